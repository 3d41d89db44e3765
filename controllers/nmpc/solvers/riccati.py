"""Exact solution of the linearised horizon in O(n): Newton's method on the free couplings, each system a Riccati sweep.

The couplings that sit on a bound and want to stay there are held; a Newton step in the others is the solution of a
linear-quadratic control problem, which one Riccati sweep gives. The step is projected onto the bounds, as far as the
cost falls along the bent path: projected Newton (Bertsekas, SIAM J. Control Optim. 20 (1982) 221-246). The cost is
piecewise quadratic with continuous slope, strictly convex by the proximal term: once the pieces are found, one step
ends at the solution, to rounding. Two or three sweeps do for most plans. In one of ten, many bounds and limits trade
places and the path bends too soon; after PATIENCE sweeps an interior point method finds the pieces instead.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from gyroctl.controllers.nmpc.solvers import SOURCES, subproblem
from gyroctl.controllers.nmpc.solvers.bent_path import ROUNDING, SHORTEST, SUFFICIENT, hold, steepness
from gyroctl.controllers.nmpc.solvers.interior_point import InteriorRoom, empty_interior_room, interior_point
from gyroctl.controllers.nmpc.solvers.riccati_sweep import SweepRoom, empty_sweep_room, sweep
from gyroctl.controllers.nmpc.solvers.subproblem import Step, bounds, evaluate, slope
from gyroctl.plant.compiled import entry_point, inlined, put, put_table, source_stamp

PATIENCE = 7
INTERIOR = 40  # most iterations of the interior point method, of two sweeps each


class RiccatiRoom(NamedTuple):
    """Arrays that the solver works in."""

    sweep: SweepRoom
    interior: InteriorRoom


@inlined
def empty_riccati_room(n: int, m: int) -> RiccatiRoom:
    """Room for a horizon of `n` intervals of a model with `m` states."""
    return RiccatiRoom(empty_sweep_room(n, m), empty_interior_room(n))


@inlined
def _act(qp: Any, room: Any) -> None:
    """Choose the limits that act."""
    for i in range(room.held.size):
        for r in range(3):
            room.curvature[i, r] = qp.weight[r] if room.slopes[i, r] != 0.0 else 0.0


@inlined
def _shortened(qp: Any, proximal: float, d: Any, cost: float, rounding: float, room: Any) -> tuple[bool, float]:
    """Go along the bent path as far as the cost falls; return whether it did, and the cost."""
    part = 1.0
    while part > SHORTEST:
        decrease = 0.0
        for i in range(d.size):
            room.trial[i] = min(max(d[i] + part * room.direction[i], room.low[i]), room.high[i])
            decrease -= room.slope[i] * (room.trial[i] - d[i])
        found = evaluate(qp, proximal, room.trial, room.ahead, room.new_slopes)
        if found <= cost - SUFFICIENT * decrease + rounding:
            put(room.trial, d)
            put_table(room.new_slopes, room.slopes)
            return True, found
        part *= 0.5
    return False, cost


def _solve(stamp: str, rescue: bool) -> Callable[..., Step]:
    """Compile the solver, with the interior point method or without; the stamp is as in `subproblem`."""

    @entry_point
    def solve(qp: Any, proximal: float, d: Any, tolerance: float, limit: int, rooms: Any) -> Step:
        """Solve a subproblem that `linearise` has filled; `d` (n,) is the start [Nms] and becomes the solution.

        `proximal` is the weight of |d|^2 / 2, positive [J/(Nms)^2], `tolerance` the largest distance from the solution
        [Nms], `limit` the most projected Newton steps: up to PATIENCE of them the interior point method is never
        called. The `rooms`, a RiccatiRoom, are overwritten.
        """
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        room = rooms.sweep
        bounds(qp, room.low, room.high)
        room.trial[:] = 0.0
        nothing = evaluate(qp, proximal, room.trial, room.states, room.slopes)
        for i in range(d.size):
            d[i] = min(max(d[i], room.low[i]), room.high[i])
        cost = evaluate(qp, proximal, d, room.states, room.slopes)
        rounding = ROUNDING * (1.0 + abs(cost) + abs(nothing))
        distance, status, count, inner = np.inf, subproblem.LIMIT_REACHED, 0, 0
        room.barrier[:] = 0.0
        for count in range(limit + 1):
            slope(qp, proximal, d, room.slopes, room.slope)
            square, whole = steepness(d, room)
            distance = np.sqrt(square) / proximal
            if not np.isfinite(distance + cost):
                status = subproblem.NOT_FINITE
                break
            if distance <= tolerance or square <= ROUNDING**2 * whole:  # the slope itself is no better known
                status = subproblem.SOLVED
                break
            if count == limit:
                break
            if rescue and count == PATIENCE:
                put(d, room.trial)
                inner = 2 * interior_point(qp, proximal, d, 1e-9, INTERIOR, room, rooms.interior)
                room.barrier[:] = 0.0
                found = evaluate(qp, proximal, d, room.states, room.slopes)
                if not found <= cost:
                    put(room.trial, d)
                    found = evaluate(qp, proximal, d, room.states, room.slopes)
                cost = found
                continue
            hold(d, min(1e-6, distance) * qp.cc_max[0], room)
            _act(qp, room)
            if not sweep(qp, proximal, room):
                status = subproblem.NOT_CONVEX
                break
            accepted, cost = _shortened(qp, proximal, d, cost, rounding, room)
            if not accepted:  # as near as rounding lets the cost tell
                break
        return Step(status, count + inner, distance, cost - nothing)

    return solve


solve = _solve(source_stamp(SOURCES), True)
solve_briefly = _solve(source_stamp(SOURCES), False)
"""`solve` for a few Newton steps: without the interior point method, whose machine code takes seconds to make."""
