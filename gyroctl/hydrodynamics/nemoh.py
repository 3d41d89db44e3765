"""NEMOH's Tecplot output: RadiationCoefficients.tec, ExcitationForce.tec, FKForce.tec, IRF.tec, and KH.dat."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.directions import degrees
from gyroctl.hydrodynamics.foreign import Forces, Reading, Site, assembled, existing, unlike
from gyroctl.hydrodynamics.fortran_numbers import lines_of, number, numbers, rows_of
from gyroctl.hydrodynamics.frequency_unit import omega_of, settled
from gyroctl.hydrodynamics.moving import Told, framed
from gyroctl.hydrodynamics.nemoh_cal import Cal, read_cal
from gyroctl.hydrodynamics.table import Complexes, Floats, Hydrodynamics

PHASES = "Say what they are: --phases deg or rad"

MOST_ZONES = 20000
"""Zones of a file: motions, or headings."""


class Zone(NamedTuple):
    """A block of rows under its title."""

    title: str
    lines: list[int]
    rows: Floats


def read_nemoh(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read RadiationCoefficients.tec, ExcitationForce.tec and, where they are there, FKForce.tec, IRF.tec and KH.dat.

    Parameters
    ----------
    path : Path or str
        The project's folder or its Results folder.
    site : Site, optional
        Modes, units and place; the water and the degrees of freedom are those of Nemoh.cal where the project has it.

    Returns
    -------
    Hydrodynamics
        Conjugated from NEMOH's exp(-i w t). Frequencies are what the files or Nemoh.cal call them. Phases are in
        degrees in version 3, in radians in version 2; a file whose phases all lie within pi is read as radians.

    Raises
    ------
    InputError
        When a file is missing or of another layout, and where a unit can be read in two ways.
    """
    site = site or Site()
    folder = Path(path)
    results = next((folder / n for n in ("Results", "results") if (folder / n).is_dir()), folder)
    cal = read_cal([folder / "Nemoh.cal", results.parent / "Nemoh.cal"])
    if site.length is not None:
        problem = "is WAMIT's: NEMOH's results have units of their own"
        raise InputError("hydro.length", site.length, problem, "Leave it out")
    radiation = _zones(existing(results / "RadiationCoefficients.tec"))
    frame = framed(site, Told(cal.points, cal.origin, cal.name))
    reading = Reading(site, frame, f"NEMOH results {results}")
    reading.rho, reading.g, reading.depth = (
        site.settled(name, cal.numbers.get(name), cal.name) for name in ("rho", "g", "depth")
    )
    whole, apart = existing(results / "ExcitationForce.tec"), results / "FKForce.tec"
    unit = _frequency(reading, cal, radiation, [results / "RadiationCoefficients.tec", whole, apart])
    columns = _columns_of(reading, cal, radiation, results)
    by_motion = _by_motion(radiation)
    for j, column in enumerate(columns):
        if column not in by_motion:
            problem = f"needs mode {column}, the file has {len(by_motion)}"
            raise InputError(str(results), site.chosen, problem, "Set the two modes")
        _motion(reading, results, by_motion[column], columns, j, unit)
    phase = _phase(reading, whole)
    with np.errstate(all="ignore"):  # what overflows is refused as what it gives
        reading.forces = _moments(reading, whole, columns, unit, phase)
        reading.undisturbed = _moments(reading, apart, columns, unit, phase) if apart.is_file() else None
        _at_infinity(reading, results / "IRF.tec", columns)
        _restoring(reading, [folder, results.parent])
        return assembled(reading)


def _frequency(reading: Reading, cal: Cal, radiation: list[Zone], paths: list[Path]) -> str:
    """Unit of the frequencies, by the heads of all files and by Nemoh.cal."""
    told: dict[str, str] = {}
    for path in paths:
        if path.is_file():
            unit = _head_unit(path)
            if unit is not None:
                told[f"head of {path.name}"] = unit
    if cal.frequency is not None:
        told[cal.name] = cal.frequency
    unit, source = settled(reading.site.frequency, told, "RadiationCoefficients.tec")
    reading.told["frequency"] = f"{unit}, by {source}"
    return unit


def _head_unit(path: Path) -> str | None:
    """Unit that the first variable of a file names."""
    for line in lines_of(path):
        if "VARIABLES" in line.upper():
            name = re.search(r'"([^"]*)"', line)
            text = (name.group(1) if name else line).lower()
            if "hz" in text:
                return "Hz"
            if "rad" in text:
                return "rad/s"
            return "period" if re.search(r"\(\s*s(?:ec\w*)?\s*\)|period", text) else None
        if numbers(line):
            return None
    return None


