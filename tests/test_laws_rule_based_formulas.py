"""Laws by rules: what all of them keep, and each one's formula against the lock balance and the sense of the slip."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lock_numbers import J4, WP, N
from rule_based_laws import LAWS

import gyroctl as gy
from gyroctl.controllers.rule_based import Constant, Coupling, LoadAngle, Stabiliser, Threshold, Tracking
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.harness.sensing import Sensors
from gyroctl.loop_margins.closed_loop_orbit import close_loop
from gyroctl.nested import leaves
from gyroctl.plant.equations import PHI1_RATE, PHI3_RATE, PSI

EASED = ("load_angle", "stabiliser", "tracking", "coupling")

measurements = st.builds(
    Measurement,
    psi=st.floats(-1e3, 1e3),
    psi_rate=st.floats(-5.0, 10.0),
    omega_rate=st.floats(-20.0, 150.0),
    phi1=st.floats(-1.0, 1.0),
    phi3=st.floats(-1.0, 1.0),
    phi1_rate=st.floats(-3.0, 3.0),
    phi3_rate=st.floats(-3.0, 3.0),
)


def locked(t: float, V: float, delta: float, omega_rate: float = 65.0, wp: float = WP) -> Measurement:
    """Float rate that stands still in the frame of a ring at wp: u1 + i u3 = V exp(i delta).

    Its angles are next to nothing, but never the same bits: a reading that repeats itself is taken for a lost one.
    """
    rate, angle = cmath.rect(V, delta - wp * t), 1e-9 * (1.0 + t)
    return Measurement(wp * t, wp, omega_rate, angle, angle, rate.real, rate.imag)


def settled(law: Any, seconds: float = 200.0, **reading: Any) -> Any:
    """State of a law that has seen a steady lock for a while."""
    state = law.init()
    for i in range(round(seconds / law.period)):
        _, state = law.step(law.period * i, locked(law.period * i, **reading), state)
    return state


# --- what every law must keep ------------------------------------------------------------------------------------


@given(first=measurements, second=measurements)
@pytest.mark.parametrize("name", LAWS)
def test_commands_stay_within_limits_and_finite(name: str, first: Measurement, second: Measurement) -> None:
    law = LAWS[name]
    state = law.init()
    for i, y in enumerate((first, second, first)):
        (cc, cg), state = law.step(0.1 * i, y, state)
        assert 0.0 <= cc <= 0.3
        assert 0.0 <= cg <= law.cg_max
        assert all(math.isfinite(value) for value in leaves(state))


@pytest.mark.parametrize("name", [*LAWS, "constant"])
def test_compiled_law_gives_the_same_bits_as_python(device: gy.Plant, name: str) -> None:
    law = LAWS.get(name, Constant())
    brief = Settings(blend=10.0)
    waves = lead_in(gy.realise(device, gy.SeaState(), 100000, duration=30.0), brief)
    compiled, _ = run_law(device, law, waves, brief)
    plain, _ = run_law(device, law, waves, brief, compiled=False)
    np.testing.assert_array_equal(compiled.commands, plain.commands)
    np.testing.assert_array_equal(compiled.states, plain.states)


@pytest.mark.parametrize("name", LAWS)
def test_law_has_a_linear_model_in_a_regular_wave(device: gy.Plant, name: str) -> None:
    """Its state is periodic and its step differentiable, through the clock as well."""
    loop = close_loop(device, gy.Regular(0.2, WP), LAWS[name])
    assert loop.status == "stable", loop.advice


@pytest.mark.parametrize("name", LAWS)
def test_law_scales_with_the_waves(name: str) -> None:
    """A steady lock in waves of half the height takes half the generator gain."""
    law = gy.law(name, motion=1e3) if name in EASED else LAWS[name]
    gains = []
    for V in (0.4, 0.2):
        state = settled(law, V=V, delta=-0.3, omega_rate=N * WP)
        (_, cg), _ = law.step(0.0, locked(200.0, V, -0.3, N * WP), state)
        gains.append(cg)
    assert gains[0] > 0.0
    assert gains[1] / gains[0] == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("name", EASED)
def test_load_eases_with_the_swing_of_the_float(name: str) -> None:
    """A sine of amplitude `motion` in phi1 halves the generator, where nothing else asks for it."""
    quiet = {
        "load_angle": {"damping": 0.0},
        "tracking": {"damping": 0.0},
        "coupling": {"droop": 0.0},
        "stabiliser": {"governor": 0.0, "stabiliser": 0.0},
    }[name]
    law = gy.law(name, recall=20.0, relative=1e3, **quiet)
    powers = {}
    for amplitude in (0.0, law.easing.motion):
        state = law.init()
        seen = []
        for i in range(4000):
            y = locked(0.1 * i, 0.3, -0.5)._replace(phi1=(1e-9 + amplitude) * math.sin(WP * 0.1 * i))
            (_, cg), state = law.step(0.1 * i, y, state)
            seen.append(cg)
        powers[amplitude] = np.mean(seen[2000:])
    assert powers[law.easing.motion] / powers[0.0] == pytest.approx(0.5, rel=0.01)


# --- load angle --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("delta", [-0.3, -1.2, 2.0])
def test_load_angle_takes_its_share_of_the_capacity(delta: float) -> None:
    law, V = LoadAngle(margin=0.0, share=0.4, damping=0.0), 0.3
    state = settled(law, V=V, delta=delta)
    (_, cg), _ = law.step(0.0, locked(200.0, V, delta), state)
    assert N * cg / (J4 * V) == pytest.approx(0.4, rel=1e-6)  # whatever the angle


@pytest.mark.parametrize(("delta", "kept"), [(-0.3, math.cos(0.3)), (-1.5, math.cos(1.5)), (-2.0, 0.0)])
def test_load_angle_margin_vanishes_at_pull_out(delta: float, kept: float) -> None:
    law, V = LoadAngle(share=0.0, margin=0.6, damping=0.0), 0.3
    state = settled(law, V=V, delta=delta)
    (_, cg), _ = law.step(0.0, locked(200.0, V, delta), state)
    assert cg == pytest.approx(0.6 * J4 / N * V * kept, abs=1e-9)


def test_load_angle_keeps_the_lock_balance_on_the_plant(device: gy.Plant) -> None:
    """In a regular wave <u3> = -N cg/J4 (24)-(25): the share that the law takes is what the load takes of V."""
    law = gy.law("load_angle", share=0.2, margin=0.0, damping=0.0, slow=20.0, motion=1e3, relative=1e3)
    waves = gy.realise(device, gy.Regular(height=0.2, wp=WP), 1, duration=600.0)
    record, _ = run_law(device, law, waves, Settings(sensors=Sensors.ideal(), blend=0.0))
    states = record.states[-1571:-1]  # 157 s: 78 waves and a half, so the mean holds within a percent
    u3 = np.sin(states[:, PSI]) * states[:, PHI1_RATE] + np.cos(states[:, PSI]) * states[:, PHI3_RATE]
    u1 = np.cos(states[:, PSI]) * states[:, PHI1_RATE] - np.sin(states[:, PSI]) * states[:, PHI3_RATE]
    V, cg = math.hypot(u1.mean(), u3.mean()), record.controls[-1571:, 1].mean()
    assert u3.mean() == pytest.approx(-N * cg / J4, rel=0.05)
    assert -u3.mean() / V == pytest.approx(0.2, rel=0.06)


@pytest.mark.parametrize(
    "make",
    [
        lambda: LoadAngle(share=0.0, margin=0.0, damping=0.8, lean=0.0, fast=1e-3),
        lambda: Tracking(share=0.0, margin=0.0, damping=0.8, lean=0.0, fast=1e-3),
        lambda: Stabiliser(share=0.0, governor=0.8, stabiliser=0.8, lean=0.0, lead=0.5, behind=0.5),
    ],
)
def test_generator_brakes_a_ring_that_is_faster_than_the_waves_only(make: Any) -> None:
    law, V = make(), 0.3
    state = settled(law, V=V, delta=-0.5)
    y = locked(200.0, V, -0.5)
    over = law.step(0.0, y._replace(psi_rate=WP + 0.5), state)[0][1]
    assert over == pytest.approx(0.8 * 0.5 * J4 * V / N, rel=1e-2)
    assert law.step(0.0, y._replace(psi_rate=WP - 0.5), state)[0][1] == 0.0  # a generator cannot drive


# --- stabiliser --------------------------------------------------------------------------------------------------


def deviations(law: Stabiliser, signal: Any) -> Any:
    """Generator gain over the capacity for a ring whose speed deviates by `signal` from that of the waves."""
    V, state, seen = 0.3, settled(law, V=0.3, delta=-0.5), []
    for i, value in enumerate(signal):
        y = locked(200.0 + 0.1 * i, V, -0.5)
        (_, cg), state = law.step(0.0, y._replace(psi_rate=WP + value + 1e-9 * i), state)  # no sensor repeats itself
        seen.append(N * cg / (J4 * V))
    return np.array(seen)


def test_washout_lets_a_lasting_deviation_go_and_the_governor_keep_it() -> None:
    base = {"share": 0.3, "lean": 0.0, "washout": 5.0, "lead": 0.4, "behind": 0.4, "cg_max": 1.0}
    washed = deviations(Stabiliser(governor=0.0, stabiliser=0.5, **base), np.full(600, 0.2))
    assert washed[0] == pytest.approx(0.3 + 0.5 * 0.2, rel=0.03)
    assert washed[-1] == pytest.approx(0.3, rel=1e-3)
    kept = deviations(Stabiliser(governor=0.5, stabiliser=0.0, **base), np.full(600, 0.2))
    assert kept[0] == pytest.approx(0.3, rel=0.02)
    assert kept[-1] == pytest.approx(0.3 + 0.5 * 0.2, rel=1e-3)


def test_lead_lag_turns_the_phase_as_its_transfer_function() -> None:
    """(1 + lead s)/(1 + behind s) times the washout, at 0.5 rad/s where a sample is short."""
    law = Stabiliser(share=0.3, lean=0.0, governor=0.0, stabiliser=0.5, washout=8.0, lead=2.0, behind=0.5, cg_max=1.0)
    t = 0.1 * np.arange(4000)
    answer = deviations(law, 0.1 * np.sin(0.5 * t))[2000:] - 0.3
    reference = np.exp(0.5j * t[2000:])
    found = 2.0 * np.mean(answer * np.conj(reference)) / (0.1 / 1j)
    s = 0.5j
    assert found == pytest.approx(0.5 * (8.0 * s / (1 + 8.0 * s)) * (1 + 2.0 * s) / (1 + 0.5 * s), rel=0.06)


# --- tracking ----------------------------------------------------------------------------------------------------


def test_tracking_lets_go_of_a_ring_a_quarter_turn_behind_and_softens_the_coupling() -> None:
    law = Tracking(share=0.0, margin=0.3, damping=0.0, stiff=0.08, soften=0.5, rise=0.0, fast=1e-3)
    found = {}
    for delta in (0.0, -1.0, -0.5 * math.pi - 0.1):
        state = settled(law, V=0.3, delta=delta)
        found[delta], _ = law.step(0.0, locked(200.0, 0.3, delta), state)
    for delta, (cc, cg) in found.items():
        kept = max(math.cos(delta), 0.0)
        assert cg == pytest.approx(0.3 * J4 * 0.3 / N * kept, rel=0.02, abs=1e-9)
        assert cc == pytest.approx(0.08 * (1.0 - 0.5 * (1.0 - kept)), rel=0.02)


@pytest.mark.parametrize("wp", [2.7, 3.6])
def test_tracking_schedules_the_coupling_on_the_frequency(wp: float) -> None:
    law = Tracking(stiff=0.06, soften=0.0, rise=2.0)
    state = settled(law, seconds=400.0, V=0.3, delta=-0.3, wp=wp)
    (cc, _), _ = law.step(0.0, locked(400.0, 0.3, -0.3, wp=wp), state)
    assert cc == pytest.approx(0.06 * (wp / WP) ** 2, rel=0.01)


# --- threshold ---------------------------------------------------------------------------------------------------


def test_threshold_keeps_its_level_between_the_thresholds() -> None:
    law = Threshold(speed_low=0.9, speed_high=0.96, fast=1e-3, used_high=10.0, used_low=9.0)
    state, levels = settled(law, V=0.3, delta=-0.3), []
    for part in (1.0, 0.93, 0.88, 0.93, 0.95, 0.97, 0.93, 0.91):
        y = locked(200.0, 0.3, -0.3)._replace(psi_rate=part * WP)
        (cc, cg), state = law.step(0.0, y, state)
        levels.append(state.eased)
        full = law.share * J4 / N * math.sqrt(state.clock.square)
        assert cg == pytest.approx(full * (law.eased if state.eased else 1.0))
        assert cc == (law.cc_eased if state.eased else law.cc_full)
    assert levels == [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]


def test_threshold_eases_when_the_capacity_falls_below_the_load() -> None:
    """The float's rate leaves the frame of the ring: V of the sea is the same, the ring's capacity goes."""
    law = Threshold(share=0.4, used_high=0.8, used_low=0.5, brisk=1.0)
    state = settled(law, V=0.3, delta=-0.3)
    assert state.eased == 0.0
    for i in range(200):
        rate = cmath.rect(0.3, 5.0 * 0.1 * i)  # against the sense of the ring
        y = locked(200.0 + 0.1 * i, 0.3, 0.0)._replace(phi1_rate=rate.real, phi3_rate=rate.imag)
        _, state = law.step(0.0, y, state)
    assert math.hypot(state.U1, state.U3) < 0.4 * 0.3 / 0.8
    assert state.eased == 1.0


# --- coupling ----------------------------------------------------------------------------------------------------


@given(y=measurements)
def test_coupling_gives_the_wanted_torque_where_the_slip_allows(y: Measurement) -> None:
    law = Coupling()
    (cc, _), _ = law.step(0.0, y, law.init())
    V = max(math.hypot(y.phi1_rate, y.phi3_rate), 0.01)
    turn = complex(math.cos(y.psi), math.sin(y.psi))
    from1, from3 = turn * y.phi1_rate, turn * 1j * y.phi3_rate  # u1 + i u3, from each direction of the float
    swing = (1.0 - math.exp(-0.1 / law.easing.recall)) * 2.0 * y.phi1**2
    drive = law.through1 * from1.imag + law.through3 * from3.imag
    across = law.direct1 * from1.real + law.direct3 * from3.real
    _, new = law.step(0.0, y, law.init())
    ease = 1.0 / (1.0 + (swing / min(law.easing.motion, law.easing.relative * V / new.clock.speed) ** 2) ** 2)
    synchronising = ease * law.margin * max((from1 + from3).real, 0.0)
    wanted = J4 * y.omega_rate * (synchronising + across - drive + law.damping * V * (y.psi_rate - new.clock.speed))
    slip = N * y.psi_rate - y.omega_rate
    given_torque = N * cc * slip  # against the ring, right-hand side of (24) with its sign turned
    assert 0.0 <= cc <= law.cc_max
    if abs(wanted) < 1e-6 or abs(slip) < 1e-6:
        return
    if wanted * slip < 0.0:
        assert cc == 0.0
    elif abs(wanted) < law.cc_max * N * abs(slip) * (1.0 - 1e-9):
        assert given_torque == pytest.approx(wanted, rel=1e-6)
    else:
        assert cc == pytest.approx(law.cc_max)


def test_coupling_regulates_the_flywheel_by_a_droop() -> None:
    """Without mean slip the power is `level` of J4 omega' V w; each N V of speed above it adds `droop`."""
    law, V = gy.law("coupling", motion=1e3, relative=1e3), 0.3
    state = settled(law, seconds=400.0, V=V, delta=-0.3, omega_rate=N * WP)
    for over in (0.0, 0.2, -0.5):
        y = locked(400.0, V, -0.3, omega_rate=N * (WP + over * V))
        (_, cg), _ = law.step(0.0, y, state)
        expected = (law.level + over * law.droop) * J4 * y.omega_rate * V * WP
        assert cg * y.omega_rate**2 == pytest.approx(expected, rel=2e-3)
    (_, cg), _ = law.step(0.0, locked(400.0, V, -0.3, omega_rate=-1e-6), state)
    assert cg == 0.0  # a flywheel at rest is left alone
