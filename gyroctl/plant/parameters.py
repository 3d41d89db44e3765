"""The device in numbers: Table 1, hinge damping and the named choices among the paper's forms."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal

from gyroctl.errors import InputError

POSITIVE = ("a", "b", "d", "r1", "r2", "m1", "m2", "m3", "m4", "J11", "J22", "J13", "J14", "k1", "k3")
NOT_NEGATIVE = ("c", "Jh1", "Jh3", "d1", "d3")


@dataclass(frozen=True)
class Parameters:
    """Table 1 of the paper (SI units), hinge damping, and choices.

    Parameters
    ----------
    a, b : float
        Lever from the hinge to the float, and on to the ring; the ring's centre is a + b from the hinge. [m]
    c, d : float
        Cylinder height and diameter of the float. [m]
    r1, r2 : float
        Radii of the spin axis and of the ring; N = r2/r1. [m]
    m1, m2, m3, m4 : float
        Masses of float and lever, ring, spin axis, flywheel. [kg]
    J11, J22, J13, J14 : float
        Their moments of inertia as defined above (16). [kg m^2]
    k1, k3 : float
        Stiffness about the vertical and the horizontal axis. [Nm/rad]
    Jh1, Jh3 : float
        Added moments of inertia at infinite frequency. [kg m^2]
    d1, d3 : float
        Hinge damping. The paper has none. [Nms/rad]
    generator_reaction : bool
        Keep the generator's reaction on the float in (22)-(23) as printed. It counts the torque twice: omega is
        relative to the ring, so that the torque pair does no virtual work on phi1 and phi3, see (18).
    lever_gyroscopic : bool
        Keep the moment omega x H of the momentum about the lever, which the paper leaves out.
    connection : {"magnetic", "rigid"}
        Flywheel on the magnetic coupling, or geared rigidly to the ring (omega' = N psi') as in the predecessor.

    Raises
    ------
    InputError
        For a value outside its physical range.
    """

    a: float = 0.9891
    b: float = 0.0761
    c: float = 0.080
    d: float = 0.550
    r1: float = 0.009
    r2: float = 0.203
    m1: float = 20.27
    m2: float = 5.270
    m3: float = 1.963
    m4: float = 20.75
    J11: float = 21.68
    J22: float = 0.0952
    J13: float = 0.0009208
    J14: float = 0.3671
    k1: float = 146.7
    k3: float = 2945.0
    Jh1: float = 14.39
    Jh3: float = 32.16
    d1: float = 2.0
    d3: float = 0.0
    generator_reaction: bool = False
    lever_gyroscopic: bool = True
    connection: Literal["magnetic", "rigid"] = "magnetic"

    def __post_init__(self) -> None:
        for name in POSITIVE + NOT_NEGATIVE:
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise InputError(f"plant.{name}", value, "must be a finite number", f"Give {name} in SI units")
            if value < 0.0 or (value == 0.0 and name in POSITIVE):
                kind = "positive" if name in POSITIVE else "zero or positive"
                default = next(f.default for f in fields(self) if f.name == name)
                raise InputError(f"plant.{name}", value, f"must be {kind}", f"The device of the paper has {default}")
        for name in ("generator_reaction", "lever_gyroscopic"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(f"plant.{name}", getattr(self, name), "must be true or false", "Choose one")
        if self.connection not in ("magnetic", "rigid"):
            raise InputError("plant.connection", self.connection, "unknown connection", 'Choose "magnetic" or "rigid"')
        if self.r2 <= self.r1:
            problem = f"the ring must be wider than the spin axis (r1 = {self.r1})"
            raise InputError("plant.r2", self.r2, problem, "Exchange r1 and r2 or correct one of them")
        if self.J22 < self.J13:
            problem = "the ring cannot be lighter than the spin axis that rolls on it"
            raise InputError("plant.J22", self.J22, problem, "Check J22 and J13")

    @property
    def N(self) -> float:
        """Gear ratio r2/r1. [-]"""
        return self.r2 / self.r1

    @property
    def J1(self) -> float:
        """Inertia about the hinge, (16). [kg m^2]"""
        inner = self.J22 / 2 + self.J13 / 2 + self.J14 / 2
        return self.J11 + inner + self.m1 * self.a**2 + (self.m2 + self.m3 + self.m4) * (self.a + self.b) ** 2

    @property
    def J2(self) -> float:
        """Inertia of the ring with what turns along, (16). [kg m^2]"""
        return self.J22 + (self.N**2 + 0.5) * self.J13 + self.J14 / 2

    @property
    def J3(self) -> float:
        """Half the inertia of the spin axis, (16). [kg m^2]"""
        return self.J13 / 2

    @property
    def J4(self) -> float:
        """Inertia of the flywheel, (16). [kg m^2]"""
        return self.J14

    @property
    def K(self) -> float:
        """J3 + J4/2, (16). [kg m^2]"""
        return self.J3 + self.J4 / 2

    @property
    def lever_inertia(self) -> float:
        """Inertia of ring, spin axis and flywheel about the lever: C2 of the lever term. [kg m^2]"""
        return self.J22 + self.J13 / 2 + self.J14 / 2
