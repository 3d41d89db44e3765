"""Results as CSV for spreadsheets: a file for each table, units in the headings, numbers to the last bit, no formulas.

Of a comparison every run is a row. Of what a study wrote as JSON, a list of records is a table, and so are records by
name; what lies within a record becomes columns, ``power.low``. Everything else goes to a table of facts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.errors import InputError
from gyroctl.names import file_in
from gyroctl.reading import read_json
from gyroctl.reports.layout import open_results
from gyroctl.simulation import metrics, validity
from gyroctl.writing import write_rows

MEND = "Give the folder that --out named, with results.nc or the JSON of a study in it"

SUFFIXES = {
    "_w_per_m": "W/m",
    "_kwh_per_m": "kWh/m",
    "_rad_s": "rad/s",
    "_kwh": "kWh",
    "_nms": "Nms",
    "_deg": "deg",
    "_rad": "rad",
    "_ms": "ms",
    "_hz": "Hz",
    "_nm": "Nm",
    "_w": "W",
    "_j": "J",
    "_s": "s",
    "_m": "m",
}
"""Unit of a number by the end of its name, the longest first."""

UNITS = {**metrics.UNITS, **validity.UNITS, "power": "W", "difference": "W", "hours": "h", "hs": "m", "wp": "rad/s"}
UNITS |= dict.fromkeys(("cc", "cg"), "Nms")
"""Of names that bear none."""

TABLE_UNITS = {
    "site.annual": {
        **dict.fromkeys(("energy", "energy_of_plant", "energy_if_lost"), "kWh"),
        **dict.fromkeys(("out_of_step", "out_of_lock", "reversing", "over_motion"), "h"),
        **dict.fromkeys(("ratio_to_site", "ratio_to_seas", "capture_ratio", "reversals", "failed"), "1"),
    },
    "site.cells": {
        "power_at_site": "W",
        "capture_width": "m",
        "reversals": "1/h",
        **dict.fromkeys(("lock", "in_step", "capture_ratio", "reversing", "over_motion", "failed", "share"), "1"),
    },
}
"""Of names whose unit is another one in another table, or is nowhere else, by file and table."""

ESTIMATE = {"value", "low", "high"}
"""What a number with an interval is made of."""

Record = dict[str, Any]


def export(folder: Path, out: Path | None = None, bom: bool = False) -> list[Path]:
    """Write the tables of a folder of results as CSV.

    Parameters
    ----------
    folder : Path
        Of a comparison or a study, as ``--out`` named it.
    out : Path, optional
        Where to write, by default ``csv`` in that folder.
    bom : bool
        Begin each file with a mark of byte order, by which some spreadsheets know UTF-8.

    Returns
    -------
    list of Path
        The files, each written whole or not at all.

    Raises
    ------
    InputError
        For a folder without results, or results that cannot be read.
    """
    if not folder.is_dir():
        raise InputError("dir", str(folder), "there is no such folder", MEND)
    place = folder / "csv" if out is None else out
    if place.exists() and not place.is_dir():
        raise InputError("out", str(out), "is a file, not a folder", "Give another folder")
    found: dict[str, list[Record]] = {}
    if (folder / "results.nc").is_file():
        found["runs"] = runs(open_results(folder))
    for path in sorted(folder.glob("*.json")):
        content = read_json("results", path, MEND)
        if isinstance(content, Mapping):
            found |= {f"{path.stem}.{name}": rows for name, rows in tables(content).items()}
    if not found:
        raise InputError("dir", str(folder), "holds no results that could be exported", MEND)
    written, taken = [], set[str]()
    for name, rows in found.items():
        slug = base = (
            re.sub(r"[^A-Za-z0-9_-]*\.[^A-Za-z0-9_-]*|[^A-Za-z0-9_.-]+", _sign, name).strip("._-")[:80] or "table"
        )
        count = 1
        while slug.lower() in taken:
            count += 1
            slug = f"{base}_{count}"
        taken.add(slug.lower())
        written.append(write_rows(file_in(place, slug, ending=".csv"), lines(rows, TABLE_UNITS.get(name)), bom))
    return written


def _sign(found: re.Match[str]) -> str:
    """What stands in the name of a file for signs that it cannot have: one dot where there was one."""
    return "." if "." in found.group() else "_"


def runs(ds: Any) -> list[Record]:
    """Every run of a comparison: law, seed, hash of the waves, and each metric."""
    names = [str(name) for name in ds.data_vars if set(ds[name].dims) == {"law", "realisation"}]
    units = {name: str(ds[name].attrs.get("units", "")) for name in names}
    columns = {name: ds[name].transpose("law", "realisation").values for name in names}
    found = []
    for i, law in enumerate(ds["law"].values.tolist()):
        for j, seed in enumerate(ds["realisation"].values.tolist()):
            row: Record = {"law": law, "seed": seed, "sha256": str(ds["sha256"].values[j])}
            for name, values in columns.items():
                unit = units[name]
                row[f"{name} [{unit}]" if unit else name] = _plain(values[i, j])
            found.append(row)
    return found


def tables(content: Mapping[str, Any]) -> dict[str, list[Record]]:
    """Tables of a study's JSON by name, and its facts."""
    found: dict[str, list[Record]] = {}
    facts: list[Record] = []
    for name, rows in _walk(content, ""):
        if isinstance(rows, list):
            found.setdefault(name, []).extend(rows)
        else:
            facts.append({"name": name, "value": rows})
    return {**found, **({"facts": facts} if facts else {})}


