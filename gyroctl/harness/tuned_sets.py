"""The files in which tuned parameters ship beside their law: ``tuned/LAW.json``, sets with how they were found."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.names import file_in
from gyroctl.reading import is_finite, read_json
from gyroctl.writing import write_json

MEND = "Write it anew with gyroctl tune"

SEEDS_MAX = 100_000
"""Most seeds of a tuning."""


def tuned_file(folder: Path, stem: str) -> Path:
    """Path of the tuned sets of the law `stem` whose code is in `folder`."""
    return file_in(folder / "tuned", stem, ending=".json")


def task_file(folder: Path, stem: str) -> Path:
    """Path of the task by which the law `stem`, whose code is in `folder`, is tuned."""
    return file_in(folder / "tuning", stem, ending=".toml")


def read_sets(path: Path) -> dict[str, Any]:
    """Sets of a file by name, each with ``parameters``, ``goal``, ``result`` and ``found``; empty without a file.

    Raises
    ------
    InputError
        For a file that cannot be read.
    """
    if not path.exists():
        return {}
    content = read_json("tuned", path, MEND)
    sets = content.get("sets") if isinstance(content, Mapping) else None
    if not isinstance(sets, Mapping):
        raise InputError("tuned", str(path), 'cannot be read: it has no table "sets"', MEND)
    return {name: _checked(f"sets.{name}", entry) for name, entry in sets.items()}


def _checked(field: str, entry: Any) -> dict[str, Any]:
    """Return a set whose numbers are some."""
    if not isinstance(entry, Mapping) or not isinstance(entry.get("parameters"), Mapping):
        raise InputError(field, entry, 'must be a table with "parameters"', MEND)
    for name, value in entry["parameters"].items():
        if not isinstance(value, str | bool) and not is_finite(value):
            raise InputError(f"{field}.parameters.{name}", value, "must be a number or a name", MEND)
    for part in ("goal", "met", "result", "found"):
        if not isinstance(entry.get(part, {}), Mapping):
            raise InputError(f"{field}.{part}", entry[part], "must be a table", MEND)
    found = entry.get("found", {})
    for name in ("budget_s", "spent_s", "spent_before_s"):
        if name in found and not (is_finite(found[name]) and found[name] >= 0.0):
            raise InputError(f"{field}.found.{name}", found[name], "must be a time of zero or more", MEND)
    if "seeds" in found:
        _span(f"{field}.found.seeds", found["seeds"])
    return dict(entry)


def _span(field: str, given: Any) -> range:
    """Seeds from ``first`` to ``last``; of a slip in either the seeds alone would fill the memory."""
    ends: list[Any] = [given.get(name) for name in ("first", "last")] if isinstance(given, Mapping) else []
    if not ends or not all(type(end) is int for end in ends) or not 0 <= ends[0] <= ends[1]:
        raise InputError(field, given, "must be whole numbers, first and last, in this order", MEND)
    if ends[1] - ends[0] >= SEEDS_MAX:
        raise InputError(field, given, f"are more than {SEEDS_MAX} seeds", MEND)
    return range(ends[0], ends[1] + 1)


def write_sets(path: Path, law: str, sets: Mapping[str, Any]) -> None:
    """Write sets into a file beside those that it has, whole or not at all."""
    merged = {**read_sets(path), **sets}
    write_json(path, {"law": law, "sets": {name: merged[name] for name in sorted(merged)}})


def seeds_of(sets: Mapping[str, Any]) -> set[int]:
    """Seeds on which any of the sets was tuned.

    Raises
    ------
    InputError
        For a set that does not tell them: whether it may be judged would be a guess.
    """
    seeds: set[int] = set()
    for name, entry in sets.items():
        seeds |= set(_span(f"sets.{name}.found.seeds", entry.get("found", {}).get("seeds")))
    return seeds
