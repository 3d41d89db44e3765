"""Exact solution of the linearised horizon in O(n): Newton's method on the free couplings, each system a Riccati sweep.

The couplings that sit on a bound and want to stay there are held; a Newton step in the others is the solution of a
linear-quadratic control problem, which the Riccati recursion gives in one sweep back and one forth. The step is
projected onto the bounds, as far as the cost falls along the bent path: projected Newton (Bertsekas, SIAM J. Control
Optim. 20 (1982) 221-246). The cost is piecewise quadratic with continuous slope, strictly convex by the proximal term:
once the pieces are found, one step ends at the solution, to rounding. A start near the solution finds them at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc import problem as problem_file
from gyroctl.controllers.nmpc import subproblem as subproblem_file
from gyroctl.controllers.nmpc.subproblem import (
    LIMIT_REACHED, NOT_CONVEX, NOT_FINITE, OUTPUTS, SOLVED, Step, bounds, evaluate, slope,
)  # fmt: skip
from gyroctl.plant.compiled import entry_point, source_stamp

FloatArray = NDArray[np.float64]

SUFFICIENT = 1e-4  # share of the linear decrease that a step must bring
SHORTEST = 1e-12  # part of a step below which no decrease can be measured


class RiccatiRoom(NamedTuple):
    """Arrays that the solver works in."""

    low: FloatArray  # (n,)
    high: FloatArray  # (n,)
    states: FloatArray  # (n, m)
    ahead: FloatArray  # (n, m)
    slopes: FloatArray  # (n, 3)
    new_slopes: FloatArray  # (n, 3)
    slope: FloatArray  # (n,)
    direction: FloatArray  # (n,)
    trial: FloatArray  # (n,)
    gain: FloatArray  # (n, m + 2): by the state, by the coupling before, constant
    held: NDArray[np.bool_]  # (n,)


def empty_riccati_room(n: int, m: int) -> RiccatiRoom:
    """Room for a horizon of `n` intervals of a model with `m` states."""
    return RiccatiRoom(
        np.zeros(n), np.zeros(n), np.zeros((n, m)), np.zeros((n, m)), np.zeros((n, 3)), np.zeros((n, 3)),
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, m + 2)), np.zeros(n, np.bool_),
    )  # fmt: skip


@entry_point
def newton_direction(qp: Any, proximal: float, room: Any) -> bool:
    """Solve the linear-quadratic problem about the present point.

    Read are `room.slope`, `room.slopes` (which outputs are beyond a limit), `room.held` and, for the held couplings,
    `room.direction`; written is `room.direction` of the others. The cost to go, with l the change before, is
    1/2 e'Pe + l c'e + 1/2 gamma l^2 + v'e + nu l.

    Returns
    -------
    bool
        Whether the problem is convex in the free couplings: the pivots of the sweep are those of its Hessian.
    """
    n, m = qp.b.shape
    p, w, c, v = np.zeros((m, m)), np.zeros((m, m)), np.zeros(m), np.zeros(m)
    pb, by_state, moved = np.zeros(m), np.zeros(m), np.zeros(m)
    gamma, nu = 0.0, 0.0
    twice, last_travel = 2.0 * qp.travel[0], 0.0
    empty = True  # P is zero until an output beyond its limit has been met
    for i in range(n - 1, -1, -1):
        a, b = qp.A[i], qp.b[i]
        for r in range(3):
            if room.slopes[i, r] != 0.0:
                p[OUTPUTS[r], OUTPUTS[r]] += qp.weight[r]
                empty = False
        # pb = P b + c; by_state = A' pb; moved = A' v; by_itself, constant: the quadratic in p_i
        by_itself, constant = gamma + twice + proximal, room.slope[i] + nu
        for row in range(m):
            total = 0.0
            if not empty:
                for column in range(m):
                    total += p[row, column] * b[column]
            by_itself += b[row] * (total + 2.0 * c[row])
            constant += b[row] * v[row]
            pb[row] = total + c[row]
        by_state[:] = 0.0
        moved[:] = 0.0
        for row in range(m):
            for column in range(m):
                by_state[column] += a[row, column] * pb[row]
                moved[column] += a[row, column] * v[row]
        if not empty:
            _congruence(p, a, w)
        last_travel = -twice
        if room.held[i]:
            given = room.direction[i]
            for row in range(m):
                c[row] = 0.0
                v[row] = moved[row] + by_state[row] * given
            gamma, nu = twice, last_travel * given
            continue
        if not by_itself > 0.0:
            return False
        for row in range(m):
            room.gain[i, row] = -by_state[row] / by_itself
        room.gain[i, m] = -last_travel / by_itself
        room.gain[i, m + 1] = -constant / by_itself
        for row in range(m):
            factor = room.gain[i, row]
            if not empty:
                for column in range(m):
                    p[row, column] += factor * by_state[column]
            c[row] = factor * last_travel
            v[row] = moved[row] + factor * constant
        gamma = twice + room.gain[i, m] * last_travel
        nu = room.gain[i, m] * constant
        if not empty:
            continue
        for row in range(m):  # the travel couples to the state even where P was zero
            if by_state[row] != 0.0:
                empty = False
        if not empty:
            for row in range(m):
                for column in range(m):
                    p[row, column] = room.gain[i, row] * by_state[column]
    e, before = np.zeros(m), 0.0
    for i in range(n):
        if not room.held[i]:
            total = room.gain[i, m] * before + room.gain[i, m + 1]
            for row in range(m):
                total += room.gain[i, row] * e[row]
            room.direction[i] = total
        before = room.direction[i]
        for row in range(m):
            total = qp.b[i, row] * before
            for column in range(m):
                total += qp.A[i, row, column] * e[column]
            moved[row] = total
        e[:] = moved
    return True


@entry_point
def _congruence(p: Any, a: Any, w: Any) -> None:
    """Overwrite symmetric `p` by a' p a; `w` is room."""
    m = p.shape[0]
    for row in range(m):
        w[row, :] = 0.0
        for inner in range(m):
            factor = p[row, inner]
            for column in range(m):
                w[row, column] += factor * a[inner, column]
    p[:, :] = 0.0
    for inner in range(m):
        for row in range(m):
            factor = a[inner, row]
            for column in range(m):
                p[row, column] += factor * w[inner, column]


