"""A lost sensor: what the laws take in its place, and that the estimator never believes what is no reading."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from rule_based_laws import LAWS

import gyroctl as gy
from gyroctl.controllers.nmpc.sample import acted_on
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.nested import leaves
from gyroctl.plant.measurement import CHANNELS, ROWS, Measurement
from gyroctl.plant.readings import PATIENCE, SAFE, TURN, believed, joint, unread
from gyroctl.simulation.metrics import evaluate
from gyroctl.waves.estimation import SENSOR_NOISE, EstimatorState, MomentEstimator, look_to_then, update
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


@pytest.mark.parametrize("reads", ["nothing", "zero"])
@pytest.mark.parametrize("name", [*LAWS, "scheduled_lmi", "supervisor"])
def test_law_holds_the_lock_while_a_sensor_of_the_float_is_lost(device: gy.Plant, name: str, reads: Any) -> None:
    """Twenty seconds without phi3', which drives the ring: as Python and as machine code the same bits."""
    lost = replace(gy.Sensors().phi3_rate, lost_from=40.0, lost_for=20.0, lost_reads=reads)
    settings = Settings(blend=20.0, sensors=replace(gy.Sensors(), phi3_rate=lost))
    waves = lead_in(gy.realise(device, gy.SeaState(gamma=50.0), 100002, duration=70.0), settings)
    law = gy.law(name)
    record, _ = run_law(device, law, waves, settings)
    turned = record.states[-1, 2] - record.states[400, 2]
    assert turned > 0.8 * WP * 30.0
    plain, _ = run_law(device, law, waves, settings, compiled=False)
    np.testing.assert_array_equal(record.commands, plain.commands)


def test_device_at_rest_is_not_taken_for_lost_sensors() -> None:
    """Ideal sensors of a device that stands repeat themselves, and all agree."""
    seen, blind = followed(np.zeros((100, 7)))
    assert not seen.any() and not blind.any()


def test_what_repeats_itself_rightly_is_believed() -> None:
    """A rate that is read with a coarse resolution repeats itself next to the truth."""
    y = course(400)
    y[:, 5] = np.round(y[:, 5] / 0.15) * 0.15 + 0.01
    seen, _ = followed(y)
    repeats = np.flatnonzero(np.diff(y[:, 5]) == 0.0) + 1
    assert repeats.size > 10
    assert np.mean(seen[repeats, 5] == y[repeats, 5]) > 0.5


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


def test_gain_of_the_sensors_that_are_left_is_the_one_that_acts(estimator: MomentEstimator, record: Any) -> None:
    """One sample without phi3 moves the moments by the gain that was designed for its loss."""
    y = noisy(record)
    state = estimator.init()
    for i in range(300):
        update(estimator, state, y[i], *record.commands[max(i - 1, 0)])
    copies = [EstimatorState(*(part.copy() for part in state)) for _ in range(2)]
    whole, holed = y[300].copy(), y[300].copy()
    holed[4] = math.nan
    for one, reading in zip(copies, (whole, holed), strict=True):
        update(estimator, one, reading, *record.commands[299])
    e = copies[0].innovation[3:]
    left = estimator.partial[2] @ (e * np.array([1.0, 0.0, 1.0, 1.0])) - estimator.gain @ e
    np.testing.assert_allclose(copies[1].wave - copies[0].wave, left[-4:], rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(copies[1].missing, np.arange(7) == 4)


def test_variance_of_the_ring_grows_while_a_sensor_is_lost(estimator: MomentEstimator, record: Any) -> None:
    """Without psi its variance is that of a random walk: the noise of psi' is integrated, nothing takes it away."""
    y = noisy(record)
    y[300:500, 0] = math.nan
    state, variance = estimator.init(), []
    for i in range(500):
        update(estimator, state, y[i], *record.commands[max(i - 1, 0)])
        variance.append(state.ring[0, 0])
    growth = np.diff(variance[310:])
    assert np.all(growth > 0.0)
    assert variance[499] > 20.0 * variance[299]


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


def test_plan_of_a_law_that_knows_its_delay_begins_where_it_acts() -> None:
    """In the state then, and with the moments that were foreseen for two intervals later."""
    law = gy.law("nmpc", delay=2)
    state = law.init()
    for i, row in enumerate(course(100)):
        _, state = law.step(PERIOD * i, Measurement(*row.tolist()), state)
    memory, numbers = law.memory(state), law._numbers
    width = memory.moments.size // (2 * memory.ahead.shape[1] + 1)
    assert memory.ahead.shape[1] == law.intervals + 2
    plan = acted_on(numbers, memory.ahead, memory.moments)
    assert plan.size == width * (2 * law.intervals + 1)
    np.testing.assert_array_equal(plan[:2], memory.ahead[:, 1])  # the second interval's end is the plan's beginning
    np.testing.assert_array_equal(memory.work.start, memory.estimate.then[numbers.rows])
    assert np.max(np.abs(memory.estimate.then - memory.estimate.x_hat)) > 0.1


@pytest.mark.slow
def test_planner_that_knows_its_delay_loses_a_tenth_of_its_power_at_most(device: gy.Plant) -> None:
    powers = {}
    for name, law, delay in (("none", 0, 0), ("known", 1, 1), ("unknown", 0, 1)):
        settings = Settings(actuators=gy.Actuators(delay=delay))
        found = []
        for seed in range(100000, 100004):
            waves = lead_in(gy.realise(device, gy.SeaState(), seed, duration=400.0), settings)
            record, _ = run_law(device, gy.law("nmpc", delay=law), waves, settings)
            found.append(evaluate(device, record, waves.moments[1], waves.dt, WP, 100.0, np.nan)["mean_power"])
        powers[name] = np.mean(found)
    assert powers["known"] > 0.9 * powers["none"]
    assert powers["unknown"] < 0.9 * powers["none"], "else there is nothing to make up for"


@pytest.mark.parametrize("delay", [-1, 0.5, True, 11, "1"])
def test_delay_that_cannot_be_made_up_for_is_refused(delay: Any) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.law("nmpc", delay=delay)
    assert caught.value.field == "nmpc.delay"


def test_readings_with_a_resolution_are_believed_where_they_are_zero_by_chance() -> None:
    """A gyro tells zero where the float turns back, an encoder once in a turn: nothing is lost then."""
    period, rate_before = 0.1, 0.44
    way = 0.5 * period * rate_before  # of a float that slows down evenly and stands still
    angle, rate, dark = joint(period, 5.0, 0.3 + way, 0.0, 0.3, rate_before, 0.3, 0.0, False, 0.0)
    assert (angle, rate, dark) == (0.3 + way, 0.0, False)
    begin = TURN - 0.5 * period * (3.0 + 8.0)  # the ring has sped up from 3 to 8 rad/s, and passes the encoder's zero
    angle, rate, dark = joint(period, 0.0, TURN, 8.0, begin, 3.0, begin, 3.0, False, TURN)
    assert (angle, rate, dark) == (TURN, 8.0, False)


def test_gyro_that_goes_dead_is_not_believed() -> None:
    period, at = 0.1, 0.3
    _, rate, dark = joint(period, 5.0, at + 0.044, 0.0, at, 0.44, at, 0.0, False, 0.0)
    assert rate == pytest.approx(0.44) and not dark
