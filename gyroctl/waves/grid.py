"""The time grid of a realisation and the frequency grid that belongs to it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.waves.checks import DURATION_MAX, positive

BASE_PERIOD = 2000.0
"""Repetition period of a sea of up to that length; like all times here that of a device of the size of Table 1 [s]."""

BASE_HARMONICS = 4000
"""Harmonics of the base period, (41): they reach 12.566 rad/s."""

OMEGA_MAX = 2.0 * math.pi * BASE_HARMONICS / BASE_PERIOD
"""Highest frequency of a synthesised sea [rad/s]."""


STEP = 0.05
"""Wave step where none is asked for: 40 to a wave of 3.14 rad/s. [s]"""

STEP_MIN = 1e-3
"""Shortest wave step: three hundred to the shortest wave. [s]"""


class TimeGrid(NamedTuple):
    """Sampling instants ``0, dt, .., duration`` of a sea that repeats after `period`.

    The period is 2000 s for any duration up to that, so a seed gives the same sea whatever the duration, and a
    shorter duration is a prefix of a longer one. Beyond 2000 s it is the next multiple of 2000 s, with as many more
    harmonics at a finer step: another sea for the same seed, because a sea that repeats would count its waves twice.
    """

    duration: float  # [s]
    dt: float  # [s]
    n: int  # instants, both ends included
    multiple: int  # period in units of the base period
    unit: float = 1.0  # of time of the device over that of Table 1: base period and frequency cut are in it [-]

    @property
    def period(self) -> float:
        """Repetition period [s]."""
        return BASE_PERIOD * self.unit * self.multiple

    @property
    def omega_max(self) -> float:
        """Highest frequency of a synthesised sea [rad/s]."""
        return OMEGA_MAX / self.unit

    @property
    def steps(self) -> int:
        """Steps of `dt` in one period."""
        return round(self.period / self.dt)

    @property
    def harmonics(self) -> NDArray[np.float64]:
        """Frequencies of the harmonics, without zero [rad/s]."""
        return 2.0 * np.pi / self.period * np.arange(1, BASE_HARMONICS * self.multiple + 1, dtype=np.float64)

    @property
    def time(self) -> NDArray[np.float64]:
        """Sampling instants, shape (n,) [s]."""
        return self.dt * np.arange(self.n, dtype=np.float64)


def time_grid(duration: float, dt: float | None = None, unit: float = 1.0) -> TimeGrid:
    """Grid of a run.

    Parameters
    ----------
    duration : float
        Length. At the size of Table 1 it is a multiple of the step; of a device of another size, whose step is no
        round number, it ends at the first instant of the grid that is not before. [s]
    dt : float, optional
        Step; 0.05 s at the size of Table 1. [s]
    unit : float
        Unit of time of the device over that of Table 1, see `Parameters.time_scale`. [-]

    Raises
    ------
    InputError
        Field ``run.dt``: not positive, does not divide 2000 s, or too coarse for the highest harmonic.
        Field ``run.duration``: not positive or not a multiple of `dt`.
    """
    base, cut, least = BASE_PERIOD * unit, OMEGA_MAX / unit, STEP_MIN * unit
    mend = f"Give a wave step below {0.25 * unit:.4g} s that divides {base:.6g} s, for example {STEP * unit:.4g}"
    step = positive("run.dt", STEP * unit if dt is None else dt, mend)
    per_base = base / step
    if step < least:
        raise InputError("run.dt", dt, f"the wave step must be at least {least:g} s", mend)
    if step >= math.pi / cut:
        raise InputError("run.dt", dt, f"is too coarse for waves up to {cut:.3f} rad/s", mend)
    if abs(per_base - round(per_base)) > 1e-6:
        raise InputError("run.dt", dt, f"must divide the wave period of {base:g} s", mend)
    step = base / round(per_base)
    mend = f"Give a duration in seconds that is a multiple of the wave step {step:g} s, for example 600"
    length = positive("run.duration", duration, mend)
    if length > DURATION_MAX * max(unit, 1.0):
        raise InputError("run.duration", duration, f"must be at most {DURATION_MAX * max(unit, 1.0):g} s", mend)
    count = round(length / step)
    if abs(length / step - count) > 1e-6 and unit != 1.0:
        count = math.ceil(length / step)
    if count < 1 or (unit == 1.0 and abs(length / step - count) > 1e-6):
        raise InputError("run.duration", duration, f"must be a multiple of the wave step {step:g} s", mend)
    return TimeGrid(count * step, step, count + 1, math.ceil(count / round(per_base)), unit)
