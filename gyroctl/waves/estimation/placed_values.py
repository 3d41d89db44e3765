"""Forecast from a float that moves: the moments that it felt belong to the places where it was.

What is seen is the moment at the float, a few decimetres from where it rests, and there every wave has a phase of its
own: k X, which grows with the square of its frequency. So the covariance of what was seen at two instants depends on
the two places as well, and the matrix of a window is made anew at every sample, from the spectrum that was learnt. Its
solution gives the mean complex amplitude of each bin, and they give every linear signal of the waves ahead.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.plant import compiled, row_sums, trigonometry
from gyroctl.plant.compiled import stamped
from gyroctl.plant.plant import Plant
from gyroctl.plant.row_sums import add_rows
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation.gaussian import Responses
from gyroctl.waves.estimation.moment_model import Array

SOURCES = (compiled.__file__, row_sums.__file__, trigonometry.__file__, __file__)

HIGHEST = 8.0
"""Greatest frequency whose waves are told apart; those above are part of the noise. [rad/s]"""

NOISE = (20.0, 12.0)
"""White noise of the moments at the float that is reckoned with: what the model of the float misses. [Nm]"""


class Placed(NamedTuple):
    """Constants of the forecast; build it with `placed`."""

    reach: float  # of the lever [m]
    ages: NDArray[np.int64]  # (m,) of the values looked at, recent first [steps]
    phase: Array  # (m, b) of each wave at each age, at rest [rad]
    k: Array  # (b,) wave number along the reach [rad/m]
    seen: Array  # (4, b): real and imaginary part of the moments as they are seen, Me1 first [Nm/m]
    ahead: Array  # (2, 1 + horizon, 2 b): moments at rest at each step from now on, of the amplitudes' parts [Nm/m]
    noise: Array  # (4, past) covariance of the noise over the lag, see `Kernels` [Nm^2]
    width: float  # of a bin [rad/s]


def placed(
    plant: Plant, response: Responses, heading: float, step: float, ages: NDArray[np.int64], horizon: int, noise: Array
) -> Placed:
    """Prepare the forecast; arguments as of `Predictor.design` and `kernels`."""
    assert plant.geometry is not None
    few = response.grid.omega <= HIGHEST
    omega, true, seen = response.grid.omega[few], response.true[:, few], response.seen[:, few]
    turned = true[:, None, :] * np.exp(1j * step * np.outer(np.arange(horizon + 1), omega))
    k = wavenumber(omega, plant.depth, plant.geometry.g) * math.cos(math.radians(heading))
    own = noise.copy()
    for j in range(2):
        own[3 * j, 0] += NOISE[j] ** 2
    return Placed(
        float(plant.geometry.reach),
        ages,
        np.ascontiguousarray(-step * np.outer(ages, omega)),
        k,
        np.stack([part for moment in seen for part in (moment.real, moment.imag)]),
        np.ascontiguousarray(np.concatenate([turned.real, -turned.imag], axis=2)),
        own,
        response.grid.width,
    )


@stamped(SOURCES)
def predict_placed(
    c: Placed, spectrum: Array, history: Array, samples: int, now: Array, out: NDArray[np.float64]
) -> None:
    """Write the moments at rest (2, n) at 1 .. n steps ahead, and those of now into `now` (2,). [Nm]

    `history` (past, 3) is a round buffer of the moments at the float [Nm] and of its place, the sine of phi1.
    """
    length, bins = history.shape[0], c.k.size
    known = 0
    while known < c.ages.size and c.ages[known] < samples:
        known += 1
    size, twice = 2 * known, 2 * bins
    A, across = np.empty((size, twice)), np.empty((twice, size))
    v, root = np.empty(size), np.empty(bins)
    for b in range(bins):
        root[b] = math.sqrt(spectrum[b] * c.width)
    for a in range(known):
        row = (samples - 1 - c.ages[a]) % length
        v[2 * a], v[2 * a + 1] = history[row, 0], history[row, 1]
        place, phase = c.reach * history[row, 2], c.phase[a]
        one, three = A[2 * a], A[2 * a + 1]
        for b in range(bins):
            real, imaginary = cos_sin(phase[b] - c.k[b] * place)
            one[b] = root[b] * (c.seen[0, b] * real - c.seen[1, b] * imaginary)
            one[bins + b] = -root[b] * (c.seen[0, b] * imaginary + c.seen[1, b] * real)
            three[b] = root[b] * (c.seen[2, b] * real - c.seen[3, b] * imaginary)
            three[bins + b] = -root[b] * (c.seen[2, b] * imaginary + c.seen[3, b] * real)
    for r in range(size):
        for b in range(twice):
            across[b, r] = A[r, b]
    U = np.empty((size, size))
    for r in range(size):
        for s in range(r, size):
            lag = c.ages[s // 2] - c.ages[r // 2]
            U[r, s] = c.noise[2 * (r % 2) + s % 2, lag] if lag < c.noise.shape[1] else 0.0
        add_rows(A[r], across, 0, twice, U[r], r, size)
    solve_in_place(U, v)
    amplitudes = np.zeros(twice)
    add_rows(v, A, 0, size, amplitudes, 0, twice)
    for b in range(bins):
        amplitudes[b] *= root[b]
        amplitudes[bins + b] *= root[b]
    leads = min(out.shape[1], c.ahead.shape[1] - 1)
    for j in range(2):
        now[j] = 0.0
        for lead in range(out.shape[1]):
            out[j, lead] = 0.0
        for b in range(twice):
            now[j] += c.ahead[j, 0, b] * amplitudes[b]
        for lead in range(leads):
            total, wave = 0.0, c.ahead[j, 1 + lead]
            for b in range(twice):
                total += wave[b] * amplitudes[b]
            out[j, lead] = total


@stamped(SOURCES)
def solve_in_place(U: Array, v: Array) -> None:
    """Solve G w = v for a positive definite matrix whose upper half `U` holds, and write w into `v`; U is lost."""
    size = v.size
    column = np.empty(size)
    for r in range(size):
        for i in range(r):
            column[i] = -U[i, r]
        add_rows(column, U, 0, r, U[r], r, size)
        pivot = math.sqrt(U[r, r])
        for s in range(r, size):
            U[r, s] /= pivot
    for r in range(size):  # U' z = v
        v[r] /= U[r, r]
        for s in range(r + 1, size):
            v[s] -= U[r, s] * v[r]
    for r in range(size - 1, -1, -1):  # U w = z
        total = v[r]
        for s in range(r + 1, size):
            total -= U[r, s] * v[s]
        v[r] = total / U[r, r]
