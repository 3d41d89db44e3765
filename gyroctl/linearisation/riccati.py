"""Discrete periodic Lyapunov and Riccati equations: covariance, periodic LQR, periodic Kalman filter.

The lifted system of one period has the same cost as the periodic one, so that SciPy's solver for time-invariant systems
gives the solution at sample 0; the periodic recursion carries it through the period, and its return to the start is
the residual (S. Bittanti and P. Colaneri, Periodic Systems, Springer 2009, chapter 10).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.lifted import lift_matrices
from gyroctl.linearisation.periodic import multipliers_of, transition

Matrices = NDArray[np.float64]

POLISH = 3
"""Periods of the recursion after the lifted solution: each takes its error down by the square of the multipliers."""


@dataclass(frozen=True)
class PeriodicRiccati:
    """Solution of a periodic Riccati equation.

    Parameters
    ----------
    X : (N, n, n) array
        Cost to go, or covariance of the estimate before its measurement, at each sample.
    gain : (N, m, n) or (N, n, p) array
        u_k = -gain_k x_k for the regulator; x_{k+1} = A_k x_k + B_k u_k + gain_k (y_k - C_k x_k) for the filter.
    multipliers : (n,) complex array
        Of the closed loop, or of the estimation error, over one period, largest first.
    residual : float
        Relative difference between X at sample 0 and after one more period of the recursion.
    """

    X: Matrices
    gain: Matrices
    multipliers: NDArray[np.complex128]
    residual: float


def periodic_lyapunov(A: Matrices, Q: Matrices) -> Matrices:
    """Covariances X_k (N, n, n) with X_{k+1} = A_k X_k A_k' + Q_k, X_N = X_0.

    Raises
    ------
    InputError
        For a system that is not stable.
    """
    from scipy.linalg import solve_discrete_lyapunov

    period = transition(A)
    radius = float(np.max(np.abs(np.linalg.eigvals(period))))
    if radius >= 1.0:
        raise InputError("A", radius, "the largest multiplier must be below 1", "Close a loop that stabilises it first")
    gathered = np.zeros_like(period)
    for a, q in zip(A, Q, strict=True):
        gathered = a @ gathered @ a.T + q
    out = [solve_discrete_lyapunov(period, gathered)]
    for a, q in zip(A[:-1], Q[:-1], strict=True):
        out.append(a @ out[-1] @ a.T + q)
    return np.array(out)


def periodic_lqr(A: Matrices, B: Matrices, Q: Matrices, R: Matrices) -> PeriodicRiccati:
    """Minimise the sum of x'Q_k x + u'R_k u.

    Parameters
    ----------
    A, B : (N, n, n), (N, n, m) arrays
        The system.
    Q, R : (N, n, n), (N, m, m) arrays
        Weights, Q positive semidefinite and R positive definite.

    Raises
    ------
    InputError
        Where no stabilising solution exists.
    """
    from scipy.linalg import LinAlgError, block_diag, solve_discrete_are

    samples, n, m = B.shape
    eye = np.repeat(np.eye(n)[None], samples, 0)
    a, b, c, d = lift_matrices(A, B, eye, np.zeros((samples, n, m)))
    weight = block_diag(*Q)
    try:
        X = solve_discrete_are(a, b, c.T @ weight @ c, block_diag(*R) + d.T @ weight @ d, s=c.T @ weight @ d)
    except (LinAlgError, ValueError) as error:
        mend = "Choose inputs that reach every growing mode, and R > 0"
        raise InputError("B", B.shape, f"no stabilising regulator: {error}", mend) from error
    for _ in range(POLISH):
        start = X
        costs, gains = [X] * samples, [np.zeros((m, n))] * samples
        for k in reversed(range(samples)):
            gains[k] = np.linalg.solve(R[k] + B[k].T @ X @ B[k], B[k].T @ X @ A[k])
            X = Q[k] + A[k].T @ X @ (A[k] - B[k] @ gains[k])
            X = 0.5 * (X + X.T)
            costs[k] = X
    closed = A - B @ np.array(gains)
    residual = float(np.linalg.norm(X - start)) / max(float(np.linalg.norm(X)), 1e-300)
    return PeriodicRiccati(np.array(costs), np.array(gains), multipliers_of(transition(closed)), residual)


def periodic_kalman(A: Matrices, C: Matrices, W: Matrices, V: Matrices) -> PeriodicRiccati:
    """Stationary one-step predictor for process noise W_k and measurement noise V_k.

    Parameters
    ----------
    A, C : (N, n, n), (N, p, n) arrays
        The system.
    W, V : (N, n, n), (N, p, p) arrays
        Covariances per sample, W positive semidefinite and V positive definite.

    Raises
    ------
    InputError
        Where no stable filter exists.
    """
    # the filter is the regulator of the transposed system in reversed time
    back = [(-k - 1) % len(A) for k in range(len(A))]
    swap = (0, 2, 1)
    dual = periodic_lqr(A.transpose(swap)[back], C.transpose(swap)[back], W[back], V[back])
    # the dual's cost at step j includes W of sample back[j] and is the covariance after it
    covariance = np.array([dual.X[back[(k - 1) % len(A)]] for k in range(len(A))])
    return PeriodicRiccati(covariance, dual.gain[back].transpose(swap), dual.multipliers, dual.residual)
