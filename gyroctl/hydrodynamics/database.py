"""The hydrodynamic table of a device: the dataclass, and its file in the layout that Capytaine writes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import netcdf_classic
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf as kramers_kronig_inf

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Coefficients = tuple[Floats, Floats]

#: The two rotations, in the order of the arrays.
DOFS = ("phi1", "phi3")
SHIPPED = Path(__file__).parent.parent / "data" / "hydrodynamics.nc"

_LAYOUT = "Use a NetCDF file as Capytaine writes it, with the rotations phi1 and phi3 as degrees of freedom"


@dataclass(frozen=True)
class Hydrodynamics:
    """Linear hydrodynamics of the float for its two rotations phi1 and phi3 about the hinge.

    The time factor is exp(+i w t), the elevation is referred to the centre of the float, moments are about the hinge.

    Parameters
    ----------
    omega : ndarray (n,)
        Frequencies. [rad/s]
    added_mass : ndarray (2, n)
        Added moments of inertia. [kg m^2]
    damping : ndarray (2, n)
        Radiation damping. [Nms/rad]
    added_mass_inf : ndarray (2,)
        Added moments of inertia at infinite frequency, consistent with Kramers-Kronig. [kg m^2]
    excitation : complex ndarray (2, n_heading, n)
        Wave moments per wave amplitude. [Nm/m]
    headings : ndarray (n_heading,)
        Directions the waves travel to, from the axis x3 (0) towards the axis from the hinge to the float (90). [deg]
    stiffness : float
        Buoyancy stiffness k3. [Nm/rad]
    depth : float
        Water depth. [m]
    rho, g : float
        Density of the water [kg/m^3] and gravity [m/s^2].
    coupling : float
        Largest radiation coupling between the two rotations, relative to the geometric mean of their own values. [-]
    fits : mapping of str to pair of (p, q)
        Coefficients of the radiation fits kept with the table, one (p, q) for each rotation.
    provenance : mapping
        Where the table comes from.
    """

    omega: Floats
    added_mass: Floats
    damping: Floats
    added_mass_inf: Floats
    excitation: Complexes
    headings: Floats
    stiffness: float
    depth: float
    rho: float = 1000.0
    g: float = 9.81
    coupling: float = 0.0
    fits: Mapping[str, tuple[Coefficients, Coefficients]] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse a table that no calculation could have produced."""
        n, m = len(self.omega), len(self.headings)
        shapes = {
            "added_mass": (2, n),
            "damping": (2, n),
            "added_mass_inf": (2,),
            "excitation": (2, m, n),
        }
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values.shape != shape:
                raise InputError(f"hydrodynamics.{name}", values.shape, f"must have shape {shape}", _LAYOUT)
            if not np.all(np.isfinite(values)):
                raise InputError(
                    f"hydrodynamics.{name}",
                    "nan",
                    "holds values that are not finite",
                    "Compute those frequencies again or leave them out",
                )
        if n < 8 or np.any(self.omega <= 0.0) or np.any(np.diff(self.omega) <= 0.0):
            raise InputError(
                "hydrodynamics.omega",
                n,
                "must be at least 8 increasing positive frequencies",
                "Tabulate more frequencies, in rad/s",
            )
        if m < 1 or np.any(np.diff(self.headings) <= 0.0):
            raise InputError(
                "hydrodynamics.headings", m, "must be increasing, one at least", "Sort the headings of the table"
            )

    @cached_property
    def sha256(self) -> str:
        """Hash of the numbers (not of the provenance), for the fairness contract of comparisons."""
        digest = hashlib.sha256()
        scalars = np.array([self.stiffness, self.depth, self.rho, self.g])
        for values in (
            self.omega,
            self.added_mass,
            self.damping,
            self.added_mass_inf,
            self.excitation,
            self.headings,
            scalars,
        ):
            digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()


@cache
def shipped() -> Hydrodynamics:
    """Return the database that comes with the package: the float of Zhang et al. (2017), rebuilt by `bem.build`."""
    return load(SHIPPED)


