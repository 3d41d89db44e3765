"""Which choice of the plant beyond the linear model moves fold, Neimark-Sacker border and damping of phi1 most."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gyroctl.devices import VARIANTS
from gyroctl.devices.scaling import grown
from gyroctl.froude import at_length, growth
from gyroctl.linearisation import PeriodicOrbit, lock_orbit
from gyroctl.orbits.continuation import Branch, Kind, continue_fixed_point, continue_orbit, scaled_by_orbit
from gyroctl.orbits.orbit_map import OrbitMap
from gyroctl.orbits.pseudo_arclength import Palc
from gyroctl.plant import Plant
from gyroctl.robustness.headroom import headroom
from gyroctl.studies.margins.request import Request

OPTIONS = Palc(longest=0.3)

LINEAR: dict[str, Any] = {
    "position": "rest",
    "wetted": "linear",
    "contact": "rolling",
    **dict.fromkeys(("drag", "coupling_cap", "coupling_slip", "bearing", "windage", "rolling_resistance"), 0.0),
    "generator_efficiency": 1.0,
}
"""The plant with every choice off."""

ALL = "all smooth ones"

CHOICES: dict[str, dict[str, Any]] = {
    "linear": {},
    "position moving": {"position": "moving"},
    "drag 0.5": {"drag": 0.5},
    "drag 1": {"drag": 1.0},
    "wetted reduced": {"wetted": "reduced"},
    "coupling slip 20 rad/s": {"coupling_slip": 20.0},
    "coupling cap 2 Nm": {"coupling_cap": 2.0},
    "bearing 0.01 Nm": {"bearing": 0.01},
    "windage 9.1e-7 Nms²": {"windage": 9.1e-7},
    "rolling 1e-5 m": {"rolling_resistance": 1e-5},
    "efficiency 0.8": {"generator_efficiency": 0.8},
    ALL: {name: value for name, value in VARIANTS["realistic"].items() if name in LINEAR},
}
"""One choice at a time, and those of the realistic variant together as far as they can be differentiated. At the size
of Table 1; `choices_of` has those of a device."""

OSCILLATIONS: tuple[Kind, ...] = ("Neimark-Sacker", "period doubling")
"""Where an oscillation begins to grow: at a frequency of its own, or where the symmetry fails at half the wave's."""

LEAST_DAMPING, MOST_DAMPING = -80.0, 40.0
"""Hinge damping between which the border is sought, at the size of Table 1. [Nms/rad]"""

SCALE_DAMPING = 20.0
"""Change of the hinge damping that counts as one, at the size of Table 1. [Nms/rad]"""

BELOW = 1.0
"""How far below the device's own damping the border is sought at least, at the size of Table 1. [Nms/rad]"""

CG_REACH = 2.0
"""Largest cg that is tried, over the capacity that the orbit's lock share tells."""

CC_RANGE = (0.005, 0.3)
"""Couplings in which the border is sought, at the size of Table 1. [Nms]"""

NUMBER = re.compile(r"[\d.]+(e-?\d+)?")


@dataclass(frozen=True)
class ChoiceMargins:
    """Orbit and borders of a plant with one choice on.

    Parameters
    ----------
    name : str
        The choice.
    status : str
        Of the orbit; without one every number is NaN.
    multiplier : float
        Modulus of the largest multiplier over a wave.
    slowest : str
        The mode that it is of.
    rate : float
        Growth rate of the phi1 mode. [1/s]
    damping_ratio : float
        Of the phi1 mode.
    frequency : float
        Of the phi1 mode. [rad/s]
    fold : float
        Largest cg with an orbit. [Nms]
    cg_end : float
        Largest cg up to which the orbit is stable: the fold, or where an oscillation begins to grow before it. [Nms]
    cg_ending : str
        How stability ends there.
    d1_border : float
        Neimark-Sacker border: hinge damping that the lock needs; negative where it stands that much negative damping.
        [Nms/rad]
    cc_border : float
        The same in the coupling: least cc with a stable lock; NaN where none was met. [Nms]
    power : float
        Mean electrical power. [W]
    wp_end : float
        Lowest frequency of the wave down to which the orbit is stable; NaN where none was met. [rad/s]
    wp_ending : str
        How stability ends there.
    """

    name: str
    status: str
    multiplier: float = math.nan
    slowest: str = ""
    rate: float = math.nan
    damping_ratio: float = math.nan
    frequency: float = math.nan
    fold: float = math.nan
    cg_end: float = math.nan
    cg_ending: str = ""
    d1_border: float = math.nan
    cc_border: float = math.nan
    power: float = math.nan
    wp_end: float = math.nan
    wp_ending: str = ""

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return asdict(self)


