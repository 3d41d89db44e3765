"""The spectrum of the sea, learnt from the moments themselves.

What was seen is kept as covariances over the lag, with exponential forgetting. Every few seconds the spectrum takes one
step towards the one under which windows of the past are most likely. With a_b the moments that a unit wave of bin b
gives in a window, C the covariance of windows as seen and G that of the present spectrum, the likelihood grows along
q_b - e_b, where q_b = a_b^H G^-1 C G^-1 a_b and e_b = a_b^H G^-1 a_b. That one vector drives two things:

- a Fisher-scoring step of level, peak frequency and gamma of a JONSWAP sea, with a weak prior that fades as data come;
- a step of expectation-maximisation of every bin, which finds what no JONSWAP sea has.

The fit looks through a coarser glass than the forecast: a few Nm of doubt are added to G. Without them the likelihood
would be ruled by the quiet ends of the spectrum, where the smallest error of the model outweighs the waves.

The second is drawn towards the first. A few minutes hold fewer than a hundred waves: bins alone would learn their
noise, three numbers alone would be wrong in a mixed sea.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import compiled, row_sums
from gyroctl.plant.compiled import stamped
from gyroctl.plant.row_sums import add_rows
from gyroctl.waves import spectrum
from gyroctl.waves.estimation import sea_shape
from gyroctl.waves.estimation.moment_model import Array
from gyroctl.waves.estimation.sea_shape import HIGHEST, LOWEST, log_spectrum

SOURCES = (compiled.__file__, row_sums.__file__, spectrum.__file__, sea_shape.__file__, __file__)

DRAWN = 0.2
"""Part by which the bins are drawn to the JONSWAP sea at each fit."""

TRUST = (0.7, 0.1, 0.7)
"""Largest step of the three numbers at one fit."""

PRIOR = (1.5, 0.15, 1.2)
"""Standard deviations of the three numbers before anything has been seen."""

SPARED = 2
"""Bins between those that make up the Fisher information."""


class Learner(NamedTuple):
    """Constants of the fit."""

    ages: NDArray[np.int64]  # (m,) of the values looked at, recent first [steps]
    seen: Array  # (4, b, past), see `Kernels`
    ahead: Array  # (4, b, past + horizon)
    noise: Array  # (4, past) [Nm^2]
    steering: Array  # (2 m, 2 b), moments of a unit wave of each bin: real parts, then imaginary ones [Nm/m]
    omega: Array  # (b,) [rad/s]
    width: float  # of a bin [rad/s]
    prior: Array  # (b,) spectrum to start from [m^2 s]
    shape: Array  # (3,) its JONSWAP numbers
    every: int  # samples between two fits, 0 for none
    fade: float  # factor of forgetting per sample
    window: float  # length of a window [samples]
    doubt: float  # variance added to what is looked at while learning [Nm^2]

    def init(self) -> LearnerState:
        """Return a state that knows the prior only."""
        values = self.steering.shape[0]
        state = LearnerState(
            self.prior.copy(),
            self.shape.copy(),
            np.zeros(self.noise.shape),
            np.zeros(1),
            np.zeros((4, self.ahead.shape[2])),
            np.zeros((values, values)),
        )
        factorise(self, state, 0.0)
        return state


class LearnerState(NamedTuple):
    """What has been learnt, changed in place.

    Whoever keeps states apart copies it at every sample, so it is small: the working space of a fit, which is rare, is
    allocated there.
    """

    spectrum: Array  # (b,) [m^2 s]
    shape: Array  # (3,) JONSWAP numbers
    products: Array  # (4, past) sums of products over the lag, forgotten exponentially [Nm^2]
    weight: Array  # (1,) the sum of the weights, 1 when the memory is full
    ahead: Array  # (4, past + horizon) covariances of the present spectrum [Nm^2]
    whitener: Array  # (2 m, 2 m), lower V with G^-1 = V^T V


class Fit(NamedTuple):
    """Working space of a fit."""

    solved: Array  # (2 m, 2 b), G^-1 a_b
    q: Array  # (b,)
    e: Array  # (b,)
    slopes: Array  # (b, 3), of log S with the three numbers
    overlap: Array  # (2, b', b'), a_b^H G^-1 a_c of spared bins
    system: Array  # (3, 4), the linear equations of the three numbers


@stamped(SOURCES)
def factorise(learner: Learner, state: LearnerState, doubt: float) -> None:
    """Covariances at the present spectrum, the factor of those looked at and its inverse.

    `doubt` is a variance added to the values looked at. [Nm^2]
    """
    S, ages, V = state.spectrum, learner.ages, state.whitener
    size, lags = V.shape[0], learner.noise.shape[1]
    U, seen, column = np.empty((size, size)), np.empty((4, lags)), np.empty(size)  # G = U^T U, V = U^-T
    for p in range(4):
        for lag in range(lags):
            seen[p, lag] = learner.noise[p, lag]
        add_rows(S, learner.seen[p], 0, S.size, seen[p], 0, lags)
        state.ahead[p, :] = 0.0
        add_rows(S, learner.ahead[p], 0, S.size, state.ahead[p], 0, state.ahead.shape[1])
    for r in range(size):
        for c in range(r, size):  # column c is the older: E o_i(t - a) o_j(t - b) at the lag b - a
            U[r, c] = seen[2 * (r % 2) + c % 2, ages[c // 2] - ages[r // 2]]
        U[r, r] += doubt
    for r in range(size):
        for k in range(r):
            column[k] = -U[k, r]
        add_rows(column, U, 0, r, U[r], r, size)
        pivot = math.sqrt(U[r, r])
        for c in range(r, size):
            U[r, c] /= pivot
    for r in range(size):
        for c in range(size):
            V[r, c] = 0.0
        V[r, r] = 1.0
        for k in range(r):
            f = U[k, r]
            for c in range(k + 1):
                V[r, c] -= f * V[k, c]
        for c in range(r + 1):
            V[r, c] /= U[r, r]


@stamped(SOURCES)
def correlate(learner: Learner, state: LearnerState, history: NDArray[np.float64], at: int) -> None:
    """Take the newest moments, row `at` of the round buffer, into the products over the lag."""
    keep, share, length = learner.fade, 1.0 - learner.fade, history.shape[0]
    one, three = share * history[at, 0], share * history[at, 1]
    products = state.products
    for lag in range(length):
        row = at - lag if lag <= at else at - lag + length
        h1, h3 = history[row, 0], history[row, 1]
        products[0, lag] = keep * products[0, lag] + one * h1
        products[1, lag] = keep * products[1, lag] + one * h3
        products[2, lag] = keep * products[2, lag] + three * h1
        products[3, lag] = keep * products[3, lag] + three * h3
    state.weight[0] = keep * state.weight[0] + share


@stamped(SOURCES)
def learn(learner: Learner, state: LearnerState) -> None:
    """Take one step of the fit and factorise anew."""
    bins = learner.omega.size
    spared = (bins + SPARED - 1) // SPARED
    overlap, system = np.zeros((2, spared, spared)), np.zeros((3, 4))
    solved, slopes = np.zeros(learner.steering.shape), np.zeros((bins, 3))
    fit = Fit(solved, np.zeros(bins), np.zeros(bins), slopes, overlap, system)
    factorise(learner, state, learner.doubt)
    whiten(learner, state, fit)
    compare(learner, state, fit)
    fit_shape(learner, state, fit)
    fit_bins(learner, state, fit)
    factorise(learner, state, 0.0)


@stamped(SOURCES)
def whiten(learner: Learner, state: LearnerState, fit: Fit) -> None:
    """G^-1 a_b and e_b."""
    A, V, X = learner.steering, state.whitener, fit.solved
    size, twice = A.shape
    bins, Z, column = twice // 2, np.zeros((size, twice)), np.empty(size)
    for r in range(size):
        z = Z[r]
        add_rows(V[r], A, 0, r + 1, z, 0, twice)
        for b in range(bins):
            fit.e[b] += z[b] * z[b] + z[bins + b] * z[bins + b]
    for k in range(size):
        for r in range(k, size):
            column[r] = V[r, k]
        add_rows(column, Z, k, size, X[k], 0, twice)


@stamped(SOURCES)
def compare(learner: Learner, state: LearnerState, fit: Fit) -> None:
    """q_b, from the covariances as seen."""
    X, ages, q = fit.solved, learner.ages, fit.q
    size, twice = X.shape
    bins, y, row = twice // 2, np.empty(twice), np.empty(size)
    scale = 1.0 / state.weight[0]
    for r in range(size):
        for c in range(size):
            lag = ages[c // 2] - ages[r // 2]
            if lag >= 0:
                row[c] = scale * state.products[2 * (r % 2) + c % 2, lag]
            else:
                row[c] = scale * state.products[2 * (c % 2) + r % 2, -lag]
        y[:] = 0.0
        add_rows(row, X, 0, size, y, 0, twice)
        for b in range(bins):
            q[b] += X[r, b] * y[b] + X[r, bins + b] * y[bins + b]


@stamped(SOURCES)
def fit_shape(learner: Learner, state: LearnerState, fit: Fit) -> None:
    """One Fisher-scoring step of level, peak and sharpness."""
    S, slopes, M, H = state.spectrum, fit.slopes, fit.system, fit.overlap
    A, X, shape = learner.steering, fit.solved, state.shape
    size, bins = A.shape[0], S.size
    for b in range(bins):
        log_spectrum(shape, learner.omega[b], slopes[b])
    spared = H.shape[1]
    reals, imaginaries = np.empty(spared), np.empty(spared)
    for r in range(size):
        for j in range(spared):
            reals[j], imaginaries[j] = X[r, SPARED * j], X[r, bins + SPARED * j]
        for i in range(spared):
            real, imaginary = A[r, SPARED * i], A[r, bins + SPARED * i]
            for j in range(spared):
                H[0, i, j] += real * reals[j] + imaginary * imaginaries[j]
                H[1, i, j] += real * imaginaries[j] - imaginary * reals[j]
    # the prior weighs as much as one window against the number of windows seen
    windows = 1.0 + min(-math.log(max(1.0 - state.weight[0], 1e-9)), 1.0) / -math.log(learner.fade) / learner.window
    for k in range(3):
        precision = 1.0 / (PRIOR[k] * PRIOR[k] * windows)
        M[k, k] = precision
        M[k, 3] = -precision * (shape[k] - learner.shape[k])
        for b in range(bins):
            M[k, 3] += 0.5 * learner.width * slopes[b, k] * S[b] * (fit.q[b] - fit.e[b])
    area = (SPARED * learner.width) ** 2
    for i in range(spared):
        for j in range(spared):
            b, c = SPARED * i, SPARED * j
            weight = 0.25 * area * S[b] * S[c] * (H[0, i, j] ** 2 + H[1, i, j] ** 2)
            for k in range(3):
                for l in range(3):
                    M[k, l] += weight * slopes[b, k] * slopes[c, l]
    for k in range(3):  # M is positive definite: no pivoting
        for r in range(k + 1, 3):
            f = M[r, k] / M[k, k]
            for c in range(k, 4):
                M[r, c] -= f * M[k, c]
    for k in range(2, -1, -1):
        for c in range(k + 1, 3):
            M[k, 3] -= M[k, c] * M[c, 3]
        M[k, 3] /= M[k, k]
    for k in range(3):
        shape[k] += 0.7 * min(max(M[k, 3], -TRUST[k]), TRUST[k])
        shape[k] = min(max(shape[k], LOWEST[k]), HIGHEST[k])


@stamped(SOURCES)
def fit_bins(learner: Learner, state: LearnerState, fit: Fit) -> None:
    """Expectation-maximisation of every bin, drawn to the JONSWAP sea."""
    S, slopes = state.spectrum, fit.slopes
    for b in range(S.size):
        jonswap = math.exp(log_spectrum(state.shape, learner.omega[b], slopes[b]))
        grown = 1.0 + 0.5 * learner.width * S[b] * (fit.q[b] - fit.e[b])
        S[b] = (1.0 - DRAWN) * S[b] * min(max(grown, 0.1), 10.0) + DRAWN * jonswap
