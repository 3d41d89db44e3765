"""The files in which tuned parameters ship beside their law: ``tuned/LAW.json``, sets with how they were found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.names import file_in
from gyroctl.writing import write_json


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
    if not path.is_file():
        return {}
    try:
        sets = json.loads(path.read_text(encoding="utf-8"))["sets"]
        return {str(name): dict(entry) for name, entry in sets.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(
            "tuned", str(path), f"cannot be read: {type(error).__name__}: {error}", "Write it anew with gyroctl tune"
        ) from None


def write_sets(path: Path, law: str, sets: Mapping[str, Any]) -> None:
    """Write sets into a file beside those that it has, whole or not at all."""
    merged = {**read_sets(path), **sets}
    write_json(path, {"law": law, "sets": {name: merged[name] for name in sorted(merged)}})


def seeds_of(sets: Mapping[str, Any]) -> set[int]:
    """Seeds on which any of the sets was tuned."""
    seeds: set[int] = set()
    for entry in sets.values():
        span = entry["found"]["seeds"]
        seeds |= set(range(span["first"], span["last"] + 1))
    return seeds
