"""Real-time iterations of several plans at once: their predictions, a good half of the work, go side by side.

What becomes of a plan is bit for bit what `real_time_iterations.iterate_with` makes of it alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc import solvers
from gyroctl.controllers.nmpc.casadi_to_numba import BESIDE
from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.controllers.nmpc.problem import cost_of, predict
from gyroctl.controllers.nmpc.solvers.condensed import empty_condensed_room, solve
from gyroctl.controllers.nmpc.solvers.real_time_iterations import HALVINGS, PROXIMAL_MAX, at_rest, went_well
from gyroctl.controllers.nmpc.solvers.subproblem import NOT_FINITE, SOLVED, Subproblem, empty_subproblem, linearise
from gyroctl.plant.compiled import inlined, part, put, put_table, source_stamp, within

FloatArray = NDArray[np.float64]

ALONE = 1
"""Plans up to which it takes less time to predict one after the other."""


class Room(NamedTuple):
    """Arrays that the plans are worked on in."""

    qp: Subproblem
    inner: Any  # CondensedRoom
    beside: FloatArray  # (BESIDE (m + 2),) states, couplings and powers, see `prediction.beside_of`
    states: FloatArray  # (plans, n STEPS + 1, m) of each plan as it is
    ahead: FloatArray  # the same, of a plan that is tried
    d: FloatArray  # (plans, n) [Nms]
    trial: FloatArray  # (plans, n) [Nms]
    costs: FloatArray  # (plans,) of plans as they are [J]
    found: FloatArray  # (plans,) of plans that are tried [J]
    promised: FloatArray  # (plans,) [J]
    share: FloatArray  # (plans,) of the step that is tried
    chosen: NDArray[np.int64]  # (plans,) those that are predicted next, in front
    status: NDArray[np.int64]  # (plans,) of the last program of each, see `subproblem.SOLVED`


@inlined
def empty_side_by_side(plans: int, n: int, m: int) -> Room:
    """Room for so many plans of `n` intervals with a model of `m` states."""
    states, ahead = np.empty((plans, STEPS * n + 1, m)), np.empty((plans, STEPS * n + 1, m))
    d, trial, each = np.empty((plans, n)), np.empty((plans, n)), np.empty((4, plans))
    chosen, status = np.zeros(plans, np.int64), np.zeros(plans, np.int64)
    shared = empty_subproblem(n, m), empty_condensed_room(n, m), np.empty(BESIDE * (m + 2))
    return Room(*shared, states, ahead, d, trial, each[0], each[1], each[2], each[3], chosen, status)


HELD, FREE = (1, 2, 4), (1, 3)
"""Intervals for which a variation of a plan begins with all the coupling, and with none."""


def _compiled(stamp: str) -> tuple[Callable[..., None], Callable[..., None], Callable[..., None]]:
    """Compile all; the stamp makes the cache forget code whose parts have changed."""
    linearised, solved = within(linearise), within(solve)

    @part()
    def predict_all(
        step: Any, beside: Any, problem: Any, plans: Any, chosen: Any, count: int, room: Any, states: Any, costs: Any
    ) -> None:
        """Predict the plans `chosen`, the first `count` of them: their `states` and `costs` [J] are written."""
        assert stamp
        n, m, width = plans.shape[1], problem.start.size, problem.width
        if count <= ALONE:
            for l in range(count):
                costs[chosen[l]] = predict(step, problem, plans[chosen[l]], states[chosen[l]])
            return
        for first in range(0, count, BESIDE):
            last = min(first + BESIDE, count) - 1
            for l in range(BESIDE):  # places that are left go along with the last plan
                for j in range(m):
                    room[BESIDE * j + l] = problem.start[j]
                room[BESIDE * (m + 1) + l] = problem.power
            for l in range(first, last + 1):
                put(problem.start, states[chosen[l], 0])
            for i in range(n):
                for l in range(BESIDE):
                    room[BESIDE * m + l] = plans[chosen[min(first + l, last)], i]
                for q in range(STEPS * i, STEPS * (i + 1)):
                    beside(problem.moments[width * q : width * (q + 2)], problem.h, problem.k, room)
                    for l in range(first, last + 1):
                        for j in range(m):
                            states[chosen[l], q + 1, j] = room[BESIDE * j + l - first]
            for l in range(first, last + 1):
                costs[chosen[l]] = cost_of(problem, plans[chosen[l]], states[chosen[l]])

    @part()
    def improve(
        step: Any,
        beside: Any,
        tangent: Any,
        problem: Any,
        plans: Any,
        proximal: Any,
        iterations: Any,
        newton: int,
        tolerance: float,
        r: Any,
    ) -> None:
        """Improve the `plans` (plans, n) [Nms] in place, each by its number of `iterations` (plans,).

        `step`, `beside`, `tangent` come from `prediction`; `newton` and `tolerance` are as in
        `real_time_iterations.iterate`. `proximal` (plans,) [J/(Nms)^2] is what is remembered of each plan; costs and
        states are left in the room `r`.
        """
        assert stamp
        count, n = plans.shape
        for p in range(count):
            r.chosen[p], r.status[p] = p, SOLVED
            for i in range(n):
                plans[p, i] = min(max(plans[p, i], 0.0), problem.cc_max)
        predict_all(step, beside, problem, plans, r.chosen, count, r.beside, r.states, r.costs)
        for turn in range(np.max(iterations)):
            going = 0
            for p in range(count):
                if turn >= iterations[p] or r.status[p] == NOT_FINITE:
                    continue
                if not linearised(tangent, problem, plans[p], r.states[p], r.qp):
                    r.status[p] = NOT_FINITE
                    continue
                r.d[p, :] = 0.0
                change = solved(r.qp, proximal[p], r.d[p], tolerance, newton, r.inner)
                r.status[p], r.promised[p], r.share[p] = change.status, -change.value, 1.0
                if change.status == NOT_FINITE:
                    continue
                if r.promised[p] > 0.0:
                    r.chosen[going] = p
                    going += 1
                else:
                    proximal[p] = at_rest(proximal[p])
            for _ in range(HALVINGS):  # those that cost less are done, of the others half the step is tried
                for l in range(going):
                    p = r.chosen[l]
                    for i in range(n):
                        r.trial[p, i] = min(max(plans[p, i] + r.share[p] * r.d[p, i], 0.0), problem.cc_max)
                predict_all(step, beside, problem, r.trial, r.chosen, going, r.beside, r.ahead, r.found)
                left = 0
                for l in range(going):
                    p = r.chosen[l]
                    if r.found[p] < r.costs[p]:  # not a number counts as no improvement
                        proximal[p] = went_well(r.costs[p] - r.found[p], r.promised[p], r.share[p], proximal[p])
                        put(r.trial[p], plans[p])
                        put_table(r.ahead[p], r.states[p])
                        r.costs[p] = r.found[p]
                    else:
                        r.share[p] *= 0.5
                        r.chosen[left] = p
                        left += 1
                going = left
                if going == 0:
                    break
            for l in range(going):
                proximal[r.chosen[l]] = min(9.0 * proximal[r.chosen[l]], PROXIMAL_MAX)

    @part()
    def vary(step: Any, beside: Any, problem: Any, cc: Any) -> None:
        """Replace the plan `cc` (n,) [Nms] by the best of its variations where one costs less.

        They begin with all the coupling or none, or switch a control interval sooner or later: what a slope does not
        tell, since close to pull-out the cost has many valleys side by side.
        """
        assert stamp
        n = cc.size
        plans, room = np.empty((BESIDE, n)), np.empty(BESIDE * (problem.start.size + 2))
        states, costs = np.empty((BESIDE, STEPS * n + 1, problem.start.size)), np.empty(BESIDE)
        for p in range(BESIDE):
            for i in range(n):
                plans[p, i] = cc[i]
        for j in range(len(HELD)):
            for i in range(HELD[j]):
                plans[1 + j, i] = problem.cc_max
        for j in range(len(FREE)):
            for i in range(FREE[j]):
                plans[1 + len(HELD) + j, i] = 0.0
        for i in range(n - 1):
            plans[BESIDE - 2, i] = cc[i + 1]
            plans[BESIDE - 1, i + 1] = cc[i]
        predict_all(step, beside, problem, plans, np.arange(BESIDE), BESIDE, room, states, costs)
        best = 0
        for p in range(1, BESIDE):
            if costs[p] < costs[best]:
                best = p
        put(plans[best], cc)

    return predict_all, improve, vary


predict_all, improve, vary = _compiled(source_stamp(solvers.SOURCES))
