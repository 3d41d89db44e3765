"""Linear models about the orbit: against the variational equation, the nonlinear plant and plain simulation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.linearisation.lifted import nonlinear_error
from gyroctl.linearisation.model import PeriodicModel, linearise
from gyroctl.linearisation.norms import h2_norm, hinf_norm, hinf_of
from gyroctl.linearisation.periodic import transition

WAVE = gy.Regular(height=0.2, wp=3.14)
OUTPUTS = ("psi", "psi_rate", "omega_rate", "phi1", "slip", "u1", "u3", "power")


@pytest.fixture(scope="module", params=[(0.052, 3.5e-4), (0.104, 3e-3), (0.02, 1e-3)], ids=str)
def orbit(request: pytest.FixtureRequest, device: gy.Plant) -> gy.PeriodicOrbit:
    return gy.lock_orbit(device, WAVE, *request.param)


@pytest.fixture(scope="module")
def model(orbit: gy.PeriodicOrbit) -> PeriodicModel:
    return linearise(orbit, OUTPUTS)


def test_multipliers_are_the_orbits(orbit: gy.PeriodicOrbit, model: PeriodicModel) -> None:
    """The orbit's come from the half map with its own steps; these from the product of sampled matrices."""
    np.testing.assert_allclose(np.abs(model.multipliers[:7]), np.abs(orbit.multipliers[:7]), rtol=1e-6)
    lifted = np.sort(np.abs(np.linalg.eigvals(model.lifted().A)))[::-1]
    np.testing.assert_allclose(lifted[:7], np.abs(orbit.multipliers[:7]), rtol=1e-6)
    assert np.max(np.abs(model.orbit[0] - orbit.x)) < 1e-5


@pytest.mark.parametrize("period", [0.05, 0.2, 0.5])
def test_multipliers_do_not_depend_on_the_control_period(
    orbit: gy.PeriodicOrbit, model: PeriodicModel, period: float
) -> None:
    other = linearise(orbit, period=period)
    assert other.samples == round(orbit.period / period)
    np.testing.assert_allclose(np.abs(other.multipliers[:6]), np.abs(model.multipliers[:6]), rtol=1e-6)


def test_note_says_which_period_is_used(model: PeriodicModel) -> None:
    assert model.samples == 20
    assert model.period == pytest.approx(2 * math.pi / 3.14 / 20)
    assert "20 samples" in model.note and "0.1 s was asked for" in model.note


