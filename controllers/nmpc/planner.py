"""One call per sample: the problem of the moment from flat arrays, and the solver's iterations on it.

A tuple with two dozen fields takes longer to hand to compiled code than the iterations take; so what changes from
sample to sample comes as plain arrays, and the functions of the model by their addresses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numba import types
from numba.np.unsafe.ndarray import to_fixed_tuple

from gyroctl.controllers.nmpc import by_address
from gyroctl.controllers.nmpc.by_address import ROW, function_at
from gyroctl.controllers.nmpc.prediction import STEPS, Kind, beside_of, pullback_of, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import NOW, Problem, Weights
from gyroctl.controllers.nmpc.solvers import descent
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.descent import descend
from gyroctl.controllers.nmpc.solvers.planner_osqp import osqp_planner
from gyroctl.controllers.nmpc.solvers.real_time_iterations import empty_room, iterate_briefly
from gyroctl.controllers.nmpc.solvers.side_by_side import empty_side_by_side, improve, vary
from gyroctl.plant.compiled import callback, entry_point, inlined, put, source_stamp, within

FIELDS = len(Weights._fields)

NEWTON, TOLERANCE = 4, 1e-4
"""Newton steps on a subproblem where nothing else is said, each better than the last, and its tolerance [Nms]."""

FRESH = {"condensed": 100.0, "riccati": 100.0, "osqp": 100.0, "descent": 1e-3}
"""Memory of a solver that begins anew: proximal weight [J/(Nms)^2], or step length [(Nms)^2/J]."""

ELSEWHERE = {"condensed": 1.0, "riccati": 1.0, "osqp": 1.0, "descent": 1e-4}
"""The same for a plan that is begun elsewhere: with large steps it has soon left where it began."""

GRADIENTS = 5
"""Steps of `descent` that a plan begun elsewhere gets for each iteration by programs."""

MODEL = {
    "condensed": (step_of, tangent_of, beside_of),
    "riccati": (step_of, tangent_of),
    "descent": (step_of, pullback_of),
}
"""Functions of the model that a solver takes."""

MOST = 3
"""Functions of the model that a planner is given the addresses of; where it takes fewer, the rest are 0."""

step_at, pullback_at, tangent_at, beside_at = function_at(6), function_at(8), function_at(4), function_at(4)

swept_iterations = within(iterate_briefly)

PLAN = types.void(*[types.intp] * MOST, *[ROW] * 9, *[types.int64] * 4)
"""Of ``plan(step, slope, beside, start, moments, now, weights, h, k, cc, rivals, result, *counts)``.

