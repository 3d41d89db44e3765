"""The supervisor's rules, without a device: modes, times, motor, hand-over, limits; and what it refuses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from lock_numbers import WP, N
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment
from gyroctl.controllers.supervisor import MODES, Rules, Watch
from gyroctl.controllers.supervisor.rules import PRODUCE, PULL, START, UNLOAD, command, first_watch, motor, observe
from gyroctl.harness.actuation import actuate
from gyroctl.harness.protocol import Measurement
from gyroctl.simulation.metrics import production


def seen(t: float, ring: float, flywheel: float, V: float = 0.3, delta: float = -0.3) -> Measurement:
    """A ring at a steady speed and a float rate that stands at the angle delta in its frame."""
    rate = V * complex(math.cos(delta - ring * t), math.sin(delta - ring * t))
    return Measurement(ring * t, ring, flywheel, 0.0, 0.0, rate.real, rate.imag)


def after(watch: Watch, seconds: float, ring: float, flywheel: float, delta: float = -0.3) -> list[Watch]:
    """Watches while the same is seen for a while."""
    found = []
    for i in range(round(seconds / 0.1)):
        watch = observe(Rules(), 0.1, seen(0.1 * i, ring, flywheel, delta=delta), watch)
        found.append(watch)
    return found


# --- rules ---------------------------------------------------------------------------------------------------------


def test_modes_follow_flywheel_and_ring() -> None:
    """Rest, flywheel up to speed, ring in step, handed over, ring behind, stalled with a fast and a slow flywheel."""
    rules = Rules()
    enough = rules.speed_ratio * N * WP + 0.1
    watch = after(first_watch(), 50.0, 0.0, 10.0)[-1]
    assert (watch.mode, watch.starts) == (START, 1.0)
    watch = after(watch, 20.0, 0.0, enough)[-1]
    assert (watch.mode, watch.share) == (PULL, 0.0)
    ways = after(watch, 30.0, WP, enough)
    modes = [w.mode for w in ways]
    caught = modes.index(PRODUCE)
    assert rules.confirm <= 0.1 * caught <= rules.confirm + 5.0 * rules.window
    assert ways[caught].catches == 1.0
    watch = after(ways[-1], 10.0, 0.45 * WP, enough)[-1]
    assert (watch.mode, watch.unloads) == (UNLOAD, 1.0)
    assert after(watch, 15.0, WP, enough)[-1].mode == PRODUCE
    assert after(watch, 20.0, 0.0, enough)[-1].mode == PULL
    assert after(watch, 20.0, 0.0, 20.0)[-1].mode == START


def test_ring_at_the_wrong_angle_or_not_caught_in_time_is_not_in_lock() -> None:
    """U1 < 0: the float's motion brakes the ring. It is let go after the patience."""
    watch = after(after(first_watch(), 1.0, 0.0, 70.0)[-1], 1.0, WP, 70.0)[-1]
    ways = after(watch, 80.0, WP, 20.0, delta=2.5)
    assert next(w.mode for w in ways if w.mode != PULL) == START
    assert next(i for i, w in enumerate(ways) if w.mode == START) * 0.1 <= Rules().patience
    assert ways[-1].catches == 0.0


def test_times_in_the_modes_add_up() -> None:
    ways = after(first_watch(), 30.0, 0.0, 10.0) + after(after(first_watch(), 30.0, 0.0, 10.0)[-1], 40.0, WP, 70.0)
    last = ways[-1]
    assert sum(getattr(last, f"time_{mode}") for mode in MODES) == pytest.approx(70.0)
    assert last.time_start == pytest.approx(30.0)


def test_motor_keeps_its_limits_and_brakes_the_wrong_sense() -> None:
    rules = Rules(motor_gain=0.02, motor_power=30.0)
    for speed in np.linspace(0.1, 90.0, 400):
        cg = motor(rules, float(speed))
        assert -0.02 <= cg < 0.0
        assert -cg * speed**2 <= 30.0 * (1.0 + 1e-12)
    assert -motor(rules, 60.0) * 60.0**2 == pytest.approx(30.0)
    assert motor(rules, -3.0) == 0.02


