"""Nemoh.cal: the water, the origin of the waves, the degrees of freedom and what frequencies are written as."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.fortran_numbers import lines_of, number

UNITS = {1: "rad/s", 2: "Hz", 3: "period"}
"""Types of frequency."""


@dataclass(frozen=True)
class Cal:
    """What Nemoh.cal tells; empty where there is none."""

    name: str = "Nemoh.cal"
    numbers: dict[str, float] = field(default_factory=dict)
    """rho, g and depth."""
    origin: tuple[float, float] = (0.0, 0.0)
    """XEFF and YEFF, where the elevation is referred to. [m]"""
    frequency: str | None = None
    """Unit of the written frequencies."""
    columns: dict[int, int] = field(default_factory=dict)
    """Degree of freedom, from 1, of each rigid mode; empty where bodies are not described."""
    points: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    """Point that each rotation is about. [m]"""


def read_cal(candidates: list[Path]) -> Cal:
    """Read the first of these files that exists.

    Raises
    ------
    InputError
        Where it has no density, gravity and depth, or degrees of freedom that are no rigid modes.
    """
    path = next((path for path in candidates if path.is_file()), None)
    if path is None:
        return Cal()
    lines = [(_leading(line), line) for line in lines_of(path)]
    rows = [values for values, _ in lines if values]
    if len(rows) < 3:
        raise InputError("path", str(path), "lacks density, gravity and depth", "Use Nemoh.cal as NEMOH reads it")
    rho, g, depth = (values[0] for values in rows[:3])
    numbers = {"rho": rho, "g": g, "depth": float("inf") if depth <= 0.0 else depth}  # 0 is deep water
    for name in ("rho", "g", "depth"):
        if not numbers[name] > 0.0:
            raise InputError(f"{path}: {name}", numbers[name], "must be positive", "Use Nemoh.cal as NEMOH reads it")
    origin = (rows[3][0], rows[3][1]) if len(rows) > 3 and len(rows[3]) > 1 else (0.0, 0.0)
    if not np.all(np.isfinite(origin)):
        raise InputError(f"{path}: XEFF", origin, "must be finite", "Use Nemoh.cal as NEMOH reads it")
    columns, points = _freedom(path, lines)
    return Cal("Nemoh.cal", numbers, origin, _output(path, lines), columns, points)


def _leading(line: str) -> list[float]:
    """Numbers that a line begins with."""
    values: list[float] = []
    for word in re.split(r"[\s,]+", line.split("!")[0].strip()):
        value = number(word) if word else None
        if value is None:
            break
        values.append(value)
    return values


def _output(path: Path, lines: list[tuple[list[float], str]]) -> str | None:
    """Unit that frequencies are written in."""
    for values, line in lines:
        if values and re.search(r"output\s+freq|freq\w*\s+type\s+output|freq\w*\s+output", line, re.IGNORECASE):
            if values[0] not in UNITS:
                raise InputError(f"{path}: output freq type", values[0], "is not 1, 2 or 3", "Set it as in the run")
            return UNITS[int(values[0])]
    return None


def _freedom(
    path: Path, lines: list[tuple[list[float], str]]
) -> tuple[dict[int, int], dict[int, tuple[float, float, float]]]:
    """Degrees of freedom of the one body: kind, direction and point."""
    columns: dict[int, int] = {}
    points: dict[int, tuple[float, float, float]] = {}
    at = [k for k, (values, line) in enumerate(lines) if values and re.search(r"degrees? of freedom", line, re.I)]
    if not at:
        return columns, points
    if len(at) > 1:
        raise InputError(str(path), len(at), "describes several bodies", "Give results of one body alone")
    count = lines[at[0]][0][0]
    if not 0 <= count <= 100:
        raise InputError(f"{path}: degrees of freedom", count, "is no number of them", "Use Nemoh.cal of the run")
    for k, (values, line) in enumerate(lines[at[0] + 1 : at[0] + 1 + int(count)], 1):
        axis = np.flatnonzero(np.abs(values[1:4]) > 1e-9) if len(values) >= 7 else np.empty(0)
        if len(values) < 7 or not np.all(np.isfinite(values[:7])):
            problem = "is no degree of freedom of kind, direction and point"
            raise InputError(f"{path}: degree of freedom {k}", line.strip()[:60], problem, "Use Nemoh.cal of the run")
        if values[0] not in (1.0, 2.0) or len(axis) != 1 or abs(values[1 + axis[0]] - 1.0) > 1e-9:
            continue  # no rigid mode along an axis
        mode = int(axis[0]) + 1 + 3 * int(values[0] == 2.0)
        columns[mode] = k
        if values[0] == 2.0:
            points[mode] = (values[4], values[5], values[6])
    return columns, points
