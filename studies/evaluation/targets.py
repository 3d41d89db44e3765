"""What the laws are to reach in the three seas, as data, and whether they do."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from gyroctl.reports.layout import MOTION_LIMIT
from gyroctl.reports.verdict import too_few
from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.entrants import ALL, Kind
from gyroctl.studies.evaluation.rows import Row

MOTION = MOTION_LIMIT
"""Largest 98 % motion of phi1 and phi3, in the mean over the realisations and in each but a few of them. [rad]"""

LOCKED = 0.99
"""Least part of the realisations that hold lock, and of those that stay within the limit of motion. [1]"""

SHARE = 0.85
"""Part of a bar that one set of parameters for all seas is to reach. [1]"""


@dataclass(frozen=True)
class Bar:
    """A demand on some law of a kind."""

    name: str  # in words
    gamma: float  # sea
    kind: Kind
    information: str  # what the law may see at most
    power: float = 0.0  # least mean power [W]
    ratio: float = 0.0  # least mean power over that of the best constant pair of the sea [1]
    cv: float = math.inf  # largest power CV [1]
    one_set: bool = False  # only with the one set of parameters for all seas

    def concerns(self, row: Row) -> bool:
        """Whether the row may answer the bar."""
        return row.kind == self.kind and row.information == self.information and (row.tuning == ALL or not self.one_set)

    def missed(self, row: Row) -> list[str]:
        """What the row misses; empty where it meets the bar. The numbers are those of the table, without a margin."""
        missing = []
        if not row.power.value >= self.power:
            missing.append(f"power {number(row.power.value)} < {number(self.power)} W")
        if self.ratio and not row.ratio.value >= self.ratio:
            missing.append(f"ratio {number(row.ratio.value)} < {number(self.ratio)}")
        if not row.cv.value <= self.cv:
            missing.append(f"CV {number(row.cv.value, 2)} > {number(self.cv, 2)}")
        return missing + limits_missed(row)

    def shortfall(self, row: Row) -> float:
        """How far the row is from the bar, in parts of it; 0 where it is met."""
        gaps = [
            1.0 - row.power.value / self.power if self.power else 0.0,
            1.0 - row.ratio.value / self.ratio if self.ratio else 0.0,
            row.cv.value / self.cv - 1.0,
            row.motion / MOTION - 1.0,
            (LOCKED - row.locked / row.runs) / LOCKED,
            (LOCKED - 1.0 + row.over_limit / row.runs) / LOCKED,
            1.0 - row.in_step / row.pair_in_step if row.pair_in_step else 0.0,
        ]
        return sum(max(0.0, gap) if math.isfinite(gap) else 1.0 for gap in gaps)


class Verdict(NamedTuple):
    """Answer to a bar: the law that meets it or comes nearest, and what that one misses."""

    bar: Bar
    law: str
    missed: tuple[str, ...]

    @property
    def met(self) -> bool:
        """Whether some law meets the bar."""
        return bool(self.law) and not self.missed


def limits_missed(row: Row) -> list[str]:
    """Which of the limits that hold for every law the row misses."""
    return list(missed_by_limit(row).values())


def limits_in_words(row: Row) -> str:
    """Say whether the row keeps those limits."""
    missing = limits_missed(row)
    return f"not kept: {', '.join(missing)}" if missing else "kept"


def missed_by_limit(row: Row) -> dict[str, str]:
    """What the row misses by the limit: motion, lock, step, or power, which every run must have as a number.

    In step is measured by the best constant pair, which misses its own limit of slips now and then: a row misses it
    where it is in step in fewer runs than chance explains.
    """
    missing = {}
    if not row.motion <= MOTION:
        missing["motion"] = f"motion {number(row.motion, 3)} > {MOTION:g} rad"
    elif row.over_limit > (1.0 - LOCKED) * row.runs:
        missing["motion"] = f"motion > {MOTION:g} rad in {row.over_limit}/{row.runs}"
    if not row.locked >= LOCKED * row.runs:
        missing["lock"] = f"locked {row.locked}/{row.runs}"
    if too_few(row.in_step, row.pair_in_step, row.runs):
        missing["step"] = f"in step {row.in_step}/{row.runs} (constant {row.pair_in_step})"
    if "not finite" in row.power.note:
        missing["power"] = f"power: {row.power.note}"
    return missing


def _bars() -> tuple[Bar, ...]:
    bars = [
        Bar("simple, most power", 5.0, "simple", "sensors", power=5.5),
        Bar("simple, smooth", 5.0, "simple", "sensors", power=4.5, cv=0.35),
        Bar("planning from sensors", 5.0, "planning", "sensors", power=10.0, cv=0.25),
        Bar("planning with preview", 5.0, "planning", "oracle", power=13.0, cv=0.20),
    ]
    for gamma in (1.0, 50.0):
        bars.append(Bar("simple, against constant", gamma, "simple", "sensors", ratio=1.8))
        bars.append(Bar("planning from sensors, against constant", gamma, "planning", "sensors", ratio=3.0, cv=0.25))
    one_set = [
        replace(bar, name=f"{bar.name}, one set", power=SHARE * bar.power, ratio=SHARE * bar.ratio, one_set=True)
        for bar in bars
        if bar.information == "sensors"
    ]
    return (*bars, *one_set)


BARS = _bars()
"""The same limits of motion and lock hold in all of them."""


def bars_for(gamma: float, row: Row) -> list[Bar]:
    """Bars of a sea that the row may answer."""
    return [bar for bar in BARS if bar.gamma == gamma and bar.concerns(row)]


def nearest_missed(bars: Sequence[Bar], row: Row) -> tuple[Bar, str]:
    """Of some bars the one that the row comes nearest to, and in words what it misses of that."""
    nearest = min(bars, key=lambda bar: bar.shortfall(row))
    return nearest, ", ".join(nearest.missed(row))


def answer(bar: Bar, table: Sequence[Row]) -> Verdict:
    """Verdict on a bar from the rows of its sea: the strongest law that meets it, or the one that comes nearest."""
    concerned = [row for row in table if bar.concerns(row)]
    if not concerned:
        return Verdict(bar, "", ("no such law takes part",))
    meeting = [row for row in concerned if not bar.missed(row)]
    best = max(meeting, key=lambda row: row.power.value) if meeting else min(concerned, key=bar.shortfall)
    return Verdict(bar, best.law, tuple(bar.missed(best)))


def answers(tables: Mapping[float, Sequence[Row]]) -> list[Verdict]:
    """Verdicts on the bars of all seas that were run."""
    return [answer(bar, tables[bar.gamma]) for bar in BARS if bar.gamma in tables]


def one_set_laws(tables: Mapping[float, Sequence[Row]]) -> dict[str, list[str]]:
    """For each law with one set of parameters for all seas: what it misses anywhere, and so whether it serves them all.

    A law serves a sea when it meets one of the bars of its kind there.
    """
    found: dict[str, list[str]] = {}
    for gamma, table in tables.items():
        for row in table:
            bars = [bar for bar in bars_for(gamma, row) if bar.one_set]
            missing = found.setdefault(row.law, []) if bars else []
            if bars and all(bar.missed(row) for bar in bars):
                missing.append(f"gamma {gamma:g}: {nearest_missed(bars, row)[1]}")
    return found
