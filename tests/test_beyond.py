"""Terms beyond the linear model and the signals they need, each against an oracle that shares no step with it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.geometry import Geometry
from gyroctl.plant.beyond import BEYOND, HALF, NODES
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PHI1, PHI1_RATE, PHI3_RATE, PSI_RATE
from gyroctl.plant.held import Held
from gyroctl.plant.kernel import hold_into, hold_one, rows, signal_room

Array = NDArray[Any]

SEA = gy.SeaState(gamma=5.0)
CHOICES: dict[str, dict[str, Any]] = {
    "position": {"position": "moving"},
    "drag": {"drag": 0.5},
    "curve": {"coupling_slip": 60.0, "coupling_cap": 2.0},
    "losses": {"bearing": 0.02, "windage": 9.1e-7, "rolling_resistance": 2e-5},
}
ALL = {name: value for choice in CHOICES.values() for name, value in choice.items()}
REACH = Geometry().reach


@pytest.fixture(scope="module")
def linear() -> gy.Plant:
    return gy.zhang2017()


@pytest.fixture(scope="module")
def waves(linear: gy.Plant) -> gy.WaveRealisation:
    return gy.realise(linear, SEA, 1, 600.0)


@pytest.fixture(scope="module", params=[*CHOICES, "all"])
def plant(request: pytest.FixtureRequest) -> gy.Plant:
    return gy.zhang2017(**CHOICES.get(request.param, ALL))


def state(plant: gy.Plant, seed: int) -> Array:
    """A random state of the working range."""
    rng = np.random.default_rng(seed)
    x = 0.2 * rng.standard_normal(len(plant.labels))
    x[PSI_RATE], x[OMEGA_RATE] = 3.0 + x[PSI_RATE], 65.0 + 10.0 * x[OMEGA_RATE]
    return x


def signals(plant: gy.Plant, seed: int) -> Array:
    """Signals at an instant as smooth along the reach as waves are."""
    rng = np.random.default_rng(seed)
    out = rng.normal(0.0, 0.3, len(plant.channels))
    out[:2] *= 300.0
    if "Me1@0" in plant.channels:
        x = REACH * np.arange(-HALF, HALF + 1) / HALF
        for j, first in enumerate((-2 * NODES, -NODES)):
            phase = rng.uniform(0.0, 6.28, 3)
            shape = sum(
                a * np.cos(k * x + p) for a, k, p in zip((100.0, 30.0, 5.0), (1.3, 3.0, 6.0), phase, strict=True)
            )
            out[len(out) + first : len(out) + first + NODES] = shape
            out[j] = shape[HALF]
    return out


# --- the waves ---------------------------------------------------------------------------------------------------


def test_plant_choices_do_not_enter_the_hash(linear: gy.Plant, waves: gy.WaveRealisation) -> None:
    other = gy.realise(gy.zhang2017(**ALL), SEA, 1, 600.0)
    assert other.sha256 == waves.sha256
    np.testing.assert_array_equal(other.moments, waves.moments)
    assert waves.signals(linear) is waves.moments


def test_signals_are_sums_of_cosines(waves: gy.WaveRealisation) -> None:
    """Each component alone, with its own wavenumber: velocities from the potential, moments with the phase k X."""
    plant = gy.zhang2017(**ALL)
    found = waves.signals(plant)
    parts, omega = waves.synthesis, waves.synthesis.waves.omega  # type: ignore[union-attr]
    a = parts.waves.amplitude * np.exp(1j * waves.phases)  # type: ignore[union-attr]
    k, depth, z = wavenumber(omega, plant.depth), plant.depth, plant.parameters.drag_height
    he = plant.excitation(omega, 0.0)
    for sample in (0, 1234, 12000):
        turn = a * np.exp(1j * omega * 0.05 * sample)
        u = np.real(np.sum(turn * omega * np.cosh(k * (z + depth)) / np.sinh(k * depth)))
        w = np.real(np.sum(1j * turn * omega * np.sinh(k * (z + depth)) / np.sinh(k * depth)))
        expected = [*np.real(he @ turn), u, w]
        for moment in range(2):
            expected += [
                np.real(np.sum(he[moment] * turn * np.exp(-1j * k * REACH * i / HALF))) for i in range(-10, 11)
            ]
        np.testing.assert_allclose(found[:, sample], expected, rtol=1e-9, atol=1e-8)


def test_velocities_obey_continuity_and_the_surface(linear: gy.Plant) -> None:
    """At the mean level the water rises with the elevation; at the bottom it only slides."""
    from gyroctl.waves.channels import velocities

    omega = np.linspace(0.5, 12.0, 40)
    k = wavenumber(omega, 0.7)
    np.testing.assert_allclose(velocities(omega, k, 0.7, 0.0)[1], 1j * omega, rtol=1e-12)
    assert np.max(np.abs(velocities(omega, k, 0.7, -0.7)[1])) < 1e-12
    deep = velocities(omega, wavenumber(omega, np.inf), np.inf, -0.1)
    np.testing.assert_allclose(np.abs(deep[0]), np.abs(deep[1]), rtol=1e-12)


def test_heading_turns_the_waves_across_the_reach() -> None:
    """Waves along the lever reach all positions at once and push nothing along x3."""
    plant = gy.zhang2017(**ALL)
    found = gy.realise(plant, gy.SeaState(heading=90.0), 1, 50.0).signals(plant)
    assert np.max(np.abs(found[2])) < 1e-12 * np.max(np.abs(found[3]))
    np.testing.assert_allclose(found[4 : 4 + NODES], np.broadcast_to(found[0], (NODES, found.shape[1])), atol=1e-9)


def test_signals_are_blended_like_the_moments(waves: gy.WaveRealisation) -> None:
    """At the beginning they are those of the regular wave, later those of the sea."""
    plant, led = gy.zhang2017(**ALL), waves.blended(100.0)
    found, whole = led.signals(plant), waves.signals(plant)
    regular = gy.realise(plant, gy.Regular(SEA.hs / np.sqrt(2.0), SEA.wp), 1, 10.0).signals(plant)
    np.testing.assert_allclose(found[:, 0], regular[:, 0], atol=1e-9)
    np.testing.assert_array_equal(found[:, 2000:], whole[:, 2000:])
    np.testing.assert_allclose(found[4 + HALF], found[0], atol=1e-9)


def test_other_excitation_is_refused(linear: gy.Plant, waves: gy.WaveRealisation) -> None:
    other = gy.zhang2017(position="moving", excitation_phase="magnitude")
    with pytest.raises(InputError, match="another excitation"):
        waves.signals(other)
    bare = dataclasses.replace(waves, synthesis=None)
    with pytest.raises(InputError, match="without the waves"):
        bare.signals(gy.zhang2017(position="moving"))


# --- one text ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma, wp, most", [(5.0, 3.14, 1e-3), (1.0, 3.6, 1e-3)])
def test_moving_moments_are_the_sum_of_cosines_at_the_position(gamma: float, wp: float, most: float) -> None:
    """Through the compiled kernel: what a small step changes in phi', at positions and instants between all nodes."""
    plant, linear = gy.zhang2017(position="moving"), gy.zhang2017()
    sea = gy.SeaState(gamma=gamma, wp=wp)
    waves = gy.realise(plant, sea, 3, 600.0)
    flat, plain = np.ascontiguousarray(waves.signals(plant).T).ravel(), np.ascontiguousarray(waves.moments.T).ravel()
    parts = waves.synthesis
    assert parts is not None
    omega = parts.waves.omega
    k, he = wavenumber(omega, plant.depth), parts.response * np.exp(1j * waves.phases)
    rng, h, errors = np.random.default_rng(0), 1e-6, []
    for _ in range(300):
        x = np.zeros(len(plant.labels))
        x[PHI1], t = rng.uniform(-0.7, 0.7), rng.uniform(1.0, 590.0)
        X = REACH * np.sin(x[PHI1])
        exact = np.real(he * np.exp(-1j * k * X) @ np.exp(1j * omega * t)) - np.real(he @ np.exp(1j * omega * t))
        rates = []
        for device, grid in ((plant, flat), (linear, plain)):
            y = np.zeros(rows(device.coefficients))
            y[: x.size] = x
            rates.append(hold_one(y, device.coefficients, 0.0, 0.0, t, h, 1, grid, 0.05)[PHI1_RATE : PHI3_RATE + 1] / h)
        # with psi = 0 and all at rest the inertia of phi1 is that of the constraint
        still = np.zeros(len(plant.labels))
        unit = (
            linear.derivative(still, (0.0, 0.0), (1.0, 0.0))[PHI1_RATE],
            linear.derivative(still, (0.0, 0.0), (0.0, 1.0))[PHI3_RATE],
        )
        errors.append((rates[0] - rates[1]) / unit - exact)
    deviation = np.std(waves.moments, axis=1)
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < most * deviation)


