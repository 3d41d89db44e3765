"""A closed loop whose actuators are states of their own, by SciPy's DOP853: it shares no text with the harness's loop.

An actuator obeys u' = (aim - u)/T, limited to -r..r; without a lag it runs at its rate, and stops at the aim. The
moments are interpolated by a polynomial through eleven samples of their grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

PERIOD = 0.1
NEAR = (4, 7)  # samples of the moments before and after an interval that its polynomial passes through


class SlowActuator(NamedTuple):
    """Time constant [s] and largest rate [Nms/s] of an actuator, 0 for none."""

    lag: float = 0.0
    rate: float = 0.0

    def speed(self, gap: float) -> float:
        """Rate of change at a distance `gap` from the aim. [Nms/s]"""
        if self.lag > 0.0:
            free = gap / self.lag
            return math.copysign(min(abs(free), self.rate), gap) if self.rate > 0.0 else free
        return math.copysign(self.rate, gap) if gap != 0.0 else 0.0

    def bend(self, gap: float) -> float:
        """Time until its course bends: the end of the ramp. [s]"""
        return max(abs(gap) / self.rate - self.lag, 0.0) if self.rate > 0.0 else 0.0

    @property
    def jumps(self) -> bool:
        """Whether it has neither a lag nor a largest rate."""
        return self.lag == 0.0 and self.rate == 0.0


class Course(NamedTuple):
    """States (n + 1, rows) and controls (n + 1, 2) at the samples; integrals up to each sample (n + 1, 3).

    The integrals are those of the power of the generator [J], of its square [W J] and of the power lost in slip [J].
    """

    states: Array
    controls: Array
    integrals: Array


def run_slow(
    plant: Any,
    actuators: Sequence[SlowActuator],
    command: Callable[[int, Array], tuple[float, float]],
    start: Array,
    before: tuple[float, float],
    moments: Array,
    grid: float,
    samples: int,
) -> Course:
    """Run the loop.

    Parameters
    ----------
    plant : Plant
        Its `derivative` alone is used.
    actuators : two SlowActuator
        Of cc and cg.
    command : callable
        Sample and state of the plant to the controls that are asked for from then on. [Nms]
    start, before : (n,) array, pair of float
        State and controls at the start.
    moments, grid : (2, m) array, float
        Moments [Nm] and the spacing of their samples [s].
    samples : int
        Intervals of 0.1 s.
    """
    n = start.size
    y = np.concatenate([start, before, np.zeros(3)])
    course = [y]
    for sample in range(samples):
        aim = command(sample, y[:n].copy())
        y = y.copy()
        for channel, actuator in enumerate(actuators):
            if actuator.jumps:
                y[n + channel] = aim[channel]
        begin = sample * PERIOD
        first = round(begin / grid)
        near = slice(max(first - NEAR[0], 0), first + NEAR[1])
        time = np.arange(moments.shape[1])[near] * grid
        fits = [np.polynomial.Polynomial.fit(time, moment[near], time.size - 1) for moment in moments]
        bends = [a.bend(aim[i] - y[n + i]) for i, a in enumerate(actuators)]
        ends = sorted({*(bend for bend in bends if 1e-12 < bend < PERIOD), PERIOD})
        since = 0.0
        for until in ends:
            moving = [bends[i] > since + 1e-12 or a.lag > 0.0 for i, a in enumerate(actuators)]

            def rate(t: float, y: Array, aim: Any = aim, moving: Any = moving, fits: Any = fits) -> Array:
                cc, cg = y[n], y[n + 1]
                dx = plant.derivative(y[:n], (cc, cg), [fit(t) for fit in fits])
                speeds = [a.speed(aim[i] - y[n + i]) if moving[i] else 0.0 for i, a in enumerate(actuators)]
                power = cg * y[7] ** 2
                slip = cc * (y[7] - plant.parameters.N * y[6]) ** 2
                return np.concatenate([np.asarray(dx, float), speeds, [power, power**2, slip]])

            span = (begin + since, begin + until)
            y = solve_ivp(rate, span, y, "DOP853", rtol=1e-10, atol=1e-12, max_step=0.05).y[:, -1]
            for i, actuator in enumerate(actuators):
                if actuator.lag == 0.0 and not actuator.jumps and bends[i] <= until:
                    y[n + i] = aim[i]
            since = until
        course.append(y)
    found = np.array(course)
    return Course(found[:, :n], found[:, n : n + 2], found[:, n + 2 :])
