"""A sample of the law, stage by stage: estimate, look ahead, command the power, pose the problem, act.

One text, run as Python or compiled, bit for bit alike. Constants and memory are nests of numbers and arrays, so that
both go into rows of numbers (`flat`); the memory is changed in place.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.foresight import between
from gyroctl.controllers.nmpc.power_command import PowerCommand, commanded
from gyroctl.controllers.nmpc.problem import Weights
from gyroctl.plant.compiled import inlined, put
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PSI
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation import EstimatorState, MomentEstimator, Predictor, PredictorState, predict, update
from gyroctl.waves.estimation.predictor import take

FloatArray = NDArray[np.float64]
Counts = NDArray[np.int64]

REACH = Weights._fields.index("reach")

PATIENCE = 10
"""Samples for which the rest of a good plan is followed when no new one comes."""

PAST = 60
"""Samples of the past that count for the reserve of lock: with the horizon about the ten seconds that judge a loss."""

GOOD, LATE, FAILED = 0, 1, 2
"""What became of a plan: it serves, came after the deadline, or is not of numbers."""

SOLVER, POWER, MEAN, CC, CG = range(5)
"""Numbers that the law remembers: of the solver, power and its slow mean [W], the last command [Nms]."""

SAMPLE, AGE, LATES, FAILURES, KEPT, FALLBACKS = range(6)
"""Counts: samples so far, samples since the last good plan, and what went otherwise than planned."""


class Constants(NamedTuple):
    """What the law goes by."""

    estimator: MomentEstimator
    predictor: Predictor
    command: PowerCommand
    rows: Counts  # of the plant's state that the model has
    h: FloatArray  # (1,) model step [s]
    k: FloatArray  # constants of the model
    weights: FloatArray  # fields of `Weights`
    period: float  # [s]
    horizon: float  # [s]
    reserve: float  # mean ring speed that past and horizon together are to keep [rad/s]
    cc_max: float  # [Nms]
    cg_max: float  # [Nms]
    fresh: float  # what a solver remembers that begins anew
    iterations: int  # of the solver, per plan
    replan: int  # samples from one plan to the next
    every: int  # plans from one that is begun elsewhere to the next
    retries: int  # iterations that it gets
    fallback: tuple[float, float]  # cc, cg [Nms]
    addresses: tuple[int, int, int, int, int]  # plan, two functions of the model, learn, clock; see `entry`


class Memory(NamedTuple):
    """What the law carries from sample to sample, and the room that it works in."""

    estimate: EstimatorState
    forecast: PredictorState
    plan: FloatArray  # (n,) couplings from the last sample on [Nms]
    numbers: FloatArray  # SOLVER .. CG
    angles: FloatArray  # (PAST,) of the ring at the last samples, oldest first [rad]
    counts: Counts  # SAMPLE .. FALLBACKS
    trial: FloatArray  # (n,) the plan that is worked on [Nms]
    other: FloatArray  # (n,) one that is begun elsewhere [Nms]
    ahead: FloatArray  # (2, n) moments at the end of each interval [Nm]
    moments: FloatArray  # (width (2 n + 1),) at each model step, see `prediction.width_of` [Nm, Nm/s]
    start: FloatArray  # state that a plan begins in
    now: FloatArray  # power [W], last coupling, its limit [Nms], control interval [s]
    weights: FloatArray  # fields of `Weights`
    result: FloatArray  # cost [J], what the solver remembers
    spent: Counts  # samples by the time they took, see `stopwatch`


def first_memory(c: Constants, pair: tuple[float, float], intervals: int, width: int, bins: int) -> Memory:
    """Memory before the first sample, of a law whose last command was a pair [Nms]."""
    n, new = intervals, np.zeros
    return Memory(
        c.estimator.init(),
        c.predictor.init(),
        np.full(n, pair[0]),
        np.array([c.fresh, c.command.power, c.command.power, *pair]),
        new(PAST),
        new(6, np.int64),
        new(n),
        new(n),
        new((2, n)),
        new(width * (2 * n + 1)),
        new(c.rows.size),
        new(4),
        new(c.weights.size),
        new(2),
        new(bins, np.int64),
    )


@inlined
def observed(c: Constants, w: Memory, y: Any) -> None:
    """Estimate the state."""
    w.counts[SAMPLE] += 1
    update(c.estimator, w.estimate, y, w.numbers[CC], w.numbers[CG])
    total = 0.0
    for i in range(w.estimate.x_hat.size):
        total += w.estimate.x_hat[i]
    if not np.isfinite(total):
        begin_anew(c.estimator, w.estimate)
        update(c.estimator, w.estimate, y, w.numbers[CC], w.numbers[CG])
    now, angles = w.estimate.x_hat[PSI], w.angles
    if w.counts[SAMPLE] == 1:  # before the first sample
        for i in range(PAST):
            angles[i] = now + c.reserve * c.period * (i + 1 - PAST)
        return
    for i in range(PAST - 1):
        angles[i] = angles[i + 1]
    angles[PAST - 1] = now


@inlined
def begin_anew(estimator: MomentEstimator, state: EstimatorState) -> None:
    """Forget all, as `MomentEstimator.init`."""
    state.x_hat[:], state.me_hat[:], state.wave[:], state.begun[:] = 0.0, 0.0, 0.0, 0.0
    state.queue[:, :], state.ring[:, :], state.work[:, :] = 0.0, 0.0, 0.0
    state.innovation[:] = 0.0
    for i in range(3):
        state.ring[i, i] = estimator.ring_noise[i]


@inlined
def saw(c: Constants, w: Memory) -> bool:
    """Take the moments of now; return whether the sea is to be learnt anew."""
    _, place = cos_sin(w.estimate.x_hat[PHI1])
    return bool(take(c.predictor, w.forecast, w.estimate.me_hat[0], w.estimate.me_hat[1], place))


@inlined
def foreseen(c: Constants, w: Memory) -> None:
    """Predict the moments over the horizon."""
    predict(c.predictor, w.forecast, w.ahead)
    between(w.forecast.now, w.ahead, c.period, w.moments)


@inlined
def powered(c: Constants, w: Memory) -> None:
    """Set the power by the flywheel's speed."""
    speed, since = w.estimate.x_hat[OMEGA_RATE], w.counts[SAMPLE] * c.period
    w.numbers[POWER], w.numbers[MEAN] = commanded(c.command, speed, w.numbers[MEAN], c.period, since, c.cg_max)


