"""Plans that are improved side by side: each as if it were alone, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from nmpc_subproblems import CC_MAX, DEVICE, STEP, TANGENT, ByCondensing, M, N, horizon
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.controllers.nmpc.casadi_to_numba import BESIDE
from gyroctl.controllers.nmpc.planner import NEWTON, TOLERANCE, planner_of
from gyroctl.controllers.nmpc.prediction import STEPS, beside_of, linear_kind
from gyroctl.controllers.nmpc.problem import predict
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.side_by_side import empty_side_by_side, improve, predict_all, vary
from gyroctl.controllers.nmpc.solvers.subproblem import NOT_FINITE
from gyroctl.errors import InputError

Array = NDArray[np.float64]
SIDE = beside_of(linear_kind(DEVICE))


def plans_of(count: int) -> Array:
    """Rough plans, some out of bounds."""
    return np.random.default_rng(count).uniform(-0.2 * CC_MAX, 1.2 * CC_MAX, (count, N))


@pytest.mark.parametrize("count", [1, 2, 3, BESIDE, BESIDE + 2])
def test_predictions_side_by_side_are_those_of_one_after_the_other(count: int) -> None:
    """Those that are not chosen stay as they are; more than fit beside one another come in turns."""
    problem, _ = horizon()
    plans = np.clip(plans_of(count + 1), 0.0, CC_MAX)
    room, chosen = empty_side_by_side(count + 1, N, M), np.arange(count, -1, -1)
    room.costs[:], room.states[:] = 7.0, 7.0
    predict_all(STEP, SIDE, problem, plans, chosen, count, room.beside, room.states, room.costs)
    states = np.empty((STEPS * N + 1, M))
    for p in chosen[:count]:
        assert room.costs[p] == predict(STEP, problem, plans[p], states)
        assert np.array_equal(room.states[p], states)
    assert room.costs[0] == 7.0 and np.all(room.states[0] == 7.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [100000, 100001])
@pytest.mark.parametrize("count, least", [(1, 1), (2, 1), (5, 1), (BESIDE + 1, 1), (3, 90)])
def test_each_plan_becomes_what_it_becomes_alone(count: int, least: int, seed: int) -> None:
    """By the text in Python, which improves one plan; weights and iterations differ from plan to plan.

    After many of them no part of a step makes the cost fall, and the plan stays.
    """
    problem, _ = horizon(seed)
    plans, proximal = plans_of(count), 10.0 ** np.linspace(0.0, 3.0, count)
    iterations = least + np.arange(count, dtype=np.int64) % 3
    alone, expected, shortened = plans.copy(), [], 0
    for p in range(count):
        room = rti.empty_room(N, M)
        found = rti.iterate_with(
            ByCondensing(), STEP, TANGENT, problem, alone[p], proximal[p], int(iterations[p]), room
        )
        expected.append((found.after, found.proximal))
        shortened += found.proximal > proximal[p]
    room_of_all = empty_side_by_side(count, N, M)
    improve(STEP, SIDE, TANGENT, problem, plans, proximal, iterations, NEWTON, TOLERANCE, room_of_all)
    assert np.array_equal(plans, alone)
    assert list(zip(room_of_all.costs, proximal, strict=True)) == expected
    assert count <= 2 or shortened, "some steps must have been too long"
    states = np.empty((STEPS * N + 1, M))
    for p in range(count):
        assert predict(STEP, problem, plans[p], states) == room_of_all.costs[p]
        assert np.array_equal(room_of_all.states[p], states)


@pytest.mark.slow
def test_plan_without_numbers_stops_and_the_others_go_on() -> None:
    problem, _ = horizon()
    plans, alone, one = plans_of(4), plans_of(4), np.array([100.0])
    plans[2] = np.nan
    proximal, iterations = np.full(4, 100.0), np.full(4, 2, np.int64)
    room = empty_side_by_side(4, N, M)
    improve(STEP, SIDE, TANGENT, problem, plans, proximal, iterations, NEWTON, TOLERANCE, room)
    assert (room.status == NOT_FINITE).tolist() == [False, False, True, False]
    assert not np.isfinite(room.costs[2]) and proximal[2] == 100.0
    for p in (0, 1, 3):
        one[0], beside = 100.0, empty_side_by_side(1, N, M)
        improve(STEP, SIDE, TANGENT, problem, alone[p : p + 1], one, iterations[:1], NEWTON, TOLERANCE, beside)
        assert np.array_equal(alone[p], plans[p]) and one[0] == proximal[p]


def variations(plan: Array) -> list[Array]:
    """All the coupling for 1, 2, 4 intervals, none for 1, 3, and a switching that comes sooner or later."""
    made = []
    for count, coupling in ((1, CC_MAX), (2, CC_MAX), (4, CC_MAX), (1, 0.0), (3, 0.0)):
        made.append(np.concatenate([np.full(count, coupling), plan[count:]]))
    return [*made, np.append(plan[1:], plan[-1]), np.append(plan[0], plan[:-1])]


def test_plan_is_replaced_by_the_best_of_its_variations() -> None:
    """Each of them is the best somewhere, and the plan stays where none is better."""
    problem, _ = horizon()
    states, taken = np.empty((STEPS * N + 1, M)), set()
    rng = np.random.default_rng(3)
    for _ in range(400):
        plan = np.repeat(rng.uniform(0.0, CC_MAX, N // 4) * rng.integers(0, 2, N // 4), 4)
        moved = problem._replace(before=0.05, start=problem.start + 0.05 * rng.standard_normal(M))
        tried = [plan, *variations(plan)]
        costs = [predict(STEP, moved, other, states) for other in tried]
        found = plan.copy()
        vary(STEP, SIDE, moved, found)
        assert np.array_equal(found, tried[int(np.argmin(costs))])
        taken.add(int(np.argmin(costs)))
    assert taken == set(range(len(tried)))


def test_planner_varies_a_plan_as_often_as_it_is_told() -> None:
    problem, _ = horizon()
    plan, planner = np.zeros(N), planner_of(linear_kind(DEVICE), "condensed")
    now = np.array([problem.power, problem.before, problem.cc_max, problem.period])
    moments = problem.moments[: 2 * (STEPS * N + 1)]
    for times in range(4):
        expected, found, result = plan.copy(), plan.copy(), np.array([0.0, 100.0])
        for _ in range(times):
            vary(STEP, SIDE, problem, expected)
        given = problem.start, moments, now, np.array(problem.weights), problem.h, problem.k
        planner(*given, found, np.empty(0), result, 0, 0, times, NEWTON)
        assert np.array_equal(found, expected)


def test_solver_that_varies_no_plans_says_so() -> None:
    with pytest.raises(InputError, match=r"nmpc\.varied = 2.*riccati.*condensed"):
        gy.law("nmpc", solver="riccati", varied=2)
