"""Periodic LQR of what the law can feed back: full-information solution, projected on its signals, then polished.

The full-information regulator comes from the periodic Riccati equation. The law has ten signals and constant gains on
them, so that its best gains are an output feedback: the projection of the full solution in its own stationary
covariance is the start, and the descent of Anderson and Moore on the same cost brings it to its optimum
(W. Levine and M. Athans, IEEE Trans. Automatic Control 15 (1970) 44-48; P. Mäkilä and H. Toivonen, ibid. 32 (1987)
658-671, here for a periodic system).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.gain_scheduled.cell import Cell
from gyroctl.linearisation.periodic import transition
from gyroctl.linearisation.riccati import periodic_lqr, periodic_lyapunov

Matrices = NDArray[np.float64]

HALVINGS = 12
STEPS = 20


@dataclass(frozen=True)
class Weights:
    """Deviations that weigh alike in the cost.

    Parameters
    ----------
    angle : float
        Of the load angle. [rad]
    speed : float
        Of the ring. [rad/s]
    flywheel : float
        Of omega'/N. [rad/s]
    swing : float
        Of phi1. [rad]
    cc : float
        Of the coupling. [Nms]
    cg : float
        Of the generator gain, as a part of the lock capacity J4 V/N. [-]
    """

    angle: float = 0.35
    speed: float = 0.17
    flywheel: float = 0.12
    swing: float = 0.094
    cc: float = 0.005
    cg: float = 0.3


@dataclass(frozen=True)
class Regulator:
    """Gains and how good they are.

    Parameters
    ----------
    gains : (2, 10) array
        From the signals to cc and cg.
    cost : float
        Of the modulated wave.
    open_cost, bound : float
        Without feedback, and with full information.
    """

    gains: NDArray[np.float64]
    cost: float
    open_cost: float
    bound: float


def regulate(cell: Cell, weights: Weights, detuning: float = 1.0) -> Regulator:
    """Find the gains of a cell; `detuning` makes both controls dearer."""
    Q, R = _costs(cell, weights, detuning)
    samples = cell.A.shape[0]
    W = cell.G @ cell.G.transpose(0, 2, 1)
    full = periodic_lqr(cell.A, cell.B, Q, np.repeat(R[None], samples, 0))
    spread = periodic_lyapunov(cell.A - cell.B @ full.gain, W)
    total = Q + full.gain.transpose(0, 2, 1) @ R @ full.gain
    bound = float(np.mean(np.einsum("kij,kji->k", total, spread)))
    left = sum(-f @ x @ c.T for f, x, c in zip(full.gain, spread, cell.C, strict=True))
    right = sum(c @ x @ c.T for x, c in zip(spread, cell.C, strict=True))
    nothing = np.zeros((2, cell.C.shape[1]))
    open_cost = _cost(cell, nothing, Q, R, W)
    start = np.linalg.lstsq(np.asarray(right), np.asarray(left).T, rcond=1e-9)[0].T
    K = nothing
    for _ in range(HALVINGS):
        if _cost(cell, start, Q, R, W) < open_cost:
            K = start
            break
        start = 0.5 * start
    K, cost = _descend(cell, K, Q, R, W)
    return Regulator(K, cost, open_cost, bound)


def _costs(cell: Cell, weights: Weights, detuning: float) -> tuple[Matrices, NDArray[np.float64]]:
    """Q (N, n, n) and R (2, 2)."""
    samples, n = cell.A.shape[:2]
    parameters = cell.orbit.plant.parameters
    plant = np.zeros((samples, 3, n))
    for i, (name, unit) in enumerate(
        (("psi_rate", weights.speed), ("omega_rate", weights.flywheel * parameters.N), ("phi1", weights.swing))
    ):
        plant[:, i, cell.rows[name]] = 1.0 / unit
    outputs = np.concatenate([plant, cell.C[:, 1:2] / weights.angle], axis=1)
    units = np.array([weights.cc, weights.cg * parameters.J4 * cell.node.envelope / parameters.N])
    return outputs.transpose(0, 2, 1) @ outputs, np.diag(detuning / units**2)


def _cost(cell: Cell, K: NDArray[np.float64], Q: Matrices, R: NDArray[np.float64], W: Matrices) -> float:
    closed = cell.A + cell.B @ K @ cell.C
    if np.max(np.abs(np.linalg.eigvals(transition(closed)))) >= 1.0:
        return np.inf
    total = Q + (K @ cell.C).transpose(0, 2, 1) @ R @ (K @ cell.C)
    return float(np.mean(np.einsum("kij,kji->k", total, periodic_lyapunov(closed, W))))


def _descend(
    cell: Cell, K: NDArray[np.float64], Q: Matrices, R: NDArray[np.float64], W: Matrices
) -> tuple[NDArray[np.float64], float]:
    """Anderson-Moore: solve for the gains with covariance and cost-to-go held, go there as far as the cost falls."""
    cost = _cost(cell, K, Q, R, W)
    m, p = K.shape
    for _ in range(STEPS):
        closed = cell.A + cell.B @ K @ cell.C
        KC = K @ cell.C
        X = periodic_lyapunov(closed, W)
        back = closed.transpose(0, 2, 1)[::-1]
        P = periodic_lyapunov(back, (Q + KC.transpose(0, 2, 1) @ R @ KC)[::-1])
        # P[j] is the cost to go before sample (N - j) mod N: after sample k it is that before k + 1
        ahead = P[(-np.arange(1, cell.A.shape[0] + 1)) % cell.A.shape[0]]
        normal, right = np.zeros((m * p, m * p)), np.zeros((m, p))
        for k in range(cell.A.shape[0]):
            BP = cell.B[k].T @ ahead[k]
            seen = cell.C[k] @ X[k]
            normal += np.kron(R + BP @ cell.B[k], seen @ cell.C[k].T)
            right -= BP @ cell.A[k] @ seen.T
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        solved = np.linalg.lstsq(normal * np.outer(scale, scale), scale * right.ravel(), rcond=1e-10)[0]
        wanted = (scale * solved).reshape(m, p)
        step, before = 1.0, cost
        for _ in range(HALVINGS):
            trial = K + step * (wanted - K)
            found = _cost(cell, trial, Q, R, W)
            if found < cost:
                K, cost = trial, found
                break
            step *= 0.5
        if before - cost < 1e-4 * before:
            break
    return K, cost
