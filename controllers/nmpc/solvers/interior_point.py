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


class InteriorRoom(NamedTuple):
    """Arrays of the pairs: (n, 2) of each coupling's bounds, (n, 6) of each output's limits, low ones first."""

    t: FloatArray  # (n, 2) distance to a bound [Nms]
    z: FloatArray  # (n, 2) its multiplier
    dz: FloatArray
    second: FloatArray  # (n, 2) second-order term of the corrector
    l: FloatArray  # (n, 6) multiplier of a limit, the penalty's slope
    dl: FloatArray
    y: FloatArray  # (n, 6) slope t of the complementary side
    dy: FloatArray
    limit_second: FloatArray  # (n, 6)
    used: NDArray[np.bool_]  # (6,) limits which are finite and weigh something


@inlined
def empty_interior_room(n: int) -> InteriorRoom:
    """Room for a horizon of `n` intervals."""
    return InteriorRoom(
        np.zeros((n, 2)),
        np.zeros((n, 2)),
        np.zeros((n, 2)),
        np.zeros((n, 2)),
        np.zeros((n, 6)),
        np.zeros((n, 6)),
        np.zeros((n, 6)),
        np.zeros((n, 6)),
        np.zeros((n, 6)),
        np.zeros(6, np.bool_),
    )


@entry_point
def interior_point(qp: Any, proximal: float, d: Any, tolerance: float, limit: int, room: Any, inner: Any) -> int:
    """Solve a subproblem from the middle; `d` (n,) is overwritten, and put on the bounds that hold it.

    Parameters
    ----------
    qp : Subproblem
        As `linearise` fills it.
    proximal : float
        Weight of |d|^2 / 2, positive. [J/(Nms)^2]
    d : (n,) array
        Overwritten. [Nms]
    tolerance : float
        Of the mean complementarity, relative to its start.
    limit : int
        Most iterations of two sweeps each.
    room : SweepRoom
        Overwritten.
    inner : InteriorRoom
        Overwritten.

    Returns
    -------
    int
        Iterations.
    """
    n = d.size
    bounds(qp, room.low, room.high)
    room.held[:] = False
    for i in range(n):
        d[i] = 0.5 * (room.low[i] + room.high[i])
    evaluate(qp, proximal, d, room.states, room.slopes)
    slope(qp, proximal, d, room.slopes, room.slope)
    for side in range(6):
        bound = qp.low[side] if side < 3 else qp.high[side - 3]
        inner.used[side] = np.isfinite(bound) and qp.weight[side % 3] > 0.0
    steepness = np.mean(np.abs(room.slope)) + 1e-12
    first = 0.05 * steepness * qp.cc_max[0]
    pairs = 2 * n
    for i in range(n):  # every pair starts on the central path
        for side in range(2):
            inner.t[i, side] = d[i] - room.low[i] if side == 0 else room.high[i] - d[i]
            inner.z[i, side] = first / inner.t[i, side]
        for side in range(6):
            if inner.used[side]:
                pairs += 1
                weight, distance = qp.weight[side % 3], _distance(qp, room.states, i, side)
                inner.l[i, side] = 0.5 * weight * (np.sqrt(distance * distance + 4.0 * first / weight) - distance)
    mean, count = first, 0
    while count < limit:
        mean = _complementarity(qp, room, inner) / pairs
        if not mean > tolerance * first:
            break
        count += 1
        inner.second[:] = 0.0
        inner.limit_second[:] = 0.0
        _direction(qp, proximal, d, 0.0, room, inner)
        part = _longest(room, inner)
        ahead = _complementarity_ahead(room, inner, part) / pairs
        for i in range(n):
            for side in range(2):
                move = room.direction[i] if side == 0 else -room.direction[i]
                inner.second[i, side] = move * inner.dz[i, side]
            for side in range(6):
                inner.limit_second[i, side] = inner.dl[i, side] * inner.dy[i, side]
        _direction(qp, proximal, d, mean * (ahead / mean) ** 3, room, inner)
        part = min(1.0, TO_BOUNDARY * _longest(room, inner))
        for i in range(n):
            d[i] += part * room.direction[i]
            inner.t[i, 0], inner.t[i, 1] = d[i] - room.low[i], room.high[i] - d[i]
            for side in range(2):
                inner.t[i, side] = max(inner.t[i, side], 1e-300)
                inner.z[i, side] += part * inner.dz[i, side]
            for side in range(6):
                inner.l[i, side] += part * inner.dl[i, side]
        evaluate(qp, proximal, d, room.states, room.slopes)
    scale = qp.cc_max[0] / steepness
    for i in range(n):  # of each pair the one that is small for its size is zero
        if inner.t[i, 0] < scale * inner.z[i, 0]:
            d[i] = room.low[i]
        elif inner.t[i, 1] < scale * inner.z[i, 1]:
            d[i] = room.high[i]
    return count


