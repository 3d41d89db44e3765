"""Real-time iterations: compiled as the plain ones, safe steps, a local optimum at the end."""

from __future__ import annotations

import numpy as np
import pytest
from nmpc_subproblems import CC_MAX, DEVICE, PULLBACK, STEP, TANGENT, ByCondensing, M, N, horizon
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.planner import NEWTON, planner_of
from gyroctl.controllers.nmpc.prediction import STEPS, linear_kind
from gyroctl.controllers.nmpc.problem import Problem, gradient, predict
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.osqp_solver import OsqpSolver
from gyroctl.controllers.nmpc.solvers.riccati import PATIENCE, empty_riccati_room, solve
from gyroctl.controllers.nmpc.solvers.subproblem import NOT_FINITE, SOLVED, Step, Subproblem

Array = NDArray[np.float64]


class ByRiccati:
    """The compiled solver behind the interface of the others."""

    def solve(self, qp: Subproblem, proximal: float, d: Array) -> Step:
        return solve(qp, proximal, d, 1e-6, 10, empty_riccati_room(N, M))


def test_compiled_iteration_is_the_plain_one() -> None:
    problem, plan = horizon()
    one, two = plan.copy(), plan.copy()
    a = rti.iterate(STEP, TANGENT, problem, one, 100.0, 5, 10, 1e-6, rti.empty_room(N, M))
    b = rti.iterate_with(ByRiccati(), STEP, TANGENT, problem, two, 100.0, 5, rti.empty_room(N, M))
    assert a == b and np.array_equal(one, two)


@pytest.mark.parametrize("newton", [1, 4, PATIENCE])
def test_brief_iteration_is_the_full_one_while_the_interior_point_method_is_not_called(newton: int) -> None:
    problem, plan = horizon()
    one, two = plan.copy(), plan.copy()
    a = rti.iterate(STEP, TANGENT, problem, one, 1.0, 5, newton, 1e-9, rti.empty_room(N, M))
    b = rti.iterate_briefly(STEP, TANGENT, problem, two, 1.0, 5, newton, 1e-9, rti.empty_room(N, M))
    assert a == b and np.array_equal(one, two)
    assert not np.array_equal(one, plan)


def test_cost_never_rises_and_the_plan_stays_in_its_bounds() -> None:
    for seed in (100000, 100003, 100004):
        problem, plan = horizon(seed)
        states, room, proximal = np.empty((STEPS * N + 1, M)), rti.empty_room(N, M), 1.0  # rash at first
        for _ in range(12):
            before = predict(STEP, problem, plan, states)
            found = rti.iterate(STEP, TANGENT, problem, plan, proximal, 1, 4, 1e-6, room)
            after, proximal = predict(STEP, problem, plan, states), found.proximal
            assert (found.before, found.after) == (before, after)
            assert after <= before
            assert np.all(plan >= 0.0) and np.all(plan <= CC_MAX)


def left(problem: Problem, plan: Array) -> float:
    """Largest slope into the box. [J/Nms]"""
    states, out = np.empty((STEPS * N + 1, M)), np.empty(N)
    predict(STEP, problem, plan, states)
    gradient(PULLBACK, problem, plan, states, out)
    out[plan <= 0.0] = np.minimum(out[plan <= 0.0], 0.0)
    out[plan >= CC_MAX] = np.maximum(out[plan >= CC_MAX], 0.0)
    return float(np.max(np.abs(out)))


@pytest.mark.parametrize("solver", ["riccati", "osqp"])
def test_iterations_end_at_a_local_optimum(solver: str) -> None:
    """Stationary by the adjoint of the nonlinear cost, which the iterations never call."""
    problem, plan = horizon(100001)
    plan, room = plan.copy(), rti.empty_room(N, M)
    at_first = left(problem, plan)
    if solver == "riccati":
        found = rti.iterate(STEP, TANGENT, problem, plan, 100.0, 300, 50, 1e-9, room)
        assert left(problem, plan) < 1e-3 * at_first
        assert found.promised < 1e-3
    else:
        by_osqp = OsqpSolver(N, M)
        found = rti.iterate_with(by_osqp, STEP, TANGENT, problem, plan, 100.0, 40, room)
        assert left(problem, plan) < 0.1 * at_first
    assert found.status == SOLVED
    assert found.after < found.before - 1.0


