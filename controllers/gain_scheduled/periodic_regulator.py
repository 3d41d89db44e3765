"""Periodic LQR of what the law can feed back: full-information solution, projected on its signals, then polished.

The full-information regulator comes from the periodic Riccati equation. The law has ten signals and constant gains on
them, so that its best gains are an output feedback: the projection of the full solution in its own stationary
covariance is the start, and the descent of Anderson and Moore on the same cost brings it to its optimum
(W. Levine and M. Athans, IEEE Trans. Automatic Control 15 (1970) 44-48; P. Mäkilä and H. Toivonen, ibid. 32 (1987)
658-671, here for a periodic system).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

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
    """Deviations that weigh alike in the cost."""

    angle: float = 0.35  # of the load angle [rad]
    speed: float = 0.17  # of the ring [rad/s]
    flywheel: float = 0.12  # of omega'/N [rad/s]
    swing: float = 0.094  # of phi1 [rad]
    cc: float = 0.005  # of the coupling [Nms]
    cg: float = 0.3  # of the generator gain, as a part of the lock capacity J4 V/N [-]


@dataclass(frozen=True)
class Regulator:
    """Gains and how good they are."""

    gains: NDArray[np.float64]  # (2, 10) from the signals to cc and cg
    cost: float  # of the modulated wave
    open_cost: float  # without feedback
    bound: float  # with full information


class Problem(NamedTuple):
    """A cell with its cost: the mean of x' Q x + u' R u in the stationary noise of variance W."""

    cell: Cell
    Q: Matrices  # (N, n, n)
    R: NDArray[np.float64]  # (2, 2)
    W: Matrices  # (N, n, n)

    def weight(self, gain: Matrices) -> Matrices:
        """Weight of the states (N, n, n) where the controls follow them by a gain (N, 2, n)."""
        return self.Q + gain.transpose(0, 2, 1) @ self.R @ gain

    def closed(self, K: NDArray[np.float64]) -> Matrices:
        """Closed loop (N, n, n) with gains (2, 10) on the signals."""
        return self.cell.A + self.cell.B @ K @ self.cell.C

    def cost(self, K: NDArray[np.float64]) -> float:
        """Cost of gains (2, 10) on the signals, infinite where they do not stabilise."""
        closed = self.closed(K)
        if np.max(np.abs(np.linalg.eigvals(transition(closed)))) >= 1.0:
            return np.inf
        return _mean(self.weight(K @ self.cell.C), periodic_lyapunov(closed, self.W))


def regulate(cell: Cell, weights: Weights, detuning: float = 1.0) -> Regulator:
    """Find the gains of a cell; `detuning` makes both controls dearer."""
    problem = Problem(cell, *_costs(cell, weights, detuning), cell.G @ cell.G.transpose(0, 2, 1))
    full = periodic_lqr(cell.A, cell.B, problem.Q, np.repeat(problem.R[None], cell.A.shape[0], 0))
    spread = periodic_lyapunov(cell.A - cell.B @ full.gain, problem.W)
    left = sum(-f @ x @ c.T for f, x, c in zip(full.gain, spread, cell.C, strict=True))
    right = sum(c @ x @ c.T for x, c in zip(spread, cell.C, strict=True))
    projected = np.linalg.lstsq(np.asarray(right), np.asarray(left).T, rcond=1e-9)[0].T
    nothing = np.zeros((2, cell.C.shape[1]))
    open_cost = problem.cost(nothing)
    K, cost = _towards(problem, projected, nothing, open_cost)
    for _ in range(STEPS):
        before = cost
        K, cost = _towards(problem, _stationary_gains(problem, K), K, cost)
        if before - cost < 1e-4 * before:
            break
    return Regulator(K, cost, open_cost, _mean(problem.weight(full.gain), spread))


def _costs(cell: Cell, weights: Weights, detuning: float) -> tuple[Matrices, NDArray[np.float64]]:
    """Q (N, n, n) and R (2, 2)."""
    samples, n = cell.A.shape[:2]
    parameters = cell.orbit.plant.parameters
    plant = np.zeros((samples, 3, n))
    units = {"psi_rate": weights.speed, "omega_rate": weights.flywheel * parameters.N, "phi1": weights.swing}
    for i, (name, unit) in enumerate(units.items()):
        plant[:, i, cell.rows[name]] = 1.0 / unit
    outputs = np.concatenate([plant, cell.C[:, 1:2] / weights.angle], axis=1)
    controls = np.array([weights.cc, weights.cg * parameters.J4 * cell.node.envelope / parameters.N])
    return outputs.transpose(0, 2, 1) @ outputs, np.diag(detuning / controls**2)


def _mean(weight: Matrices, spread: Matrices) -> float:
    return float(np.mean(np.einsum("kij,kji->k", weight, spread)))


def _towards(
    problem: Problem, wanted: NDArray[np.float64], K: NDArray[np.float64], cost: float
) -> tuple[NDArray[np.float64], float]:
    """Go from the gains K to those wanted as far as the cost falls."""
    step = 1.0
    for _ in range(HALVINGS):
        trial = K + step * (wanted - K)
        found = problem.cost(trial)
        if found < cost:
            return trial, found
        step *= 0.5
    return K, cost


def _stationary_gains(problem: Problem, K: NDArray[np.float64]) -> NDArray[np.float64]:
    """Anderson-Moore: the best gains where covariance and cost to go are held as they are with K."""
    cell, closed = problem.cell, problem.closed(K)
    samples = cell.A.shape[0]
    X = periodic_lyapunov(closed, problem.W)
    P = periodic_lyapunov(closed.transpose(0, 2, 1)[::-1], problem.weight(K @ cell.C)[::-1])
    # P[j] is the cost to go before sample (N - j) mod N: after sample k it is that before k + 1
    ahead = P[(-np.arange(1, samples + 1)) % samples]
    normal, right = np.zeros((K.size, K.size)), np.zeros(K.shape)
    for k in range(samples):
        BP = cell.B[k].T @ ahead[k]
        seen = cell.C[k] @ X[k]
        normal += np.kron(problem.R + BP @ cell.B[k], seen @ cell.C[k].T)
        right -= BP @ cell.A[k] @ seen.T
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    solved = np.linalg.lstsq(normal * np.outer(scale, scale), scale * right.ravel(), rcond=1e-10)[0]
    return (scale * solved).reshape(K.shape)
