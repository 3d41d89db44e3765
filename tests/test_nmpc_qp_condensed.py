"""The dense program of a horizon: cost and slope by hand, solutions as by sweeps, failures as values."""

from __future__ import annotations

import numpy as np
import pytest
from nmpc_subproblems import (
    CC_MAX,
    STEP,
    TANGENT,
    ByCondensing,
    M,
    N,
    by_hand,
    gradient_by_differences,
    horizon,
    random_subproblem,
    real_subproblems,
)
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.solvers import condensed, riccati
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.subproblem import LIMIT_REACHED, NOT_CONVEX, NOT_FINITE, SOLVED, Step, Subproblem

Array = NDArray[np.float64]


def solved(qp: Subproblem, proximal: float, limit: int = 200) -> tuple[Step, Array]:
    d = np.zeros(qp.plan.size)
    return condensed.solve(qp, proximal, d, 1e-10, limit, condensed.empty_condensed_room(*qp.b.shape)), d


def test_cost_and_slope_are_those_by_hand() -> None:
    rng, limited = np.random.default_rng(5), 0
    for seed in range(20):
        qp, proximal = random_subproblem(seed)
        room = condensed.empty_condensed_room(*qp.b.shape)
        condensed.condense(qp, room)
        d = rng.uniform(-qp.plan, qp.cc_max - qp.plan)
        cost = condensed.condensed_cost(qp, proximal, d, room.slopes, room)
        nothing = condensed.condensed_cost(qp, proximal, 0.0 * d, room.new_slopes, room)
        assert cost - nothing == pytest.approx(by_hand(qp, proximal, d) - by_hand(qp, proximal, 0.0 * d), rel=1e-9)
        condensed.condensed_slope(qp, proximal, d, room)
        slope = gradient_by_differences(qp, proximal, d)
        np.testing.assert_allclose(room.slope, slope, rtol=1e-4, atol=1e-4 * np.max(np.abs(slope)))
        limited += np.count_nonzero(room.slopes)
    assert limited > 50, "limits must act"


@pytest.mark.slow
def test_solutions_are_those_of_the_sweeps() -> None:
    """Two eliminations of the states, one forth and one back; bounds, limits and travel all act."""
    at_bound, travelling, problems = 0, 0, [random_subproblem(seed) for seed in range(60)] + real_subproblems()
    for qp, proximal in problems:
        found, d = solved(qp, proximal)
        other = np.zeros(d.size)
        swept = riccati.solve(qp, proximal, other, 1e-10, 200, riccati.empty_riccati_room(*qp.b.shape))
        assert (found.status, swept.status) == (SOLVED, SOLVED)
        np.testing.assert_allclose(d, other, rtol=0.0, atol=1e-9)
        assert found.value == pytest.approx(swept.value, rel=1e-8, abs=1e-10)
        at_bound += np.count_nonzero((d <= -qp.plan) | (d >= qp.cc_max - qp.plan))
        travelling += qp.travel[0] > 0.0
    assert at_bound > 200 and travelling > 20


def test_a_few_steps_are_those_of_the_sweeps() -> None:
    """Stopped early as the planner does, both are at the same point."""
    for qp, proximal in real_subproblems():
        one, two = np.zeros(N), np.zeros(N)
        a = condensed.solve(qp, proximal, one, 1e-4, 4, condensed.empty_condensed_room(N, M))
        b = riccati.solve_briefly(qp, proximal, two, 1e-4, 4, riccati.empty_riccati_room(N, M))
        assert (a.status, a.iterations) == (b.status, b.iterations)
        np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-9 * CC_MAX)


def test_iterations_are_those_of_the_sweeps() -> None:
    problem, plan = horizon()
    one, two = plan.copy(), plan.copy()
    a = rti.iterate_with(ByCondensing(), STEP, TANGENT, problem, one, 100.0, 5, rti.empty_room(N, M))
    b = rti.iterate_briefly(STEP, TANGENT, problem, two, 100.0, 5, 4, 1e-4, rti.empty_room(N, M))
    assert a.after < a.before and a.newton == b.newton
    assert a.after == pytest.approx(b.after, rel=1e-9)
    np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-7 * CC_MAX)


def test_failures_are_values() -> None:
    qp, proximal = random_subproblem(3)
    assert solved(qp, proximal, 0)[0].status == LIMIT_REACHED
    qp.weight[:] = -1e3
    assert solved(qp, proximal)[0].status == NOT_CONVEX
    qp.weight[:] = 1.0
    qp.A[4, 0, 0] = np.nan
    assert solved(qp, proximal)[0].status == NOT_FINITE
