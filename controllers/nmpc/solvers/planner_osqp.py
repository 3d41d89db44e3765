"""The planner with OSQP, the baseline: the same iterations, the quadratic program by a general solver.

It keeps its last solution to begin from, so that its plans repeat to its tolerance, not to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gyroctl.controllers.nmpc.prediction import Orders, pullback_of, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import Problem, Weights
from gyroctl.controllers.nmpc.solvers.descent import descend
from gyroctl.controllers.nmpc.solvers.osqp_solver import OsqpSolver
from gyroctl.controllers.nmpc.solvers.real_time_iterations import empty_room, iterate_with


def osqp_planner(orders: Orders, retry_length: float) -> Callable[..., tuple[float, float]]:
    """Return a planner with the arguments and the answer of those of `planner.planner_of`."""
    step, pullback, tangent = step_of(orders), pullback_of(orders), tangent_of(orders)
    built: dict[int, tuple[OsqpSolver, Any]] = {}

    def plan(*given: Any) -> tuple[float, float]:
        start, moments, now, weights, h, k, cc, memory, iterations, other, more = given
        power, before, cc_max, period = now.tolist()
        problem = Problem(start, moments, power, before, cc_max, period, h, k, Weights(*weights.tolist()))
        if cc.size not in built:
            built[cc.size] = OsqpSolver(cc.size, start.size), empty_room(cc.size, start.size)
        solver, room = built[cc.size]
        found = iterate_with(solver, step, tangent, problem, cc, memory, iterations, room)
        cost = found.after
        if more > 0:
            _, elsewhere, _ = descend(step, pullback, problem, other, retry_length, more)
            if elsewhere < cost:
                cc[:], cost = other, elsewhere
        return cost, found.proximal

    return plan
