"""The plant's equations: one text on every engine, energy, symmetries, the linear limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.plant.equations import LEDGER, Coefficients, derivative
from gyroctl.plant.trigonometry import cos_sin

Array = NDArray[np.float64]

PLANTS: dict[str, Callable[[], gy.Plant]] = {
    "corrected": gy.zhang2017,
    "paper": lambda: gy.zhang2017("paper"),
    "rigid": lambda: gy.zhang2017(connection="rigid"),
    "fine radiation": lambda: gy.zhang2017(radiation="fine", d3=1.5),
}


@pytest.fixture(scope="module", params=list(PLANTS))
def plant(request: pytest.FixtureRequest) -> gy.Plant:
    return PLANTS[request.param]()


def states_of(plant: gy.Plant, count: int, seed: int) -> Array:
    """Random states (count, n) of the working range; the flywheel turns along where it is geared to the ring."""
    rng = np.random.default_rng(seed)
    n = len(plant.labels)
    size = np.array([0.2, 0.2, 1.0, 1.0, 0.5, 0.5, 1.5, 20.0] + [0.05] * (n - 8))
    x = size * rng.standard_normal((count, n))
    x[:, 2] = rng.uniform(-np.pi, np.pi, count)
    x[:, 6] += rng.choice([-3.14, 3.14], count)
    x[:, 7] += rng.choice([-70.0, 70.0], count)
    if plant.parameters.connection == "rigid":
        x[:, 7] = plant.parameters.N * x[:, 6]
    return x


def inputs(count: int, seed: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, [0.3, 0.02], (count, 2)), 100.0 * rng.standard_normal((count, 2))


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def compiled(x: Any, dx: Any, k: Coefficients, cc: Any, cg: Any, me1: Any, me3: Any) -> None:
    derivative(x, dx, 1, 0, k, cc, cg, me1, me3)


# --- one text, four engines --------------------------------------------------------------------------------------


def test_compiled_text_equals_numpy_to_rounding(plant: gy.Plant) -> None:
    controls, moments = inputs(50, 1)
    for x, u, m in zip(states_of(plant, 50, 0), controls, moments, strict=True):
        dx = np.empty(x.size + len(LEDGER))
        compiled(x, dx, plant.coefficients, *u, *m)
        plain = [*plant.derivative(x, u, m), *plant.powers(x, u, m).values()]
        np.testing.assert_allclose(dx, plain, rtol=1e-12, atol=1e-12 * np.max(np.abs(plain)))


def test_casadi_text_equals_numpy_to_rounding(plant: gy.Plant) -> None:
    function = plant.casadi()
    controls, moments = inputs(20, 3)
    for x, u, m in zip(states_of(plant, 20, 2), controls, moments, strict=True):
        np.testing.assert_allclose(np.ravel(function(x, u, m)), plant.derivative(x, u, m), rtol=1e-12, atol=1e-12)


@pytest.mark.slow
def test_three_jacobians_agree(plant: gy.Plant) -> None:
    """Complex step on NumPy, complex step through the compiled text, casadi's algorithmic derivative."""
    import casadi

    n = len(plant.labels)
    function = plant.casadi()
    x_, u_, m_ = casadi.SX.sym("x", n), casadi.SX.sym("u", 2), casadi.SX.sym("m", 2)
    slope = function(x_, u_, m_)
    symbolic = casadi.Function("J", [x_, u_, m_], [casadi.jacobian(slope, casadi.vertcat(x_, u_, m_))])
    controls, moments = inputs(10, 5)
    for x, u, m in zip(states_of(plant, 10, 4), controls, moments, strict=True):
        A, B = plant.jacobians(x, u, m)
        assert A.shape == (n, n) and B.shape == (n, 4)
        ours = np.hstack([A, B])
        theirs = np.array(symbolic(x, u, m))
        through = np.empty_like(ours)
        for i in range(n + 4):
            point = np.concatenate([x, u, m]).astype(complex)
            point[i] += 1e-30j
            dx = np.empty(n + len(LEDGER), complex)
            compiled(point[:n].copy(), dx, plant.coefficients, *point[n:])
            through[:, i] = dx[:n].imag / 1e-30
        scale = 1e-12 * np.max(np.abs(ours), axis=1, keepdims=True)
        assert np.all(np.abs(theirs - ours) <= scale)
        assert np.all(np.abs(through - ours) <= scale)


def test_batch_equals_single_states(plant: gy.Plant) -> None:
    x, (controls, moments) = states_of(plant, 30, 6), inputs(30, 7)
    batch = plant.derivative(x.T, controls.T, moments.T)
    single = np.array([plant.derivative(a, b, c) for a, b, c in zip(x, controls, moments, strict=True)])
    assert batch.shape == x.T.shape
    np.testing.assert_allclose(batch.T, single, rtol=1e-12, atol=1e-12)
    common = plant.derivative(x.T, (0.05, 1e-3), (3.0, -4.0))
    np.testing.assert_allclose(common[:, 4], plant.derivative(x[4], (0.05, 1e-3), (3.0, -4.0)), rtol=1e-12, atol=1e-12)


