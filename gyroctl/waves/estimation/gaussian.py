"""Covariances of the moments from the spectrum of the sea, as linear maps ready for compiled code.

Both moments come from one elevation: with the complex He_j known, one spectrum S(omega) says everything about the two,
`E Me_i(t + tau) Me_j(t) = int Re(He_i conj(He_j) exp(i omega tau)) S d omega`. S is taken constant within bins, and
the integral over a bin is done exactly, so that a narrow peak does not repeat after 2 pi over the bin width.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.waves.excitation import Excited

Array = NDArray[np.float64]

PAIRS = ((0, 0), (0, 1), (1, 0), (1, 1))
"""Order of the pairs of moments in `Kernels`."""


class Bins(NamedTuple):
    """Frequency bins: centres and width. [rad/s]"""

    omega: Array  # (b,)
    width: float


class Kernels(NamedTuple):
    """Covariances per unit of spectrum: multiply by S (b,) and sum. Lags stand together, so that sums run abreast.

    `seen[p, :, k]` is E o_i(t + k step) o_j(t) of what is seen, `ahead[p, :, k]` E Me_i(t + k step) o_j(t) of the true
    moment and what was seen, for the pairs of `PAIRS`.
    """

    seen: Array  # (4, b, past)
    ahead: Array  # (4, b, past + horizon)
    noise: Array  # (4, past), added to `seen`


def bins(low: float = 1.0, high: float = 12.6, width: float = 0.1) -> Bins:
    """Even bins from `low` to `high`. [rad/s]"""
    count = round((high - low) / width)
    omega: Array = low + width * (np.arange(count, dtype=np.float64) + 0.5)
    return Bins(omega, width)


class Responses(NamedTuple):
    """Moments that a unit wave of each bin gives. [Nm/m]"""

    grid: Bins
    true: NDArray[np.complex128]  # (2, b)
    seen: NDArray[np.complex128]  # (2, b)


def responses(plant: Excited, heading: float, grid: Bins, transfer: NDArray[np.complex128] | None = None) -> Responses:
    """Responses of `plant` to waves that travel to `heading` [deg].

    `transfer` (2, 2, b) leads from the true moments to the seen ones; unity without.
    """
    true = plant.excitation(grid.omega, heading)
    return Responses(grid, true, true if transfer is None else np.einsum("ijb,jb->ib", transfer, true))


def kernels(response: Responses, step: float, past: int, horizon: int, noise: Array) -> Kernels:
    """Covariances per bin.

    Parameters
    ----------
    response : Responses
    step : float
        Sampling period. [s]
    past, horizon : int
        Greatest lag between two seen values, and beyond. [steps]
    noise : (2, 2, k) array
        Covariance of the noise in the seen moments at lags 0 .. k - 1, zero beyond. [Nm^2]
    """
    grid, true, seen = response
    lag = step * np.arange(past + horizon)
    wave = np.exp(1j * np.outer(lag, grid.omega)) * (grid.width * np.sinc(0.5 / np.pi * grid.width * lag))[:, None]
    ahead = np.stack([np.real(wave * (true[i] * np.conj(seen[j]))).T for i, j in PAIRS])
    both = np.stack([np.real(wave[:past] * (seen[i] * np.conj(seen[j]))).T for i, j in PAIRS])
    floor = np.zeros((4, past))
    count = min(past, noise.shape[2])
    for p, (i, j) in enumerate(PAIRS):
        floor[p, :count] = noise[i, j, :count]
    return Kernels(np.ascontiguousarray(both), np.ascontiguousarray(ahead), floor)


def steering(response: Responses, step: float, ages: NDArray[np.int64]) -> Array:
    """Moments (2 m, 2 b) that a unit wave of each bin gives at the ages looked at: real parts, then imaginary ones.

    Rows are Me1, Me3 of the youngest, then of the next, as they are seen; `step` is that of `kernels`.
    """
    grid, _, seen = response
    wave = np.exp(-1j * step * np.outer(ages, grid.omega))
    both = (wave[:, None, :] * seen[None, :, :]).reshape(2 * ages.size, grid.omega.size)
    return np.ascontiguousarray(np.hstack([both.real, both.imag]))