def test_engines_agree(plant: gy.Plant) -> None:
    """NumPy, casadi; complex step, central differences, casadi's derivative."""
    import casadi

    u, n = (0.06, 4e-4), len(plant.labels)
    function = plant.casadi()
    x_, u_ = casadi.SX.sym("x", n), casadi.SX.sym("u", 2)
    m_ = casadi.SX.sym("m", function.numel_in(2))
    symbolic = casadi.Function("J", [x_, u_, m_], [casadi.jacobian(function(x_, u_, m_), casadi.vertcat(x_, u_))])
    for seed in range(5):
        x, m = state(plant, seed), signals(plant, seed)
        slope = plant.derivative(x, u, m)
        np.testing.assert_allclose(np.ravel(function(x, u, plant.near(x, m))), slope, rtol=1e-11, atol=1e-11)
        A, B = plant.jacobians(x, u, m)
        scale = 1e-10 * np.max(np.abs(np.hstack([A, B])), axis=1, keepdims=True)
        ours = np.hstack([A, B[:, :2]])
        assert np.all(np.abs(np.array(symbolic(x, u, plant.near(x, m))) - ours) <= scale)
        for row in range(n):
            h = 1e-5 * np.eye(n)[row]
            difference = (plant.derivative(x + h, u, m) - plant.derivative(x - h, u, m)) / 2e-5
            np.testing.assert_allclose(A[:, row], difference, atol=2e-6 * np.max(np.abs(A)))


