"""The orbit as an object: exact derivatives, multipliers three ways, named modes, the nearest wave with an orbit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.orbits.choices import TERMS
from gyroctl.orbits.flow import Forcing, flow
from gyroctl.orbits.modes import segment_jacobians
from gyroctl.orbits.monodromy import METHODS, monodromy
from gyroctl.orbits.orbit_map import OrbitMap, ShiftedExcitation
from gyroctl.orbits.sensitivity import PARAMETERS, in_other_time, with_gear
from gyroctl.orbits.symmetry import free_rows, reflect
from gyroctl.orbits.wave import Wave
from gyroctl.plant.kernel import slip_rate

WAVE = gy.Regular(height=0.2, wp=3.14)
LINEAR = tuple(name for name in PARAMETERS if name not in TERMS)
SMALL = {"cc": 1e-5, "cg": 1e-6, "d1": 1e-2, "k1": 1e-1, "N": 1e-4, "height": 1e-5, "wp": 1e-4, "phase": 1e-3}


@pytest.fixture(scope="module", params=[(0.052, 1e-3), (0.1, 4e-3), (0.3, 3e-3)], ids=str)
def orbit(request: pytest.FixtureRequest, device: gy.Plant) -> gy.PeriodicOrbit:
    return gy.lock_orbit(device, WAVE, *request.param)


# --- derivatives -------------------------------------------------------------------------------------------------


def test_every_constant_of_the_equations_has_its_power_of_time(device: gy.Plant) -> None:
    """The derivative by the frequency changes the unit of time: a constant that it does not know makes it wrong."""
    powers = {"k1": 2, "k3": 2, "d1": 1, "d3": 1}
    timeless = {"i1", "i3", "K", "kappa", "N", "J3", "J4", "Gpp", "Gpo", "Goo", "ap", "ao", "C2", "reaction"}
    k, alpha = device.coefficients, 1.25
    scaled = in_other_time(k, alpha)
    assert scaled.beyond is None  # its constants: test_equations_in_another_unit_of_time_are_the_same_motion
    for name in set(k._fields) - {"p1", "q1", "p3", "q3", "beyond"}:
        assert name in powers or name in timeless, f"{name}: tell in_other_time and this test its power of time"
        assert getattr(scaled, name) == pytest.approx(getattr(k, name) / alpha ** powers.get(name, 0)), name


@pytest.mark.parametrize("connection", ["magnetic", "rigid"])
@pytest.mark.parametrize("symmetric", [True, False])
def test_parameter_derivatives_are_those_of_the_map(device: gy.Plant, connection: Any, symmetric: bool) -> None:
    plant = device.replace(connection=connection)
    found = gy.lock_orbit(plant, WAVE, 0.06, 2e-3)
    x = found.x[free_rows(plant)]
    for name in LINEAR:
        orbit_map = OrbitMap(plant, found.wave, 0.06, 2e-3, parameters=(name,), symmetric=symmetric)
        value, h = orbit_map.value(name), SMALL[name]

        def image(shift: float, m: OrbitMap = orbit_map, v: float = value) -> NDArray[np.float64]:
            return m.evaluate(x, np.array([v + shift]), derivative=False).image

        exact = orbit_map.evaluate(x, np.array([value])).by_parameter[:, 0]
        difference = (8 * (image(h) - image(-h)) - (image(2 * h) - image(-2 * h))) / (12 * h)
        np.testing.assert_allclose(
            exact, difference, rtol=1e-5, atol=1e-6 * max(np.max(np.abs(exact)), 1e-4), err_msg=name
        )


def test_map_over_a_parameter_is_the_map_of_the_moved_device(device: gy.Plant) -> None:
    """By constants in the kernel, or as a plant of its own."""
    found = gy.lock_orbit(device, WAVE, 0.06, 2e-3)
    x = found.x[free_rows(device)]
    for name in LINEAR:
        orbit_map = OrbitMap(device, found.wave, 0.06, 2e-3, parameters=(name,))
        values = np.array([1.03 * orbit_map.value(name)])
        moved = orbit_map.moved({name: values[0]})
        assert moved.value(name) == pytest.approx(values[0], rel=1e-12)
        own = moved.over(()).evaluate(x, np.empty(0))
        there = orbit_map.evaluate(x, values)
        np.testing.assert_allclose(there.image, own.image, rtol=1e-10, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(there.by_state, own.by_state, rtol=1e-8, atol=1e-8, err_msg=name)
        assert there.power == pytest.approx(own.power, rel=1e-10)
    with pytest.raises(gy.InputError, match="parameter"):
        OrbitMap(device, found.wave, 0.06, 2e-3, parameters=("J14",))


@pytest.mark.parametrize("connection", ["magnetic", "rigid"])
def test_constants_with_another_gear_are_the_plants(device: gy.Plant, connection: Any) -> None:
    plant = device.replace(connection=connection)
    other = plant.replace(r2=1.1 * plant.parameters.r2)
    changed = with_gear(plant.coefficients, 0.1 * plant.parameters.N, plant.parameters.J13, connection == "rigid")
    for name in ("N", "Gpp", "Gpo", "Goo", "ap", "ao", "kappa"):
        expected = getattr(other.coefficients, name)
        assert getattr(changed, name) == pytest.approx(expected, rel=1e-12, abs=1e-14), name


def test_shifted_excitation_keeps_the_moduli_and_sets_the_phase(device: gy.Plant) -> None:
    shifted = ShiftedExcitation(device.excitation, 0.4)
    omega = np.array([2.0, 3.14, 5.0])
    before, after = device.excitation(omega), shifted(omega)
    np.testing.assert_allclose(np.abs(after), np.abs(before))
    np.testing.assert_allclose(np.angle(after[0] / after[1]), 0.4)
    np.testing.assert_allclose(after[1], before[1])
    assert shifted.sha256 != device.excitation.sha256
    assert "sha" not in shifted.sha256 and "0.4" in shifted.sha256


# --- multipliers -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_three_ways_to_the_multipliers_agree(orbit: gy.PeriodicOrbit) -> None:
    """Kernel by complex step, variational equation by DOP853, casadi's derivative of its own Runge-Kutta step."""
    values = {}
    for method in METHODS:
        steps = 800 if orbit.cc < 0.2 else 1600
        found = np.linalg.eigvals(monodromy(orbit, method, steps))
        values[method] = found[np.argsort(-np.abs(found))][:4]
    for method in METHODS[1:]:
        for value in values[method]:
            assert np.min(np.abs(values["complex step"] - value)) < 1e-6, method


