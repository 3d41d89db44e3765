"""Forecast of the moments, against closed forms, brute force and the seas it is made for."""

from __future__ import annotations

import csv
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.run import Settings, run_law
from gyroctl.plant.measurement import ROWS
from gyroctl.studies.forecast import forecast_report
from gyroctl.studies.forecast.report import SEAS
from gyroctl.studies.forecast.skill import SOURCES
from gyroctl.waves.estimation import (
    MomentEstimator,
    Predictor,
    Probe,
    forecast,
    foresee,
    observe,
    predict,
    relative_error,
    replay,
    replay_moments,
)
from gyroctl.waves.estimation.gaussian import PAIRS, bins
from gyroctl.waves.estimation.learning import DRAWN, Fit, compare, correlate, factorise, fit_bins, learn, whiten
from gyroctl.waves.estimation.predictor import PredictorState
from gyroctl.waves.estimation.sea_shape import log_spectrum, shape_of

Array = NDArray[np.float64]
SEED = 100050
LEADS = (0.5, 1.0, 2.0, 4.0, 8.0)


def moments(plant: gy.Plant, sea: Any, duration: float = 400.0, seed: int = SEED) -> Array:
    return gy.realise(plant, sea, seed, duration, 0.1).moments


def known(plant: gy.Plant, **changes: Any) -> Predictor:
    """A predictor that knows the sea and learns nothing."""
    return Predictor.design(plant, **{"sea": gy.SeaState(), "forgetting": None, **changes})


def fed(predictor: Predictor, values: Array) -> PredictorState:
    state = predictor.init()
    for one, three in values.T:
        observe(predictor, state, one, three)
    return state


def covariance(predictor: Predictor) -> Array:
    """G of the values looked at, by its definition."""
    learner, state = predictor.learner, predictor.init()
    size = 2 * learner.ages.size
    seen = predictor.learner.noise + learner.seen @ state.memory.spectrum
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
    ahead = learner.ahead @ state.memory.spectrum
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


# --- learning --------------------------------------------------------------------------------------------------------


def test_what_drives_the_fit_is_the_slope_of_the_likelihood(device: gy.Plant) -> None:
    """q_b - e_b against the log-likelihood of windows, differentiated bin by bin."""
    predictor = Predictor.design(device, past=2.0, horizon=1.0, grid=bins(1.5, 6.0, 0.05))
    learner = predictor.learner
    state = learner.init()
    values = moments(device, gy.SeaState(hs=0.4, wp=2.8), 120.0)
    history = np.zeros((learner.seen.shape[1], 2))
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
        G = arranged(learner.noise + learner.seen @ S) + learner.doubt * np.eye(size)
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


# --- skill -----------------------------------------------------------------------------------------------------------


def test_skill_falls_with_lead_and_rises_with_the_sharpness_of_the_peak(device: gy.Plant) -> None:
    errors = []
    for gamma in (50.0, 5.0, 1.0):
        sea = gy.SeaState(gamma=gamma)
        predictor, values = known(device, sea=sea), moments(device, sea, 500.0)
        errors.append(relative_error(predictor, LEADS, replay_moments(predictor, LEADS, values), values, 12.0))
    for error in errors:
        assert np.all(np.diff(error[:, :4], axis=1) > 0.0)
        assert np.all(error < 1.05)
    for sharper, flatter in pairwise(errors):
        assert np.all(sharper[:, 1:4] < flatter[:, 1:4])


def test_noise_costs_skill_and_its_knowledge_gives_some_back(device: gy.Plant) -> None:
    values = moments(device, gy.SeaState(), 300.0)
    noisy = values + 10.0 * np.random.default_rng(4).standard_normal(values.shape)
    plain, aware = known(device), known(device, floor=10.0)
    clean = relative_error(plain, LEADS, replay_moments(plain, LEADS, values), values, 12.0)
    naive = relative_error(plain, LEADS, replay_moments(plain, LEADS, noisy), values, 12.0)
    knowing = relative_error(aware, LEADS, replay_moments(aware, LEADS, noisy), values, 12.0)
    assert np.all(clean[:, :3] < knowing[:, :3]) and np.all(knowing < naive)


def test_forecast_from_the_sensors(device: gy.Plant) -> None:
    """Estimator and predictor in their chain, behind a closed loop: between ideal and nothing."""
    duration = 300.0
    waves = gy.realise(device, gy.SeaState(), SEED, duration)
    run, _ = run_law(device, gy.law("coupling"), waves.blended(50.0), Settings(sensors=gy.Sensors(), blend=0.0))
    errors = gy.Sensors().arrays(len(run.controls), SEED)
    measured = run.states[:-1, list(ROWS)] + errors.error
    truth = waves.blended(50.0).moments[:, ::2]
    estimator = MomentEstimator.design(device)
    sensed = Predictor.design(device, estimator=estimator)
    result = replay(sensed, LEADS, estimator, measured, run.commands)
    error = relative_error(sensed, LEADS, result.ahead, truth, 100.0)
    ideal = Predictor.design(device)
    best = relative_error(ideal, LEADS, replay_moments(ideal, LEADS, truth), truth, 100.0)
    assert np.all(best[:, :3] < error[:, :3]) and np.all(error[:, :3] < [[0.12, 0.35, 0.75], [0.07, 0.2, 0.55]])
    truth = truth.T[1000 : len(result.now)]
    smoothed, filtered = (np.mean((v[1000:] - truth) ** 2, axis=0) for v in (result.now, result.me_hat))
    assert np.all(smoothed < 0.6 * filtered), "the spectrum of the sea and the known noise take most of the error away"