def test_batch_equals_single_states(plant: gy.Plant) -> None:
    x = np.stack([state(plant, seed) for seed in range(6)], axis=1)
    m = np.stack([signals(plant, seed) for seed in range(6)], axis=1)
    batch = plant.derivative(x, (0.05, 4e-4), m)
    for i in range(6):
        np.testing.assert_allclose(
            batch[:, i], plant.derivative(x[:, i], (0.05, 4e-4), m[:, i]), rtol=1e-12, atol=1e-12
        )


def test_energy_changes_by_the_powers(plant: gy.Plant) -> None:
    """Along the motion the stored energy changes by what the ledger's rows bring and take: independent of each term."""
    for seed in range(5):
        x, m, u = state(plant, seed), signals(plant, seed), (0.06, 4e-4)
        slope, powers = plant.derivative(x, u, m), plant.powers(x, u, m)
        assert tuple(powers) == (*LEDGER, *BEYOND)
        h = 1e-6
        rate = (plant.stored_energy(x + h * slope) - plant.stored_energy(x - h * slope)) / (2.0 * h)
        brought = powers["wave_input"] + powers["second_order"]
        taken = sum(value for name, value in powers.items() if name not in ("wave_input", "second_order"))
        assert rate == pytest.approx(brought - taken, rel=1e-6, abs=1e-5)


# --- the terms, in closed form -----------------------------------------------------------------------------------


def immobile(**choices: Any) -> gy.Plant:
    """A device whose lever cannot move."""
    return gy.zhang2017(J11=1e12, **choices)


