"""The float in its water, as plant and waves see it where more than the linear moments at rest acts."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.excitation import ExcitationTable
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.reduced import ReducedSurface
from gyroctl.hydrodynamics.table import MESH, Hydrodynamics


@dataclass(frozen=True, eq=False)
class Floating:
    """Geometry of the float and what follows from it; equal where all numbers are.

    Parameters
    ----------
    hull : Hull
        Surface and hinge.
    rho, g : float
        Density of the water [kg/m^3] and gravity [m/s^2].
    undisturbed : ExcitationTable, optional
        Froude-Krylov moments.
    reduced : ReducedSurface, optional
        Polynomials of the wetted surface.
    """

    hull: Hull
    rho: float = 1000.0
    g: float = 9.81
    undisturbed: ExcitationTable | None = None
    reduced: ReducedSurface | None = None

    @property
    def reach(self) -> float:
        """Horizontal distance from the hinge to the centre of the float. [m]"""
        return self.hull.reach

    @cached_property
    def sha256(self) -> str:
        """Hash of all numbers."""
        digest = hashlib.sha256(repr((self.rho, self.g, self.reduced, self.hull.inclination)).encode())
        for values in (self.hull.vertices, self.hull.faces, self.hull.hinge):
            digest.update(np.ascontiguousarray(values).tobytes())
        if self.undisturbed is not None:
            digest.update(self.undisturbed.sha256.encode())
        return digest.hexdigest()

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are the same."""
        return isinstance(other, Floating) and self.sha256 == other.sha256

    def __hash__(self) -> int:
        """Hash of all numbers."""
        return hash(self.sha256)

    def choice(self, wetted: str) -> Floating:
        """Return itself, or refuse a choice of the wetted surface that it cannot serve.

        Raises
        ------
        InputError
            Field ``plant.wetted``: without Froude-Krylov and diffraction apart, or "reduced" without a fit.
        """
        if wetted != "linear" and self.undisturbed is None:
            problem = "needs Froude-Krylov and diffraction apart, which this hydrodynamic database does not hold"
            raise InputError("plant.wetted", wetted, problem, MESH)
        if wetted == "reduced" and self.reduced is None:
            problem = "needs a fit for this float, which this hydrodynamic database does not hold"
            raise InputError("plant.wetted", wetted, problem, "Make it: gyroctl hydro fit-wetted FILE")
        return self


def floating(hydro: Hydrodynamics) -> Floating | None:
    """Return the float of a database, None where it holds no geometry."""
    if hydro.hull is None:
        return None
    apart = hydro.froude_krylov if hydro.diffraction is not None else None
    table = None if apart is None else ExcitationTable(hydro.omega, hydro.headings, apart)
    return Floating(hydro.hull, hydro.rho, hydro.g, table, hydro.wetted)
