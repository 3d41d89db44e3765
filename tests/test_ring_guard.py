"""The guard of the ring speed, a coupling whose torque falls, and both in water that turns the ring back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lock_numbers import J4, WP, N

import gyroctl as gy
from gyroctl.controllers.rule_based import Coupling
from gyroctl.controllers.rule_based.ring_guard import RingGuard, growing, held_up, straightened
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant.beyond import Curve, falling
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI_RATE
from gyroctl.plant.readings import unread

GUARD = RingGuard(floor=0.5, cc_guard=0.3)
LEAST = 0.5 * WP
LAW = Coupling()


def reading(psi_rate: float, omega_rate: float = 65.0) -> Measurement:
    """Ring and flywheel; the guard is told the float's rate beside."""
    return Measurement(0.0, psi_rate, omega_rate, 0.0, 0.0, 0.0, 0.0)


def change(device: gy.Plant, u3: float, omega_rate: float, cc: float, psi_rate: float = LEAST) -> float:
    """Acceleration of a ring, with moments by which the float's rate phi3' = u3 stays. [rad/s^2]"""
    x = np.zeros(len(device.labels))
    x[[PSI_RATE, OMEGA_RATE, PHI3_RATE]] = psi_rate, omega_rate, u3
    rates = [PHI1_RATE, PHI3_RATE]
    moments = np.zeros(2)
    at_rest = device.derivative(x, (cc, 0.0), moments)[rates]
    answers = [device.derivative(x, (cc, 0.0), one)[rates] - at_rest for one in np.eye(2)]
    moments = np.linalg.solve(np.array(answers).T, -at_rest)
    return float(device.derivative(x, (cc, 0.0), moments)[PSI_RATE])


@given(psi_rate=st.floats(-5.0, 8.0), u3=st.floats(-3.0, 3.0), cc=st.floats(0.0, 0.3))
def test_without_a_floor_a_law_keeps_its_coupling(psi_rate: float, u3: float, cc: float) -> None:
    assert held_up(RingGuard(), LAW, reading(psi_rate), u3, WP, cc) == cc


@given(psi_rate=st.floats(-5.0, 8.0), u3=st.floats(-3.0, 3.0), cc=st.floats(0.0, 0.3))
def test_guard_only_ever_couples_harder(psi_rate: float, u3: float, cc: float) -> None:
    held = held_up(GUARD, LAW, reading(psi_rate), u3, WP, cc)
    assert cc <= held <= max(cc, GUARD.cc_guard)
    if u3 <= 0.0:
        assert held == cc  # the float drives the ring


@pytest.mark.parametrize("u3", [0.05, 0.2, 0.4])
def test_ring_at_the_floor_keeps_its_speed(device: gy.Plant, u3: float) -> None:
    """Torques of (24) in the plant's own text: at a steady rate of the float the ring keeps its speed."""
    W = 65.0
    cc = held_up(GUARD, LAW, reading(LEAST, W), u3, WP, 0.0)
    assert 0.0 < cc < GUARD.cc_guard
    assert change(device, u3, W, cc) == pytest.approx(0.0, abs=0.02 * abs(change(device, u3, W, 0.0)))


@pytest.mark.parametrize("u3", [0.9, 1.1])
def test_ring_keeps_the_speed_by_which_its_contact_still_holds(device: gy.Plant, u3: float) -> None:
    """Pressed by J4 omega' psi', the contact of friction mu holds J4 omega' u3 while psi' > u3/mu, above the floor."""
    W, mu = 65.0, 0.5
    cc = held_up(GUARD._replace(friction=mu), LAW, reading(LEAST, W), u3, WP, 0.0)
    assert held_up(GUARD, LAW, reading(LEAST, W), u3, WP, 0.0) < cc < GUARD.cc_guard
    assert change(device, u3, W, cc, u3 / mu) == pytest.approx(0.0, abs=0.02 * abs(change(device, u3, W, 0.0, u3 / mu)))
    assert change(device, u3, W, cc, 0.95 * u3 / mu) > 0.0 > change(device, u3, W, cc, 1.05 * u3 / mu)


@pytest.mark.parametrize("over", [-0.01, 0.01])
def test_guard_looks_one_period_ahead(over: float) -> None:
    """The ring that the float would leave just above the floor, the coupling open, is not touched."""
    u3, W = 0.3, 65.0
    fall = LAW.period * J4 * W * u3 / GUARD.J2
    held = held_up(GUARD, LAW, reading(LEAST + fall + over, W), u3, WP, 0.01)
    assert (held > 0.01) == (over < 0.0)


