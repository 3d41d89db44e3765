"""The float and its lever at rest: geometry, draft from the static moment balance, buoyancy stiffness.

Axes of this package (z up, so that Capytaine reads them as they are): x is the paper's x3, the horizontal normal of the
lever; y is horizontal, from the hinge O to the float; z points up, against the paper's x1. The origin is on the mean
water level plumb below the centre of the float, so that the wave elevation is referred to that centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError


@dataclass(frozen=True)
class Geometry:
    """Float, lever and site. The defaults are the reading of the paper that reproduces its k3, Jh1 and Jh3.

    Parameters
    ----------
    diameter : float
        Diameter d of the two hemispheres. [m]
    cylinder : float
        Length c of the cylinder between them. [m]
    arm : float
        Distance a + b from the hinge to the centre of the float, along the lever. [m]
    inclination : float
        Angle of the lever below the horizontal, from the hinge down to the float. [deg]
    moment : float
        First moment of all masses about the hinge along the lever, m1 a + (m2 + m3 + m4)(a + b). [kg m]
    depth : float
        Water depth, ``inf`` for deep water. [m]
    rho : float
        Density of the water. [kg/m^3]
    g : float
        Acceleration of gravity. [m/s^2]

    Raises
    ------
    InputError
        When a value is outside what a float on a lever can have.
    """

    diameter: float = 0.550
    cylinder: float = 0.080
    arm: float = 0.9891 + 0.0761
    inclination: float = 10.0
    moment: float = 20.27 * 0.9891 + (5.270 + 1.963 + 20.75) * (0.9891 + 0.0761)
    depth: float = 0.70
    rho: float = 1000.0
    g: float = 9.81

    def __post_init__(self) -> None:
        """Refuse what no float can be."""
        for name in ("diameter", "arm", "moment", "depth", "rho", "g"):
            value = getattr(self, name)
            if not value > 0.0:
                raise InputError(f"geometry.{name}", value, "must be positive", "Give it in SI units")
        if not self.cylinder >= 0.0:
            mend = "Give it in metres, 0 for a sphere"
            raise InputError("geometry.cylinder", self.cylinder, "must not be negative", mend)
        if not abs(self.inclination) < 45.0:
            mend = "Give the angle of the lever below the horizontal in degrees"
            raise InputError("geometry.inclination", self.inclination, "must lie between -45 and 45 deg", mend)

    @property
    def axis(self) -> NDArray[np.float64]:
        """Unit vector along the lever, from the hinge to the float. (3,)."""
        angle = np.deg2rad(self.inclination)
        return np.array([0.0, np.cos(angle), -np.sin(angle)])

    @property
    def reach(self) -> float:
        """Horizontal distance from the hinge to the centre of the float. [m]"""
        return float(self.arm * self.axis[1])

    def hinge(self, height: float) -> NDArray[np.float64]:
        """Position of the hinge when the centre of the float is `height` above the mean water level. (3,) [m]."""
        return np.array([0.0, 0.0, height]) - self.arm * self.axis


#: Readings of what the paper leaves open: "inclined" reproduces Table 1, the others show by how much they miss.
VARIANTS: dict[str, Geometry] = {
    "inclined": Geometry(),
    "horizontal": Geometry(inclination=0.0),
    "deep": Geometry(depth=float("inf")),
}


class Statics(NamedTuple):
    """Rest position of the float and its buoyancy stiffness."""

    height: float
    """Centre of the float above the mean water level. [m]"""
    hinge_height: float
    """Hinge above the mean water level. [m]"""
    volume: float
    """Displaced volume. [m^3]"""
    centre: NDArray[np.float64]
    """Centre of buoyancy. (3,) [m]"""
    k3: float
    """Buoyancy stiffness of phi3 without the gravity term, as in Table 1. [Nm/rad]"""


@cache
def _gauss() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights on [-1, 1] for a piece of the float; working them out takes longer than all that they serve."""
    return np.polynomial.legendre.leggauss(200)


def _submerged(geometry: Geometry, height: float) -> tuple[float, NDArray[np.float64], float]:
    """Volume, centre and waterplane moment about the hinge of the tilted capsule, slice by slice along its axis.

    A slice normal to the axis is a disc cut by the water level: area, moment and chord are closed form, so only the
    integral along the axis is numerical (Gauss-Legendre on each smooth piece).
    """
    radius, half = geometry.diameter / 2.0, geometry.cylinder / 2.0
    axis = geometry.axis
    normal = np.array([0.0, -axis[2], axis[1]])  # in the vertical plane, normal to the axis, upwards
    nodes, weights = _gauss()
    volume, moment, waterplane = 0.0, np.zeros(3), 0.0
    for low, high in ((-half - radius, -half), (-half, half), (half, half + radius)):
        s = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        ds = 0.5 * (high - low) * weights
        r = np.sqrt(radius**2 - np.clip(np.abs(s) - half, 0.0, None) ** 2)
        level = -(height + s * axis[2]) / normal[2]  # where the water level cuts the slice, along `normal`
        cut = np.clip(level, -r, r)
        root = np.sqrt(r**2 - cut**2)
        area = r**2 * (np.pi / 2.0 + np.arcsin(cut / r)) + cut * root
        first = -(2.0 / 3.0) * root**3
        volume += float(np.sum(ds * area))
        moment += np.sum(ds * area * s) * axis + np.sum(ds * first) * normal
        y = s * axis[1] + level * normal[1]
        dy = ds * (axis[1] - axis[2] / normal[2] * normal[1])
        waterplane += float(np.sum(dy * 2.0 * root * (y + geometry.arm * axis[1]) ** 2))
    return volume, moment / volume + np.array([0.0, 0.0, height]), waterplane


def statics(geometry: Geometry) -> Statics:
    """Draft from the balance of weight and buoyancy moments about the hinge, and k3.

    Parameters
    ----------
    geometry : Geometry
        Float, lever and site.

    Returns
    -------
    Statics
        Rest position, displaced volume and stiffness.

    Raises
    ------
    InputError
        When no draft balances the weight: the masses are too heavy for the float.
    """
    reach = geometry.axis[1]

    def excess(height: float) -> float:
        volume, centre, _ = _submerged(geometry, height)
        return geometry.rho * volume * float(centre[1] + geometry.arm * reach) - geometry.moment * float(reach)

    extent = geometry.diameter / 2.0 + geometry.cylinder / 2.0 * abs(float(geometry.axis[2]))
    low, high = -0.999 * extent, 0.999 * extent
    if not excess(low) > 0.0 > excess(high):
        problem = "no draft of the float balances this moment of the masses"
        raise InputError("geometry.moment", geometry.moment, problem, "Lower the masses or enlarge the float")
    for _ in range(60):  # bisection: `excess` falls with the height
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    height = 0.5 * (low + high)
    volume, centre, waterplane = _submerged(geometry, height)
    hinge = geometry.hinge(height)
    k3 = geometry.rho * geometry.g * (waterplane + volume * float(centre[2] - hinge[2]))
    return Statics(height, float(hinge[2]), volume, centre, k3)
