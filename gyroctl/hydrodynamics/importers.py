"""Results of other solvers as a database: WAMIT (.1 and .3), NEMOH (Tecplot files) and Capytaine (NetCDF).

Capytaine writes these text formats and reads them only through the separate package bemio; the two small formats are
read here. All results must have been computed about the hinge, with waves referred to a point below the centre of the
float, x along the paper's x3 and z up. Rigid modes are numbered as usual (1 surge .. 4 roll, 5 pitch, 6 yaw): phi1
turns about the downward vertical, so it is minus yaw, and phi3 is roll.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.database import Hydrodynamics, coupling, load, save
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf
from gyroctl.hydrodynamics.radiation import fit_all

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class Site:
    """What the text formats leave out.

    Parameters
    ----------
    rho, g : float
        Density of the water [kg/m^3] and gravity [m/s^2], as in the foreign run.
    depth : float
        Water depth, ``inf`` for deep water. [m]
    length : float
        WAMIT's length ULEN. [m]
    stiffness : float
        Buoyancy stiffness k3 of phi3. [Nm/rad]
    modes : tuple of int
        Mode numbers of phi1 and phi3; negative where the mode turns against ours.
    """

    rho: float = 1000.0
    g: float = 9.81
    depth: float = float("inf")
    length: float = 1.0
    stiffness: float = 0.0
    modes: tuple[int, int] = (-6, 4)


def read_capytaine(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read a NetCDF file of Capytaine with degrees of freedom phi1 and phi3; being complete, it needs no `site`."""
    return load(path)


