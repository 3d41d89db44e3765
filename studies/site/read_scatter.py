"""Scatter tables from CSV: a matrix of heights and periods, or a list of sea states.

A file says itself what it holds: in its headings, in lines ``# period: Tz``, ``# occurrence: counts``, ``# bins:
lower``, or it is said beside it. What two of them say differently, and what none says, is refused: nothing is guessed.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.names import text_of
from gyroctl.reading import cut_short, read_text
from gyroctl.studies.site.axes import BINS, axis
from gyroctl.studies.site.headings import Heading, corner, heading, is_total, number
from gyroctl.studies.site.headings import occurrence as way_of_telling
from gyroctl.studies.site.periods import PERIODS
from gyroctl.studies.site.scatter import TOLD, Bin, Scatter, shares

FIELD = "scatter"
MEND = 'Give a CSV of heights by periods, or of lines hs, tp, occurrence; see the page "A year at a site"'
LARGEST = 4 << 20
"""Largest file. [bytes]"""

BINS_MAX, WIDE = 5000, 500
"""Most sea states, and cells of a line."""

SEPARATOR = re.compile(r'"?sep=([,;\t])"?[,;\t]*', re.IGNORECASE)
"""A line that says the sign between cells; where a spreadsheet saved it again with quotes, or empty cells behind."""

NOTE = 2000
"""Characters of a line that says where a table is from."""

LAYOUTS = ("matrix", "matrix-by-period", "list")
"""Rows of heights, rows of periods, one sea state a row."""


class Line(NamedTuple):
    """A line of the table."""

    number: int  # in the file
    cells: list[str]


class Said(NamedTuple):
    """What is said beside the file."""

    period: str
    occurrence: str
    bins: str
    layout: str


def read_scatter(
    path: str | PathLike[str], period: str = "", occurrence: str = "", bins: str = "", layout: str = ""
) -> Scatter:
    """Read a scatter table.

    Parameters
    ----------
    path : str or path
        CSV in UTF-8, with or without a mark of byte order; comma, semicolon or tab between the cells, a decimal comma
        only where it is not the separator. Lines that begin with ``#`` may say ``period``, ``occurrence``, ``bins``,
        and whatever else is kept as a note.
    period : {"Tp", "Te", "T1", "Tz"}, optional
        What the periods are, where the file does not say.
    occurrence : {"hours", "counts", "percent", "fraction"}, optional
        How occurrence is told, where the file does not say: hours of a mean year of 8766 h.
    bins : {"centres", "lower", "upper"}, optional
        What a heading of one number is of its bin; the middle where nothing is said. A range, 0.5-1.0, says it itself.
    layout : {"matrix", "matrix-by-period", "list"}, optional
        Where the file does not say: a matrix with heights down the rows, one with periods down the rows, or a list.

    Returns
    -------
    Scatter

    Raises
    ------
    InputError
        Field ``scatter``, with line and column: no table, an unknown unit, a number that is negative, not finite or
        missing, a bin that repeats, sums that do not fit; fields ``period``, ``occurrence``, ``bins``, ``layout`` for
        what is not said, or said twice in different ways.
    """
    _choice("period", period, PERIODS)
    _choice("occurrence", occurrence, TOLD)
    _choice("bins", bins, BINS)
    _choice("layout", layout, LAYOUTS)
    lines, directives, comma, notes = _lines(Path(path))
    said = Said(
        _one("period", period, _period_of(directives.get("period", ""))),
        _one("occurrence", occurrence, _occurrence_of(directives.get("occurrence", ""))),
        _one("bins", bins, _bins_of(directives.get("bins", ""))),
        layout,
    )
    notes += [f"{key}: {text}" for key, text in directives.items() if key not in ("period", "occurrence", "bins")]
    head = [heading(cell) for cell in lines[0].cells]
    kinds = {one.kind for one in head}
    is_list = layout == "list" or (not layout and "Hs" in kinds and bool(kinds & set(PERIODS)))
    return _list(lines, head, said, comma, notes) if is_list else _matrix(lines, said, comma, notes)


def _lines(path: Path) -> tuple[list[Line], dict[str, str], bool, list[str]]:
    """Lines of cells, what lines of ``#`` say, whether decimals are commas, and notes."""
    text = read_text(FIELD, path, MEND, LARGEST)
    table, directives = [], dict[str, str]()
    for count, line in enumerate(text.split("\n"), 1):
        if line.lstrip().startswith("#"):
            key, colon, value = line.lstrip("# \t").partition(":")
            if colon and value.strip():
                directives[key.strip().lower()[:40]] = text_of(f"{FIELD}, line {count}", value.strip(), NOTE)
        elif line.strip(" \t,;"):
            table.append((count, line))
    if len(table) < 2 + (bool(table) and bool(SEPARATOR.fullmatch(table[0][1].strip()))):
        raise InputError(FIELD, str(path), f"has {len(table)} lines of a table", MEND)
    told = SEPARATOR.fullmatch(table[0][1].strip())  # a line that spreadsheets write and read
    if told:
        first, table = table[0][0], table[1:]
        if not any(told[1] in row for _, row in table):
            problem = f"line {first} says that cells are apart by it, and no line of the table has one"
            raise InputError(FIELD, told[1], problem, "Leave this line out, or name the sign that is there")
    sign = told[1] if told else next((sign for sign in "\t;" if sign in table[0][1]), ",")
    try:
        rows = [Line(count, _cells(line, sign)) for count, line in table]
    except csv.Error as error:
        raise InputError(FIELD, str(path), f"is no CSV: {error}", MEND) from None
    width = max(len(line.cells) for line in rows)
    while width and not any("".join(line.cells[width - 1 : width]).strip() for line in rows):
        width -= 1  # spreadsheets write columns that are empty
    rows = [Line(line.number, line.cells[:width]) for line in rows]
    if width > WIDE:
        raise InputError(FIELD, width, f"has more than {WIDE} columns", MEND)
    numbers = [cell for line in rows for cell in line.cells]
    commas = sign != "," and any("," in cell and cell.replace(",", "").strip().isdigit() for cell in numbers)
    if commas and any("." in cell and cell.replace(".", "").strip().isdigit() for cell in numbers):
        raise InputError(FIELD, str(path), "has decimal commas and decimal points", "Write decimal points alone")
    notes = ["decimal commas were read as such"] if commas else []
    notes += cut_short(text, [line.cells[-1] for line in rows if line.cells])
    return rows, directives, commas, notes


