"""Forecast of the moments in a known sea, against closed forms and brute force, and what a predictor refuses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray
from wave_predictors import LEADS, SEED, fed, known, moments

import gyroctl as gy
from gyroctl.waves.estimation import (
    MomentEstimator,
    Predictor,
    forecast,
    observe,
    predict,
    relative_error,
    replay_moments,
)
from gyroctl.waves.estimation.gaussian import PAIRS, bins
from gyroctl.waves.estimation.predictor import PredictorState
from gyroctl.waves.estimation.sea_shape import log_spectrum, shape_of

Array = NDArray[np.float64]


def covariance(predictor: Predictor) -> Array:
    """G of the values looked at, by its definition."""
    learner, state = predictor.learner, predictor.init()
    size = 2 * learner.ages.size
    seen = predictor.learner.noise + state.memory.spectrum @ learner.seen
    G = np.empty((size, size))
    for r in range(size):
        for c in range(size):
            lag = learner.ages[c // 2] - learner.ages[r // 2]
            i, j = (r % 2, c % 2) if lag >= 0 else (c % 2, r % 2)
            G[r, c] = seen[PAIRS.index((i, j)), abs(lag)]
    return G


def towards(predictor: Predictor, moment: int, lead: int) -> Array:
    """g of the moment `lead` steps ahead with the values looked at, by its definition."""
    learner, state = predictor.learner, predictor.init()
    ahead = state.memory.spectrum @ learner.ahead
    return np.array([ahead[PAIRS.index((moment, j)), lead + age] for age in learner.ages for j in range(2)])


# --- covariances -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", [1.0, 50.0])
def test_covariances_are_the_integral_over_the_spectrum(device: gy.Plant, gamma: float) -> None:
    sea = gy.SeaState(gamma=gamma)
    predictor = known(device, sea=sea, grid=bins(width=0.05))
    omega = np.arange(0.3, 12.6, 0.001)
    he, S = device.excitation(omega, 0.0), sea.spectrum(omega)
    ahead = predictor.init().memory.ahead
    for lag in (0, 3, 20, 77, 190):
        for p, (i, j) in enumerate(PAIRS):
            exact = np.sum(np.real(he[i] * np.conj(he[j]) * np.exp(0.1j * omega * lag)) * S) * 0.001
            scale = math.sqrt(ahead[3 * i, 0] * ahead[3 * j, 0])
            assert ahead[p, lag] == pytest.approx(exact, abs=0.02 * scale)


def test_covariances_are_those_of_a_realisation(device: gy.Plant) -> None:
    predictor = known(device)
    values = np.concatenate([moments(device, gy.SeaState(), 2000.0, seed)[:, :-1] for seed in range(SEED, SEED + 8)], 1)
    ahead = predictor.init().memory.ahead
    for lag in (0, 5, 13):
        sample = values[:, lag:] @ values[:, : values.shape[1] - lag].T / (values.shape[1] - lag)
        np.testing.assert_allclose(ahead[:, lag].reshape(2, 2), sample, atol=0.03 * sample.max())


def test_the_prior_is_the_sea(device: gy.Plant) -> None:
    slopes = np.zeros(3)
    for sea in (gy.SeaState(), gy.SeaState(0.5, 2.7, 1.0), gy.SeaState(0.15, 3.6, 50.0)):
        shape = np.array(shape_of(sea))
        for omega in (1.7, sea.wp, 4.4, 9.0):
            assert math.exp(log_spectrum(shape, omega, slopes)) == pytest.approx(
                float(sea.spectrum(np.array([omega]))[0]), rel=1e-9
            )
            for k in range(3):
                step = np.zeros(3)
                step[k] = 1e-6
                up, down = (log_spectrum(shape + sign * step, omega, np.zeros(3)) for sign in (1.0, -1.0))
                if abs(omega - sea.wp) > 1e-3:  # the width of the peak jumps there, (40)
                    assert slopes[k] == pytest.approx((up - down) / 2e-6, rel=1e-5, abs=1e-6)


# --- Wiener ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 7, 60, 300])
def test_forecast_is_the_conditional_mean(device: gy.Plant, count: int) -> None:
    """Whatever has been seen so far, however little, by solving the normal equations densely."""
    predictor = known(device)
    values = moments(device, gy.SeaState(), 30.0)[:, :count]
    state = fed(predictor, values)
    out = np.empty((2, 80))
    predict(predictor, state, out)
    ages = predictor.learner.ages[predictor.learner.ages < count]
    G = covariance(predictor)[: 2 * ages.size, : 2 * ages.size]
    m = values[:, count - 1 - ages].T.ravel()
    for moment in range(2):
        for lead in (0, 1, 10, 80):
            exact = towards(predictor, moment, lead)[: m.size] @ np.linalg.solve(G, m)
            got = state.now[moment] if lead == 0 else out[moment, lead - 1]
            assert got == pytest.approx(exact, rel=1e-6, abs=1e-4)


def test_error_of_the_forecast_is_wieners(device: gy.Plant) -> None:
    """The closed-form error of a known Gaussian sea is what is found on its realisations."""
    predictor = known(device, floor=3.0)
    G = covariance(predictor)
    rng = np.random.default_rng(5)
    found = np.zeros((2, len(LEADS)))
    for seed in (SEED, SEED + 1):
        values = moments(device, gy.SeaState(), 800.0, seed)
        noisy = values + 3.0 * rng.standard_normal(values.shape)
        found += 0.5 * relative_error(predictor, LEADS, replay_moments(predictor, LEADS, noisy), values, 12.0)
    for moment in range(2):
        variance = predictor.init().memory.ahead[3 * moment, 0]
        for a, lead in enumerate(LEADS):
            g = towards(predictor, moment, round(10 * lead))
            assert found[moment, a] == pytest.approx(1.0 - g @ np.linalg.solve(G, g) / variance, rel=0.12, abs=0.004)


def test_no_linear_forecast_fitted_to_the_record_is_much_better(device: gy.Plant) -> None:
    """Brute force: least squares on the same past, fitted and judged on the same record, which flatters it."""
    predictor = known(device)
    values = moments(device, gy.SeaState(), 1000.0)
    ages, lead = predictor.learner.ages, 20
    at = np.arange(ages[-1], values.shape[1] - lead)
    X = np.concatenate([values[:, at - age] for age in ages]).T
    weights = np.linalg.solve(X.T @ X + 0.3**2 * len(at) * np.eye(X.shape[1]), X.T @ values[1, at + lead])
    fitted = np.mean((X @ weights - values[1, at + lead]) ** 2) / np.var(values[1])
    ours = relative_error(predictor, (2.0,), replay_moments(predictor, (2.0,), values), values, 12.0)[1, 0]
    assert fitted < ours < 1.4 * fitted


# --- broken values, compiled code ------------------------------------------------------------------------------------


def test_a_value_that_is_no_number_does_no_lasting_harm(device: gy.Plant) -> None:
    predictor = Predictor.design(device)
    values = moments(device, gy.SeaState(), 60.0)
    broken = values.copy()
    broken[0, 200], broken[1, 300] = math.nan, math.inf
    out, other = np.empty((2, 80)), np.empty((2, 80))
    predict(predictor, fed(predictor, values), out)
    predict(predictor, fed(predictor, broken), other)
    assert np.all(np.isfinite(other)) and np.abs(other - out).max() < 0.1 * np.abs(out).max()


@pytest.mark.slow
def test_compiled_code_may_call_it(device: gy.Plant) -> None:
    predictor, values = known(device), moments(device, gy.SeaState(), 20.0)

    @njit
    def run(predictor: Predictor, state: PredictorState, values: Array, out: Array) -> None:
        for i in range(values.shape[1]):
            observe(predictor, state, values[0, i], values[1, i])
        predict(predictor, state, out)

    out, other = np.empty((2, 80)), np.empty((2, 80))
    run(predictor, predictor.init(), values, out)
    predict(predictor, fed(predictor, values), other)
    np.testing.assert_array_equal(out, other)


# --- bad input -------------------------------------------------------------------------------------------------------


def test_forecast_beyond_the_horizon_is_refused(device: gy.Plant) -> None:
    predictor = known(device, horizon=4.0)
    state = fed(predictor, moments(device, gy.SeaState(), 20.0))
    assert forecast(predictor, state, 4.0).shape == (2, 40)
    for seconds in (4.1, 0.0, -1.0, math.inf, math.nan):
        with pytest.raises(gy.InputError) as caught:
            forecast(predictor, state, seconds)
        assert caught.value.field == "forecast.seconds" and "4 s" in str(caught.value)
    with pytest.raises(gy.InputError, match="horizon"):
        replay_moments(predictor, (1.0, 5.0), np.zeros((2, 10)))
    out = np.ones((2, 50))
    predict(predictor, state, out)
    assert np.all(out[:, 40:] == 0.0) and np.all(out[:, :40] != 0.0)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"step": 0.0}, "predictor.step"),
        ({"horizon": math.inf}, "predictor.horizon"),
        ({"past": 0.01}, "predictor.past"),
        ({"forgetting": -1.0}, "predictor.forgetting"),
        ({"floor": math.nan}, "predictor.floor"),
        ({"doubt": True}, "predictor.doubt"),
    ],
)
def test_bad_design_names_field_and_mend(device: gy.Plant, change: dict[str, Any], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        Predictor.design(device, **change)
    assert caught.value.field == field and caught.value.mend


def test_estimator_of_another_period_is_refused(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match="estimator's period"):
        Predictor.design(device, estimator=MomentEstimator.design(device, period=0.2))
