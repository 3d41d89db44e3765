"""The layout of Capytaine's NetCDF files, to and from the table."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.kramers_kronig import both_added_mass_inf
from gyroctl.hydrodynamics.table import DOFS, LAYOUT, Complexes, Fits, Floats, Hydrodynamics, coupling, diagonal

if TYPE_CHECKING:
    import xarray as xr


class Variable(NamedTuple):
    """One variable of a file: its dimensions and its values in native byte order."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]


Variables = Mapping[str, Variable]


def from_capytaine(variables: Variables, attributes: Mapping[str, Any], source: str) -> Hydrodynamics:
    """Build the dataclass from variables named and shaped as in Capytaine's files.

    Parameters
    ----------
    variables : mapping of str to Variable
        `added_mass`, `radiation_damping`, `excitation_force` (or its two parts) and their coordinates.
    attributes : mapping
        Global attributes, kept as provenance.
    source : str
        Name of the file, for error messages.

    Returns
    -------
    Hydrodynamics

    Raises
    ------
    InputError
        When a variable or a degree of freedom is missing.
    """

    def get(name: str, *dims: str) -> NDArray[Any]:
        if name not in variables:
            raise InputError(f"{source}: {name}", "missing", "the file has no such variable", LAYOUT)
        own, values = variables[name]
        for d, size in zip(own, values.shape, strict=True):
            if d not in dims and size != 1:  # Capytaine keeps dimensions such as water_depth when several were solved
                problem = "has a dimension with several values"
                raise InputError(f"{source}: {name}", d, problem, f"Select one value of {d} first")
        left = [d for d in own if d in dims]
        if set(left) != set(dims):
            raise InputError(f"{source}: {name}", own, f"must have the dimensions {dims}", LAYOUT)
        kept = values.reshape([size for d, size in zip(own, values.shape, strict=True) if d in dims])
        return np.transpose(kept, [left.index(d) for d in dims])

    def scalar(name: str, default: float) -> float:
        return float(np.ravel(variables[name].values)[0]) if name in variables else default

    def pick(dimension: str, wanted: Sequence[str] = DOFS) -> list[int]:
        labels = [str(v) for v in get(dimension, dimension)]
        missing = [label for label in wanted if label not in labels]
        if missing:
            raise InputError(f"{source}: {dimension}", labels, f"lacks {' and '.join(missing)}", LAYOUT)
        return [labels.index(label) for label in wanted]

    every = np.asarray(get("omega", "omega"), dtype=np.float64)
    order = np.argsort(every)
    order = order[np.isfinite(every[order]) & (every[order] > 0.0)]
    rows, columns = pick("influenced_dof"), pick("radiating_dof")

    def matrix(name: str) -> Floats:
        full = np.asarray(get(name, "omega", "influenced_dof", "radiating_dof"), dtype=np.float64)
        return full[order][:, rows, :][:, :, columns]

    added, damping, omega = matrix("added_mass"), matrix("radiation_damping"), every[order]
    if "added_mass_inf" in variables:
        infinite = np.asarray(get("added_mass_inf", "influenced_dof"), dtype=np.float64)[rows]
    else:
        infinite = both_added_mass_inf(omega, added, damping)
    force = _excitation(variables, get, pick)[:, :, rows]
    direction = np.asarray(get("wave_direction", "wave_direction"), dtype=np.float64)
    headings = np.asarray(np.round(np.rad2deg(direction), 9), dtype=np.float64)
    turn = np.argsort(headings)[: len(headings) - int(np.isclose(np.ptp(headings), 360.0))]  # 360 repeats 0
    stiffness = 0.0
    if "hydrostatic_stiffness" in variables:
        stiffness = float(get("hydrostatic_stiffness", "influenced_dof", "radiating_dof")[rows[1], columns[1]])
    return Hydrodynamics(
        omega=omega,
        added_mass=diagonal(added),
        damping=diagonal(damping),
        added_mass_inf=infinite,
        # Capytaine writes exp(-i w t); everything here is exp(+i w t)
        excitation=np.ascontiguousarray(np.conj(np.transpose(force[order][:, turn], (2, 1, 0)))),
        headings=headings[turn],
        stiffness=stiffness,
        depth=scalar("water_depth", float("inf")),
        rho=scalar("rho", 1000.0),
        g=scalar("g", 9.81),
        coupling=max(scalar("coupling", 0.0), coupling(added, damping)),
        fits=_fits(variables, get, rows),
        provenance=dict(attributes),
    )


