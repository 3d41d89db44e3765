"""Numbers as Fortran programs write them: `1D+02`, `1.2-101` without its letter, stars where a field was too narrow."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple

from gyroctl.errors import InputError
from gyroctl.reading import read_text

MEND = "Check the path of the results"

RESULTS_MAX = 16 << 20
"""Largest file of results: a hundred thousand rows. [bytes]"""

_MANTISSA = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_PLAIN = re.compile(rf"({_MANTISSA})(?:[eEdDqQ]([+-]?\d{{1,4}}))?", re.ASCII)
_BARE = re.compile(rf"({_MANTISSA})([+-]\d{{3}})", re.ASCII)
_NONE = re.compile(r"\*+|[+-]?(?:nan(?:\(\w*\))?|inf(?:inity)?)", re.IGNORECASE)


class Row(NamedTuple):
    """A line of numbers: nan where a value stands that is none."""

    line: int
    values: list[float]


def number(text: str) -> float | None:
    """Return the number that a Fortran program wrote.

    Parameters
    ----------
    text : str
        A word: with an exponent after E, D or Q, or after its sign alone where it has three digits.

    Returns
    -------
    float or None
        nan for stars, NaN, infinity and what overflows; None for a word that is no value at all.
    """
    found = _PLAIN.fullmatch(text) or _BARE.fullmatch(text)
    if found:
        value = float(f"{found.group(1)}e{found.group(2) or 0}")
        return value if math.isfinite(value) else math.nan
    return math.nan if _NONE.fullmatch(text) else None


def numbers(line: str) -> list[float] | None:
    """Return the numbers of a line, nan where a value is none; None where a word is no value, or there is no word."""
    values = [number(word) for word in line.split()]
    return None if not values or None in values else [value for value in values if value is not None]


def lines_of(path: Path) -> list[str]:
    """Lines of a file of results, whose headings may be in the letters of another program."""
    return read_text("path", path, MEND, RESULTS_MAX, errors="replace").split("\n")


def rows_of(path: Path, lengths: tuple[int, ...], mend: str) -> list[Row]:
    """Rows of numbers of one of the given lengths; lines of words before the first of them are headings.

    Raises
    ------
    InputError
        Names file and line of what is no such row.
    """
    rows: list[Row] = []
    wanted = " or ".join(map(str, lengths))
    for count, line in enumerate(lines_of(path), 1):
        values = numbers(line)
        if values is not None and len(values) in lengths:
            rows.append(Row(count, values))
        elif line.strip() and (rows or (values is None and number(line.split()[0]) is not None)):
            problem = f"is not a row of {wanted} numbers"
            raise InputError(f"{path.name}, line {count}", line.strip()[:60], problem, mend)
    if not rows:
        raise InputError("path", str(path), f"has no row of {wanted} numbers", mend)
    return rows