@inlined
def posed(c: Constants, w: Memory) -> int:
    """Pose the problem of the moment; return the iterations from elsewhere, or -1 where the plan is followed."""
    for i in range(c.rows.size):
        w.start[i] = w.estimate.x_hat[c.rows[i]]
    w.now[0], w.now[1], w.now[2], w.now[3] = w.numbers[POWER], w.numbers[CC], c.cc_max, c.period
    put(c.weights, w.weights)
    w.weights[REACH] = w.angles[0] + c.reserve * ((PAST - 1) * c.period + c.horizon)
    w.result[1] = w.numbers[SOLVER]
    followed(w.plan, w.trial)
    sample = w.counts[SAMPLE]
    if sample % c.replan != 0:
        return -1
    plans = sample // c.replan
    if plans % c.every != 0 or c.retries == 0:
        return 0
    elsewhere(plans // c.every % 4, c.cc_max, w.trial, w.other)
    return c.retries


@inlined
def elsewhere(kind: int, cc_max: float, plan: Any, other: Any) -> None:
    """Begin another plan: no coupling, half of it, or the same switching a little later or sooner."""
    n = plan.size
    for i in range(n):
        if kind < 2:
            other[i] = 0.5 * cc_max * kind
        else:
            other[i] = plan[(i + n - 3) % n if kind == 2 else (i + 3) % n]


@inlined
def acted(c: Constants, w: Memory, status: int, u: Any) -> bool:
    """Apply the plan, or what stands in for it; return whether the fallback law has to act."""
    speed, numbers, counts = w.estimate.x_hat[OMEGA_RATE], w.numbers, w.counts
    before = numbers[CC]
    cg = min(numbers[POWER] / max(speed * speed, 1.0), c.cg_max)
    if status == GOOD:
        put(w.trial, w.plan)
        numbers[SOLVER] = w.result[1]
        counts[AGE] = 0
    else:
        numbers[SOLVER] = c.fresh
        counts[LATES] += status == LATE
        counts[FAILURES] += status == FAILED
        if counts[AGE] < PATIENCE:
            followed(w.plan, w.trial)
            put(w.trial, w.plan)
            counts[KEPT] += 1
        else:
            w.plan[:] = before
            counts[FALLBACKS] += 1
        counts[AGE] += 1
    numbers[CC], numbers[CG] = w.plan[0], cg
    u[0], u[1] = w.plan[0], cg
    return bool(status != GOOD and counts[AGE] > PATIENCE)


@inlined
def fell_back(w: Memory, cc: float, cg: float, u: Any) -> None:
    """Act as the fallback law says. [Nms]"""
    w.numbers[CC], w.numbers[CG] = cc, cg
    u[0], u[1] = cc, cg


@inlined
def followed(plan: Any, later: Any) -> None:
    """Write the plan one interval later, its last coupling held."""
    for i in range(plan.size - 1):
        later[i] = plan[i + 1]
    later[plan.size - 1] = plan[plan.size - 1]
