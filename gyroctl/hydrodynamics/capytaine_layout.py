"""The layout of Capytaine's NetCDF files, to and from the table."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.capytaine_axes import Axis, axis_of, dofs_of, headings_of, told_point
from gyroctl.hydrodynamics.directions import repeated
from gyroctl.hydrodynamics.foreign import SHOWN, dropped, infinite_of, stiffness_of
from gyroctl.hydrodynamics.moving import Frame, framed, named
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.reduced import ReducedSurface, checked
from gyroctl.hydrodynamics.site import Site
from gyroctl.hydrodynamics.table import DOFS, FEWEST, LAYOUT, Complexes, Fits, Floats, Hydrodynamics, coupling, diagonal
from gyroctl.netcdf import Variable, Variables

if TYPE_CHECKING:
    import xarray as xr


PARTS = ("Froude_Krylov_force", "diffraction_force")
"""The two parts of the excitation."""

NUMBERS = ReducedSurface._fields[2:]

WAVES = ("omega", "wave_direction", "influenced_dof")


def from_capytaine(
    variables: Variables, attributes: Mapping[str, Any], source: str, site: Site | None = None
) -> Hydrodynamics:
    """Build the dataclass from variables named and shaped as in Capytaine's files.

    Parameters
    ----------
    variables : mapping of str to Variable
        `added_mass`, `radiation_damping`, `excitation_force` (or its two parts) and their coordinates.
    attributes : mapping
        Global attributes, kept as provenance.
    source : str
        Name of the file, for error messages.
    site : Site, optional
        What the file leaves out, and which modes are phi1 and phi3.

    Returns
    -------
    Hydrodynamics

    Raises
    ------
    InputError
        When a variable or a degree of freedom is missing, or what is given differs from what the file tells.
    """
    asked, site = site is not None, site or Site()

    def get(name: str, *dims: str) -> NDArray[Any]:
        if name not in variables:
            raise InputError(f"{source}: {name}", "missing", "the file has no such variable", LAYOUT)
        own, values, _ = variables[name]
        for d, size in zip(own, values.shape, strict=True):
            if d not in dims and size != 1:  # Capytaine keeps dimensions such as water_depth when several were solved
                problem = "has a dimension with several values"
                raise InputError(f"{source}: {name}", d, problem, f"Select one value of {d} first")
        left = [d for d in own if d in dims]
        if sorted(left) != sorted(dims):
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

    def settled(name: str, variable: str) -> float:
        told = scalar(variable, math.nan) if variable in variables else None
        usual = told is None or told > 0.0
        return site.settled(name, told, source) if usual else cast(float, told)  # refused as what it is

    labels = {name: [str(v) for v in get(name, name)] for name in ("influenced_dof", "radiating_dof")}
    names, modes = dofs_of(labels, source, site)
    told: dict[str, str] = {}
    notes: list[str] = []
    if modes is None:
        wanted: Sequence[str] = DOFS
        frame = Frame((1, 2), np.eye(2), (0.0, 0.0), "phi1 and phi3 of the file")
        if asked and (site.about or site.centre):
            field = "about" if site.about else "centre"
            problem = f"cannot be used: {source} has phi1 and phi3, which are about the hinge"
            raise InputError(f"hydro.{field}", getattr(site, field), problem, "Leave it out")
    else:
        frame = framed(site, told_point(variables, source))
        lacking = [mode for mode in frame.wanted if mode not in names]
        if lacking:
            problem = f"lacks {named(tuple(lacking))}, which moving to the hinge needs"
            raise InputError(f"{source}: influenced_dof", labels["influenced_dof"], problem, LAYOUT)
        wanted = [names[mode] for mode in frame.wanted]
    rows, columns = pick("influenced_dof", wanted), pick("radiating_dof", wanted)
    axis = axis_of(variables, source, site)
    told["frequency"], told["point"] = axis.words, frame.words

    def matrix(name: str) -> Floats:
        full = np.asarray(numbers(name, axis.dimension, "influenced_dof", "radiating_dof"), dtype=np.float64)
        return frame.matrix(full[:, rows, :][:, :, columns]) if modes else full[:, rows, :][:, :, columns]

    added, damping = matrix("added_mass"), matrix("radiation_damping")
    depth, rho, g = settled("depth", "water_depth"), settled("rho", "rho"), settled("g", "g")
    headings, told["headings"] = headings_of(
        Variable(("",), numbers("wave_direction", "wave_direction"), variables["wave_direction"].attributes),
        source,
        site,
    )
    turn = np.argsort(headings)
    again = {int(k) for _, k in repeated(headings[turn])}
    turn = turn[[k for k in range(len(turn)) if k not in again]]  # 360 repeats 0

    def moments(*parts: str) -> Complexes | None:
        force = _moments(variables, numbers, pick, parts, axis.dimension)
        # Capytaine writes exp(-i w t); everything here is exp(+i w t)
        if force is None:
            return None
        ours = np.conj(np.transpose(force[:, turn][:, :, rows], (2, 1, 0))).copy()
        with np.errstate(invalid="ignore"):
            return (
                frame.moments(ours, np.nan_to_num(axis.omega, posinf=0.0), headings[turn], depth, g) if modes else ours
            )

    parts = [moments(name) for name in PARTS]
    excitation = moments("excitation_force")
    if excitation is None:
        excitation = moments(*PARTS)
    if excitation is None:
        get("excitation_force", "wave_direction", "influenced_dof")  # refuses
    kept = kept_frequencies(axis, added, damping, cast(Complexes, excitation), notes, source)
    limits = {name: _limit(axis.omega, added, value, notes) for name, value in (("infinite", math.inf), ("zero", 0.0))}
    omega, added, damping = axis.omega[kept], added[kept], damping[kept]
    if len(omega) < FEWEST or np.any(np.diff(omega) <= 0.0):
        raise InputError(
            f"{source}: omega", len(omega), f"must be at least {FEWEST} different positive numbers", LAYOUT
        )
    if "added_mass_inf" in variables and modes is None:
        infinite = np.asarray(numbers("added_mass_inf", "influenced_dof"), dtype=np.float64)[rows]
        told.update({f"added_mass_inf of {name}": "kept with the database" for name in DOFS})
    else:
        infinite = infinite_of(limits["infinite"], omega, added, damping, told)
    if "added_mass_zero" in variables and modes is None:
        limits["zero"] = np.asarray(numbers("added_mass_zero", "influenced_dof"), dtype=np.float64)[rows]
    told["coupling"] = dropped(added, damping)
    stiffness = _stiffness(variables, numbers, (rows, columns), frame, site, told)
    import_ = {"import": {**told, "notes": notes}} if (asked or notes) and "import" not in attributes else {}
    return Hydrodynamics(
        omega=omega,
        added_mass=diagonal(added),
        damping=diagonal(damping),
        added_mass_inf=infinite,
        excitation=cast(Complexes, excitation)[:, :, kept],
        headings=headings[turn],
        stiffness=stiffness,
        depth=depth,
        rho=rho,
        g=g,
        coupling=max(scalar("coupling", 0.0), coupling(added, damping)),
        fits=_fits(variables, numbers, rows) if modes is None else {},
        provenance={**attributes, **import_},
        froude_krylov=None if parts[0] is None else parts[0][:, :, kept],
        diffraction=None if parts[1] is None else parts[1][:, :, kept],
        hull=_hull(variables, numbers, scalar),
        wetted=_wetted(variables, numbers),
        added_mass_zero=None if np.isnan(limits["zero"]).all() else limits["zero"],
    )


def kept_frequencies(
    axis: Axis, added: Floats, damping: Floats, excitation: Complexes, notes: list[str], source: str
) -> NDArray[np.int64]:
    """Positions of the frequencies that can be used, in rising order; what holds no numbers is left out and noted."""
    omega = axis.omega
    order = np.argsort(omega)
    order = order[np.isfinite(omega[order]) & (omega[order] > 0.0)]
    own = np.arange(2)
    holes = ~(np.isfinite(added[:, own, own]) & np.isfinite(damping[:, own, own]))
    sound = np.asarray(~holes.any(axis=1) & np.isfinite(excitation).all(axis=(0, 1)))
    lost = order[~sound[order]]
    if not len(lost):
        return order
    words = ", ".join(f"{w:.4g}" for w in omega[lost][:SHOWN]) + (", .." if len(lost) > SHOWN else "")
    left = order[sound[order]]
    if len(left) < FEWEST:
        problem = f"holds values that are not finite, at {words} rad/s, and {len(left)} frequencies without"
        raise InputError(f"{source}: added_mass", "nan", problem, "Compute those frequencies again")
    notes.append(f"left out {words} rad/s: nan there; the table begins at {omega[left[0]]:.4g} rad/s")
    return left


def _limit(omega: Floats, added: Floats, value: float, notes: list[str]) -> Floats:
    """Added mass (2,) in a limit of the frequency, nan for what the file lacks."""
    at = np.flatnonzero(omega == value)
    if not len(at):
        return np.full(2, np.nan)
    notes.append(f"row of {'infinite' if value else 'zero'} frequency read")
    return np.asarray(np.diagonal(added[at[0]]), dtype=np.float64)


def _stiffness(
    variables: Variables, get: Any, at: tuple[list[int], list[int]], frame: Frame, site: Site, told: dict[str, str]
) -> float:
    """k3 of phi3, as the file or the option has it; 0 stands for unknown."""
    if "hydrostatic_stiffness" not in variables:
        return stiffness_of(site, frame, None, told)
    own = np.asarray(get("hydrostatic_stiffness", "influenced_dof", "radiating_dof").real, dtype=np.float64)
    own = own[np.ix_(*at)]
    value = float(frame.turn[1] @ np.nan_to_num(own) @ frame.turn[1])
    if site.stiffness is not None:
        told["stiffness"] = f"--stiffness, in place of {value:.4g} of the file"
        return site.stiffness
    if value == 0.0:
        return stiffness_of(site, frame, None, told)
    if value < 0.0:
        problem = "is negative: it must be that of buoyancy alone, without the weight"
        raise InputError("hydrostatic_stiffness of phi3", value, problem, "Correct it, or import with --stiffness")
    told["stiffness"] = "hydrostatic_stiffness" + (", moved as of a body in balance" if frame.moved else "")
    return value


def _moments(variables: Variables, get: Any, pick: Any, names: Sequence[str], main: str) -> Complexes | None:
    """Sum of moments (omega, wave_direction, influenced_dof), complex or as real and imaginary parts; None without."""
    if any(name not in variables for name in names):
        return None
    total: Any = 0.0
    dims = (main, *WAVES[1:])
    for name in names:
        if "complex" in variables[name].dimensions:
            real, imaginary = get(name, "complex", *dims)[pick("complex", ("re", "im"))]
            total = total + real + 1j * imaginary
        else:
            total = total + get(name, *dims)
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
    if hydro.added_mass_zero is not None:
        data["added_mass_zero"] = ("influenced_dof", hydro.added_mass_zero, {"units": "kg m^2"})
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
