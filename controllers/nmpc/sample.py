"""A sample of the law, stage by stage: estimate, look ahead, command the power, pose the problem, act.

One text, run as Python or compiled, bit for bit alike. Constants and memory are nests of numbers and arrays, so that
both go into rows of numbers (`flat`); the memory is changed in place.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.power_command import PowerCommand, commanded
from gyroctl.controllers.nmpc.problem import NOW, Weights
from gyroctl.plant.compiled import inlined, put
from gyroctl.plant.equations import PHI1, PSI, PSI_RATE
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation import EstimatorState, MomentEstimator, Predictor, PredictorState, update
from gyroctl.waves.estimation.gauge_readings import GaugeState

FloatArray = NDArray[np.float64]
Counts = NDArray[np.int64]

REACH, GRIP, LIMIT1 = (Weights._fields.index(name) for name in ("reach", "grip", "limit1"))

DOUBTED = 0.6
"""Time ahead from which the margin of ring speed grows no more: the motion is steered by then. [s]"""

CERTAIN, DOUBTFUL = 0.4, 0.6
"""Doubt of the whole horizon up to which all the room for motion may be used, and from which none of it. A gauge leaves
about the one or less, sensors alone leave more than the other but where the sea is calm. [rad/s]"""

BACKWARDS = -0.5
"""Ring speed below which the axis rolls backwards, and no reading is that wrong. [rad/s]"""

RING_READING = 1
"""Place of the ring's speed in a measurement."""

PATIENCE = 10
"""Samples for which the rest of a good plan is followed when no new one comes."""

PAST = 60
"""Samples of the past that count for the reserve of lock: with the horizon about the ten seconds that judge a loss."""

GOOD, LATE, FAILED = 0, 1, 2
"""What became of a plan: it serves, came after the deadline, or is not of numbers."""

SOLVER, POWER, MEAN, CC, CG, DOUBT = range(6)
"""Numbers that the law remembers: of the solver, power and its slow mean [W], the last command [Nms], and what
the doubt of the moments of the horizon adds up to in the speed of the ring [rad/s]."""

SAMPLE, AGE, LATES, FAILURES, KEPT, FALLBACKS = range(6)
"""Counts: samples so far, samples since the last good plan, and what went otherwise than planned."""


class Numbers(NamedTuple):
    """What the law goes by beside estimator and forecast."""

    command: PowerCommand
    rows: Counts  # of the plant's state that the model has
    h: FloatArray  # (1,) model step [s]
    k: FloatArray  # constants of the model
    weights: FloatArray  # fields of `Weights`
    doubt: FloatArray  # (2,) margin of ring speed that an uncertain impulse of Me1 and of Me3 asks for [rad/s per Nms]
    sure: float  # further |phi1| where nothing is in doubt [rad]
    period: float  # [s]
    horizon: float  # [s]
    reserve: float  # mean ring speed that past and horizon together are to keep [rad/s]
    cc_max: float  # [Nms]
    cg_max: float  # [Nms]
    lagging: float  # part of a control interval's mean coupling that is still the one before it [-]
    fresh: float  # what a solver remembers that begins anew
    delay: int  # samples by which a command acts later than its measurements were taken
    iterations: int  # of the solver, per plan
    replan: int  # samples from one plan to the next
    every: int  # plans from one that is begun elsewhere to the next
    retries: int  # iterations that each of them gets
    life: int  # plans for which it is kept before it is begun anew
    varied: int  # times that a plan is varied before it is improved
    newton: int  # steps on a program
    fresh_rival: float  # what a solver remembers of one that is begun elsewhere
    fallback: tuple[float, float]  # cc, cg [Nms]
    addresses: tuple[int, int, int, int, int, int]  # plan, three functions of the model, learn, clock; see `entry`


class Constants(NamedTuple):
    """What a sample goes by."""

    estimator: MomentEstimator
    predictor: Predictor
    law: Numbers


class Work(NamedTuple):
    """Plan and counts, and the room that they are worked on in."""

    plan: FloatArray  # (n,) couplings from the last sample on [Nms]
    numbers: FloatArray  # SOLVER .. DOUBT
    angles: FloatArray  # (PAST,) of the ring at the last samples, oldest first [rad]
    counts: Counts  # SAMPLE .. FALLBACKS
    trial: FloatArray  # (n,) the plan that is worked on [Nms]
    rivals: FloatArray  # (rivals n,) plans that were begun elsewhere, one after the other [Nms]
    start: FloatArray  # state that a plan begins in
    now: FloatArray  # (NOW + n,) power [W], last coupling, its limit [Nms], control interval [s]; margins [rad/s]
    weights: FloatArray  # fields of `Weights`
    result: FloatArray  # (2 + rivals,) cost [J], what the solver remembers of the plan and of each rival