def _columns_of(reading: Reading, cal: Cal, radiation: list[Zone], results: Path) -> list[int]:
    """Degree of freedom of each wanted mode."""
    if not cal.columns:
        return list(reading.frame.wanted)
    lacking = [mode for mode in reading.frame.wanted if mode not in cal.columns]
    if lacking:
        problem = f"needs mode {lacking[0]}, {cal.name} describes {', '.join(map(str, sorted(cal.columns)))}"
        raise InputError(str(results), reading.site.chosen, problem, "Set the two modes")
    return [cal.columns[mode] for mode in reading.frame.wanted]


def _by_motion(zones: list[Zone]) -> dict[int, Zone]:
    """Zones by their degree of freedom, which their titles name; by order where they do not."""
    found: dict[int, Zone] = {}
    for order, zone in enumerate(zones, 1):
        named = re.search(r"body\s+(\d{1,9})\s+in\s+dof\s+(\d{1,9})\b", zone.title, re.IGNORECASE)
        if named and int(named.group(1)) > 1:
            raise InputError("RadiationCoefficients.tec", zone.title[:60], "is of another body", "Give one body alone")
        found.setdefault(int(named.group(2)) if named else order, zone)
    return found


def _motion(reading: Reading, results: Path, zone: Zone, columns: list[int], j: int, unit: str) -> None:
    """Put the rows of one motion into the matrices."""
    size = len(columns)
    for line, row in zip(zone.lines, zone.rows, strict=True):
        place = f"RadiationCoefficients.tec, line {line}"
        if not np.isfinite(row[0]):
            raise InputError(place, "frequency", "is no number", "Compute it again")
        limit = None if row[0] > 0.0 else _limit(float(row[0]), unit)
        omega = float(omega_of(row[0], unit)) if limit is None else 0.0
        entry = reading.matrices.setdefault(omega, np.full((2, size, size), np.nan)) if limit is None else None
        for i, column in enumerate(columns):
            pair = _pair(row, column, results)
            if limit is not None or entry is None:
                target = reading.infinite if limit == "infinite" else reading.zero
                target[i, j] = pair[0]
                continue
            if i != j and not reading.frame.moved and not np.isfinite(pair).all():
                reading.note(f"{place}: coupling that cannot be read, dropped like all of it")
                continue
            if not np.isfinite(pair).all():
                reading.spoiled.setdefault(omega, []).append(place)
                pair = np.zeros(2)
            elif np.isfinite(entry[:, i, j]).all() and any(map(unlike, entry[:, i, j], pair)):
                raise InputError(place, float(row[0]), "gives a frequency once more, with other values", "Leave one")
            entry[:, i, j] = pair
        if limit is not None:
            note = f"row of {limit} frequency read"
            if note not in reading.notes:
                reading.notes.append(note)


def _limit(value: float, unit: str) -> str:
    """What a frequency of 0, or a negative one, stands for."""
    return "infinite" if (unit == "period") == (value == 0.0) else "zero"


def _phase(reading: Reading, path: Path) -> float:
    """Radians per unit of the angles of a file: some versions write degrees."""
    given, told = reading.site.phases, None
    head = [line for line in lines_of(path)[:200] if '"' in line and "angle" in line.lower()]
    if head:
        told = "deg" if re.search(r"\(deg", head[0], re.I) else "rad" if re.search(r"\(rad", head[0], re.I) else None
    zones = _zones(path)
    largest = max((float(np.nanmax(np.abs(zone.rows[:, 2::2]), initial=0.0)) for zone in zones), default=0.0)
    unit, source = given or told, "--phases" if given else "the head of the file"
    if unit is None:
        if np.pi + 1e-3 < largest <= 2.0 * np.pi + 1e-3:
            problem = "is the largest phase: radians of a whole turn, or degrees"
            raise InputError(f"{path.name}: phases", round(largest, 6), problem, PHASES)
        unit = "rad" if largest <= np.pi + 1e-3 else "deg"
        source = f"the largest, {largest:.4g}"
    if unit == "rad" and largest > 2.0 * np.pi + 1e-3:
        raise InputError(f"{path.name}: phases", round(largest, 6), "is beyond 2 pi rad", PHASES)
    reading.told["phases"] = f"{unit}, by {source}"
    return 1.0 if unit == "rad" else np.pi / 180.0