def test_hand_over_does_not_jump() -> None:
    """The law wants its most from the first sample on: the command gets there in equal steps along the ramp."""
    rules, wanted = Rules(), (0.3, 0.02)
    watch = after(first_watch(), 1.0, 0.0, 70.0)[-1]
    ways = after(watch, 40.0, WP, 71.0)
    given = np.array([command(rules, seen(0.0, WP, 71.0), w, *wanted) for w in ways])
    begin = next(i for i, w in enumerate(ways) if w.mode == PRODUCE)
    steps = np.abs(np.diff(given[begin - 5 :], axis=0)).max(axis=0)
    np.testing.assert_array_less(steps, np.array(wanted) * 0.1 / rules.handover + 1e-12)
    np.testing.assert_allclose(given[-1], wanted)
    assert given[begin, 1] == 0.0


# --- actuators and metrics -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motors", "wanted", "given", "count"),
    [(False, -0.01, 0.0, 1), (True, -0.01, -0.01, 0), (True, -0.05, -0.02, 1), (True, 0.05, 0.03, 1)],
)
def test_lower_limit_is_for_laws_that_motor(motors: bool, wanted: float, given: float, count: int) -> None:
    arrays = gy.Actuators(cg_min=-0.02, cg_max=0.03, cg_quantum=0.004).arrays(motors)
    held, commands = np.zeros(2), np.array([[0.1, wanted]])
    assert actuate(arrays, 0, commands, held) == count
    assert abs(held[1] - given) <= 0.002 + 1e-12
    assert arrays.floor[1] - 1e-15 <= held[1] <= 0.03
    assert arrays.floor[0] == 0.0


def test_production_wants_turns_and_no_motor() -> None:
    """30 s standing, 30 s turning with the motor, 30 s turning alone, then standing: true from 10 s after the motor."""
    dt = 0.1
    t = np.arange(1200) * dt
    turning = (t >= 30.0) & (t < 90.0)
    psi = np.concatenate([[0.0], np.cumsum(np.where(turning, WP, 0.0))[:-1]]) * dt
    net = np.cumsum(np.where(t < 60.0, np.where(t >= 30.0, -1.0, 0.0), np.where(t < 90.0, 1.0, 0.0)))
    found = t[production(psi, net, dt, WP)]
    assert found[0] == pytest.approx(70.0, abs=0.2)
    assert found[-1] == pytest.approx(95.0, abs=0.2)  # half of the turns in 10 s
    assert not production(-psi, net, dt, WP).any()
    assert production(-psi, net, dt, WP, sense=-1).sum() == found.size


def test_load_is_a_plain_array(device: gy.Plant) -> None:
    """Regression: the lower limit enters the compiled loop as an array like the other limits."""
    arrays: NDArray[np.float64] = gy.Actuators().arrays().floor
    assert arrays.dtype == np.float64
    np.testing.assert_array_equal(arrays, 0.0)


# --- bad input -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("build", "field"),
    [
        (lambda: gy.Settings(start="sleeping"), "run.start"),
        (lambda: gy.Actuators(cg_min=0.01), "actuators.cg_min"),
        (lambda: gy.Actuators(cg_min=math.nan), "actuators.cg_min"),
        (lambda: build_experiment({"run": {"start": "fast"}}), "run.start"),
        (lambda: gy.law("supervisor", wraps="nothing"), "law"),
        (lambda: gy.law("supervisor", wraps="supervisor"), "laws.supervisor.wraps"),
        (lambda: gy.law("supervisor", wraps={"share": 0.3}), "laws.supervisor.wraps"),
        (lambda: gy.law("supervisor", wraps={"law": "load_angle", "chare": 0.3}), "laws.load_angle.chare"),
        (lambda: gy.law("supervisor", patience=-1.0), "laws.supervisor"),
        (lambda: gy.law("supervisor", window=0.0), "laws.supervisor"),
        (lambda: gy.law("supervisor", hurry=1.0), "laws.supervisor.hurry"),
    ],
)
def test_bad_input_names_the_field(build: Any, field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        build()
    assert caught.value.field == field
