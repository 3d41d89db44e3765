"""The planner with OSQP, the baseline: the same iterations, the quadratic program by a general solver.

It keeps its last solution to begin from, so that its plans repeat to its tolerance, not to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gyroctl.controllers.nmpc.prediction import STEPS, Kind, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import Problem, Weights
from gyroctl.controllers.nmpc.solvers.osqp_solver import OsqpSolver
from gyroctl.controllers.nmpc.solvers.real_time_iterations import empty_room, iterate_with


def osqp_planner(kind: Kind) -> Callable[..., None]:
    """Return a planner as `planner.planner_of` does."""
    step, tangent = step_of(kind), tangent_of(kind)
    built: dict[int, tuple[OsqpSolver, Any]] = {}

    def plan(*given: Any) -> None:
        start, moments, now, weights, h, k, cc, rivals, result, iterations, more, *_ = given
        power, before, cc_max, period, *margins = now.tolist()
        priced, width = Weights(*weights.tolist()), moments.size // (STEPS * cc.size + 1)
        problem = Problem(start, moments, power, before, cc_max, period, h, k, priced, width, np.array(margins))
        if cc.size not in built:
            built[cc.size] = OsqpSolver(cc.size, start.size), empty_room(cc.size, start.size)
        solver, room = built[cc.size]
        found = iterate_with(solver, step, tangent, problem, cc, float(result[1]), iterations, room)
        result[:2] = found.after, found.proximal
        for r, rival in enumerate(rivals.reshape(-1, cc.size) if more > 0 else ()):
            found = iterate_with(solver, step, tangent, problem, rival, float(result[2 + r]), more, room)
            result[2 + r] = found.proximal
            if found.after < result[0]:
                result[0] = found.after
                cc[:], rival[:] = rival.copy(), cc.copy()

    return plan