def test_compiled_cosine_and_sine_are_good_to_two_units_in_the_last_place() -> None:
    """Over the angles of a run and far beyond, near the zeros too: |angle| up to 1e6 rad is 44 hours of lock."""

    @njit  # type: ignore[untyped-decorator]
    def both(angles: Any, out: Any) -> None:
        for i in range(angles.size):
            out[0, i], out[1, i] = cos_sin(angles[i])

    rng = np.random.default_rng(8)
    wide = np.concatenate([rng.uniform(-(10.0**e), 10.0**e, 20000) for e in (-8, -3, 0, 1, 2, 4, 6)])
    quarters = np.arange(-20000, 20001) * (np.pi / 2)
    angles = np.concatenate([wide, quarters, np.nextafter(quarters, np.inf), quarters + np.pi / 4, [0.0]])
    out = np.empty((2, angles.size))
    both(angles, out)
    for found, exact in zip(out, (np.cos(angles), np.sin(angles)), strict=True):
        assert np.max(np.abs(found - exact) / np.spacing(np.maximum(np.abs(exact), 0.5))) <= 2.0
        small = (np.abs(exact) < 1e-3) & (np.abs(exact) > 0)
        # where the value nears zero, what counts is the reduction of the angle: three parts of pi/2
        assert np.max(np.abs(found - exact)[small] / np.abs(exact)[small], initial=0.0) < 1e-9


# --- energy ------------------------------------------------------------------------------------------------------


def energy_surplus(plant: gy.Plant, x: Array, u: Array, m: Array) -> tuple[float, float]:
    """Rate of the stored energy less what the ledger's powers say, and the size of the largest power [W]."""
    rate = plant.derivative(x, u, m)
    stored = float(np.imag(plant.stored_energy(x + 1e-30j * rate)) / 1e-30)
    powers = {name: float(value) for name, value in plant.powers(x, u, m).items()}
    spent = sum(powers[name] for name in ("radiated", "hinge", "slip", "generator"))
    return stored - powers["wave_input"] + spent, max(map(abs, powers.values()))


@pytest.mark.parametrize("name", ["corrected", "rigid", "fine radiation"])
def test_energy_changes_by_the_powers_of_the_ledger(name: str) -> None:
    plant = PLANTS[name]()
    controls, moments = inputs(100, 10)
    for x, u, m in zip(states_of(plant, 100, 9), controls, moments, strict=True):
        surplus, size = energy_surplus(plant, x, u, m)
        assert abs(surplus) < 1e-11 * (size + 1e3)


def test_printed_generator_reaction_makes_work_cg_omega_u1(printed: gy.Plant) -> None:
    """Trap 3: the excess is exactly the bracketed moments times the rates they act on."""
    controls, moments = inputs(100, 12)
    excess = []
    for x, u, m in zip(states_of(printed, 100, 11), controls, moments, strict=True):
        surplus, size = energy_surplus(printed, x, u, m)
        u1 = math.cos(x[2]) * x[4] - math.sin(x[2]) * x[5]
        excess.append(u[1] * x[7] * u1)
        assert surplus == pytest.approx(excess[-1], abs=1e-11 * (size + 1e3))
    assert np.max(np.abs(excess)) > 0.1  # the test would see it


def test_lever_term_does_no_work(device: gy.Plant) -> None:
    """Trap 3b: no energy check can see it, and it is there."""
    without = device.replace(lever_gyroscopic=False)
    controls, moments = inputs(20, 14)
    for x, u, m in zip(states_of(device, 20, 13), controls, moments, strict=True):
        surplus, size = energy_surplus(without, x, u, m)
        assert abs(surplus) < 1e-11 * (size + 1e3)
        change = (device.derivative(x, u, m) - without.derivative(x, u, m))[4:6]
        assert np.linalg.norm(change) > 1e-4 * np.linalg.norm(x[4:6])


def test_rigid_connection_keeps_its_gear_and_has_no_slip() -> None:
    plant = PLANTS["rigid"]()
    controls, moments = inputs(30, 16)
    for x, u, m in zip(states_of(plant, 30, 15), controls, moments, strict=True):
        dx = plant.derivative(x, u, m)
        assert dx[7] == pytest.approx(plant.parameters.N * dx[6], rel=1e-11, abs=1e-10)
        assert plant.powers(x, u, m)["slip"] == pytest.approx(0.0, abs=1e-20)
        np.testing.assert_allclose(dx, plant.derivative(x, (0.0, u[1]), m), rtol=1e-10, atol=1e-10)


