"""Periodic Lyapunov and Riccati equations: against SciPy's for constant systems and the cyclic reformulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

import gyroctl as gy
from gyroctl.linearisation.model import linearise
from gyroctl.linearisation.riccati import periodic_kalman, periodic_lqr, periodic_lyapunov

N, STATES, INPUTS = 5, 4, 2
Array = NDArray[np.float64]


def system(constant: bool = False, seed: int = 0) -> tuple[Array, Array, Array, Array]:
    """A (N, n, n), B (N, n, m), Q (N, n, n), R (N, m, m); unstable without control."""
    rng = np.random.default_rng(seed)
    a, b = 0.6 * rng.standard_normal((N, STATES, STATES)), rng.standard_normal((N, STATES, INPUTS))
    q, r = rng.standard_normal((N, STATES, STATES)), rng.standard_normal((N, INPUTS, INPUTS))
    q, r = q @ q.transpose(0, 2, 1), r @ r.transpose(0, 2, 1) + np.eye(INPUTS)
    if constant:
        a, b, q, r = (np.repeat(part[:1], N, 0) for part in (a, b, q, r))
    return a, b, q, r


def cyclic(parts: Array) -> Array:
    """Block k in row k + 1: the periodic system as a constant one of N times its order."""
    count, rows, columns = parts.shape
    out = np.zeros((count * rows, count * columns))
    for k in range(count):
        row = (k + 1) % count
        out[row * rows : (row + 1) * rows, k * columns : (k + 1) * columns] = parts[k]
    return out


def diagonal(parts: Array) -> Array:
    from scipy.linalg import block_diag

    return np.asarray(block_diag(*parts))


def blocks(matrix: Array, size: int = STATES) -> Array:
    return np.array([matrix[k * size : (k + 1) * size, k * size : (k + 1) * size] for k in range(N)])


def test_constant_system_gives_scipys_solution() -> None:
    a, b, q, r = system(constant=True)
    found = periodic_lqr(a, b, q, r)
    expected = solve_discrete_are(a[0], b[0], q[0], r[0])
    for X in found.X:
        np.testing.assert_allclose(X, expected, rtol=1e-8)
    gain = np.linalg.solve(r[0] + b[0].T @ expected @ b[0], b[0].T @ expected @ a[0])
    np.testing.assert_allclose(found.gain, np.repeat(gain[None], N, 0), rtol=1e-7, atol=1e-9)
    closed = np.linalg.eigvals(a[0] - b[0] @ gain) ** N
    np.testing.assert_allclose(np.sort(np.abs(found.multipliers)), np.sort(np.abs(closed)), atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_regulator_is_that_of_the_cyclic_system(seed: int) -> None:
    a, b, q, r = system(seed=seed)
    found = periodic_lqr(a, b, q, r)
    X = blocks(solve_discrete_are(cyclic(a), cyclic(b), diagonal(q), diagonal(r)))
    np.testing.assert_allclose(found.X, X, rtol=1e-6, atol=1e-8 * np.max(X))
    assert found.residual < 1e-12
    assert abs(found.multipliers[0]) < 1.0


def test_cost_of_the_regulator_is_what_a_run_costs_and_the_least() -> None:
    a, b, q, r = system(seed=7)
    found, start = periodic_lqr(a, b, q, r), np.arange(1.0, STATES + 1)

    def cost(gains: Array) -> float:
        x, total = start, 0.0
        for i in range(60 * N):
            k = i % N
            u = -gains[k] @ x
            total += x @ q[k] @ x + u @ r[k] @ u
            x = a[k] @ x + b[k] @ u
        return float(total)

    assert cost(found.gain) == pytest.approx(start @ found.X[0] @ start, rel=1e-8)
    rng = np.random.default_rng(1)
    for _ in range(5):
        assert cost(found.gain + 0.01 * rng.standard_normal(found.gain.shape)) > cost(found.gain)


@pytest.mark.parametrize("seed", range(3))
def test_filter_is_that_of_the_cyclic_system_and_of_plain_recursion(seed: int) -> None:
    a, b, w, v = system(seed=seed)
    c = b.transpose(0, 2, 1)
    found = periodic_kalman(a, c, w, v)
    P = np.eye(STATES)
    for i in range(400 * N):
        k = i % N
        if i >= 399 * N:
            np.testing.assert_allclose(found.X[k], P, rtol=1e-6, atol=1e-9 * np.max(P))
            gain = a[k] @ P @ c[k].T @ np.linalg.inv(c[k] @ P @ c[k].T + v[k])
            np.testing.assert_allclose(found.gain[k], gain, rtol=1e-6, atol=1e-8)
        middle = P - P @ c[k].T @ np.linalg.solve(c[k] @ P @ c[k].T + v[k], c[k] @ P)
        P = a[k] @ middle @ a[k].T + w[k]
    noise = np.roll(w, 1, 0)  # noise of sample k arrives in block k + 1
    whole = blocks(solve_discrete_are(cyclic(a).T, diagonal(c).T, diagonal(noise), diagonal(v)))
    np.testing.assert_allclose(found.X, whole, rtol=1e-6, atol=1e-8 * np.max(whole))


def test_covariance_is_that_of_the_cyclic_system() -> None:
    a, _, q, _ = system(seed=3)
    a = 0.5 * a
    found = periodic_lyapunov(a, q)
    whole = blocks(solve_discrete_lyapunov(cyclic(a), diagonal(np.roll(q, 1, 0))))
    np.testing.assert_allclose(found, whole, rtol=1e-8)
    for k in range(N):
        np.testing.assert_allclose(found[(k + 1) % N], a[k] @ found[k] @ a[k].T + q[k], rtol=1e-9, atol=1e-12)


def test_growing_and_unreachable_systems_are_refused() -> None:
    a, b, q, r = system()
    with pytest.raises(gy.InputError, match="below 1"):
        periodic_lyapunov(3.0 * a, q)
    with pytest.raises(gy.InputError, match="no stabilising regulator"):
        periodic_lqr(np.repeat(2.0 * np.eye(STATES)[None], N, 0), 0.0 * b, q, r)


def test_periodic_regulator_holds_the_nonlinear_plant_on_an_unstable_orbit(device: gy.Plant) -> None:
    """At cc = 0.02 the horizontal mode grows; held by cc and cg from the state, the plant comes back."""
    orbit = gy.lock_orbit(device, gy.Regular(0.2, 3.14), 0.02, 1e-3)
    assert orbit.status == "unstable"
    model = linearise(orbit, ("psi", "phi1"))
    n = len(model.states)
    q = np.repeat(np.diag([1e2 if name == "phi1" else 1e-4 for name in model.states])[None], model.samples, 0)
    r = np.repeat(np.diag([1e1, 1e5])[None], model.samples, 0)
    found = periodic_lqr(model.A, model.B[:, :, :2], q, r)
    assert abs(found.multipliers[0]) < 0.99 and found.residual < 1e-10
    phi1, flow = model.states.index("phi1"), model.flow
    sizes = {}
    for held in (True, False):
        x, course = model.orbit[0].copy(), []
        x[0] += 1e-3
        for i in range(200 * model.samples):
            k = i % model.samples
            there = model.orbit[k].copy()
            there[2] += 2 * math.pi * (i // model.samples)
            gap = (x - there)[flow.free]
            if k == 0:
                course.append(abs(gap[phi1]))
            u = model.controls - (found.gain[k] @ gap if held else np.zeros(2))
            x = flow.advance(x, max(float(u[0]), 0.0), max(float(u[1]), 0.0), k)
        sizes[held] = max(course[-10:])
    assert gap.size == n
    assert sizes[True] < 0.3e-3
    assert sizes[False] > 2e-3
