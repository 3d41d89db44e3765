"""The horizon linearised about a plan: a convex quadratic program in the change of the plan.

The states enter linearly, by the exact Jacobians of the prediction model; the penalties on motion and stall enter as
they are, distances to an interval squared, and are not replaced by parabolas: a step sees the limit it would run into.
The stored energy is convex and counts negative, so it enters by its tangent, which bounds the cost from above: the
convex-concave procedure (Yuille, Rangarajan, Neural Comput. 15 (2003) 915-936). With linear dynamics every step would
lower the cost; what the dynamics' curvature spoils is bounded by the proximal term, the weight of Levenberg's method.

    minimise over d   sum_i sum_r 1/2 weight_r dist(y_ir + e_ir, [low_r, high_r])^2 + terminal' e_n
                      + travel sum_i (plan_i + d_i - plan_(i-1) - d_(i-1))^2 + 1/2 proximal |d|^2
    where             e_i = A_i e_(i-1) + b_i d_i,   e_0 = 0,   -plan_i <= d_i <= cc_max - plan_i
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.casadi_to_numba import BESIDE, row_of
from gyroctl.controllers.nmpc.prediction import STEPS, tangent_room
from gyroctl.controllers.nmpc.problem import PHI1, PHI3, RING, RING_ANGLE, V1, V3, grip_needed, margin_at, terminal_cost
from gyroctl.controllers.nmpc.solvers import SOURCES
from gyroctl.plant.compiled import inlined, part, put, put_table, source_stamp, zero_table, zeros

FloatArray = NDArray[np.float64]

OUTPUTS = (PHI1, PHI3, RING)
"""Rows of the state that have limits."""

CURVED = (RING_ANGLE, V1, V3)
"""Rows of which the ring speed that grip asks for is a function."""

SOLVED, LIMIT_REACHED, NOT_FINITE, NOT_CONVEX = 0, 1, 2, 3
"""What became of a quadratic program: solved to tolerance, best point so far, no usable numbers, no minimum found."""


class Subproblem(NamedTuple):
    """A horizon of n intervals about a plan; the arrays are filled by `linearise`."""

    A: FloatArray  # (n, m, m): sensitivity of the state after an interval to the one before it
    b: FloatArray  # (n, m): to the coupling in the interval [1/Nms]
    outputs: FloatArray  # (n, 3): phi1, phi3 [rad] and ring speed [rad/s] after each interval
    low: FloatArray  # (3,) where a penalty begins
    high: FloatArray  # (3,)
    weight: FloatArray  # (3,) [J/rad^2], [J s^2/rad^2]
    terminal: FloatArray  # (m,) gradient of the terminal cost
    plan: FloatArray  # (n,) [Nms]
    before: FloatArray  # (1,) coupling before the horizon [Nms]
    travel: FloatArray  # (1,) [J/(Nms)^2]
    cc_max: FloatArray  # (1,) [Nms]


class Step(NamedTuple):
    """A solution of a subproblem."""

    status: int  # SOLVED, LIMIT_REACHED, NOT_FINITE or NOT_CONVEX
    iterations: int
    distance: float  # from the solution at most [Nms]: projected gradient over the modulus of convexity
    value: float  # of the subproblem's cost at the step, less its value at d = 0 [J]


@inlined
def empty_subproblem(n: int, m: int) -> Subproblem:
    """Room for a horizon of `n` intervals of a model with `m` states."""
    new = zeros
    tables = np.zeros((n, m, m)), zero_table(n, m), zero_table(n, 3)
    return Subproblem(*tables, new(3), new(3), new(3), new(m), new(n), new(1), new(1), new(1))


@part(SOURCES)
def _settle(qp: Any, problem: Any) -> None:
    """Write what does not depend on the states: limits, weights, bounds."""
    weights = problem.weights
    qp.low[0], qp.low[1], qp.low[2] = -weights.limit1, -weights.limit3, weights.floor
    qp.high[0], qp.high[1], qp.high[2] = weights.limit1, weights.limit3, np.inf
    qp.weight[0] = qp.weight[1] = 2.0 * problem.period * weights.motion
    qp.weight[2] = 2.0 * problem.period * weights.lock
    qp.before[0], qp.travel[0], qp.cc_max[0] = problem.before, weights.travel, problem.cc_max


@inlined
def add_product(matrix: Any, vector: Any, out: Any) -> None:
    """Add ``matrix @ vector`` to `out`, in an order of summation that is the same on every machine."""
    for row in range(matrix.shape[0]):
        total = out[row]
        for column in range(matrix.shape[1]):
            total += matrix[row, column] * vector[column]
        out[row] = total


@inlined
def add_transposed(matrix: Any, vector: Any, out: Any) -> None:
    """Add ``matrix.T @ vector`` to `out`."""
    for row in range(matrix.shape[0]):
        for column in range(matrix.shape[1]):
            out[column] += matrix[row, column] * vector[row]


@inlined
def transposed_product(left: Any, right: Any, out: Any) -> None:
    """Overwrite `out` by ``left.T @ right``."""
    out[:, :] = 0.0
    for inner in range(left.shape[0]):
        for row in range(left.shape[1]):
            factor = left[inner, row]
            if factor != 0.0:
                for column in range(right.shape[1]):
                    out[row, column] += factor * right[inner, column]


@part(SOURCES)
def _gripped(qp: Any, weights: Any, states: Any) -> None:
    """Let the ring speed of the program be that less what grip asks for: a change of the state's coordinates.

    With y = psi' - extra(psi, phi1', phi3') in the place of psi', e becomes T e with T = 1 - e_RING extra'; the output
    is a row of the state as before, so that no solver knows of it.
    """
    n, m = qp.b.shape
    before, now = np.zeros(3), np.zeros(3)  # slopes at the last instant and at this one
    for i in range(n):
        extra, now[0], now[1], now[2] = grip_needed(states[STEPS * (i + 1)], weights)
        qp.outputs[i, 2] -= extra
        a, b = qp.A[i], qp.b[i]
        for k in range(3):
            column = CURVED[k]
            for row in range(m):
                a[row, column] += a[row, RING] * before[k]
        for k in range(3):
            row = CURVED[k]
            for column in range(m):
                a[RING, column] -= now[k] * a[row, column]
            b[RING] -= now[k] * b[row]
        put(now, before)
    for k in range(3):
        qp.terminal[CURVED[k]] += qp.terminal[RING] * before[k]


def _linearise(stamp: str) -> Callable[..., bool]:
    """Compile the linearisation; the stamp makes the cache forget code whose parts have changed."""

    @part()
    def linearise(tangent: Any, problem: Any, cc: Any, states: Any, qp: Any) -> bool:
        """Linearise the horizon about the plan `cc` (n,) [Nms] into `qp`; return whether every number is finite.

        `states` are those that `problem.predict` wrote for the plan, `tangent` comes from `prediction.tangent_of`.
        """
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        n, m, width = cc.size, problem.start.size, problem.width
        size, row = m + 1, row_of(m + 1)
        room, columns = np.empty(tangent_room(m, width)), np.empty((BESIDE // STEPS, size, row))
        flat = columns.reshape(BESIDE // STEPS * size * row)
        _settle(qp, problem)
        for first in range(0, STEPS * n, BESIDE):
            for l in range(BESIDE):
                q = min(first + l, STEPS * n - 1)  # beyond the end the last step once more
                for j in range(m):
                    room[BESIDE * j + l] = states[q, j]
                room[BESIDE * m + l], room[BESIDE * (m + 1) + l] = cc[q // STEPS], problem.power
                for j in range(2 * width):
                    room[BESIDE * (m + 2 + j) + l] = problem.moments[width * q + j]
            columns[:, :, :] = 0.0
            for block in range(BESIDE // STEPS):
                for j in range(size):
                    columns[block, j, j] = 1.0
            tangent(problem.h, problem.k, room, flat)
            for block in range(min(BESIDE // STEPS, n - first // STEPS)):
                i = first // STEPS + block
                qp.plan[i] = cc[i]
                put_table(columns[block, :, :m], qp.A[i])
                put(columns[block, :, m], qp.b[i])
                for r in range(3):
                    qp.outputs[i, r] = states[STEPS * (i + 1), OUTPUTS[r]]
                qp.outputs[i, 2] -= margin_at(problem, i)
        qp.terminal[:] = 0.0
        value = terminal_cost(states[STEPS * n], problem.weights, qp.terminal)
        if problem.weights.grip > 0.0:
            _gripped(qp, problem.weights, states)
        return bool(np.isfinite(value + np.sum(qp.A) + np.sum(qp.b)))

    return linearise


linearise = _linearise(source_stamp(SOURCES))


@part(SOURCES)
def bounds(qp: Any, low: Any, high: Any) -> None:
    """Write the least and largest change of each interval."""
    for i in range(qp.plan.size):
        low[i], high[i] = -qp.plan[i], qp.cc_max[0] - qp.plan[i]


@part(SOURCES)
def evaluate(qp: Any, proximal: float, d: Any, states: Any, slopes: Any) -> float:
    """Cost of a change `d`, with its states (n, m) and the slopes of the penalties by the outputs (n, 3) written."""
    n, m = qp.b.shape
    cost, last, planned = 0.0, 0.0, qp.before[0]
    for i in range(n):
        for row in range(m):
            states[i, row] = qp.b[i, row] * d[i]
        if i > 0:
            add_product(qp.A[i], states[i - 1], states[i])
        for r in range(3):
            value = qp.outputs[i, r] + states[i, OUTPUTS[r]]
            beyond = value - min(max(value, qp.low[r]), qp.high[r])
            slopes[i, r] = qp.weight[r] * beyond
            cost += 0.5 * qp.weight[r] * beyond * beyond
        jump = qp.plan[i] + d[i] - planned - last
        cost += qp.travel[0] * jump * jump + 0.5 * proximal * d[i] * d[i]
        last, planned = d[i], qp.plan[i]
    for row in range(m):
        cost += qp.terminal[row] * states[n - 1, row]
    return cost


@part(SOURCES)
def slope(qp: Any, proximal: float, d: Any, slopes: Any, out: Any) -> None:
    """Write the gradient by `d` (n,), from the slopes that `evaluate` left."""
    n, m = qp.b.shape
    weight, moved = np.zeros(m), np.zeros(m)
    put(qp.terminal, weight)
    for i in range(n - 1, -1, -1):
        for r in range(3):
            weight[OUTPUTS[r]] += slopes[i, r]
        total = proximal * d[i]
        for row in range(m):
            total += qp.b[i, row] * weight[row]
        before = qp.before[0] if i == 0 else qp.plan[i - 1] + d[i - 1]
        total += 2.0 * qp.travel[0] * (qp.plan[i] + d[i] - before)
        if i + 1 < n:
            total += 2.0 * qp.travel[0] * (qp.plan[i] + d[i] - qp.plan[i + 1] - d[i + 1])
        out[i] = total
        moved[:] = 0.0
        add_transposed(qp.A[i], weight, moved)
        put(moved, weight)
