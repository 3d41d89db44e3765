"""The subproblem of a real-time iteration: the linearised horizon, its cost and slope, its condensed form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from nmpc_subproblems import (
    PULLBACK,
    STEP,
    TANGENT,
    Array,
    M,
    N,
    by_hand,
    gradient_by_differences,
    horizon,
    random_subproblem,
)
from scipy.sparse import diags

from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.controllers.nmpc.problem import RING, RING_ANGLE, V1, V3, Problem, gradient, predict
from gyroctl.controllers.nmpc.solvers.osqp_solver import CondensedForm
from gyroctl.controllers.nmpc.solvers.subproblem import Subproblem, empty_subproblem, evaluate, linearise, slope


def test_states_are_linearised_exactly() -> None:
    """Against central differences of the nonlinear prediction."""
    problem, plan = horizon()
    states, there, back = (np.empty((STEPS * N + 1, M)) for _ in range(3))
    predict(STEP, problem, plan, states)
    qp = empty_subproblem(N, M)
    assert linearise(TANGENT, problem, plan, states, qp)
    d = np.random.default_rng(1).standard_normal(N)
    predict(STEP, problem, plan + 1e-7 * d, there)
    predict(STEP, problem, plan - 1e-7 * d, back)
    linear, slopes = np.empty((N, M)), np.empty((N, 3))
    evaluate(qp, 1.0, d, linear, slopes)
    found = (there - back)[STEPS::STEPS] / 2e-7
    assert np.max(np.abs(linear - found) / np.max(np.abs(found), 0)) < 1e-6


class AtThePlan(NamedTuple):
    """What program and adjoint say of a plan itself."""

    qp: Subproblem
    states: Array  # (n STEPS + 1, m)
    slopes: Array  # (n, 3) of the penalties by the outputs
    found: Array  # (n,) slope of the program's cost
    true: Array  # (n,) slope of the true cost


def at_the_plan(problem: Problem, plan: Array) -> AtThePlan:
    states, qp = np.empty((STEPS * N + 1, M)), empty_subproblem(N, M)
    predict(STEP, problem, plan, states)
    linearise(TANGENT, problem, plan, states, qp)
    at = AtThePlan(qp, states, np.empty((N, 3)), np.empty(N), np.empty(N))
    gradient(PULLBACK, problem, plan, states, at.true)
    evaluate(qp, 7.0, np.zeros(N), np.empty((N, M)), at.slopes)
    slope(qp, 7.0, np.zeros(N), at.slopes, at.found)
    return at


@pytest.mark.parametrize("travel", [0.0, 300.0])
def test_slope_at_the_plan_is_that_of_the_true_cost(travel: float) -> None:
    """Forward sensitivities and a tangent of the stored energy against the adjoint of the nonlinear cost."""
    problem, plan = horizon(100002, travel)
    _, _, slopes, found, true = at_the_plan(problem, plan)
    assert np.count_nonzero(slopes[:, :2]) > 10, "the limits on motion must take part"
    np.testing.assert_allclose(found, true, rtol=0.0, atol=1e-11 * np.max(np.abs(true)))


def test_grip_is_linearised_as_the_adjoint_has_it() -> None:
    """Where the ring speed that grip asks for rules, the program's slope is that of the true cost."""
    problem, plan = horizon(100002)
    asked = problem.weights._replace(grip=1.0 / 0.02, floor=1.0, ceiling=9.0)
    problem = problem._replace(weights=asked, margins=np.linspace(0.0, 0.2, N))
    qp, states, slopes, found, true = at_the_plan(problem, plan)
    across = np.sin(states[:, RING_ANGLE]) * states[:, V1] + np.cos(states[:, RING_ANGLE]) * states[:, V3]
    need = np.clip(np.abs(across[STEPS::STEPS]) / 0.02, 1.0, 9.0)
    short = need + problem.margins - states[STEPS::STEPS, RING]
    assert np.count_nonzero(slopes[:, 2]) == np.count_nonzero(short > 0.0) > 10
    assert min(np.count_nonzero((need == 9.0) & (short > 0.0)), np.count_nonzero((need < 9.0) & (short > 0.0))) > 3
    np.testing.assert_allclose(qp.low[2] - qp.outputs[:, 2], short, atol=1e-12)
    np.testing.assert_allclose(found, true, rtol=0.0, atol=1e-11 * np.max(np.abs(true)))


def test_states_that_are_no_numbers_are_noticed() -> None:
    problem, plan = horizon()
    states, qp = np.empty((STEPS * N + 1, M)), empty_subproblem(N, M)
    predict(STEP, problem, plan, states)
    states[17, 6] = np.nan
    assert not linearise(TANGENT, problem, plan, states, qp)


@pytest.mark.parametrize("seed", range(4))
def test_cost_and_slope_are_what_the_head_of_the_file_states(seed: int) -> None:
    qp, proximal = random_subproblem(seed)
    n, m = qp.b.shape
    d = np.random.default_rng(seed).standard_normal(n)
    states, slopes, found = np.empty((n, m)), np.empty((n, 3)), np.empty(n)
    assert evaluate(qp, proximal, d, states, slopes) == pytest.approx(by_hand(qp, proximal, d), rel=1e-12)
    slope(qp, proximal, d, slopes, found)
    np.testing.assert_allclose(found, gradient_by_differences(qp, proximal, d), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("seed", range(4))
def test_condensed_form_is_the_same_problem(seed: int) -> None:
    """At any d, with the best slacks put in, the rows hold and the cost differs by a constant."""
    qp, proximal = random_subproblem(seed)
    n, m = qp.b.shape
    P, q, G, low, high = CondensedForm.build(n).filled(qp, proximal)
    P = P + P.T - diags(P.diagonal())
    rng, offsets = np.random.default_rng(seed), []
    for _ in range(3):
        d = rng.uniform(-qp.plan, qp.cc_max - qp.plan)
        e, slopes = np.empty((n, m)), np.empty((n, 3))
        cost = evaluate(qp, proximal, d, e, slopes)
        z = np.concatenate([d, (slopes / qp.weight).ravel()])
        rows = G @ z
        assert np.all(rows >= low - 1e-9) and np.all(rows <= high + 1e-9)
        offsets.append(cost - (0.5 * z @ P @ z + q @ z))
    assert np.ptp(offsets) < 1e-9 * max(1.0, abs(cost))
