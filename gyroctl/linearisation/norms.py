"""H2 and H-infinity norms of a discrete time-invariant model, as the lifted model is.

The H-infinity norm is bracketed from below by the largest gain between the crossings of a level, and the level raised
until nothing crosses it (N. A. Bruinsma and M. Steinbuch, Systems & Control Letters 14, 1990), after the bilinear map
z = (1 + s)/(1 - s), which leaves the norm as it is. No gridding of frequency, and no library outside SciPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.linearisation.lifted import LiftedModel

ROUNDS = 30


def h2_norm(model: LiftedModel) -> float:
    """H2 norm: root of the summed output energies of unit impulses at all inputs; infinite where unstable.

    Over the root of the samples per period it is the stationary rms of the outputs under unit white noise per sample.
    """
    from scipy.linalg import solve_discrete_lyapunov

    if np.max(np.abs(np.linalg.eigvals(model.A))) >= 1.0:
        return np.inf
    gramian = solve_discrete_lyapunov(model.A, model.B @ model.B.T)
    return float(np.sqrt(np.trace(model.C @ gramian @ model.C.T) + np.sum(model.D**2)))


def hinf_norm(model: LiftedModel, tolerance: float = 1e-8) -> tuple[float, float]:
    """H-infinity norm and the frequency where it is attained.

    Parameters
    ----------
    model : LiftedModel
        Any object with matrices A, B, C, D and the sampling period [s].
    tolerance : float
        Relative error of the norm.

    Returns
    -------
    norm : float
        Infinite where the model is unstable.
    frequency : float
        [rad/s]; NaN where unstable.
    """
    norm, angle = hinf_of(model.A, model.B, model.C, model.D, tolerance)
    return norm, angle / model.period


def hinf_of(
    A: NDArray[Any], B: NDArray[Any], C: NDArray[Any], D: NDArray[Any], tolerance: float = 1e-8
) -> tuple[float, float]:
    """H-infinity norm of x+ = A x + B u, y = C x + D u, and the angle in [0, pi] of z where it is attained."""
    n = A.shape[0]
    if np.max(np.abs(np.linalg.eigvals(A))) >= 1.0:
        return np.inf, np.nan
    back = np.linalg.inv(A + np.eye(n))
    a, b = back @ (A - np.eye(n)), np.sqrt(2.0) * back @ B
    c, d = np.sqrt(2.0) * C @ back, D - C @ back @ B

    def gain(angle: float) -> float:
        response = C @ np.linalg.solve(np.exp(1j * angle) * np.eye(n) - A, B) + D
        return float(np.linalg.norm(response, 2))

    poles = np.linalg.eigvals(A)
    angles = [0.0, np.pi, *np.abs(np.angle(poles[np.abs(poles) > 0.3]))]
    best = max(angles, key=gain)
    level = max(gain(best), float(np.linalg.norm(d, 2)), 1e-300)
    for _ in range(ROUNDS):
        raised = (1.0 + tolerance) * level
        r = np.linalg.inv(raised**2 * np.eye(d.shape[1]) - d.T @ d)
        corner = a + b @ r @ d.T @ c
        lower = -c.T @ (np.eye(d.shape[0]) + d @ r @ d.T) @ c
        values = np.linalg.eigvals(np.block([[corner, b @ r @ b.T], [lower, -corner.T]]))
        crossing = np.abs(values.real) < 1e-7 * (1.0 + np.abs(values))
        crossings = np.unique(2.0 * np.arctan(np.abs(values[crossing].imag)))
        if crossings.size == 0:
            return raised, float(best)
        inner = 0.5 * (crossings[:-1] + crossings[1:])
        candidate = max([*inner, *crossings], key=gain)
        reached = gain(candidate)
        if reached <= raised:  # crossings by rounding only
            return raised, float(best)
        level, best = reached, candidate
    return level, float(best)
