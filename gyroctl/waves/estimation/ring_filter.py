"""Ring and flywheel in the estimator: a Kalman filter of psi, psi', omega' whose transition follows the coupling."""

from __future__ import annotations

from typing import Any

from gyroctl.plant import kernel
from gyroctl.plant.beyond import coupling_torque
from gyroctl.plant.compiled import inlined, part
from gyroctl.plant.equations import OMEGA_RATE, PSI, PSI_RATE

SOURCES = (*kernel.SOURCES, __file__)

SOME = 1e-3
"""Slip below which the torque of any coupling is a straight line. [rad/s]"""


@inlined
def secant(more: Any, cc: float, slip: float) -> float:
    """Coupling that gives the torque at a slip [rad/s]: weaker than the command where the torque is curbed. [Nms]"""
    if more is None:
        return cc
    some = max(abs(slip), SOME)
    return float(coupling_torque(more, cc, some)) / some


@part(SOURCES)
def predict_ring(estimator: Any, state: Any, cc: float, cg: float) -> None:
    """Carry the variance of psi, psi', omega' over one period."""
    k, P, h = estimator.k, state.ring, estimator.period
    cc = secant(k.beyond, cc, state.x_hat[OMEGA_RATE] - k.N * state.x_hat[PSI_RATE])
    # the slip decays within a period: an L-stable Pade step (1, 2) of its two states, a trapezoid for psi
    a, b = -h * k.N * k.N * cc * k.Gpp, h * k.N * cc * k.Gpp
    c, d = h * k.N * cc * k.Goo, -h * (cc + cg) * k.Goo
    aa, ab, ca, dd = a * a + b * c, a * b + b * d, c * a + d * c, c * b + d * d
    la, lb = 1.0 - 2.0 / 3.0 * a + aa / 6.0, -2.0 / 3.0 * b + ab / 6.0
    lc, ld = -2.0 / 3.0 * c + ca / 6.0, 1.0 - 2.0 / 3.0 * d + dd / 6.0
    ra, rb, rc, rd = 1.0 + a / 3.0, b / 3.0, c / 3.0, 1.0 + d / 3.0
    det = la * ld - lb * lc
    fa, fb = (ld * ra - lb * rc) / det, (ld * rb - lb * rd) / det
    fc, fd = (la * rc - lc * ra) / det, (la * rd - lc * rb) / det
    F = state.work[3:6, 0:3]
    F[0, 0], F[0, 1], F[0, 2] = 1.0, 0.5 * h * (1.0 + fa), 0.5 * h * fb
    F[1, 0], F[1, 1], F[1, 2] = 0.0, fa, fb
    F[2, 0], F[2, 1], F[2, 2] = 0.0, fc, fd
    G = state.work[3:6, 3:6]
    for i in range(3):
        for j in range(3):
            G[i, j] = F[i, 0] * P[0, j] + F[i, 1] * P[1, j] + F[i, 2] * P[2, j]
    for i in range(3):
        for j in range(3):
            P[i, j] = G[i, 0] * F[j, 0] + G[i, 1] * F[j, 1] + G[i, 2] * F[j, 2]
        P[i, i] += estimator.ring_drift[i]


@part(SOURCES)
def correct_ring(estimator: Any, state: Any) -> None:
    """Correct psi, psi', omega' by their measurements, one after the other: their noises are independent."""
    x, P, e, gain = state.x_hat, state.ring, state.innovation, state.work[3]
    move0, move1, move2 = 0.0, 0.0, 0.0
    for i in range(3):
        if state.missing[i] > 0.0:
            continue
        moved = move0 if i == 0 else (move1 if i == 1 else move2)
        whole = P[i, i] + estimator.ring_noise[i]
        for j in range(3):
            gain[j] = P[j, i] / whole
        left = e[i] - moved
        move0, move1, move2 = move0 + gain[0] * left, move1 + gain[1] * left, move2 + gain[2] * left
        r0, r1, r2 = P[i, 0], P[i, 1], P[i, 2]
        for j in range(3):
            P[j, 0] -= gain[j] * r0
            P[j, 1] -= gain[j] * r1
            P[j, 2] -= gain[j] * r2
    x[PSI] += move0
    x[PSI_RATE] += move1
    x[OMEGA_RATE] += move2
