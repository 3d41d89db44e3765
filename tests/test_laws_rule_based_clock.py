"""The wave clock of the laws by rules, and how it eases them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from lock_numbers import WP

import gyroctl as gy
from gyroctl.controllers.rule_based import LoadAngle
from gyroctl.controllers.rule_based.wave_clock import Clock, Easing, WaveClock, begin, eased, follow, upright
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant.equations import PHI1_RATE, PHI3_RATE


def clock_over(rates: Any, bandwidth: float = 0.2, memory: float = 50.0) -> list[Clock]:
    """Clock over complex rates phi1' + i phi3' at 0.1 s, from 3.14 rad/s."""
    settings = WaveClock(bandwidth, memory, WP)
    state, seen = begin(settings), []
    for rate in rates:
        y = Measurement(0.0, 0.0, 0.0, 0.0, 0.0, rate.real, rate.imag)
        state = follow(settings, 0.1, y, state)
        seen.append(state)
    return seen


@pytest.mark.parametrize("w", [2.7, 3.14, 3.6, 4.2])
def test_clock_finds_frequency_phase_and_height(w: float) -> None:
    t = 0.1 * np.arange(3000)
    last = clock_over(0.3 * np.exp(-1j * (w * t - 0.7)))[-1]
    assert last.speed == pytest.approx(w, rel=2e-3)
    assert math.sqrt(last.square) == pytest.approx(0.3, rel=1e-9)
    # the angle is that of the next sample: the float's rate turned by it is real
    error = upright(last.theta, last.speed, 0.1) - (w * 300.0 - 0.7)
    assert abs(math.remainder(error, 2.0 * math.pi)) < 0.01


def test_clock_sees_the_part_that_turns_with_the_ring_only() -> None:
    """Three quarters of the motion one way, a quarter the other way."""
    t = 0.1 * np.arange(3000)
    seen = clock_over(0.3 * np.exp(-3.5j * t) + 0.1 * np.exp(3.5j * t), bandwidth=0.15)
    assert np.mean([state.speed for state in seen[1500:]]) == pytest.approx(3.5, rel=5e-3)


def test_clock_follows_a_drifting_frequency() -> None:
    t = 0.1 * np.arange(6000)
    w = 2.7 + 0.9 * t / 600.0
    seen = clock_over(0.3 * np.exp(-1j * (2.7 * t + 0.45 * t**2 / 600.0)))
    assert max(abs(state.speed - true) for state, true in zip(seen[1000:], w[1000:], strict=True)) < 0.05


def test_clock_stands_still_without_waves_and_is_bounded() -> None:
    seen = clock_over(np.zeros(500, complex))
    assert seen[-1].speed == WP
    wild = clock_over(3.0 * np.exp(-20j * np.arange(2000)), bandwidth=0.6)
    assert all(1.5 <= state.speed <= 6.0 and 0.0 <= state.theta < 2.0 * math.pi for state in wild)


def test_mean_square_is_a_plain_mean_at_first() -> None:
    rates = np.array([0.5, 0.1, 0.3, 0.2])
    seen = clock_over(rates.astype(complex), memory=50.0)
    # weights 1 - exp(-1/n) instead of 1/n: the first sample alone, then near the mean
    assert seen[0].square == pytest.approx(0.25)
    assert seen[3].square == pytest.approx(np.mean(rates**2), rel=0.35)


@pytest.mark.parametrize("gamma", [1.0, 50.0])
@pytest.mark.parametrize("wp", [2.7, 3.6])
def test_clock_is_right_on_the_device_at_any_bandwidth_of_the_sea(device: gy.Plant, gamma: float, wp: float) -> None:
    """Unsmoothed rates would give 3.6 rad/s at gamma 1 and a peak of 3.14."""
    waves = lead_in(gy.realise(device, gy.SeaState(gamma=gamma, wp=wp), 100200, duration=600.0), Settings())
    record, _ = run_law(device, LoadAngle(), waves, Settings(dt=0.025), "load_angle")
    rates = record.states[:, PHI1_RATE] + 1j * record.states[:, PHI3_RATE]
    mean = np.mean([state.speed for state in clock_over(rates, bandwidth=0.15)[2000:]])
    assert mean == pytest.approx(wp, rel=0.08)


def test_easing_halves_at_either_limit() -> None:
    limits = Easing(motion=0.3, relative=2.0, recall=1.0)
    assert eased(limits, 0.0, 0.6, 3.0) == 1.0
    assert eased(limits, 0.3**2, 0.6, 3.0) == pytest.approx(0.5)  # 2 V/w = 0.4: the motion's limit counts
    assert eased(limits, 0.2**2, 0.3, 3.0) == pytest.approx(0.5)  # 2 V/w = 0.2: the relative one
