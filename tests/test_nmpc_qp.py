"""Real-time iterations: the linearised horizon, its two solvers against each other and against a third, safe steps."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import clarabel
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import block_diag, csc_matrix, diags, hstack, identity, vstack

import gyroctl as gy
from gyroctl.controllers.nmpc.prediction import STEPS, constants, orders_of, pullback_of, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import Problem, gradient, predict, weights
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.interior_point import empty_interior_room, interior_point
from gyroctl.controllers.nmpc.solvers.osqp_solver import CondensedForm, OsqpSolver
from gyroctl.controllers.nmpc.solvers.riccati import PATIENCE, empty_riccati_room, solve
from gyroctl.controllers.nmpc.solvers.riccati_sweep import empty_sweep_room, sweep
from gyroctl.controllers.nmpc.solvers.subproblem import (
    LIMIT_REACHED,
    NOT_CONVEX,
    NOT_FINITE,
    OUTPUTS,
    SOLVED,
    Step,
    Subproblem,
    empty_subproblem,
    evaluate,
    linearise,
    slope,
)
from gyroctl.harness.start import locked_start

N = 40
CC_MAX = 0.12
Array = NDArray[np.float64]
DEVICE = gy.zhang2017()
STEP, PULLBACK, TANGENT = (of(orders_of(DEVICE)) for of in (step_of, pullback_of, tangent_of))
M = 13


@cache
def horizon(seed: int = 100000, travel: float = 0.0) -> tuple[Problem, Array]:
    """A horizon of an irregular sea from the locked orbit, and a rough plan."""
    sea = gy.SeaState()
    waves = gy.realise(DEVICE, sea, seed, 60.0)
    x, _ = locked_start(DEVICE, sea)
    cost = weights(DEVICE, 2000.0, 0.10, 0.08, 50.0, 3.0, travel, 0.3)  # tight limits: they must matter
    plan = np.random.default_rng(seed).uniform(0.0, CC_MAX, N)
    plan[::3], plan[1::3] = 0.0, CC_MAX
    moments = np.ascontiguousarray(waves.moments.T).ravel()
    start = x[[0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13]]
    return Problem(start, moments, 8.0, 0.03, CC_MAX, 0.1, np.array([0.05]), constants(DEVICE), cost), plan


def later(problem: Problem, sample: int, start: Array, before: float) -> Problem:
    """The horizon that begins at a sample."""
    first = 2 * STEPS * sample
    return problem._replace(start=start, before=before, moments=problem.moments[first:])


@cache
def real_subproblems() -> list[tuple[Subproblem, float]]:
    """Subproblems met in closed loop, the model in the place of the plant, and their proximal weights."""
    out = []
    for seed, travel in ((100000, 0.0), (100001, 200.0)):
        problem, plan = horizon(seed, travel)
        now, proximal, room = problem, 100.0, rti.empty_room(N, M)
        for sample in range(25):
            predict(STEP, now, plan, room.states)
            qp = empty_subproblem(N, M)
            assert linearise(TANGENT, now, plan, room.states, qp)
            out.append((qp, proximal))
            proximal = rti.iterate(STEP, TANGENT, now, plan, proximal, 1, 10, 1e-6, room).proximal
            now = later(problem, sample + 1, room.states[STEPS].copy(), plan[0])
            plan = np.append(plan[1:], plan[-1])
    return out


def random_subproblem(seed: int, n: int = 12, m: int = 9) -> tuple[Subproblem, float]:
    """A subproblem with bounds and limits active, with and without travel."""
    rng = np.random.default_rng(seed)
    qp = empty_subproblem(n, m)
    orthogonal = np.linalg.qr(rng.standard_normal((n, m, m)))[0]
    qp.A[:], qp.b[:] = rng.uniform(0.8, 1.05) * orthogonal, rng.standard_normal((n, m))
    qp.outputs[:] = rng.standard_normal((n, 3))
    qp.low[:], qp.high[:] = (-1.0, -0.7, 0.2), (1.0, 0.7, np.inf)
    qp.weight[:] = rng.uniform(1.0, 30.0, 3)
    qp.terminal[:] = 3.0 * rng.standard_normal(m)
    qp.cc_max[0] = 1.0
    qp.plan[:] = np.clip(rng.uniform(-0.5, 1.5, n), 0.0, 1.0)
    qp.before[0], qp.travel[0] = rng.uniform(), rng.choice([0.0, 2.0])
    return qp, float(10.0 ** rng.uniform(-1.0, 1.0))


def by_hand(qp: Subproblem, proximal: float, d: Array) -> float:
    """The cost as the file's head states it, in plain numpy."""
    n, m = qp.b.shape
    e, total = np.zeros(m), 0.0
    planned = np.concatenate([qp.before, qp.plan])
    moved = planned + np.append(0.0, d)
    for i in range(n):
        e = qp.A[i] @ e + qp.b[i] * d[i]
        y = qp.outputs[i] + e[list(OUTPUTS)]
        total += 0.5 * qp.weight @ np.maximum(0.0, np.maximum(qp.low - y, y - qp.high)) ** 2
    return float(total + qp.terminal @ e + qp.travel[0] * np.sum(np.diff(moved) ** 2) + 0.5 * proximal * d @ d)


