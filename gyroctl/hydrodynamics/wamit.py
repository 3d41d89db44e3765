"""WAMIT's numeric output: NAME.1 (added mass and damping), NAME.3 (excitation), NAME.3fk (its Froude-Krylov part)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.foreign import Forces, Matrices, Site, assembled, existing, lines_of, mode_of
from gyroctl.hydrodynamics.table import Hydrodynamics
from gyroctl.reading import real


def read_wamit(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read WAMIT's NAME.1 and NAME.3 (or NAME.2), and NAME.3fk where it is there.

    Parameters
    ----------
    path : Path or str
        Either file, or NAME without suffix.
    site : Site, optional
        Density, gravity, depth, length and modes of the run.

    Returns
    -------
    Hydrodynamics
        WAMIT's time factor is exp(+i w t) as here. A row of period 0 (infinite frequency) gives the added mass at
        infinite frequency; without it Kramers-Kronig does.

    Raises
    ------
    InputError
        When a file is missing or of another layout.
    """
    site = site or Site()
    base = Path(path)
    base = base.with_suffix("") if base.suffix in (".1", ".2", ".3", ".3fk") else base
    first = existing(base.with_name(base.name + ".1"))
    third, second = (base.with_name(base.name + suffix) for suffix in (".3", ".2"))
    third = existing(second if second.is_file() and not third.is_file() else third)
    scale = site.rho * site.length**5  # rotation with rotation
    matrices: Matrices = {}
    infinite = np.full((2, 2), np.nan)
    for row in _rows(first, (4, 5)):
        period, i, j = row[0], _index(row[1], site.modes), _index(row[2], site.modes)
        if i is None or j is None or period < 0.0:
            continue
        sign = np.sign(site.modes[i]) * np.sign(site.modes[j])
        if period == 0.0:
            infinite[i, j] = sign * scale * row[3]
        elif len(row) == 5:
            omega = 2.0 * np.pi / period
            entry = matrices.setdefault(omega, np.full((2, 2, 2), np.nan))
            entry[:, i, j] = sign * scale * np.array([row[3], row[4] * omega])
    apart = base.with_name(base.name + ".3fk")
    undisturbed = _moments(apart, site) if apart.is_file() else None
    source = f"WAMIT files {first.name} and {third.name}"
    with np.errstate(all="ignore"):  # what overflows is refused as what it gives
        return assembled(matrices, _moments(third, site), infinite, site, source, undisturbed)


def _moments(path: Path, site: Site) -> Forces:
    """Moments of a file in the layout of NAME.3."""
    forces: Forces = {}
    for row in _rows(path, (7,)):
        i = _index(row[2], site.modes)
        if i is None or row[0] <= 0.0:
            continue
        key = (2.0 * np.pi / row[0], row[1])
        moment = np.sign(site.modes[i]) * site.rho * site.g * site.length**3 * (row[5] + 1j * row[6])
        forces.setdefault(key, np.full(2, np.nan + 0j))[i] = moment
    return forces


def _rows(path: Path, lengths: tuple[int, ...]) -> list[list[float]]:
    """Rows of numbers of one of the given lengths; a heading line before the first of them is skipped."""
    rows: list[list[float]] = []
    mend = "Use WAMIT's numeric output files"
    for number, line in enumerate(lines_of(path), 1):
        try:
            row = [real(v.replace("D", "E")) for v in line.split()]
        except ValueError:
            row = []
        if len(row) in lengths and all(map(math.isfinite, row)):
            rows.append(row)
        elif line.strip() and rows:
            problem = f"is not a row of {lengths} numbers"
            raise InputError(f"{path.name}, line {number}", line.strip()[:60], problem, mend)
    if not rows:
        raise InputError("path", str(path), f"has no row of {lengths} numbers", mend)
    return rows


def _index(mode: float, modes: tuple[int, int]) -> int | None:
    """Position of a mode number among ours."""
    order = [abs(m) for m in modes]
    return order.index(mode_of(mode)) if mode_of(mode) in order else None