class Memory(NamedTuple):
    """What the law carries from sample to sample; each stage is given the groups that it needs."""

    estimate: EstimatorState
    forecast: PredictorState
    work: Work
    ahead: FloatArray  # (2, delay + n) moments at the end of each interval [Nm]
    moments: FloatArray  # (width (2 (delay + n) + 1),) at each model step, see `prediction.width_of` [Nm, Nm/s]
    spent: Counts  # samples by the time they took, see `stopwatch`
    gauge: GaugeState | None = None  # where a gauge is read


def first_memory(
    c: Constants,
    pair: tuple[float, float],
    intervals: int,
    width: int,
    rivals: int,
    bins: int,
    gauge: GaugeState | None = None,
) -> Memory:
    """Memory before the first sample, of a law whose last command was a pair [Nms]."""
    n, new, law = intervals, np.zeros, c.law
    far = n + law.delay
    numbers = np.array([law.fresh, law.command.power, law.command.power, *pair, 0.0])
    counts, weights = new(6, np.int64), new(law.weights.size)
    problem = new(n), new(rivals * n), new(law.rows.size), new(NOW + n), weights, new(2 + rivals)
    work = Work(np.full(n, pair[0]), numbers, new(PAST), counts, *problem)
    ahead, moments = new((2, far)), new(width * (2 * far + 1))
    return Memory(c.estimator.init(), c.predictor.init(), work, ahead, moments, new(bins, np.int64), gauge)


@inlined
def observed(estimator: MomentEstimator, state: EstimatorState, law: Numbers, w: Work, y: Any) -> None:
    """Estimate the state; begin anew where it is not of numbers."""
    w.counts[SAMPLE] += 1
    for attempt in range(2):  # one place that is compiled
        update(estimator, state, y, w.numbers[CC], w.numbers[CG])
        total = 0.0
        for i in range(state.x_hat.size):
            total += state.x_hat[i]
        if np.isfinite(total):
            break
        if attempt == 0:
            begin_anew(estimator, state)
    now, angles = state.x_hat[PSI], w.angles
    if w.counts[SAMPLE] == 1:  # before the first sample
        for i in range(PAST):
            angles[i] = now + law.reserve * law.period * (i + 1 - PAST)
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
def placed(state: EstimatorState) -> float:
    """Where the float is: the sine of phi1."""
    _, place = cos_sin(state.x_hat[PHI1])
    return float(place)


@inlined
def seen_ring(state: EstimatorState, y: Any) -> float:
    """Speed of the ring [rad/s] as it is read, which is right also where the estimator's rolling axis is not."""
    return float(state.x_hat[PSI_RATE] if state.missing[RING_READING] > 0.0 else y[RING_READING])


@inlined
def powered(c: Numbers, w: Work, speed: float) -> None:
    """Set the power by the flywheel's speed [rad/s]."""
    since = w.counts[SAMPLE] * c.period
    w.numbers[POWER], w.numbers[MEAN] = commanded(c.command, speed, w.numbers[MEAN], c.period, since, c.cg_max)


@inlined
def doubted(c: Numbers, w: Work, spread: Any) -> None:
    """Write the margins of ring speed that a plan has to keep, from the deviation of the forecast, `spread` [Nm].

    What is not known of a moment adds up in the speed of the float, and with it in what the rolling contact asks of the
    ring: a chance constraint, with the errors of all instants taken for one. `spread` is (2, 1 + intervals), now first;
    of no size where the forecast does not tell it, and then there are no margins. What the impulse of the whole horizon
    would ask for stands beside them: how much is in doubt of what a plan goes by.
    """
    if spread.size == 0:
        return
    by_1, by_3, margin = 0.0, 0.0, 0.0
    for j in range(spread.shape[1] - 1):
        by_1 += 0.5 * c.period * c.doubt[0] * (spread[0, j] + spread[0, j + 1])
        by_3 += 0.5 * c.period * c.doubt[1] * (spread[1, j] + spread[1, j + 1])
        if j * c.period < DOUBTED:
            margin = math.sqrt(0.5 * (by_1 * by_1 + by_3 * by_3))
        i = j - c.delay
        if 0 <= i < w.trial.size:
            w.now[NOW + i] = margin
    w.numbers[DOUBT] = math.sqrt(0.5 * (by_1 * by_1 + by_3 * by_3))


