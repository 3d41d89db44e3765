"""The committed results, how they were made in words, and the tables of a law's figures that every page shares."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from gyroctl.reports.wording import number, percent, seed_ranges, sees, watts

ROOT = Path(__file__).resolve().parents[2]
HERE = "RESULTS/"
"""Stands for the way from the page to docs/results in a link."""

STATES = {"reserve": "in reserve until this run", "unlisted": "in no entry of the ledger"}
"""States of seeds as a page says them, where that is not the word of the ledger."""

Row = Mapping[str, Any]


class Missing(LookupError):
    """A result that is not kept yet: its name is the argument."""


@lru_cache(maxsize=64)
def read(path: str) -> Any:
    """A JSON file by its path from the root of the checkout."""
    return json.loads((ROOT / path).read_text(encoding="utf-8"))


def result(name: str) -> Any:
    """A committed result by its name.

    Raises
    ------
    Missing
        Where there is none.
    """
    path = f"docs/results/{name}.json"
    if not (ROOT / path).is_file():
        raise Missing(name)
    return read(path)


def caption(*names: str) -> str:
    """Say which results a block shows, and by which command, at which commit and when each was made."""
    told = []
    for name in names:
        found = result(name)
        command = re.sub(r" --out \S+", "", found["command"])
        at = f"{found['gyroctl_version']} at {found['commit'][:7]}" if found.get("commit") else found["gyroctl_version"]
        changed = ", with changes" if "changed" in found.get("commit", "") else ""
        told.append(f"[{name}.json]({HERE}{name}.json): `{command}`, version {at}{changed}, {found['date']}")
    return f"*{'; '.join(told)}.*"


def of_file(path: str, command: str, remark: str = "") -> str:
    """Caption of a block from another committed file, by the command that writes it."""
    found = read(path)
    when = f"version {found['gyroctl_version']} at {found['commit'][:7]}, {found['date']}" if "date" in found else ""
    return f"*{'; '.join(part for part in (f'`{path}`: `{command}`', when, remark) if part)}.*"


def states(found: Mapping[str, Sequence[int]]) -> str:
    """Seeds by their state: ``1 to 8 spent``."""
    return "; ".join(f"{seed_ranges(tuple(seeds))} {STATES.get(state, state)}" for state, seeds in found.items())


def failures(found: Mapping[str, Any]) -> str:
    """What was not run, in a sentence."""
    failed = found.get("failed") or {}
    return (
        "Nothing failed." if not failed else "Not run: " + "; ".join(f"{what} ({why})" for what, why in failed.items())
    )


def table(headings: Sequence[str], lines: Iterable[Sequence[str]], text: int = 1) -> str:
    """Markdown; columns after the first `text` are aligned to the right."""
    marks = ["---" if i < text else "---:" for i in range(len(headings))]
    return "\n".join("| " + " | ".join(line) + " |" for line in (headings, marks, *lines))


def ranged(estimate: Mapping[str, Any] | None, digits: int = 3) -> str:
    """A number with its interval in brackets."""
    if estimate is None:
        return ""
    low, high = estimate["low"], estimate["high"]
    inside = f" ({number(low, digits)} to {number(high, digits)})" if low is not None and high is not None else ""
    return f"{number(estimate['value'], digits)}{inside}"


def pair(first: float | None, second: float | None, digits: int = 2) -> str:
    """Two numbers."""
    return f"{number(first, digits)}, {number(second, digits)}"


def held(row: Row) -> str:
    """Runs that held lock and runs in step with the waves, of all: ``64, 63 of 64``."""
    return f"{row['locked']}, {row['in_step']} of {row['runs']}"


def whole(row: Row) -> bool:
    """Whether every run held lock in step with the waves."""
    return bool(row["locked"] == row["in_step"] == row["runs"])


def parts(row: Row) -> str:
    """Generated and stored part of the judged power."""
    return f"{number(row['generated_w'])}, {watts(row['stored_w'])}"


def outside(row: Row) -> str:
    """Share of the time in which the float is beyond what its model is made for."""
    return percent(100.0 * row["outside_share"])


def largest(row: Row) -> float:
    """Largest motion of either rotation in any run. [rad]"""
    return float(max(row["phi1_max"], row["phi3_max"]))


def realisations(row: Row) -> str:
    """Seeds of a row and their state."""
    found = row["seed_states"]
    if len(found) == 1:
        state = next(iter(found))
        return f"{row['seeds']}: {STATES.get(state, state)}"
    return f"{row['seeds']}: " + ", ".join(f"{count} {STATES.get(state, state)}" for state, count in found.items())


def seen(row: Row) -> str:
    """What a law sees; a preview that is not kept as a number is one of all the waves, or none."""
    return sees(row["information"], math.inf if row["preview"] is None else row["preview"])


def law(row: Row) -> str:
    """Name of a law."""
    name, space, remark = row["law"].partition(" ")
    return f"`{name}`{space}{remark}"


FULL = (
    *(
        "power [W]",
        "generated, stored [W]",
        "of the pair",
        "CV",
        "locked, in step",
        "turns kept",
        "slips per 1000 waves",
    ),
    *("98 % of φ1, φ3 [rad]", "largest φ1, φ3 [rad]", "beyond 0.3 rad", "failed", "seeds"),
)
"""Headings of `full`."""


def full(row: Row) -> list[str]:
    """All that is demanded of a row: judged power with its parts, lock and step, motion, failures, realisations."""
    return [
        ranged(row["power"]),
        parts(row),
        ranged(row["ratio"]),
        number(row["cv"]["value"], 2),
        held(row),
        number(row["turns_kept"]),
        number(row["cycle_slips"], 2),
        pair(row["phi1_p98"], row["phi3_p98"]),
        pair(row["phi1_max"], row["phi3_max"]),
        outside(row),
        str(row["failed"]),
        realisations(row),
    ]


def law_table(rows: Iterable[Row]) -> str:
    """Rows of laws in full."""
    lines = [[law(row), seen(row), *full(row)] for row in rows]
    return table(("law", "sees", *FULL), lines, 2)
