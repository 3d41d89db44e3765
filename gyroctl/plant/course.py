"""How the controls move within an interval: along a ramp, then along the exponential of a lag, to what is asked for.

An actuator with time constant T and largest rate r obeys u' = (aim - u)/T, limited to -r..r. While the aim is held its
answer has a closed form, so that it is evaluated at the instant of every Runge-Kutta stage, not integrated.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import inlined

FADED = 40.0
"""Time constants after which a lag has arrived: what is left of the way, exp(-40), is lost in rounding."""


class Course(NamedTuple):
    """Course of cc and cg from the start of an interval on, each (2,)."""

    begin: NDArray[np.float64]  # value at the start [Nms]
    aim: NDArray[np.float64]  # value that is asked for [Nms]
    slope: NDArray[np.float64]  # of the ramp, with its sign [Nms/s]
    turn: NDArray[np.float64]  # end of the ramp, after the start [s]
    lag: NDArray[np.float64]  # time constant [s]
    arrive: NDArray[np.float64]  # from when on the value is the aim, after the start [s]


@inlined
def set_out(course: Course, lag: Any, rate: Any, begin: Any, aim: Any) -> None:
    """Fill the course in place.

    Parameters
    ----------
    course : Course
        Is filled.
    lag, rate : (2,) arrays
        Time constants [s], largest rates of change [Nms/s]; 0 for none.
    begin, aim : (2,) arrays
        Values at the start, values asked for. [Nms]
    """
    for channel in range(2):
        gap = aim[channel] - begin[channel]
        ramp = rate[channel]
        slope, turn = 0.0, 0.0
        if ramp > 0.0 and abs(gap) > ramp * lag[channel]:  # the lag alone would be faster
            slope, turn = math.copysign(ramp, gap), abs(gap) / ramp - lag[channel]
        course.begin[channel], course.aim[channel] = begin[channel], aim[channel]
        course.slope[channel], course.turn[channel] = slope, turn
        course.lag[channel] = lag[channel]
        course.arrive[channel] = turn + FADED * lag[channel] if gap != 0.0 else 0.0


@inlined
def control_at(course: Course, channel: int, t: float) -> Any:
    """Value of a control `t` [s] after the start. [Nms]"""
    aim = course.aim[channel]
    if t >= course.arrive[channel]:
        return aim
    if t <= course.turn[channel]:
        return _ramp(course, channel, t)
    gap = _ramp(course, channel, course.turn[channel]) - aim
    return aim + gap * math.exp((course.turn[channel] - t) / course.lag[channel])


@inlined
def _ramp(course: Course, channel: int, t: float) -> Any:
    """Value on the ramp, never beyond the aim."""
    value, slope = course.begin[channel] + course.slope[channel] * t, course.slope[channel]
    if slope > 0.0:
        return min(value, course.aim[channel])
    return max(value, course.aim[channel]) if slope < 0.0 else value


@inlined
def next_bend(course: Course, since: float, hold: float) -> float:
    """Time after `since` at which a control ceases to be smooth, or the end `hold` of the interval. [s]"""
    until = hold
    for channel in range(2):
        for bend in (course.turn[channel], course.arrive[channel]):
            if since < bend < until:
                until = bend
    return until


@inlined
def lag_rate(course: Course, since: float) -> float:
    """Rate of the fastest lag that is under way `since` [s] after the start, 0 where none is. [1/s]"""
    fastest = 0.0
    for channel in range(2):
        if course.turn[channel] <= since < course.arrive[channel]:
            fastest = max(fastest, 1.0 / course.lag[channel])
    return fastest


@inlined
def effective(course: Course, channel: int, hold: float) -> Any:
    """Root of the mean square of a control over an interval of `hold` [s]. [Nms]"""
    aim, lag = course.aim[channel], course.lag[channel]
    if course.arrive[channel] <= 0.0:
        return aim
    turn = min(course.turn[channel], hold)
    begin, top = course.begin[channel], _ramp(course, channel, turn)
    total = turn * (begin * begin + begin * top + top * top) / 3.0
    rest = hold - turn
    total += rest * aim * aim
    if rest > 0.0 and lag > 0.0:
        gap, left = top - aim, math.exp(-rest / lag)
        total += lag * gap * (2.0 * aim * (1.0 - left) + 0.5 * gap * (1.0 - left * left))
    return math.sqrt(total / hold)
