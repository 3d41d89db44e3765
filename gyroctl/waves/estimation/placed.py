"""Forecast from a float that moves: the moments that it felt belong to the places where it was.

What is seen is the moment at the float, a few decimetres from where it rests, and there every wave has a phase of its
own: k X, which grows with the square of its frequency. So the covariance of what was seen depends on the places, and is
made anew at every sample, from the spectrum that was learnt. There are fewer waves than values seen: the complex
amplitudes of some bins are estimated, by the normal equations of Gaussian regression

    (I + A' A) z = A' y,    A = R^-1/2 H S^1/2,    y = R^-1/2 m,

with H the moments that a unit wave of each bin gives at the place and age of each value m, S the variances of the
amplitudes and R those of what no wave explains. The same matrix holds the variance of whatever is foreseen. Where a
gauge has told of the waves before, what it says stands in the place of the unit matrix and of zero (`gauge_forecast`).

Two things are learnt, for they are most of all what the model of the float misses. R, from the newest value of each
moment: what it leaves unexplained over what it would leave by itself, r^2 / (1 - a' (I + A' A)^-1 a), is one on the
average where R is right. And the scale of the deviation that the forecast says: a misfit is no white noise. A forecast
that is made again a second later differs from the first by what was seen in between, and the variance of the difference
is that of the one less that of the other.
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

JUDGED = 1.0
"""Lead at which the deviation that the forecast says is compared with its errors. [s]"""

SLOW, SLOWER = 30.0, 120.0
"""Times over which the misfit and the scale of the deviation are learnt. [s]"""

NARROW, WIDE = 0.5, 4.0
"""Range of that scale, squared. [1]"""

ALIKE = 1.25
"""By how much the misfit weighs more than its variance says: what the model of a moving float misses is alike from one
sample to the next, so that many values tell less of a wave than they would with as much white noise. [1]"""

FAR = 9.0
"""Squared deviations that count for no more than this many: one gust of a broken value is no misfit. [1]"""


class Placed(NamedTuple):
    """Constants of the forecast; build it with `placed`."""

    reach: float  # of the lever [m]
    width: float  # of a bin of the spectrum [rad/s]
    rates: tuple[float, float]  # parts of a deviation that misfit and scale take on at once
    far: int  # see `JUDGED` [steps]
    alike: float  # see `ALIKE` [1]
    edges: NDArray[np.int64]  # (b + 1,) bins of the spectrum at which those here begin, and the end
    ages: NDArray[np.int64]  # (m,) of the values looked at, recent first [steps]
    phase: Array  # (m, b) of each wave at each age, at rest [rad]
    k: Array  # (b,) wave number along the reach [rad/m]
    seen: Array  # (4, b): real and imaginary part of the moments as they are seen, Me1 first [Nm/m]
    ahead: Array  # (2, 2 b, 1 + horizon): moments at rest at each step from now on, of the amplitudes' parts [Nm/m]
    misfit: Array  # (2,) variance of what no wave explains, to begin with [Nm^2]
    least: Array  # (2,) and the least that it is taken for [Nm^2]


class PlacedState(NamedTuple):
    """What is known of the waves at the last sample, changed in place; of no size where the float is at rest."""

    spread: Array  # (2, 1 + horizon) standard deviation of the forecast, now and at each lead [Nm]
    variance: Array  # (2, 1 + horizon) what it would be if the model were right, squared [Nm^2]
    misfit: Array  # (2,) variance of what no wave explains, as it was learnt [Nm^2]
    scale: Array  # (2,) errors squared over their variance, as it was learnt [1]
    judged: Array  # (2, 2) a forecast that is to be judged [Nm], and its variances [Nm^2]
    due: NDArray[np.int64]  # (2,) samples at which it is, and at which the misfit was learnt last


def placed(
    plant: Plant,
    response: Responses,
    heading: float,
    step: float,
    past: float,
    horizon: int,
    noise: Array,
    moves: bool = True,
    widths: tuple[float, float] = (BROAD, BROADER),
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
    moves : bool
        Whether the float that saw them did; of one at rest nothing else is missed than `noise`.
    widths : pair of float
        See `BROAD`. [rad/s]
    """
    edges = _edges(response, widths)
    low, count = edges[:-1], np.diff(edges)
    omega, true, seen = (
        np.add.reduceat(values[..., : edges[-1]], low, axis=-1) / count
        for values in (response.grid.omega, response.true, response.seen)
    )
    turned = true[:, :, None] * np.exp(1j * step * np.outer(omega, np.arange(horizon + 1)))
    ages = np.array([a for a in range(round(past / step) + 1) if a % _stride(a * step) == 0], np.int64)
    far = min(max(round(JUDGED / step), 1), horizon)
    if moves:
        assert plant.geometry is not None
        reach, alike, least = float(plant.geometry.reach), ALIKE, np.full(2, LEAST**2)
        k = wavenumber(omega, plant.depth, plant.geometry.g) * math.cos(math.radians(heading))
    else:
        reach, alike, least, k = 0.0, 1.0, np.minimum(noise, LEAST**2), np.zeros(omega.size)
    return Placed(
        reach,
        float(response.grid.width),
        (step / SLOW, far * step / SLOWER),
        far,
        alike,
        edges,
        ages,
        np.ascontiguousarray(-step * np.outer(ages, omega)),
        k,
        np.stack([part for moment in seen for part in (moment.real, moment.imag)]),
        np.ascontiguousarray(np.concatenate([turned.real, -turned.imag], axis=1)),
        np.clip(noise, least, MOST**2),
        least,
    )