@entry_point
def _distance(qp: Any, states: Any, i: int, side: int) -> float:
    """How far an output is within a limit."""
    r = side % 3
    value = qp.outputs[i, r] + states[i, OUTPUTS[r]]
    inside: float = value - qp.low[r] if side < 3 else qp.high[r] - value
    return inside


@entry_point
def _complementarity(qp: Any, room: Any, inner: Any) -> float:
    """Sum over the pairs; writes the slopes complementary to the limits' multipliers."""
    total = 0.0
    for i in range(inner.t.shape[0]):
        for side in range(2):
            total += inner.t[i, side] * inner.z[i, side]
        for side in range(6):
            if inner.used[side]:
                t = _distance(qp, room.states, i, side) + inner.l[i, side] / qp.weight[side % 3]
                inner.y[i, side] = max(t, 1e-300)
                total += inner.y[i, side] * inner.l[i, side]
    return total


@entry_point
def _complementarity_ahead(room: Any, inner: Any, part: float) -> float:
    """Sum over the pairs after a step."""
    total = 0.0
    for i in range(inner.t.shape[0]):
        for side in range(2):
            move = room.direction[i] if side == 0 else -room.direction[i]
            total += (inner.t[i, side] + part * move) * (inner.z[i, side] + part * inner.dz[i, side])
        for side in range(6):
            if inner.used[side]:
                total += (inner.y[i, side] + part * inner.dy[i, side]) * (inner.l[i, side] + part * inner.dl[i, side])
    return total


@entry_point
def _longest(room: Any, inner: Any) -> float:
    """Largest part of a step, up to one, which keeps every pair positive."""
    part = 1.0
    for i in range(inner.t.shape[0]):
        for side in range(2):
            move = room.direction[i] if side == 0 else -room.direction[i]
            if move < 0.0:
                part = min(part, -inner.t[i, side] / move)
            if inner.dz[i, side] < 0.0:
                part = min(part, -inner.z[i, side] / inner.dz[i, side])
        for side in range(6):
            if inner.used[side]:
                if inner.dy[i, side] < 0.0:
                    part = min(part, -inner.y[i, side] / inner.dy[i, side])
                if inner.dl[i, side] < 0.0:
                    part = min(part, -inner.l[i, side] / inner.dl[i, side])
    return part


@entry_point
def _direction(qp: Any, proximal: float, d: Any, target: float, room: Any, inner: Any) -> None:
    """Newton step towards complementarity `target`, less the second-order terms: `room.direction`, dz, dl, dy."""
    n = d.size
    for i in range(n):
        for r in range(3):
            room.slopes[i, r], room.curvature[i, r] = 0.0, 0.0
        for side in range(6):
            if not inner.used[side]:
                continue
            r, l, t = side % 3, inner.l[i, side], inner.y[i, side]
            stiff = t + l / qp.weight[r]
            moved = l + (target - inner.limit_second[i, side] - t * l) / stiff
            inner.dl[i, side] = moved - l  # the part that does not depend on the step
            room.slopes[i, r] += -moved if side < 3 else moved
            room.curvature[i, r] += l / stiff
    slope(qp, proximal, d, room.slopes, room.slope)
    for i in range(n):
        room.barrier[i] = inner.z[i, 0] / inner.t[i, 0] + inner.z[i, 1] / inner.t[i, 1]
        room.slope[i] -= (target - inner.second[i, 0]) / inner.t[i, 0]
        room.slope[i] += (target - inner.second[i, 1]) / inner.t[i, 1]
    sweep(qp, proximal, room)
    for i in range(n):
        for side in range(2):
            move = room.direction[i] if side == 0 else -room.direction[i]
            t, z = inner.t[i, side], inner.z[i, side]
            inner.dz[i, side] = (target - inner.second[i, side] - z * move) / t - z
        for side in range(6):
            if inner.used[side]:
                r, l, t = side % 3, inner.l[i, side], inner.y[i, side]
                change = room.ahead[i, OUTPUTS[r]] if side < 3 else -room.ahead[i, OUTPUTS[r]]
                inner.dl[i, side] -= l / (t + l / qp.weight[r]) * change
                inner.dy[i, side] = change + inner.dl[i, side] / qp.weight[r]
