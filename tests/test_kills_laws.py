"""Laws in states made by hand: which way each of their parts pulls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers.rule_based.wave_clock import Easing, WaveClock, begin, eased, follow
from gyroctl.controllers.supervisor.rules import PRODUCE, UNLOAD, Rules, first_watch, observe
from gyroctl.harness.protocol import Measurement

WP, N, PERIOD = 3.14, 0.203 / 0.009, 0.1


def locked(t: float, V: float = 0.3, delta: float = -0.4, **changes: float) -> Measurement:
    """Ring in step with waves of 3.14 rad/s, float rates of size V turning with it at the load angle delta."""
    psi = WP * t
    turned = V * np.exp(1j * (delta - psi))
    y = Measurement(psi, WP, 0.97 * N * WP, 0.0, 0.0, float(turned.real), float(turned.imag))
    return y._replace(**changes)


def settled(law: Any, seconds: float = 150.0, **changes: float) -> Any:
    state = law.init()
    for i in range(round(seconds / PERIOD)):
        _, state = law.step(PERIOD * i, locked(PERIOD * i, **changes), state)
    return state


def test_float_s_rates_in_the_frame_of_the_ring_stand_still() -> None:
    """`load_angle`: the slow parts are V cos delta and V sin delta, whatever the ring's angle."""
    state = settled(gy.law("load_angle"))
    assert pytest.approx(0.3 * math.cos(-0.4), rel=1e-6) == state.U1
    assert pytest.approx(0.3 * math.sin(-0.4), rel=1e-6) == state.U3


def test_coupling_gives_a_torque_of_the_sign_of_the_slip_only() -> None:
    law = gy.law("coupling")
    state = settled(law)
    rng = np.random.default_rng(0)
    for _ in range(40):
        V, delta = rng.uniform(0.1, 0.6), rng.uniform(-3.0, 3.0)
        couplings = []
        for slip in (4.0, -4.0):  # ring ahead of the flywheel, and behind
            y = locked(150.0, V, delta, omega_rate=N * WP - slip)
            (cc, _), _ = law.step(150.0, y, state)
            couplings.append(cc)
        assert min(couplings) == 0.0 < max(couplings), "whatever torque is wanted, one sign of the slip gives it"
    still = {"phi1_rate": 0.0, "phi3_rate": 0.0, "psi_rate": WP + 1.0}
    (braked, _), _ = law.step(150.0, locked(150.0, omega_rate=N * (WP + 1.0) - 4.0, **still), state)
    assert braked > 0.0, "a ring ahead of the waves is braked"


@pytest.mark.parametrize("wp", [2.6, 3.6])
def test_clock_finds_the_frequency_of_the_waves(wp: float) -> None:
    settings = WaveClock(bandwidth=0.12, memory=30.0)
    clock = begin(settings)
    for i in range(3000):
        turned = 0.3 * np.exp(-1j * wp * PERIOD * i)
        y = Measurement(wp * PERIOD * i, wp, 60.0, 0.0, 0.0, float(turned.real), float(turned.imag))
        clock = follow(settings, PERIOD, y, clock)
    assert clock.speed == pytest.approx(wp, rel=1e-3)


def test_load_is_halved_at_the_amplitude_that_says_so() -> None:
    easing = Easing(motion=0.3, relative=1e3, recall=2.0)
    loads = [eased(easing, swing, 0.3, WP) for swing in (0.0, 0.09, 0.36)]
    assert loads == pytest.approx([1.0, 0.5, 1.0 / 17.0])


def test_stabiliser_softens_the_coupling_while_the_ring_runs_ahead() -> None:
    law = gy.law("stabiliser")
    state = settled(law)
    (steady, _), _ = law.step(150.0, locked(150.0), state)
    (ahead, more), _ = law.step(150.0, locked(150.0, psi_rate=WP + 0.5), state)
    (behind, less), _ = law.step(150.0, locked(150.0, psi_rate=WP - 0.5), state)
    assert ahead < steady < behind
    assert more > less, "and the generator takes more from a ring that runs ahead"


def test_threshold_keeps_its_level_between_the_two() -> None:
    law = gy.law("threshold")
    between = 0.5 * (law.speed_low + law.speed_high)
    loaded = settled(law)
    eased_ = loaded._replace(eased=1.0)
    after = {}
    for name, state, part in (("lost", loaded, 0.8), ("back", eased_, 1.0)):
        _, new = law.step(150.0, locked(150.0, psi_rate=part * WP), state._replace(ring=part * WP))
        after[name] = new.eased
    assert after == {"lost": 1.0, "back": 0.0}
    kept = [state._replace(ring=between * WP) for state in (loaded, eased_)]
    for i in range(80):
        t = 150.0 + PERIOD * i
        seen = locked(t, psi_rate=between * WP + 1e-9 * i)  # no sensor tells the same twice to the bit
        kept = [law.step(t, seen, state)[1] for state in kept]
    assert [state.eased for state in kept] == [0.0, 1.0]


def test_supervisor_unloads_a_ring_that_falls_behind() -> None:
    rules, watch = Rules(), first_watch()
    for i in range(100):
        watch = observe(rules, PERIOD, locked(PERIOD * i), watch)
    assert watch.mode == PRODUCE and watch.unloads == 0.0
    for i in range(100, 200):
        watch = observe(rules, PERIOD, locked(PERIOD * i, psi_rate=0.5 * WP), watch)
        if watch.mode != PRODUCE:
            break
    assert watch.mode == UNLOAD and watch.unloads == 1.0
