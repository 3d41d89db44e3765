"""The hydrodynamic table of a device, as every other module sees it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.device import hydrodynamics_face
from gyroctl.faces.show import shown
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.reduced import ReducedSurface

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Coefficients = tuple[Floats, Floats]
Fits = dict[str, tuple[Coefficients, Coefficients]]

FEWEST = 8
"""Frequencies of a table, at least."""

LARGEST, OMEGA_MAX = 1e12, 1e3
"""Moments and inertias [SI units], and frequencies [rad/s], beyond which no float is meant."""

SITE = {
    "rho": (500.0, 2000.0),
    "g": (1.0, 30.0),
    "depth": (1e-3, float("inf")),
    "stiffness": (0.0, LARGEST),
    "coupling": (0.0, LARGEST),
}
"""Least and largest values of what stands for itself."""

NOISE = 0.05
"""Part of its largest value by which a computed damping may be below zero where it vanishes."""

#: The two rotations, in the order of the arrays.
DOFS = ("phi1", "phi3")
MESH = "Build it with gyroctl hydro build, or import it with --mesh and --hinge"
LAYOUT = "Use a NetCDF file as Capytaine writes it, with the rotations phi1 and phi3 as degrees of freedom"


@shown(hydrodynamics_face)
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
    froude_krylov, diffraction : complex ndarray (2, n_heading, n), optional
        The two parts of the excitation: pressure of the undisturbed waves, and of the waves that the held float
        scatters. [Nm/m]
    hull : Hull, optional
        Surface of the float and its hinge, for what acts at the float's true position.
    wetted : ReducedSurface, optional
        Polynomials of what the wetted surface adds, fitted to the panels of the hull.
    added_mass_zero : ndarray (2,), optional
        Added moments of inertia at zero frequency, nan for a rotation that lacks it; kept, and used nowhere. [kg m^2]

    Raises
    ------
    InputError
        For a table that no calculation could have produced: numbers that are not finite, or shapes that disagree.
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
    froude_krylov: Complexes | None = None
    diffraction: Complexes | None = None
    hull: Hull | None = None
    wetted: ReducedSurface | None = None
    added_mass_zero: Floats | None = None

    def __post_init__(self) -> None:
        """Refuse a table that no calculation could have produced."""
        for name in ("omega", "headings"):
            if getattr(self, name).ndim != 1 or not np.all(np.isfinite(getattr(self, name))):
                raise InputError(f"hydrodynamics.{name}", "nan", "must be finite numbers in a row", LAYOUT)
        n, m = len(self.omega), len(self.headings)
        shapes = {"added_mass": (2, n), "damping": (2, n), "added_mass_inf": (2,), "excitation": (2, m, n)}
        for part in ("froude_krylov", "diffraction"):
            if getattr(self, part) is not None:
                shapes[part] = (2, m, n)
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values.shape != shape:
                raise InputError(f"hydrodynamics.{name}", values.shape, f"must have shape {shape}", LAYOUT)
            if not np.all(np.isfinite(values)):
                mend = "Compute those frequencies again or leave them out"
                raise InputError(f"hydrodynamics.{name}", "nan", "holds values that are not finite", mend)
            if np.max(np.abs(values), initial=0.0) > LARGEST:
                worst = float(np.max(np.abs(values)))
                raise InputError(f"hydrodynamics.{name}", worst, "is beyond any device", "Give it in SI units")
        if n < FEWEST or np.any(self.omega <= 0.0) or np.any(np.diff(self.omega) <= 0.0):
            problem = f"must be at least {FEWEST} increasing positive frequencies"
            raise InputError("hydrodynamics.omega", n, problem, "Tabulate more frequencies, in rad/s")
        if m < 1 or np.any(np.diff(self.headings) <= 0.0):
            raise InputError("hydrodynamics.headings", m, "must be increasing, one at least", "Sort the headings")
        self._check_numbers()

    def _check_numbers(self) -> None:
        """Refuse a site, a stiffness or a damping that is none."""
        if self.omega[-1] > OMEGA_MAX:
            problem = f"must be at most {OMEGA_MAX:g} rad/s"
            raise InputError("hydrodynamics.omega", float(self.omega[-1]), problem, "Give rad/s, not Hz or periods")
        if np.max(np.abs(self.headings)) > 360.0:
            worst = float(np.max(np.abs(self.headings)))
            raise InputError("hydrodynamics.headings", worst, "must lie within a full turn", "Give degrees")
        for name, (low, high) in SITE.items():
            value = getattr(self, name)
            if not low <= value <= high:
                problem = f"must be between {low:g} and {high:g}"
                raise InputError(f"hydrodynamics.{name}", value, problem, "Give it in SI units")
        for name, fits in self.fits.items():
            for values in (part for pair in fits for part in pair):
                if not np.all(np.isfinite(values)) or np.max(np.abs(values), initial=0.0) > LARGEST:
                    raise InputError(f"hydrodynamics.fits.{name}", "nan", "holds no finite numbers", "Fit it again")
        low = np.min(self.damping / np.maximum(np.max(np.abs(self.damping), axis=1, keepdims=True), 1e-300))
        if low < -NOISE:
            problem = f"is negative by {-low:.2g} of its largest value: waves would feed the float"
            raise InputError(
                "hydrodynamics.damping", float(np.min(self.damping)), problem, "Compute it on a finer mesh"
            )

    @cached_property
    def sha256(self) -> str:
        """Hash of the numbers (not of the provenance), for the fairness contract of comparisons."""
        digest = hashlib.sha256()
        tables = (self.omega, self.added_mass, self.damping, self.added_mass_inf, self.excitation, self.headings)
        for values in (*tables, np.array([self.stiffness, self.depth, self.rho, self.g])):
            digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()

    def with_hull(self, asked: str) -> Hull:
        """Return the hull, or refuse the choice `asked` that needs it, by an `InputError`."""
        if self.hull is None:
            problem = "needs the float's geometry, which this hydrodynamic database does not hold"
            raise InputError(f"plant.{asked}", asked, problem, MESH)
        return self.hull


def diagonal(matrices: Floats) -> Floats:
    """Return the two rotations' own values (2, n) of (n, 2, 2) matrices."""
    return np.ascontiguousarray(np.diagonal(matrices, axis1=1, axis2=2).T)


def coupling(added: Floats, damping: Floats) -> float:
    """Return the largest coupling in (n, 2, 2) matrices, relative to the geometric mean of the diagonal."""
    worst = 0.0
    for values in (added, damping):
        own = float(np.max(np.sqrt(np.abs(values[:, 0, 0] * values[:, 1, 1]))))
        cross = float(np.max(np.abs(values[:, [0, 1], [1, 0]])))
        worst = max(worst, cross / own if own > 0.0 else 0.0)
    return worst
