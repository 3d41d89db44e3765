"""The solvers of a subproblem against each other and against a third, and what they say of themselves."""

from __future__ import annotations

from pathlib import Path

import clarabel
import numpy as np
import pytest
from nmpc_subproblems import CC_MAX, M, N, by_hand, gradient_by_differences, random_subproblem, real_subproblems
from numpy.typing import NDArray
from scipy.sparse import block_diag, csc_matrix, diags, hstack, identity, vstack

from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.interior_point import empty_interior_room, interior_point
from gyroctl.controllers.nmpc.solvers.osqp_solver import OsqpSolver
from gyroctl.controllers.nmpc.solvers.riccati import empty_riccati_room, solve
from gyroctl.controllers.nmpc.solvers.riccati_sweep import empty_sweep_room, sweep
from gyroctl.controllers.nmpc.solvers.subproblem import (
    LIMIT_REACHED,
    NOT_CONVEX,
    NOT_FINITE,
    OUTPUTS,
    SOLVED,
    Step,
    Subproblem,
    evaluate,
    slope,
)

Array = NDArray[np.float64]


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


def solved(qp: Subproblem, proximal: float, tolerance: float = 1e-10) -> tuple[Step, Array]:
    d = np.zeros(qp.plan.size)
    return solve(qp, proximal, d, tolerance, 200, empty_riccati_room(*qp.b.shape)), d


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