def begun(c: Placed | None) -> PlacedState:
    """Return the state before the first sample."""
    leads = 0 if c is None else c.ahead.shape[2]
    misfit = np.zeros(0) if c is None else c.misfit.copy()
    new = np.zeros
    judged, due = new((2, misfit.size)), new(2, np.int64)
    return PlacedState(new((2, leads)), new((2, leads)), misfit, np.ones(misfit.size), judged, due)


def _stride(age: float) -> int:
    return 1 if age <= DENSE else (2 if age <= SPARSE else 4)


def _edges(response: Responses, widths: tuple[float, float]) -> NDArray[np.int64]:
    """Where the bins of the forecast begin and end, in those of the spectrum."""
    omega, width = response.grid
    edges = [0]
    while edges[-1] < omega.size and omega[edges[-1]] < HIGHEST:
        wide = widths[0] if omega[edges[-1]] < HIGH else widths[1]
        edges.append(min(edges[-1] + max(round(wide / width), 1), omega.size))
    return np.array(edges, np.int64)


@stamped(SOURCES)
def predict_placed(
    c: Placed, state: PlacedState, spectrum: Array, history: Array, samples: int, now: Array, out: NDArray[np.float64]
) -> None:
    """Write the moments at rest (2, n) at 1 .. n steps ahead, and those of now into `now` (2,). [Nm]

    `history` (past, 3) is a round buffer of the moments at the float [Nm] and of its place, the sine of phi1.
    """
    bins, size = c.k.size, 2 * known_of(c, samples)
    A, y, root = np.empty((size, 2 * bins)), np.empty(size), np.empty(2 * bins)
    U, z = np.zeros((2 * bins, 2 * bins)), np.zeros(2 * bins)
    scale_waves(c, spectrum, root)
    observe_waves(c, state.misfit, root, np.zeros(bins), history, samples, A, y)
    add_normal_equations(A, y, U, z)
    for r in range(2 * bins):
        U[r, r] += 1.0
    foresee_waves(c, state, root, A, y, U, z, 0, samples, now, out)


@stamped(SOURCES)
def known_of(c: Placed, samples: int) -> int:
    """How many of the ages that are looked at have been observed."""
    known = 0
    while known < c.ages.size and c.ages[known] < samples:
        known += 1
    return known


@stamped(SOURCES)
def scale_waves(c: Placed, spectrum: Array, root: Array) -> None:
    """Standard deviations (2 b,) of the amplitudes' parts under the spectrum. [m]"""
    bins = c.k.size
    for b in range(bins):
        variance = 0.0
        for of in range(c.edges[b], c.edges[b + 1]):
            variance += spectrum[of] * c.width
        root[b] = math.sqrt(variance)
        root[bins + b] = root[b]


@stamped(SOURCES)
def add_normal_equations(A: Array, y: Array, U: Array, z: Array) -> None:
    """Add A' A to the upper half of U, and A' y to z."""
    size, twice = A.shape
    across = np.empty((twice, size))
    for r in range(size):
        for b in range(twice):
            across[b, r] = A[r, b]
    add_rows(y, lent(A), 0, size, z, 0, twice)
    for r in range(twice):
        add_rows(across[r], lent(A), 0, size, U[r], r, twice)


