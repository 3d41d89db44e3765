"""How large a run is, before it is made: a slip in a unit shows here and not in hours or terabytes."""

from __future__ import annotations

from typing import NamedTuple

from gyroctl.errors import InputError
from gyroctl.waves.checks import DURATION_MAX, within

SAMPLES_MAX, STEPS_MAX = 2_000_000, 200_000_000
"""Samples of a run, some 300 bytes each, and its Runge-Kutta steps, some microseconds each."""

DT = (1e-5, 1.0)
"""Least and largest step that can be asked for of any device. [s]"""

COARSEST = 0.1
"""And the largest of a device of the size of Table 1, a twentieth of its wave; the slip of the coupling asks for less.
A longer one would ask for so little accuracy that it is a slip in the unit. [s]"""


class RunSize(NamedTuple):
    """Samples and Runge-Kutta steps of one run."""

    samples: int
    steps: int


def run_size(duration: float, dt: float, period: float, time_scale: float = 1.0) -> RunSize:
    """Size of a run of `duration` [s] in steps of `dt` [s], sampled every `period` [s].

    `time_scale` is the unit of time of the device over that of Table 1, see `Parameters.time_scale`. [-]

    Raises
    ------
    InputError
        Fields ``run.duration``, ``run.dt``: out of bounds, or too much for one run together.
    """
    length = within("run.duration", duration, 0.0, DURATION_MAX, "Give seconds, for example 2000")
    coarsest = COARSEST * time_scale
    step = within("run.dt", dt, *DT, "Give the step in seconds, for example 0.01")
    if step > coarsest * (1.0 + 1e-9):
        mend = f"Give at most {coarsest:.3g} s; {0.1 * coarsest:.3g} s is usual"
        raise InputError("run.dt", dt, "is too coarse a step for the waves of this device", mend)
    size = RunSize(round(length / period), round(length / min(step, period)))
    if size.samples > SAMPLES_MAX:
        mend = f"Give at most {SAMPLES_MAX * period:g} s, or a longer actuators.period"
        raise InputError("run.duration", duration, f"makes {size.samples:.2g} samples of {period:g} s", mend)
    if size.steps > STEPS_MAX:
        mend = f"Give at least {length / STEPS_MAX:.2g} s, or a shorter run.duration"
        raise InputError("run.dt", dt, f"makes {size.steps:.2g} steps", mend)
    return size
