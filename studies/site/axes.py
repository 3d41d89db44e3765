"""The axis of a scatter table: the middle of each bin, from headings that are middles, edges or ranges."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from gyroctl.errors import InputError
from gyroctl.studies.site.headings import interval, number

BINS = ("centres", "lower", "upper")
"""What a heading of one number is of its bin."""

MOST = {"Hs": (30.0, "m")}
PERIOD_MOST = (40.0, "s")
"""Height and period beyond which another unit is meant."""


def axis(
    headings: Sequence[tuple[str, str]], bins: str, comma: bool, kind: str, each: bool = True
) -> tuple[list[float], str]:
    """Middles of the bins, and a note on how they were told.

    Parameters
    ----------
    headings : sequence of (where, text)
        Where each stands, and what it says.
    bins : str
        What a heading of one number is, "" where nothing was said.
    comma : bool
        Whether decimals are commas.
    kind : str
        "Hs" or a kind of period.
    each : bool
        Whether every heading is a bin of its own, so that none may repeat or overlap another one.

    Raises
    ------
    InputError
        Field ``scatter`` with the place: what is no number, or out of bounds; a bin that repeats; overlapping ranges.
    """
    ends = [interval(text, comma) for _, text in headings]
    told = [one for one in ends if one is not None]
    if told and len(told) < len(ends):
        where, text = headings[ends.index(None)]
        raise InputError(f"scatter, {where}", text, "is no range, and other headings are", "Write all of them alike")
    if told:
        for (where, text), (low, high) in zip(headings, told, strict=True):
            if not 0.0 <= low < high:
                raise InputError(f"scatter, {where}", text, "is no range", "Write the lower end first, 0.5-1.0")
        middles = [0.5 * (low + high) for low, high in told]
        note = f"{kind}: middles of the ranges"
    else:
        values = [_number(where, text, comma, kind) for where, text in headings]
        middles, note = _middles(headings, values, bins, kind), ""
    most, unit = MOST.get(kind, PERIOD_MOST)
    for (where, text), middle in zip(headings, middles, strict=True):
        if not 0.0 <= middle <= most:
            mend = f"Give {kind} in {unit}, from 0 to {most:g}"
            raise InputError(f"scatter, {where}", text, f"is out of bounds for {kind}", mend)
    if each:
        _check_apart(headings, middles, told)
    return middles, note


def _number(where: str, text: str, comma: bool, kind: str) -> float:
    try:
        return number(text, comma)
    except ValueError:
        mend = "Write the middle of the bin, or its range: 0.75, or 0.5-1.0"
        raise InputError(f"scatter, {where}", text, f"is no number of {kind}", mend) from None


def _middles(headings: Sequence[tuple[str, str]], values: list[float], bins: str, kind: str) -> list[float]:
    """Middles of bins that are told by a number each."""
    if bins in ("", "centres"):
        return values
    edges = sorted(set(values))
    if len(edges) < 2:
        where, text = headings[0]
        raise InputError(f"scatter, {where}", text, f"the one edge of {kind} tells no width", "Write ranges, 0.5-1.0")
    if bins == "lower":  # the last bin is as wide as the one before
        ends = {low: high for low, high in zip(edges, [*edges[1:], 2.0 * edges[-1] - edges[-2]], strict=True)}
    else:
        first = max(0.0, 2.0 * edges[0] - edges[1])
        ends = {high: low for high, low in zip(edges, [first, *edges[:-1]], strict=True)}
    return [0.5 * (value + ends[value]) for value in values]


def _check_apart(
    headings: Sequence[tuple[str, str]], middles: list[float], ranges: Sequence[tuple[float, float]]
) -> None:
    """Refuse bins that repeat or overlap."""
    order = sorted(range(len(middles)), key=lambda at: middles[at])
    for one, other in pairwise(order):
        same = middles[one] == middles[other]
        over = bool(ranges) and ranges[other][0] < ranges[one][1] - 1e-9
        if same or over:
            where, text = headings[other]
            problem = f"{'repeats' if same else 'overlaps'} the bin {headings[one][1]}"
            raise InputError(f"scatter, {where}", text, problem, "Give each bin once")