@inlined
def allowed(c: Numbers, w: Work) -> float:
    """Limit of |phi1| of the plan [rad]: the less of the moments is in doubt, the more of the room may be used."""
    sure = (DOUBTFUL - w.numbers[DOUBT]) / (DOUBTFUL - CERTAIN)
    return float(c.weights[LIMIT1] + c.sure * min(max(sure, 0.0), 1.0))


@inlined
def posed(c: Numbers, w: Work, x: Any) -> int:
    """Pose the problem of the moment in the state `x`.

    Return the iterations that a plan from elsewhere gets, or -1 where the last plan is followed.
    """
    for i in range(c.rows.size):
        w.start[i] = x[c.rows[i]]
    w.now[0], w.now[1], w.now[2], w.now[3] = w.numbers[POWER], w.numbers[CC], c.cc_max, c.period
    put(c.weights, w.weights)
    w.weights[LIMIT1] = allowed(c, w)
    w.weights[REACH] = w.angles[0] + c.reserve * ((PAST - 1 + c.delay) * c.period + c.horizon)
    w.result[1] = w.numbers[SOLVER]
    followed(w.plan, w.trial)
    sample, n = w.counts[SAMPLE], w.trial.size
    count = w.rivals.size // n
    if c.life > 1:
        for r in range(count):
            followed(w.rivals[n * r : n * (r + 1)], w.rivals[n * r : n * (r + 1)])
    if sample % c.replan != 0:
        return -1
    plans = sample // c.replan
    if plans % c.every != 0 or c.retries == 0:
        return 0
    turn = plans // c.every
    for r in range(count):  # begun one after the other, so that there is always one that has had its time
        if turn % c.life == r * c.life // count or w.result[2 + r] == 0.0:
            elsewhere((turn // c.life * count + r) % 4, c.cc_max, w.trial, w.rivals[n * r : n * (r + 1)])
            w.result[2 + r] = c.fresh_rival
    return c.retries


@inlined
def acted_on(c: Numbers, ahead: Any, moments: Any) -> Any:
    """Moments from the instant on at which the command of this sample acts."""
    return moments[2 * c.delay * (moments.size // (2 * ahead.shape[1] + 1)) :]


@inlined
def elsewhere(kind: int, cc_max: float, plan: Any, other: Any) -> None:
    """Begin a rival plan: no coupling, half of it, or the same switching a little later or sooner."""
    n = plan.size
    for i in range(n):
        if kind < 2:
            other[i] = 0.5 * cc_max * kind
        else:
            other[i] = plan[(i + n - 3) % n if kind == 2 else (i + 3) % n]


@inlined
def acted(c: Numbers, w: Work, speed: float, ring: float, held: float, status: int, u: Any) -> bool:
    """Apply the plan, or what stands in for it; return whether the fallback law has to act.

    A plan tells the mean coupling of an interval. One that lags begins at what is `held` [Nms], so the command leads
    where it is to grow. Where it is to fall, a lead would buy the mean by too little in the end, and the ring, which
    follows within hundredths of a second, is slower than planned when the next sample comes.

    Where the `ring` goes backwards [rad/s] the axis rolls so, and a coupling holds it there: flywheel and ring agree
    with the other sense. The plan's model rolls forwards and knows nothing of that, so the ring is let go: the float
    turns it round within a few tenths of a second.
    """
    numbers, counts = w.numbers, w.counts
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
    cc = w.plan[0]
    if c.lagging > 0.0:
        cc = min(max((cc - c.lagging * held) / (1.0 - c.lagging), cc), c.cc_max)
    if ring < BACKWARDS and c.weights[GRIP] > 0.0:
        cc = 0.0
    numbers[CC], numbers[CG] = cc, cg
    u[0], u[1] = cc, cg
    return bool(status != GOOD and counts[AGE] > PATIENCE)


@inlined
def fell_back(w: Work, cc: float, cg: float, u: Any) -> None:
    """Act as the fallback law says. [Nms]"""
    w.numbers[CC], w.numbers[CG] = cc, cg
    u[0], u[1] = cc, cg


@inlined
def followed(plan: Any, later: Any) -> None:
    """Write the plan one interval later, its last coupling held."""
    for i in range(plan.size - 1):
        later[i] = plan[i + 1]
    later[plan.size - 1] = plan[plan.size - 1]