def lines(rows: Sequence[Record], units: Mapping[str, str] | None = None) -> Iterator[list[Any]]:
    """Headings, by the `units` of this table first, and rows; a record that lacks a column has an empty cell there."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    yield [with_unit(name, units) for name in columns]
    for row in rows:
        yield [_plain(row.get(name)) for name in columns]


def with_unit(name: str, units: Mapping[str, str] | None = None) -> str:
    """Heading of a column: its name, with the unit in brackets where it is known; `units` go before what is usual."""
    if name.endswith("]"):
        return name
    parts = name.split(".")
    base = parts[-2] if len(parts) > 1 and parts[-1] in ESTIMATE else parts[-1]
    unit = (
        (units or {}).get(base)
        or UNITS.get(base)
        or next((unit for end, unit in SUFFIXES.items() if base.endswith(end)), "")
    )
    return f"{name} [{unit}]" if unit else name


def _walk(content: Mapping[str, Any], path: str) -> Iterator[tuple[str, Any]]:
    """Tables as lists of records, and whatever is none as it is, each by its path."""
    for key, value in content.items():
        name = f"{path}.{key}" if path else str(key)
        if _records(value):
            yield name, [_flat(row) for row in value]
        elif isinstance(value, Mapping) and value and all(map(_records, value.values())):
            yield name, [{str(key): group, **_flat(row)} for group, rows in value.items() for row in rows]
        elif _by_name(value):
            yield name, [{_named(str(key)): one, **_flat(row)} for one, row in value.items()]
        elif isinstance(value, Mapping):
            yield from _walk(value, name)
        else:
            yield name, _text(value)


def _records(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, Mapping) for row in value)


def _by_name(value: Any) -> bool:
    """Whether these are records of one kind by name: groups that have most of their parts in common."""
    if not isinstance(value, Mapping) or len(value) < 2:
        return False
    parts = [set(row) if isinstance(row, Mapping) else set() for row in value.values()]
    if not all(parts) or any(part >= ESTIMATE for part in parts):
        return False
    return 2 * len(set.intersection(*parts)) >= max(map(len, parts))


def _named(key: str) -> str:
    """Heading of the names of records: ``annual`` holds laws, and is the heading itself where nothing else is known."""
    return "law" if key in ("annual", "laws") else key


def _flat(row: Mapping[str, Any], path: str = "") -> Record:
    """Record whose groups have become columns."""
    found: Record = {}
    for key, value in row.items():
        name = f"{path}.{key}" if path else str(key)
        if isinstance(value, Mapping):
            found |= _flat(value, name)
        else:
            found[name] = _text(value)
    return found


def _text(value: Any) -> Any:
    """Value of a cell: a list is written with semicolons."""
    return "; ".join(str(_plain(one)) for one in value) if isinstance(value, list) else value


def _plain(value: Any) -> Any:
    """Value as a spreadsheet takes it: no number is an empty cell, true and false are words."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, float) and not np.isfinite(value):
        return None if np.isnan(value) else str(value)
    return value
