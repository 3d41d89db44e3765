"""What lies beside a comparison: margins of its laws and tables of an evaluation, for the sections of the laws."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from gyroctl.errors import InputError
from gyroctl.reading import is_finite, read_json
from gyroctl.statistics import Estimate

TABLES = {
    "information": "Price of information",
    "information_real": "Price of information in real water",
    "robustness": "Robustness",
    "faults": "Faults",
    "price": "Price of real water",
    "gauge": "Worth of a wave gauge",
}
"""Files of an evaluation that tell something about a law, and headings."""

MEND = "Make it again, or take it out of the folder"

DEEPEST = 6
"""Levels down to which a table is searched for rows."""


class MarginsFound(NamedTuple):
    """Margins of a law in a file."""

    file: str
    point: str
    meaning: dict[str, str]


class RowFound(NamedTuple):
    """Row of a table for one law."""

    case: str
    power: Estimate
    ratio: Estimate
    locked: str
    in_step: str
    runs: str
    turns_kept: float


class TableFound(NamedTuple):
    """Rows of a table for one law."""

    file: str
    title: str
    rows: list[RowFound]


class Beside(NamedTuple):
    """All that was found, by the name of the law; `unread` says which files could not be read, and why."""

    margins: Mapping[str, list[MarginsFound]]
    tables: Mapping[str, list[TableFound]]
    files: list[str]
    unread: list[str]


NOTHING_TOLD = "–"

NOTHING = Beside({}, {}, [], [])


def look_beside(folder: Path | None) -> Beside:
    """Read what lies in a folder and in the folders within it; a file that cannot be read is named, and left out."""
    margins: dict[str, list[MarginsFound]] = {}
    tables: dict[str, list[TableFound]] = {}
    files, unread = list[str](), list[str]()
    if folder is None or not folder.is_dir():
        return NOTHING
    for path in sorted([*folder.glob("*.json"), *folder.glob("*/*.json")]):
        if path.stem not in ("margins", *TABLES) or not path.is_file():
            continue
        file = str(path.relative_to(folder))
        try:
            content = read_json("beside", path, MEND)
        except InputError as error:
            unread.append(f"{file} {error.problem}")
            continue
        if not isinstance(content, dict):
            continue
        if path.stem == "margins":
            found = _margins(file, content)
            if found is not None:
                margins.setdefault(found[0], []).append(found[1])
                files.append(file)
            continue
        for law, rows in _by_law(content).items():
            tables.setdefault(law, []).append(TableFound(file, TABLES[path.stem], rows))
            files.append(file)
    return Beside(margins, tables, sorted(set(files)), unread)


def _margins(file: str, content: Mapping[str, Any]) -> tuple[str, MarginsFound] | None:
    request, meaning = content.get("request"), content.get("meaning")
    law = request.get("law") if isinstance(request, dict) else None
    if not isinstance(request, dict) or not isinstance(law, dict) or not isinstance(law.get("name"), str):
        return None
    if not isinstance(meaning, dict) or not all(isinstance(words, str) for words in meaning.values()):
        return None
    wave, controls = request.get("wave"), request.get("controls")
    told = [*_told(wave, {"height_m": "wave of {} m", "wp_rad_s": "{} rad/s"})]
    pair = ", ".join(_told(controls, {"cc_nms": "cc {} Nms", "cg_nms": "cg {} Nms"}))
    sea = content.get("sea")
    of_sea = f", which stands for the sea {sea['words']}" if isinstance(sea, dict) and "words" in sea else ""
    point = f"In a regular {', '.join(told)}{of_sea}." if told else ""
    point += f" The constant controls beside it: {pair}." if pair else ""
    return law["name"], MarginsFound(file, point, {str(name): words for name, words in meaning.items()})


def _told(values: Any, words: Mapping[str, str]) -> Iterator[str]:
    for name, said in words.items():
        if isinstance(values, dict) and is_finite(values.get(name)):
            yield said.format(f"{values[name]:g}")


def _by_law(content: Mapping[str, Any]) -> dict[str, list[RowFound]]:
    found: dict[str, list[RowFound]] = {}
    for case, row in _rows(content, ()):
        law = str(row["law"]).split("[")[0]
        ratio = row.get("ratio")
        found.setdefault(law, []).append(
            RowFound(
                ", ".join(case) or str(row["law"]),
                _estimate(row["power"]),
                _estimate(ratio),
                str(row.get("locked", NOTHING_TOLD)),
                str(row.get("in_step", NOTHING_TOLD)),
                str(row.get("runs", NOTHING_TOLD)),
                float(row["turns_kept"]) if is_finite(row.get("turns_kept")) else math.nan,
            )
        )
    return found


def _rows(part: Any, case: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Mapping[str, Any]]]:
    """Rows of laws in a table, each with the names of the tables that it stands in."""
    if len(case) > DEEPEST:
        return
    if isinstance(part, dict):
        if isinstance(part.get("law"), str) and isinstance(part.get("power"), dict):
            yield case, part
            return
        for name, inner in part.items():
            if isinstance(inner, dict | list):
                yield from _rows(inner, case if name in ("cases", "levels", "laws", "rows") else (*case, str(name)))
    elif isinstance(part, list):
        for inner in part:
            yield from _rows(inner, case)


def _estimate(told: Any) -> Estimate:
    parts = told if isinstance(told, dict) else {}
    value, low, high = (
        float(parts[name]) if is_finite(parts.get(name)) else math.nan for name in ("value", "low", "high")
    )
    return Estimate(value, low, high, "")
