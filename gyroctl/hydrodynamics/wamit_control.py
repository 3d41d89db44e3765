"""What the files of a WAMIT run tell beside its results: XBODY, IPEROUT, HBOT, and the water in NAME.out."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.fortran_numbers import lines_of, number
from gyroctl.hydrodynamics.moving import Told

SUFFIXES = (".cfg", ".pot", ".frc", ".CFG", ".POT", ".FRC")
"""Files that may name XBODY, with the word on its line."""

_WORD = re.compile(r"[-+*\w.]+")
_NUMBER = r"\s*([-+]?[\d.]+(?:[EeDd][-+]?\d+)?|infinite)"
_OUT = {
    "g": re.compile(rf"Gravity\s*:{_NUMBER}", re.IGNORECASE),
    "length": re.compile(rf"Length scale\s*:{_NUMBER}", re.IGNORECASE),
    "depth": re.compile(rf"Water depth\s*:{_NUMBER}", re.IGNORECASE),
    "rho": re.compile(rf"Water density\s*:{_NUMBER}", re.IGNORECASE),
}


class Control(NamedTuple):
    """What was told."""

    places: Told
    numbers: dict[str, float]
    """g, length, depth and rho, where NAME.out or NAME.pot tells them."""
    where: str
    frequency: dict[str, str]
    """Unit of the first columns by the file that tells it."""


def control(base: Path) -> Control:
    """Read the input files beside NAME.1.

    Parameters
    ----------
    base : Path
        NAME without suffix.

    Raises
    ------
    InputError
        Where XBODY cannot be read, or the body is turned against the axes of the run.
    """
    found: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    depth: dict[str, float] = {}
    for path in (base.with_name(base.name + suffix) for suffix in SUFFIXES):
        if path.is_file():
            geometry = False
            for line in lines_of(path):
                units.update(_unit(path, line))
                bottom = re.match(r"\s*(\S+)\s+HBOT\b", line, re.IGNORECASE)
                if bottom and number(bottom.group(1)) is not None:
                    told = float(number(bottom.group(1)) or 0.0)
                    depth = {"depth": told if told > 0.0 else float("inf")}
                values = _body(line)
                if values is None and geometry and path.suffix.lower() == ".pot":
                    values = _placed(line)
                geometry = bool(re.match(r"\s*\S+\.gdf\b", line, re.IGNORECASE))
                if values is not None:
                    if len(values) < 3 or (len(values) > 3 and values[3] % 360.0 != 0.0):
                        problem = "is not three coordinates and an angle of 0"
                        raise InputError(f"{path.name}: XBODY", line.strip()[:60], problem, "Compute it unturned")
                    found.setdefault(path.name, values[:3])
    places = {tuple(values) for values in found.values()}
    if len(places) > 1:
        raise InputError("XBODY", sorted(places), f"differs between {' and '.join(found)}", "Keep one of them")
    points = {mode: (p[0], p[1], p[2]) for p in places for mode in (4, 5, 6)}
    numbers = depth | _printed(base.with_name(base.name + ".out"))
    where = f"{base.name}.{'pot' if numbers == depth else 'out'}"
    return Control(Told(points, where=", ".join(found) or "the file"), numbers, where, units)


def _unit(path: Path, line: str) -> dict[str, str]:
    """Unit of the first columns, as IPEROUT of NAME.cfg has it."""
    found = re.match(r"\s*IPEROUT\s*=\s*(\S+)", line, re.IGNORECASE)
    if found is None:
        return {}
    kinds = {"1": "period", "2": "rad/s"}
    if found.group(1) not in kinds:
        problem = "writes neither periods nor frequencies in rad/s"
        raise InputError(f"{path.name}: IPEROUT", found.group(1)[:20], problem, "Run it with IPEROUT 1 or 2")
    return {f"IPEROUT of {path.name}": kinds[found.group(1)]}


def _body(line: str) -> list[float] | None:
    """Coordinates of a line that names XBODY: before the word, or after an equals sign; None elsewhere."""
    text = line.split("!")[0] if "XBODY" in line.split("!")[0].upper() else line
    at = text.upper().find("XBODY")
    if at < 0:
        return None
    part = text[at:].partition("=")[2] if "=" in text[at:] else text[:at]
    values = [number(word) for word in _WORD.findall(part)]
    return [value for value in values if value is not None]


def _placed(line: str) -> list[float] | None:
    """Coordinates by their place, below the file of the geometry: the words behind them are comments."""
    values = []
    for word in line.split():
        value = number(word)
        if value is None:
            break
        values.append(value)
    return values if len(values) == 4 else None


def _printed(path: Path) -> dict[str, float]:
    """Numbers of the water in NAME.out."""
    if not path.is_file():
        return {}
    numbers: dict[str, float] = {}
    for line in lines_of(path)[:2000]:
        for name, pattern in _OUT.items():
            found = pattern.search(line)
            if found and name not in numbers:
                value = float("inf") if found.group(1).lower() == "infinite" else number(found.group(1))
                if value is not None and value > 0.0:
                    numbers[name] = value
    return numbers