def _cells(line: str, sign: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=sign, strict=True))]


def _matrix(lines: Sequence[Line], said: Said, comma: bool, notes: list[str]) -> Scatter:
    """Read a matrix: the corner and the headings of the columns, then a heading and occurrences a row."""
    top, body = lines[0], list(lines[1:])
    named = corner(top.cells[0]) if top.cells[0] else []
    axes = [one for one in named if one.kind not in ("", "occurrence")]
    by_period = said.layout == "matrix-by-period"
    if len(axes) == 2 and {"Hs"} < {one.kind for one in axes}:
        by_period = axes[0].kind != "Hs"
        if said.layout and (said.layout == "matrix-by-period") != by_period:
            raise InputError("layout", said.layout, f"the corner {top.cells[0]!r} says otherwise", "Leave it out")
    elif not said.layout:
        mend = 'Name both in the corner, "Hs [m] \\ Tp [s]", or say --layout matrix for heights down the rows'
        raise InputError(FIELD, top.cells[0], f"line {top.number} names no heights and periods", mend)
    kinds = [one.kind for one in axes if one.kind != "Hs"]
    kind = _needed("period", _one("period", said.period, kinds[0] if kinds else ""), PERIODS)
    for one in axes:
        _check_unit(one, top.number)
    told = next((one.unit for one in named if one.kind == "occurrence"), "")
    told = _needed("occurrence", _one("occurrence", said.occurrence, told), TOLD)
    totals = [column for column, cell in enumerate(top.cells) if column and is_total(cell)]
    if totals not in ([], [len(top.cells) - 1]):
        raise InputError(FIELD, top.cells[totals[0]], f"line {top.number}: sums stand amid the table", "Put them last")
    last = is_total(body[-1].cells[0])
    sums, body = (body[-1], body[:-1]) if last else (None, body)
    width = len(top.cells) - len(totals)
    if width < 2 or not body:
        raise InputError(FIELD, top.cells, f"line {top.number}: the table has no bins", MEND)
    where = [(f"line {top.number}, column {c + 1}", top.cells[c]) for c in range(1, width)]
    columns, how = axis(where, said.bins, comma, "Hs" if by_period else kind)
    rows, other = axis(
        [(f"line {line.number}, column 1", line.cells[0]) for line in body],
        said.bins,
        comma,
        kind if by_period else "Hs",
    )
    notes += [note for note in dict.fromkeys((how, other)) if note]
    _check_size(len(rows) * len(columns))
    found: list[tuple[float, float, float]] = []
    empty = 0
    table: list[list[float]] = []
    for line, row in zip(body, rows, strict=True):
        if len(line.cells) != len(top.cells):
            problem = f"line {line.number} has {len(line.cells)} cells, and line {top.number} has {len(top.cells)}"
            raise InputError(FIELD, line.cells[0], problem, "Give every row a cell for each column")
        values = []
        for at, column in enumerate(columns, 1):
            cell = line.cells[at]
            empty += not cell
            value = _occurrence(cell or "0", f"line {line.number}, column {at + 1}", comma)
            values.append(value)
            hs, period = (column, row) if by_period else (row, column)
            found.append((hs, period, value))
        table.append(values)
        if totals and line.cells[-1]:
            _check_sum(sum(values), line.cells[-1], f"line {line.number}", comma)
    if sums is not None:
        for at, cell in enumerate(sums.cells[1:]):
            if cell:
                whole = sum(map(sum, table)) if at >= len(columns) else sum(values[at] for values in table)
                _check_sum(whole, cell, f"column {at + 2}", comma)
    if empty:
        notes.append(f"{empty} empty cells of the matrix were read as sea states that never occur")
    words = f"matrix of {len(rows)} {'periods' if by_period else 'heights'} by {len(columns)}"
    return _scatter(found, kind, told, words, notes)


