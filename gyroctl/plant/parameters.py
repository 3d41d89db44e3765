"""The device in numbers: Table 1, hinge damping and the named choices among the paper's forms."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from gyroctl.errors import InputError
from gyroctl.faces.device import parameters_face
from gyroctl.faces.show import shown
from gyroctl.froude import growth
from gyroctl.reading import is_finite

POSITIVE = ("a", "b", "d", "r1", "r2", "m1", "m2", "m3", "m4", "J11", "J22", "J13", "J14", "k1", "k3")
NOT_NEGATIVE = ("c", "Jh1", "Jh3", "d1", "d3")
FURTHER = ("drag", "coupling_cap", "coupling_slip", "bearing", "windage", "rolling_resistance")
"""Numbers beyond the linear model: zero leaves the term out."""

SHARES = ("traction", "generator_efficiency")

LARGEST = 1e15
"""Size beyond which no number of a device is meant."""

SCALES = (1e-2, 1e3)
"""Least and largest length of a device over that of Table 1."""

NAMED: dict[str, tuple[str, ...]] = {
    "connection": ("magnetic", "rigid"),
    "position": ("rest", "moving"),
    "wetted": ("linear", "reduced", "surface"),
    "contact": ("rolling", "friction"),
}
"""Choices that have names, the usual one first."""

CHOICES = (
    *("position", "wetted", "drag", "drag_area", "drag_height", "contact", "traction", "coupling_cap", "coupling_slip"),
    *("bearing", "windage", "rolling_resistance", "generator_efficiency"),
)
"""Choices beyond the linear model; each is off by default."""


@shown(parameters_face)
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
    position : {"rest", "moving"}
        Where the wave moments act: at the float's place at rest, or at X = l sin phi1 with each wave's own phase k X,
        l the horizontal reach of the lever.
    wetted : {"linear", "reduced", "surface"}
        Pressure of the undisturbed wave and buoyancy on the float: linear, or on what is under water at the instant.
    drag : float
        Drag coefficient Cd of the float in the relative velocity. [-]
    drag_area : pair of float
        Areas for the motions of phi1 and phi3. [m^2]
    drag_height : float
        Height above the mean water level at which the velocity of the water is taken. [m]
    contact : {"rolling", "friction"}
        The spin axis rolls on the track without slip, or as far as friction carries it.
    traction : float
        Coefficient of that friction. [-]
    coupling_cap : float
        Greatest torque Tm of the coupling: Tm tanh(T/Tm); 0 for none. [Nm]
    coupling_slip : float
        Slip sc of an eddy-current coupling's greatest torque: T = cc s/(1 + (s/sc)^2); 0 for none. [rad/s]
    bearing : float
        Friction of the flywheel's bearing. [Nm]
    windage : float
        Drag of the air on the flywheel over the square of its speed. [Nms^2]
    rolling_resistance : float
        Lever arm of the rolling resistance of the spin axis on its track. [m]
    generator_efficiency : float
        Electrical over mechanical energy, of what is stored alike. [-]
    length_scale : float
        Length of the device over that of Table 1: steps, grids of the waves, and the widths over which a term beyond
        the linear model changes its sign are in its units, by Froude's law. It enters no equation of motion. [-]

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
    position: Literal["rest", "moving"] = "rest"
    wetted: Literal["linear", "reduced", "surface"] = "linear"
    drag: float = 0.0
    drag_area: tuple[float, float] = (0.141, 0.282)
    drag_height: float = -0.1
    contact: Literal["rolling", "friction"] = "rolling"
    traction: float = 0.6
    coupling_cap: float = 0.0
    coupling_slip: float = 0.0
    bearing: float = 0.0
    windage: float = 0.0
    rolling_resistance: float = 0.0
    generator_efficiency: float = 1.0
    length_scale: float = 1.0

    def __post_init__(self) -> None:
        for name in (*POSITIVE, *NOT_NEGATIVE, *FURTHER, *SHARES, "length_scale", "drag_height"):
            value = getattr(self, name)
            _check_number(name, value)
            if name == "drag_height":
                continue
            positive = name in (*POSITIVE, *SHARES, "length_scale")
            if value < 0.0 or (value == 0.0 and positive):
                kind = "positive" if positive else "zero or positive"
                default = next(f.default for f in fields(self) if f.name == name)
                raise InputError(f"plant.{name}", value, f"must be {kind}", f"The device of the paper has {default}")
        for name in ("generator_reaction", "lever_gyroscopic"):
            if not isinstance(getattr(self, name), bool):
                raise InputError(f"plant.{name}", getattr(self, name), "must be true or false", "Choose one")
        for name, known in NAMED.items():
            if getattr(self, name) not in known:
                mend = "Choose " + " or ".join(f'"{choice}"' for choice in known)
                raise InputError(f"plant.{name}", getattr(self, name), f"unknown {name}", mend)
        self._check_further()
        if self.r2 <= self.r1:
            problem = f"the ring must be wider than the spin axis (r1 = {self.r1})"
            raise InputError("plant.r2", self.r2, problem, "Exchange r1 and r2 or correct one of them")
        if self.J22 < self.J13:
            problem = "the ring cannot be lighter than the spin axis that rolls on it"
            raise InputError("plant.J22", self.J22, problem, "Check J22 and J13")

    def _check_further(self) -> None:
        """Refuse values and contradictions among the choices beyond the linear model; keep the areas as floats."""
        area = self.drag_area
        if not isinstance(area, tuple | list) or len(area) != 2:
            mend = "Give two areas in m^2, for phi1 and phi3, for example [0.141, 0.282]"
            raise InputError("plant.drag_area", area, "must be two numbers", mend)
        for value in area:
            _check_number("drag_area", value)
            if value < 0.0:
                raise InputError("plant.drag_area", area, "must be zero or positive", "Give areas in m^2")
        object.__setattr__(self, "drag_area", (float(area[0]), float(area[1])))
        low, high = SCALES
        if not low <= self.length_scale <= high:
            problem, mend = (
                f"must be between {low:g} and {high:g}",
                "Give the length over that of Table 1, 1 for its own",
            )
            raise InputError("plant.length_scale", self.length_scale, problem, mend)
        if not -100.0 * max(1.0, self.length_scale) <= self.drag_height <= 0.0:
            mend = "Give a height above the mean water level between -100 and 0 m, for example -0.1"
            raise InputError("plant.drag_height", self.drag_height, "must lie in the water", mend)
        if self.generator_efficiency > 1.0:
            problem, mend = "a generator cannot give more than it takes", "Give a share between 0 and 1"
            raise InputError("plant.generator_efficiency", self.generator_efficiency, problem, mend)
        if self.connection == "rigid":
            if self.contact == "friction":
                problem = "a rigidly geared flywheel cannot slip on the track"
                raise InputError("plant.contact", self.contact, problem, 'Choose "rolling", or the magnetic connection')
            for name in ("coupling_cap", "coupling_slip"):
                if getattr(self, name) > 0.0:
                    problem = "a rigidly geared flywheel has no magnetic coupling"
                    raise InputError(f"plant.{name}", getattr(self, name), problem, "Choose 0")

    @property
    def in_the_waves(self) -> bool:
        """Whether more of the waves acts than their moments at rest: then the float's geometry must be known."""
        return self.position == "moving" or self.drag > 0.0 or self.wetted != "linear"

    @property
    def symmetric(self) -> bool:
        """Whether half a wave later the device moves mirrored: not where the float meets another wave there."""
        return self.position == "rest" and self.wetted == "linear"

    @property
    def time_scale(self) -> float:
        """Unit of time of the device over that of Table 1, by Froude's law. [-]"""
        return growth("s", self.length_scale)

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


def _check_number(name: str, value: object) -> None:
    """Refuse what is no finite number, or a slip of the unit."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not is_finite(value):
        raise InputError(f"plant.{name}", value, "must be a finite number", f"Give {name} in SI units")
    if abs(value) > LARGEST:
        raise InputError(f"plant.{name}", value, f"must be at most {LARGEST:g}", f"Give {name} in SI units")
