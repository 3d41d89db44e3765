"""A lost sensor: what the laws take in its place, and that the estimator never believes what is no reading."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from rule_based_laws import LAWS

import gyroctl as gy
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.nested import leaves
from gyroctl.plant.measurement import CHANNELS, ROWS, Measurement
from gyroctl.plant.readings import PATIENCE, SAFE, believed, unread
from gyroctl.waves.estimation import SENSOR_NOISE, MomentEstimator, look_to_then, update
from gyroctl.waves.estimation.moment_model import gains_of, gains_of_the_rest

Array = NDArray[np.float64]

N, PERIOD, WP = 22.5, 0.1, 3.14
READS = {"nothing": math.nan, "zero": 0.0, "last": None}


def course(samples: int, noise: float = 1.0, seed: int = 1) -> Array:
    """Readings (samples, 7) of a ring that turns unevenly and a float that swings, with the noise of the sensors."""
    t = PERIOD * np.arange(samples)
    psi, psi_rate = WP * t + 0.3 * np.sin(0.5 * t), WP + 0.15 * np.cos(0.5 * t)
    phi1, phi3 = 0.12 * np.cos(WP * t), -0.1 * np.sin(WP * t)
    rates = -0.12 * WP * np.sin(WP * t), -0.1 * WP * np.cos(WP * t)
    true = np.stack([psi, psi_rate, N * WP + np.sin(0.2 * t), phi1, phi3, *rates], axis=1)
    return np.asarray(true + noise * np.array(SENSOR_NOISE) * np.random.default_rng(seed).standard_normal(true.shape))


def lose(y: Array, lost: tuple[int, ...], reads: str, span: slice) -> Array:
    """Readings with some sensors lost for a time."""
    seen = y.copy()
    for channel in lost:
        value = READS[reads]
        seen[span, channel] = y[span.start - 1, channel] if value is None else value
    return seen


def followed(y: Array) -> tuple[Array, Array]:
    """What a law goes by (n, 7), and for how long it has been blind (n,) [s]."""
    kept, out, blind = unread(), np.empty(y.shape), np.empty(len(y))
    for i, row in enumerate(y):
        good, kept = believed(PERIOD, N, Measurement(*row.tolist()), kept)
        out[i], blind[i] = good, kept.blind
    return out, blind


# --- what laws take for a lost reading -----------------------------------------------------------------------------


def test_readings_of_whole_sensors_pass_bit_for_bit() -> None:
    y = course(2000)
    seen, blind = followed(y)
    np.testing.assert_array_equal(seen, y)
    assert not blind.any()


@pytest.mark.parametrize("reads", READS)
@pytest.mark.parametrize("channel", range(7), ids=CHANNELS)
def test_partner_stands_in_for_a_lost_sensor(channel: int, reads: str) -> None:
    """Over 20 s an angle is off by its rate's noise and the rule of the integral, a rate by half a sample's turn."""
    y, true, span = course(600), course(600, noise=0.0), slice(200, 400)
    seen, blind = followed(lose(y, (channel,), reads, span))
    assert not blind.any()
    np.testing.assert_array_equal(np.delete(seen, channel, axis=1), np.delete(y, channel, axis=1))
    np.testing.assert_array_equal(seen[:200], y[:200])
    np.testing.assert_array_equal(seen[400:], y[400:])
    off = np.sqrt(np.mean((seen - true)[span, channel] ** 2))
    if channel == 0:
        off = np.sqrt(np.mean(np.angle(np.exp(1j * (seen - true)[span, 0])) ** 2))
    assert off < [0.1, 0.12, 1.5, 0.04, 0.04, 0.1, 0.1][channel]
    swing = [2.0, 0.12, 1.5, 0.085, 0.07, 0.27, 0.22][channel]
    assert channel == 2 or off < 0.6 * swing or channel == 1  # far better than to take none


def test_ring_takes_the_flywheel_where_both_of_its_sensors_are_lost_and_the_law_ends_on_the_safe_pair() -> None:
    y = course(600)
    seen, blind = followed(lose(y, (0, 1), "nothing", slice(200, 400)))
    np.testing.assert_allclose(seen[200:400, 1], y[200:400, 2] / N, rtol=1e-12)
    assert blind[199] == 0.0 and blind[399] == pytest.approx(20.0) and blind[400] == 0.0
    for name, law in {**LAWS, "scheduled_lqr": gy.law("scheduled_lqr")}.items():
        state, commands = law.init(), []
        for i, row in enumerate(lose(y, (3, 5), "nothing", slice(200, 400))):
            command, state = law.step(PERIOD * i, Measurement(*row.tolist()), state)
            commands.append(command)
            assert all(math.isfinite(value) for value in (*command, *leaves(state))), name
        wait = round(PATIENCE / PERIOD) + 1
        assert all(command == SAFE for command in commands[200 + wait : 400]), name
        assert SAFE not in commands[:200] and SAFE not in commands[400:], name


def test_device_at_rest_is_not_taken_for_lost_sensors() -> None:
    """Ideal sensors of a device that stands repeat themselves, and all agree."""
    seen, blind = followed(np.zeros((100, 7)))
    assert not seen.any() and not blind.any()


# --- estimator -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def estimator(device: gy.Plant) -> MomentEstimator:
    return MomentEstimator.design(device)


@pytest.fixture(scope="module")
def record(device: gy.Plant) -> Any:
    settings = Settings(blend=20.0)
    waves = lead_in(gy.realise(device, gy.SeaState(), 100000, duration=120.0), settings)
    return run_law(device, gy.law("coupling"), waves, settings)[0]


def estimated(estimator: MomentEstimator, record: Any, y: Array) -> Array:
    state, out = estimator.init(), np.empty((len(y), state_size(estimator)))
    for i, row in enumerate(y):
        update(estimator, state, row, *record.commands[max(i - 1, 0)])
        out[i] = state.x_hat
    return out


def state_size(estimator: MomentEstimator) -> int:
    return int(estimator.init().x_hat.size)


def noisy(record: Any, seed: int = 2) -> Array:
    true = record.states[:-1, ROWS]
    return np.asarray(true + np.array(SENSOR_NOISE) * np.random.default_rng(seed).standard_normal(true.shape))


@pytest.mark.parametrize("reads", READS)
@pytest.mark.parametrize("channel", range(7), ids=CHANNELS)
def test_estimate_bears_a_lost_sensor(estimator: MomentEstimator, record: Any, channel: int, reads: str) -> None:
    """For 20 s the lost quantity is told by the others: within a fifth of how much it moves, or the ring's drift."""
    y, span = noisy(record), slice(600, 800)
    x = estimated(estimator, record, lose(y, (channel,), reads, span))
    true = record.states[:-1]
    assert np.all(np.isfinite(x))
    off = np.sqrt(np.mean((x[span] - true[span][:, : x.shape[1]])[:, ROWS] ** 2, axis=0))
    moves = np.array([1.0, 0.5, 3.0, *np.std(true[span][:, ROWS[3:]], axis=0)])
    assert np.all(off < 0.35 * moves), off / moves
    back = np.abs((x[900:] - true[900:, : x.shape[1]])[:, ROWS])
    assert np.all(np.mean(back, axis=0) < 3.0 * np.array(SENSOR_NOISE))


