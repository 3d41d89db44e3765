"""A database as other programs read it: WAMIT's numeric files, and Capytaine's NetCDF with its rigid modes.

phi1 turns about the downward vertical and is minus yaw, phi3 is roll; both about the hinge, waves referred to the
float's centre. WAMIT's time factor is that of the database, Capytaine's the conjugate.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.database import load
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.table import Complexes, Floats, Hydrodynamics
from gyroctl.writing import write_text, written_whole

MODES = ((-1.0, 6, "Yaw"), (1.0, 4, "Roll"))
"""Sign, number and name of phi1 and phi3 among the rigid modes."""


def export_results(source: Hydrodynamics | Path | str, format: str, out: Path | str) -> list[Path]:
    """Write a database for another program.

    Parameters
    ----------
    source : Hydrodynamics, Path or str
        A database or its file.
    format : {"wamit", "capytaine"}
        NAME.1, NAME.3, NAME.hst (where k3 is known), NAME.3fk (where Froude-Krylov is) and the water in NAME.out; or
        one NetCDF file.
    out : Path or str
        NAME, with or without a suffix of these, or the NetCDF file.

    Returns
    -------
    list of Path
        The files, each of which appears whole or not at all.

    Raises
    ------
    InputError
        For an unknown format, and where no file can be written.
    """
    writers: dict[str, Callable[[Hydrodynamics, Path], list[Path]]] = {"wamit": wamit, "capytaine": capytaine}
    if format not in writers:
        raise InputError("hydro.format", format, f"is not one of {', '.join(writers)}", "Choose one of these")
    path = Path(out)
    if path.is_dir():
        raise InputError("out", str(out), "is a folder", "Give the name of a file, for example float")
    if not path.resolve().parent.is_dir():
        raise InputError("out", str(out), "its folder does not exist", f"Make the folder {path.parent} first")
    hydro = source if isinstance(source, Hydrodynamics) else load(source)
    return writers[format](hydro, path)


def wamit(hydro: Hydrodynamics, out: Path) -> list[Path]:
    """Write WAMIT's numeric files, by periods and with ULEN 1, and the water in the words of its printed output."""
    base = out.with_suffix("") if out.suffix in (".1", ".3", ".3fk", ".hst", ".out") else out
    radiation = []
    for mark, limit in ((0.0, hydro.added_mass_inf), (-1.0, hydro.added_mass_zero)):
        for j, (_, mode, _) in enumerate(MODES):
            if limit is not None and np.isfinite(limit[j]):
                radiation.append(_line(mark, mode, mode, limit[j] / hydro.rho))
    for n in reversed(range(len(hydro.omega))):
        w = hydro.omega[n]
        for j, (_, mode, _) in enumerate(MODES):
            values = hydro.added_mass[j, n] / hydro.rho, hydro.damping[j, n] / hydro.rho / w
            radiation.append(_line(2.0 * np.pi / w, mode, mode, *values))
    texts = {".1": radiation, ".3": _forces(hydro, hydro.excitation), ".out": _water(hydro)}
    if hydro.froude_krylov is not None:
        texts[".3fk"] = _forces(hydro, hydro.froude_krylov)
    if hydro.stiffness > 0.0:
        whole = {(4, 4): hydro.stiffness / (hydro.rho * hydro.g)}
        texts[".hst"] = [_line(i, j, whole.get((i, j), 0.0)) for i in range(1, 7) for j in range(1, 7)]
    return [write_text(base.with_name(base.name + suffix), "\n".join(rows) + "\n") for suffix, rows in texts.items()]


def _water(hydro: Hydrodynamics) -> list[str]:
    """Gravity, ULEN, depth and density, which stand in none of the numeric files."""
    depth = "infinite" if np.isinf(hydro.depth) else f"{hydro.depth:.9E}"
    return [
        "A hydrodynamic database of gyroctl: roll and yaw about the hinge, waves referred to the float's centre",
        f" Gravity:      {hydro.g:.9E}      Length scale:   {1.0:.9E}",
        f" Water depth:  {depth}      Water density:  {hydro.rho:.9E}",
    ]


def _forces(hydro: Hydrodynamics, moments: Complexes) -> list[str]:
    """Rows of NAME.3: period, heading, mode, size, phase [deg], real and imaginary part."""
    rows = []
    for n in reversed(range(len(hydro.omega))):
        for k, heading in enumerate(hydro.headings):
            for j, (sign, mode, _) in enumerate(MODES):
                value = sign * complex(moments[j, k, n]) / (hydro.rho * hydro.g)
                parts = abs(value), float(np.degrees(np.angle(value))), value.real, value.imag
                rows.append(_line(2.0 * np.pi / hydro.omega[n], float(heading), mode, *parts))
    return rows


def _line(*values: float) -> str:
    """A row, whole numbers as such."""
    return " ".join(f"{v:5d}" if isinstance(v, int) else f"{v: .9E}" for v in values)


def capytaine(hydro: Hydrodynamics, out: Path) -> list[Path]:
    """Write Capytaine's NetCDF with the modes Roll and Yaw, the last frequency infinite."""
    import xarray as xr

    order = [1, 0]  # Roll, Yaw
    sign = np.array([MODES[j][0] for j in order])
    names = [MODES[j][2] for j in order]
    omega = np.append(hydro.omega, np.inf)

    def square(values: Floats, limit: Floats) -> Floats:
        full = np.zeros((len(omega), 2, 2))
        full[:, [0, 1], [0, 1]] = np.concatenate([values, limit[:, None]], axis=1)[order].T
        return full

    def split(moments: Complexes) -> tuple[tuple[str, ...], Floats]:
        force = np.conj(np.transpose(moments[order], (2, 1, 0))) * sign
        force = np.concatenate([force, np.zeros_like(force[:1])])
        return ("complex", "omega", "wave_direction", "influenced_dof"), np.stack([force.real, force.imag])

    dims = ("omega", "influenced_dof", "radiating_dof")
    data = {
        "added_mass": (dims, square(hydro.added_mass, hydro.added_mass_inf)),
        "radiation_damping": (dims, square(hydro.damping, np.zeros(2))),
        "excitation_force": split(hydro.excitation),
    }
    if hydro.froude_krylov is not None and hydro.diffraction is not None:
        data["Froude_Krylov_force"], data["diffraction_force"] = split(hydro.froude_krylov), split(hydro.diffraction)
    if hydro.stiffness > 0.0:
        data["hydrostatic_stiffness"] = (dims[1:], np.diag([hydro.stiffness, 0.0]))
    with np.errstate(divide="ignore"):
        coords = {
            "omega": ("omega", omega, {"units": "rad/s"}),
            "freq": ("omega", omega / (2.0 * np.pi), {"units": "Hz"}),
            "period": ("omega", 2.0 * np.pi / omega, {"units": "s"}),
            "wavenumber": ("omega", np.append(wavenumber(hydro.omega, hydro.depth, hydro.g), np.inf)),
            "wave_direction": ("wave_direction", np.deg2rad(hydro.headings), {"units": "rad"}),
            "influenced_dof": names,
            "radiating_dof": names,
            "complex": ["re", "im"],
            "water_depth": hydro.depth,
            "rho": hydro.rho,
            "g": hydro.g,
            "forward_speed": 0.0,
        }
    with written_whole(out) as part:
        xr.Dataset(data, coords=coords).to_netcdf(part, engine="scipy", format="NETCDF3_64BIT")
    return [out]