def _moments(reading: Reading, path: Path, columns: list[int], unit: str, phase: float) -> Forces:
    """Forces and moments of a file of sizes and angles, `phase` radians each."""
    forces: Forces = {}
    zones = _zones(path)
    heading = _headings(reading, path, zones)
    for zone, beta in zip(zones, heading, strict=True):
        for line, row in zip(zone.lines, zone.rows, strict=True):
            if not np.isfinite(row[0]):
                raise InputError(f"{path.name}, line {line}", "frequency", "is no number", "Compute it again")
            if row[0] <= 0.0:
                continue
            omega = float(omega_of(row[0], unit))
            moment: Complexes = np.empty(len(columns), dtype=np.complex128)
            for i, column in enumerate(columns):
                size, angle = _pair(row, column, path.parent)
                moment[i] = size * np.exp(-1j * phase * angle)
            if not np.isfinite(moment).all():
                reading.spoiled.setdefault(omega, []).append(f"{path.name}, line {line}")
                continue
            before = forces.setdefault((omega, beta), moment)
            if any(map(unlike, before, moment)):
                problem = "gives a frequency and heading once more, with other values"
                raise InputError(f"{path.name}, line {line}", float(row[0]), problem, "Leave one of them out")
    return forces


def _headings(reading: Reading, path: Path, zones: list[Zone]) -> list[float]:
    """Headings of the zones. [deg]"""
    values, told = [], None
    for zone in zones:
        found = re.search(
            r"beta\s*=\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d{1,3})?)(?![\w.])\s*(deg|rad)?", zone.title
        )
        value = None if found is None else number(found.group(1))
        if found is None or value is None:
            raise InputError(str(path), zone.title, "names no heading beta", f"Use {path.name} as NEMOH writes it")
        values.append(value)
        told = found.group(2) or told
    turned = degrees(np.array(values), reading.site.headings, told, None, path.name)
    reading.told["headings"] = f"{reading.site.headings or told or 'deg'}, by {path.name}"
    return [float(v) for v in turned]


def _zones(path: Path) -> list[Zone]:
    """Blocks of numeric rows with the text line that precedes each."""
    found: list[tuple[str, list[int], list[list[float]]]] = []
    title, fresh = "", True
    for count, line in enumerate(lines_of(path), 1):
        row = numbers(line)
        if row is None:
            words = line.split()
            if words and number(words[0]) is not None:
                problem, mend = "is no row of numbers", "Compute it again, or mend the number"
                raise InputError(f"{path.name}, line {count}", line.strip()[:60], problem, mend)
            title, fresh = (line.strip(), True) if words else (title, fresh)
            continue
        if fresh:
            found.append((title, [], []))
            fresh = False
        found[-1][1].append(count)
        found[-1][2].append(row)
    widths = {len(row) for _, _, rows in found for row in rows}
    if not found or len(widths) != 1 or widths.pop() % 2 == 0:
        problem = "is not made of zones of one frequency and pairs of values"
        raise InputError("path", str(path), problem, "Use the files of NEMOH's postProc")
    for title, lines, _ in found:
        told = re.search(r"I\s*=\s*(\d{1,9})", title)
        if told and int(told.group(1)) != len(lines):
            problem = f"says {told.group(1)} rows and has {len(lines)}"
            raise InputError(f"{path.name}, line {lines[0] - 1}", title[:60], problem, "Compute it again")
    return [Zone(title, lines, np.array(rows)) for title, lines, rows in found[:MOST_ZONES]]


def _pair(row: Floats, column: int, where: Path) -> Floats:
    """Pair of values of one degree of freedom in a row of a zone."""
    pair = row[2 * column - 1 : 2 * column + 1]
    if len(pair) != 2:
        raise InputError(str(where), column, "is a mode the file does not have", "Set the two modes")
    return pair


def _at_infinity(reading: Reading, path: Path, columns: list[int]) -> None:
    """Added mass at infinite frequency, which IRF.tec repeats in each row of its zones."""
    if not path.is_file():
        return
    zones = _by_motion(_zones(path))
    for j, column in enumerate(columns):
        if column not in zones:
            continue
        for i, other in enumerate(columns):
            value = _pair(zones[column].rows[0], other, path.parent)[0]
            if np.isfinite(value) and not np.isfinite(reading.infinite[i, j]):
                reading.infinite[i, j] = value
    for name, row in zip(("phi1", "phi3"), reading.frame.turn, strict=True):
        if np.isfinite(reading.infinite[np.ix_(*2 * [np.flatnonzero(row)])]).all():
            reading.told[f"added_mass_inf of {name}"] = path.name


def _restoring(reading: Reading, folders: list[Path]) -> None:
    """KH.dat of the mesh: the restoring matrix (6, 6)."""
    names = [sub / name for sub in map(Path, ("mesh", "Mesh", "Mechanics", ".")) for name in ("KH.dat", "Kh.dat")]
    path = next((folder / name for folder in folders for name in names if (folder / name).is_file()), None)
    if path is None:
        return
    rows = [row.values for row in rows_of(path, (6,), "Use KH.dat as NEMOH's mesh program writes it")]
    if len(rows) != 6 or not np.isfinite(rows).all():
        raise InputError("path", str(path), "is not six rows of six numbers", "Compute it again")
    reading.restoring, reading.told["restoring"] = np.array(rows), path.name
