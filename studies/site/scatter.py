"""A scatter table: how often each sea state occurs at a site."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from gyroctl.errors import InputError

YEAR = 8766.0
"""Mean length of a year. [h]"""

TOLD = ("hours", "counts", "percent", "fraction")
"""How occurrence may be told: hours of a mean year, counts of records, percent, parts of one."""

FULL = {"hours": YEAR, "percent": 100.0, "fraction": 1.0}
"""Sum of a table in which no time is missing."""

ABOVE = 0.005
"""By how much a sum may be above that, from the rounding of its parts: it is brought back to the whole year. [1]"""

CALENDAR = (8760.0, 8784.0)
"""Hours of a year of the calendar: a table that sums to them, or between, misses nothing. [h]"""

ALL_THERE = 1e-9
"""Time that is not missed. [1]"""


class Bin(NamedTuple):
    """A cell of the table."""

    hs: float  # significant wave height, the middle of the bin [m]
    period: float  # the middle of the bin, of the table's kind [s]
    share: float  # part of the mean year [1]


@dataclass(frozen=True)
class Scatter:
    """Sea states of a site; those that never occur are in no bin.

    Parameters
    ----------
    bins : tuple of Bin
        In ascending order of height, then of period.
    kind : {"Tp", "Te", "T1", "Tz"}
        What the periods are.
    told : {"hours", "counts", "percent", "fraction"}
        How occurrence was told.
    total : float
        Sum of the table as it was told. [unit of the table]
    missing : float
        Part of the year that is not in the table. [1]
    layout : str
        How the table was laid out, in words.
    notes : tuple of str
        What was taken for granted or mended while it was read, and lines of the file that say where it is from.
    """

    bins: tuple[Bin, ...]
    kind: str
    told: str = "fraction"
    total: float = 1.0
    missing: float = 0.0
    layout: str = "list"
    notes: tuple[str, ...] = ()

    @property
    def heights(self) -> tuple[float, ...]:
        """Heights that occur. [m]"""
        return tuple(sorted({one.hs for one in self.bins}))

    @property
    def periods(self) -> tuple[float, ...]:
        """Periods that occur. [s]"""
        return tuple(sorted({one.period for one in self.bins}))


def shares(values: list[float], told: str, field: str) -> tuple[list[float], float, list[str]]:
    """Parts of a year of occurrences as they were told, the part that is missing, and what is to be said of it.

    Raises
    ------
    InputError
        Field `field`: no occurrence at all, or a sum that cannot be that of a year.
    """
    total = sum(values)
    if not total > 0.0:
        raise InputError(field, total, "no sea state occurs", "Give occurrences above zero")
    if told == "counts":
        return [value / total for value in values], 0.0, []
    full = FULL[told]
    part = total / full
    if part > 1.0 + ABOVE:
        others = {"hours": "counts", "percent": "counts or hours", "fraction": "percent, counts or hours"}[told]
        problem = f"sum of the table, of {full:g} that a year has in {told}"
        raise InputError(
            field, round(total, 6), problem, f"Correct the table, or say with --occurrence if it is {others}"
        )
    if told == "percent" and part <= 0.02:
        mend = "Say --occurrence fraction if these are parts of one, or correct the table"
        raise InputError(field, round(total, 6), "sum of the table, in percent of a year", mend)
    of_calendar = told == "hours" and CALENDAR[0] - 0.5 <= total <= CALENDAR[1] + 0.5
    if part > 1.0 + ALL_THERE or (of_calendar and part < 1.0 - 1e-6):
        said = f"the table sums to {total:.6g} of {full:g} {told}: brought back to the whole year"
        return [value / total for value in values], 0.0, [said]
    missing = max(0.0, 1.0 - part)
    if missing <= 1e-6:
        return [value / total for value in values], 0.0, []
    said = (
        f"the table sums to {total:.6g} of {full:g} {told}: the other {100.0 * missing:.3g} % of the year give nothing"
    )
    return [value / full for value in values], missing, [said]
