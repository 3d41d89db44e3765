"""Skill of the forecast by lead, sea, noise and sensors; its study; the probe, a forecast of a known quality."""

from __future__ import annotations

import csv
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from wave_predictors import LEADS, SEED, known, moments

import gyroctl as gy
from gyroctl.controllers.nmpc.foresight import Foresight
from gyroctl.harness.run import Settings, run_law
from gyroctl.plant.measurement import ROWS
from gyroctl.studies.forecast import forecast_report
from gyroctl.studies.forecast.report import REAL_WATER, SEAS, _halves
from gyroctl.studies.forecast.skill import SOURCES, Skill
from gyroctl.waves.estimation import MomentEstimator, Predictor, Probe, foresee, relative_error, replay, replay_moments
from gyroctl.waves.estimation.probe import floor_of
from gyroctl.waves.window import Shutter

Array = NDArray[np.float64]


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


@pytest.mark.slow
def test_study_writes_table_and_figure(tmp_path: Path) -> None:
    text = forecast_report(tmp_path, [SEED], duration=260.0)
    figures = {f"{stem}.{kind}" for stem in ("forecast", "forecast_real_water") for kind in ("png", "svg", "pdf")}
    assert {path.name for path in tmp_path.iterdir()} == {"forecast.csv", "forecast.json"} | figures
    with (tmp_path / "forecast.csv").open(encoding="utf-8") as stream:
        rows = {(row["sea"], row["source"], row["moment"]): row for row in csv.DictReader(stream)}
    assert len(rows) == (len(SEAS) + len(REAL_WATER)) * len(SOURCES) * 2
    for moment in ("Me1", "Me3"):
        one, two = (float(rows["gamma 5", source, moment]["error_at_1_s"]) for source in ("true moments", "sensors"))
        assert 0.0 < one < two < 0.6
        plain, knowing = (float(rows[case, "sensors", moment]["error_at_1_s"]) for case in REAL_WATER)
        assert knowing < 0.6 < plain, "a design model that knows the water forecasts; one that does not, does not"
    assert rows["gamma 5, peak 2.8 to 3.5 rad/s", "sensors, sea known", "Me1"]["error_at_1_s"] == "nan"
    assert "gamma 50" in text and "nan" not in text


def test_study_refuses_what_leaves_nothing_to_judge(tmp_path: Path) -> None:
    for seeds, duration, field in (([], 500.0, "forecast.seeds"), ([SEED], 100.0, "forecast.duration")):
        with pytest.raises(gy.InputError) as caught:
            forecast_report(tmp_path, seeds, duration)
        assert caught.value.field == field


def test_interval_of_the_error_is_students() -> None:
    """Two realisations whose errors differ by 2: half the width is the 97.5 % quantile of one degree of freedom."""
    runs = np.zeros((2, len(SOURCES), 2, 3))
    runs[:, SOURCES.index("sensors"), :, 1] = [[1.0, 5.0], [3.0, 5.0]]
    halves = _halves(Skill(np.zeros(0), np.zeros(0), np.zeros(0), runs))
    np.testing.assert_allclose(halves, [[0.0, 12.7062, 0.0], [0.0, 0.0, 0.0]], rtol=1e-5)
    alone = _halves(Skill(np.zeros(0), np.zeros(0), np.zeros(0), runs[:1]))
    assert np.all(np.isnan(alone)), "one realisation says nothing of its spread"


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


def covariance_at(predictor: Predictor, plant: gy.Plant, times: Array, others: Array) -> Array:
    """E Me_i(t) Me_j(s) of moments at two sets of instants, as rows and columns: Me1, Me3 of each."""
    S, omega, width = predictor.learner.prior, predictor.learner.omega, predictor.learner.width
    he, lag = plant.excitation(omega, 0.0), np.subtract.outer(times, others)
    wave = np.exp(1j * lag[..., None] * omega) * np.sinc(0.5 / np.pi * width * lag)[..., None] * S * width
    blocks = np.real(np.einsum("ib,jb,tsb->tisj", he, he.conj(), wave))
    return np.asarray(blocks.reshape(2 * times.size, 2 * others.size))


@pytest.mark.parametrize("lead", [0.0, 1.0, math.inf])
def test_noisy_probe_tells_the_mean_of_the_moments_given_what_it_told(device: gy.Plant, lead: float) -> None:
    """Now, within the lead and beyond it, against dense Gaussian conditioning with the probe's own noise."""
    values, noise = moments(device, gy.SeaState(), 40.0), 0.2
    floor = floor_of(values.std(axis=1), noise)
    assert floor is not None
    np.testing.assert_allclose(np.square(floor), 0.3**2 + np.square(noise * values.std(axis=1)), rtol=1e-12)
    predictor = known(device, floor=floor, horizon=4.0)
    probe, sample = Probe.design(predictor, values, 0.1, lead, noise, seed=1), 250
    state, out = predictor.init(), np.empty((2, 40))
    for at in range(sample + 1):
        foresee(predictor, probe, state, at, out)
    seen = sample + probe.lead - predictor.learner.ages
    G = covariance_at(predictor, device, 0.1 * seen, 0.1 * seen) + np.diag(np.tile(np.square(floor), seen.size))
    g = covariance_at(predictor, device, 0.1 * np.arange(sample, sample + 41), 0.1 * seen)
    wanted = (g @ np.linalg.solve(G, probe.told[:, seen].T.ravel())).reshape(41, 2).T
    found = np.column_stack([state.now, out])
    np.testing.assert_allclose(found, wanted, atol=1e-6 * np.abs(wanted).max())


def test_law_reckons_with_the_noise_of_its_probe(device: gy.Plant) -> None:
    """Told of the whole realisation or of a window on it, in each moment; where there is no noise nothing changes."""
    estimator, waves = MomentEstimator.design(device), gy.realise(device, gy.SeaState(), 100000, 30.0)
    window, plain = Shutter(waves, 1.0).window, Predictor.design(device, horizon=4.0).learner
    for seen in (waves, window):
        noisy, exact = (Foresight.design(device, estimator, 4.0, 1.0, noise, seen) for noise in (0.2, 0.0))
        added = noisy.predictor.learner.noise[[0, 3], 0] - plain.noise[[0, 3], 0]
        np.testing.assert_allclose(added, np.square(0.2 * waves.moments.std(axis=1)), rtol=1e-9)
        np.testing.assert_array_equal(exact.predictor.learner.noise, plain.noise)
        assert noisy.probe is not None and exact.probe is not None and noisy.probe.errs and not exact.probe.errs


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