def reference(qp: Subproblem, proximal: float) -> Array:
    """Solution by Clarabel with all states as variables, built apart from the code under test."""
    n, m = qp.b.shape
    difference = np.eye(n) - np.eye(n, k=-1)
    jump = difference @ qp.plan - np.append(qp.before, np.zeros(n - 1))
    hessian = proximal * np.eye(n) + 2.0 * qp.travel[0] * difference.T @ difference
    slack, picked = np.tile(qp.weight, n), csc_matrix(np.kron(np.eye(n), np.eye(m)[list(OUTPUTS)]))
    P = block_diag([csc_matrix(np.triu(hessian)), csc_matrix((n * m, n * m)), diags(slack)], format="csc")
    q = np.concatenate([2.0 * qp.travel[0] * difference.T @ jump, np.zeros((n - 1) * m), qp.terminal, np.zeros(3 * n)])
    chain = identity(n * m, format="lil")
    for i in range(1, n):
        chain[i * m : (i + 1) * m, (i - 1) * m : i * m] = -qp.A[i]
    dynamics = hstack([-block_diag([column[:, None] for column in qp.b]), chain, csc_matrix((n * m, 3 * n))])
    box = hstack([identity(n), csc_matrix((n, n * m + 3 * n))])
    limit = hstack([csc_matrix((3 * n, n)), picked, -identity(3 * n)], format="csr")  # low <= y + e - s <= high
    y, low, high = qp.outputs.ravel(), np.tile(qp.low, n), np.tile(qp.high, n)
    limited = np.isfinite(high)
    A = vstack([dynamics, box, -box, limit[limited], -limit], format="csc")
    b = np.concatenate([np.zeros(n * m), qp.cc_max - qp.plan, qp.plan, (high - y)[limited], y - low])
    cones = [clarabel.ZeroConeT(n * m), clarabel.NonnegativeConeT(b.size - n * m)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    found = clarabel.DefaultSolver(P, q, A, b, cones, settings).solve()
    return np.array(found.x[:n])


def gradient_by_differences(qp: Subproblem, proximal: float, d: Array) -> Array:
    out = np.empty(d.size)
    for i in range(d.size):
        move = np.zeros(d.size)
        move[i] = 1e-5
        out[i] = (by_hand(qp, proximal, d + move) - by_hand(qp, proximal, d - move)) / 2e-5
    return out


def solved(qp: Subproblem, proximal: float, tolerance: float = 1e-10) -> tuple[Step, Array]:
    d = np.zeros(qp.plan.size)
    return solve(qp, proximal, d, tolerance, 200, empty_riccati_room(*qp.b.shape)), d


# the linearised horizon


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


@pytest.mark.parametrize("travel", [0.0, 300.0])
def test_slope_at_the_plan_is_that_of_the_true_cost(travel: float) -> None:
    """Forward sensitivities and a tangent of the stored energy against the adjoint of the nonlinear cost."""
    problem, plan = horizon(100002, travel)
    states, qp = np.empty((STEPS * N + 1, M)), empty_subproblem(N, M)
    predict(STEP, problem, plan, states)
    linearise(TANGENT, problem, plan, states, qp)
    true, found, linear, slopes = np.empty(N), np.empty(N), np.empty((N, M)), np.empty((N, 3))
    gradient(PULLBACK, problem, plan, states, true)
    evaluate(qp, 7.0, np.zeros(N), linear, slopes)
    slope(qp, 7.0, np.zeros(N), slopes, found)
    assert np.count_nonzero(slopes[:, :2]) > 10, "the limits on motion must take part"
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


# the solvers


@pytest.mark.parametrize("free", [1.0, 0.5, 0.1])
def test_riccati_sweep_solves_the_newton_system(free: float) -> None:
    """Against the dense Hessian, some couplings held at a given change."""
    for seed in range(6):
        qp, proximal = random_subproblem(seed)
        n, m = qp.b.shape
        rng, room = np.random.default_rng(seed), empty_sweep_room(n, m)
        evaluate(qp, proximal, np.zeros(n), room.states, room.slopes)
        slope(qp, proximal, np.zeros(n), room.slopes, room.slope)
        room.held[:] = rng.uniform(size=n) > free
        room.direction[:] = np.where(room.held, rng.standard_normal(n), 0.0)
        given = room.direction.copy()
        # the piece of the cost on which the present limits stay active: its Hessian by columns
        response, last = np.zeros((n, 3, n)), np.zeros((m, n))
        for i in range(n):
            last = qp.A[i] @ last
            last[:, i] += qp.b[i]
            response[i] = last[list(OUTPUTS)]
        room.curvature[:] = active = (room.slopes != 0.0) * qp.weight
        room.barrier[:] = rng.uniform(0.0, 2.0, n)
        difference = np.eye(n) - np.eye(n, k=-1)
        hessian = np.einsum("ir,irj,irk->jk", active, response, response)
        hessian += np.diag(proximal + room.barrier) + 2.0 * qp.travel[0] * difference.T @ difference
        assert sweep(qp, proximal, room)
        f, h = ~room.held, room.held
        if np.any(f):
            wanted = -np.linalg.solve(hessian[np.ix_(f, f)], room.slope[f] + hessian[np.ix_(f, h)] @ given[h])
            np.testing.assert_allclose(room.direction[f], wanted, rtol=1e-8, atol=1e-10)
        assert np.array_equal(room.direction[h], given[h])


def test_solvers_agree_on_random_problems() -> None:
    """Riccati, OSQP and Clarabel: three methods, three forms of the problem."""
    solver, at_bound, limited, travelling = OsqpSolver(12, 9, tolerance=1e-9, limit=100_000, polish=True), 0, 0, 0
    for seed in range(100):
        qp, proximal = random_subproblem(seed)
        found, d = solved(qp, proximal)
        other = np.zeros(12)
        assert (found.status, solver.solve(qp, proximal, other).status) == (SOLVED, SOLVED)
        np.testing.assert_allclose(d, reference(qp, proximal), rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(d, other, rtol=0.0, atol=1e-6)
        at_bound += np.count_nonzero((d <= -qp.plan) | (d >= qp.cc_max - qp.plan))
        e, slopes = np.empty((12, 9)), np.empty((12, 3))
        evaluate(qp, proximal, d, e, slopes)
        limited += np.count_nonzero(slopes)
        travelling += qp.travel[0] > 0.0
    assert 200 < at_bound < 1000 and limited > 200 and 20 < travelling < 80, "the problems must exercise all parts"


def test_solvers_agree_on_problems_from_the_closed_loop() -> None:
    problems = real_subproblems()
    solver = OsqpSolver(N, M, tolerance=1e-9, limit=50_000, polish=True)
    for qp, proximal in problems:
        found, d = solved(qp, proximal)
        assert found.status == SOLVED
        gain = by_hand(qp, proximal, d) - by_hand(qp, proximal, np.zeros(N))
        assert gain == pytest.approx(found.value, rel=1e-6, abs=1e-9)
        np.testing.assert_allclose(d, reference(qp, proximal), rtol=0.0, atol=2e-3 * CC_MAX)
        other = np.zeros(N)
        value = solver.solve(qp, proximal, other).value
        np.testing.assert_allclose(d, other, rtol=0.0, atol=1e-8 * CC_MAX)
        assert value == pytest.approx(found.value, rel=1e-9, abs=1e-9)
    assert sum(np.any(qp.travel > 0.0) for qp, _ in problems) == len(problems) / 2


def test_interior_point_needs_few_sweeps_whatever_the_problem() -> None:
    """Alone it is right to its tolerance, and lands on the bounds that hold the solution."""
    for qp, proximal in [random_subproblem(seed) for seed in range(40)] + real_subproblems()[::3]:
        n, m = qp.b.shape
        d, (_, best) = np.zeros(n), solved(qp, proximal)
        count = interior_point(qp, proximal, d, 1e-10, 40, empty_sweep_room(n, m), empty_interior_room(n))
        assert 3 < count < 25
        short = by_hand(qp, proximal, d) - by_hand(qp, proximal, best)
        scale = max(1e-3, by_hand(qp, proximal, np.zeros(n)) - by_hand(qp, proximal, best))
        assert -1e-9 * scale < short < 1e-3 * scale


@pytest.mark.parametrize("seed", range(8))
def test_solution_is_stationary_by_independent_differences(seed: int) -> None:
    """Signs of the slope at the bounds and zero between: the conditions of Karush, Kuhn and Tucker."""
    qp, proximal = random_subproblem(seed)
    found, d = solved(qp, proximal)
    steepness, least, most = gradient_by_differences(qp, proximal, d), -qp.plan, qp.cc_max - qp.plan
    assert np.all(d >= least) and np.all(d <= most)
    scale = 1e-4 * (1.0 + np.max(np.abs(steepness)))
    assert np.all(steepness[d > least] < scale) and np.all(steepness[d < most] > -scale)
    assert found.distance <= 1e-10


def test_distance_bounds_the_true_one() -> None:
    """Stopped early, the solver must not claim to be nearer than it is."""
    for seed in range(20):
        qp, proximal = random_subproblem(seed)
        n, m = qp.b.shape
        _, best = solved(qp, proximal)
        for limit in range(4):
            d = np.zeros(n)
            found = solve(qp, proximal, d, 1e-10, limit, empty_riccati_room(n, m))
            assert found.distance >= np.linalg.norm(d - best) - 1e-9
            assert found.value <= 0.0
            assert found.status == (SOLVED if found.distance <= 1e-10 else LIMIT_REACHED)


def test_warm_start_saves_the_work() -> None:
    cold = warm = 0
    for qp, proximal in real_subproblems():
        found, d = solved(qp, proximal)
        cold += found.iterations
        again = solve(qp, proximal, d.copy(), 1e-7, 200, empty_riccati_room(N, M))
        assert again.iterations == 0 and again.status == SOLVED
        nearby = qp._replace(outputs=qp.outputs * 1.01, terminal=qp.terminal * 0.99)
        warm += solve(nearby, proximal, d, 1e-10, 200, empty_riccati_room(N, M)).iterations
    assert warm < 0.7 * cold


def test_failures_are_values() -> None:
    qp, proximal = random_subproblem(3)
    n, m = qp.b.shape
    room, osqp = empty_riccati_room(n, m), OsqpSolver(n, m, tolerance=1e-12, limit=1)
    assert solve(qp, proximal, np.zeros(n), 1e-12, 0, room).status == LIMIT_REACHED
    assert osqp.solve(qp, proximal, np.zeros(n)).status == LIMIT_REACHED
    qp.weight[:] = -1e3
    assert solve(qp, proximal, np.zeros(n), 1e-12, 100, room).status == NOT_CONVEX
    qp.weight[:] = 1.0
    qp.A[4, 0, 0] = np.nan
    assert solve(qp, proximal, np.zeros(n), 1e-12, 100, room).status == NOT_FINITE


def test_osqp_has_one_door() -> None:
    """The solver can be replaced, and nobody pays for its import who does not use it."""
    folder = Path(rti.__file__).parent
    users = [file.name for file in folder.glob("*.py") if "import osqp\n" in file.read_text()]
    assert users == ["osqp_solver.py"]
    text = (folder / "osqp_solver.py").read_text()
    assert "\nimport osqp" not in text and "\nfrom osqp" not in text


# real-time iterations


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
