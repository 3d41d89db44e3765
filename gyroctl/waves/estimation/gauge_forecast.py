"""Forecast from a gauge up-wave and the sensors together: one Gaussian estimate of the waves that both have seen.

What the readings tell of the amplitudes (`gauge_readings`) and the moments that the float felt where it was (`placed`)
are rows of one regression, in which a bin has one complex amplitude. The estimate given both is the best one, and gives
the moments ahead with their variance.

Where the gauge truly stands is learnt. If it is off by some way, waves at the float are turned by k times that against
what the gauge says; so every few seconds the likelihood of the moments is asked for a little nearer and a little
farther, and the place takes a Newton step (`find_place`). Waves that come at an angle are, to the gauge, a shorter way.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import stamped
from gyroctl.waves.estimation import gauge_readings
from gyroctl.waves.estimation.gauge_readings import APART, GaugeForecast, GaugeState
from gyroctl.waves.estimation.moment_model import Array
from gyroctl.waves.estimation.placed import (
    add_normal_equations,
    factorise_upper,
    foresee_waves,
    known_of,
    observe_waves,
)

SOURCES = (*gauge_readings.SOURCES, __file__)

MOST = 0.1
"""Longest step of the place; its likelihood is compared `APART` to both sides. [m]"""

REMEMBERED = 0.96
"""Part of what is known of the place that is left at the next step. [-]"""


@stamped(SOURCES)
def predict_from_gauge(
    c: GaugeForecast,
    state: GaugeState,
    values: Array,
    last: int,
    steps: int,
    history: Array,
    samples: int,
    now: Array,
    out: NDArray[np.float64],
) -> bool:
    """Write the moments at rest (2, n) at 1 .. n steps ahead, and those of now into `now` (2,). [Nm]

    Parameters
    ----------
    c, state
        Constants, and what was prepared; `state.waves.spread` holds the deviations afterwards.
    values : (any,) array
        Readings. [m]
    last : int
        The last of them that was read.
    steps : int
        Samples of the law since then.
    history : (past, 3) array
        Round buffer of the moments at the float [Nm] and of its place, see `predict_placed`.
    samples : int
        Moments observed so far.

    Returns
    -------
    bool
        False where nothing was written: too few readings, or one that is no number.
    """
    if (
        steps + max(out.shape[1], c.waves.far) >= c.waves.ahead.shape[2]
    ):  # the last reading is too old: none has come since
        return False
    if state.ready[0] == 0 or not all_read(c, values, last):
        return False
    twice, size = state.root.size, 2 * known_of(c.waves, samples)
    A, y, U, z = np.empty((size, twice)), np.empty(size), np.empty((twice, twice)), np.empty(twice)
    reckon(c, state, 0.0, values, last, steps, history, samples, A, y, U, z)
    foresee_waves(c.waves, state.waves, state.root, A, y, U, z, steps, samples, now, out)
    return True


@stamped(SOURCES)
def find_place(
    c: GaugeForecast, state: GaugeState, values: Array, last: int, steps: int, history: Array, samples: int
) -> None:
    """Take a step to where moments and readings are most likely together; arguments as of `predict_from_gauge`.

    What was prepared stays that of the place before: `prepare` is due.
    """
    if state.ready[0] == 0 or not all_read(c, values, last):
        return
    twice, size, cost = state.root.size, 2 * known_of(c.waves, samples), np.zeros(3)
    A, y, U, z = np.empty((size, twice)), np.empty(size), np.empty((twice, twice)), np.empty(twice)
    for i in range(3):
        reckon(c, state, (i - 1) * APART, values, last, steps, history, samples, A, y, U, z)
        factorise_upper(U)
        for r in range(twice):  # U' w = z: less w' w / 2, as far as it depends on the place
            z[r] /= U[r, r]
            for s in range(r + 1, twice):
                z[s] -= U[r, s] * z[r]
            cost[i] += math.log(U[r, r]) - 0.5 * z[r] * z[r]
    slope = (cost[2] - cost[0]) / (2.0 * APART)
    bend = (cost[2] - 2.0 * cost[1] + cost[0]) / APART**2
    state.place[1] = max(REMEMBERED * state.place[1] + max(bend, 0.0), c.trust)
    step = (slope + (1.0 - REMEMBERED) * c.trust * state.place[0]) / state.place[1]
    state.place[0] -= min(max(step, -MOST), MOST)
    state.place[0] = min(max(state.place[0], -c.bound), c.bound)


@stamped(SOURCES)
def all_read(c: GaugeForecast, values: Array, last: int) -> bool:
    """Whether there are readings enough, and all of them numbers."""
    n = c.own.size
    if last < n - 1:
        return False
    missing = 0
    for age in range(n):
        if not math.isfinite(values[last - age]):
            missing += 1
    return missing == 0


@stamped(SOURCES)
def reckon(
    c: GaugeForecast,
    state: GaugeState,
    off: float,
    values: Array,
    last: int,
    steps: int,
    history: Array,
    samples: int,
    A: Array,
    y: Array,
    U: Array,
    z: Array,
) -> None:
    """Write the normal equations U, z of readings and moments, were the gauge `off` farther than it was found. [m]

    The phases of the amplitudes are those at the last reading; A and y are as of `observe_waves`.
    """
    turn, n = np.empty(c.omega.size), c.own.size
    for b in range(turn.size):
        turn[b] = c.omega[b] * c.step * steps - c.k[b] * off
    observe_waves(c.waves, state.waves.misfit, state.root, turn, history, samples, A, y)
    for r in range(z.size):
        told = state.told[r]
        z[r] = 0.0
        for age in range(n):
            z[r] += told[age] * values[last - age]
        for s in range(r, z.size):
            U[r, s] = state.precision[r, s]
    add_normal_equations(A, y, U, z)