def load(path: Path | str) -> Hydrodynamics:
    """Read a database from a NetCDF file in the layout that Capytaine writes.

    Parameters
    ----------
    path : Path or str
        NetCDF classic (read without any further library) or NetCDF 4 (needs xarray with h5netcdf and h5py).

    Returns
    -------
    Hydrodynamics
        Conjugated from Capytaine's exp(-i w t) to exp(+i w t). What the file lacks is derived: the added mass at
        infinite frequency from Kramers-Kronig.

    Raises
    ------
    InputError
        When the file is missing, unreadable or of another layout.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError("path", str(path), "there is no such file", "Check the path of the hydrodynamic database")
    with file.open("rb") as stream:
        magic = stream.read(4)
    if magic[:3] == b"CDF" and magic[3:] in (b"\x01", b"\x02"):
        contents = netcdf_classic.read(file)
    elif magic == b"\x89HDF":
        contents = _read_netcdf4(file)
    else:
        raise InputError("path", str(path), "is not a NetCDF file", _LAYOUT)
    return from_capytaine(contents.variables, contents.attributes, str(path))


def _read_netcdf4(path: Path) -> netcdf_classic.Contents:
    """Read a NetCDF 4 file through xarray."""
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            data = dataset.load()
    except ImportError as error:
        raise InputError(
            "path", str(path), "is a NetCDF 4 file and h5py is not installed", "Run: pip install h5py"
        ) from error
    except (OSError, ValueError) as error:
        raise InputError("path", str(path), f"cannot be read as NetCDF 4 ({error})", _LAYOUT) from error
    variables = {
        str(name): netcdf_classic.Variable(tuple(map(str, values.dims)), np.asarray(values.values))
        for name, values in data.variables.items()
    }
    return netcdf_classic.Contents(variables, {str(k): v for k, v in data.attrs.items()})


def from_capytaine(
    variables: Mapping[str, netcdf_classic.Variable], attributes: Mapping[str, Any], source: str
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
            raise InputError(f"{source}: {name}", "missing", "the file has no such variable", _LAYOUT)
        variable = variables[name]
        extra = [d for d in variable.dimensions if d not in dims]
        keep = variable.values
        for d in extra:  # Capytaine keeps dimensions such as water_depth when several were solved
            axis = [*variable.dimensions].index(d)
            if variable.values.shape[axis] != 1:
                raise InputError(
                    f"{source}: {name}", d, "has a dimension with several values", f"Select one value of {d} first"
                )
        left = [d for d in variable.dimensions if d in dims]
        keep = keep.reshape([s for d, s in zip(variable.dimensions, keep.shape, strict=True) if d in dims])
        if set(left) != set(dims):
            raise InputError(f"{source}: {name}", variable.dimensions, f"must have the dimensions {dims}", _LAYOUT)
        return np.transpose(keep, [left.index(d) for d in dims])

    def scalar(name: str, default: float) -> float:
        return float(np.ravel(variables[name].values)[0]) if name in variables else default

    def pick(dimension: str) -> list[int]:
        labels = [str(v) for v in get(dimension, dimension)]
        missing = [d for d in DOFS if d not in labels]
        if missing:
            raise InputError(f"{source}: {dimension}", labels, f"lacks {' and '.join(missing)}", _LAYOUT)
        return [labels.index(d) for d in DOFS]

    every = np.asarray(get("omega", "omega"), dtype=np.float64)
    order = np.argsort(every)
    order = order[np.isfinite(every[order]) & (every[order] > 0.0)]
    rows, columns = pick("influenced_dof"), pick("radiating_dof")

    def matrix(name: str) -> Floats:
        full = np.asarray(get(name, "omega", "influenced_dof", "radiating_dof"), dtype=np.float64)
        return full[:, rows, :][:, :, columns]

    added, damping = matrix("added_mass"), matrix("radiation_damping")
    omega = every[order]
    if "added_mass_inf" in variables:
        infinite = np.asarray(get("added_mass_inf", "influenced_dof"), dtype=np.float64)[rows]
    else:
        infinite = np.array([kramers_kronig_inf(omega, added[order, j, j], damping[order, j, j])[0] for j in range(2)])
    force = _excitation(variables, get)[:, :, rows]
    direction = np.asarray(get("wave_direction", "wave_direction"), dtype=np.float64)
    headings = np.asarray(np.round(np.rad2deg(direction), 9), dtype=np.float64)
    turn = np.argsort(headings)[: len(headings) - int(np.isclose(np.ptp(headings), 360.0))]  # 360 repeats 0
    stiffness = 0.0
    if "hydrostatic_stiffness" in variables:
        stiffness = float(get("hydrostatic_stiffness", "influenced_dof", "radiating_dof")[rows[1], columns[1]])
    return Hydrodynamics(
        omega=omega,
        added_mass=_diagonal(added[order]),
        damping=_diagonal(damping[order]),
        added_mass_inf=infinite,
        # Capytaine writes exp(-i w t); everything here is exp(+i w t)
        excitation=np.ascontiguousarray(np.conj(np.transpose(force[order][:, turn], (2, 1, 0)))),
        headings=headings[turn],
        stiffness=stiffness,
        depth=scalar("water_depth", float("inf")),
        rho=scalar("rho", 1000.0),
        g=scalar("g", 9.81),
        coupling=max(scalar("coupling", 0.0), coupling(added[order], damping[order])),
        fits=_fits(variables, rows),
        provenance=dict(attributes),
    )


def _diagonal(matrices: Floats) -> Floats:
    """(n, 2, 2) to (2, n)."""
    return np.ascontiguousarray(np.diagonal(matrices, axis1=1, axis2=2).T)


def coupling(added: Floats, damping: Floats) -> float:
    """Return the largest coupling in (n, 2, 2) matrices, relative to the geometric mean of the diagonal."""
    worst = 0.0
    for values in (added, damping):
        own = float(np.max(np.sqrt(np.abs(values[:, 0, 0] * values[:, 1, 1]))))
        cross = float(np.max(np.abs(values[:, [0, 1], [1, 0]])))
        worst = max(worst, cross / own if own > 0.0 else 0.0)
    return worst


def _excitation(variables: Mapping[str, netcdf_classic.Variable], get: Any) -> Complexes:
    """Excitation as complex (omega, wave_direction, influenced_dof), stored as such or as real and imaginary parts."""
    names = ["excitation_force"]
    if "excitation_force" not in variables and "diffraction_force" in variables:
        names = ["diffraction_force", "Froude_Krylov_force"]
    dims = ("omega", "wave_direction", "influenced_dof")
    total: Any = 0.0
    for name in names:
        if name in variables and "complex" in variables[name].dimensions:
            labels = [str(v) for v in get("complex", "complex")]
            parts = get(name, "complex", *dims)
            total = total + parts[labels.index("re")] + 1j * parts[labels.index("im")]
        else:
            total = total + get(name, *dims)
    return np.asarray(total, dtype=np.complex128)


def _fits(
    variables: Mapping[str, netcdf_classic.Variable], rows: list[int]
) -> dict[str, tuple[Coefficients, Coefficients]]:
    """Radiation fits kept as fit_NAME_p and fit_NAME_q, (influenced_dof, coefficient)."""
    found: dict[str, tuple[Coefficients, Coefficients]] = {}
    for key in variables:
        if key.startswith("fit_") and key.endswith("_p"):
            p, q = variables[key].values, variables[key[:-1] + "q"].values
            found[key[4:-2]] = ((p[rows[0]], q[rows[0]]), (p[rows[1]], q[rows[1]]))
    return found


def to_dataset(hydro: Hydrodynamics) -> xr.Dataset:
    """Return the database as a dataset in Capytaine's layout, complex values as real and imaginary parts."""
    import xarray as xr

    def diagonal(values: Floats) -> Floats:
        out = np.zeros((values.shape[1], 2, 2))
        out[:, 0, 0], out[:, 1, 1] = values
        return out

    force = np.conj(np.transpose(hydro.excitation, (2, 1, 0)))
    square = ("omega", "influenced_dof", "radiating_dof")
    stiffness = np.diag([0.0, hydro.stiffness])
    data: dict[str, Any] = {
        "added_mass": (square, diagonal(hydro.added_mass), {"units": "kg m^2"}),
        "radiation_damping": (square, diagonal(hydro.damping), {"units": "Nms/rad"}),
        "excitation_force": (
            ("complex", "omega", "wave_direction", "influenced_dof"),
            np.stack([force.real, force.imag]),
            {"units": "Nm/m", "long_name": "wave moment about the hinge, time factor exp(-i w t)"},
        ),
        "added_mass_inf": ("influenced_dof", hydro.added_mass_inf, {"units": "kg m^2"}),
        "hydrostatic_stiffness": (
            ("influenced_dof", "radiating_dof"),
            stiffness,
            {"units": "Nm/rad", "long_name": "buoyancy only, without the gravity term"},
        ),
        "coupling": ((), hydro.coupling, {"units": "1"}),
    }
    for name, pair in hydro.fits.items():
        for k, letter in enumerate("pq"):
            values = np.stack([pair[0][k], pair[1][k]])
            data[f"fit_{name}_{letter}"] = (("influenced_dof", f"fit_{name}_{letter}_index"), values)
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


def save(hydro: Hydrodynamics, path: Path | str) -> Path:
    """Write the database as NetCDF classic in Capytaine's layout; `load` reads it back bit by bit.

    Parameters
    ----------
    hydro : Hydrodynamics
        The table.
    path : Path or str
        File to write. It appears whole or not at all.

    Returns
    -------
    Path
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(target.name + ".partial")
    try:
        to_dataset(hydro).to_netcdf(partial, engine="scipy", format="NETCDF3_64BIT")
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
    return target
