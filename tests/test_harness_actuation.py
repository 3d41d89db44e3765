"""Actuators: limits, lag, rate, quantum and delay, and what they count."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.actuation import actuate
from gyroctl.harness.run import Settings, run_law
from gyroctl.plant.course import Course, set_out
from gyroctl.plant.kernel import instant

Array = NDArray[np.float64]


def actuated(actuators: gy.Actuators, commands: Array, before: tuple[float, float] = (0.0, 0.0)) -> tuple[Array, int]:
    """Controls (n, 2) at the end of each interval after the commands (n, 2), and how many saturated."""
    held, aim, out, count = np.array(before), np.array(before), np.empty_like(commands), 0
    arrays, course = actuators.arrays(), Course(*np.zeros((6, 2)))
    for sample in range(commands.shape[0]):
        count += actuate(arrays, sample, commands, aim)
        set_out(course, arrays.lag, arrays.rate, held, aim)
        held = np.array(instant(course, actuators.period))
        out[sample] = held
    return out, count


COMMANDS = np.random.default_rng(5).uniform([0.0, 0.0], [0.3, 0.02], (200, 2))


def test_plain_actuators_give_what_is_asked_for_to_the_bit() -> None:
    controls, count = actuated(gy.Actuators(), COMMANDS)
    np.testing.assert_array_equal(controls, COMMANDS)
    assert count == 0


def test_limits_clip_and_count_each_channel() -> None:
    commands = np.array([[0.1, 0.01], [0.4, 0.01], [-0.1, 0.03], [0.3, 0.02], [0.0, -1e-9]])
    controls, count = actuated(gy.Actuators(), commands)
    np.testing.assert_array_equal(controls, np.clip(commands, 0.0, [0.3, 0.02]))
    assert count == 1 + 2 + 0 + 1


def test_lag_is_a_first_order_response_to_a_step() -> None:
    """1 - exp(-t/T) at the samples, also from above."""
    steps = np.tile([0.2, 0.01], (30, 1))
    up, _ = actuated(gy.Actuators(cc_lag=0.5, cg_lag=1.0), steps)
    time = 0.1 * np.arange(1, 31)
    np.testing.assert_allclose(up[:, 0], 0.2 * (1 - np.exp(-time / 0.5)), rtol=1e-12)
    np.testing.assert_allclose(up[:, 1], 0.01 * (1 - np.exp(-time / 1.0)), rtol=1e-12)
    down, _ = actuated(gy.Actuators(cc_lag=0.5), np.zeros((30, 2)), (0.2, 0.0))
    np.testing.assert_allclose(down[:, 0], 0.2 * np.exp(-time / 0.5), rtol=1e-12)


def test_rate_limit_is_a_ramp_that_arrives_exactly() -> None:
    controls, _ = actuated(gy.Actuators(cc_rate=0.3, cg_rate=0.05), np.tile([0.1, 0.02], (10, 1)))
    np.testing.assert_allclose(controls[:, 0], [0.03, 0.06, 0.09, *[0.1] * 7], rtol=1e-12)
    assert controls[3, 0] == 0.1 and controls[-1, 1] == 0.02


def test_rate_limit_holds_under_any_command_and_with_lag() -> None:
    controls, _ = actuated(gy.Actuators(cc_rate=0.5, cg_rate=0.02, cc_lag=0.05), COMMANDS)
    change = np.abs(np.diff(controls, axis=0, prepend=0.0))
    assert np.all(change <= np.array([0.05, 0.002]) * (1 + 1e-12))
    assert np.all((controls >= 0.0) & (controls <= [0.3, 0.02]))


def test_quantum_rounds_to_nearest_and_stays_within_the_limit() -> None:
    controls, _ = actuated(gy.Actuators(cc_quantum=0.04, cg_quantum=0.003), COMMANDS)
    inside = controls < np.array([0.3, 0.02])
    levels = controls / [0.04, 0.003]
    np.testing.assert_allclose(levels[inside], np.round(levels[inside]), atol=1e-9)
    assert np.all(controls <= [0.3, 0.02])
    assert np.all(np.abs(controls - COMMANDS) <= np.array([0.02, 0.0015]) + 1e-12)


def test_delay_lets_commands_act_later() -> None:
    controls, _ = actuated(gy.Actuators(delay=3), COMMANDS)
    np.testing.assert_array_equal(controls[3:], COMMANDS[:-3])
    np.testing.assert_array_equal(controls[:3], 0.0)  # none of them acts yet


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("cc_max", 0.0),
        ("cc_max", -0.1),
        ("cg_max", math.nan),
        ("period", 0.0),
        ("period", -0.1),
        ("cc_lag", -1.0),
        ("cg_rate", -1.0),
        ("cc_quantum", math.inf),
        ("delay", -1),
        ("delay", 0.5),
        ("cc_max", "0.3"),
        ("delay", True),
    ],
)
def test_bad_actuator_is_named(field: str, value: Any) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.Actuators(**{field: value})
    assert caught.value.field == f"actuators.{field}" and caught.value.mend


def test_saturations_of_a_run_are_counted(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    settings = Settings(blend=20.0, actuators=gy.Actuators(cg_max=3e-4))
    record, _ = run_law(device, gy.law("constant", cg=5e-4), waves, settings)
    assert record.saturations == 1200
    np.testing.assert_array_equal(record.controls[:, 1], 3e-4)
    np.testing.assert_array_equal(record.commands[:, 1], 5e-4)