def _excitation(variables: Variables, get: Any, pick: Any) -> Complexes:
    """Excitation as complex (omega, wave_direction, influenced_dof), stored as such or as real and imaginary parts."""
    names = ["excitation_force"]
    if "excitation_force" not in variables and "diffraction_force" in variables:
        names = ["diffraction_force", "Froude_Krylov_force"]
    dims = ("omega", "wave_direction", "influenced_dof")
    total: Any = 0.0
    for name in names:
        if name in variables and "complex" in variables[name].dimensions:
            real, imaginary = get(name, "complex", *dims)[pick("complex", ("re", "im"))]
            total = total + real + 1j * imaginary
        else:
            total = total + get(name, *dims)
    return np.asarray(total, dtype=np.complex128)


def _fits(variables: Variables, get: Any, rows: list[int]) -> Fits:
    """Radiation fits kept as fit_NAME_p and fit_NAME_q, (influenced_dof, coefficient)."""
    found: Fits = {}
    for key in variables:
        if key.startswith("fit_") and key.endswith("_p"):
            p, q = (get(name, "influenced_dof", f"{name}_index") for name in (key, f"{key[:-1]}q"))
            found[key[4:-2]] = ((p[rows[0]], q[rows[0]]), (p[rows[1]], q[rows[1]]))
    return found


def to_dataset(hydro: Hydrodynamics) -> xr.Dataset:
    """Return the database as a dataset in Capytaine's layout, complex values as real and imaginary parts."""
    import xarray as xr

    def square(values: Floats) -> Floats:
        out = np.zeros((values.shape[1], 2, 2))
        out[:, 0, 0], out[:, 1, 1] = values
        return out

    force = np.conj(np.transpose(hydro.excitation, (2, 1, 0)))
    pair, stiffness = ("influenced_dof", "radiating_dof"), np.diag([0.0, hydro.stiffness])
    waves = ("complex", "omega", "wave_direction", "influenced_dof")
    moment = {"units": "Nm/m", "long_name": "wave moment about the hinge, time factor exp(-i w t)"}
    buoyancy = {"units": "Nm/rad", "long_name": "buoyancy only, without the gravity term"}
    data: dict[str, Any] = {
        "added_mass": (("omega", *pair), square(hydro.added_mass), {"units": "kg m^2"}),
        "radiation_damping": (("omega", *pair), square(hydro.damping), {"units": "Nms/rad"}),
        "excitation_force": (waves, np.stack([force.real, force.imag]), moment),
        "added_mass_inf": ("influenced_dof", hydro.added_mass_inf, {"units": "kg m^2"}),
        "hydrostatic_stiffness": (pair, stiffness, buoyancy),
        "coupling": ((), hydro.coupling, {"units": "1"}),
    }
    for name, fits in hydro.fits.items():
        for letter, coefficients in zip("pq", zip(*fits, strict=True), strict=True):
            key = f"fit_{name}_{letter}"
            data[key] = (("influenced_dof", f"{key}_index"), np.stack(coefficients))
    coords: dict[str, Any] = {
        "omega": ("omega", hydro.omega, {"units": "rad/s"}),
        "wave_direction": ("wave_direction", np.deg2rad(hydro.headings), {"units": "rad"}),
        "influenced_dof": list(DOFS),
        "radiating_dof": list(DOFS),
        "complex": ["re", "im"],
        "water_depth": hydro.depth,
        "rho": hydro.rho,
        "g": hydro.g,
    }
    attributes = {k: v if isinstance(v, str | int | float) else json.dumps(v) for k, v in hydro.provenance.items()}
    return xr.Dataset(data, coords=coords, attrs=attributes)
