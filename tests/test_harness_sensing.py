"""Sensors: noise, bias, quantum, delay and dropout, the same for every law."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from user_law import UserLaw

import gyroctl as gy
from gyroctl.harness.run import Settings, run_law
from gyroctl.harness.sensing import measure
from gyroctl.plant.measurement import CHANNELS, ROWS

Array = NDArray[np.float64]


def measured(sensors: gy.Sensors, record: Array, seed: int = 1) -> Array:
    """What a law would see of a record (n, rows): (n, 7)."""
    arrays, y = sensors.arrays(record.shape[0], seed), np.zeros(7)
    out = np.empty((record.shape[0], 7))
    for sample in range(record.shape[0]):
        measure(arrays, sample, record, y)
        out[sample] = y
    return out


@pytest.fixture(scope="module")
def motion() -> Array:
    """A smooth record (2000, 19)."""
    return np.asarray(np.sin(0.05 * np.arange(2000)[:, None] + np.arange(19)) * np.arange(1, 20), np.float64)


def test_ideal_sensors_tell_the_state(motion: Array) -> None:
    np.testing.assert_array_equal(measured(gy.Sensors.ideal(), motion), motion[:, ROWS])
    assert CHANNELS == ("psi", "psi_rate", "omega_rate", "phi1", "phi3", "phi1_rate", "phi3_rate")
    assert ROWS == (2, 6, 7, 0, 1, 4, 5)


def test_default_sensors_have_the_stated_noise(motion: Array) -> None:
    error = measured(gy.Sensors(), motion) - motion[:, ROWS]
    quantum = 2 * math.pi / 4096
    expected = [math.hypot(1e-3, quantum / math.sqrt(12)), 0.02, 0.1, 1e-3, 1e-3, 4e-3, 4e-3]
    np.testing.assert_allclose(np.std(error, axis=0), expected, rtol=0.06)
    assert np.all(np.abs(np.mean(error, axis=0)) < 4 * np.array(expected) / math.sqrt(2000))
    correlation = np.corrcoef(error.T) - np.eye(7)
    assert np.max(np.abs(correlation)) < 0.1
    lagged = np.corrcoef(error[1:, 1], error[:-1, 1])[0, 1]
    assert abs(lagged) < 0.1


def test_bias_quantum_and_delay(motion: Array) -> None:
    sensors = gy.Sensors(
        *[gy.Channel(bias=0.5), gy.Channel(quantum=0.25), gy.Channel(delay=3)], *[gy.Channel() for _ in range(4)]
    )
    seen = measured(sensors, motion)
    np.testing.assert_allclose(seen[:, 0] - motion[:, ROWS[0]], 0.5)
    np.testing.assert_allclose(seen[:, 1] / 0.25, np.round(seen[:, 1] / 0.25), atol=1e-9)
    assert np.max(np.abs(seen[:, 1] - motion[:, ROWS[1]])) <= 0.125 + 1e-12
    np.testing.assert_array_equal(seen[3:, 2], motion[:-3, ROWS[2]])
    np.testing.assert_array_equal(seen[:3, 2], motion[0, ROWS[2]])


def test_dropout_keeps_the_last_value_that_came(motion: Array) -> None:
    channels = {name: gy.Channel(dropout=0.25) for name in CHANNELS}
    seen = measured(gy.Sensors(**channels), motion)
    true = motion[:, ROWS]
    fresh = seen == true
    np.testing.assert_array_equal(fresh[0], True)  # a law never starts blind
    assert np.mean(fresh) == pytest.approx(0.75, abs=0.02)
    for sample in range(1, 2000):
        np.testing.assert_array_equal(seen[sample][~fresh[sample]], seen[sample - 1][~fresh[sample]])


def test_noise_is_that_of_the_realisation_whatever_the_law(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """The same for every law, another for another seed, and not the random numbers of the waves."""
    sensors = gy.Sensors()
    one, same, other = sensors.arrays(500, 3), sensors.arrays(500, 3), sensors.arrays(500, 4)
    np.testing.assert_array_equal(one.error, same.error)
    assert not np.array_equal(one.error, other.error)
    plain = np.random.default_rng(3).standard_normal((500, 7))
    assert abs(np.corrcoef(one.error[:, 1], plain[:, 1])[0, 1]) < 0.2

    class Spy(UserLaw):
        """Notes what it sees."""

    seen: dict[str, list[Any]] = {"a": [], "b": []}

    def spying(key: str, cg: float) -> Any:
        def step(t: float, y: Any, state: Any) -> Any:
            seen[key].append(y)
            return (0.052, cg), state

        return Spy(step)

    records = [
        run_law(device, spying(key, cg), waves, Settings(blend=20.0))[0] for key, cg in (("a", 1e-4), ("b", 1e-3))
    ]
    errors = [
        np.array(seen[key])[:, 3] - record.states[:-1, 0] for key, record in zip(("a", "b"), records, strict=True)
    ]
    np.testing.assert_allclose(errors[0], errors[1], atol=1e-12)
    assert np.std(errors[0]) == pytest.approx(1e-3, rel=0.1)


@pytest.mark.parametrize(
    ("field", "channel"),
    [
        ("sensors.phi1.noise", {"noise": -1.0}),
        ("sensors.phi1.quantum", {"quantum": -0.1}),
        ("sensors.phi1.delay", {"delay": -1}),
        ("sensors.phi1.delay", {"delay": 1.5}),
        ("sensors.phi1.dropout", {"dropout": 1.0}),
        ("sensors.phi1.dropout", {"dropout": -0.1}),
        ("sensors.phi1.bias", {"bias": math.nan}),
        ("sensors.phi1.noise", {"noise": "much"}),
        ("sensors.phi1.noise", {"noise": math.inf}),
    ],
)
def test_bad_sensor_is_named(field: str, channel: dict[str, Any]) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.Sensors(phi1=gy.Channel(**channel))
    assert caught.value.field == field and caught.value.mend


@pytest.mark.parametrize(
    ("reads", "expected"), [("nothing", math.nan), ("zero", 0.0), ("last", None)], ids=["nothing", "zero", "last"]
)
def test_lost_sensor_reads_as_chosen_for_its_time_alone(motion: Array, reads: Any, expected: float | None) -> None:
    """Lost from 5 to 8 s at 0.1 s a sample: samples 50 to 79; the other sensors, with a resolution too, go on."""
    lost = gy.Channel(quantum=1e-9, lost_from=5.0, lost_for=3.0, lost_reads=reads)
    whole, holed = (measured(gy.Sensors(phi1=channel), motion) for channel in (gy.Channel(quantum=1e-9), lost))
    away = np.zeros(len(motion), bool)
    away[50:80] = True
    np.testing.assert_array_equal(holed[~away], whole[~away])
    np.testing.assert_array_equal(np.delete(holed, 3, axis=1), np.delete(whole, 3, axis=1))
    np.testing.assert_array_equal(holed[away, 3], whole[49, 3] if expected is None else expected)


@pytest.mark.parametrize(("period", "first", "end"), [(0.1, 3, 6), (0.05, 6, 12), (0.2, 2, 3)])
def test_loss_is_counted_in_seconds(period: float, first: int, end: int) -> None:
    sensors = gy.Sensors(psi=gy.Channel(lost_from=0.3, lost_for=0.3, lost_reads="zero"))
    fate = sensors.arrays(20, 1, period).fate[:, 0]
    np.testing.assert_array_equal(np.flatnonzero(fate), np.arange(first, end))


def test_one_sample_that_comes_late_is_the_one_before(motion: Array) -> None:
    late = gy.Channel(lost_from=1.0, lost_for=0.1, lost_reads="last")
    seen = measured(gy.Sensors(*[late] * 7), motion)
    expected = motion[:, ROWS].copy()
    expected[10] = expected[9]
    np.testing.assert_array_equal(seen, expected)


def test_unknown_reading_of_a_lost_sensor_is_named() -> None:
    for value in ("nan", 0.0, ["zero"]):
        with pytest.raises(gy.InputError) as caught:
            gy.Sensors(phi3=gy.Channel(lost_reads=value))  # type: ignore[arg-type]
        assert caught.value.field == "sensors.phi3.lost_reads"