def _solve(stamp: str) -> Callable[..., Step]:
    """Compile the solver; the stamp makes the cache forget code whose parts have changed."""

    @entry_point
    def solve(qp: Any, proximal: float, d: Any, tolerance: float, limit: int, room: Any) -> Step:
        """Solve a subproblem.

        Parameters
        ----------
        qp : Subproblem
            As `linearise` fills it.
        proximal : float
            Weight of |d|^2 / 2, positive. [J/(Nms)^2]
        d : (n,) array
            Start, and solution in place; zero or the last solution. [Nms]
        tolerance : float
            Largest distance from the solution. [Nms]
        limit : int
            Most Newton steps.
        room : RiccatiRoom
            Overwritten.

        Returns
        -------
        Step
            Status, iterations, the distance from the solution at most, value of the cost.
        """
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        n = d.size
        bounds(qp, room.low, room.high)
        room.trial[:] = 0.0
        nothing = evaluate(qp, proximal, room.trial, room.states, room.slopes)
        for i in range(n):
            d[i] = min(max(d[i], room.low[i]), room.high[i])
        cost = evaluate(qp, proximal, d, room.states, room.slopes)
        distance, status, count = np.inf, LIMIT_REACHED, 0
        for count in range(limit + 1):
            slope(qp, proximal, d, room.slopes, room.slope)
            square = 0.0
            for i in range(n):
                left = room.slope[i]
                if d[i] <= room.low[i]:
                    left = min(left, 0.0)
                if d[i] >= room.high[i]:
                    left = max(left, 0.0)
                square += left * left
            distance = np.sqrt(square) / proximal
            if not np.isfinite(distance + cost):
                status = NOT_FINITE
                break
            if distance <= tolerance:
                status = SOLVED
                break
            if count == limit:
                break
            near = min(1e-6, distance) * qp.cc_max[0]
            for i in range(n):
                room.held[i] = False
                if d[i] <= room.low[i] + near and room.slope[i] > 0.0:
                    room.held[i], room.direction[i] = True, room.low[i] - d[i]
                elif d[i] >= room.high[i] - near and room.slope[i] < 0.0:
                    room.held[i], room.direction[i] = True, room.high[i] - d[i]
            if not newton_direction(qp, proximal, room):
                status = NOT_CONVEX
                break
            part, accepted = 1.0, False
            while part > SHORTEST:
                decrease = 0.0
                for i in range(n):
                    room.trial[i] = min(max(d[i] + part * room.direction[i], room.low[i]), room.high[i])
                    decrease -= room.slope[i] * (room.trial[i] - d[i])
                found = evaluate(qp, proximal, room.trial, room.ahead, room.new_slopes)
                if found <= cost - SUFFICIENT * decrease:
                    accepted = True
                    break
                part *= 0.5
            if not accepted:  # as near as rounding lets the cost tell
                break
            d[:] = room.trial
            room.slopes[:] = room.new_slopes
            cost = found
        return Step(status, count, distance, cost - nothing)

    return solve


SOURCES = (__file__, subproblem_file.__file__, problem_file.__file__)
solve = _solve(source_stamp(SOURCES))