def test_drag_damps_a_free_oscillator_as_its_first_integral_says() -> None:
    """(1 - 2 b y) exp(2 b y) = (1 + 2 b x) exp(-2 b x) for turning points x, -y of x'' + w^2 x + b |x'| x' = 0."""
    fit = gy.zhang2017().radiation[0]
    silent = dataclasses.replace(fit, p=tuple(1e-12 * p for p in fit.p))
    plant = gy.zhang2017(drag=1.0, d1=0.0, J13=1e-12, J14=1e-12, J22=0.1, radiation=(silent, silent))
    k = plant.coefficients
    b = 0.5 * 1000.0 * 1.0 * 0.141 * REACH**3 * k.i1
    x = np.zeros(rows(k))
    x[PHI1], width = 0.3, 4
    still, before, turning, t, h = np.zeros(400 * width), 0.3, [], 0.0, 2e-3
    last = x
    while len(turning) < 4:
        x = hold_one(last, k, 0.0, 0.0, 1.0, h, 1, still, 0.05)
        if x[PHI1_RATE] * last[PHI1_RATE] < 0.0:  # the parabola through the step
            part = last[PHI1_RATE] / (last[PHI1_RATE] - x[PHI1_RATE])
            turning.append(abs(last[PHI1] + 0.5 * last[PHI1_RATE] * part * h))
        last, t = x, t + h
    for found in turning:
        assert (1.0 - 2.0 * b * found) * np.exp(2.0 * b * found) == pytest.approx(
            (1.0 + 2.0 * b * before) * np.exp(-2.0 * b * before), abs=3e-6
        )
        assert found < 0.98 * before
        before = found


def test_drag_acts_in_the_relative_velocity() -> None:
    plant, linear = gy.zhang2017(drag=0.7, drag_area=(0.2, 0.3)), gy.zhang2017()
    x, u, w = state(plant, 1), 0.4, -0.25
    r1, r3 = REACH * x[PHI1_RATE] - u, REACH * x[PHI3_RATE] - w
    speed = np.sqrt(r1**2 + r3**2 + 1e-6)
    moments = -0.5 * 1000.0 * 0.7 * REACH * speed * np.array([0.2 * r1, 0.3 * r3])
    same = linear.derivative(x, (0.05, 4e-4), np.array([10.0, -20.0]) + moments)
    np.testing.assert_allclose(plant.derivative(x, (0.05, 4e-4), (10.0, -20.0, u, w)), same, rtol=1e-12, atol=1e-12)


def test_compiled_tangent_is_the_library_s() -> None:
    """To the last bits over all sizes, also where it is small or has arrived."""
    from numba import njit

    from gyroctl.plant.hyperbolic import tanh

    @njit  # type: ignore[untyped-decorator]
    def compiled(x: Array, out: Array) -> None:
        for i in range(x.size):
            out[i] = tanh(x[i])

    x = np.concatenate([np.linspace(-25.0, 25.0, 20001), np.logspace(-12.0, 1.5, 2000)])
    found = np.empty_like(x)
    compiled(x, found)
    np.testing.assert_allclose(found, np.tanh(x), rtol=2e-15)


@pytest.mark.parametrize("slip", [-130.0, -20.0, -1.0, 0.0, 5.0, 20.0, 44.0, 200.0])
def test_coupling_torque_follows_its_curve(slip: float) -> None:
    plant = gy.zhang2017(coupling_slip=20.0, coupling_cap=2.0)
    x = np.zeros(len(plant.labels))
    x[OMEGA_RATE] = slip
    torque = 0.2 * slip / (1.0 + (slip / 20.0) ** 2)
    expected = 2.0 * np.tanh(torque / 2.0)
    assert plant.powers(x, (0.2, 0.0), (0.0, 0.0))["slip"] == pytest.approx(expected * slip, rel=1e-12, abs=1e-12)
    assert abs(expected) < 2.0