def test_a_rash_step_is_shortened_or_refused() -> None:
    """A direction uphill changes nothing and makes the next step more cautious; a promise kept makes it bolder."""
    problem, plan = horizon()
    room = rti.empty_room(N, M)
    states, steepness = room.states, np.empty(N)
    cost = predict(STEP, problem, plan, states)
    gradient(PULLBACK, problem, plan, states, steepness)
    kept, uphill = plan.copy(), 1e-9 * steepness
    after, proximal = rti.advance(STEP, problem, plan, uphill, cost, 1.0, 100.0, room)
    assert after == cost and proximal > 100.0 and np.array_equal(plan, kept)
    promised = 1e-9 * float(steepness @ np.clip(steepness, (plan - CC_MAX) * 1e9, plan * 1e9))
    after, proximal = rti.advance(STEP, problem, plan, -uphill, cost, promised, 100.0, room)
    assert after < cost and proximal < 100.0


def test_a_state_that_is_no_number_leaves_the_plan() -> None:
    problem, plan = horizon()
    start = problem.start.copy()
    start[4] = np.nan
    kept = plan.copy()
    for found in (
        rti.iterate(STEP, TANGENT, problem._replace(start=start), plan, 100.0, 3, 10, 1e-6, rti.empty_room(N, M)),
        rti.iterate_with(
            OsqpSolver(N, M), STEP, TANGENT, problem._replace(start=start), plan, 100.0, 3, rti.empty_room(N, M)
        ),
    ):
        assert found.status == NOT_FINITE and np.array_equal(plan, kept)


def test_rival_changes_places_with_the_plan_where_it_costs_less() -> None:
    """Two rivals from several starts: the cost that is told is that of the plan, and the least of the three."""
    problem, plan = horizon()
    planner = planner_of(linear_kind(DEVICE), "condensed")
    now = np.array([problem.power, problem.before, problem.cc_max, problem.period])
    moments = problem.moments[: 2 * (STEPS * N + 1)]
    flat = problem.start, moments, now, np.array(problem.weights), problem.h, problem.k
    states, room, taken = np.empty((STEPS * N + 1, M)), rti.empty_room(N, M), 0
    for begin in (np.zeros(N), np.full(N, 0.5 * CC_MAX), np.roll(plan, 3), np.roll(plan, -9)):
        costs, rivals = [], np.concatenate([begin, 0.5 * begin])
        for more in (0, 2):
            cc, result, worked = plan.copy(), np.array([0.0, 100.0, 1.0, 1.0]), rivals.copy()
            planner(*flat, cc, worked, result, 1, more, 0, NEWTON)
            assert predict(STEP, problem, cc, states) == result[0]
            costs.append(result[0])
        each, alone = [], rivals.reshape(2, N).copy()
        for rival in alone:
            each.append(rti.iterate_with(ByCondensing(), STEP, TANGENT, problem, rival, 1.0, 2, room))
        assert costs[1] == min(costs[0], *(found.after for found in each))
        assert result[2:].tolist() == [found.proximal for found in each], "each remembers its own weight"
        kept = {row.tobytes() for row in (cc, *worked.reshape(2, N))}
        other = plan.copy()
        rti.iterate_with(ByCondensing(), STEP, TANGENT, problem, other, 100.0, 1, room)
        assert kept == {row.tobytes() for row in (other, *alone)}, "the loser goes on as a rival"
        taken += costs[1] < costs[0]
    assert 0 < taken < 4
