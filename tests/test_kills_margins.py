"""Margins and orbits against closed forms: the corners of the disk, both gain margins, a delay as a queue, advice."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.linearisation.periodic import output
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.margins import OpenedLoop, channel_margins, delayed_transition, open_loop
from gyroctl.orbits.flow import Forcing
from gyroctl.orbits.guess import harmonic_balance
from gyroctl.orbits.orbit import GROWS, RUNS_AWAY, LockProblem, describe
from gyroctl.orbits.search import search_orbit
from gyroctl.orbits.wave import Wave

WAVE = gy.Regular(height=0.2, wp=3.14)
CC, CG = 0.052, 3.5e-4


@pytest.fixture(scope="module")
def loop(device: gy.Plant) -> LoopOrbit:
    return close_loop(device, WAVE, gy.law("load_angle"))


@pytest.mark.parametrize("channel", ["cg", "phi3_rate"])
def test_guarantees_of_the_disk_are_its_corners(loop: LoopOrbit, channel: str) -> None:
    """The disk is (2 + alpha d)/(2 - alpha d), |d| < 1: walked round to the real axis and to the unit circle."""
    found = channel_margins(loop, channel)
    assert 0.3 < found.disk < 2.0, "so large that arc sine and arc tangent differ"
    d = np.exp(1j * np.linspace(0.0, math.pi, 200_001))
    border = (2.0 + found.disk * d) / (2.0 - found.disk * d)
    on_circle = border[np.argmin(np.abs(np.abs(border) - 1.0))]
    assert found.guaranteed_phase == pytest.approx(np.degrees(np.angle(on_circle)), rel=1e-4)
    assert found.guaranteed_gain == pytest.approx((border[-1].real, border[0].real), rel=1e-9)


def test_scalar_loop_has_the_margins_of_the_back_of_an_envelope() -> None:
    """x+ = (1.2 - 0.5 f) x is stable for f between 0.4 and 4.4, and for f on the unit circle up to cos = 0.575."""
    one = np.ones((1, 1, 1))
    opened = OpenedLoop(("v",), 1.2 * one, -0.5 * one, one)
    assert opened.gain_margin() == pytest.approx((0.4, 4.4), rel=1e-6)
    assert opened.phase_margin() == pytest.approx(math.degrees(math.acos(0.575)), rel=1e-6)
    z = np.exp(1j * np.linspace(0.0, math.pi, 20_001))
    sensitivity = 1.0 / (1.0 + 0.5 / (z - 1.2))
    assert opened.disk() == pytest.approx(1.0 / np.max(np.abs(sensitivity - 0.5)), rel=1e-6)
    assert OpenedLoop(("v",), 0.9 * one, -0.5 * one, one).gain_margin()[0] == 0.0, "a loop that may be cut"


@pytest.mark.parametrize(("channel", "whole"), [("cg", 1), ("cg", 3), ("psi_rate", 2)])
def test_delay_of_whole_samples_is_a_queue(loop: LoopOrbit, channel: str, whole: int) -> None:
    opened = open_loop(loop, (channel,))
    n = opened.A.shape[1]

    def turn(start: NDArray[np.float64]) -> NDArray[np.float64]:
        x, queue = start[:n], list(start[n:])
        for a, b, c in zip(opened.A, opened.B, opened.C, strict=True):
            queue.insert(0, float(c[0] @ x))  # v of now; the value of `whole` samples ago acts
            x = a @ x + b[:, 0] * queue[whole]
            queue.pop()
        return np.concatenate([x, queue])

    expected = np.stack([turn(row) for row in np.eye(n + whole + 1)], axis=1)
    np.testing.assert_allclose(
        delayed_transition(loop, channel)(whole * loop.flow.period), expected, rtol=1e-9, atol=1e-12
    )


def test_error_of_the_half_map_is_told(device: gy.Plant) -> None:
    """On the orbit the half map's square is the full map; beside it, it is not, and the number says so."""
    orbit = gy.lock_orbit(device, WAVE, CC, CG)
    wave = Wave(WAVE.height, WAVE.wp, WAVE.heading)
    beside = describe(LockProblem(device, CC, CG, 1, 0.01, wave), Forcing.of(device, wave), orbit.x + 0.05, 0.0)
    assert orbit.error < 1e-6 < 1e-3 < beside.error


def test_advice_tells_growing_from_running_away(device: gy.Plant) -> None:
    wave = Wave(WAVE.height, WAVE.wp, WAVE.heading)
    guesses = harmonic_balance(device, Forcing.of(device, wave), CC, CG, 1)
    found = [search_orbit(device, wave, CC, CG, guess=guess) for guess in guesses]
    (saddle,) = [orbit for orbit in found if orbit.status == "unstable"]
    assert saddle.multipliers[0].real > 1.0 and saddle.advice == RUNS_AWAY
    swings = gy.lock_orbit(device.replace(d1=0.0), WAVE, 0.02, CG)
    assert swings.status == "unstable" and abs(swings.multipliers[0].imag) > 0.01 and swings.advice == GROWS


def test_outputs_that_are_no_states_are_those_of_their_names(device: gy.Plant) -> None:
    x = np.random.default_rng(3).standard_normal(len(device.labels))
    psi, w, W, v1, v3 = (
        x[device.labels.index(name)] for name in ("psi", "psi_rate", "omega_rate", "phi1_rate", "phi3_rate")
    )
    turned = np.exp(1j * psi) * (v1 + 1j * v3)  # the float's rates in the frame of the ring
    expected = {"u1": turned.real, "u3": turned.imag, "slip": W - device.parameters.N * w, "power": 3e-4 * W**2}
    for name, value in expected.items():
        assert output(device, name, x, (0.05, 3e-4)) == pytest.approx(value), name


def test_heading_of_the_wave_is_that_of_its_moments(device: gy.Plant) -> None:
    def moments(heading: float) -> Any:
        return Forcing.of(device, Wave(0.3, 3.0, heading)).amplitude

    for heading in (0.0, 30.0, -75.0):
        expected = 0.15 * device.excitation(np.array([3.0]), heading)[:, 0]
        np.testing.assert_allclose(moments(heading), expected, rtol=1e-12)
    assert not np.allclose(moments(0.0), moments(30.0))
