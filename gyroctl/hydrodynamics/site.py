"""What a file of results leaves out: the water, the units, the modes, the place. Given by hand, or told by the file."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.table import SITE

BOUNDS = {name: SITE[name] for name in ("rho", "g", "depth", "stiffness")} | {"length": (1e-6, 1e6)}
"""Least and largest values of a site."""

USUAL = {"rho": 1000.0, "g": 9.81, "depth": math.inf, "length": 1.0, "stiffness": 0.0}
"""What holds where neither the file nor its user says anything."""

NAMES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
"""Rigid modes by number, from 1."""

FREQUENCIES = ("rad/s", "Hz", "period")
ANGLES = ("deg", "rad")
ALSO = {
    **dict.fromkeys(("rad/s", "omega", "rad s-1"), "rad/s"),
    **dict.fromkeys(("hz", "freq"), "Hz"),
    **dict.fromkeys(("period", "periods", "s"), "period"),
    **dict.fromkeys(("degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
}
"""Other words for units."""

FARTHEST = 1e4
"""Farthest point that results can be about. [m]"""

SAME = 1e-6
"""Relative difference of two statements that count as one."""


@dataclass(frozen=True)
class Site:
    """What a file of results leaves out; None where nothing is given and the file, or what is usual, decides.

    Parameters
    ----------
    rho, g : float, optional
        Density of the water [kg/m^3] and gravity [m/s^2], as in the foreign run; usual: 1000 and 9.81.
    depth : float, optional
        Water depth, ``inf`` for deep water, which is usual. [m]
    length : float, optional
        WAMIT's length ULEN; usual: 1. [m]
    stiffness : float, optional
        Buoyancy stiffness k3 of phi3, in place of the file's. [Nm/rad]
    modes : pair of int or str, optional
        Modes of phi1 and phi3, by number or name; negative, or with a minus, where the mode turns against ours. Usual:
        ``("-yaw", "roll")``, that is (-6, 4).
    frequency : str, optional
        What the column of frequencies holds: "rad/s", "Hz" or "period".
    headings, phases : str, optional
        Unit of the headings and of the phases: "deg" or "rad".
    about : tuple of 3 float, optional
        Point that the moments are about, in the coordinates of the run, where the file does not tell it. [m]
    centre : tuple of 2 float, optional
        Horizontal position of the float's centre in the coordinates of the run, to which waves are referred. [m]
    hinge : tuple of 2 float, optional
        y (negative: the hinge lies behind the float) and z of the hinge from there. [m]

    Raises
    ------
    InputError
        For numbers that no water, float or mode has, and for unknown units.
    """

    rho: float | None = None
    g: float | None = None
    depth: float | None = None
    length: float | None = None
    stiffness: float | None = None
    modes: tuple[int | str, int | str] | None = None
    frequency: str | None = None
    headings: str | None = None
    phases: str | None = None
    about: tuple[float, float, float] | None = None
    centre: tuple[float, float] | None = None
    hinge: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Refuse numbers that no water, float or mode has."""
        for name, (low, high) in BOUNDS.items():
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                problem = f"must be between {low:g} and {high:g}"
                raise InputError(f"hydro.{name}", value, problem, "Give it in SI units, as in the run of the results")
        for name, known in (("frequency", FREQUENCIES), ("headings", ANGLES), ("phases", ANGLES)):
            value = getattr(self, name)
            value = ALSO.get(str(value).strip().lower(), value)
            object.__setattr__(self, name, value)
            if value is not None and value not in known:
                raise InputError(f"hydro.{name}", value, f"is not one of {', '.join(known)}", "Choose one of these")
        for name, size in (("about", 3), ("centre", 2), ("hinge", 2)):
            value = getattr(self, name)
            if value is not None and (len(value) != size or not all(abs(v) <= FARTHEST for v in value)):
                problem = f"must be {size} numbers within {FARTHEST:g} m"
                raise InputError(f"hydro.{name}", value, problem, "Give the place in metres")
        if self.modes is not None:
            first, second = map(abs, self.chosen)
            if first == second:
                raise InputError("hydro.modes", self.modes, "must be two different modes", MODES)

    @property
    def chosen(self) -> tuple[int, int]:
        """Mode numbers of phi1 and phi3, negative where the mode turns against ours."""
        first, second = self.modes or (-6, 4)
        return mode_number(first), mode_number(second)

    def settled(self, name: str, told: float | None = None, where: str = "the file") -> float:
        """Return a number that the file tells, or that is given, or that is usual.

        Raises
        ------
        InputError
            Where the file tells another one than is given.
        """
        given = getattr(self, name)
        if told is not None and given is not None and not math.isclose(told, given, rel_tol=SAME):
            problem = f"differs from {told:g}, which {where} tells"
            raise InputError(f"hydro.{name}", given, problem, "Leave the option out, or mend the file")
        return float(next(value for value in (told, given, USUAL[name]) if value is not None))


MODES = "Number rigid modes from 1 for surge to 6 for yaw, or name them; negative where turned"


def mode_number(mode: int | str) -> int:
    """Return the number of a mode that is given by number or name, negative where it turns against ours."""
    text = str(mode).strip().lower()
    sign, name = (-1, text[1:]) if text.startswith("-") else (1, text.removeprefix("+"))
    if name in NAMES:
        return sign * (NAMES.index(name) + 1)
    if not (name.isascii() and name.isdigit() and len(name) < 10 and 1 <= int(name) <= 1000):
        raise InputError("hydro.modes", mode, "is no mode", MODES)
    return sign * int(name)