def test_ways_are_named_and_refuse_what_they_cannot(device: gy.Plant) -> None:
    rigid = gy.lock_orbit(device.replace(connection="rigid"), WAVE, 0.0, 1e-3)
    with pytest.raises(gy.InputError, match="magnetic"):
        monodromy(rigid, "variational")
    with pytest.raises(gy.InputError, match="method"):
        monodromy(rigid, "differences")  # type: ignore[arg-type]
    with pytest.raises(gy.InputError, match="orbit"):
        monodromy(gy.lock_orbit(device, WAVE, 0.052, 0.02, nearest=False))


def test_multipliers_do_not_depend_on_segments_or_step(orbit: gy.PeriodicOrbit) -> None:
    for segments, halves in ((3, 1), (7, 1), (5, 2)):
        product = np.linalg.multi_dot(segment_jacobians(orbit, segments, halves)[::-1])
        values = np.linalg.eigvals(product) ** (2 // halves)
        values = values[np.argsort(-np.abs(values))]
        np.testing.assert_allclose(np.abs(values[:4]), np.abs(orbit.multipliers[:4]), atol=1e-6)
    fine = gy.lock_orbit(orbit.plant, WAVE, orbit.cc, orbit.cg, dt=0.004)
    np.testing.assert_allclose(np.abs(fine.multipliers[:4]), np.abs(orbit.multipliers[:4]), atol=1e-6)
    assert fine.power == pytest.approx(orbit.power, rel=1e-6)


def test_error_and_residual_bars(orbit: gy.PeriodicOrbit) -> None:
    assert orbit.error < 1e-8 and orbit.residual < 1e-10
    np.testing.assert_allclose(orbit.half_multipliers**2, orbit.multipliers)


# --- modes -------------------------------------------------------------------------------------------------------


def test_all_growth_rates_together_are_the_mean_divergence(orbit: gy.PeriodicOrbit) -> None:
    """Liouville, over all modes and so with the slip, which no monodromy matrix resolves."""
    force, plant = orbit.forcing, orbit.plant
    traces = []
    for i, x in enumerate(orbit.states(64)):
        moments = np.real(np.exp(2j * np.pi * i / 64) * force.amplitude)
        traces.append(np.trace(plant.jacobians(x, (orbit.cc, orbit.cg), moments)[0]))
    total = sum(mode.rate * mode.order for mode in orbit.modes)
    # Runge-Kutta damps the slip a little less than the equations where one step is half a time constant
    assert total == pytest.approx(np.mean(traces), rel=2e-3)


def test_modes_have_their_names_once_and_their_multipliers(orbit: gy.PeriodicOrbit) -> None:
    names = [mode.name for mode in orbit.modes]
    for name in ("libration", "horizontal", "vertical", "slip"):
        assert names.count(name) == 1
    assert sum(mode.order for mode in orbit.modes) == 13
    for mode in orbit.modes:
        if abs(mode.multiplier) > 1e-6:
            assert np.min(np.abs(orbit.multipliers - mode.multiplier)) < 1e-6  # by other steps
        assert mode.decay_time == pytest.approx(-orbit.period / np.log(abs(mode.multiplier)))
    assert orbit.mode("slip").rate == pytest.approx(-slip_rate(orbit.plant.coefficients, orbit.cc), rel=0.03)
    assert 1.15 < orbit.mode("horizontal").frequency < 1.25
    assert 20.0 < orbit.mode("libration").period < 80.0
    assert orbit.mode("horizontal").decay_time > 10.0 * orbit.mode("vertical").decay_time
    with pytest.raises(gy.InputError, match="mode"):
        orbit.mode("pitch")


def decay(orbit: gy.PeriodicOrbit, row: int, name: str, kick: float, halves: int) -> tuple[float, float]:
    """Rate [1/s] and frequency [rad/s] fitted to the nonlinear simulation after a small kick along a mode."""
    plant, force = orbit.plant, orbit.forcing
    x = orbit.x + kick * np.real(orbit.mode(name).shape)
    series = []
    for _ in range(halves):
        x = reflect(flow(plant, x, orbit.cc, orbit.cg, force, 0.5)[: x.size], orbit.sense)
        x[3] = 0.0
        series.append(x[row] - orbit.x[row])
    y = np.array(series)
    coefficients, *_ = np.linalg.lstsq(np.stack([y[1:-1], y[:-2]], axis=1), y[2:], rcond=None)
    root = np.roots([1.0, *-coefficients])[0]
    turned = root if name == "libration" else -root
    return float(np.log(abs(root))) / (0.5 * orbit.period), abs(float(np.angle(turned))) / (0.5 * orbit.period)


@pytest.mark.parametrize(("name", "row", "halves"), [("libration", 2, 20), ("horizontal", 0, 120), ("vertical", 1, 4)])
def test_modes_match_a_decay_fitted_to_the_nonlinear_simulation(
    orbit: gy.PeriodicOrbit, name: str, row: int, halves: int
) -> None:
    rate, frequency = decay(orbit, row, name, 1e-4, halves)
    assert rate == pytest.approx(orbit.mode(name).rate, rel=0.03)
    assert frequency == pytest.approx(orbit.mode(name).frequency, rel=0.03)


def test_libration_of_two_real_multipliers(device: gy.Plant) -> None:
    """At a small coupling the libration is overdamped: two modes of that name, the slowest given first."""
    modes = [m for m in gy.lock_orbit(device, WAVE, 0.02, 1e-3).modes if m.name == "libration"]
    assert [m.order for m in modes] == [1, 1]
    assert modes[0].rate > modes[1].rate and modes[0].frequency == 0.0 and modes[0].period == np.inf


def test_rigid_connection_has_no_slip_mode(device: gy.Plant) -> None:
    rigid = gy.lock_orbit(device.replace(connection="rigid"), WAVE, 0.0, 1e-3)
    assert sum(mode.order for mode in rigid.modes) == 12
    assert "slip" not in {mode.name for mode in rigid.modes}


# --- reserve and advice ------------------------------------------------------------------------------------------


def test_lock_reserve_vanishes_towards_the_fold(device: gy.Plant) -> None:
    reserve = [gy.lock_orbit(device, WAVE, 0.1, cg).lock_reserve for cg in (1e-4, 2e-3, 4e-3, 5.2e-3)]
    assert np.all(np.diff(reserve) < 0.0)
    assert reserve[0] > 0.95 and abs(reserve[-1]) < 0.02


@pytest.mark.parametrize(
    ("height", "wp", "cc", "cg"), [(0.05, 3.14, 0.1, 2e-3), (0.2, 3.14, 0.3, 8e-3), (0.2, 3.6, 0.052, 6e-3)]
)
def test_no_orbit_names_the_nearest_height_that_has_one(
    device: gy.Plant, height: float, wp: float, cc: float, cg: float
) -> None:
    found = gy.lock_orbit(device, gy.Regular(height, wp), cc, cg)
    assert found.status == "no orbit" and found.modes == ()
    assert f"{found.nearest_height:.4g} m" in found.advice and "raise" in found.advice
    for factor, exists in ((0.995, False), (1.005, True)):
        wave = gy.Regular(factor * found.nearest_height, wp)
        assert (gy.lock_orbit(device, wave, cc, cg, nearest=False).status != "no orbit") == exists


def test_orbit_knows_its_wave(device: gy.Plant) -> None:
    orbit = gy.lock_orbit(device, gy.Regular(0.15, 3.0), 0.052, 1e-3, dt=0.008)
    assert orbit.wave == Wave(0.15, 3.0, 0.0) and orbit.dt == 0.008
    he = device.excitation(np.array([3.0]))[:, 0]
    np.testing.assert_allclose(orbit.forcing.amplitude, 0.075 * he)
    assert isinstance(orbit.forcing, Forcing)
    end = orbit.states(4)[2]
    np.testing.assert_allclose(reflect(end, 1)[[0, 1, 2, 4, 5, 6, 7]], orbit.x[[0, 1, 2, 4, 5, 6, 7]], atol=1e-8)