def read_wamit(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read WAMIT's NAME.1 and NAME.3 (or NAME.2).

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
    base = base.with_suffix("") if base.suffix in (".1", ".2", ".3") else base
    first = _existing(base.with_name(base.name + ".1"))
    third = base.with_name(base.name + ".3")
    third = _existing(
        third if third.is_file() or not base.with_name(base.name + ".2").is_file() else third.with_suffix(".2")
    )
    scale = site.rho * site.length**5  # rotation with rotation
    matrices: dict[float, NDArray[np.float64]] = {}
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
    forces: dict[tuple[float, float], Complexes] = {}
    for row in _rows(third, (7,)):
        i = _index(row[2], site.modes)
        if i is None or row[0] <= 0.0:
            continue
        key = (2.0 * np.pi / row[0], row[1])
        moment = np.sign(site.modes[i]) * site.rho * site.g * site.length**3 * (row[5] + 1j * row[6])
        forces.setdefault(key, np.full(2, np.nan + 0j))[i] = moment
    return _assembled(matrices, forces, infinite, site, f"WAMIT files {first.name} and {third.name}")


def read_nemoh(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read RadiationCoefficients.tec and ExcitationForce.tec of a NEMOH project (frequencies in rad/s).

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
    radiation = _zones(_existing(results / "RadiationCoefficients.tec"))
    excitation = _zones(_existing(results / "ExcitationForce.tec"))
    matrices: dict[float, Floats] = {}
    order = [abs(m) for m in site.modes]
    for j, mode in enumerate(order):
        if not 1 <= mode <= len(radiation):
            raise InputError(
                str(results), site.modes, f"needs mode {mode}, the file has {len(radiation)}", "Set the two modes"
            )
        for row in radiation[mode - 1][1]:
            entry = matrices.setdefault(float(row[0]), np.full((2, 2, 2), np.nan))
            for i, other in enumerate(order):
                sign = np.sign(site.modes[i]) * np.sign(site.modes[j])
                entry[:, i, j] = sign * _columns(row, other, results)
    largest = max((float(np.max(np.abs(zone[:, 2::2]))) for _, zone in excitation), default=0.0)
    unit = 1.0 if largest <= np.pi + 1e-3 else np.pi / 180.0
    forces: dict[tuple[float, float], Complexes] = {}
    for title, zone in excitation:
        found = re.search(r"beta\s*=\s*([-+.\deE]+)", title)
        if found is None:
            raise InputError(str(results), title, "names no heading beta", "Use ExcitationForce.tec as NEMOH writes it")
        for row in zone:
            moment = forces.setdefault((float(row[0]), float(found.group(1))), np.full(2, np.nan + 0j))
            for i, mode in enumerate(order):
                size, angle = _columns(row, mode, results)
                moment[i] = np.sign(site.modes[i]) * size * np.exp(-1j * unit * angle)
    return _assembled(matrices, forces, np.full((2, 2), np.nan), site, f"NEMOH results {results}")


#: Reader of each format; a new format is one more entry.
READERS: dict[str, Callable[[Path | str, Site | None], Hydrodynamics]] = {
    "capytaine": read_capytaine,
    "wamit": read_wamit,
    "nemoh": read_nemoh,
}


def import_results(path: Path | str, format: str, out: Path | str, site: Site | None = None) -> Path:
    """Read results of another solver, fit the radiation and write a database.

    Parameters
    ----------
    path : Path or str
        The results.
    format : str
        "capytaine", "wamit" or "nemoh".
    out : Path or str
        NetCDF file to write.
    site : Site, optional
        What the format leaves out.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        When the format is unknown, a file is missing or of another layout.
    """
    if format not in READERS:
        raise InputError("hydro.format", format, f"is not one of {', '.join(READERS)}", "Choose one of these")
    hydro = READERS[format](path, site)
    return save(replace(hydro, fits=fit_all(hydro)), out)


def _existing(path: Path) -> Path:
    if not path.is_file():
        raise InputError("path", str(path), "there is no such file", "Check the path of the results")
    return path


def _rows(path: Path, lengths: tuple[int, ...]) -> list[list[float]]:
    """Rows of numbers of one of the given lengths; a heading line before the first of them is skipped."""
    rows: list[list[float]] = []
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
        try:
            row = [float(v.replace("D", "E")) for v in line.split()]
        except ValueError:
            row = []
        if len(row) in lengths:
            rows.append(row)
        elif line.strip() and rows:
            raise InputError(
                f"{path.name}, line {number}",
                line.strip()[:60],
                f"is not a row of {lengths} numbers",
                "Use WAMIT's numeric output files",
            )
    if not rows:
        raise InputError("path", str(path), f"has no row of {lengths} numbers", "Use WAMIT's numeric output files")
    return rows


def _zones(path: Path) -> list[tuple[str, Floats]]:
    """Blocks of numeric rows with the text line that precedes each."""
    zones: list[tuple[str, list[list[float]]]] = []
    title, fresh = "", True
    for line in path.read_text(errors="replace").splitlines():
        try:
            row = [float(v) for v in line.split()]
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
        raise InputError(
            "path",
            str(path),
            "is not made of zones of one frequency and pairs of values",
            "Use the files of NEMOH's postProc",
        )
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
            for line in path.read_text(errors="replace").splitlines():
                try:
                    values.append(float(line.split()[0]))
                except (ValueError, IndexError):
                    continue
            if len(values) < 3:
                raise InputError(
                    "path", str(path), "lacks density, gravity and depth", "Use Nemoh.cal as NEMOH reads it"
                )
            return replace(site, rho=values[0], g=values[1], depth=values[2] if values[2] > 0.0 else float("inf"))
    return site


def _index(mode: float, modes: tuple[int, int]) -> int | None:
    """Position of a mode number among ours."""
    order = [abs(m) for m in modes]
    return order.index(int(mode)) if int(mode) in order else None


def _assembled(
    matrices: dict[float, Floats],
    forces: dict[tuple[float, float], Complexes],
    infinite: Floats,
    site: Site,
    source: str,
) -> Hydrodynamics:
    """Put rows in any order onto one frequency axis, which both kinds of results must share."""
    omega = np.array(sorted(matrices))
    headings = np.array(sorted({beta for _, beta in forces}))
    headings = headings[: len(headings) - int(len(headings) > 0 and np.isclose(np.ptp(headings), 360.0))]  # repeated
    excitation = np.full((2, len(headings), len(omega)), np.nan + 0j)
    for (w, beta), moment in forces.items():
        near = np.flatnonzero(np.isclose(omega, w, rtol=1e-6))
        if len(near) and beta in headings:
            excitation[:, np.searchsorted(headings, beta), near[0]] = moment
    table = np.array([matrices[w] for w in omega]).reshape(-1, 2, 2, 2)
    own = np.arange(2)
    complete = np.isfinite(table[:, :, own, own]).all() and np.isfinite(excitation).all()
    if not len(omega) or not len(headings) or not complete:
        raise InputError(
            source,
            site.modes,
            "lacks values of these modes at some frequency or heading",
            "Compute radiation and excitation at the same frequencies, or set the two modes",
        )
    table = np.nan_to_num(table)  # an absent coupling term is zero
    added, damping = table[:, 0], table[:, 1]
    at_infinity = np.diagonal(infinite)
    if not np.isfinite(at_infinity).all():
        at_infinity = np.array([added_mass_inf(omega, added[:, j, j], damping[:, j, j])[0] for j in range(2)])
    return Hydrodynamics(
        omega=omega,
        added_mass=np.ascontiguousarray(added[:, own, own].T),
        damping=np.ascontiguousarray(damping[:, own, own].T),
        added_mass_inf=np.array(at_infinity),
        excitation=excitation,
        headings=headings,
        stiffness=site.stiffness,
        depth=site.depth,
        rho=site.rho,
        g=site.g,
        coupling=coupling(added, damping),
        provenance={"source": source},
    )