def choices_of(plant: Plant) -> dict[str, dict[str, Any]]:
    """Return `CHOICES` at the length of a device, each with its own number in the name."""
    length = plant.parameters.length_scale
    if length == 1.0:
        return CHOICES
    return {_renamed(name, own): own for name, own in ((name, grown(of, length)) for name, of in CHOICES.items())}


def couplings_around(asked: Request) -> tuple[float, float]:
    """Couplings in which a border is sought, the pair's own among them. [Nms]"""
    low, high = at_length(CC_RANGE, "Nms", asked.plant.parameters.length_scale)
    return min(low, asked.cc), max(high, asked.cc)


def linear_plant(plant: Plant) -> Plant:
    """Return a plant with every choice beyond the linear model off."""
    return plant.replace(**LINEAR)


def with_choices(plant: Plant, name: str) -> Plant:
    """Return the linear plant with the named choices of `choices_of` on, as far as they can be differentiated."""
    return linear_plant(plant).replace(**choices_of(plant)[name]).smooth


def of_choice(asked: Request, name: str) -> ChoiceMargins:
    """Measure the plant of a request with one of `choices_of` on and all others off, at its wave and controls."""
    plant = with_choices(asked.plant, name)
    orbit = lock_orbit(plant, asked.wave, asked.cc, asked.cg, asked.sense, nearest=False)
    if orbit.status == "no orbit":
        return ChoiceMargins(name, orbit.status)
    mode, slowest = orbit.mode("horizontal"), orbit.modes[0]
    stable = orbit.status == "stable"
    over_cg = continue_orbit(orbit, "cg", (0.0, CG_REACH * orbit.cg / min(orbit.lock_share, 1.0)), OPTIONS)
    over_cc = continue_orbit(orbit, "cc", couplings_around(asked), OPTIONS)
    room = headroom(orbit, asked.wave, "cg", True) if stable else None
    down = headroom(orbit, asked.wave, "wp", False) if stable else None
    return ChoiceMargins(
        name,
        orbit.status,
        multiplier=float(np.abs(orbit.multipliers[0])),
        slowest=slowest.name,
        rate=mode.rate,
        damping_ratio=-mode.rate / math.hypot(mode.rate, mode.frequency),
        frequency=mode.frequency,
        fold=min((point.value for point in over_cg.folds if point.value > orbit.cg), default=math.nan),
        cg_end=room.reached if room is not None else math.nan,
        cg_ending=room.ending if room is not None else "",
        d1_border=damping_border(orbit),
        cc_border=nearest(over_cc, OSCILLATIONS, orbit.cc, stable),
        power=orbit.power * plant.parameters.generator_efficiency,
        wp_end=down.reached if down is not None else math.nan,
        wp_ending=down.ending if down is not None else "",
    )


def damping_border(orbit: PeriodicOrbit) -> float:
    """Hinge damping d1 at which an oscillation begins to grow, also below zero; NaN where none is met. [Nms/rad]"""
    over = OrbitMap(orbit.plant, orbit.wave, orbit.cc, orbit.cg, orbit.sense, orbit.dt, ("d1",))
    unit = growth("Nms/rad", orbit.plant.parameters.length_scale)
    limits = (min(LEAST_DAMPING * unit, orbit.plant.parameters.d1 - BELOW * unit), MOST_DAMPING * unit)
    scaled, start = scaled_by_orbit(over, orbit, SCALE_DAMPING * unit)
    branch = continue_fixed_point(scaled, start, limits, OPTIONS)
    return nearest(branch, OSCILLATIONS, orbit.plant.parameters.d1, orbit.status == "stable")


