"""What the tests read off a plant through its public `derivative` alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PSI, RADIATION = 2, (slice(8, 11), slice(11, 14))


def runge_kutta(rate: Callable[[float, Array], Array], time: float, state: Array, dt: float) -> Array:
    """Return the state after one classical fourth-order step."""
    k1 = rate(time, state)
    k2 = rate(time + dt / 2, state + dt / 2 * k1)
    k3 = rate(time + dt / 2, state + dt / 2 * k2)
    k4 = rate(time + dt, state + dt * k3)
    return state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def table_1(plant: Any) -> Array:
    """Return a, b, N, m1 .. m4, J11, J22, J13, J14 of a plant, shape (11,), as `Derivation` takes them."""
    p = plant.parameters
    return np.array([p.a, p.b, p.r2 / p.r1, p.m1, p.m2, p.m3, p.m4, p.J11, p.J22, p.J13, p.J14])


def random_states(count: int, seed: int, amplitude: float = 0.2) -> Array:
    """Return states (count, 14) near the working range, phi and its rates of the given size, the ring near 3 rad/s."""
    rng = np.random.default_rng(seed)
    size = np.array([amplitude, amplitude, 1.0, 1.0, 3 * amplitude, 3 * amplitude, 1.5, 25.0] + [0.05] * 6)
    states: Array = size * rng.standard_normal((count, 14))
    states[:, PSI] = rng.uniform(-np.pi, np.pi, count)
    states[:, 6] += rng.choice([-3.14, 3.14], count)
    states[:, 7] += rng.choice([-70.0, 70.0], count)
    return states


def jacobian(plant: Any, state: Array, u: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Return d derivative / d state by complex step, shape (14, 14)."""
    columns = [
        plant.derivative(state + 1e-30j * direction, u, (0.0, 0.0)).imag / 1e-30 for direction in np.eye(len(state))
    ]
    return np.array(columns, dtype=np.float64).T


class RadiationRealisation(NamedTuple):
    """The linear system z' = A z + b phi', Mr = p z of one direction, as the plant realises it.

    Attributes
    ----------
    A : ndarray, shape (n, n)
        System matrix [1/s].
    b : ndarray, shape (n,)
        Input vector.
    p : ndarray, shape (n,)
        Output vector; the moment -Mr acts on the lever.
    """

    A: Array
    b: Array
    p: Array

    def __call__(self, omega: float) -> complex:
        """Return the radiation function H(i omega) = p (i omega - A)^-1 b [Nms]."""
        return complex(self.p @ np.linalg.solve(1j * omega * np.eye(len(self.b)) - self.A, self.b))


def radiation_realisation(plant: Any, direction: int) -> RadiationRealisation:
    """Read the radiation system off the plant.

    A radiation state has on the accelerations the effect of a moment -p_i on the lever: the ratio to the effect of a
    wave moment is p.
    """
    state = np.zeros(14)
    state[PSI] = 0.4
    slopes = jacobian(plant, state)
    z = RADIATION[direction]
    moment = np.zeros(2)
    moment[direction] = 1.0
    answer = plant.derivative(state, (0.0, 0.0), tuple(moment))[4 + direction]
    return RadiationRealisation(slopes[z, z], slopes[z, 4 + direction], -slopes[4 + direction, z] / answer)
