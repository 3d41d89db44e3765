"""The linearised horizon from within: a primal-dual interior point method, each of its systems a Riccati sweep.

Where many bounds and limits trade places, projected Newton steps zigzag; this method takes ten to twenty sweeps
whatever the problem. Predictor and corrector after Mehrotra (SIAM J. Optim. 2 (1992) 575-601), the sweep after Rao,
Wright, Rawlings (J. Optim. Theory Appl. 99 (1998) 723-757). A soft limit needs no slack: the penalty
1/2 w max(0, y - high)^2 is the largest of l (y - high) - l^2 / (2 w) over l >= 0, whose slope t = high - y + l / w is
complementary to l, which gives the curvature l / (t + l / w), between zero and w.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.solvers.riccati_sweep import sweep
from gyroctl.controllers.nmpc.solvers.subproblem import OUTPUTS, bounds, evaluate, slope
from gyroctl.plant.compiled import entry_point, inlined

FloatArray = NDArray[np.float64]
TO_BOUNDARY = 0.995
SMALLEST = 1e-300  # of what must stay positive

SIDES, BOUNDS = 8, 2
"""Pairs of an interval: the coupling's two bounds, then the three outputs' low limits, then their high ones."""

SIGN = (1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0)
"""Of the change of a pair's distance by what it bounds."""


class InteriorRoom(NamedTuple):
    """Complementary pairs, `SIDES` in each interval."""

    t: FloatArray  # (n, SIDES) distance to a bound [Nms]; the slope t of a limit's complementary side
    l: FloatArray  # (n, SIDES) multiplier of a bound; that of a limit, the penalty's slope
    dt: FloatArray
    dl: FloatArray
    second: FloatArray  # (n, SIDES) second-order term of the corrector
    used: NDArray[np.bool_]  # (SIDES,) the bounds, and the limits which are finite and weigh something


@inlined
def empty_interior_room(n: int) -> InteriorRoom:
    """Room for a horizon of `n` intervals."""
    shape = (n, SIDES)
    t, l, dt, dl = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    return InteriorRoom(t, l, dt, dl, np.zeros(shape), np.ones(SIDES, np.bool_))


@entry_point
def interior_point(qp: Any, proximal: float, d: Any, tolerance: float, limit: int, room: Any, inner: Any) -> int:
    """Solve a subproblem from the middle; `d` (n,) [Nms] is overwritten, and put on the bounds that hold it.

    `proximal` is the weight of |d|^2 / 2, positive [J/(Nms)^2], `tolerance` that of the mean complementarity, relative
    to its start, `limit` the most iterations of two sweeps each; `room` and `inner` are overwritten. Returned is the
    number of iterations.
    """
    n = d.size
    bounds(qp, room.low, room.high)
    room.held[:] = False
    for i in range(n):
        d[i] = 0.5 * (room.low[i] + room.high[i])
    evaluate(qp, proximal, d, room.states, room.slopes)
    slope(qp, proximal, d, room.slopes, room.slope)
    steepness = np.mean(np.abs(room.slope)) + 1e-12
    first = 0.05 * steepness * qp.cc_max[0]
    pairs = n * _start(qp, d, first, room, inner)
    mean, count = first, 0
    while count < limit:
        _limit_slopes(qp, room, inner)
        mean = _complementarity(inner, 0.0) / pairs
        if not mean > tolerance * first:
            break
        count += 1
        inner.second[:] = 0.0
        _direction(qp, proximal, d, 0.0, room, inner)
        ahead = _complementarity(inner, _longest(inner)) / pairs
        for i in range(n):
            for side in range(SIDES):
                inner.second[i, side] = inner.dt[i, side] * inner.dl[i, side]
        _direction(qp, proximal, d, mean * (ahead / mean) ** 3, room, inner)
        part = min(1.0, TO_BOUNDARY * _longest(inner))
        for i in range(n):
            d[i] += part * room.direction[i]
            inner.t[i, 0] = max(d[i] - room.low[i], SMALLEST)
            inner.t[i, 1] = max(room.high[i] - d[i], SMALLEST)
            for side in range(SIDES):
                inner.l[i, side] += part * inner.dl[i, side]
        evaluate(qp, proximal, d, room.states, room.slopes)
    scale = qp.cc_max[0] / steepness
    for i in range(n):  # of each pair the one that is small for its size is zero
        if inner.t[i, 0] < scale * inner.l[i, 0]:
            d[i] = room.low[i]
        elif inner.t[i, 1] < scale * inner.l[i, 1]:
            d[i] = room.high[i]
    return count


