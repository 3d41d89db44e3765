"""Forecast from a float that moves: the moments that it felt belong to the places where it was.

What is seen is the moment at the float, a few decimetres from where it rests, and there every wave has a phase of its
own: k X, which grows with the square of its frequency. So the covariance of what was seen depends on the places, and is
made anew at every sample, from the spectrum that was learnt. There are fewer waves than values seen: the complex
amplitudes of some bins are estimated, by the normal equations of Gaussian regression

    (I + A' A) z = A' y,    A = R^-1/2 H S^1/2,    y = R^-1/2 m,

with H the moments that a unit wave of each bin gives at the place and age of each value m, S the variances of the
amplitudes and R those of what no wave explains. The same matrix holds the variance of whatever is foreseen.

Two things are learnt, for they are most of all what the model of the float misses. A forecast that is made again later
differs from the first by what was seen in between, and the variance of the difference is the difference of their
variances. One step apart, the square of the one over the other says whether R is too small; a second apart, whether the
forecast is worse than it says, for a misfit is no white noise: its deviation is scaled.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.plant import compiled, row_sums, trigonometry
from gyroctl.plant.compiled import lent, stamped
from gyroctl.plant.plant import Plant
from gyroctl.plant.row_sums import add_rows
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation.gaussian import Responses
from gyroctl.waves.estimation.moment_model import Array

SOURCES = (compiled.__file__, row_sums.__file__, trigonometry.__file__, __file__)

BROAD, HIGH, BROADER, HIGHEST = 0.2, 6.0, 0.4, 10.0
"""Width of the bins up to a frequency, and of those above up to the greatest whose waves are told apart. [rad/s]