@pytest.mark.parametrize("k", [0, 7])
def test_sampled_matrices_solve_the_variational_equation(orbit: gy.PeriodicOrbit, k: int) -> None:
    """Against another integrator, with the Jacobians of the plant, not of the kernel."""
    from scipy.integrate import solve_ivp

    model = linearise(orbit, dt=2.5e-3)
    plant, force, n, m = orbit.plant, orbit.forcing, len(model.states), 4
    keep = [plant.labels.index(name) for name in model.states]

    def slope(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        x, matrix = y[:14], y[14:].reshape(n, n + m)
        moments = np.real(np.exp(1j * force.wp * t) * force.amplitude)
        a, b = plant.jacobians(x, (orbit.cc, orbit.cg), moments)
        change = a[np.ix_(keep, keep)] @ matrix
        change[:, n:] += b[keep]
        return np.concatenate([plant.derivative(x, (orbit.cc, orbit.cg), moments), change.ravel()])

    start = np.concatenate([model.orbit[k], np.eye(n, n + m).ravel()])
    span = (k * model.period, (k + 1) * model.period)
    end = solve_ivp(slope, span, start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(end[:14], model.orbit[k + 1], rtol=1e-6, atol=1e-6)
    found = end[14:].reshape(n, n + m)
    for column, ours in enumerate(np.hstack([model.A[k], model.B[k]]).T):
        size = np.max(np.abs(found[:, column]))
        np.testing.assert_allclose(ours, found[:, column], rtol=1e-5, atol=1e-6 * size)


def test_error_against_the_nonlinear_plant_falls_linearly_to_1e_6(model: PeriodicModel) -> None:
    """Bar: a wrong matrix anywhere would leave a part that does not fall."""
    sizes = 10.0 ** -np.arange(2, 7)
    errors = nonlinear_error(model, sizes, seed=1)
    assert errors[0] > 1e-4  # the plant is nonlinear: the test can fail
    np.testing.assert_allclose(errors / sizes, errors[0] / sizes[0], rtol=0.25)
    spoilt = PeriodicModel(
        model.A * (1 + 1e-4),
        model.B,
        model.C,
        model.D,
        model.states,
        model.inputs,
        model.outputs,
        model.asked,
        model.orbit,
        model.controls,
        model.flow,
    )
    assert nonlinear_error(spoilt, sizes[-1:], seed=1)[0] > 10 * errors[-1]


def test_outputs_by_hand(orbit: gy.PeriodicOrbit, model: PeriodicModel) -> None:
    N, speed = orbit.plant.parameters.N, model.orbit[:-1, 7]
    at = model.states.index
    power, slip = model.outputs.index("power"), model.outputs.index("slip")
    np.testing.assert_allclose(model.C[:, power, at("omega_rate")], 2 * orbit.cg * speed, rtol=1e-12)
    np.testing.assert_allclose(model.D[:, power, 1], speed**2, rtol=1e-12)
    assert np.count_nonzero(model.D) == model.samples
    np.testing.assert_allclose(model.C[:, slip, at("psi_rate")], -N)
    psi, v1, v3 = (model.orbit[:-1, row] for row in (2, 4, 5))
    u3 = model.outputs.index("u3")
    np.testing.assert_allclose(model.C[:, u3, at("psi")], np.cos(psi) * v1 - np.sin(psi) * v3, atol=1e-14)


def test_lifted_model_is_the_recursion(model: PeriodicModel) -> None:
    rng, x = np.random.default_rng(0), np.zeros(len(model.states))
    u = rng.standard_normal((3 * model.samples, 4)) * [1e-3, 1e-5, 1.0, 1.0]
    y = []
    for i, now in enumerate(u):
        k = i % model.samples
        y.append(model.C[k] @ x + model.D[k] @ now)
        x = model.A[k] @ x + model.B[k] @ now
    import control

    lifted = model.lifted().to_control()
    answer = control.forced_response(lifted, inputs=u.reshape(3, -1).T, squeeze=False)
    expected = np.array(y).reshape(3, -1).T
    np.testing.assert_allclose(answer.outputs, expected, atol=1e-9 * np.max(np.abs(expected)))
    assert lifted.dt == pytest.approx(model.wave_period)
    assert lifted.input_labels[5] == "cg[1]" and lifted.output_labels[8] == "psi[1]"
    assert lifted.state_labels == list(model.states)


@pytest.mark.slow
def test_continuous_model_is_the_generator_of_the_sampled_one(orbit: gy.PeriodicOrbit) -> None:
    fine = linearise(orbit, period=1e-3)
    a, b = fine.continuous()
    middle, entry = 0.5 * (a + np.roll(a, -1, 0)), 0.5 * (b + np.roll(b, -1, 0))
    eye, h = np.eye(a.shape[1]), fine.period
    series = eye + h * middle + h**2 / 2 * middle @ middle + h**3 / 6 * middle @ middle @ middle
    np.testing.assert_allclose(fine.A, series, atol=1e-5 * np.max(np.abs(a)) * h)
    held = h * (eye + h / 2 * middle + h**2 / 6 * middle @ middle) @ entry
    size = h * np.max(np.abs(b), (0, 1))
    np.testing.assert_allclose(fine.B / size, held / size, atol=3e-3)


# --- harmonic transfer -------------------------------------------------------------------------------------------


def test_harmonic_transfer_is_what_a_sine_does(orbit: gy.PeriodicOrbit, model: PeriodicModel) -> None:
    """Steady state of the recursion under exp(i (w + j wp) t), its harmonics by projection."""
    if orbit.status != "stable":
        pytest.skip("no steady state")
    transfer, w, j, h = model.harmonic(), 0.37, 1, model.period
    rate = w + j * 2 * np.pi / model.wave_period
    count = model.samples
    # steady state x_{k+N} = exp(i w T) x_k: solved, not waited for
    push, z = np.zeros(len(model.states), complex), np.exp(1j * w * model.wave_period)
    for k in range(count):
        push = model.A[k] @ push + model.B[k][:, 1] * np.exp(1j * rate * k * h)
    x = np.linalg.solve(z * np.eye(push.size) - transition(model.A), push)
    y = []
    for k in range(count):
        u = np.exp(1j * rate * k * h)
        y.append(model.C[k] @ x + model.D[k][:, 1] * u)
        x = model.A[k] @ x + model.B[k][:, 1] * u
    found = transfer(w, keep=2)
    for line in range(-2, 3):
        turn = np.exp(-1j * (w + line * 2 * np.pi / model.wave_period) * h * np.arange(count))
        expected = np.mean(np.array(y) * turn[:, None], axis=0)
        np.testing.assert_allclose(found[line + 2, :, j + 2, 1], expected, atol=1e-9 * np.max(np.abs(y)))


def test_symmetry_of_the_device_splits_odd_from_even_harmonics(model: PeriodicModel) -> None:
    """Half a wave later phi has the other sign: cg moves psi at even harmonics only, phi1 at odd ones only."""
    found = model.harmonic()(0.3, keep=2)[:, :, 2, 1]
    psi, phi1 = (np.abs(found[:, model.outputs.index(name)]) for name in ("psi", "phi1"))
    assert np.max(psi[[1, 3]]) < 1e-5 * psi[2]
    assert np.max(phi1[[0, 2, 4]]) < 1e-5 * np.max(phi1)


# --- averaged model ----------------------------------------------------------------------------------------------


def test_averaged_poles_are_the_named_modes(orbit: gy.PeriodicOrbit, model: PeriodicModel) -> None:
    poles = model.averaged().poles
    for name, part in (("libration", poles[:2]), ("horizontal", poles[2:])):
        modes = [mode for mode in orbit.modes if mode.name == name]
        rates = sorted(
            [complex(m.rate, s * m.frequency) for m in modes for s in ((1,) if m.order == 1 else (-1, 1))],
            key=lambda p: (p.real, p.imag),
        )
        np.testing.assert_allclose(sorted(part, key=lambda p: (round(p.real, 9), p.imag)), rates, rtol=1e-5)


def test_averaged_model_is_good_within_its_range(model: PeriodicModel) -> None:
    averaged = model.averaged()
    assert 1.0 < averaged.valid_frequency <= np.pi / model.wave_period + 1e-12
    omega = np.linspace(0.0, averaged.valid_frequency, 12)
    exact, near = model.harmonic().baseband(omega), averaged.response(omega)
    psi, phi1 = model.outputs.index("psi"), model.outputs.index("phi1")
    for out, into in ((psi, 1), (phi1, 2)):
        np.testing.assert_array_less(np.abs(near - exact)[:, out, into], 0.11 * np.abs(exact[:, out, into]))
    np.testing.assert_allclose(near[0].real, exact[0].real, rtol=1e-8, atol=1e-9)
    system = averaged.to_control()
    assert system.nstates == 4 and system.state_labels[0] == "libration_psi" and system.isctime()


def test_averaged_model_predicts_a_slow_swing_of_the_nonlinear_plant(device: gy.Plant) -> None:
    """Two per cent of cg at 0.25 rad/s into the plant; psi averaged over each wave."""
    orbit = gy.lock_orbit(device, WAVE, 0.052, 1e-3)
    model = linearise(orbit, ("psi",))
    w, count = 2 * np.pi / (12 * model.wave_period), model.samples
    x, gaps = model.orbit[0], []
    for i in range(36 * count):
        cg = orbit.cg * (1 + 0.02 * math.cos(w * i * model.period))
        gaps.append(x[2] - model.orbit[i % count, 2] - 2 * np.pi * (i // count))
        x = model.flow.advance(x, orbit.cc, cg, i % count)
    last = np.array(gaps[24 * count :])
    found = 2 * np.mean(last * np.exp(-1j * w * model.period * np.arange(24 * count, 36 * count)))
    expected = model.averaged().response(np.array([w]))[0, 0, 1] * 0.02 * orbit.cg
    assert found == pytest.approx(expected, rel=0.03)


def test_range_of_the_libration_is_where_the_nonlinear_plant_leaves_it(device: gy.Plant) -> None:
    """Nearer to pull-out the ring leaves the linear picture earlier; an unstable orbit has no range."""
    angles = []
    for cg in (3.5e-4, 3e-3, 4.5e-3):
        angles.append(linearise(gy.lock_orbit(device, WAVE, 0.3, cg)).averaged().valid_angle)
    assert 0.05 < angles[2] < angles[0] < np.pi
    assert linearise(gy.lock_orbit(device, WAVE, 0.02, 1e-3)).averaged().valid_angle == 0.0


# --- norms -------------------------------------------------------------------------------------------------------


def test_norms_of_the_lifted_model(device: gy.Plant) -> None:
    import control

    orbit = gy.lock_orbit(device, WAVE, 0.104, 3e-3)
    lifted = linearise(orbit, ("psi", "power")).select(inputs=("cg",)).lifted()
    norm, frequency = hinf_norm(lifted)
    at = np.exp(1j * np.linspace(0, np.pi, 4001))
    eye = np.eye(lifted.A.shape[0])
    grid = max(np.linalg.norm(lifted.C @ np.linalg.solve(z * eye - lifted.A, lifted.B) + lifted.D, 2) for z in at)
    assert grid <= norm * (1 + 1e-9) and norm == pytest.approx(grid, rel=1e-4)
    z = np.exp(1j * frequency * lifted.period)
    there = np.linalg.norm(lifted.C @ np.linalg.solve(z * eye - lifted.A, lifted.B) + lifted.D, 2)
    assert there == pytest.approx(norm, rel=1e-6)
    assert h2_norm(lifted) == pytest.approx(control.system_norm(lifted.to_control(), 2), rel=1e-8)


@pytest.mark.parametrize(("radius", "angle"), [(0.999, 1.2), (0.9, 0.3), (0.5, 3.0)])
def test_hinf_norm_of_a_resonance_by_hand(radius: float, angle: float) -> None:
    """Two poles at radius exp(+-i angle): the peak by fine minimisation of the denominator."""
    from scipy.optimize import minimize_scalar

    a = np.array([[2 * radius * math.cos(angle), -(radius**2)], [1.0, 0.0]])
    b, c, d = np.array([[1.0], [0.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1))

    def minus_gain(w: float) -> float:
        z = np.exp(1j * w)
        return -abs(z / (z * z - 2 * radius * math.cos(angle) * z + radius**2))

    peak = max(
        -minimize_scalar(
            minus_gain,
            bounds=(max(0, angle - 0.5), min(np.pi, angle + 0.5)),
            method="bounded",
            options={"xatol": 1e-12},
        ).fun,
        -minus_gain(0.0),
        -minus_gain(np.pi),
    )
    assert hinf_of(a, b, c, d)[0] == pytest.approx(peak, rel=1e-6)


def test_norms_of_an_unstable_model_are_infinite(device: gy.Plant) -> None:
    lifted = linearise(gy.lock_orbit(device, WAVE, 0.02, 1e-3), ("psi",)).lifted()
    assert math.isinf(hinf_norm(lifted)[0]) and math.isinf(h2_norm(lifted))


# --- files and requests ------------------------------------------------------------------------------------------


def test_matlab_files_hold_the_matrices_and_names(model: PeriodicModel, tmp_path: Path) -> None:
    from scipy.io import loadmat

    for name, value in (("periodic", model), ("lifted", model.lifted()), ("averaged", model.averaged())):
        path = tmp_path / f"{name}.mat"
        value.to_mat(path)
        back = loadmat(path, simplify_cells=True)
        expected = np.moveaxis(value.A, 0, -1) if name == "periodic" else value.A
        np.testing.assert_array_equal(back["A"], expected)
        assert list(back["states"]) == list(value.states)
        assert list(back["inputs"]) == list(value.inputs)


def test_rigid_connection_has_fewer_states_and_the_same_kind_of_model(device: gy.Plant) -> None:
    orbit = gy.lock_orbit(device.replace(connection="rigid"), WAVE, 0.0, 1e-3)
    model = linearise(orbit, ("psi", "power"))
    assert len(model.states) == 12
    np.testing.assert_allclose(np.abs(model.multipliers[:6]), np.abs(orbit.multipliers[:6]), rtol=1e-6)
    errors = nonlinear_error(model, np.array([1e-3, 1e-5]))
    assert errors[1] == pytest.approx(1e-2 * errors[0], rel=0.3)


def test_bad_requests_are_named(orbit: gy.PeriodicOrbit, model: PeriodicModel, device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match="outputs = 'speed': unknown output"):
        linearise(orbit, ("speed",))
    for period in (0.0, -0.1, math.nan, 3.0):
        with pytest.raises(gy.InputError, match="period"):
            linearise(orbit, period=period)
    nothing = gy.lock_orbit(device, gy.Regular(0.01, 3.14), 0.052, 1e-3)
    with pytest.raises(gy.InputError, match="nothing to linearise about"):
        linearise(nothing)
    with pytest.raises(gy.InputError, match="inputs = 'torque'"):
        model.select(inputs=("torque",))


def test_orbit_offers_the_model(orbit: gy.PeriodicOrbit) -> None:
    assert orbit.linearise(outputs=("psi",), period=0.1).outputs == ("psi",)
