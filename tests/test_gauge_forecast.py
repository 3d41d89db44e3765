"""Forecast from a gauge and the sensors: against realisations, dense linear algebra and single waves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.controllers.nmpc.foresight import Foresight
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.waves.estimation import MomentEstimator, Predictor, predict
from gyroctl.waves.estimation.gauge_forecast import find_place, predict_from_gauge
from gyroctl.waves.estimation.gauge_readings import GaugeForecast, GaugeState, place_readings, prepare
from gyroctl.waves.estimation.predictor import PredictorState, take
from gyroctl.waves.gauge import Gauge, Readings, elevation_up_wave, error, measured

Array = NDArray[np.float64]
SEA = gy.SeaState()
CLEAN = Gauge(gauge_noise=0.0, drift=0.0, misplaced=0.0, placing=0.0)
STEP = 0.1


def parts(plant: gy.Plant) -> tuple[MomentEstimator, Predictor]:
    estimator = MomentEstimator.design(plant)
    return estimator, Predictor.design(plant, horizon=4.0, sea=SEA, estimator=estimator, forgetting=None)


def made(plant: gy.Plant, gauge: Gauge) -> tuple[GaugeForecast, GaugeState, Array]:
    """Forecast in a known sea, prepared, and the spectrum of the sea."""
    estimator, predictor = parts(plant)
    c = GaugeForecast.design(plant, predictor, estimator, gauge)
    state, spectrum = c.init(), SEA.spectrum(predictor.learner.omega)
    prepare(c, spectrum, state)
    return c, state, spectrum


def told(c: GaugeForecast, state: GaugeState, values: Array, history: Array, steps: int = 0) -> tuple[Array, Array]:
    """Moments of now (2,) and ahead (2, 40), the newest reading and moments last."""
    now, out = np.zeros(2), np.zeros((2, 40))
    assert predict_from_gauge(c, state, values, values.size - 1, steps, history, history.shape[0], now, out)
    return now, out


def deafened(c: GaugeForecast) -> GaugeForecast:
    """The same whose moments at the float tell nothing."""
    return c._replace(waves=c.waves._replace(seen=np.zeros_like(c.waves.seen)))


def rows_of(c: GaugeForecast, state: GaugeState) -> Array:
    """Readings (n, 2 b) of unit amplitudes. [-]"""
    rows = np.empty((c.own.size, state.root.size))
    place_readings(c, state, rows)
    return rows / state.root


# --- covariances against realisations -------------------------------------------------------------------------------


def test_covariances_are_those_of_realisations(device: gy.Plant) -> None:
    """Readings with one another and with the moments ahead, on the mean over time and seeds."""
    gauge = CLEAN._replace(distance=6.0)
    c, state, spectrum = made(device, gauge)
    scale, rows = state.root**2, rows_of(c, state)
    readings = rows * scale @ rows.T
    lags = c.own + spectrum @ c.doubtful
    found, across, ahead = np.zeros(4), np.zeros((2, 3)), (5, 20, 38)
    ages = (0, 4, 13, 60)
    for seed in range(100000, 100006):
        waves = gy.realise(device, SEA, seed, 2000.0, STEP)
        level = elevation_up_wave(waves, device, gauge.distance)
        n = level.size
        found += [np.mean(level[age:] * level[: n - age]) / 6.0 for age in ages]
        across += [[np.mean(waves.moments[j, lead:] * level[: n - lead]) / 6.0 for lead in ahead] for j in range(2)]
    expected = [readings[0, age] + lags[age] for age in ages]
    np.testing.assert_allclose(found, expected, atol=0.03 * expected[0])
    size = np.sqrt(np.sum(c.waves.ahead[:, :, 0] ** 2 * scale, axis=1) * expected[0])
    for j in range(2):
        wanted = [c.waves.ahead[j, :, lead] * scale @ rows[0] for lead in ahead]
        np.testing.assert_allclose(across[j], wanted, atol=0.04 * size[j])
        assert max(np.abs(wanted)) > 0.3 * size[j]


def test_noise_and_drift_are_reckoned_with_as_they_are_made(device: gy.Plant) -> None:
    gauge = CLEAN._replace(sampling=0.2, gauge_noise=0.004, drift=0.01, drift_time=5.0)
    own = made(device, gauge)[0].own
    errors = np.stack([error(gauge, 4000, seed) for seed in range(40)])
    for lag in (0, 1, 5, 25, 50):
        found = np.mean(errors[:, : 4000 - lag] * errors[:, lag:])
        assert own[lag] == pytest.approx(found, abs=0.05 * 0.01**2)


def test_doubt_about_the_place_turns_waves_into_noise_of_their_spectrum(device: gy.Plant) -> None:
    """Wherever the gauge stands it sees the same spectrum; on the mean over the places a part of each wave is left."""
    spread = 0.2
    (sure, state, spectrum), (doubting, other, _) = (made(device, CLEAN._replace(placing=s)) for s in (0.0, spread))
    scale, rows, left = state.root**2, rows_of(sure, state), rows_of(doubting, other)
    for age in (0, 7, 30):
        whole = rows[0] * scale @ rows[age] + (spectrum @ sure.doubtful)[age]
        parted = left[0] * scale @ left[age] + (spectrum @ doubting.doubtful)[age]
        # the noise is integrated over a bin, the waves stand at its centre: alike to the width of a bin
        assert parted == pytest.approx(whole, abs=0.02 * spectrum.sum() * 0.1)
    at, weight = np.polynomial.hermite_e.hermegauss(60)
    weight /= weight.sum()
    k = wavenumber(sure.omega, device.depth)
    for age in (0, 11):
        angle = k * 10.0 - sure.omega * 0.1 * age
        mean = np.cos(angle[:, None] + k[:, None] * spread * at) @ weight
        np.testing.assert_allclose(left[age, : k.size], mean, atol=1e-9)


# --- the estimate against dense linear algebra ----------------------------------------------------------------------


@pytest.mark.parametrize(("sampling", "steps"), [(0.1, 0), (0.3, 0), (0.3, 2), (0.05, 0)])
@pytest.mark.parametrize("variant", ["corrected", "realistic"])
def test_estimate_is_the_conditional_mean(variant: str, sampling: float, steps: int) -> None:
    plant = gy.zhang2017(variant)
    gauge = Gauge(distance=7.0, sampling=sampling, gauge_noise=0.01, drift=0.02, placing=0.1)
    c, state, spectrum = made(plant, gauge)
    n, twice = c.own.size, state.root.size
    size, bins = 2 * c.waves.ages.size, twice // 2
    source = np.random.default_rng(3)
    values = 0.07 * source.standard_normal(n)
    history = source.standard_normal((c.waves.ages[-1] + 1, 3)) * [30.0, 60.0, 0.1]
    rows = np.zeros((n + size, twice))
    rows[:n] = rows_of(c, state)
    noise = np.zeros((n + size, n + size))
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    noise[:n, :n] = (c.own + spectrum @ c.doubtful)[lag]
    given = np.concatenate([values[::-1], np.zeros(size)])
    omega = c.omega
    for a, age in enumerate(c.waves.ages):
        seen = history[history.shape[0] - 1 - age]
        where = c.waves.k * c.waves.reach * seen[2]
        turn = np.exp(1j * (omega * (STEP * (steps - age)) - where))
        for j in range(2):
            wave = (c.waves.seen[2 * j] + 1j * c.waves.seen[2 * j + 1]) * turn
            rows[n + 2 * a + j] = np.concatenate([wave.real, -wave.imag])
            given[n + 2 * a + j] = seen[j]
    noise[n:, n:] = np.diag(np.tile(c.waves.misfit, size // 2))
    prior = np.tile(spectrum[:bins], 2) * 0.1
    follows = np.linalg.solve(rows * prior @ rows.T + noise, rows * prior).T
    amplitudes, unknown = follows @ given, np.diag(prior) - follows @ (rows * prior)
    now, out = told(c, state, values, history, steps)
    turn = np.exp(1j * STEP * np.outer(np.arange(41) + steps, omega))
    he = plant.excitation(omega, 0.0)
    for j in range(2):
        wave = np.hstack([(he[j] * turn).real, -(he[j] * turn).imag])
        wanted = wave @ amplitudes
        variance = np.einsum("lb,bc,lc->l", wave, unknown, wave)
        np.testing.assert_allclose(state.waves.variance[j, :41], variance, rtol=1e-5)
        np.testing.assert_allclose(out[j], wanted[1:], atol=1e-6 * np.abs(wanted).max())
        assert now[j] == pytest.approx(wanted[0], abs=1e-6 * np.abs(wanted).max())


@pytest.mark.parametrize("omega", [2.55, 3.15, 4.55])
@pytest.mark.parametrize("distance", [5.0, 10.0])
def test_single_wave_at_the_gauge_alone_arrives_with_its_phase(device: gy.Plant, omega: float, distance: float) -> None:
    """Moments at the float that tell nothing: the forecast is He a exp(i w t), k d after the wave was measured."""
    c, state, _ = made(device, CLEAN._replace(distance=distance, gauge_noise=1e-3))
    deaf = deafened(c)
    waves = gy.realise(device, gy.Regular(0.2, omega), 1, 60.0)
    values = elevation_up_wave(waves, device, distance)[::2]
    history = np.zeros((c.waves.ages[-1] + 1, 3))
    lead = 10 if distance < 8.0 else 25
    at = values.size - 1
    _, out = told(deaf, state, values, history)
    expected = np.real(device.excitation(np.array([omega]), 0.0)[:, 0] * 0.1 * np.exp(1j * omega * STEP * (at + lead)))
    size = np.abs(device.excitation(np.array([omega]), 0.0)[:, 0]) * 0.1
    np.testing.assert_allclose(out[:, lead - 1], expected, atol=0.05 * size.max())


# --- drift, misplacement, missing readings --------------------------------------------------------------------------


def history_of(plant: gy.Plant, waves: gy.WaveRealisation, at: int, past: int) -> Array:
    """True moments of the last samples up to `at`, as if observed at rest."""
    moments = waves.moments[:, ::2][:, at + 1 - past : at + 1]
    return np.ascontiguousarray(np.vstack([moments, np.zeros(past)]).T)


def error_of(plant: gy.Plant, gauge: Gauge, offset: float = 0.0, deaf: bool = False) -> Array:
    """Mean square error (2,) at 2 s of forecasts in one realisation, over the variance."""
    c, state, _ = made(plant, gauge)
    c = deafened(c) if deaf else c
    waves = gy.realise(plant, SEA, 100000, 120.0)
    values, past = measured(gauge, waves, plant) + offset, int(c.waves.ages[-1]) + 1
    truth = waves.moments[:, ::2]
    off = []
    for at in range(400, 1150, 5):
        now, out = np.zeros(2), np.zeros((2, 40))
        assert predict_from_gauge(c, state, values, at, 0, history_of(plant, waves, at, past), past, now, out)
        off.append(out[:, 19] - truth[:, at + 20])
    return np.asarray(np.mean(np.square(off), axis=0) / np.mean(truth**2, axis=1))


def test_reckoned_drift_is_kept_out_of_the_waves(device: gy.Plant) -> None:
    """A mean level that is off by half a standard deviation of the waves."""
    base = CLEAN._replace(gauge_noise=2e-3)
    naive, quiet = error_of(device, base, 0.035), error_of(device, base)
    knowing = error_of(device, base._replace(drift=0.05, drift_time=1e4), 0.035)
    assert np.all(knowing < 2.0 * quiet + 0.01)
    assert np.all(naive > 1.5 * knowing)


def test_misplacement_costs_and_doubt_about_the_place_saves(device: gy.Plant) -> None:
    right = error_of(device, CLEAN._replace(gauge_noise=3e-3))
    wrong = error_of(device, CLEAN._replace(gauge_noise=3e-3, misplaced=0.3))
    doubting = error_of(device, CLEAN._replace(gauge_noise=3e-3, misplaced=0.3, placing=0.3))
    assert np.all(wrong > 5.0 * right)
    assert np.all(doubting < 0.8 * wrong)


def test_gauge_farther_than_waves_come_in_the_lead_tells_more(device: gy.Plant) -> None:
    """At 2 s: waves of the peak need more than that over 5 m, less over 1 m."""
    near, far = error_of(device, CLEAN._replace(distance=1.0)), error_of(device, CLEAN._replace(distance=5.0))
    assert np.all(far < 0.3 * near)


def test_gauge_and_float_together_know_more_than_the_gauge_alone(device: gy.Plant) -> None:
    poor = CLEAN._replace(distance=4.0, gauge_noise=0.03)
    both, alone = error_of(device, poor), error_of(device, poor, deaf=True)
    assert both[0] < alone[0] and both[1] < 0.7 * alone[1]


def fed(foresight: Foresight, waves: gy.WaveRealisation, samples: int) -> tuple[PredictorState, Any]:
    memory, moments = foresight.predictor.init(), waves.moments[:, ::2]
    assert foresight.gauge is not None
    for at in range(samples):
        take(foresight.predictor, memory, moments[0, at], moments[1, at], 0.0)
    return memory, foresight.gauge.init()


@pytest.mark.parametrize("off", [-0.4, 0.25])
def test_gauge_that_is_found_elsewhere_is_as_one_that_was_known_to_stand_there(device: gy.Plant, off: float) -> None:
    gauge, past = Gauge(6.0, misplaced=off), int(parts(device)[1].learner.ages[-1]) + 1
    (c, state, spectrum), (known, sure, _) = made(device, gauge), made(device, gauge._replace(distance=6.0 + off))
    state.place[0] = off
    prepare(c, spectrum, state)
    waves = gy.realise(device, SEA, 100000, 60.0)
    values, history = measured(gauge, waves, device)[:551], history_of(device, waves, 550, past)
    for one, other in zip(told(c, state, values, history), told(known, sure, values, history), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6 * np.abs(other).max())


@pytest.mark.parametrize(("misplaced", "heading"), [(0.3, 0.0), (-0.4, 0.0), (0.0, 20.0), (9.0, 0.0)])
def test_place_of_the_gauge_is_found(device: gy.Plant, misplaced: float, heading: float) -> None:
    """From the moments of the float; a gauge at an angle stands nearer by d (1 - cos), and none is looked for afar."""
    c, state, spectrum = made(device, Gauge())
    waves = gy.realise(device, SEA, 100000, 300.0)
    values = measured(Gauge(misplaced=misplaced, heading=heading), waves, device)
    past = int(c.waves.ages[-1]) + 1
    for at in range(300, 3000, 50):
        find_place(c, state, values, at, 0, history_of(device, waves, at, past), past)
        prepare(c, spectrum, state)
        assert abs(state.place[0]) <= 0.3 * 10.0
    stands = (10.0 + misplaced) * math.cos(math.radians(heading)) - 10.0
    if misplaced < 3.0:
        assert state.place[0] == pytest.approx(stands, abs=0.03)


def test_place_is_not_left_without_a_reason(device: gy.Plant) -> None:
    """Moments that tell nothing: the gauge is taken back to where it is believed."""
    c, state, _ = made(device, Gauge())
    state.place[0] = 0.2
    values = measured(Gauge(), gy.realise(device, SEA, 100000, 60.0), device)
    for _ in range(200):
        find_place(deafened(c), state, values, 500, 0, np.zeros((int(c.waves.ages[-1]) + 1, 3)), 500)
    assert abs(state.place[0]) < 0.02


def test_readings_that_have_ended_are_not_gone_by(device: gy.Plant) -> None:
    c, state, _ = made(device, Gauge())
    now, out, past = np.zeros(2), np.full((2, 40), 7.0), int(c.waves.ages[-1]) + 1
    assert not predict_from_gauge(c, state, np.zeros(300), 299, 5, np.zeros((past, 3)), past, now, out)
    assert np.all(out == 7.0)


@pytest.mark.parametrize("lost", ["a reading", "the beginning", "none"])
def test_where_readings_are_missing_the_sensors_tell(device: gy.Plant, lost: str) -> None:
    gauge, estimator = Gauge(), parts(device)[0]
    waves = gy.realise(device, SEA, 100000, 40.0)
    values = measured(gauge, waves, device)
    samples = 100 if lost == "the beginning" else 300
    if lost == "a reading":
        values[samples - 30] = np.nan
    foresight = Foresight.gauged(device, estimator, 4.0, gauge, Readings(values, gauge.sampling, 40.0))
    memory, state = fed(foresight, waves, samples)
    ahead, alone = np.empty((2, 40)), np.empty((2, 40))
    assert foresight.read((samples - 1) * STEP, False, memory, state, ahead) == (lost == "none")
    predict(foresight.predictor, memory, alone)
    assert np.array_equal(ahead, alone) == (lost != "none")


def test_newest_reading_counts_and_none_after_it(device: gy.Plant) -> None:
    gauge, estimator = Gauge(sampling=0.3), parts(device)[0]
    waves = gy.realise(device, SEA, 100000, 40.0)
    values, at = measured(gauge, waves, device), 299  # 29.9 s: the reading of 29.7 s is the newest
    ahead = []
    for changed in (None, 100, 99):
        own = values.copy()
        if changed is not None:
            own[changed] += 0.05
        foresight = Foresight.gauged(device, estimator, 4.0, gauge, Readings(own, gauge.sampling, 40.0))
        memory, state = fed(foresight, waves, at + 1)
        ahead.append(np.empty((2, 40)))
        foresight.read(at * STEP, False, memory, state, ahead[-1])
    np.testing.assert_array_equal(ahead[0], ahead[1])
    assert np.abs(ahead[0] - ahead[2]).max() > 0.1


def test_forecast_goes_by_the_spectrum_once_it_is_learnt(device: gy.Plant) -> None:
    gauge, estimator = Gauge(), parts(device)[0]
    waves = gy.realise(device, SEA, 100000, 40.0)
    readings = Readings(measured(gauge, waves, device), gauge.sampling, 40.0)
    foresight = Foresight.gauged(device, estimator, 4.0, gauge, readings)
    memory, state = fed(foresight, waves, 300)
    out = [np.empty((2, 40)) for _ in range(4)]
    for _ in range(2):  # the misfit of the newest value is learnt at the first
        foresight.read(29.9, False, memory, state, out[0])
    memory.memory.spectrum[:] = gy.SeaState(wp=2.5).spectrum(foresight.predictor.learner.omega)
    foresight.read(29.9, False, memory, state, out[1])
    np.testing.assert_array_equal(out[0], out[1])
    foresight.read(29.9, True, memory, state, out[2])
    assert foresight.gauge is not None
    fresh = foresight.gauge.init()
    fresh.place[:] = state.place
    fresh.waves.misfit[:] = state.waves.misfit
    foresight.read(29.9, False, memory, fresh, out[3])
    np.testing.assert_array_equal(out[2], out[3])
    assert not np.array_equal(out[1], out[2])


def test_what_the_gauge_tells_follows_the_spectrum_that_is_learnt(device: gy.Plant) -> None:
    estimator, predictor = parts(device)
    c = GaugeForecast.design(device, predictor, estimator, Gauge())
    state, other = c.init(), c.init()
    prepare(c, SEA.spectrum(predictor.learner.omega), state)
    prepare(c, gy.SeaState(wp=2.6).spectrum(predictor.learner.omega), other)
    assert not np.allclose(state.told, other.told)
    prepare(c, SEA.spectrum(predictor.learner.omega), other)
    np.testing.assert_array_equal(state.told, other.told)
    np.testing.assert_array_equal(state.precision, other.precision)


def test_far_gauge_is_looked_back_to_for_longer(device: gy.Plant) -> None:
    estimator, predictor = parts(device)
    near, far = (
        GaugeForecast.design(device, predictor, estimator, Gauge(distance)).own.size for distance in (5.0, 20.0)
    )
    assert near == round(12.0 / 0.1)
    assert far * 0.1 > 20.0 / 0.9  # waves of 5.6 rad/s need that long
