"""Columns of a user's text file, with their names and units: a spectrum or an elevation record."""

from __future__ import annotations

import hashlib
import math
import os
import re
from collections.abc import Sequence
from os import PathLike
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError, visible
from gyroctl.reading import cut_short, read_text, real

FIELD = "sea.file"
FILE_MAX = 32 << 20
"""Largest file: a day at ten samples a second. [bytes]"""

MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--")
"""Cells that hold no number, in small letters."""

_LABEL = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
_BRACKET = re.compile(r"\s*[\[(](?P<unit>(?:[^\[\]()]|\([^()]*\))*)[\])]\s*$")
_SUFFIX = re.compile(r"\s*(?:_|/|\s)\s*(?P<unit>rad/s|rad_s|mm|cm|m|ft|ms|sec|s|min|mHz|Hz|hz)$")
_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_STAMP = re.compile(r"\d{4}-\d\d-\d\d\s+\d\d:\d\d")


class Column(NamedTuple):
    """A column as it stands in a file."""

    name: str  # of the header, "" without one
    unit: str  # of the header, "" where it names none
    cells: list[str]
    lines: list[int]  # of the file, from 1
    notes: tuple[str, ...] = ()  # what is notable about the file where this column ends

    def numbers(self, path: str, mend: str, missing: bool = False) -> NDArray[np.float64]:
        """Return the cells as numbers, shape (n,); where `missing` is allowed, a cell that holds none is NaN.

        Raises
        ------
        InputError
            Field ``sea.file``: a cell that is no finite number, with its line.
        """
        values = np.empty(len(self.cells))
        for i, cell in enumerate(self.cells):
            values[i] = number = _number(cell)
            if math.isinf(number) or (math.isnan(number) and not (missing and cell.lower() in MISSING)):
                problem = f"line {self.lines[i]} is not two finite numbers: {cell[:60]!r} in {self.name or 'a column'}"
                raise InputError(FIELD, path, problem, mend)
        return values


def read_columns(
    path: str | PathLike[str], columns: str, chosen: Sequence[str | None] = (None, None)
) -> tuple[Column, Column]:
    """Read two columns.

    Separators are comma, semicolon, tab or blanks; where columns are apart by semicolons or tabs, a comma is the mark
    of decimals. Empty lines and lines that start with ``#`` are skipped. One line of names is allowed, also as the
    comment right above the numbers; a name may end with its unit: ``f [Hz]``, ``eta (mm)``, ``time_s``. Of more than
    two columns the two have to be chosen.

    Parameters
    ----------
    path : str or path
        Text file in UTF-8.
    columns : str
        What the two columns are, for the messages, e.g. ``"time [s], elevation [m]"``.
    chosen : pair of str or None
        Names of the two columns; None for the first, and the second of two.

    Returns
    -------
    tuple of Column
        At least two cells each.

    Raises
    ------
    InputError
        Field ``sea.file``: missing or unreadable file, a line with another number of cells, fewer than two lines.
        Field ``sea.column``, ``sea.clock``: no column of that name, or a choice that is missing.
    """
    mend = f"Give a text file with two columns of numbers: {columns}"
    text = read_text(FIELD, os.fspath(path), mend, FILE_MAX)
    said = ""
    header: str | None = None
    rows: list[list[str]] = []
    lines: list[int] = []
    comma = _decimal_commas(text)
    for number, line in enumerate(text.split("\n"), start=1):
        bare = line.strip()
        if not bare or bare.startswith("#"):
            said = bare.lstrip("#").strip() if bare and not rows else said
            continue
        cells = _cells(line, comma)
        if header is None and not rows and not any(_is_number(cell) for cell in cells):
            header = bare
            continue
        if rows and len(cells) != len(rows[0]):
            problem = f"line {number} has {len(cells)} cells, not {len(rows[0])}: {bare[:60]!r}"
            raise InputError(FIELD, str(path), problem, mend)
        if len(cells) < 2 or not any(_is_number(cell) for cell in cells):
            problem = f"line {number} is not two finite numbers: {bare[:60]!r}"
            raise InputError(FIELD, str(path), problem, mend + _hint(bare))
        rows.append(cells)
        lines.append(number)
    if len(rows) < 2:
        raise InputError(FIELD, str(path), f"has {len(rows)} lines of numbers, at least 2 are needed", mend)
    labels = _labels(header if header is not None else said, len(rows[0]), header is not None)
    if labels is None:
        problem = f"has {len(rows[0])} columns, and {len(_split(header or '', 0))} names of columns: {header!r}"
        raise InputError(FIELD, str(path), problem, mend)
    cut = cut_short(text, [row[-1] for row in rows])
    first, second = _choice(labels, chosen, str(path), _hint(text))
    return tuple(  # type: ignore[return-value]
        Column(*label_of(labels[i]), [row[i] for row in rows], lines, cut if i == len(rows[0]) - 1 else ())
        for i in (first, second)
    )


