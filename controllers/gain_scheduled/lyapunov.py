"""LMI design: gains of all cells at once, with one Lyapunov function over the schedule or a bounded rate of scheduling.

The model of a cell is the averaged one of its orbit, libration and horizontal mode. Its inputs are both controls, and
both modulated with the ring angle: a control that is modulated in this way acts on the horizontal mode, and by the
half-period symmetry nothing else does. With gains K_i = Y_i Q_i^-1 at the nodes the closed loops satisfy

    A_i Q_i + B_i Y_i + (..)' + 2 a Q_i + G_i G_i' -+ rate dQ/dV <= 0,    [Z_i, C Q_i + D Y_i; .., Q_i] >= 0,

and the largest trace of Z_i, a bound of the cost of the irregular wave, is made least (S. Boyd et al., Linear Matrix
Inequalities in System and Control Theory, SIAM 1994, chapter 7; F. Wu et al., Int. J. Robust Nonlinear Control 6
(1996) 983-998 for the bounded rate). With a constant Q the schedule may move at any rate; with Q affine in the envelope
its rate is bounded. The inequality holds at the nodes; between them, where the law interpolates, it is checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.gain_scheduled.cell import Cell, Node, modulation
from gyroctl.controllers.gain_scheduled.scheduled import SIGNALS
from gyroctl.errors import InputError
from gyroctl.linearisation.averaged import average
from gyroctl.linearisation.model import linearise
from gyroctl.plant.equations import PSI

Matrix = NDArray[np.float64]

INPUTS = ("cc", "cg", "cc_cos", "cc_sin", "cg_cos", "cg_sin")
FOLLOW = 0.3  # part of the brisk changes of the envelope that the generator follows [-]


@dataclass(frozen=True)
class SlowModel:
    """x' = A x + B u + G w of libration angle [rad] and rate, phi1 [rad] and phi1' of the horizontal mode."""

    node: Node  # the cell
    A: Matrix  # (4, 4)
    B: Matrix  # (4, 6) from `INPUTS`: cc, cg [Nms] and both times cos and sin of the ring angle
    G: Matrix  # (4, 2) from white noise


@dataclass(frozen=True)
class Wishes:
    """What the LMI design is asked for: deviations that weigh alike in the cost, rates of decay, and disturbances.

    The disturbances are white accelerations, told by the root of their spectral density: what is irregular within a
    wave, and so not seen by an average over waves.
    """

    angle: float = 0.1  # of the libration [rad]
    speed: float = 0.5  # of the ring [rad/s]
    swing: float = 0.13  # of phi1 [rad]
    cc: float = 0.003  # of the coupling [Nms]
    cg: float = 0.15  # of the generator gain, as a part of the lock capacity J4 V/N [-]
    decay: float = 0.03  # least rate at which the libration dies out [1/s]
    swing_decay: float = 0.003  # and the horizontal mode [1/s]
    shake: float = 0.05  # of the ring [rad/s^1.5]
    swing_shake: float = 0.02  # of the float [rad/s^1.5]
    rate: float = float("inf")  # largest rate of the envelope; infinite: one function for any rate [rad/s^2]

    @property
    def varying(self) -> bool:
        """Whether the Lyapunov function varies with the envelope, whose rate is bounded then."""
        return bool(np.isfinite(self.rate))

    @property
    def bound(self) -> float:
        """Rate of the envelope in the proof: zero where the function does not vary. [rad/s^2]"""
        return self.rate if self.varying else 0.0


@dataclass(frozen=True)
class Certificate:
    """Gains with the Lyapunov function that proves them: x' (Q0 + V Q1)^-1 x decreases in every cell."""

    gains: list[Matrix]  # (6, 4) from the states of the slow model to its inputs, by cell
    Q0: Matrix  # (4, 4)
    Q1: Matrix  # (4, 4)
    decay: float  # least rate of decay that it proves at the nodes [1/s]
    cost: float  # bound of the cost


def cell_model(cell: Cell, decorrelation: float, scatter: float = 0.5) -> SlowModel:
    """Averaged model of a cell's orbit with modulated inputs, driven by the irregularity of the wave."""
    model = linearise(cell.orbit, ("psi", "phi1"))
    psi = model.orbit[:-1, PSI]
    c, s = np.cos(psi)[:, None], np.sin(psi)[:, None]
    cc, cg = model.B[:, :, 0], model.B[:, :, 1]
    waves = np.array([modulation(model.flow, x, model.controls, k) for k, x in enumerate(model.orbit[:-1])])
    entry = np.concatenate([np.stack([cc, cg, cc * c, cc * s, cg * c, cg * s], axis=2), waves], axis=2)
    names = (*INPUTS, "wave_in_phase", "wave_quarter")
    found = average(replace(model, B=entry, D=np.zeros((model.samples, 2, len(names))), inputs=names))
    # a slow mode feels a modulation that is forgotten at the rate b as white noise of the spectral density 2 s^2/b
    noise = scatter * np.sqrt(2.0 / max(decorrelation, 1e-3))
    return SlowModel(cell.node, found.A, found.B[:, : len(INPUTS)], noise * found.B[:, len(INPUTS) :])


