"""Margins beyond the linear model: against the nonlinear simulation, closed forms, and orbits found alone."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop, settle_loop
from gyroctl.loop_margins.margins import channel_margins
from gyroctl.loop_margins.trial import try_loop
from gyroctl.nested import leaves, like
from gyroctl.orbits.flow import flow
from gyroctl.orbits.search import search_orbit
from gyroctl.plant.equations import OMEGA, PHI1_RATE, PHI3_RATE, PSI
from gyroctl.robustness.headroom import headroom, ramp
from gyroctl.robustness.regime import settle, simulate
from gyroctl.studies.margins import request
from gyroctl.studies.margins.drag_lock import DragLock, counted_in_a_sea, drag_that_locks, drags_to_count, undamped
from gyroctl.studies.margins.maps import GROWS, coupling_map
from gyroctl.studies.margins.request import Request
from gyroctl.studies.margins.water import (
    ALL,
    CHOICES,
    OSCILLATIONS,
    ChoiceMargins,
    damping_border,
    in_words,
    linear_plant,
    most,
    nearest,
    of_choice,
    with_choices,
)

WAVE = gy.Regular(height=0.2, wp=3.14)
PAIR = 0.052, 3.5e-4
SURGE: dict[str, Any] = {"position": "moving", "drag": 0.5}


@pytest.fixture(scope="module")
def everything() -> gy.Plant:
    return with_choices(gy.zhang2017(), ALL).replace(coupling_slip=60.0)


@pytest.fixture(scope="module")
def loop(everything: gy.Plant) -> LoopOrbit:
    return close_loop(everything, WAVE, gy.law("load_angle"))


@pytest.fixture(scope="module")
def asked(device: gy.Plant) -> Request:
    return request(device, WAVE.height, WAVE.wp, *PAIR)


@pytest.fixture(scope="module")
def lock(asked: Request) -> DragLock:
    return drag_that_locks(asked)


# --- a law in the loop -------------------------------------------------------------------------------------------


def test_multipliers_of_the_loop_are_those_of_differences_over_a_wave(loop: LoopOrbit) -> None:
    """Plant and law side by side, disturbed one by one and simulated over a wave: no derivative enters."""
    assert loop.status == "stable"
    flow, first = loop.flow, loop.law_states[0]

    def over_a_wave(z: NDArray[np.float64]) -> NDArray[np.float64]:
        n = flow.free.size
        x = loop.states[0] + flow.embedding @ z[:n]
        state = like(first, (np.array(leaves(first)) + z[n:]).tolist())
        end, state, _ = settle_loop(flow, loop.law, x, state, 1)
        return np.concatenate([(end - loop.states[0])[flow.free], np.array(leaves(state)) - np.array(leaves(first))])

    size, h = flow.free.size + len(leaves(first)), 1e-5
    assert np.max(np.abs(over_a_wave(np.zeros(size)))) < 1e-6
    columns = [(over_a_wave(h * unit) - over_a_wave(-h * unit)) / (2.0 * h) for unit in np.eye(size)]
    differences = np.linalg.eigvals(np.stack(columns, axis=1))
    for value in loop.multipliers[:5]:
        assert np.min(np.abs(differences - value)) < 3e-3, value


def test_gain_margin_of_a_law_holds_in_the_nonlinear_loop(loop: LoopOrbit) -> None:
    found = channel_margins(loop, "cg")
    assert math.isfinite(found.gain[1]) and 0.0 < found.disk <= 2.0
    inside, outside = (try_loop(loop, "cg", gain=part * found.gain[1]) for part in (0.95, 1.05))
    assert inside.stable and inside.growth < 1.0
    assert not outside.stable and outside.growth > 1.0


def test_what_is_added_to_a_moment_acts_the_same_in_any_water() -> None:
    """The inertia alone says what a moment does at an instant, wherever the float is."""
    plant, linear = gy.zhang2017(**SURGE), gy.zhang2017()
    model = gy.lock_orbit(plant, WAVE, *PAIR).linearise()
    _, B = model.continuous()
    assert B.shape == (model.samples, len(model.states), 4)
    for k in (0, 7):
        _, expected = linear.jacobians(model.orbit[k], PAIR, (0.0, 0.0))
        np.testing.assert_allclose(B[k][:, 2:], expected[model.flow.free][:, 2:], rtol=1e-9, atol=1e-12)


# --- plain simulation --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("choices", [SURGE, {"wetted": "reduced", "drag": 0.5}])
def test_regime_in_real_water_is_the_orbit(choices: dict[str, Any]) -> None:
    plant = gy.zhang2017(**choices)
    orbit = gy.lock_orbit(plant, WAVE, *PAIR)
    regime = settle(orbit, WAVE)
    assert regime.power == pytest.approx(orbit.power, rel=1e-4)
    run, courses = simulate(regime, regime.x, 1.0), orbit.states(256)
    phase = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    for row in (PHI1_RATE, PHI3_RATE):
        expected = np.interp(run.phase, phase, courses[:, row], period=2.0 * np.pi)
        np.testing.assert_allclose(run.record[:, row], expected, atol=2e-3 * np.max(np.abs(courses[:, row])))


@pytest.mark.slow
def test_height_headroom_in_real_water_is_that_of_a_sinking_wave() -> None:
    """All signals sink together: positions, velocities of the water, moments."""
    plant = gy.zhang2017(**SURGE)
    least = headroom(gy.lock_orbit(plant, WAVE, 0.052, 2e-3), WAVE, "height", False).limit
    wave = gy.Regular(1.03 * least, 3.14)
    near = settle(gy.lock_orbit(plant, wave, 0.052, 2e-3), wave)
    assert ramp(near, "height", 1.03 * least, 0.97 * least, periods=600) == pytest.approx(least, rel=0.015)


def test_swing_at_half_the_frequency_of_the_wave_grows_where_the_float_moves() -> None:
    """Parametric resonance, which symmetry forbids: each wave turns the disturbance round and lets it grow."""
    plant, wave = gy.zhang2017(**SURGE), gy.Regular(0.2, 2.6)
    orbit = gy.lock_orbit(plant, wave, *PAIR)
    largest = orbit.multipliers[0]
    assert orbit.status == "unstable" and largest.real < -1.0 and abs(largest.imag) < 1e-9
    assert "half the frequency" in orbit.advice
    mode = orbit.mode("horizontal")
    assert mode.frequency == pytest.approx(0.5 * 2.6, rel=1e-9) and mode.rate > 0.0
    n, state, apart = orbit.x.size, orbit.x.copy(), []
    state[PHI1_RATE] += 1e-6
    for _ in range(24):
        state = np.real(flow(plant, state, *PAIR, orbit.forcing, 1.0)[:n])
        state[[PSI, OMEGA]] -= 2.0 * math.pi, state[OMEGA]
        apart.append(state[PHI1_RATE] - orbit.x[PHI1_RATE])
    ratios = np.array(apart[1:]) / np.array(apart[:-1])
    np.testing.assert_allclose(ratios[-4:], largest.real, rtol=0.02)
    found = coupling_map(plant, wave, [PAIR[0]], [PAIR[1]])
    assert found.code.tolist() == [[GROWS]]


# --- drag as damping ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("drag", [0.01, 0.1])
def test_drag_damps_phi1_as_its_equivalent_linear_damping(device: gy.Plant, drag: float) -> None:
    """A small motion on the forced one: the mean slope of |r| r1 is that of |r| + r1^2/|r| over a wave.

    For one harmonic of amplitude R alone it is the known 4 R/pi. What hinge damping does to the rate of the mode says
    what this damping is to do.
    """

    def rate(plant: gy.Plant) -> float:
        return gy.lock_orbit(plant, WAVE, *PAIR).mode("horizontal").rate

    plant = device.replace(drag=drag)
    orbit, parts = gy.lock_orbit(plant, WAVE, *PAIR), 64
    states, water = orbit.states(parts), orbit.forcing.amplitude[2:4]
    u, w = np.real(water[:, None] * np.exp(2j * np.pi * np.arange(parts) / parts))
    reach, rho = plant.geometry.reach, plant.geometry.rho  # type: ignore[union-attr]
    r1, r3 = reach * states[:, PHI1_RATE] - u, reach * states[:, PHI3_RATE] - w
    size = np.hypot(r1, r3)
    damping = 0.5 * rho * drag * 0.141 * reach**2 * float(np.mean(size + r1**2 / size))
    by_hinge = rate(device.replace(d1=2.5)) - rate(device.replace(d1=1.5))
    assert rate(plant) - rate(device) == pytest.approx(by_hinge * damping, rel=0.03)


def test_mean_slope_of_the_drag_of_one_harmonic() -> None:
    """The formula of the test above where the closed form is known."""
    r = 0.3 * np.cos(2.0 * np.pi * (np.arange(4096) + 0.5) / 4096)
    assert np.mean(np.abs(r) + r**2 / np.abs(r)) == pytest.approx(4.0 * 0.3 / math.pi, rel=1e-5)
    assert np.mean(r * np.abs(r) * r) / np.mean(r**2) == pytest.approx(8.0 * 0.3 / (3.0 * math.pi), rel=1e-5)


def test_drag_that_locks_is_where_a_disturbance_ceases_to_grow(device: gy.Plant, lock: DragLock) -> None:
    found = lock
    assert found.error < 1e-9
    status, growth = [], []
    for part in (0.97, 1.03):
        orbit = gy.lock_orbit(undamped(device, part * found.drag), WAVE, *PAIR)
        status.append(orbit.status)
        growth.append(_growth(orbit))
    assert status == ["unstable", "stable"]
    assert growth[0] > 1.0 > growth[1]


def test_drag_over_coupling_and_height_is_where_orbits_found_alone_change(device: gy.Plant, lock: DragLock) -> None:
    found = lock
    line = {line.over: line for line in found.curves}
    assert np.interp(0.052, line["cc"].at, line["cc"].drag) == pytest.approx(found.drag, rel=0.02)
    for over, at in (("cc", 0.12), ("height", 0.1)):
        drag = float(np.interp(at, line[over].at, line[over].drag))
        cc, wave = (at, WAVE) if over == "cc" else (0.052, gy.Regular(at, 3.14))
        sides = [gy.lock_orbit(undamped(device, part * drag), wave, cc, 3.5e-4).status for part in (0.95, 1.05)]
        assert sides == ["unstable", "stable"], over
    assert "Cd" in found.in_words() and f"{found.drag:.3g}" in found.in_words()


def _growth(orbit: gy.PeriodicOrbit) -> float:
    """Ratio of a small disturbance of phi1 late and early, over whole swings, by plain simulation."""
    n, apart, state = orbit.x.size, [], orbit.x.copy()
    state[PHI1_RATE] += 1e-4
    for _ in range(240):
        state = np.real(flow(orbit.plant, state, orbit.cc, orbit.cg, orbit.forcing, 1.0)[:n])
        state[[PSI, OMEGA]] -= 2.0 * math.pi, state[OMEGA]
        apart.append(math.hypot(state[0] - orbit.x[0], (state[PHI1_RATE] - orbit.x[PHI1_RATE]) / 1.2))
    return float(np.max(apart[-40:]) / np.max(apart[40:80]))


def test_no_drag_loses_lock_in_a_sea_and_drag_keeps_it(asked: Request) -> None:
    counts = [counted_in_a_sea(asked, drag, seeds=(1, 2, 3)) for drag in (0.0, 0.5)]
    assert [one.record()["locked"] for one in counts] == [0, 3]
    assert counts[0].phi1_p98 > 2.0 * counts[1].phi1_p98
    drags = drags_to_count(0.04)
    assert drags[0] == 0.0 and 0.04 in drags and list(drags) == sorted(drags)


# --- the study ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_borders_of_a_choice_are_where_orbits_found_alone_change(asked: Request) -> None:
    """The falling curve of the coupling: fold, border in hinge damping and in the coupling, a swing before the fold."""
    name = "coupling slip 20 rad/s"
    found, plant = of_choice(asked, name), with_choices(asked.plant, name)
    assert found.status == "stable" and found.slowest == "horizontal"
    mode = gy.lock_orbit(plant, WAVE, *PAIR).mode("horizontal")
    assert found.multiplier == pytest.approx(math.exp(mode.rate * 2.0 * math.pi / 3.14), rel=1e-9)
    assert found.damping_ratio == pytest.approx(-mode.rate / mode.frequency, rel=1e-4)
    sides = [search_orbit(plant, WAVE, 0.052, part * found.fold).status for part in (0.997, 1.003)]
    assert sides[0] != "no orbit" and sides[1] == "no orbit"
    assert found.cg_ending == "Neimark-Sacker" and found.cg_end < found.fold
    for part, expected in ((0.98, "unstable"), (1.02, "stable")):
        assert gy.lock_orbit(plant.replace(d1=part * found.d1_border), WAVE, *PAIR).status == expected
        assert gy.lock_orbit(plant, WAVE, part * found.cc_border, PAIR[1]).status == expected
        assert gy.lock_orbit(plant, WAVE, 0.052, found.cg_end / part).status == expected
        slower = gy.Regular(WAVE.height, part**0.2 * found.wp_end)
        assert gy.lock_orbit(plant, slower, *PAIR).status == expected


def test_drag_takes_the_place_of_hinge_damping(device: gy.Plant) -> None:
    """The border falls by what the drag is worth, beyond zero: from no drag on it is one line."""
    borders = [
        damping_border(gy.lock_orbit(undamped(device, drag).replace(d1=2.0), WAVE, *PAIR)) for drag in (0.02, 0.04, 0.3)
    ]
    assert borders[0] > 0.0 > borders[1] > borders[2]
    slope = (borders[1] - borders[0]) / 0.02
    assert (borders[2] - borders[1]) / 0.26 == pytest.approx(slope, rel=0.1)


def test_border_is_the_first_one_on_the_way_out_of_stability() -> None:
    points = [SimpleNamespace(value=value) for value in (-5.0, 1.0, 4.0)]
    branch: Any = SimpleNamespace(of_kind=lambda kind: points if kind == "Neimark-Sacker" else [])
    assert nearest(branch, OSCILLATIONS, 2.0, stable=True) == 1.0
    assert nearest(branch, OSCILLATIONS, -7.0, stable=False) == -5.0
    assert math.isnan(nearest(branch, OSCILLATIONS, -7.0, stable=True))
    assert math.isnan(nearest(branch, ("fold",), 2.0, stable=True))


def test_every_choice_of_the_study_has_an_orbit_map_and_starts_from_the_linear_plant(device: gy.Plant) -> None:
    assert linear_plant(device) == device and linear_plant(gy.zhang2017("realistic")).parameters == device.parameters
    for name in CHOICES:
        plant = with_choices(gy.zhang2017("realistic"), name)
        assert not plant.slips and plant.parameters.wetted != "surface"
        assert (plant.coefficients.beyond is None) == (name in ("linear", "efficiency 0.8")), name
    together = with_choices(device, ALL).parameters
    assert together == gy.zhang2017("realistic").smooth.parameters


def test_what_moves_most_is_told_of_single_choices_and_in_words() -> None:
    linear = ChoiceMargins("linear", "stable", 0.99, "horizontal", -0.002, 0.002, 1.2, 5e-3, 5e-3, "fold", 1.5, 0.04)
    linear = dataclasses.replace(linear, wp_end=2.71, wp_ending="Neimark-Sacker")

    def moved(**changes: Any) -> ChoiceMargins:
        return dataclasses.replace(linear, **changes)

    found = {
        "linear": linear,
        "drag 0.5": moved(
            rate=-0.09, damping_ratio=0.08, d1_border=-17.0, fold=4.95e-3, wp_end=2.8, wp_ending="period doubling"
        ),
        "bearing 0.01 Nm": moved(fold=4.8e-3),
        "windage 9.1e-7 Nms²": ChoiceMargins("windage", "no orbit"),
        ALL: moved(fold=4e-3, d1_border=-30.0, rate=-0.2),
    }
    told = {"fold": "bearing 0.01 Nm", "neimark_sacker": "drag 0.5", "phi1_damping": "drag 0.5"}
    assert most(found) == {**told, "frequency": "drag 0.5"}
    words = in_words(found)
    assert "Bearing 0.01 Nm alone moves the fold most, by -4.0 %" in words
    assert "-17 Nms/rad in place of 1.5" in words and "All smooth ones together move the fold by -20.0 %" in words
    assert "from 2.71 to 2.8 rad/s, where it ends by a period doubling" in words
    assert set(most({"linear": linear}).values()) == {""}