The counts are iterations, more, varied and newton, see `compiled_planner`."""


@inlined
def problem_of(start: Any, moments: Any, now: Any, weights: Any, h: Any, k: Any, n: int) -> Problem:
    """Name what comes in flat arrays, for a plan of n intervals."""
    priced, width = Weights(*to_fixed_tuple(weights, FIELDS)), moments.size // (STEPS * n + 1)
    return Problem(start, moments, now[0], now[1], now[2], now[3], h, k, priced, width, now[NOW:])


def _by_dense_programs(stamp: str) -> Any:
    """Text of a planner by condensed programs; the stamp makes the cache forget code whose parts have changed."""

    def plan(
        step_address: int,
        tangent_address: int,
        beside_address: int,
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
        varied: int,
        newton: int,
    ) -> None:
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        step, tangent, beside = step_at(step_address), tangent_at(tangent_address), beside_at(beside_address)
        problem = problem_of(start, moments, now, weights, h, k, cc.size)
        n = cc.size
        for _ in range(varied):
            vary(step, beside, problem, cc)
        count = 1 + (rivals.size // n if more > 0 else 0)
        room = empty_side_by_side(count, n, start.size)
        plans, turns = np.empty((count, n)), np.empty(count, np.int64)
        put(cc, plans[0])
        turns[0] = iterations
        for r in range(1, count):
            put(rivals[n * (r - 1) : n * r], plans[r])
            turns[r] = more
        improve(step, beside, tangent, problem, plans, result[1:], turns, newton, TOLERANCE, room)
        result[0] = room.costs[0]
        put(plans[0], cc)
        for r in range(1, count):
            rival = rivals[n * (r - 1) : n * r]
            put(plans[r], rival)
            if room.costs[r] < result[0]:  # the two change places: the loser goes on as a rival
                result[0] = room.costs[r]
                for i in range(n):
                    rival[i], cc[i] = cc[i], rival[i]

    return plan


def _by_programs(stamp: str) -> Any:
    """Text of a planner by programs of the states and couplings together."""

    def plan(
        step_address: int,
        tangent_address: int,
        ignored: int,
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
        varied: int,
        newton: int,
    ) -> None:
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        step, tangent = step_at(step_address), tangent_at(tangent_address)
        problem = problem_of(start, moments, now, weights, h, k, cc.size)
        room = empty_room(cc.size, start.size)
        n = cc.size
        for begun in range(1 + rivals.size // n if more > 0 else 1):  # the plan, then each rival: one compiled place
            tried, count, memory = cc, iterations, result[1]
            if begun > 0:
                tried, count, memory = rivals[n * (begun - 1) : n * begun], more, result[1 + begun]
            found = swept_iterations(step, tangent, problem, tried, memory, count, newton, TOLERANCE, room)
            if begun == 0:
                result[0], result[1] = found.after, found.proximal
                continue
            result[1 + begun] = found.proximal
            if found.after < result[0]:  # as above
                result[0] = found.after
                for i in range(n):
                    tried[i], cc[i] = cc[i], tried[i]

    return plan


def _by_descent(stamp: str) -> Any:
    """Text of the planner by gradients."""

    def plan(
        step_address: int,
        pullback_address: int,
        ignored: int,
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
        varied: int,
        newton: int,
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


TEXTS = {"condensed": _by_dense_programs, "riccati": _by_programs, "descent": _by_descent}

STAMP = source_stamp((__file__, by_address.__file__, *descent.SOURCES, *rti.SOURCES))


@lru_cache(maxsize=4)
def compiled_planner(solver: str) -> Any:
    """Compile a planner, see `PLAN`: the functions of the model need not be there for it.

    The plan `cc` (n,) is improved by so many `iterations` of the solver "condensed", "riccati" or "descent", a program
    of the first two by `newton` steps: each is better than the last, and a few serve as well as all. `now`
    holds power [W], last coupling, its limit [Nms] and the control interval [s], and behind them the margins of the
    `Problem`, (n,) or none; `weights` the fields of `Weights`; the
    rest is as in `Problem`. `result` (2 + rivals,) holds what the solver remembers of the plan, see `FRESH`, as its
    second number, and of each rival behind it; all are written, the cost of the plan [J] is the first. With `more` > 0
    iterations each of the `rivals`, plans one after the other, is improved as well, and changes places with `cc` where
    it costs less: there are many local optima, and a plan that is only ever shifted stays in its own. Before all that
    "condensed", and it alone, replaces the plan `varied` times by the best of its variations, see `side_by_side.vary`.
    """
    return callback(TEXTS[solver](STAMP), PLAN)


@lru_cache(maxsize=8)
def model_of(kind: Kind, solver: str) -> tuple[Any, ...]:
    """Functions of the model of a kind that a solver takes."""
    return tuple(function(kind) for function in MODEL[solver])


def addresses_of(model: Sequence[Any]) -> tuple[int, ...]:
    """Addresses of such functions as a planner is given them."""
    return *(function.address for function in model), *[0] * (MOST - len(model))


plan_at = by_address.function_of(PLAN)


@entry_point
def plan_by_address(
    address: int,
    step: int,
    slope: int,
    beside: int,
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
    varied: int,
    newton: int,
) -> None:
    """Call a planner from Python."""
    plan_at(address)(
        step, slope, beside, start, moments, now, weights, h, k, cc, rivals, result, iterations, more, varied, newton
    )


def planner_of(kind: Kind, solver: str) -> Callable[..., None]:
    """Return ``plan(start, moments, now, weights, h, k, cc, rivals, result, *counts)`` of any solver, see `PLAN`.

    As `compiled_planner`, with the functions of the model in it, and with "osqp" among the solvers.
    """
    if solver == "osqp":
        return osqp_planner(kind)
    planner, model = compiled_planner(solver), model_of(kind, solver)
    addresses = planner.address, *addresses_of(model)

    def plan(*given: Any) -> None:
        assert planner and model  # kept: their machine code goes with them
        plan_by_address(*addresses, *given)

    return plan
