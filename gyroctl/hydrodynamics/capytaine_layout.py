"""The layout of Capytaine's NetCDF files, to and from the table."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.kramers_kronig import both_added_mass_inf
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.reduced import ReducedSurface, checked
from gyroctl.hydrodynamics.table import DOFS, FEWEST, LAYOUT, Complexes, Fits, Floats, Hydrodynamics, coupling, diagonal
from gyroctl.netcdf import Variables

if TYPE_CHECKING:
    import xarray as xr


PARTS = ("Froude_Krylov_force", "diffraction_force")
"""The two parts of the excitation."""

NUMBERS = ReducedSurface._fields[2:]

WAVES = ("omega", "wave_direction", "influenced_dof")


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
        own, values, _ = variables[name]
        for d, size in zip(own, values.shape, strict=True):
            if d not in dims and size != 1:  # Capytaine keeps dimensions such as water_depth when several were solved
                problem = "has a dimension with several values"
                raise InputError(f"{source}: {name}", d, problem, f"Select one value of {d} first")
        left = [d for d in own if d in dims]
        if set(left) != set(dims):
            raise InputError(f"{source}: {name}", own, f"must have the dimensions {dims}", LAYOUT)
        kept = values.reshape([size for d, size in zip(own, values.shape, strict=True) if d in dims])
        return np.transpose(kept, [left.index(d) for d in dims])

    def numbers(name: str, *dims: str) -> NDArray[Any]:
        values = get(name, *dims)
        if values.dtype.kind not in "biufc":
            raise InputError(f"{source}: {name}", str(values.dtype), "holds no numbers", LAYOUT)
        return values

    def scalar(name: str, default: float) -> float:
        values = variables[name].values if name in variables else np.array([default])
        if values.size != 1 or values.dtype.kind not in "biuf":
            raise InputError(f"{source}: {name}", values.shape, "must be one number", LAYOUT)
        return float(values.ravel()[0])

    def pick(dimension: str, wanted: Sequence[str] = DOFS) -> list[int]:
        labels = [str(v) for v in get(dimension, dimension)]
        missing = [label for label in wanted if label not in labels]
        if missing:
            raise InputError(f"{source}: {dimension}", labels, f"lacks {' and '.join(missing)}", LAYOUT)
        return [labels.index(label) for label in wanted]

    every = np.asarray(numbers("omega", "omega"), dtype=np.float64)
    order = np.argsort(every)
    order = order[np.isfinite(every[order]) & (every[order] > 0.0)]
    rows, columns = pick("influenced_dof"), pick("radiating_dof")

    def matrix(name: str) -> Floats:
        full = np.asarray(numbers(name, "omega", "influenced_dof", "radiating_dof"), dtype=np.float64)
        return full[order][:, rows, :][:, :, columns]

    added, damping, omega = matrix("added_mass"), matrix("radiation_damping"), every[order]
    if len(omega) < FEWEST or np.any(np.diff(omega) <= 0.0):
        raise InputError(
            f"{source}: omega", len(omega), f"must be at least {FEWEST} different positive numbers", LAYOUT
        )
    if "added_mass_inf" in variables:
        infinite = np.asarray(numbers("added_mass_inf", "influenced_dof"), dtype=np.float64)[rows]
    else:
        infinite = both_added_mass_inf(omega, added, damping)
    direction = np.asarray(numbers("wave_direction", "wave_direction"), dtype=np.float64)
    headings = np.asarray(np.round(np.rad2deg(direction), 9), dtype=np.float64)
    turn = np.argsort(headings)[
        : len(headings) - int(headings.size > 1 and np.isclose(np.ptp(headings), 360.0))
    ]  # 360 repeats 0

    def moments(*names: str) -> Complexes | None:
        force = _moments(variables, numbers, pick, names)
        # Capytaine writes exp(-i w t); everything here is exp(+i w t)
        return force if force is None else np.conj(np.transpose(force[order][:, turn][:, :, rows], (2, 1, 0))).copy()

    parts = [moments(name) for name in PARTS]
    excitation = moments("excitation_force")
    if excitation is None:
        excitation = moments(*PARTS)
    if excitation is None:
        get("excitation_force", *WAVES)  # refuses
    stiffness = 0.0
    if "hydrostatic_stiffness" in variables:
        stiffness = float(numbers("hydrostatic_stiffness", "influenced_dof", "radiating_dof")[rows[1], columns[1]].real)
    return Hydrodynamics(
        omega=omega,
        added_mass=diagonal(added),
        damping=diagonal(damping),
        added_mass_inf=infinite,
        excitation=cast(Complexes, excitation),
        headings=headings[turn],
        stiffness=stiffness,
        depth=scalar("water_depth", float("inf")),
        rho=scalar("rho", 1000.0),
        g=scalar("g", 9.81),
        coupling=max(scalar("coupling", 0.0), coupling(added, damping)),
        fits=_fits(variables, numbers, rows),
        provenance=dict(attributes),
        froude_krylov=parts[0],
        diffraction=parts[1],
        hull=_hull(variables, numbers, scalar),
        wetted=_wetted(variables, numbers),
    )


def _moments(variables: Variables, get: Any, pick: Any, names: Sequence[str]) -> Complexes | None:
    """Sum of moments (omega, wave_direction, influenced_dof), complex or as real and imaginary parts; None without."""
    if any(name not in variables for name in names):
        return None
    total: Any = 0.0
    for name in names:
        if "complex" in variables[name].dimensions:
            real, imaginary = get(name, "complex", *WAVES)[pick("complex", ("re", "im"))]
            total = total + real + 1j * imaginary
        else:
            total = total + get(name, *WAVES)
    return np.asarray(total, dtype=np.complex128)


def _hull(variables: Variables, get: Any, scalar: Any) -> Hull | None:
    """Surface of the float, where the file holds it."""
    if "hull_faces" not in variables:
        return None
    return Hull(
        np.asarray(get("hull_vertices", "hull_vertex", "xyz"), dtype=np.float64),
        np.asarray(get("hull_faces", "hull_face", "hull_corner"), dtype=np.int64),
        np.asarray(get("hull_hinge", "xyz"), dtype=np.float64),
        scalar("hull_inclination", 0.0),
    )


def _wetted(variables: Variables, get: Any) -> ReducedSurface | None:
    """Polynomials of the wetted surface, where the file holds them."""
    if "wetted_moment1" not in variables:
        return None
    powers = [tuple(map(float, get(f"wetted_{name}", f"{name}_power"))) for name in ("moment1", "moment3")]
    numbers = list(map(float, get("wetted_numbers", "wetted_number")))
    if len(numbers) != len(NUMBERS):
        raise InputError("wetted_numbers", len(numbers), f"must be {len(NUMBERS)} numbers", LAYOUT)
    return checked(ReducedSurface(powers[0], powers[1], *numbers))


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

    pair, stiffness = ("influenced_dof", "radiating_dof"), np.diag([0.0, hydro.stiffness])
    moment = {"units": "Nm/m", "long_name": "wave moment about the hinge, time factor exp(-i w t)"}
    buoyancy = {"units": "Nm/rad", "long_name": "buoyancy only, without the gravity term"}
    data: dict[str, Any] = {
        "added_mass": (("omega", *pair), square(hydro.added_mass), {"units": "kg m^2"}),
        "radiation_damping": (("omega", *pair), square(hydro.damping), {"units": "Nms/rad"}),
        "excitation_force": _split(hydro.excitation, moment),
        "added_mass_inf": ("influenced_dof", hydro.added_mass_inf, {"units": "kg m^2"}),
        "hydrostatic_stiffness": (pair, stiffness, buoyancy),
        "coupling": ((), hydro.coupling, {"units": "1"}),
    }
    for name, part in zip(PARTS, (hydro.froude_krylov, hydro.diffraction), strict=True):
        if part is not None:
            data[name] = _split(part, moment)
    if hydro.hull is not None:
        metres = {"units": "m", "long_name": "at rest; x along x3, y from the hinge to the float, z up"}
        data["hull_vertices"] = (("hull_vertex", "xyz"), hydro.hull.vertices, metres)
        data["hull_faces"] = (("hull_face", "hull_corner"), hydro.hull.faces.astype(np.int32))
        data["hull_hinge"] = ("xyz", hydro.hull.hinge, metres)
        data["hull_inclination"] = ((), hydro.hull.inclination, {"units": "deg"})
    if hydro.wetted is not None:
        data["wetted_moment1"] = ("moment1_power", np.array(hydro.wetted.moment1))
        data["wetted_moment3"] = ("moment3_power", np.array(hydro.wetted.moment3))
        data["wetted_numbers"] = ("wetted_number", np.array(hydro.wetted[2:]), {"long_name": ", ".join(NUMBERS)})
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


def _split(moments: Complexes, attributes: Mapping[str, str]) -> tuple[tuple[str, ...], Floats, Mapping[str, str]]:
    """Moments (2, n_heading, n) as Capytaine has them, real and imaginary parts along a dimension of their own."""
    force = np.conj(np.transpose(moments, (2, 1, 0)))
    return ("complex", *WAVES), np.stack([force.real, force.imag]), attributes
