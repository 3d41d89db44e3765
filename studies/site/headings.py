"""Headings of a scatter table: which quantity, in which unit, and the range of a bin."""

from __future__ import annotations

import re
from typing import NamedTuple

from gyroctl.reading import real

HEIGHTS = ("hs", "hm0", "h1/3", "h13", "hsig", "swh", "significant wave height", "wave height")

PERIOD_NAMES = {
    "Tp": ("tp", "peak period", "peak wave period"),
    "Te": ("te", "tm-10", "tm-1,0", "t-10", "tm10", "tm-1 0", "energy period", "wave energy period"),
    "Tz": ("tz", "t02", "tm02", "zero-crossing period", "zero crossing period", "mean zero-crossing period"),
    "T1": ("t1", "t01", "tm01", "tm", "mean period", "mean wave period"),
}

OCCURRENCES = {
    "hours": ("hours", "hours per year", "hours a year", "h", "h/a", "h/year", "h/yr"),
    "counts": ("counts", "count", "n", "number", "observations", "records", "samples"),
    "percent": ("percent", "%", "pct"),
    "fraction": ("fraction", "share", "probability", "-", "1"),
}
"""How occurrence is told, by what it may be called; a word that says no unit, "occurrence", is none of these."""

PLAIN = ("occurrence", "occurence", "frequency", "prob")
"""Words for occurrence that need a unit beside them."""

TOTALS = ("total", "totals", "sum", "all", "σ", "∑")
"""Heading of a row or column of sums."""

UNITS = {"m", "s", "h", "%"}

UNIT = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*$")

RANGE = re.compile(r"^\s*(?P<low>[\d.,]+)\s*(?:-|–|—|\.\.|to|:)\s*(?P<high>[\d.,]+)\s*$")

PARTS = re.compile(r"\s*[\\|×]\s*|\s*,\s+|\s+/\s+|/(?=[TtHh])|(?<=[\])])\s*/\s*|\s+x\s+|\s+by\s+")
"""What stands between the names of rows and columns in the corner of a matrix."""


class Heading(NamedTuple):
    """What a heading says."""

    kind: str  # "Hs", "Tp", "Te", "T1", "Tz", "occurrence", or "" for none of these
    unit: str  # as written, or ""; of occurrence how it is told: "hours", "counts", "percent", "fraction"


def heading(text: str) -> Heading:
    """Quantity and unit of a heading: ``Hs [m]``, ``tp_s``, ``Tz``, ``occurrence [%]``, ``hours``."""
    found = UNIT.match(text)
    name, unit = (found["name"], found["unit"].strip()) if found else (text, "")
    name = " ".join(name.strip().lower().split())
    if not found and "_" in name:
        before, _, last = name.rpartition("_")
        if last in ("m", "s", "h", "percent", "pct", "cm", "ft", "mm", "min", "ms", "hz"):
            name, unit = before, last
        name = name.replace("_", " ") if name.replace("_", " ") in _known() else name.replace("_", "")
    if name in HEIGHTS:
        return Heading("Hs", unit)
    for kind, names in PERIOD_NAMES.items():
        if name in names:
            return Heading(kind, unit)
    told = occurrence(name)
    if told:
        return Heading("occurrence", told)
    if name in PLAIN or (not name and unit):
        return Heading("occurrence", occurrence(unit.lower()))
    return Heading("", unit)


def occurrence(text: str) -> str:
    """How occurrence is told, by a word or a unit; empty where it is none."""
    word = text.strip().lower()
    return next((told for told, names in OCCURRENCES.items() if word in names), "")


def corner(text: str) -> list[Heading]:
    """What the corner of a matrix says of rows, columns and, where it stands there, of occurrence."""
    return [heading(part) for part in PARTS.split(text) if part.strip()]


def number(text: str, comma: bool = False) -> float:
    """Return a number as it stands in a cell; with `comma` a decimal comma.

    Raises
    ------
    ValueError
        For what is no number.
    """
    return real(text.strip().replace(",", ".") if comma else text.strip())


def interval(text: str, comma: bool = False) -> tuple[float, float] | None:
    """Ends of a bin that is told as a range, ``0.5-1.0``; None for what is no range."""
    found = RANGE.match(text)
    if found is None:
        return None
    try:
        return number(found["low"], comma), number(found["high"], comma)
    except ValueError:
        return None


def is_total(text: str) -> bool:
    """Whether a heading is that of sums."""
    return text.strip().lower().rstrip(":") in TOTALS


def _known() -> set[str]:
    return {*HEIGHTS, *PLAIN, *(name for names in (*PERIOD_NAMES.values(), *OCCURRENCES.values()) for name in names)}