def test_a_stiff_coupling_tends_to_the_rigid_connection(device: gy.Plant) -> None:
    """The rigid device is the limit of large cc: float and ring accelerations after the slip has settled."""
    rigid = device.replace(connection="rigid")
    p, x = device.parameters, states_of(rigid, 1, 17)[0]
    u, m = (1e5, 1e-3), (40.0, -70.0)

    def miss(slip: float) -> float:
        dx = device.derivative(x + slip * np.eye(14)[7], u, m)
        return float(dx[7] - p.N * dx[6])

    # the settled slip is the one that keeps omega'' = N psi''; the miss is all but linear in it
    slip = -miss(0.0) * 1e-4 / (miss(1e-4) - miss(0.0))
    found = device.derivative(x + slip * np.eye(14)[7], u, m)
    np.testing.assert_allclose(found[4:8], rigid.derivative(x, u, m)[4:8], rtol=1e-4)


# --- symmetries --------------------------------------------------------------------------------------------------


def half_turn(plant: gy.Plant, x: Array, shift: float) -> Array:
    """Half a period later: phi -> -phi, z -> -z, psi -> psi - pi; `shift` is pi for states, 0 for rates."""
    out = -x
    out[[2, 3, 6, 7]] = x[[2, 3, 6, 7]]
    out[2] -= shift
    return out


def mirror(plant: gy.Plant, x: Array) -> Array:
    """Other sense of rotation: phi1, its radiation, psi and omega change sign."""
    out = x.copy()
    n1 = len(plant.radiation[0].q)
    out[[0, 2, 3, 4, 6, 7, *range(8, 8 + n1)]] *= -1.0
    return out


def test_half_period_symmetry(plant: gy.Plant) -> None:
    controls, moments = inputs(20, 19)
    for x, u, m in zip(states_of(plant, 20, 18), controls, moments, strict=True):
        turned = plant.derivative(half_turn(plant, x, math.pi), u, -m)
        np.testing.assert_allclose(turned, half_turn(plant, plant.derivative(x, u, m), 0.0), rtol=1e-9, atol=1e-9)


def test_mirror_symmetry(plant: gy.Plant) -> None:
    controls, moments = inputs(20, 21)
    for x, u, m in zip(states_of(plant, 20, 20), controls, moments, strict=True):
        mirrored = plant.derivative(mirror(plant, x), u, m * [-1.0, 1.0])
        np.testing.assert_allclose(mirrored, mirror(plant, plant.derivative(x, u, m)), rtol=1e-9, atol=1e-9)


def test_flywheel_angle_is_cyclic(plant: gy.Plant) -> None:
    x, (u, m) = states_of(plant, 1, 22)[0], (i[0] for i in inputs(1, 23))
    A, _ = plant.jacobians(x, u, m)
    np.testing.assert_array_equal(A[:, 3], 0.0)


# --- linear limit ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("angle", "cc", "cg"), [(0.0, 0.0, 0.0), (0.7, 0.052, 3.5e-4), (2.0, 0.3, 0.02)])
def test_small_motion_about_rest_is_the_linear_float_of_control(
    device: gy.Plant, angle: float, cc: float, cg: float
) -> None:
    """Ring and flywheel at rest: moments to float rates by python-control from (16), Table 1 and P/Q."""
    import control as ct

    p = device.parameters
    c, s = math.cos(angle), math.sin(angle)
    mass = np.array(
        [
            [p.J1 + p.K * c**2 + p.Jh1, -p.K * c * s, 2 * p.N * p.J3 * c, p.J4 * c],
            [-p.K * c * s, p.J1 + p.K * s**2 + p.Jh3, -2 * p.N * p.J3 * s, -p.J4 * s],
            [2 * p.N * p.J3 * c, -2 * p.N * p.J3 * s, p.J2, 0.0],
            [p.J4 * c, -p.J4 * s, 0.0, p.J4],
        ]
    )
    damping = np.zeros((4, 4))
    damping[:2, :2] = np.diag([p.d1, p.d3])
    damping[2:, 2:] = [[p.N**2 * cc, -p.N * cc], [-p.N * cc, cc + cg]]
    stiffness = np.diag([p.k1, p.k3, 0.0, 0.0])
    inverse = np.linalg.inv(mass)
    dry = ct.ss(
        np.block([[np.zeros((4, 4)), np.eye(4)], [-inverse @ stiffness, -inverse @ damping]]),
        np.vstack([np.zeros((4, 2)), inverse[:, :2]]),
        np.hstack([np.zeros((2, 4)), np.eye(2), np.zeros((2, 2))]),
        np.zeros((2, 2)),
    )
    water = ct.append(*(ct.tf2ss(ct.tf(list(r.p), [1.0, *r.q])) for r in device.radiation))
    wet = ct.feedback(dry, water)

    x = np.zeros(14)
    x[2] = angle
    A, B = device.jacobians(x, (cc, cg), (0.0, 0.0))
    for w in (0.3, 1.2, 1.29, 3.14, 7.0, 20.0):
        ours = np.linalg.solve(1j * w * np.eye(14) - A, B[:, 2:])[4:6]
        np.testing.assert_allclose(ours, wet(1j * w), rtol=1e-8, atol=1e-14)