@stamped(SOURCES)
def foresee_waves(
    c: Placed,
    state: PlacedState,
    root: Array,
    A: Array,
    y: Array,
    U: Array,
    z: Array,
    since: int,
    samples: int,
    now: Array,
    out: NDArray[np.float64],
) -> None:
    """Solve the normal equations, write what follows as `predict_placed` does, and learn from what does not.

    U and z are lost. The phases of the amplitudes are those of an instant `since` steps before the last sample.
    """
    twice = z.size
    factorise_upper(U)
    solve_upper(U, z)
    left, explained = np.empty(2), np.empty(2)  # of the newest values
    for j in range(2):
        left[j] = y[j]
        for b in range(twice):
            left[j] -= A[j, b] * z[b]
    for b in range(twice):
        z[b] *= root[b]
    spread_of(c, U, root, A, since, state, explained)
    learn_misfit(c, state, samples, left, explained)
    leads = c.ahead.shape[2]
    row, later = np.empty(leads), np.empty(2)
    for j in range(2):
        row[:] = 0.0
        add_rows(z, lent(c.ahead[j]), 0, twice, row, 0, leads)
        now[j], later[j] = row[since], row[since + c.far]
        for lead in range(out.shape[1]):
            out[j, lead] = row[since + lead + 1] if since + lead + 1 < leads else 0.0
    learn_scale(c, state, samples, now, later)


@stamped(SOURCES)
def observe_waves(
    c: Placed, misfit: Array, root: Array, turn: Array, history: Array, samples: int, A: Array, y: Array
) -> None:
    """Write what was seen, over the deviation of its misfit, and the moments of amplitudes of unit variance there.

    `turn` (b,) is the phase of the waves of each bin at the last sample, at rest. [rad]
    """
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
            real, imaginary = cos_sin(phase[b] + turn[b] - c.k[b] * place)
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
def spread_of(c: Placed, U: Array, root: Array, A: Array, since: int, state: PlacedState, explained: Array) -> None:
    """Standard deviation of the moments now and ahead. [Nm]

    It is worked out at every lead, for it goes up and down twice in a wave.

    `explained` (2,) is filled with that of what the newest values see, over the variance of their misfit: a' G^-1 a.
    """
    twice, leads = root.size, state.variance.shape[1] - since
    count = 2 * leads + 2
    W, column, total = np.empty((twice, count)), np.empty(twice), np.zeros(count)
    for r in range(twice):  # U' W = the moments at those leads, of amplitudes of unit variance
        row = W[r]
        for j in range(2):
            ahead = c.ahead[j, r]
            for lead in range(leads):
                row[j * leads + lead] = root[r] * ahead[since + lead]
            row[2 * leads + j] = A[j, r]
    for r in range(twice):
        for i in range(r):
            column[i] = -U[i, r]
        row, inverse = W[r], 1.0 / U[r, r]
        add_rows(column, lent(W), 0, r, row, 0, count)
        for i in range(count):
            row[i] *= inverse
            total[i] += row[i] * row[i]
    for j in range(2):
        explained[j] = total[2 * leads + j]
        scale = min(max(state.scale[j], NARROW), WIDE)
        for lead in range(leads):
            state.variance[j, lead] = total[j * leads + lead]
            state.spread[j, lead] = math.sqrt(scale * total[j * leads + lead])


@stamped(SOURCES)
def learn_misfit(c: Placed, state: PlacedState, samples: int, left: Array, explained: Array) -> None:
    """Learn from what the newest values leave unexplained, over the deviation of their misfit (2,), once a sample."""
    if state.due[1] == samples:
        return
    state.due[1] = samples
    for j in range(2):
        deviation = min(left[j] ** 2 / (1.0 - explained[j]), FAR)
        grown = state.misfit[j] * math.exp(c.rates[0] * (c.alike * deviation - 1.0))
        state.misfit[j] = min(max(grown, c.least[j]), MOST * MOST)


@stamped(SOURCES)
def learn_scale(c: Placed, state: PlacedState, samples: int, now: Array, later: Array) -> None:
    """Learn from the forecast of now (2,) that was made before, and put another one by, of `c.far` steps ahead."""
    if samples < state.due[0]:
        return
    for j in range(2):
        explained = state.judged[1, j] - state.variance[j, 0]
        if state.due[0] == samples and explained > 0.0:
            deviation = min((now[j] - state.judged[0, j]) ** 2 / explained, FAR)
            state.scale[j] += c.rates[1] * (deviation - state.scale[j])
        state.judged[0, j], state.judged[1, j] = later[j], state.variance[j, c.far]
    state.due[0] = samples + c.far