def _list(lines: Sequence[Line], head: list[Heading], said: Said, comma: bool, notes: list[str]) -> Scatter:
    """Read a list: headings, then a height, a period and an occurrence a row."""
    top = lines[0]
    if len(head) != 3:
        raise InputError(FIELD, ", ".join(top.cells), f"line {top.number} does not name three columns", MEND)
    kinds = [one.kind for one in head]
    periods = [kind for kind in kinds if kind in PERIODS]
    if kinds.count("Hs") != 1 or len(periods) != 1 or kinds.count("occurrence") != 1:
        problem = f"line {top.number} does not name a height, a period and an occurrence"
        raise InputError(FIELD, ", ".join(top.cells), problem, MEND)
    for one in head:
        if one.kind != "occurrence":
            _check_unit(one, top.number)
    kind = _one("period", said.period, periods[0])
    at = {name: kinds.index(name) for name in ("Hs", kind, "occurrence")}
    told = _needed("occurrence", _one("occurrence", said.occurrence, head[at["occurrence"]].unit), TOLD)
    body = [line for line in lines[1:] if not is_total(line.cells[0])]
    if len(body) < len(lines) - 1:
        notes.append("rows of sums were left out")
    _check_size(len(body))
    for line in body:
        if len(line.cells) != 3:
            problem = f"line {line.number} has {len(line.cells)} cells"
            raise InputError(FIELD, ", ".join(line.cells), problem, "Give three in every row")
    axes = {}
    for name in ("Hs", kind):
        where = [(f"line {line.number}, column {at[name] + 1}", line.cells[at[name]]) for line in body]
        axes[name], note = axis(where, said.bins, comma, name, each=False)
        notes += [note] if note else []
    values = []
    for line in body:
        cell = line.cells[at["occurrence"]]
        values.append(_occurrence(cell, f"line {line.number}, column {at['occurrence'] + 1}", comma))
    found = list(zip(axes["Hs"], axes[kind], values, strict=True))
    seen: dict[tuple[float, float], int] = {}
    for line, (hs, period, _) in zip(body, found, strict=True):
        first = seen.setdefault((hs, period), line.number)
        if first != line.number:
            problem = f"line {line.number} has the sea state of line {first}"
            raise InputError(FIELD, f"Hs {hs:g} m, {kind} {period:g} s", problem, "Give each once")
    return _scatter(found, kind, told, f"list of {len(body)} sea states", list(dict.fromkeys(notes)))


