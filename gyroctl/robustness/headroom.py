"""Headroom: how far cg, the wave height and its frequency may move before the locked orbit is lost.

For constant controls the stable orbit is followed with exact multipliers to where it ends, which also says how it
ends. For a law in the loop, and to confirm the former without any orbit, the quantity is moved slowly in one plain
simulation until the ring falls out of step.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.protocol import Law, Measurement
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.search import search_orbit
from gyroctl.plant.equations import PSI
from gyroctl.robustness.regime import Excite, Regime, simulate
from gyroctl.waves import Regular
from gyroctl.waves.channels import transfers

Quantity = Literal["cg", "height", "wp"]
Ending = Literal[
    "fold", "Neimark-Sacker", "period doubling", "none in range", "lost in a slow ramp", "end of the table"
]
RAMPED: tuple[Ending, ...] = ("lost in a slow ramp", "none in range")
"""Endings that a slow ramp of a law can tell."""

ACCURACY = 1e-4
"""Of the end of the orbit, relative. [-]"""

GROWTH = 1.3
"""Ratio of successive values while the end is sought."""

LEAST_CG = 1e-6
"""Gain from which the end of an orbit without load is sought, at the size of Table 1. [Nms]"""

RAMP = 600
"""Waves over which a slow ramp goes from one end of its range to the other."""


class Headroom(NamedTuple):
    """Room between a value and the end of the lock.

    Parameters
    ----------
    quantity : {"cg", "height", "wp"}
        What is moved.
    value, limit : float
        Where it is and where lock ends; the limit is infinite where none was met. [Nms, m or rad/s; - of a law's cg]
    ending : str
        How lock ends there.
    """

    quantity: str
    value: float
    limit: float
    ending: Ending

    @property
    def reached(self) -> float:
        """The limit, NaN where none was met within the range that was tried."""
        return self.limit if math.isfinite(self.decibel) else math.nan

    @property
    def relative(self) -> bool:
        """Whether value and limit are factors on the cg of a law."""
        return self.quantity == "cg" and self.value == 1.0 and self.ending in RAMPED

    @property
    def decibel(self) -> float:
        """Room as a ratio, positive whichever way the limit lies. [dB]"""
        if self.value == 0.0 or self.limit == 0.0 or not math.isfinite(self.limit):
            return math.inf
        return abs(20.0 * math.log10(self.limit / self.value))


def headroom(orbit: Orbit, wave: Regular, quantity: Quantity, upwards: bool, reach: float = 30.0) -> Headroom:
    """Follow the stable orbit until it ends.

    Parameters
    ----------
    orbit : Orbit
        A stable orbit.
    wave : Regular
        Its wave.
    quantity : {"cg", "height", "wp"}
        What is moved; everything else stays.
    upwards : bool
        Towards larger values.
    reach : float
        Largest ratio that is tried. [-]

    Raises
    ------
    InputError
        Where the orbit is not stable: an unstable orbit has no headroom.
    """
    if orbit.status != "stable":
        raise InputError("orbit", orbit.status, "has no headroom", orbit.advice)
    value = {"cg": orbit.cg, "height": wave.height, "wp": wave.wp}[quantity]
    limit, ending = _end(orbit, wave, quantity, upwards, reach)
    return Headroom(quantity, value, limit, ending)


def ramp(regime: Regime, quantity: Quantity, first: float, last: float, periods: int = RAMP) -> float:
    """Move a quantity slowly until the ring falls out of step; its value then, NaN where lock is kept to the end.

    Parameters
    ----------
    regime : Regime
        The lock at the beginning.
    quantity : {"cg", "height", "wp"}
        What is moved: the height or frequency of the wave, or a factor on the law's cg (relative to 1).
    first, last : float
        Values at the beginning and at the end; the former should be that of the regime. [m, rad/s or -]
    periods : int
        Length of the ramp: it is quasi-static, so the answer is late by a fraction of what passes in ten waves.
    """
    duration = periods * regime.period
    if quantity == "cg":
        scaled = _Scaled(regime.law, first, last, duration)
        run = simulate(regime, regime.x, periods, law=scaled)
    else:
        run = simulate(regime, regime.x, periods, excite=_moving(regime, quantity, first, last, duration))
    tick = regime.actuators.period
    lag = regime.sense * run.record[:, PSI] - run.phase - regime.angle
    # at the fold of a lock the ring stands a quarter turn or more behind; half a turn further it has fallen out
    out = ~(np.abs(lag) < 1.5 * math.pi)
    if not np.any(out):
        return math.nan
    return first + (last - first) * int(np.argmax(out)) * tick / duration


def _end(orbit: Orbit, wave: Regular, quantity: Quantity, upwards: bool, reach: float) -> tuple[float, Ending]:
    least = LEAST_CG * growth("Nms", orbit.plant.parameters.length_scale)
    value = {"cg": max(orbit.cg, least), "height": wave.height, "wp": wave.wp}[quantity]
    grow = 1.0 + (GROWTH - 1.0) * (0.15 if quantity == "wp" else 1.0)
    band = orbit.plant.excitation.omega
    inside, outside, kept = value, value, orbit
    failed: Orbit | None = None
    while failed is None:
        outside = inside * grow if upwards else inside / grow
        if quantity == "wp" and not band[0] < outside < band[-1]:
            return inside, "end of the table"
        if max(outside / value, value / outside) > reach:
            return math.inf if upwards else 0.0, "none in range"
        found = _at(kept, wave, quantity, outside)
        if found.status == "stable":
            inside, kept = outside, found
        else:
            failed = found
    while abs(outside - inside) > ACCURACY * inside:
        middle = 0.5 * (inside + outside)
        found = _at(kept, wave, quantity, middle)
        if found.status == "stable":
            inside, kept = middle, found
        else:
            outside, failed = middle, found
    return inside, _ending(kept, failed)


def _at(near: Orbit, wave: Regular, quantity: Quantity, value: float) -> Orbit:
    """Orbit at another value, from its neighbour; from scratch where that does not lead to a stable one."""
    cg = value if quantity == "cg" else near.cg
    height = value if quantity == "height" else wave.height
    wp = value if quantity == "wp" else wave.wp
    sea = Regular(height, wp, wave.heading)
    found = search_orbit(near.plant, sea, near.cc, cg, near.sense, guess=near.x)
    if found.status == "stable":
        return found
    again = search_orbit(near.plant, sea, near.cc, cg, near.sense)
    return again if found.status == "no orbit" or again.status == "stable" else found


def _ending(kept: Orbit, failed: Orbit) -> Ending:
    """How the last stable orbit ended: by the multiplier that left, or by a fold where no orbit is left."""
    largest = kept.multipliers[0]
    if failed.status == "unstable":
        largest = failed.multipliers[0]
    elif abs(largest.imag) > 1e-6 and abs(largest) < 0.9999:
        return "fold"
    if abs(largest.imag) > 1e-6:
        return "Neimark-Sacker"
    return "fold" if largest.real > 0.0 else "period doubling"


class _Scaled:
    """A law with its cg command multiplied by a factor that moves slowly."""

    def __init__(self, law: Law, first: float, last: float, duration: float) -> None:
        self.law, self.first, self.last, self.duration = law, first, last, duration
        self.period, self.information = law.period, law.information

    def init(self) -> Any:
        """Return the state of the law."""
        return self.law.init()

    def step(self, t: float, y: Measurement, state: Any) -> tuple[tuple[float, float], Any]:
        """Call the law and scale."""
        (cc, cg), new = self.law.step(t, y, state)
        return (cc, cg * (self.first + (self.last - self.first) * min(t / self.duration, 1.0))), new


def _moving(regime: Regime, quantity: Quantity, first: float, last: float, duration: float) -> Excite:
    """Signals of a wave whose height or frequency moves slowly."""
    wave = regime.wave

    def excite(time: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        part = np.minimum(time / duration, 1.0)
        now = first + (last - first) * part
        rate = now if quantity == "wp" else np.full(time.size, wave.wp)
        height = now if quantity == "height" else np.full(time.size, wave.height)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))])
        phase = regime.phase + turned
        amplitude = 0.5 * height * transfers(regime.plant, rate, wave.heading)
        return np.real(amplitude * np.exp(1j * phase)), phase

    return excite
