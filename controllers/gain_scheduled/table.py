"""The table of a scheduled law as a readable file: cells with operating point, gains and margins, units, provenance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise, product
from pathlib import Path
from typing import Any

from gyroctl.controllers.gain_scheduled.designs import NODES, remember
from gyroctl.controllers.gain_scheduled.scheduled import POINT, SIGNALS, Scheduled
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.reading import existing, is_finite, read_toml
from gyroctl.writing import write_text

MEND = "Write it with python -m gyroctl.controllers.gain_scheduled.design"

LARGEST = 1e6
"""Size beyond which no number of a table is meant."""

FILTERS = ("slow", "brisk", "fast", "memory", "notch", "least", "N", "J4")
"""Fields of the law that a table may set, all of them positive."""

PARTS = {"point": POINT, "cc": SIGNALS, "cg": SIGNALS}
"""Numbers of a cell, in the order of the law."""

UNITS = {
    "envelope": "rad/s",
    "frequency": "rad/s",
    "bandwidth": "-",
    "wave_height": "m",
    "fold_cg": "Nms",
    "share_of_fold": "-",
    "point.cc": "Nms",
    "point.share": "-, of the lock capacity J4 V/N; bearing and windage of the design model take their part of it",
    "point.angle_cos, point.angle_sin": "-",
    "point.speed_cos2, point.speed_sin2": "rad/s",
    "point.flywheel": "-, omega'/(N w)",
    "cc, cg by envelope, speed, flywheel": "Nms/(rad/s)",
    "cc, cg by angle": "Nms",
    "cc, cg by swing": "Nms/rad",
    "cc, cg by swing_rate": "Nms/(rad/s)",
    "margins.*.gain": "-",
    "margins.*.phase": "deg",
    "margins.*.delay": "s",
    "margins.*.disk": "-",
}


def table_file(name: str) -> Path:
    """Path of a shipped table.

    Parameters
    ----------
    name : str
        Name of the table: "scheduled_lqr", "scheduled_lmi".

    Returns
    -------
    Path
        Beside the law.
    """
    return Path(__file__).with_name(f"{name}.toml")


def name_for(name: str, plant: Plant | None) -> str:
    """Name of a law's table for a design model: one of its own beyond the linear model."""
    return name if plant is None or plant.coefficients.beyond is None else f"{name}_realistic"


def lost_by(plant: Plant) -> dict[str, float]:
    """Friction of the bearing [Nm] and windage [Nms^2] that a law must know of: what brakes the flywheel beside it."""
    return {"bearing": plant.parameters.bearing, "windage": plant.parameters.windage}


def read_table(path: Path) -> dict[str, Any]:
    """Content of a table file.

    Parameters
    ----------
    path : Path
        JSON file of a design.

    Returns
    -------
    dict
        Nodes, cells and limits.

    Raises
    ------
    InputError
        For a file that is missing or no table: the message says what to run. Nodes rise, cells stand in their order
        and hold finite numbers, couplings are positive, and filters take their time: what a law interpolates blindly.
    """
    stat = existing("table", path, MEND).stat()
    return _read(path, stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=8)
def _read(path: Path, changed: int, size: int) -> dict[str, Any]:
    """Read once what is read for every law of a search; again where the file has changed."""
    content = read_toml("table", path, MEND)
    nodes = _table("nodes", content.get("nodes"))
    for name in NODES:
        rising: Any = nodes.get(name)
        sound = isinstance(rising, list) and rising and all(_bounded(node) for node in rising)
        if not sound or any(upper <= lower for lower, upper in pairwise(rising)):
            raise InputError(f"nodes.{name}", rising, "must be numbers that rise", MEND)
    cells, wanted = content.get("cells"), list(product(*(nodes[name] for name in NODES)))
    if not isinstance(cells, list) or len(cells) != len(wanted):
        count = len(cells) if isinstance(cells, list) else 0
        raise InputError("table", str(path), f"has {count} cells for {len(wanted)} nodes", MEND)
    for name, value in _table("filters", content.get("filters")).items():
        if name not in FILTERS or not (_bounded(value) and value > 0.0):
            problem = f"must be a positive time constant, one of {', '.join(FILTERS)}"
            raise InputError(f"filters.{name}", value, problem, MEND)
    for number, (cell, place) in enumerate(zip(cells, wanted, strict=True), 1):
        _check_cell(f"cells[{number}]", _table(f"cells[{number}]", cell), place)
    return content


def _check_cell(field: str, cell: Mapping[str, Any], place: tuple[float, ...]) -> None:
    """Refuse a cell that stands elsewhere than it says, or holds what is no number."""
    told = tuple(cell.get(name) for name in NODES)
    if told != place:
        raise InputError(field, told, f"stands in the place of {place}", "Keep the order: envelope slowest")
    for part, names in PARTS.items():
        numbers = _table(f"{field}.{part}", cell.get(part))
        for name in names:
            if not _bounded(numbers.get(name)):
                raise InputError(f"{field}.{part}.{name}", numbers.get(name), "must be a finite number", MEND)
    for name in ("cc", "share"):
        if cell["point"][name] < 0.0:
            problem = "must not be negative: both controls only dissipate"
            raise InputError(f"{field}.point.{name}", cell["point"][name], problem, MEND)


def _table(field: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError(field, value, "must be a table", MEND)
    return value


def _bounded(value: Any) -> bool:
    return is_finite(value) and abs(value) <= LARGEST


def law_of(content: Mapping[str, Any], **fields: float) -> Scheduled:
    """Law of a table's content; `fields` replace the law's own.

    Parameters
    ----------
    content : mapping
        As `read_table` returns it.
    **fields : float
        Fields of `Scheduled`, in their units.

    Returns
    -------
    Scheduled
        The law.
    """
    V, w, b = (tuple(float(value) for value in content["nodes"][name]) for name in NODES)
    cells = tuple(value for cell in content["cells"] for value in row_of(cell))
    law = Scheduled(V, w, b, cells, **{**content["filters"], **fields})
    remember(law, content)
    return law


def row_of(cell: Mapping[str, Any]) -> list[float]:
    """Row of numbers of a cell, in the order of the law."""
    return [float(cell[part][name]) for part, names in PARTS.items() for name in names]


def write_table(
    path: Path,
    name: str,
    nodes: Mapping[str, Sequence[float]],
    filters: Mapping[str, float],
    provenance: Mapping[str, Any],
    cells: Sequence[Mapping[str, Any]],
) -> None:
    """Write a table file, whole or not at all."""
    lines = [f"# Written by python -m gyroctl.controllers.gain_scheduled.design {name}; do not edit the numbers.", ""]
    for title, entries in (("provenance", provenance), ("units", UNITS), ("filters", filters), ("nodes", nodes)):
        lines += [f"[{title}]", *(f"{_key(key)} = {_value(value)}" for key, value in entries.items()), ""]
    for cell in cells:
        lines += ["[[cells]]", *(f"{_key(key)} = {_value(value)}" for key, value in cell.items()), ""]
    write_text(path, "\n".join(lines))
    _read.cache_clear()


def _key(key: str) -> str:
    return key if key.replace("_", "").isalnum() else f'"{key}"'


def _value(value: Any) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(entry) for entry in value) + "]"
    number = float(value)
    if not math.isfinite(number):
        return "nan" if math.isnan(number) else "inf" if number > 0.0 else "-inf"
    text = f"{number:.6g}"
    return text if any(mark in text for mark in ".e") else text + ".0"
