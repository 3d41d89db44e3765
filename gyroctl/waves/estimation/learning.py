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
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import compiled
from gyroctl.plant.compiled import entry_point, source_stamp
from gyroctl.waves import spectrum
from gyroctl.waves.estimation import sea_shape
from gyroctl.waves.estimation.averaged import Array
from gyroctl.waves.estimation.sea_shape import HIGHEST, LOWEST, log_spectrum

SOURCES = (compiled.__file__, spectrum.__file__, sea_shape.__file__, __file__)

DRAWN = 0.3
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
    seen: Array  # (4, past, b), see `Kernels`
    ahead: Array  # (4, past + horizon, b)
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
        values, twice = self.steering.shape
        lags, spared = self.seen.shape[1], (self.omega.size + SPARED - 1) // SPARED
        return LearnerState(
            self.prior.copy(), self.shape.copy(), np.zeros((4, lags)), np.zeros(1), np.zeros((4, lags)),
            np.zeros(self.ahead.shape[:2]), np.zeros((values, values)), np.zeros((values, values)),
            np.zeros((values, twice)), np.zeros(twice), np.zeros((2, self.omega.size)),
            np.zeros((self.omega.size, 4)), np.zeros((2, spared, spared)), np.zeros((3, 4)),
        )  # fmt: skip


class LearnerState(NamedTuple):
    """What has been learnt, changed in place."""

    spectrum: Array  # (b,) [m^2 s]
    shape: Array  # (3,) JONSWAP numbers
    products: Array  # (4, past) sums of products over the lag, forgotten exponentially [Nm^2]
    seconds: Array  # (1,) their weight, 1 when the memory is full
    seen: Array  # (4, past) covariances of the present spectrum
    ahead: Array  # (4, past + horizon)
    factor: Array  # (2 m, 2 m), upper U of G = U^T U
    whitener: Array  # (2 m, 2 m), lower V = U^-T, so that G^-1 = V^T V
    solved: Array  # (2 m, 2 b), G^-1 a_b
    row: Array  # (2 b,)
    power: Array  # (2, b), q_b and e_b
    slopes: Array  # (b, 4), of log S with the three numbers, and the JONSWAP spectrum
    overlap: Array  # (2, b', b'), a_b^H G^-1 a_c of spared bins
    step: Array  # (3, 4), the linear system of the three numbers