Waves of 0.2 rad/s apart are in step again after 31 s, far beyond what is looked at and ahead together.
"""

DENSE, SPARSE = 2.0, 4.0
"""Every value is looked at up to the first age, every second up to the second, every fourth beyond. [s]"""

LEAST, MOST = 5.0, 150.0
"""Range of the deviation of what no wave explains. [Nm]"""

EVERY = 0.5
"""Time between the leads whose variance is worked out. [s]"""

JUDGED = 1.0
"""Lead at which the deviation that the forecast says is compared with its errors. [s]"""

SLOW, SLOWER = 30.0, 120.0
"""Times over which the misfit and the scale of the deviation are learnt. [s]"""

NARROW, WIDE = 0.5, 4.0
"""Range of that scale, squared. [1]"""

FAR = 9.0
"""Squared deviations that count for no more than this many: one gust of a broken value is no misfit. [1]"""


class Placed(NamedTuple):
    """Constants of the forecast; build it with `placed`."""

    reach: float  # of the lever [m]
    width: float  # of a bin of the spectrum [rad/s]
    rates: tuple[float, float]  # parts of a deviation that misfit and scale take on at once
    far: int  # see `JUDGED` [steps]
    some: NDArray[np.int64]  # (s,) leads whose variance is worked out: 0, 1, then some [steps]
    before: Array  # (1 + horizon,) place of each lead among those
    edges: NDArray[np.int64]  # (b + 1,) bins of the spectrum at which those here begin, and the end
    ages: NDArray[np.int64]  # (m,) of the values looked at, recent first [steps]
    phase: Array  # (m, b) of each wave at each age, at rest [rad]
    k: Array  # (b,) wave number along the reach [rad/m]
    seen: Array  # (4, b): real and imaginary part of the moments as they are seen, Me1 first [Nm/m]
    ahead: Array  # (2, 2 b, 1 + horizon): moments at rest at each step from now on, of the amplitudes' parts [Nm/m]
    misfit: Array  # (2,) variance of what no wave explains, to begin with [Nm^2]


class PlacedState(NamedTuple):
    """What is known of the waves at the last sample, changed in place; of no size where the float is at rest."""

    spread: Array  # (2, 1 + horizon) standard deviation of the forecast, now and at each lead [Nm]
    variance: Array  # (2, 1 + horizon) what it would be if the model were right, squared [Nm^2]
    misfit: Array  # (2,) variance of what no wave explains, as it was learnt [Nm^2]
    scale: Array  # (2,) errors squared over their variance, as it was learnt [1]
    judged: Array  # (2, 2, 2) forecasts that are to be judged, the next and the far one, and their variances [Nm, Nm^2]
    due: NDArray[np.int64]  # (2,) samples at which they are, zero for none


def placed(
    plant: Plant, response: Responses, heading: float, step: float, past: float, horizon: int, noise: Array
) -> Placed:
    """Prepare the forecast.

    Parameters
    ----------
    plant : Plant
        The design model.
    response : Responses
        To true moments at rest and to seen ones at the float.
    heading : float
        The waves travel to. [deg]
    step, past : float
        Between samples, and how far to look back. [s]
    horizon : int
        [steps]
    noise : (2,) array
        Variances of what no wave explains of the moments seen, to begin with. [Nm^2]
    """
    assert plant.geometry is not None
    edges = _edges(response)
    low, count = edges[:-1], np.diff(edges)
    omega, true, seen = (
        np.add.reduceat(values[..., : edges[-1]], low, axis=-1) / count
        for values in (response.grid.omega, response.true, response.seen)
    )
    turned = true[:, :, None] * np.exp(1j * step * np.outer(omega, np.arange(horizon + 1)))
    ages = np.array([a for a in range(round(past / step) + 1) if a % _stride(a * step) == 0], np.int64)
    some = np.unique([0, 1, *range(0, horizon, max(round(EVERY / step), 1)), horizon])
    far = min(max(round(JUDGED / step), 1), horizon)
    return Placed(
        float(plant.geometry.reach),
        float(response.grid.width),
        (step / SLOW, far * step / SLOWER),
        far,
        some,
        np.interp(np.arange(horizon + 1), some, np.arange(some.size)),
        edges,
        ages,
        np.ascontiguousarray(-step * np.outer(ages, omega)),
        wavenumber(omega, plant.depth, plant.geometry.g) * math.cos(math.radians(heading)),
        np.stack([part for moment in seen for part in (moment.real, moment.imag)]),
        np.ascontiguousarray(np.concatenate([turned.real, -turned.imag], axis=1)),
        np.clip(noise, LEAST**2, MOST**2),
    )


def begun(c: Placed | None) -> PlacedState:
    """Return the state before the first sample."""
    leads = 0 if c is None else c.ahead.shape[2]
    misfit = np.zeros(0) if c is None else c.misfit.copy()
    new = np.zeros
    judged, due = new((2, 2, misfit.size)), new(2, np.int64)
    return PlacedState(new((2, leads)), new((2, leads)), misfit, np.ones(misfit.size), judged, due)


def _stride(age: float) -> int:
    return 1 if age <= DENSE else (2 if age <= SPARSE else 4)


def _edges(response: Responses) -> NDArray[np.int64]:
    """Where the bins of the forecast begin and end, in those of the spectrum."""
    omega, width = response.grid
    edges = [0]
    while edges[-1] < omega.size and omega[edges[-1]] < HIGHEST:
        wide = BROAD if omega[edges[-1]] < HIGH else BROADER
        edges.append(min(edges[-1] + max(round(wide / width), 1), omega.size))
    return np.array(edges, np.int64)


@stamped(SOURCES)
def predict_placed(
    c: Placed, state: PlacedState, spectrum: Array, history: Array, samples: int, now: Array, out: NDArray[np.float64]
) -> None:
    """Write the moments at rest (2, n) at 1 .. n steps ahead, and those of now into `now` (2,). [Nm]

    `history` (past, 3) is a round buffer of the moments at the float [Nm] and of its place, the sine of phi1.
    """
    bins, known = c.k.size, 0
    while known < c.ages.size and c.ages[known] < samples:
        known += 1
    size, twice = 2 * known, 2 * bins
    A, across, y = np.empty((size, twice)), np.empty((twice, size)), np.empty(size)
    root, U, z = np.empty(twice), np.zeros((twice, twice)), np.zeros(twice)
    for b in range(bins):
        variance = 0.0
        for of in range(c.edges[b], c.edges[b + 1]):
            variance += spectrum[of] * c.width
        root[b] = math.sqrt(variance)
        root[bins + b] = root[b]
    observe_waves(c, state.misfit, root, history, samples, A, y)
    for r in range(size):
        for b in range(twice):
            across[b, r] = A[r, b]
    add_rows(y, lent(A), 0, size, z, 0, twice)
    for r in range(twice):
        add_rows(across[r], lent(A), 0, size, U[r], r, twice)
        U[r, r] += 1.0
    factorise_upper(U)
    solve_upper(U, z)
    for b in range(twice):
        z[b] *= root[b]
    spread_of(c, U, root, state)
    leads = c.ahead.shape[2]
    row, values = np.empty(leads), np.empty((3, 2))
    for j in range(2):
        row[:] = 0.0
        add_rows(z, lent(c.ahead[j]), 0, twice, row, 0, leads)
        now[j], values[0, j], values[1, j], values[2, j] = row[0], row[0], row[1], row[c.far]
        for lead in range(out.shape[1]):
            out[j, lead] = row[lead + 1] if lead + 1 < leads else 0.0
    judge(c, state, samples, values)


@stamped(SOURCES)
def observe_waves(c: Placed, misfit: Array, root: Array, history: Array, samples: int, A: Array, y: Array) -> None:
    """Write what was seen, over the deviation of its misfit, and the moments of amplitudes of unit variance there."""
    bins, length = c.k.size, history.shape[0]
    of = np.empty((4, bins))
    for i in range(4):
        weight = 1.0 / math.sqrt(misfit[i // 2])
        for b in range(bins):
            of[i, b] = weight * root[b] * c.seen[i, b]
    one_real, one_imaginary, three_real, three_imaginary = of[0], of[1], of[2], of[3]
    for a in range(y.size // 2):
        row = (samples - 1 - c.ages[a]) % length
        for j in range(2):
            y[2 * a + j] = history[row, j] / math.sqrt(misfit[j])
        place, phase = c.reach * history[row, 2], c.phase[a]
        one, three = A[2 * a], A[2 * a + 1]
        for b in range(bins):
            real, imaginary = cos_sin(phase[b] - c.k[b] * place)
            one[b] = one_real[b] * real - one_imaginary[b] * imaginary
            one[bins + b] = -one_real[b] * imaginary - one_imaginary[b] * real
            three[b] = three_real[b] * real - three_imaginary[b] * imaginary
            three[bins + b] = -three_real[b] * imaginary - three_imaginary[b] * real


@stamped(SOURCES)
def factorise_upper(U: Array) -> None:
    """Replace the upper half of a positive definite matrix by its factor, G = U' U."""
    size = U.shape[0]
    column = np.empty(size)
    for r in range(size):
        for i in range(r):
            column[i] = -U[i, r]
        add_rows(column, lent(U), 0, r, U[r], r, size)
        inverse = 1.0 / math.sqrt(U[r, r])
        for s in range(r, size):
            U[r, s] *= inverse