def test_bearing_and_windage_slow_the_flywheel_in_closed_form() -> None:
    """sinh W = sinh W0 exp(-T t/J4) for the bearing; arsinh(1/W) = arsinh(1/W0) + C t/J4 for the air."""
    J4, t = gy.zhang2017().parameters.J4, 100.0
    for choice, after in (
        ({"bearing": 0.05}, lambda w: np.arcsinh(np.sinh(w) * np.exp(-0.05 * t / J4))),
        ({"windage": 2e-4}, lambda w: 1.0 / np.sinh(np.arcsinh(1.0 / w) + 2e-4 * t / J4)),
    ):
        k = immobile(**choice).coefficients
        y = np.zeros(rows(k))
        y[OMEGA_RATE] = 15.0
        end = hold_one(y, k, 0.0, 0.0, 0.0, t, 10000, np.zeros(2 * 2100), 0.05)
        assert end[OMEGA_RATE] == pytest.approx(after(15.0), rel=1e-8)
        lost = 0.5 * J4 * (15.0**2 - end[OMEGA_RATE] ** 2)
        n = len(immobile().labels) + len(LEDGER)
        assert end[n + BEYOND.index(next(iter(choice)))] == pytest.approx(lost, rel=1e-7)


def test_rolling_resistance_is_the_load_times_its_arm() -> None:
    """With the lever at rest the load is the gyroscopic moment of ring, spin axis and flywheel."""
    plant, free = immobile(rolling_resistance=3e-5), immobile()
    p, x = plant.parameters, np.zeros(len(plant.labels))
    x[PSI_RATE], x[OMEGA_RATE] = 3.1, 69.0
    load = 3.1 * (p.J13 * p.N * 3.1 + p.J14 * 69.0)
    torque = 3e-5 / p.r2 * np.hypot(load, 0.1) * np.tanh(p.N * 3.1)
    slowed = plant.derivative(x, (0.0, 0.0), (0.0, 0.0)) - free.derivative(x, (0.0, 0.0), (0.0, 0.0))
    assert slowed[PSI_RATE] == pytest.approx(-p.N * torque / p.J2, rel=1e-9)
    assert plant.powers(x, (0.0, 0.0), (0.0, 0.0))["rolling_resistance"] == pytest.approx(torque * p.N * 3.1, rel=1e-9)


@pytest.mark.slow
def test_held_moments_are_exact_on_a_line(linear: gy.Plant) -> None:
    """New every 10 ms and extrapolated: what is a line in time acts as if the stages knew it."""
    from typing import NamedTuple

    class Rising(NamedTuple):
        slope: float

        def moments(self, fields: Any, t: Any, x: Any, L: int, l: int) -> Any:
            return fields[0] + self.slope * t, fields[1] - self.slope * t

    from gyroctl.plant.beyond import Beyond

    k, t = linear.coefficients, 0.05 * np.arange(60)
    surface = k._replace(beyond=Beyond(surface=True))
    plain = np.stack([7.0 + 40.0 * t, -3.0 - 40.0 * t], axis=1).ravel()
    held = Held.begun(Rising(40.0), np.array([7.0, -3.0]), 1)
    y = np.zeros(rows(surface))
    y[: len(linear.labels)] = state(linear, 0)
    z = y[: rows(k)].copy()
    work, room, weight, u = (
        np.empty((5, y.size)),
        np.empty(signal_room(surface.beyond, 1)),
        np.empty(8),
        np.array([[0.05], [4e-4]]),
    )
    before = hold_one(z, k, 0.05, 4e-4, 0.5, 0.01, 1, plain, 0.05)
    hold_into(y, work, room, weight, surface, u, 0.5, 0.01, 1, np.zeros(2 * 60), 0.05, held)
    np.testing.assert_allclose(y[4:6], before[4:6], atol=5e-5)  # the first value is held: there is none before it
    y[: len(linear.labels)] = before[: len(linear.labels)]
    after = hold_one(before, k, 0.05, 4e-4, 0.51, 1.0, 170, plain, 0.05)
    hold_into(y, work, room, weight, surface, u, 0.51, 1.0, 170, np.zeros(2 * 60), 0.05, held)
    np.testing.assert_allclose(y[: len(linear.labels)], after[: len(linear.labels)], rtol=1e-9, atol=1e-9)
