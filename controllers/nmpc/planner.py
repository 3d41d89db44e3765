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
from gyroctl.controllers.nmpc.prediction import STEPS, Kind, pullback_of, step_of, tangent_of
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
from gyroctl.plant.compiled import callback, entry_point, inlined, source_stamp, within

FIELDS = len(Weights._fields)

NEWTON, TOLERANCE = 4, 1e-4
"""Newton steps on a subproblem, each better than the last, and its tolerance [Nms]: a few serve as well as all."""

FRESH = {"condensed": 100.0, "riccati": 100.0, "osqp": 100.0, "descent": 1e-3}
"""Memory of a solver that begins anew: proximal weight [J/(Nms)^2], or step length [(Nms)^2/J]."""

ELSEWHERE = {"condensed": 1.0, "riccati": 1.0, "osqp": 1.0, "descent": 1e-4}
"""The same for a plan that is begun elsewhere: with large steps it has soon left where it began."""

GRADIENTS = 5
"""Steps of `descent` that a plan begun elsewhere gets for each iteration by programs."""

MODEL = {"condensed": (step_of, tangent_of), "riccati": (step_of, tangent_of), "descent": (step_of, pullback_of)}
"""Functions of the model that a solver takes."""

step_at, pullback_at, tangent_at = function_at(6), function_at(8), function_at(4)

condensed_iterations, swept_iterations = within(iterate_condensed), within(iterate_briefly)

PLAN = types.void(types.intp, types.intp, *[ROW] * 9, types.int64, types.int64)
"""Of ``plan(step, slope, start, moments, now, weights, h, k, cc, rivals, result, iterations, more)``."""


@inlined
def problem_of(start: Any, moments: Any, now: Any, weights: Any, h: Any, k: Any, n: int) -> Problem:
    """Name what comes in flat arrays, for a plan of n intervals."""
    priced, width = Weights(*to_fixed_tuple(weights, FIELDS)), moments.size // (STEPS * n + 1)
    return Problem(start, moments, now[0], now[1], now[2], now[3], h, k, priced, width)


def _by_programs(stamp: str, condensed: bool) -> Any:
    """Text of a planner by quadratic programs; the stamp makes the cache forget code whose parts have changed."""

    def plan(
        step_address: int,
        tangent_address: int,
        start: Any,
        moments: Any,
        now: Any,
        weights: Any,
        h: Any,
        k: Any,
        cc: Any,
        rivals: Any,
        result: Any,
        iterations: int,
        more: int,
    ) -> None:
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        step, tangent = step_at(step_address), tangent_at(tangent_address)
        problem = problem_of(start, moments, now, weights, h, k, cc.size)
        room = (empty_condensed if condensed else empty_room)(cc.size, start.size)
        n = cc.size
        for begun in range(1 + rivals.size // n if more > 0 else 1):  # the plan, then each rival: one compiled place
            tried, count, memory = cc, iterations, result[1]
            if begun > 0:
                tried, count, memory = rivals[n * (begun - 1) : n * begun], more, result[1 + begun]
            if condensed:
                found = condensed_iterations(step, tangent, problem, tried, memory, count, NEWTON, TOLERANCE, room)
            else:
                found = swept_iterations(step, tangent, problem, tried, memory, count, NEWTON, TOLERANCE, room)
            if begun == 0:
                result[0], result[1] = found.after, found.proximal
                continue
            result[1 + begun] = found.proximal
            if found.after < result[0]:  # the two change places: the loser goes on as a rival
                result[0] = found.after
                for i in range(n):
                    tried[i], cc[i] = cc[i], tried[i]

    return plan


def _by_descent(stamp: str) -> Any:
    """Text of the planner by gradients."""

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
        rivals: Any,
        result: Any,
        iterations: int,
        more: int,
    ) -> None:
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        step, pullback = step_at(step_address), pullback_at(pullback_address)
        problem = problem_of(start, moments, now, weights, h, k, cc.size)
        _, cost, memory = descend(step, pullback, problem, cc, result[1], iterations)
        result[0], result[1] = cost, memory
        n = cc.size
        if more > 0:
            for r in range(rivals.size // n):
                tried = rivals[n * r : n * (r + 1)]
                _, found, result[2 + r] = descend(step, pullback, problem, tried, result[2 + r], GRADIENTS * more)
                if found < result[0]:
                    result[0] = found
                    for i in range(n):
                        tried[i], cc[i] = cc[i], tried[i]

    return plan


STAMP = source_stamp((__file__, by_address.__file__, *descent.SOURCES, *rti.SOURCES))


@lru_cache(maxsize=4)
def compiled_planner(solver: str) -> Any:
    """Compile a planner, see `PLAN`: the functions of the model need not be there for it.

    The plan `cc` (n,) is improved by so many `iterations` of the solver "condensed", "riccati" or "descent". `now`
    holds power [W], last coupling, its limit [Nms] and the control interval [s]; `weights` the fields of `Weights`; the
    rest is as in `Problem`. `result` (2 + rivals,) holds what the solver remembers of the plan, see `FRESH`, as its
    second number, and of each rival behind it; all are written, the cost of the plan [J] is the first. With `more` > 0
    iterations each of the `rivals`, plans one after the other, is improved as well, and changes places with `cc` where
    it costs less: there are many local optima, and a plan that is only ever shifted stays in its own.
    """
    text = _by_descent(STAMP) if solver == "descent" else _by_programs(STAMP, solver == "condensed")
    return callback(text, PLAN)


@lru_cache(maxsize=8)
def model_of(kind: Kind, solver: str) -> tuple[Any, Any]:
    """Functions of the model of a kind that a solver takes."""
    first, second = MODEL[solver]
    return first(kind), second(kind)


plan_at = by_address.function_of(PLAN)


@entry_point
def plan_by_address(
    address: int,
    step: int,
    slope: int,
    start: Any,
    moments: Any,
    now: Any,
    weights: Any,
    h: Any,
    k: Any,
    cc: Any,
    rivals: Any,
    result: Any,
    iterations: int,
    more: int,
) -> None:
    """Call a planner from Python."""
    plan_at(address)(step, slope, start, moments, now, weights, h, k, cc, rivals, result, iterations, more)


def planner_of(kind: Kind, solver: str) -> Callable[..., None]:
    """Return ``plan(start, moments, now, weights, h, k, cc, rivals, result, iterations, more)`` of any solver.

    As `compiled_planner`, with the functions of the model in it, and with "osqp" among the solvers.
    """
    if solver == "osqp":
        return osqp_planner(kind)
    planner, model = compiled_planner(solver), model_of(kind, solver)
    addresses = planner.address, *(function.address for function in model)

    def plan(*given: Any) -> None:
        assert planner and model  # kept: their machine code goes with them
        plan_by_address(*addresses, *given)

    return plan