@stamped(SOURCES)
def solve_upper(U: Array, v: Array) -> None:
    """Solve U' U w = v, and write w into `v`."""
    size = v.size
    for r in range(size):
        v[r] /= U[r, r]
        for s in range(r + 1, size):
            v[s] -= U[r, s] * v[r]
    for r in range(size - 1, -1, -1):
        total = v[r]
        for s in range(r + 1, size):
            total -= U[r, s] * v[s]
        v[r] = total / U[r, r]


@stamped(SOURCES)
def spread_of(c: Placed, U: Array, root: Array, state: PlacedState) -> None:
    """Standard deviation of the moments ahead: at some leads, straight lines of the variance in between. [Nm]"""
    twice, some = root.size, c.some.size
    W, column, total = np.empty((twice, 2 * some)), np.empty(twice), np.zeros(2 * some)
    for r in range(twice):  # U' W = the moments at those leads, of amplitudes of unit variance
        for j in range(2):
            for i in range(some):
                W[r, j * some + i] = root[r] * c.ahead[j, r, c.some[i]]
    for r in range(twice):
        for i in range(r):
            column[i] = -U[i, r]
        add_rows(column, lent(W), 0, r, W[r], 0, 2 * some)
        inverse = 1.0 / U[r, r]
        for i in range(2 * some):
            W[r, i] *= inverse
            total[i] += W[r, i] * W[r, i]
    for j in range(2):
        for lead in range(c.before.size):
            i = min(int(c.before[lead]), some - 2)
            part = c.before[lead] - i
            variance = (1.0 - part) * total[j * some + i] + part * total[j * some + i + 1]
            state.variance[j, lead] = variance
            state.spread[j, lead] = math.sqrt(min(max(state.scale[j], NARROW), WIDE) * variance)


@stamped(SOURCES)
def judge(c: Placed, state: PlacedState, samples: int, values: Array) -> None:
    """Learn misfit and scale from forecasts of now that were made before, and put others by.

    `values` (3, 2) are the moments now, at the next sample, and at the far lead. [Nm]
    """
    for kind in range(2):
        lead = 1 if kind == 0 else c.far
        if samples < state.due[kind]:
            continue
        for j in range(2):
            explained = state.judged[kind, 1, j] - state.variance[j, 0]
            if state.due[kind] == samples and explained > 0.0:
                deviation = min((values[0, j] - state.judged[kind, 0, j]) ** 2 / explained, FAR)
                if kind == 0:
                    grown = state.misfit[j] * math.exp(c.rates[0] * (deviation - 1.0))
                    state.misfit[j] = min(max(grown, LEAST * LEAST), MOST * MOST)
                else:
                    state.scale[j] += c.rates[1] * (deviation - state.scale[j])
            state.judged[kind, 0, j], state.judged[kind, 1, j] = values[1 + kind, j], state.variance[j, lead]
        state.due[kind] = samples + lead
