"""The drag with which the lock needs no hinge damping: by multipliers in a regular wave, and counted in a sea."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.comparison.compare import compare
from gyroctl.comparison.items import Realisations
from gyroctl.errors import InputError
from gyroctl.harness.laws import law
from gyroctl.linearisation import lock_orbit
from gyroctl.orbits.bifurcation import curve
from gyroctl.orbits.continuation import continue_orbit
from gyroctl.plant import Plant
from gyroctl.statistics import Share, wilson
from gyroctl.studies.margins.request import Request
from gyroctl.studies.margins.water import OPTIONS, couplings_around, linear_plant
from gyroctl.waves import SeaState

MOST = 1.0
"""Largest drag that is tried. [-]"""

HEIGHTS = (0.3, 2.0)
"""Wave heights over which the drag is followed, over that of the request."""

SEEDS = tuple(range(1, 17))
"""Spent seeds: the count is a check, not a judgement."""

DURATION, GAMMA = 600.0, 5.0
"""Of the runs at the size of Table 1 [s], and of their sea."""


@dataclass(frozen=True)
class Curve:
    """Drag over another quantity at which an oscillation begins to grow, without hinge damping.

    Parameters
    ----------
    over : {"cc", "height"}
        The other quantity.
    at : (n,) array
        Its values. [Nms or m]
    drag : (n,) array
        The drag there. [-]
    """

    over: str
    at: NDArray[np.float64]
    drag: NDArray[np.float64]


@dataclass(frozen=True)
class DragLock:
    """Drag at which the multipliers of the orbit without hinge damping pass the unit circle.

    Parameters
    ----------
    drag : float
        The drag in the wave and at the controls asked for. [-]
    frequency : float
        Of the oscillation that grows below it. [rad/s]
    error : float
        Distance of the multiplier's modulus from one.
    at : dict
        cc [Nms] and height [m] asked for.
    curves : tuple of Curve
        The drag over them.
    """

    drag: float
    frequency: float
    error: float
    at: dict[str, float]
    curves: tuple[Curve, ...]

    def in_words(self) -> str:
        """What the number means."""
        return (
            f"Without hinge damping (d1 = 0) the lock in this regular wave is stable from a drag of Cd {self.drag:.3g} "
            f"on; below it an oscillation of {self.frequency:.3g} rad/s grows."
        )

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Counted:
    """Runs in a sea with a drag and no hinge damping."""

    drag: float  # [-]
    share: Share  # that kept the lock
    in_step: float  # share that kept their turns as well
    phi1_p98: float  # median over the runs [rad]

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        locked = round(self.share.value * self.share.runs)
        told = {"drag": self.drag, "locked": locked, "runs": self.share.runs}
        return {**told, "ci95": [self.share.low, self.share.high], "in_step": self.in_step, "phi1_p98": self.phi1_p98}


def duration_of(asked: Request) -> float:
    """Length of the runs in a sea. [s]"""
    return DURATION * asked.plant.parameters.time_scale


def undamped(plant: Plant, drag: float) -> Plant:
    """Return the linear plant with a drag and without hinge damping."""
    return linear_plant(plant).replace(d1=0.0, drag=drag)


def drag_that_locks(asked: Request) -> DragLock:
    """Find the drag with which the lock needs no hinge damping, by continuation in the drag.

    Raises
    ------
    InputError
        Where the lock needs no damping at all, or `MOST` is not enough.
    """
    orbit = lock_orbit(undamped(asked.plant, MOST), asked.wave, asked.cc, asked.cg, asked.sense)
    if orbit.status != "stable":
        raise InputError("drag", MOST, f"the lock without hinge damping is {orbit.status} even then", orbit.advice)
    pairs = continue_orbit(orbit, "drag", (0.0, MOST), OPTIONS).of_kind("Neimark-Sacker")
    if not pairs:
        raise InputError("cc", asked.cc, "the lock needs neither drag nor hinge damping here", "Lower cc")
    point, height = max(pairs, key=lambda pair: pair.value), asked.wave.height
    ranges = {"cc": couplings_around(asked), "height": (HEIGHTS[0] * height, HEIGHTS[1] * height)}
    lines = {over: curve(point, over, limits, OPTIONS, first_limits=(0.0, MOST)) for over, limits in ranges.items()}
    curves = tuple(Curve(over, line.second, line.first) for over, line in lines.items())
    return DragLock(point.value, point.frequency, point.error, {"cc": asked.cc, "height": height}, curves)


def counted_in_a_sea(
    asked: Request, drag: float, seeds: Sequence[int] = SEEDS, duration: float | None = None
) -> Counted:
    """Count the runs of the request's pair that keep the lock in seas of its height, without hinge damping.

    Their `duration` is `duration_of` where none is given. [s]
    """
    plant = undamped(asked.plant, drag)
    pair, duration = law("constant", device=plant, cc=asked.cc, cg=asked.cg), duration or duration_of(asked)
    sea = SeaState(asked.wave.hs, asked.wave.wp, GAMMA, asked.wave.heading)
    found = compare(plant, {"constant": pair}, Realisations(sea, tuple(seeds), duration), tuning_seeds=(), quiet=True)
    locked = int(found.locked.sum())
    motion = float(np.nanmedian(found.phi1_p98.values))
    return Counted(drag, wilson(locked, len(seeds)), float(found.in_step.mean()), motion)


def drags_to_count(critical: float) -> tuple[float, ...]:
    """Drags that are counted in a sea: none, parts and multiples of the critical one, a smooth float's, the most."""
    wanted = {0.0, 0.5 * critical, critical, 2.0 * critical, 5.0 * critical, 0.5, MOST}
    return tuple(sorted(round(drag, 6) for drag in wanted if drag <= MOST))
