"""NEMOH's Tecplot output: RadiationCoefficients.tec, ExcitationForce.tec and its Froude-Krylov part FKForce.tec."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.foreign import Forces, Matrices, Site, assembled, existing, lines_of
from gyroctl.hydrodynamics.table import Floats, Hydrodynamics
from gyroctl.reading import real


def read_nemoh(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read RadiationCoefficients.tec, ExcitationForce.tec and, where it is there, FKForce.tec (frequencies in rad/s).

    Parameters
    ----------
    path : Path or str
        The project's folder or its Results folder.
    site : Site, optional
        Modes; density, gravity and depth are taken from Nemoh.cal where the project has it.

    Returns
    -------
    Hydrodynamics
        Conjugated from NEMOH's exp(-i w t). Phases are in degrees in version 3, in radians in version 2; a file whose
        phases all lie within pi is read as radians.

    Raises
    ------
    InputError
        When a file is missing or of another layout.
    """
    folder = Path(path)
    results = next((folder / n for n in ("Results", "results") if (folder / n).is_dir()), folder)
    site = _nemoh_site(site or Site(), [folder / "Nemoh.cal", results.parent / "Nemoh.cal"])
    radiation = _zones(existing(results / "RadiationCoefficients.tec"))
    matrices: Matrices = {}
    order = [abs(m) for m in site.modes]
    for j, mode in enumerate(order):
        if not 1 <= mode <= len(radiation):
            problem = f"needs mode {mode}, the file has {len(radiation)}"
            raise InputError(str(results), site.modes, problem, "Set the two modes")
        for row in radiation[mode - 1][1]:
            entry = matrices.setdefault(float(row[0]), np.full((2, 2, 2), np.nan))
            for i, other in enumerate(order):
                sign = np.sign(site.modes[i]) * np.sign(site.modes[j])
                entry[:, i, j] = sign * _columns(row, other, results)
    whole, apart = existing(results / "ExcitationForce.tec"), results / "FKForce.tec"
    unit = _unit(whole)
    forces = _moments(whole, order, site, unit)
    undisturbed = _moments(apart, order, site, unit) if apart.is_file() else None
    infinite = np.full((2, 2), np.nan)
    with np.errstate(all="ignore"):  # what overflows is refused as what it gives
        return assembled(matrices, forces, infinite, site, f"NEMOH results {results}", undisturbed)


def _unit(path: Path) -> float:
    """Radians per unit of the angles of a file: some versions write degrees."""
    largest = max((float(np.max(np.abs(zone[:, 2::2]))) for _, zone in _zones(path)), default=0.0)
    return 1.0 if largest <= np.pi + 1e-3 else np.pi / 180.0


def _moments(path: Path, order: list[int], site: Site, unit: float) -> Forces:
    """Moments of a file of sizes and angles, `unit` radians each."""
    forces: Forces = {}
    for title, zone in _zones(path):
        found = re.search(r"beta\s*=\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)(?![\w.])", title)
        if found is None:
            raise InputError(str(path), title, "names no heading beta", f"Use {path.name} as NEMOH writes it")
        for row in zone:
            moment = forces.setdefault((float(row[0]), float(found.group(1))), np.full(2, np.nan + 0j))
            for i, mode in enumerate(order):
                size, angle = _columns(row, mode, path.parent)
                moment[i] = np.sign(site.modes[i]) * size * np.exp(-1j * unit * angle)
    return forces


def _zones(path: Path) -> list[tuple[str, Floats]]:
    """Blocks of numeric rows with the text line that precedes each."""
    zones: list[tuple[str, list[list[float]]]] = []
    title, fresh = "", True
    for line in lines_of(path):
        try:
            row = [real(v) for v in line.split()]
        except ValueError:
            title, fresh = line.strip(), True
            continue
        if row:
            if fresh:
                zones.append((title, []))
                fresh = False
            zones[-1][1].append(row)
    widths = {len(row) for _, rows in zones for row in rows}
    if not zones or len(widths) != 1 or widths.pop() % 2 == 0:
        problem = "is not made of zones of one frequency and pairs of values"
        raise InputError("path", str(path), problem, "Use the files of NEMOH's postProc")
    if not all(math.isfinite(value) for _, rows in zones for row in rows for value in row):
        raise InputError("path", str(path), "holds what is no finite number", "Compute those frequencies again")
    return [(title, np.array(rows)) for title, rows in zones]


def _columns(row: Floats, mode: int, where: Path) -> Floats:
    """Pair of values of one mode in a row of a zone."""
    pair = row[2 * mode - 1 : 2 * mode + 1]
    if len(pair) != 2:
        raise InputError(str(where), mode, "is a mode the file does not have", "Set the two modes")
    return pair


def _nemoh_site(site: Site, candidates: list[Path]) -> Site:
    """Density, gravity and depth from the first three values of Nemoh.cal."""
    for path in candidates:
        if path.is_file():
            values = []
            for line in lines_of(path):
                try:
                    values.append(real(line.split()[0]))
                except (ValueError, IndexError):
                    continue
            if len(values) < 3:
                problem = "lacks density, gravity and depth"
                raise InputError("path", str(path), problem, "Use Nemoh.cal as NEMOH reads it")
            return replace(site, rho=values[0], g=values[1], depth=values[2] if values[2] > 0.0 else float("inf"))
    return site