@pytest.mark.parametrize(("slope", "carried"), [(1.5, 0.3), (0.0, 0.0), (-1.5, 0.0)])
def test_a_rate_that_grows_is_carried_on(slope: float, carried: float) -> None:
    """Of a float that moves in phi3 alone while the ring turns: u3 = cos psi phi3' is a straight line in time."""
    guard, last = RingGuard(floor=0.5, trend=0.2), unread()
    assert growing(guard, 0.1, 0.2, last) == 0.2  # nothing seen yet
    for psi, u3 in ((0.3, 0.2 - 0.1 * slope), (0.6, 0.2)):
        last, before = last._replace(psi=psi, phi3_rate=u3 / math.cos(psi), begun=1.0), last
    assert growing(guard, 0.1, 0.2, before) == pytest.approx(0.2 + carried)
    assert growing(RingGuard(floor=0.5), 0.1, 0.2, before) == 0.2


def test_guard_knows_the_inertia_of_the_ring(device: gy.Plant) -> None:
    assert RingGuard().J2 == pytest.approx(device.parameters.J2, rel=1e-3)


@given(slip=st.floats(-80.0, 80.0), cc=st.floats(1e-4, 0.3))
def test_a_coupling_that_falls_gives_the_torque_that_was_wanted(slip: float, cc: float) -> None:
    """Through the plant's own curve."""
    asked = straightened(20.0, slip, cc)
    assert falling(Curve(20.0), asked, slip) == pytest.approx(cc * slip, rel=1e-12, abs=1e-12)
    assert straightened(0.0, slip, cc) == cc


def test_law_asks_for_more_where_the_torque_falls() -> None:
    """In torque, not in command, it is the law that it was."""
    straight, bent = gy.law("coupling", cc_max=5.0), gy.law("coupling", cc_max=5.0, bend=20.0)
    seen = 0
    for number in range(40):
        y = Measurement(0.37 * number, 1.0 + 0.1 * number, 65.0, 0.01, 0.01, 0.2 * math.sin(number), 0.3)
        (one, _), _ = straight.step(0.0, y, straight.init())
        (other, _), _ = bent.step(0.0, y, bent.init())
        slip = N * y.psi_rate - y.omega_rate
        assert falling(Curve(20.0), other, slip) == pytest.approx(one * slip, rel=1e-9, abs=1e-12)
        seen += one > 0.0
    assert 5 < seen < 40


@pytest.mark.parametrize(("spared", "left"), [(0.0, 0.5), (0.4, 0.7), (1.0, 1.0)])
def test_a_part_of_the_generator_is_spared_from_easing(spared: float, left: float) -> None:
    """A sine of amplitude `motion` in phi1 halves what is eased."""
    law = gy.law("coupling", recall=20.0, relative=1e3, droop=0.0, spared=spared)
    powers = {}
    for amplitude in (0.0, law.easing.motion):
        state, seen = law.init(), []
        for i in range(4000):
            t = 0.1 * i
            turning = 0.3 * np.exp(-1j * (0.5 + WP * t))
            phi1 = (1e-9 + amplitude) * math.sin(WP * t)
            y = Measurement(WP * t, WP, 65.0, phi1, 1e-9 * t, float(turning.real), float(turning.imag))
            (_, cg), state = law.step(t, y, state)
            seen.append(cg)
        powers[amplitude] = np.mean(seen[2000:])
    assert powers[law.easing.motion] / powers[0.0] == pytest.approx(left, rel=0.01)


def lowest(law: Any, **changes: Any) -> float:
    """Lowest ring speed of a run in real water. [rad/s]"""
    plant = gy.zhang2017("realistic", wetted="reduced", **changes)
    settings = Settings(dt=0.01, actuators=Actuators(cc_lag=0.02))
    waves = lead_in(gy.realise(plant, gy.SeaState(), 100000, duration=300.0), settings)
    record, _ = run_law(plant, law, waves, settings)
    return float(record.states[:, PSI_RATE].min())


@pytest.mark.slow
def test_floor_keeps_the_ring_from_rolling_back_in_real_water() -> None:
    assert lowest(gy.law("coupling")) < 0.0
    assert lowest(gy.law("coupling", floor=0.5)) > 0.2 * WP


@pytest.mark.slow
def test_law_that_knows_the_curve_of_its_coupling_holds_the_ring() -> None:
    held = {"motion": 0.7, "floor": 0.5, "damping": 0.6, "cc_max": 0.3, "cc_guard": 0.3}
    assert lowest(gy.law("coupling", **held), coupling_slip=20.0) < 0.0
    assert lowest(gy.law("coupling", **held, bend=20.0), coupling_slip=20.0) > 0.2 * WP
