"""A gauge up-wave: what it measures, against closed forms of linear waves, and that nothing is read before its time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.signal import hilbert

import gyroctl as gy
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.harness.sight import Sight, informed, sight
from gyroctl.waves.estimation.gauge_forecast import predict_from_gauge
from gyroctl.waves.estimation.gauge_readings import prepare
from gyroctl.waves.gauge import Gauge, GaugeShutter, elevation_up_wave, error, measured

Array = NDArray[np.float64]
SETTINGS = Settings(blend=10.0)


def number_of(omega: float, depth: float) -> float:
    """Wave number from w^2 = g k tanh k h, by bisection. [rad/m]"""
    return float(brentq(lambda k: 9.81 * k * math.tanh(k * depth) - omega**2, 1e-6, 100.0, xtol=1e-14))


# --- what is measured -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", [0.0, 40.0])
@pytest.mark.parametrize("distance", [0.0, 5.0, 20.0])
def test_regular_wave_is_ahead_by_k_times_the_distance(device: gy.Plant, distance: float, heading: float) -> None:
    sea = gy.Regular(0.2, 3.0, heading)
    waves = gy.realise(device, sea, 1, 40.0)
    phase = number_of(3.0, device.depth) * distance * math.cos(math.radians(heading - 10.0))
    expected = 0.1 * np.cos(3.0 * waves.time + phase)
    np.testing.assert_allclose(elevation_up_wave(waves, device, distance, 10.0), expected, atol=1e-10)


def test_regular_start_of_a_run_is_ahead_as_well(device: gy.Plant) -> None:
    sea = gy.SeaState()
    waves = gy.realise(device, sea, 100000, 60.0).blended(50.0)
    level = elevation_up_wave(waves, device, 8.0)
    crest = sea.hs / (2.0 * math.sqrt(2.0)) * math.cos(number_of(sea.wp, device.depth) * 8.0)
    assert level[0] == pytest.approx(crest, abs=1e-12)
    whole = elevation_up_wave(replace(waves, blend=0.0), device, 8.0)
    np.testing.assert_array_equal(level[waves.time >= 50.0], whole[waves.time >= 50.0])


def test_elevation_at_no_distance_is_that_at_the_float(device: gy.Plant) -> None:
    waves = lead_in(gy.realise(device, gy.SeaState(), 100000, 60.0), SETTINGS)
    np.testing.assert_allclose(elevation_up_wave(waves, device, 0.0), waves.elevation, atol=1e-12)


def test_groups_arrive_with_the_group_velocity(device: gy.Plant) -> None:
    """Two near waves: the envelope that passes the gauge reaches the float d / c_g later."""
    low, high, distance = 2.9, 3.1, 15.0
    waves = gy.realise(device, gy.Bichromatic((0.1, 0.1), (low, high)), 3, 400.0)
    here, there = (np.abs(hilbert(level)) for level in (waves.elevation, elevation_up_wave(waves, device, distance)))
    lags = np.arange(400)  # the groups are 628 steps apart
    unlike = [np.mean((here[1000 + lag : 6500 + lag] - there[1000:6500]) ** 2) for lag in lags]
    speed = (high - low) / (number_of(high, device.depth) - number_of(low, device.depth))
    assert waves.dt * lags[int(np.argmin(unlike))] == pytest.approx(distance / speed, abs=0.06)


def test_misplaced_gauge_stands_elsewhere(device: gy.Plant) -> None:
    waves = gy.realise(device, gy.SeaState(), 100000, 60.0)
    off = measured(Gauge(10.0, misplaced=0.4, gauge_noise=0.0, drift=0.0), waves, device)
    np.testing.assert_array_equal(off, elevation_up_wave(waves, device, 10.4)[::2])


def test_error_is_white_noise_and_a_drift_that_forgets() -> None:
    gauge = Gauge(sampling=0.2, gauge_noise=0.004, drift=0.01, drift_time=10.0)
    made = np.stack([error(gauge, 4000, seed) for seed in range(40)])
    for lag in (0, 1, 10, 50, 100):
        found = np.mean(made[:, : 4000 - lag] * made[:, lag:])
        expected = 0.01**2 * math.exp(-0.2 * lag / 10.0) + (0.004**2 if lag == 0 else 0.0)
        assert found == pytest.approx(expected, abs=0.06 * 0.01**2)
    np.testing.assert_array_equal(error(gauge, 100, 7), error(gauge, 4000, 7)[:100])
    assert not np.array_equal(error(gauge, 100, 7), error(gauge, 100, 8))


def test_gauge_of_moments_alone_is_refused(device: gy.Plant) -> None:
    waves = replace(gy.realise(device, gy.SeaState(), 1, 20.0), synthesis=None)
    with pytest.raises(gy.InputError, match="waves"):
        measured(Gauge(), waves, device)


# --- nothing before its time ----------------------------------------------------------------------------------------


def test_readings_hold_what_was_measured_and_nothing_beyond() -> None:
    record = np.arange(50.0)
    shutter = GaugeShutter(record, 0.2, 10.0)
    for t in (0.0, 0.1, 3.05, 2.0, 9.9, 30.0):
        shutter.open(t)
        latest = 3.05 if t == 2.0 else t
        open_ = 0.2 * np.arange(50) <= latest + 1e-6
        np.testing.assert_array_equal(shutter.readings.values[open_], record[open_])
        assert np.isnan(shutter.readings.values[~open_]).all()
    with pytest.raises(ValueError, match="read-only"):
        shutter.readings.values[0] = 1.0
    assert set(vars(shutter.readings)) == {"values", "sampling", "duration"}


def test_law_is_told_no_reading_before_the_run(device: gy.Plant) -> None:
    waves = gy.realise(device, gy.SeaState(), 1, 20.0)
    law: Any
    law, shutter = informed(gy.law("nmpc", information="gauge"), waves, device)
    assert np.isfinite(law.seen.values[0]) and np.isnan(law.seen.values[1:]).all()
    assert shutter is not None
    shutter.open(5.0)
    assert np.isfinite(law.seen.values[:51]).all() and np.isnan(law.seen.values[51:]).all()


@dataclass(frozen=True)
class TwoFutures:
    """Waves of one seed up to an instant and of another one after it, at every place."""

    one: Any
    other: int
    known: NDArray[np.bool_]

    @property
    def waves(self) -> Any:
        return self.one.waves

    def superposed(self, of_wave: Any, seed: int, out: Array) -> None:
        after = np.empty_like(out)
        self.one.superposed(of_wave, seed, out)
        self.one.superposed(of_wave, self.other, after)
        out[:, ~self.known] = after[:, ~self.known]


@pytest.mark.parametrize("sampling", [0.1, 0.3])
def test_commands_do_not_depend_on_what_the_gauge_sees_later(device: gy.Plant, sampling: float) -> None:
    """Another future at the gauge alone: the device feels nothing of it, so that only a look ahead could tell."""
    waves = lead_in(gy.realise(device, gy.SeaState(), 100000, 24.0), SETTINGS)
    assert waves.synthesis is not None
    until = 20.0
    changed: Any = TwoFutures(waves.synthesis, 100001, waves.time <= until)
    law = gy.law("nmpc", information="gauge", distance=10.0, sampling=sampling, horizon=2.0)
    first, _ = run_law(device, law, waves, SETTINGS)
    second, _ = run_law(device, law, replace(waves, synthesis=changed), SETTINGS)
    differ = np.flatnonzero(np.any(first.commands != second.commands, axis=1))
    assert differ.size and first.period * differ[0] > until
    assert first.period * differ[0] < until + 1.0


def test_law_without_a_gauge_of_its_own_is_refused(device: gy.Plant) -> None:
    @dataclass(frozen=True)
    class Blind:
        information: str = "gauge"
        period: float = 0.1

        def informed(self, waves: Any) -> Any:
            return self

        def init(self) -> tuple[()]:
            return ()

        def step(self, t: float, y: Any, state: tuple[()]) -> Any:
            return (0.05, 4e-4), state

    waves = gy.realise(device, gy.SeaState(), 1, 20.0)
    with pytest.raises(gy.InputError, match="describes none"):
        informed(Blind(), waves, device)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrapped", [False, True])
def test_level_of_a_law_that_reads_a_gauge(device: gy.Plant, wrapped: bool) -> None:
    law = gy.law("nmpc", information="gauge", distance=5.0)
    if wrapped:
        law = gy.law("supervisor", wraps={"law": "nmpc", "information": "gauge", "distance": 5.0})
    assert sight(law) == Sight("gauge", 0.0)
    waves = gy.realise(device, gy.SeaState(), 1, 20.0)
    _, shutter = informed(law, waves, device)
    assert isinstance(shutter, GaugeShutter)


@pytest.mark.parametrize(
    ("settings", "field"),
    [
        ({"distance": 0.0}, "gauge.distance"),
        ({"distance": 1e4}, "gauge.distance"),
        ({"sampling": -0.1}, "gauge.sampling"),
        ({"gauge_noise": -1e-3}, "gauge.gauge_noise"),
        ({"drift": -1e-3}, "gauge.drift"),
        ({"drift_time": 0.0}, "gauge.drift_time"),
        ({"heading": 400.0}, "gauge.heading"),
        ({"misplaced": -11.0}, "gauge.misplaced"),
        ({"placing": -0.1}, "gauge.placing"),
    ],
)
def test_gauge_that_cannot_be_is_refused(settings: dict[str, float], field: str) -> None:
    with pytest.raises(gy.InputError) as refused:
        gy.law("nmpc", information="gauge", **settings)
    assert refused.value.field == field and refused.value.mend


@pytest.mark.parametrize("sampling", [0.15, 0.025])
def test_readings_that_do_not_fit_are_refused(device: gy.Plant, sampling: float) -> None:
    waves = lead_in(gy.realise(device, gy.SeaState(), 1, 20.0), SETTINGS)
    law = gy.law("nmpc", information="gauge", sampling=sampling)
    with pytest.raises(gy.InputError, match=r"gauge.sampling"):
        run_law(device, law, waves, SETTINGS)


def test_law_that_was_given_no_readings_says_so(device: gy.Plant) -> None:
    law = gy.law("nmpc", information="gauge", plant=device)
    with pytest.raises(gy.InputError, match="no readings"):
        law.step(0.0, gy.Measurement(0.0, 3.0, 70.0, 0.0, 0.0, 0.0, 0.0), law.init())


def test_law_that_makes_up_for_a_delay_is_told_as_far_as_it_plans(device: gy.Plant) -> None:
    """The plan begins where the command acts, and the gauge has to tell of its whole length."""
    law = gy.law("nmpc", information="gauge", delay=3, horizon=2.0, plant=device)
    waves = gy.realise(device, gy.SeaState(), 100000, 30.0)
    gauge = law._foresight.gauge
    values = measured(law.gauge, waves, device)
    state, memory = gauge.init(), law.memory(law.init())
    ahead, now = memory.ahead.copy(), np.zeros(2)
    prepare(gauge, gy.SeaState().spectrum(law._foresight.predictor.learner.omega), state)
    assert ahead.shape == (2, 23)
    assert predict_from_gauge(gauge, state, values, 250, 0, memory.forecast.history, 60, now, ahead)
    assert np.all(np.abs(ahead).max(axis=0) > 0.0)
