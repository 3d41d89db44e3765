"""One call per sample: the problem of the moment from flat arrays, and the solver's iterations on it.

A tuple with two dozen fields takes longer to hand to compiled code than the iterations take, and a function pointer
almost as long; so both are bound here, once, and what changes from sample to sample comes as plain arrays.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.baseline import osqp_planner
from gyroctl.controllers.nmpc.descent import descend
from gyroctl.controllers.nmpc.prediction import Orders, pullback_of, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import Problem, Weights
from gyroctl.controllers.nmpc.rti import empty_room, iterate

FIELDS = len(Weights._fields)


NEWTON, TOLERANCE = 4, 1e-4
"""Newton steps on a subproblem, each better than the last, and its tolerance [Nms]: a few serve as well as all."""

FRESH = {"riccati": 100.0, "osqp": 100.0, "descent": 1e-3}
"""Memory of a solver that begins anew: proximal weight [J/(Nms)^2], or step length [(Nms)^2/J]."""

RETRY_LENGTH = 1e-4  # first step of a descent from elsewhere [(Nms)^2/J]


@lru_cache(maxsize=8)
def planner_of(orders: Orders, solver: str) -> Any:
    """Compile ``plan(start, moments, now, weights, h, k, cc, memory, iterations, other, more)``.

    `now` holds power [W], last coupling, its limit [Nms] and the control interval [s]; `weights` the fields of
    `Weights`; the rest is as in `Problem`, with radiation filters of these orders. The plan `cc` is improved by the
    solver: "riccati", "osqp" or "descent". With `more` > 0 iterations the plan `other` is improved by descent as well,
    and taken instead of `cc` where it costs less: there are many local optima, and a plan that is only ever shifted
    stays in its own.

    Returns
    -------
    function
        It returns the cost of the plan [J] and the memory that the solver goes on with, see `FRESH`.
    """
    if solver == "osqp":
        return osqp_planner(orders, RETRY_LENGTH)
    step, pullback = step_of(orders), pullback_of(orders)

    @njit(nogil=True)  # type: ignore[untyped-decorator]
    def descended(problem: Problem, cc: Any, memory: float, iterations: int) -> tuple[float, float]:
        _, cost, length = descend(step, pullback, problem, cc, memory, iterations)
        return cost, length

    improve = descended
    if solver == "riccati":
        tangent = tangent_of(orders)

        @njit(nogil=True)  # type: ignore[untyped-decorator]
        def iterated(problem: Problem, cc: Any, memory: float, iterations: int) -> tuple[float, float]:
            room = empty_room(cc.size, problem.start.size)
            found = iterate(step, tangent, problem, cc, memory, iterations, NEWTON, TOLERANCE, room)
            return found.after, found.proximal

        improve = iterated

    @njit(nogil=True)  # type: ignore[untyped-decorator]
    def plan(
        start: NDArray[np.float64], moments: NDArray[np.float64], now: NDArray[np.float64],
        weights: NDArray[np.float64], h: NDArray[np.float64], k: NDArray[np.float64], cc: NDArray[np.float64],
        memory: float, iterations: int, other: NDArray[np.float64], more: int,
    ) -> tuple[float, float]:  # fmt: skip
        problem = Problem(
            start, moments, now[0], now[1], now[2], now[3], h, k, Weights(*to_fixed_tuple(weights, FIELDS))
        )  # fmt: skip
        cost, memory = improve(problem, cc, memory, iterations)
        if more > 0:
            found, _ = descended(problem, other, RETRY_LENGTH, more)
            if found < cost:
                cc[:] = other
                cost = found
        return cost, memory

    return plan