def solve(models: Sequence[SlowModel], wishes: Wishes, detuning: Sequence[float], capacity: float) -> Certificate:
    """Solve the LMI for all cells.

    Parameters
    ----------
    models : sequence of SlowModel
        Of all cells.
    wishes : Wishes
        Weights, decay and rate.
    detuning : sequence of float
        How much dearer the controls are in each cell; the decay that is asked of it falls with the root of that.
    capacity : float
        J4/N: the lock capacity is that times the envelope. [Nms s/rad]

    Raises
    ------
    InputError
        Where there is no such function: the message tells what to ease.
    """
    import cvxpy as cp

    n, m = models[0].B.shape
    units = np.array([wishes.angle, wishes.speed, wishes.swing, wishes.swing * 1.25])
    shaken = np.diag([0.0, wishes.shake, 0.0, wishes.swing_shake])[:, [1, 3]]
    decays = np.diag([wishes.decay, wishes.decay, wishes.swing_decay, wishes.swing_decay])
    Q0: Any = _even_odd()
    Q1: Any = _even_odd() if wishes.varying else np.zeros((n, n))
    constraints, costs, solved = [], [], []
    for model, dearer in zip(models, detuning, strict=True):
        # deviations in units of the weights, so that the numbers are of size one
        A = model.A * units[None, :] / units[:, None]
        G = np.hstack([model.G, shaken]) / units[:, None]
        strong = np.array([wishes.cc, wishes.cg * capacity * model.node.envelope] * 3)[[0, 1, 0, 0, 1, 1]]
        strong = strong / np.sqrt(dearer)
        B = model.B * strong[None, :] / units[:, None]
        even, odd = cp.Variable((2, 2)), cp.Variable((4, 2))
        Y = cp.bmat([[even, np.zeros((2, 2))], [np.zeros((4, 2)), odd]])
        Q = Q0 + model.node.envelope * Q1 if wishes.varying else Q0
        Z = cp.Variable((n + m, n + m), symmetric=True)
        inner = A @ Q + B @ Y
        base = inner + inner.T + 2.0 * (decays / np.sqrt(dearer)) @ Q + G @ G.T  # Q has no entries across the modes
        for left in (base - wishes.rate * Q1, base + wishes.rate * Q1) if wishes.varying else (base,):
            constraints.append(0.5 * (left + left.T) << 0)
        outputs = cp.vstack([Q, Y])
        constraints += [cp.bmat([[Z, outputs], [outputs.T, Q]]) >> 0, Q >> 1e-6 * np.eye(n)]
        costs.append(cp.trace(Z))
        solved.append((Y, strong, model))
    problem = cp.Problem(cp.Minimize(cp.sum(cp.hstack(costs)) / len(costs)), constraints)
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.error.SolverError:
        problem.solve(solver=cp.SCS)
    if problem.status not in ("optimal", "optimal_inaccurate"):
        mend = "Ask for a slower decay, or bound the rate of the schedule"
        found = f"no Lyapunov function over the schedule: {problem.status}"
        raise InputError("wishes.decay", wishes.decay, found, mend)
    q0, q1 = np.asarray(Q0.value), np.asarray(Q1.value if wishes.varying else Q1)
    gains = [
        strong[:, None] * (np.asarray(Y.value) @ np.linalg.inv(q0 + model.node.envelope * q1)) / units[None, :]
        for Y, strong, model in solved
    ]
    q0, q1 = (part * np.outer(units, units) for part in (q0, q1))
    decay = min(proven_decay(model, K, q0, q1, wishes.bound) for model, K in zip(models, gains, strict=True))
    return Certificate(gains, q0, q1, decay, float(problem.value))


def proven_decay(model: SlowModel, K: Matrix, Q0: Matrix, Q1: Matrix, rate: float) -> float:
    """Rate of decay of x' Q^-1 x in a cell that the function proves, whatever the schedule does within `rate`. [1/s]"""
    Q = Q0 + model.node.envelope * Q1
    back = np.linalg.inv(np.linalg.cholesky(Q))
    worst = -np.inf
    for sign in (-1.0, 1.0):
        inner = (model.A + model.B @ K) @ Q
        worst = max(worst, float(np.linalg.eigvalsh(back @ (inner + inner.T + sign * rate * Q1) @ back.T)[-1]))
    return -0.5 * worst


def signal_gains(K: Matrix, share: float, capacity: float) -> Matrix:
    """Gains (2, 10) on the signals of the law from those (6, 4) on the slow states.

    The envelope is no state of the slow model: of its brisk changes the generator follows a part, `FOLLOW`. All of it
    is too much in low waves, where a load raises the envelope that it is taken from.
    """
    place = {name: i for i, name in enumerate(SIGNALS)}
    gains = np.zeros((2, len(SIGNALS)))
    gains[1, place["envelope"]] = FOLLOW * share * capacity
    for control in range(2):
        gains[control, [place["angle"], place["speed"]]] = K[control, :2]
        for j, name in enumerate(("cos", "sin")):
            gains[control, [place[f"swing_{name}"], place[f"swing_rate_{name}"]]] = K[2 + 2 * control + j, 2:]
    return gains


def _even_odd() -> Any:
    """Symmetric 4 x 4 variable without coupling of libration and horizontal mode."""
    import cvxpy

    even, odd = (cvxpy.Variable((2, 2), symmetric=True) for _ in range(2))
    return cvxpy.bmat([[even, np.zeros((2, 2))], [np.zeros((2, 2)), odd]])
