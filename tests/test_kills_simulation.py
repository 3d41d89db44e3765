"""Metrics by hand: production, what the motor took and when it is paid for, motion of both joints, wave power."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PHI1, PHI3, PSI
from gyroctl.simulation.lock import phase_of_moment
from gyroctl.simulation.metrics import Record, evaluate, production
from gyroctl.waves import prepare
from gyroctl.waves.energy import wave_power

WP, PERIOD, SAMPLES = 3.14, 0.1, 1000


def made(device: gy.Plant, psi: np.ndarray, net: np.ndarray, **motion: np.ndarray) -> Record:
    """A run with that ring angle and that energy of the generator; the waves feed it, the rest is still."""
    n = len(device.labels)
    states = np.zeros((SAMPLES + 1, n + len(LEDGER)))
    states[:, PSI], states[:, OMEGA_RATE] = psi, 60.0
    states[:, n + LEDGER.index("generator")] = net
    states[:, n + LEDGER.index("wave_input")] = 2.0 * np.abs(net) + np.arange(SAMPLES + 1.0)
    for row, values in motion.items():
        states[:, {"phi1": PHI1, "phi3": PHI3}[row]] = values
    controls = np.full((SAMPLES, 2), (0.05, 3e-4))
    return Record(states, controls, controls, PERIOD, 0)


def judged(device: gy.Plant, record: Record, **more: bool) -> dict[str, float]:
    moment = np.cos(WP * 0.05 * np.arange(2 * SAMPLES + 1))
    return evaluate(device, record, moment, 0.05, WP, 0.0, 20.0, **more)


TIME = PERIOD * np.arange(SAMPLES + 1)


def test_production_ends_where_a_motor_drives() -> None:
    net = 2.0 * TIME - 6.0 * np.clip(TIME - 40.0, 0.0, 1.0)  # the motor drives from 40 to 41 s
    found = production(WP * TIME, net, PERIOD, WP)
    span = round(10.0 / PERIOD)
    assert not found[:span].any()
    assert found[span : round(40.0 / PERIOD) + 1].all()
    assert not found[round(40.2 / PERIOD) : round(50.9 / PERIOD)].any()
    assert found[round(51.1 / PERIOD) :].all()
    assert not production(0.4 * WP * TIME, net, PERIOD, WP).any(), "a ring below half the waves' speed produces nothing"


def test_energy_of_the_motor_is_paid_for(device: gy.Plant) -> None:
    net = np.where(TIME < 20.0, -5.0 * TIME, -100.0 + 2.0 * (TIME - 20.0))  # 100 J spent, 2 W from 20 s on
    found = judged(device, made(device, WP * TIME, net), from_rest=True)
    assert found["motor_energy"] == pytest.approx(100.0)
    assert found["net_energy"] == pytest.approx(net[-1]) and net[-1] == pytest.approx(60.0)
    assert found["payback_time"] == pytest.approx(70.0, abs=0.11)
    assert found["lock_begins"] == pytest.approx(30.0, abs=0.11)
    debt = judged(device, made(device, WP * TIME, -1.0 * TIME), from_rest=True)
    assert debt["net_energy"] == pytest.approx(-100.0)
    assert np.isnan(debt["payback_time"]) and np.isnan(debt["lock_begins"])


def test_either_joint_leaves_the_model_to_either_side(device: gy.Plant) -> None:
    ring, net = WP * TIME, 2.0 * TIME
    once = np.where(TIME == TIME[500], 1.0, 0.0)
    for joint in ("phi1", "phi3"):
        for size, outside in ((0.31, 1.0), (-0.31, 1.0), (0.29, 0.0)):
            found = judged(device, made(device, ring, net, **{joint: size * once}))
            assert found["outside_model"] == outside, (joint, size)


def test_motion_is_the_98_percent_quantile_of_either_side(device: gy.Plant) -> None:
    ramp = np.linspace(0.0, 0.2, SAMPLES + 1)
    found = judged(device, made(device, WP * TIME, 2.0 * TIME, phi1=-ramp, phi3=0.5 * ramp))
    assert found["phi1_p98"] == pytest.approx(0.196, rel=1e-6)
    assert found["phi3_p98"] == pytest.approx(0.098, rel=1e-6)


def test_stall_is_lost_and_a_turning_ring_is_not(device: gy.Plant) -> None:
    turning = judged(device, made(device, WP * TIME, 2.0 * TIME))
    stalled = judged(device, made(device, WP * np.minimum(TIME, 50.0), 2.0 * TIME))
    assert turning["locked"] == 1.0 and np.isnan(turning["loss_time"])
    assert stalled["locked"] == 0.0 and 50.0 < stalled["loss_time"] < 60.0


def test_wave_power_is_that_of_the_textbook(device: gy.Plant) -> None:
    """Deep water: rho g^2 H^2 T / (32 pi) for a regular wave, and by group speed at a finite depth."""
    regular = prepare(device, gy.Regular(0.2, WP), 100.0)
    period = 2.0 * np.pi / WP
    assert wave_power(regular) == pytest.approx(1000.0 * 9.81**2 * 0.2**2 * period / (32.0 * np.pi), rel=1e-12)
    irregular = prepare(device, gy.SeaState(), 100.0)
    energy_period = 0.9 * period  # between those of gamma 1 and of a single wave
    expected = 1000.0 * 9.81**2 * 0.283**2 * energy_period / (64.0 * np.pi)
    assert wave_power(irregular) == pytest.approx(expected, rel=0.05)


def test_hash_tells_phases_apart(device: gy.Plant) -> None:
    """Excitation with its phases and by magnitudes alone is not the same device, even where the table is."""
    other = gy.zhang2017(excitation_phase="magnitude")
    assert device.excitation.sha256 != other.excitation.sha256
    assert gy.realise(device, gy.SeaState(), 1, 10.0).sha256 != gy.realise(other, gy.SeaState(), 1, 10.0).sha256


def test_phase_of_the_waves_begins_where_the_turns_are_counted() -> None:
    """A regular wave: its phase is known at every instant, and the ring that keeps it slips nowhere."""
    time = np.arange(0.0, 200.0, 0.05)
    waves = np.cos(3.14 * time + 0.4)
    for first in (0, 607):
        phase = phase_of_moment(waves, 0.05, 3.14, first, 1600, 0.1)
        at = np.arange(first, 1600) * 0.1
        inner = (at > 40.0) & (at < 120.0)
        error = np.angle(phase.phasor * np.exp(-1j * (3.14 * at + 0.4)))
        np.testing.assert_allclose(error[inner], 0.0, atol=0.05)
        assert phase.slips(3.14 * at) == 0 and phase.turns(3.14 * at) == pytest.approx(1.0, abs=2e-3)


def test_phase_of_the_waves_does_not_depend_on_the_type_of_their_numbers() -> None:
    waves = np.round(1000.0 * np.cos(3.14 * np.arange(0.0, 100.0, 0.05)))
    phases = [
        phase_of_moment(waves.astype(kind), 0.05, 3.14, 10, 900, 0.1) for kind in (np.float64, np.float32, np.int64)
    ]
    for phase in phases[1:]:
        np.testing.assert_array_equal(phase.phasor, phases[0].phasor)