@entry_point
def _start(qp: Any, d: Any, first: float, room: Any, inner: Any) -> int:
    """Put every pair on the central path, where its product is `first`; return how many an interval has."""
    for side in range(BOUNDS, SIDES):
        limit = qp.low[side - 2] if side < 5 else qp.high[side - 5]
        inner.used[side] = np.isfinite(limit) and qp.weight[(side - 2) % 3] > 0.0
    inner.dt[:], inner.dl[:] = 0.0, 0.0
    for i in range(d.size):
        inner.t[i, 0], inner.t[i, 1] = d[i] - room.low[i], room.high[i] - d[i]
        inner.l[i, 0], inner.l[i, 1] = first / inner.t[i, 0], first / inner.t[i, 1]
        for side in range(BOUNDS, SIDES):
            if inner.used[side]:
                weight, distance = qp.weight[(side - 2) % 3], _distance(qp, room.states, i, side)
                inner.l[i, side] = 0.5 * weight * (np.sqrt(distance * distance + 4.0 * first / weight) - distance)
    return int(np.sum(inner.used))


@entry_point
def _distance(qp: Any, states: Any, i: int, side: int) -> float:
    """How far an output is within a limit."""
    r = (side - 2) % 3
    value = qp.outputs[i, r] + states[i, OUTPUTS[r]]
    inside: float = value - qp.low[r] if side < 5 else qp.high[r] - value
    return inside


@entry_point
def _limit_slopes(qp: Any, room: Any, inner: Any) -> None:
    """Write the slopes that are complementary to the limits' multipliers."""
    for i in range(inner.t.shape[0]):
        for side in range(BOUNDS, SIDES):
            if inner.used[side]:
                t = _distance(qp, room.states, i, side) + inner.l[i, side] / qp.weight[(side - 2) % 3]
                inner.t[i, side] = max(t, SMALLEST)


@entry_point
def _complementarity(inner: Any, part: float) -> float:
    """Sum over the pairs after a part of the step."""
    total = 0.0
    for i in range(inner.t.shape[0]):
        for side in range(SIDES):
            if inner.used[side]:
                total += (inner.t[i, side] + part * inner.dt[i, side]) * (inner.l[i, side] + part * inner.dl[i, side])
    return total


@entry_point
def _longest(inner: Any) -> float:
    """Largest part of a step, up to one, which keeps every pair positive."""
    part = 1.0
    for i in range(inner.t.shape[0]):
        for side in range(SIDES):
            if inner.used[side] and inner.dt[i, side] < 0.0:
                part = min(part, -inner.t[i, side] / inner.dt[i, side])
            if inner.used[side] and inner.dl[i, side] < 0.0:
                part = min(part, -inner.l[i, side] / inner.dl[i, side])
    return part


@entry_point
def _direction(qp: Any, proximal: float, d: Any, target: float, room: Any, inner: Any) -> None:
    """Newton step towards complementarity `target`, less the second-order terms: `room.direction`, `dt`, `dl`."""
    n = d.size
    room.slopes[:], room.curvature[:] = 0.0, 0.0
    for i in range(n):
        for side in range(BOUNDS, SIDES):
            if inner.used[side]:
                r, l, t = (side - 2) % 3, inner.l[i, side], inner.t[i, side]
                stiff = t + l / qp.weight[r]
                moved = l + (target - inner.second[i, side] - t * l) / stiff
                inner.dl[i, side] = moved - l  # the part that does not depend on the step
                room.slopes[i, r] -= SIGN[side] * moved
                room.curvature[i, r] += l / stiff
    slope(qp, proximal, d, room.slopes, room.slope)
    for i in range(n):
        room.barrier[i] = inner.l[i, 0] / inner.t[i, 0] + inner.l[i, 1] / inner.t[i, 1]
        for side in range(BOUNDS):
            room.slope[i] -= SIGN[side] * ((target - inner.second[i, side]) / inner.t[i, side])
    sweep(qp, proximal, room)
    for i in range(n):
        for side in range(SIDES):
            l, t = inner.l[i, side], inner.t[i, side]
            if side < BOUNDS:
                inner.dt[i, side] = SIGN[side] * room.direction[i]
                inner.dl[i, side] = (target - inner.second[i, side] - l * inner.dt[i, side]) / t - l
            elif inner.used[side]:
                weight, change = qp.weight[(side - 2) % 3], SIGN[side] * room.ahead[i, OUTPUTS[(side - 2) % 3]]
                inner.dl[i, side] -= l / (t + l / weight) * change
                inner.dt[i, side] = change + inner.dl[i, side] / weight