def _factorise(stamp: str) -> Any:
    def factorise(learner: Learner, state: LearnerState, doubt: float) -> None:
        """Covariances at the present spectrum, the factor of those looked at and its inverse.

        `doubt` is a variance added to the values looked at. [Nm^2]
        """
        assert stamp
        S, ages, U, V = state.spectrum, learner.ages, state.factor, state.whitener
        for p in range(4):
            for lag in range(learner.seen.shape[1]):
                total = learner.noise[p, lag]
                for b in range(S.size):
                    total += learner.seen[p, lag, b] * S[b]
                state.seen[p, lag] = total
            for lag in range(learner.ahead.shape[1]):
                total = 0.0
                for b in range(S.size):
                    total += learner.ahead[p, lag, b] * S[b]
                state.ahead[p, lag] = total
        size = U.shape[0]
        for r in range(size):
            for c in range(r, size):  # column c is the older: E o_i(t - a) o_j(t - b) at the lag b - a
                U[r, c] = state.seen[2 * (r % 2) + c % 2, ages[c // 2] - ages[r // 2]]
            U[r, r] += doubt
        for k in range(size):
            pivot = math.sqrt(U[k, k])
            for c in range(k, size):
                U[k, c] /= pivot
            for r in range(k + 1, size):
                f = U[k, r]
                for c in range(r, size):
                    U[r, c] -= f * U[k, c]
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

    return entry_point(factorise)


def _correlate(stamp: str) -> Any:
    def correlate(learner: Learner, state: LearnerState, history: NDArray[np.float64], at: int) -> None:
        """Take the newest moments, row `at` of the round buffer, into the products over the lag."""
        assert stamp
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
        state.seconds[0] = keep * state.seconds[0] + share

    return entry_point(correlate)


def _learn(stamp: str) -> Any:
    def learn(learner: Learner, state: LearnerState) -> None:
        """Take one step of the fit and factorise anew."""
        assert stamp
        factorise(learner, state, learner.doubt)
        whiten(learner, state)
        compare(learner, state)
        fit_shape(learner, state)
        fit_bins(learner, state)
        factorise(learner, state, 0.0)

    return entry_point(learn)


def _whiten(stamp: str) -> Any:
    def whiten(learner: Learner, state: LearnerState) -> None:
        """G^-1 a_b and e_b."""
        assert stamp
        A, V, X, z = learner.steering, state.whitener, state.solved, state.row
        size, twice = A.shape
        bins = twice // 2
        X[:, :] = 0.0
        state.power[1, :] = 0.0
        for r in range(size):
            for b in range(twice):
                z[b] = 0.0
            for k in range(r + 1):
                f = V[r, k]
                for b in range(twice):
                    z[b] += f * A[k, b]
            for k in range(r + 1):
                f = V[r, k]
                for b in range(twice):
                    X[k, b] += f * z[b]
            for b in range(bins):
                state.power[1, b] += z[b] * z[b] + z[bins + b] * z[bins + b]

    return entry_point(whiten)


def _compare(stamp: str) -> Any:
    def compare(learner: Learner, state: LearnerState) -> None:
        """q_b, from the covariances as seen."""
        assert stamp
        X, y, ages, q = state.solved, state.row, learner.ages, state.power[0]
        size, twice = X.shape
        bins = twice // 2
        scale = 1.0 / state.seconds[0]
        q[:] = 0.0
        for r in range(size):
            for b in range(twice):
                y[b] = 0.0
            for c in range(size):
                lag = ages[c // 2] - ages[r // 2]
                if lag >= 0:
                    f = scale * state.products[2 * (r % 2) + c % 2, lag]
                else:
                    f = scale * state.products[2 * (c % 2) + r % 2, -lag]
                for b in range(twice):
                    y[b] += f * X[c, b]
            for b in range(bins):
                q[b] += X[r, b] * y[b] + X[r, bins + b] * y[bins + b]

    return entry_point(compare)


def _fit_shape(stamp: str) -> Any:
    def fit_shape(learner: Learner, state: LearnerState) -> None:
        """One Fisher-scoring step of level, peak and sharpness."""
        assert stamp
        S, slopes, M, H = state.spectrum, state.slopes, state.step, state.overlap
        A, X, shape = learner.steering, state.solved, state.shape
        size, bins = A.shape[0], S.size
        for b in range(bins):
            slopes[b, 3] = math.exp(log_spectrum(shape, learner.omega[b], slopes[b]))
        H[:, :, :] = 0.0
        spared = H.shape[1]
        for r in range(size):
            for i in range(spared):
                real, imaginary = A[r, SPARED * i], A[r, bins + SPARED * i]
                for j in range(spared):
                    H[0, i, j] += real * X[r, SPARED * j] + imaginary * X[r, bins + SPARED * j]
                    H[1, i, j] += real * X[r, bins + SPARED * j] - imaginary * X[r, SPARED * j]
        # the prior weighs as much as one window against the number of windows seen
        windows = 1.0 + min(-math.log(max(1.0 - state.seconds[0], 1e-9)), 1.0) / (-math.log(learner.fade)) / learner.window
        M[:, :] = 0.0
        for k in range(3):
            precision = 1.0 / (PRIOR[k] * PRIOR[k] * windows)
            M[k, k] = precision
            M[k, 3] = -precision * (shape[k] - learner.shape[k])
            for b in range(bins):
                M[k, 3] += 0.5 * learner.width * slopes[b, k] * S[b] * (state.power[0, b] - state.power[1, b])
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

    return entry_point(fit_shape)


def _fit_bins(stamp: str) -> Any:
    def fit_bins(learner: Learner, state: LearnerState) -> None:
        """Expectation-maximisation of every bin, drawn to the JONSWAP sea."""
        assert stamp
        S, slopes = state.spectrum, state.slopes
        for b in range(S.size):
            jonswap = math.exp(log_spectrum(state.shape, learner.omega[b], slopes[b]))
            grown = 1.0 + 0.5 * learner.width * S[b] * (state.power[0, b] - state.power[1, b])
            S[b] = (1.0 - DRAWN) * S[b] * min(max(grown, 0.1), 10.0) + DRAWN * jonswap

    return entry_point(fit_bins)


factorise = _factorise(source_stamp(SOURCES))
correlate = _correlate(source_stamp(SOURCES))
whiten = _whiten(source_stamp(SOURCES))
compare = _compare(source_stamp(SOURCES))
fit_shape = _fit_shape(source_stamp(SOURCES))
fit_bins = _fit_bins(source_stamp(SOURCES))
learn = _learn(source_stamp(SOURCES))
