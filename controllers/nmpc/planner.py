"""One call per sample: the problem of the moment from flat arrays, and the solver's iterations on it.

A tuple with two dozen fields takes longer to hand to compiled code than the iterations take; so what changes from
sample to sample comes as plain arrays, and the functions of the model by their addresses.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from numba import types
from numba.np.unsafe.ndarray import to_fixed_tuple

from gyroctl.controllers.nmpc import by_address
from gyroctl.controllers.nmpc.by_address import ROW, function_at
from gyroctl.controllers.nmpc.prediction import Orders, pullback_of, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import Problem, Weights
from gyroctl.controllers.nmpc.solvers import descent
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.descent import descend
from gyroctl.controllers.nmpc.solvers.planner_osqp import osqp_planner
from gyroctl.controllers.nmpc.solvers.real_time_iterations import (
    empty_condensed,
    empty_room,
    iterate_briefly,
    iterate_condensed,
)
from gyroctl.plant.compiled import entry_point, inlined, put, source_stamp

FIELDS = len(Weights._fields)


NEWTON, TOLERANCE = 4, 1e-4
"""Newton steps on a subproblem, each better than the last, and its tolerance [Nms]: a few serve as well as all."""

FRESH = {"condensed": 100.0, "riccati": 100.0, "osqp": 100.0, "descent": 1e-3}
"""Memory of a solver that begins anew: proximal weight [J/(Nms)^2], or step length [(Nms)^2/J]."""

MODEL = {
    "condensed": (step_of, pullback_of, tangent_of),
    "riccati": (step_of, pullback_of, tangent_of),
    "descent": (step_of, pullback_of),
}
"""Functions of the model that a solver takes."""

step_at, pullback_at, tangent_at = function_at(6), function_at(8), function_at(7)

RETRY_LENGTH = 1e-4  # first step of a descent from elsewhere [(Nms)^2/J]


@inlined
def problem_of(start: Any, moments: Any, now: Any, weights: Any, h: Any, k: Any) -> Problem:
    """Name what comes in flat arrays."""
    return Problem(start, moments, now[0], now[1], now[2], now[3], h, k, Weights(*to_fixed_tuple(weights, FIELDS)))


def _by_programs(stamp: str, condensed: bool) -> Any:
    """Compile a planner by quadratic programs; the stamp makes the cache forget code whose parts have changed."""

    @entry_point
    def plan(
        step_address: int,
        pullback_address: int,
        tangent_address: int,
        start: Any,
        moments: Any,
        now: Any,
        weights: Any,
        h: Any,
        k: Any,
        cc: Any,
        memory: float,
        iterations: int,
        other: Any,
        more: int,
    ) -> tuple[float, float]:
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        step, pullback, tangent = step_at(step_address), pullback_at(pullback_address), tangent_at(tangent_address)
        problem = problem_of(start, moments, now, weights, h, k)
        if condensed:
            room = empty_condensed(cc.size, problem.start.size)
            found = iterate_condensed(step, tangent, problem, cc, memory, iterations, NEWTON, TOLERANCE, room)
        else:
            room = empty_room(cc.size, problem.start.size)
            found = iterate_briefly(step, tangent, problem, cc, memory, iterations, NEWTON, TOLERANCE, room)
        return elsewhere(step, pullback, problem, cc, other, more, found.after), found.proximal

    return plan


def _by_descent(stamp: str) -> Any:
    """Compile the planner by gradients."""

    @entry_point
    def plan(
        step_address: int,
        pullback_address: int,
        start: Any,
        moments: Any,
        now: Any,
        weights: Any,
        h: Any,
        k: Any,
        cc: Any,
        memory: float,
        iterations: int,
        other: Any,
        more: int,
    ) -> tuple[float, float]:
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        step, pullback = step_at(step_address), pullback_at(pullback_address)
        problem = problem_of(start, moments, now, weights, h, k)
        _, cost, memory = descend(step, pullback, problem, cc, memory, iterations)
        return elsewhere(step, pullback, problem, cc, other, more, cost), memory

    return plan


@inlined
def elsewhere(step: Any, pullback: Any, problem: Any, cc: Any, other: Any, more: int, cost: float) -> float:
    """Improve the plan `other` by descent and write it over `cc` where it costs less; return the cost of `cc`."""
    if more > 0:
        _, found, _ = descend(step, pullback, problem, other, RETRY_LENGTH, more)
        if found < cost:
            put(other, cc)
            return float(found)
    return cost


STAMP = source_stamp((__file__, by_address.__file__, *descent.SOURCES, *rti.SOURCES))
_compiled = {
    "condensed": _by_programs(STAMP, True),
    "riccati": _by_programs(STAMP, False),
    "descent": _by_descent(STAMP),
}


def compile_planner(solver: str) -> None:
    """Compile a planner by the types of its arguments: the three functions of the model need not be there for it."""
    if solver not in _compiled:
        return
    addresses = [types.intp] * len(MODEL[solver])
    _compiled[solver].compile((*addresses, *[ROW] * 7, types.float64, types.int64, ROW, types.int64))


@lru_cache(maxsize=8)
def planner_of(orders: Orders, solver: str) -> Callable[..., tuple[float, float]]:
    """Choose ``plan(start, moments, now, weights, h, k, cc, memory, iterations, other, more)``.

    `now` holds power [W], last coupling, its limit [Nms] and the control interval [s]; `weights` the fields of
    `Weights`; the rest is as in `Problem`, with radiation filters of these orders. The plan `cc` is improved by the
    solver: "condensed", "riccati", "osqp" or "descent". With `more` > 0 iterations the plan `other` is improved by
    descent as well, and taken instead of `cc` where it costs less: there are many local optima, and a plan that is only
    ever shifted stays in its own.

    Returns
    -------
    function
        It returns the cost of the plan [J] and the memory that the solver goes on with, see `FRESH`.
    """
    if solver == "osqp":
        return osqp_planner(orders, RETRY_LENGTH)
    functions = [function_of(orders) for function_of in MODEL[solver]]
    addresses, solve = [function.address for function in functions], _compiled[solver]

    def plan(*given: Any) -> tuple[float, float]:
        assert functions  # kept: their machine code goes with them
        return solve(*addresses, *given)  # type: ignore[no-any-return]

    return plan
