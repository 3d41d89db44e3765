"""A sea whose peak frequency drifts: stationary seas one after the other, each faded slowly into the next.

The fades are of equal power, ``cos^2 + sin^2 = 1``, and the stages are independent of each other, so the sea has its
significant height at every instant. A stage and the next overlap in frequency as long as they are closer than the
peak is wide, and then the spectrum has one peak that moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import DURATION_MAX, FREQUENCY_MAX, at_most, finite, positive, store
from gyroctl.waves.spectrum import SeaState
from gyroctl.waves.superposition import Superposition

SPACING = 0.1
"""Largest difference of the peak frequencies of two stages; the peak of a sea of gamma 5 is twice as wide. [rad/s]"""


@pictured(sea_face)
@dataclass(frozen=True)
class DriftingSea:
    """An irregular sea whose peak frequency moves evenly from one value to another and then stays.

    Parameters
    ----------
    hs : float
        Significant wave height, the same at every instant. [m]
    wp : float
        Peak frequency at the beginning; start and lock are judged by it. [rad/s]
    wp_end : float
        Peak frequency at the end of the drift. [rad/s]
    gamma : float
        Peak enhancement factor, at least 1. [-]
    over : float
        Length of the drift. [s]
    heading : float
        Direction the waves travel to. [deg]

    Raises
    ------
    InputError
        Fields ``sea.hs``, ``sea.wp``, ``sea.wp_end``, ``sea.gamma``, ``sea.over``, ``sea.heading``.
    """

    hs: float = 0.283
    wp: float = 2.8
    wp_end: float = 3.5
    gamma: float = 5.0
    over: float = 2000.0
    heading: float = 0.0

    def __post_init__(self) -> None:
        """Check every field and store it as a float."""
        first = SeaState(self.hs, self.wp, self.gamma, self.heading)
        end = positive("sea.wp_end", self.wp_end, "Give the last peak frequency in rad/s, for example 3.5")
        at_most("sea.wp_end", end, FREQUENCY_MAX, "rad/s")
        over = finite("sea.over", self.over, "Give the length of the drift in seconds, for example 2000")
        least = 100.0 * abs(end - first.wp) / SPACING  # 100 s a stage: twenty waves, so that a fade turns no phase
        if over < least or over <= 0.0:
            mend = f"Give at least {max(least, 1.0):.4g} s"
            raise InputError("sea.over", self.over, "is too short for waves that only drift", mend)
        at_most("sea.over", over, 10.0 * DURATION_MAX, "s")
        store(self, hs=first.hs, wp=first.wp, wp_end=end, gamma=first.gamma, over=over, heading=first.heading)

    @property
    def stages(self) -> tuple[SeaState, ...]:
        """The stationary seas, in order."""
        count = max(2, 1 + int(np.ceil(abs(self.wp_end - self.wp) / SPACING - 1e-9)))
        peaks = np.linspace(self.wp, self.wp_end, count)
        return tuple(SeaState(self.hs, float(wp), self.gamma, self.heading) for wp in peaks)

    def windows(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weight of each stage, shape (stages, n), at `time` (n,) [s]; the squares add up to 1."""
        count = len(self.stages)
        position = np.clip(time / self.over, 0.0, 1.0) * (count - 1)
        distance = np.abs(position[None, :] - np.arange(count)[:, None])
        return np.asarray(np.where(distance < 1.0, np.cos(0.5 * np.pi * np.minimum(distance, 1.0)), 0.0))


@dataclass(frozen=True, eq=False)
class FadedSum:
    """Stages of waves, each summed alone and weighted in time.

    The moments are those of the stages, weighted: as the transfer from waves to moments has a memory of a second or two
    and a fade takes minutes, that is the transfer of the faded waves to better than a hundredth.

    Parameters
    ----------
    stage : Superposition
        Sums one stage; all have the same frequencies.
    windows : ndarray, shape (stages, n)
        Weights in time.
    """

    stage: Superposition
    windows: NDArray[np.float64]

    def __call__(self, coefficients: NDArray[np.complex128], out: NDArray[np.float64]) -> None:
        """Write the sums into `out`; see `Superposition`."""
        parts = np.split(coefficients, self.windows.shape[0], axis=1)
        alone = np.empty_like(out)
        out[:] = 0.0
        for part, window in zip(parts, self.windows, strict=True):
            if np.any(window):
                self.stage(part, alone)
                out += window * alone