def label_of(text: str) -> tuple[str, str]:
    """Name and unit of a heading; the unit in brackets, or after a stroke or an underscore where it is a known one.

    Both are told again: what cannot be seen is escaped.
    """
    text = visible(" ".join(text.split()))
    for pattern in (_BRACKET, _SUFFIX):
        found = pattern.search(text)
        if found and found.start():
            return text[: found.start()], found["unit"].strip()
    return text, ""


def digest(*arrays: NDArray[np.float64]) -> str:
    """SHA-256 of the numbers themselves, the same on every machine."""
    content = hashlib.sha256()
    for array in arrays:
        content.update(str(array.shape).encode())
        content.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return content.hexdigest()


def _decimal_commas(text: str) -> bool:
    """Whether columns are apart by semicolons or tabs, and all their commas stand between digits."""
    body = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#")][:100]
    body = [line for line in body if any(_is_number(cell) for cell in _split(line.replace(",", "."), 1))]
    apart = [line for line in body if ";" in line or "\t" in line.strip()]
    marks = sum(len(re.findall(r"\d,\d", line)) for line in apart)
    return bool(body) and len(apart) == len(body) and marks > 0 and marks == sum(line.count(",") for line in apart)


def _cells(line: str, comma: bool) -> list[str]:
    if not comma:
        return _split(line, 0)
    cells = _split(line, 1)
    return ["mixed " + cell if "." in cell and "," in cell else cell.replace(",", ".") for cell in cells]


def _split(line: str, least: int) -> list[str]:
    """Cells of a line: apart by semicolons, else tabs, else commas (not from `least` 1 on), else blanks."""
    bare = line.strip(" ")
    for mark in ";\t,"[: 3 - least]:
        if mark in bare:
            return [_unquoted(cell.strip()) for cell in bare.split(mark)]
    bare = bare.strip()
    stamp = _STAMP.match(bare)
    if stamp:
        bare = re.sub(r"\s+", "T", bare[: stamp.end()], count=1) + bare[stamp.end() :]
    return bare.split()


def _unquoted(cell: str) -> str:
    """Cell without the quotes about it that spreadsheets write."""
    return cell[1:-1].strip() if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell


def _number(cell: str) -> float:
    try:
        return real(cell)
    except ValueError:
        return math.nan


def _is_number(cell: str) -> bool:
    """Whether a cell tells that its line is no heading: a number, a missing one, or a date."""
    return not math.isnan(_number(cell)) or cell.lower() in ("nan", "na") or _DATE.match(cell) is not None


def _labels(text: str, count: int, header: bool) -> list[str] | None:
    """Names of `count` columns from their line; without a header from a comment, where that has as many; else none."""
    for mark in (";", "\t", ","):
        if mark in text:
            parts = [_unquoted(part.strip()) for part in text.split(mark)]
            if len(parts) == count:
                return parts
    for parts in (_LABEL.findall(text), text.split()):
        if any(not part.strip(";,") for part in parts):  # a mark that stands alone is no name
            continue
        if len(parts) == count and (header or "[" in text or "(" in text):  # else it may be any two words
            return parts
    return None if header else [""] * count


def _choice(labels: list[str], chosen: Sequence[str | None], path: str, hint: str) -> tuple[int, int]:
    found: list[int] = []
    known = [label_of(label)[0] for label in labels]
    listed = ", ".join(name for name in known if name) or "none"
    for place, (field, name) in enumerate(zip(("sea.clock", "sea.column"), chosen, strict=True)):
        if name is None:
            if place and len(labels) > 2:
                problem = f"has {len(labels)} columns: picking one of them would be a guess"
                mend = f"Give column = one of {listed}" if listed != "none" else "Give a file with two columns"
                raise InputError(FIELD, path, problem, mend + hint)
            found.append(place)
            continue
        among = [i for i, (label, short) in enumerate(zip(labels, known, strict=True)) if name in (label, short)]
        if len(among) != 1:
            problem = "is the name of no column" if not among else "is the name of several columns"
            raise InputError(field, name, problem, f"Give the name of one column of the file: {listed}")
        found.append(among[0])
    if found[0] == found[1]:
        raise InputError("sea.column", chosen[1], "is the first column too", "Give two different columns")
    return found[0], found[1]


def _hint(text: str) -> str:
    """What to do where decimal commas cannot be told from columns."""
    if re.search(r"\d,\d+[ \t]+-?\d+,\d|\d,\d+,[ \t]*-?\d+,\d", text[:2000]):
        return ". Are commas the marks of decimals? Separate the columns by semicolons, or write points"
    return ""
