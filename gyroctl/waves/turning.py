"""A sea whose heading turns: every wave keeps its height, frequency and phase at the float, and changes its direction.

A float that is small beside the distance in which the direction changes feels, at each instant, the transfer from wave
to moment at the heading of that instant: the turn takes minutes, the transfer has a memory of a second or two. Between
headings that are a few degrees apart the transfer is linear, so that the signals are those of a few seas of fixed
headings with the same phases, blended with weights that add up to 1. The elevation at the float does not depend on the
heading at all, and is that of the sea that does not turn, to the last digits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import DURATION_MAX, at_most, finite, heading_angle, store
from gyroctl.waves.spectrum import SeaState

SPACING = 5.0
"""Largest difference of two headings between which the transfer is taken as linear: it is so to a thousandth. [deg]"""

SLOWEST = 3.0
"""Least time in which the heading may turn by one degree: half a minute for ten, some fifteen waves. [s/deg]"""


@pictured(sea_face)
@dataclass(frozen=True)
class TurningSea:
    """An irregular sea whose heading turns evenly from one direction to another and then stays.

    Parameters
    ----------
    hs : float
        Significant wave height. [m]
    wp : float
        Peak frequency. [rad/s]
    gamma : float
        Peak enhancement factor, at least 1. [-]
    heading : float
        Direction the waves travel to at the beginning. [deg]
    heading_end : float
        And at the end of the turn. [deg]
    over : float
        Length of the turn. [s]

    Raises
    ------
    InputError
        Fields ``sea.hs``, ``sea.wp``, ``sea.gamma``, ``sea.heading``, ``sea.heading_end``, ``sea.over``.
    """

    hs: float = 0.283
    wp: float = 3.14
    gamma: float = 5.0
    heading: float = 0.0
    heading_end: float = 20.0
    over: float = 500.0

    def __post_init__(self) -> None:
        """Check every field and store it as a float."""
        sea = SeaState(self.hs, self.wp, self.gamma, self.heading)
        try:
            end = heading_angle(self.heading_end)
        except InputError as error:
            raise InputError("sea.heading_end", error.value, error.problem, error.mend) from None
        over = finite("sea.over", self.over, "Give the length of the turn in seconds, for example 500")
        least = SLOWEST * abs(end - sea.heading)
        if over < least or over <= 0.0:
            mend = f"Give at least {max(least, 1.0):.4g} s"
            raise InputError("sea.over", self.over, "is too short for waves that turn slowly", mend)
        at_most("sea.over", over, 10.0 * DURATION_MAX, "s")
        store(self, hs=sea.hs, wp=sea.wp, gamma=sea.gamma, heading=sea.heading, heading_end=end, over=over)

    @property
    def still(self) -> SeaState:
        """The sea as it is at the beginning, without the turn."""
        return SeaState(self.hs, self.wp, self.gamma, self.heading)

    @property
    def headings(self) -> tuple[float, ...]:
        """Headings whose signals are blended, in order. [deg]"""
        count = 1 + max(1, math.ceil(abs(self.heading_end - self.heading) / SPACING - 1e-9))
        return tuple(float(angle) for angle in np.linspace(self.heading, self.heading_end, count))

    def weights(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weight of each heading, shape (headings, n), at `time` (n,) [s]; they add up to 1."""
        count = len(self.headings)
        position = np.clip(time / self.over, 0.0, 1.0) * (count - 1)
        return np.asarray(np.maximum(1.0 - np.abs(position[None, :] - np.arange(count)[:, None]), 0.0))
