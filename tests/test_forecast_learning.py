"""The predictor learns its sea: the slope of the likelihood, the seas found, and what learning is worth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from wave_predictors import LEADS, SEED, fed, known, moments

import gyroctl as gy
from gyroctl.waves.estimation import Predictor, relative_error, replay_moments
from gyroctl.waves.estimation.gaussian import PAIRS, bins
from gyroctl.waves.estimation.learning import DRAWN, Fit, compare, correlate, factorise, fit_bins, learn, whiten
from gyroctl.waves.estimation.sea_shape import log_spectrum

Array = NDArray[np.float64]


def test_what_drives_the_fit_is_the_slope_of_the_likelihood(device: gy.Plant) -> None:
    """q_b - e_b against the log-likelihood of windows, differentiated bin by bin."""
    predictor = Predictor.design(device, past=2.0, horizon=1.0, grid=bins(1.5, 6.0, 0.05))
    learner = predictor.learner
    state = learner.init()
    values = moments(device, gy.SeaState(hs=0.4, wp=2.8), 120.0)
    history = np.zeros((learner.seen.shape[2], 2))
    for n in range(values.shape[1]):
        history[n % len(history)] = values[:, n]
        if n >= len(history):
            correlate(learner, state, history, n % len(history))
    size, count = learner.steering.shape[0], learner.omega.size
    fit = Fit(
        np.zeros(learner.steering.shape),
        np.zeros(count),
        np.zeros(count),
        np.zeros((count, 3)),
        np.zeros((2, 1, 1)),
        np.zeros((3, 4)),
    )
    factorise(learner, state, learner.doubt)
    whiten(learner, state, fit)
    compare(learner, state, fit)
    products = state.products / state.weight[0]

    def arranged(table: Array) -> Array:
        full = np.empty((size, size))
        for r in range(size):
            for c in range(size):
                lag = learner.ages[c // 2] - learner.ages[r // 2]
                i, j = (r % 2, c % 2) if lag >= 0 else (c % 2, r % 2)
                full[r, c] = table[PAIRS.index((i, j)), abs(lag)]
        return full

    C = arranged(products)

    def likelihood(S: Array) -> float:
        G = arranged(learner.noise + S @ learner.seen) + learner.doubt * np.eye(size)
        return float(-0.5 * (np.linalg.slogdet(G)[1] + np.trace(np.linalg.solve(G, C))))

    S = state.spectrum
    for b in range(0, count, 9):
        step = np.zeros(count)
        step[b] = 1e-3 * S[b]
        slope = (likelihood(S + step) - likelihood(S - step)) / (2.0 * step[b])
        # a bin of the tables is an integral over its width; q and e are taken at its centre
        half = 0.5 * learner.width
        assert half * (fit.q[b] - fit.e[b]) == pytest.approx(slope, rel=0.03, abs=0.03 * half * fit.e[b])


@pytest.mark.parametrize("sea", [gy.SeaState(0.15, 2.8, 5.0), gy.SeaState(0.6, 3.5, 5.0), gy.SeaState(gamma=50.0)])
def test_the_sea_is_learnt(device: gy.Plant, sea: gy.SeaState) -> None:
    predictor = Predictor.design(device)
    values = moments(device, sea, 400.0)
    learnt = fed(predictor, values).memory
    best = known(device, sea=sea).init().memory.spectrum
    width = predictor.learner.width
    record = np.var(values[1]) / known(device, sea=sea).init().memory.ahead[3, 0]  # this stretch of it may be higher
    assert learnt.spectrum.sum() * width == pytest.approx(best.sum() * width * record, rel=0.25)
    assert math.exp(learnt.shape[1]) == pytest.approx(sea.wp, rel=0.04)
    if sea.gamma > 10.0:
        assert math.exp(learnt.shape[2]) > 12.0


def test_bins_find_what_no_jonswap_sea_has(device: gy.Plant) -> None:
    """Swell and wind sea together: less between the two peaks, more at them, than in the fitted JONSWAP sea."""
    swell, wind = gy.SeaState(0.2, 2.0, 10.0), gy.SeaState(0.25, 4.5, 5.0)
    values = moments(device, swell, 500.0) + moments(device, wind, 500.0, SEED + 1)
    predictor = Predictor.design(device)
    state = fed(predictor, values).memory
    omega = predictor.learner.omega
    fitted = np.exp([log_spectrum(state.shape, w, np.zeros(3)) for w in omega])
    at = [np.abs(omega - centre) < 0.25 for centre in (2.0, 3.2, 4.5)]
    peak, gap, second = (state.spectrum[band].sum() / fitted[band].sum() for band in at)
    assert peak > 1.3 * gap and second > 1.3 * gap
    assert state.spectrum[at[0]].mean() > 1.3 * state.spectrum[at[1]].mean()


def test_a_fit_step_raises_the_likelihood_and_keeps_the_spectrum_positive(device: gy.Plant) -> None:
    predictor = Predictor.design(device)
    state = fed(predictor, moments(device, gy.SeaState(0.6, 2.7, 50.0), 100.0))
    for _ in range(30):
        learn(predictor.learner, state.memory)
        assert np.all(state.memory.spectrum > 0.0) and np.all(np.isfinite(state.memory.whitener))


def test_bins_are_drawn_to_the_fitted_sea(device: gy.Plant) -> None:
    """Where the likelihood is flat (q = e) the bins go to the JONSWAP sea, by the stated part."""
    predictor = Predictor.design(device)
    learner, state = predictor.learner, predictor.init().memory
    count = learner.omega.size
    fit = Fit(
        np.zeros((1, 1)), np.ones(count), np.ones(count), np.zeros((count, 3)), np.zeros((2, 1, 1)), np.zeros((3, 4))
    )
    state.spectrum[:] = 2.0 * learner.prior
    fit_bins(learner, state, fit)
    np.testing.assert_allclose(state.spectrum, ((1.0 - DRAWN) * 2.0 + DRAWN) * learner.prior, rtol=1e-9)


def test_learning_is_nearly_as_good_as_knowing(device: gy.Plant) -> None:
    """And better than the generic sea where the sea is not generic."""
    sea = gy.SeaState(gamma=50.0)
    values = moments(device, sea, 500.0)
    error = {}
    for name, predictor in {
        "known": known(device, sea=sea),
        "learnt": Predictor.design(device),
        "generic": Predictor.design(device, forgetting=None),
    }.items():
        error[name] = relative_error(predictor, LEADS, replay_moments(predictor, LEADS, values), values, 200.0)
    assert np.all(error["learnt"] < 1.12 * error["known"] + 0.002)
    assert np.all(error["learnt"][:, 2:4] < 0.85 * error["generic"][:, 2:4])