def test_no_reading_at_the_first_sample_or_ever_leaves_no_trace_that_is_no_number(
    estimator: MomentEstimator, record: Any
) -> None:
    y = noisy(record)
    for lost in ((0,), (1, 2), tuple(range(7))):
        x = estimated(estimator, record, np.where(np.isin(np.arange(7), lost), math.nan, y)[:100])
        assert np.all(np.isfinite(x))


def test_gain_of_the_rest_is_that_of_a_sensor_whose_noise_is_boundless(device: gy.Plant) -> None:
    """A lost sensor and one that tells next to nothing are the same to a Kalman filter."""
    noise = np.array(SENSOR_NOISE)
    model, whole = gains_of(device, gy.SeaState(), noise, 0.1, 0.2, 0.3)
    partial = gains_of_the_rest(model, whole, noise[3:], 0.1)
    for lost, vague in ((1, (3,)), (4, (5,)), (10, (4, 6))):
        louder = noise.copy()
        louder[list(vague)] = 1e3
        _, expected = gains_of(device, gy.SeaState(), louder, 0.1, 0.2, 0.3)
        scale = np.max(np.abs(whole.gain), axis=1, keepdims=True)
        np.testing.assert_allclose(partial[lost] / scale, expected.gain / scale, atol=1e-3)
    np.testing.assert_array_equal(partial[0], whole.gain)
    assert not partial[15].any()


# --- delay ---------------------------------------------------------------------------------------------------------


def test_state_then_is_where_the_known_commands_lead(device: gy.Plant) -> None:
    """Estimated with a known delay of two samples, the device without noise is found two samples ahead."""
    late = 2
    estimator = MomentEstimator.design(device, sensor_noise=(1e-6,) * 7, delay=late)
    settings = Settings(blend=20.0, actuators=gy.Actuators(delay=late), sensors=gy.Sensors.ideal())
    waves = lead_in(gy.realise(device, gy.SeaState(), 100001, duration=80.0), settings)
    record, _ = run_law(device, gy.law("coupling"), waves, settings)
    state, gaps, still = estimator.init(), [], []
    for i in range(700):
        update(estimator, state, record.states[i, list(ROWS)], *record.commands[max(i - 1, 0)])
        before = [part.copy() for part in (state.x_hat, state.wave)]
        look_to_then(estimator, state)
        for part, whole in zip((state.x_hat, state.wave), before, strict=True):
            np.testing.assert_array_equal(part, whole)
        gaps.append(state.then[:8] - record.states[i + late, :8])
        still.append(record.states[i, :8] - record.states[i + late, :8])
    off, moved = (np.sqrt(np.mean(np.array(rows[300:]) ** 2, axis=0)) for rows in (gaps, still))
    known = [0, 1, 4, 5, 6, 7]  # phi1, phi3, their rates, psi', omega'
    assert np.all(off[known] < 0.2 * moved[known]), off / moved
