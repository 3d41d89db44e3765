"""Orbits followed beyond the linear model: exact derivatives, the device of its own, damping in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.orbits.choices import TERMS, signals_in_other_time
from gyroctl.orbits.continuation import continue_orbit
from gyroctl.orbits.flow import Forcing
from gyroctl.orbits.orbit_map import OrbitMap
from gyroctl.orbits.search import search_orbit
from gyroctl.orbits.sensitivity import PARAMETERS, in_other_time, time_scales
from gyroctl.orbits.symmetry import free_rows
from gyroctl.plant.equations import OMEGA_RATE, PSI_RATE, derivative
from gyroctl.plant.near import near_signals
from gyroctl.plant.parameters import FURTHER

WAVE = gy.Regular(height=0.2, wp=3.14)
PAIR = 0.06, 1e-3
REST: dict[str, Any] = {
    "wetted": "reduced",
    "drag": 0.5,
    "coupling_slip": 20.0,
    "coupling_cap": 2.0,
    "bearing": 0.01,
    "windage": 9.1e-7,
    "rolling_resistance": 1e-5,
}
MOVING: dict[str, Any] = {"position": "moving", "drag": 0.5}
SMALL = {"cc": 1e-5, "cg": 1e-6, "d1": 1e-2, "k1": 1e-1, "N": 1e-4, "height": 1e-5, "wp": 1e-4, "phase": 1e-3}


def step_of(name: str, value: float) -> float:
    return SMALL.get(name, 1e-3 * value)


def derivatives(orbit_map: OrbitMap, x: NDArray[np.float64], h: float) -> tuple[NDArray[np.float64], ...]:
    """By complex step, and by differences of fourth order."""
    value = orbit_map.value(orbit_map.parameters[0])

    def image(shift: float) -> NDArray[np.float64]:
        return orbit_map.evaluate(x, np.array([value + shift]), derivative=False).image

    exact = orbit_map.evaluate(x, np.array([value])).by_parameter[:, 0]
    return exact, (8 * (image(h) - image(-h)) - (image(2 * h) - image(-2 * h))) / (12 * h)


@pytest.mark.slow
def test_derivatives_by_all_parameters_are_those_of_the_map() -> None:
    plant = gy.zhang2017(**REST)
    found = search_orbit(plant, WAVE, *PAIR)
    assert found.status == "stable"
    x = found.x[free_rows(plant)]
    for name in set(PARAMETERS) - {"phase"}:
        orbit_map = OrbitMap(plant, found.wave, *PAIR, parameters=(name,))
        exact, difference = derivatives(orbit_map, x, step_of(name, orbit_map.value(name)))
        size = max(float(np.max(np.abs(exact))), 1e-4)
        np.testing.assert_allclose(exact, difference, rtol=1e-5, atol=2e-6 * size, err_msg=name)


@pytest.mark.parametrize("name", ["wp", "phase", "drag", "height"])
def test_derivatives_where_the_float_moves(name: str) -> None:
    """The waves' lengths change with their frequency, and the phase at every position; cubics are renewed."""
    plant = gy.zhang2017(**MOVING)
    found = search_orbit(plant, WAVE, *PAIR)
    orbit_map = OrbitMap(plant, found.wave, *PAIR, parameters=(name,))
    exact, difference = derivatives(orbit_map, found.x[free_rows(plant)], step_of(name, orbit_map.value(name)))
    np.testing.assert_allclose(exact, difference, atol=2e-3 * np.max(np.abs(exact)))


@pytest.mark.parametrize(("choices", "names"), [(REST, {*PARAMETERS} - {"phase"}), (MOVING, {"wp", "phase", "drag"})])
def test_map_in_real_water_is_that_of_the_moved_device(choices: dict[str, Any], names: set[str]) -> None:
    """By constants in the kernel and signals made anew, or as a plant of its own."""
    plant = gy.zhang2017(**choices)
    found = search_orbit(plant, WAVE, *PAIR)
    x = found.x[free_rows(plant)]
    for name in names:
        orbit_map = OrbitMap(plant, found.wave, *PAIR, parameters=(name,))
        values = np.array([1.03 * orbit_map.value(name)])
        moved = orbit_map.moved({name: float(values[0])})
        assert moved.value(name) == pytest.approx(values[0], rel=1e-12)
        there, own = orbit_map.evaluate(x, values, False), moved.over(()).evaluate(x, np.empty(0), False)
        np.testing.assert_allclose(there.image, own.image, rtol=1e-9, atol=1e-11, err_msg=name)
        signals = Forcing.of(moved.plant, moved.wave).amplitude
        np.testing.assert_allclose(orbit_map.setting(values).forcing.amplitude, signals, rtol=1e-12, err_msg=name)


