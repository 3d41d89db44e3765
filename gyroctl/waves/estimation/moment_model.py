"""The float as a linear system with the wave moments as states: what the estimator's gains are designed on.

The ring turns the small terms of (22)-(23) around once per wave; averaged over its angle they vanish, and the float is
left as two oscillators with radiation, nearly apart. The gyroscopic moments are no part of this model: they are known
from the measured ring, and the nonlinear text of the equations carries them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE, RADIATION
from gyroctl.plant.plant import Plant
from gyroctl.waves.spectrum import SeaState

Array = NDArray[np.float64]

ANGLES = 16
"""Ring angles of the average: more than enough for terms of the first and second harmonic."""


LEAST_NOISE = 1e-6
"""Standard deviation that a sensor is taken to have at least: the Riccati equation wants some noise. [rad, rad/s]"""


class FloatModel(NamedTuple):
    """Averaged float with two moments driven by broad noise.

    State: the rows `rows` of the plant, then Me1, Me1', Me3, Me3'. Measured: phi1, phi3, phi1', phi3'.
    """

    rows: NDArray[np.int64]  # (f,) rows of the plant's state that belong to the float
    A: Array  # (f + 4, f + 4), continuous time
    B: Array  # (f, 2), moments to the rates of the float
    C: Array  # (4, f + 4)
    Q: Array  # (f + 4, f + 4), intensity of the white noise that drives it


def float_model(plant: Plant, wp: float, spread: float, scale: tuple[float, float], unmodelled: float) -> FloatModel:
    """Average the float of `plant` over the ring angle and add the moments.

    Parameters
    ----------
    plant : Plant
        The design model.
    wp : float
        Frequency of the moments' oscillators and speed of the ring. [rad/s]
    spread : float
        Damping ratio of the oscillators: how broad the sea is taken to be. [-]
    scale : pair of float
        Standard deviations of Me1 and Me3. [Nm]
    unmodelled : float
        Intensity of white moments on the float that no wave explains. [Nm s^0.5]
    """
    n = len(plant.labels)
    rows = np.array([PHI1, PHI3, PHI1_RATE, PHI3_RATE, *range(RADIATION, n)], dtype=np.int64)
    f = rows.size
    whole, inputs = np.zeros((n, n)), np.zeros((n, 4))
    x = np.zeros(n)
    x[PSI_RATE], x[OMEGA_RATE] = wp, plant.coefficients.N * wp
    for angle in range(ANGLES):
        x[PSI] = 2.0 * math.pi * angle / ANGLES
        at, bt = plant.jacobians(x, (0.0, 0.0), (0.0, 0.0))
        whole += at / ANGLES
        inputs += bt / ANGLES
    B = np.ascontiguousarray(inputs[rows, 2:])
    A = np.zeros((f + 4, f + 4))
    A[:f, :f] = whole[np.ix_(rows, rows)]
    Q = np.zeros((f + 4, f + 4))
    Q[:f, :f] = B @ B.T * unmodelled**2
    for j in range(2):
        m = f + 2 * j
        A[:f, m] = B[:, j]
        A[m, m + 1] = 1.0
        A[m + 1, m], A[m + 1, m + 1] = -(wp**2), -2.0 * spread * wp
        Q[m + 1, m + 1] = 4.0 * spread * wp**3 * scale[j] ** 2  # keeps the variance at scale^2
    C = np.zeros((4, f + 4))
    C[np.arange(4), np.arange(4)] = 1.0
    return FloatModel(rows, A, B, C, Q)


class Gains(NamedTuple):
    """Sampled model and stationary Kalman gain."""

    transition: Array  # (s, s)
    noise: Array  # (s, s), covariance of the noise of one period
    gain: Array  # (s, 4)
    variance: Array  # (s, s), of the error after the measurement


def stationary_gains(model: FloatModel, sensor_noise: Array, period: float) -> Gains:
    """Kalman gain of the sampled model, from the Riccati equation.

    Parameters
    ----------
    model : FloatModel
    sensor_noise : (4,) array
        Standard deviations of phi1, phi3 [rad] and phi1', phi3' [rad/s] per sample.
    period : float
        Sampling period. [s]
    """
    from scipy.linalg import expm, solve_discrete_are

    s = model.A.shape[0]
    pair = expm(period * np.block([[-model.A, model.Q], [np.zeros((s, s)), model.A.T]]))  # van Loan
    transition = pair[s:, s:].T
    noise = transition @ pair[:s, s:]
    noise = 0.5 * (noise + noise.T)
    R = np.diag(sensor_noise**2)
    before = solve_discrete_are(transition.T, model.C.T, noise, R)
    gain = np.linalg.solve(model.C @ before @ model.C.T + R, model.C @ before).T
    return Gains(transition, noise, gain, before - gain @ model.C @ before)


def gains_of(
    plant: Plant, sea: SeaState, noise: Array, period: float, spread: float, unmodelled: float
) -> tuple[FloatModel, Gains]:
    """Averaged model and gains of the float."""
    omega = np.linspace(0.3, 12.0, 1200)
    response = np.abs(plant.excitation(omega, sea.heading)) ** 2 * sea.spectrum(omega)
    scale = np.sqrt(np.sum(response, axis=1) * (omega[1] - omega[0]))
    model = float_model(plant, sea.wp, spread, (float(scale[0]), float(scale[1])), unmodelled)
    floor = np.maximum(noise[3:], LEAST_NOISE)
    return model, stationary_gains(model, floor, period)


def gains_of_the_rest(model: FloatModel, whole: Gains, sensor_noise: Array, period: float) -> Array:
    """Gains (16, s, 4) for each set of lost sensors: the bits of the first index are phi1, phi3, phi1', phi3'.

    The columns of lost sensors are zero; with all lost the model runs by itself. Other arguments as of
    `stationary_gains`.
    """
    found = np.zeros((16, *whole.gain.shape))
    found[0] = whole.gain
    for lost in range(1, 15):
        left = [j for j in range(4) if not lost >> j & 1]
        found[lost][:, left] = stationary_gains(model._replace(C=model.C[left]), sensor_noise[left], period).gain
    return found


def innovation_spread(model: FloatModel, gains: Gains, sensor_noise: Array) -> Array:
    """Variances (4,) of what the stationary filter does not foresee of its measurements."""
    before = gains.transition @ gains.variance @ gains.transition.T + gains.noise
    return np.asarray(np.diag(model.C @ before @ model.C.T) + sensor_noise**2)


def transfer(model: FloatModel, transition: Array, gain: Array, omega: Array, period: float) -> NDArray[np.complex128]:
    """Response (2, 2, n) of the estimated to the true moments at `omega` (n,) [rad/s], noise apart."""
    f = model.rows.size
    s = model.A.shape[0]
    inner = (np.eye(s) - gain @ model.C) @ transition
    out = np.empty((2, 2, omega.size), np.complex128)
    for i, w in enumerate(omega):
        motion = np.linalg.solve(1j * w * np.eye(f) - model.A[:f, :f], model.B)  # the float under exp(i w t)
        seen = gain @ model.C[:, :f] @ motion
        z = np.exp(1j * w * period)
        out[:, :, i] = np.linalg.solve(z * np.eye(s) - inner, z * seen)[[f, f + 2]]
    return out


def noise_covariance(model: FloatModel, transition: Array, gain: Array, variance: Array, lags: int) -> Array:
    """Covariances (2, 2, lags) of what sensor noise leaves in the estimated moments, E n_i(t + k) n_j(t). [Nm^2]

    `variance` (4,) is that of the sensors of phi1, phi3, phi1', phi3'.
    """
    from scipy.linalg import solve_discrete_lyapunov

    s = model.A.shape[0]
    inner = (np.eye(s) - gain @ model.C) @ transition
    P = solve_discrete_lyapunov(inner, gain @ np.diag(variance) @ gain.T)
    pick = [model.rows.size, model.rows.size + 2]
    out = np.empty((2, 2, lags))
    for k in range(lags):
        out[:, :, k] = P[np.ix_(pick, pick)]
        P = inner @ P
    return out