def _scatter(
    found: Sequence[tuple[float, float, float]], kind: str, told: str, layout: str, notes: list[str]
) -> Scatter:
    values = [value for _, _, value in found]
    parts, missing, said = shares(values, told, FIELD)
    bins = [Bin(hs, period, part) for (hs, period, _), part in zip(found, parts, strict=True) if part > 0.0]
    for one in bins:
        if one.hs > 0.0 and not one.period > 0.0:
            raise InputError(FIELD, one.period, f"a period of waves {one.hs:g} m high", "Give one above zero")
    return Scatter(tuple(sorted(bins)), kind, told, sum(values), missing, layout, (*notes, *said))


def _occurrence(cell: str, where: str, comma: bool) -> float:
    """Occurrence in a cell."""
    field = f"{FIELD}, {where}"
    if not cell:
        raise InputError(field, cell, "is empty", "Write 0 for a sea state that never occurs")
    try:
        value = number(cell, comma)
    except ValueError:
        raise InputError(field, cell, "is no number", "Write how often the sea state occurs, 0 for never") from None
    if not value >= 0.0 or value > 1e12:
        problem = "must not be negative" if value < 0.0 else "must be finite"
        raise InputError(field, cell, problem, "Write how often the sea state occurs, 0 for never")
    return value


def _check_sum(value: float, cell: str, where: str, comma: bool) -> None:
    """Refuse a sum that is not that of its cells, but for what rounding each of them may make of it."""
    told = _occurrence(cell, where, comma)
    decimals = len(cell.replace(",", ".").partition(".")[2])
    if abs(value - told) > max(0.02 * abs(told), 10.0**-decimals):
        problem = f"is told as the sum of {where}, whose cells sum to {value:g}"
        raise InputError(FIELD, cell, problem, "Correct the cell that is wrong, or leave the sums out")


def _check_unit(one: Heading, line: int) -> None:
    wanted = "m" if one.kind == "Hs" else "s"
    if one.unit.strip().lower() not in ("", wanted, {"m": "metres", "s": "seconds"}[wanted]):
        problem = f"unit of {one.kind} in line {line}"
        raise InputError(FIELD, one.unit, problem, f"Give {one.kind} in {wanted}")


def _check_size(bins: int) -> None:
    if bins > BINS_MAX:
        raise InputError(FIELD, bins, f"has more than {BINS_MAX} sea states", "Give wider bins")


def _choice(field: str, value: str, known: Sequence[str] | dict[str, str]) -> None:
    if value and value not in known:
        raise InputError(field, value, "is unknown", f"Choose one of {', '.join(known)}")


def _one(field: str, *words: str) -> str:
    """What is said once, or several times alike."""
    found = list(dict.fromkeys(word for word in words if word))
    if len(found) > 1:
        problem = f"the file says {found[1]}"
        raise InputError(field, found[0], problem, "Leave it out, or correct the one that is wrong")
    return found[0] if found else ""


def _needed(field: str, value: str, known: Sequence[str] | dict[str, str]) -> str:
    if not value:
        unit = {"period": "the kind of period", "occurrence": "how occurrence is told"}[field]
        mend = f"Say --{field} with one of {', '.join(known)}, or write it into the heading"
        raise InputError(field, NOT_GIVEN, f"the table does not say {unit}", mend)
    return value


def _period_of(text: str) -> str:
    found = heading(text).kind if text else ""
    if text and found not in PERIODS:
        raise InputError(FIELD, text, "is no kind of period", f"Write one of {', '.join(PERIODS)}")
    return found


def _occurrence_of(text: str) -> str:
    found = way_of_telling(text) if text else ""
    if text and not found:
        raise InputError(FIELD, text, "does not say how occurrence is told", f"Write one of {', '.join(TOLD)}")
    return found


def _bins_of(text: str) -> str:
    found = next((one for one in BINS if text.lower().startswith(one[:5])), "") if text else ""
    if text and not found:
        raise InputError(FIELD, text, "does not say what the headings are", f"Write one of {', '.join(BINS)}")
    return found