def test_equations_in_another_unit_of_time_are_the_same_motion() -> None:
    """With tau = alpha t rates are 1/alpha and accelerations 1/alpha^2 of what they were: no constant is forgotten."""
    plant, alpha = gy.zhang2017(position="moving", **{**REST, "coupling_cap": 0.7}), 1.25
    k, n = plant.coefficients, len(plant.labels)
    rng = np.random.default_rng(4)
    x = 0.1 * rng.standard_normal(n)
    x[[OMEGA_RATE, PSI_RATE]] = 1.7, 0.3  # slow: where bearing, rolling and drag change their sign
    signals = rng.standard_normal(len(plant.channels)) * np.where(np.isin(plant.channels, ("u", "w")), 0.05, 5.0)

    def rate(k: Any, x: NDArray[np.float64], cc: float, cg: float, signals: NDArray[np.float64]) -> NDArray[np.float64]:
        dx = np.empty(n + len(plant.ledger))
        near = near_signals(k.beyond, x, signals)
        derivative(x, dx, 1, 0, k, cc, cg, signals[0], signals[1], k.beyond, near)
        return dx[:n]

    scales = time_scales(k, complex(alpha)).real
    plain = rate(k, x, 0.02, 1e-3, signals)
    slower = signals * signals_in_other_time(plant.channels, alpha)
    other = rate(in_other_time(k, alpha), x * scales, 0.02 / alpha, 1e-3 / alpha, slower)
    np.testing.assert_allclose(other, plain * scales / alpha, rtol=1e-12)


def test_a_choice_that_is_off_is_followed_from_zero() -> None:
    """From no drag at all on: at zero the orbit is that of the device without it."""
    device = gy.zhang2017()
    orbit = gy.lock_orbit(device, WAVE, *PAIR)
    branch = continue_orbit(orbit, "drag", (0.0, 0.6))
    assert branch.values.min() == pytest.approx(0.0, abs=1e-12) and branch.values.max() == pytest.approx(0.6)
    first, last = (branch.orbit(int(i)) for i in (np.argmin(branch.values), np.argmax(branch.values)))
    np.testing.assert_allclose(first.x, orbit.x, atol=1e-8)
    np.testing.assert_allclose(first.multipliers[:4], orbit.multipliers[:4], atol=1e-6)
    assert first.power == pytest.approx(orbit.power, rel=1e-8) and first.error < 1e-7
    np.testing.assert_allclose(last.x, gy.lock_orbit(device.replace(drag=0.6), WAVE, *PAIR).x, atol=1e-7)
    assert first.plant.parameters.drag == 0.0 and last.plant.parameters.drag == pytest.approx(0.6)


@pytest.mark.slow
def test_branch_in_the_frequency_ends_where_orbits_found_alone_do() -> None:
    """Above at a fold; below at a period doubling, which a device with the symmetry cannot have."""
    plant = gy.zhang2017(**MOVING)
    branch = continue_orbit(gy.lock_orbit(plant, WAVE, *PAIR), "wp", (2.5, 5.0))
    (fold,), double = branch.folds, max(branch.of_kind("period doubling"), key=lambda point: point.value)
    assert 2.5 < double.value < 3.14 < fold.value and double.error < 1e-9
    assert double.multiplier.real == pytest.approx(-1.0, abs=1e-9)

    def status(wp: float) -> str:
        return gy.lock_orbit(plant, gy.Regular(0.2, wp), *PAIR, nearest=False).status

    assert [status(part * fold.value) for part in (0.995, 1.005)] == ["stable", "no orbit"]
    assert [status(part * double.value) for part in (0.995, 1.005)] == ["unstable", "stable"]
    short = gy.lock_orbit(gy.zhang2017(wetted="reduced"), WAVE, *PAIR)
    with pytest.raises(gy.InputError, match="waves as short"):
        continue_orbit(short, "wp", (3.0, 9.0))


def test_what_cannot_be_followed_is_refused_in_one_line() -> None:
    device = gy.zhang2017()
    wave = search_orbit(device, WAVE, *PAIR).wave
    for name in ("coupling_slip", "coupling_cap"):
        with pytest.raises(gy.InputError, match="infinite"):
            OrbitMap(device, wave, *PAIR, parameters=(name,))
    with pytest.raises(gy.InputError, match="phases of the geometry"):
        OrbitMap(gy.zhang2017(wetted="reduced"), wave, *PAIR, parameters=("phase",))
    for choices in ({"wetted": "surface"}, {"contact": "friction"}):
        with pytest.raises(gy.InputError, match=r"plant\.smooth"):
            gy.lock_orbit(device.replace(**choices), WAVE, *PAIR)
    smooth = gy.zhang2017("realistic").smooth
    assert (smooth.parameters.wetted, smooth.parameters.contact) == ("reduced", "rolling")


def test_choices_cover_the_numbers_beyond_the_linear_model() -> None:
    assert set(TERMS) == set(FURTHER)