def nearest(branch: Branch, kinds: tuple[Kind, ...], own: float, stable: bool) -> float:
    """Nearest point of some kinds below the own value of a stable orbit, or above that of an unstable one, or NaN."""
    points = [point for kind in kinds for point in branch.of_kind(kind)]
    below = [point.value for point in points if (point.value < own) == stable]
    return (max(below) if stable else min(below)) if below else math.nan


def shift(value: float, linear: float) -> float:
    """Relative shift of a number from that of the linear plant. [1]"""
    return value / linear - 1.0


def most(found: Mapping[str, ChoiceMargins]) -> dict[str, str]:
    """The single choice that moves each number most, by "fold", "neimark_sacker", "phi1_damping" and "frequency"."""
    linear, single = found["linear"], {name: one for name, one in found.items() if name not in ("linear", ALL)}

    def largest(number: Callable[[ChoiceMargins], float]) -> str:
        moved = {name: abs(number(one) - number(linear)) for name, one in single.items()}
        known = {name: value for name, value in moved.items() if math.isfinite(value) and value > 0.0}
        return max(known, key=lambda name: known[name]) if known else ""

    return {
        "fold": largest(lambda one: one.fold),
        "neimark_sacker": largest(lambda one: one.d1_border),
        "phi1_damping": largest(lambda one: one.rate),
        "frequency": largest(lambda one: one.wp_end),
    }


def in_words(found: Mapping[str, ChoiceMargins]) -> str:
    """What the table says, in a few sentences."""
    linear, told = found["linear"], most(found)
    parts = []
    if name := told["fold"]:
        parts.append(f"{_called(name)} moves the fold most, by {100.0 * shift(found[name].fold, linear.fold):+.1f} %")
    if name := told["neimark_sacker"]:
        one = found[name]
        parts.append(
            f"{_called(name)} moves the Neimark-Sacker border most: the lock needs a hinge damping of "
            f"{one.d1_border:.3g} Nms/rad in place of {linear.d1_border:.3g}"
            + (", that is none: it would stand as much negative damping" if one.d1_border < 0.0 else "")
        )
    if name := told["phi1_damping"]:
        one = found[name]
        parts.append(
            f"{_called(name)} damps phi1 most, with {100.0 * one.damping_ratio:.2g} % of critical in place of "
            f"{100.0 * linear.damping_ratio:.2g} %"
        )
    if name := told["frequency"]:
        one = found[name]
        parts.append(
            f"{_called(name)} moves the lowest frequency with a stable lock most, from {linear.wp_end:.3g} to "
            f"{one.wp_end:.3g} rad/s, where it ends by {_process(one.wp_ending)}"
        )
    if (together := found.get(ALL)) is not None and math.isfinite(together.fold):
        parts.append(
            f"all smooth ones together move the fold by {100.0 * shift(together.fold, linear.fold):+.1f} % and the "
            f"border to {together.d1_border:.3g} Nms/rad; the lowest frequency is {together.wp_end:.3g} rad/s then, by "
            f"{_process(together.wp_ending)}"
        )
    return ". ".join(_capital(part) for part in parts) + "." if parts else "No choice has an orbit."


def _renamed(name: str, own: Mapping[str, Any]) -> str:
    """Name of a single choice with its own number."""
    number = next((value for value in own.values() if isinstance(value, float)), None)
    return name if number is None or name == ALL else NUMBER.sub(f"{number:.3g}", name, count=1)


def _process(ending: str) -> str:
    return f"a {ending}" + (" bifurcation" if ending == "Neimark-Sacker" else "")


def _called(name: str) -> str:
    return f"{name} alone"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