def test_a_value_that_is_no_number_does_no_lasting_harm(device: gy.Plant) -> None:
    predictor = Predictor.design(device)
    values = moments(device, gy.SeaState(), 60.0)
    broken = values.copy()
    broken[0, 200], broken[1, 300] = math.nan, math.inf
    out, other = np.empty((2, 80)), np.empty((2, 80))
    predict(predictor, fed(predictor, values), out)
    predict(predictor, fed(predictor, broken), other)
    assert np.all(np.isfinite(other)) and np.abs(other - out).max() < 0.1 * np.abs(out).max()


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


@pytest.mark.slow
def test_study_writes_table_and_figure(tmp_path: Path) -> None:
    text = forecast_report(tmp_path, [SEED], duration=260.0)
    assert {path.name for path in tmp_path.iterdir()} == {"forecast.csv", "forecast.json", "forecast.png"}
    with (tmp_path / "forecast.csv").open(encoding="utf-8") as stream:
        rows = {(row["sea"], row["source"], row["moment"]): row for row in csv.DictReader(stream)}
    assert len(rows) == len(SEAS) * len(SOURCES) * 2
    for moment in ("Me1", "Me3"):
        one, two = (float(rows["gamma 5", source, moment]["error_at_1_s"]) for source in ("true moments", "sensors"))
        assert 0.0 < one < two < 0.6
    assert rows["gamma 5, peak 2.8 to 3.5 rad/s", "sensors, sea known", "Me1"]["error_at_1_s"] == "nan"
    assert "gamma 50" in text and "nan" not in text


def test_study_refuses_what_leaves_nothing_to_judge(tmp_path: Path) -> None:
    for seeds, duration, field in (([], 500.0, "forecast.seeds"), ([SEED], 100.0, "forecast.duration")):
        with pytest.raises(gy.InputError) as caught:
            forecast_report(tmp_path, seeds, duration)
        assert caught.value.field == field


# --- the probe -------------------------------------------------------------------------------------------------------


def told(predictor: Predictor, probe: Probe, samples: int) -> Array:
    """Forecasts (samples, 2, 80) of a probe."""
    state, out = predictor.init(), np.empty((samples, 2, 80))
    for sample in range(samples):
        foresee(predictor, probe, state, sample, out[sample])
    return out


def test_probe_over_the_horizon_is_an_oracle(device: gy.Plant) -> None:
    predictor, values = known(device), moments(device, gy.SeaState(), 40.0)
    out = told(predictor, Probe.design(predictor, values, 0.1, math.inf), 350)
    for sample in (0, 100, 320):
        np.testing.assert_array_equal(out[sample], values[:, sample + 1 : sample + 81])
    np.testing.assert_array_equal(out[349][:, 51:], 0.0)  # beyond the record


def test_probe_is_the_predictor_moved_by_its_lead(device: gy.Plant) -> None:
    predictor, values = Predictor.design(device), moments(device, gy.SeaState(), 60.0)
    now = told(predictor, Probe.design(predictor, values, 0.1, 0.0), 540)
    ahead = told(predictor, Probe.design(predictor, values, 0.1, 1.5), 540)
    for sample in (100, 350, 500):
        np.testing.assert_array_equal(ahead[sample][:, :15], values[:, sample + 1 : sample + 16])
        np.testing.assert_array_equal(ahead[sample][:, 15:], now[sample + 15][:, :65])


def test_probe_degrades_with_lead_and_noise(device: gy.Plant) -> None:
    values = moments(device, gy.SeaState(), 300.0)
    predictor = known(device)
    error = []
    for lead in (0.0, 1.0, 3.0, 6.0):
        out = told(predictor, Probe.design(predictor, values, 0.1, lead), 2900)
        error.append(relative_error(predictor, LEADS, out[:, :, [round(10 * t) - 1 for t in LEADS]], values, 12.0))
    assert all(np.all(better <= worse + 1e-12) for worse, better in pairwise(error))
    noisy = Probe.design(predictor, values, 0.1, 1.0, noise=0.1, seed=1)
    deviation = (noisy.told - values).std(axis=1) / values.std(axis=1)
    np.testing.assert_allclose(deviation, 0.1, rtol=0.06)
    np.testing.assert_array_equal(noisy.told, Probe.design(predictor, values, 0.1, 1.0, noise=0.1, seed=1).told)
    assert not np.array_equal(noisy.told, Probe.design(predictor, values, 0.1, 1.0, noise=0.1, seed=2).told)
    out = told(predictor, noisy, 2900)
    worse = relative_error(predictor, LEADS, out[:, :, [round(10 * t) - 1 for t in LEADS]], values, 12.0)
    assert np.all(worse[:, :3] > error[1][:, :3])


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


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ((np.zeros((2, 9)), 0.03), "probe.dt"),
        ((np.zeros((3, 9)), 0.1), "probe.moments"),
        ((np.zeros((2, 9)), 0.1, -1.0), "probe.lead"),
        ((np.zeros((2, 9)), 0.1, 1.0, -0.1), "probe.noise"),
        ((np.zeros((2, 9)), 0.1, 1.0, 0.1, -3), "run.seeds"),
    ],
)
def test_bad_probe_names_field_and_mend(device: gy.Plant, arguments: tuple[Any, ...], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        Probe.design(known(device), *arguments)
    assert caught.value.field == field and caught.value.mend


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
