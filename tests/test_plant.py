"""The plant: one text of the equations on every engine, energy, symmetries, the linear limit, and what it refuses."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.plant.equations import LEDGER, Coefficients, derivative
from gyroctl.plant.trigonometry import cos_sin

Array = NDArray[np.float64]

POSITIVE = ("a", "b", "d", "r1", "r2", "m1", "m2", "m3", "m4", "J11", "J22", "J13", "J14", "k1", "k3")
NOT_NEGATIVE = ("c", "Jh1", "Jh3", "d1", "d3")

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


# --- numbers of the device ---------------------------------------------------------------------------------------


def test_derived_constants_of_table_1(device: gy.Plant) -> None:
    """(16) with the numbers of Table 1, typed here by hand."""
    p = device.parameters
    assert p.N == pytest.approx(0.203 / 0.009, rel=1e-15)
    assert p.J2 == pytest.approx(0.0952 + (508.7530864 + 0.5) * 0.0009208 + 0.3671 / 2, rel=1e-9)
    assert p.J3 == pytest.approx(0.0004604, rel=1e-12)
    assert p.J4 == 0.3671
    assert p.K == pytest.approx(0.0004604 + 0.18355, rel=1e-12)
    assert p.lever_inertia == pytest.approx(0.279, abs=5e-4)
    assert math.sqrt(146.7 / (p.J1 + 14.39)) == pytest.approx(1.29, abs=5e-3)
    lever = 21.68 + 0.0476 + 0.0004604 + 0.18355
    assert p.J1 == pytest.approx(lever + 20.27 * 0.9891**2 + 27.983 * 1.0652**2, rel=1e-9)


def test_slip_decays_at_683_times_cc(device: gy.Plant) -> None:
    """The slip alone, in the ring's frame: its rate is cc (N^2/J2 + 1/J4)."""
    from gyroctl.plant.kernel import slip_rate

    p, x = device.parameters, np.zeros(14)
    x[7] = 1.0
    dx = device.derivative(x, (0.052, 0.0), (0.0, 0.0))
    free = dx[7] - p.N * dx[6]
    assert free == pytest.approx(-0.052 * 683.2, rel=2e-2)  # the float is a little free to move with it
    assert slip_rate(device.coefficients, 1.0) == pytest.approx(p.N**2 / p.J2 + 1 / p.J4, rel=1e-12)
    assert slip_rate(device.coefficients, 1.0) == pytest.approx(683.0, abs=0.5)
    assert slip_rate(gy.zhang2017(connection="rigid").coefficients, 1.0) == pytest.approx(0.0, abs=1e-9)


def test_labels_are_those_of_the_contract(device: gy.Plant) -> None:
    assert device.labels == (
        "phi1",
        "phi3",
        "psi",
        "omega",
        "phi1_rate",
        "phi3_rate",
        "psi_rate",
        "omega_rate",
        "z1_1",
        "z1_2",
        "z1_3",
        "z3_1",
        "z3_2",
        "z3_3",
    )
    assert len(gy.zhang2017(radiation="fine").labels) == 16


def test_power_is_cg_times_the_square_of_the_speed(device: gy.Plant) -> None:
    """Trap 2, with the paper's own figures: cg 3.5e-4 at 71 rad/s gives 1.76 W."""
    x = np.zeros((14, 2))
    x[7] = 71.0, 35.5
    np.testing.assert_allclose(device.power(x, (0.052, 3.5e-4)), [1.764, 1.764 / 4], rtol=1e-3)


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


def test_radiation_of_any_order_is_its_rational_function() -> None:
    """The (3, 4) fit: moment of the water on the float over its rate, read off the Jacobian."""
    plant = gy.zhang2017(radiation="fine")
    x = np.zeros(16)
    x[2] = 0.4
    A, B = plant.jacobians(x, (0.0, 0.0), (0.0, 0.0))
    for j, rows in enumerate((slice(8, 12), slice(12, 16))):
        output = -A[4 + j, rows] / B[4 + j, 2 + j]
        fit = plant.radiation[j]
        for w in (0.2, 1.2, 3.14, 9.0, 40.0):
            gain = output @ np.linalg.solve(1j * w * np.eye(4) - A[rows, rows], A[rows, 4 + j])
            expected = np.polyval(fit.p, 1j * w) / np.polyval([1.0, *fit.q], 1j * w)
            assert gain == pytest.approx(expected, rel=1e-9)
            assert fit.response(w) == pytest.approx(expected, rel=1e-12)


# --- variants ----------------------------------------------------------------------------------------------------


def test_paper_is_the_corrected_plant_with_every_erratum_put_back_by_name(printed: gy.Plant) -> None:
    choices: dict[str, Any] = {
        "generator_reaction": True,
        "lever_gyroscopic": False,
        "d1": 0.0,
        "radiation": "paper",
        "excitation_phase": "magnitude",
    }
    built = gy.zhang2017("corrected", **choices)
    assert built.parameters == printed.parameters
    assert built.radiation == printed.radiation
    assert built.excitation.sha256 == printed.excitation.sha256
    for left_out in choices:
        partial = gy.zhang2017(**{name: value for name, value in choices.items() if name != left_out})
        assert (partial.parameters, partial.radiation, partial.excitation.sha256) != (
            printed.parameters,
            printed.radiation,
            printed.excitation.sha256,
        )


def test_presets_hold_what_the_design_says(device: gy.Plant, printed: gy.Plant) -> None:
    assert (device.parameters.d1, device.parameters.d3) == (2.0, 0.0)
    assert (printed.parameters.d1, printed.parameters.d3) == (0.0, 0.0)
    np.testing.assert_allclose(printed.radiation[0].p, [1396.494, 4584.783, 724.177], rtol=1e-3)
    np.testing.assert_allclose(printed.radiation[1].q, [11.6028, 83.0018, 134.1893], rtol=1e-3)
    low = [plant.radiation[0].response(1.2).real for plant in (device, printed)]
    assert low[0] == pytest.approx(0.27, abs=0.08)  # what the BEM has
    assert low[1] == pytest.approx(1.24, abs=0.02)  # trap 5: the unweighted fit over-damps 4.5 times


def test_printed_excitation_has_one_phase_and_the_true_one_two(device: gy.Plant, printed: gy.Plant) -> None:
    """Trap 4: about 82 degrees between the two moments near the peak."""
    w = np.array([2.5, 3.1, 4.0])
    true, one = device.excitation(w), printed.excitation(w)
    np.testing.assert_allclose(np.abs(one), np.abs(true), rtol=5e-3)
    np.testing.assert_allclose(np.angle(one), 0.0, atol=1e-12)
    apart = np.rad2deg(np.angle(true[0, 1] / true[1, 1]))
    assert apart == pytest.approx(82.0, abs=2.0)


def test_replace_changes_one_choice_and_nothing_else(device: gy.Plant) -> None:
    changed = device.replace(d1=1.0)
    assert changed.parameters.d1 == 1.0
    assert dataclasses.replace(changed.parameters, d1=2.0) == device.parameters
    assert changed.radiation is device.radiation and device.parameters.d1 == 2.0
    assert device.replace(name="mine", d3=0.5).name == "mine"
    assert device.replace(name="mine", d3=0.5).parameters.d3 == 0.5


def test_derived_numbers_follow_a_replaced_parameter(device: gy.Plant) -> None:
    """The constants are cached: a plant made by `replace` must not inherit the old ones."""
    assert device.coefficients.d1 == 2.0
    assert device.replace(d1=0.5).coefficients.d1 == 0.5
    assert len(device.replace(radiation=gy.zhang2017(radiation="fine").radiation).labels) == 16


# --- refusals ----------------------------------------------------------------------------------------------------


def parameters_with(name: str, value: Any) -> gy.Parameters:
    changes: dict[str, Any] = {name: value}
    return gy.Parameters(**changes)


@pytest.mark.parametrize("name", POSITIVE + NOT_NEGATIVE)
@given(value=st.floats(max_value=0.0, exclude_max=True) | st.sampled_from([math.nan, math.inf, -math.inf]))
@settings(max_examples=10, deadline=None)
def test_parameter_out_of_range_is_named(name: str, value: float) -> None:
    with pytest.raises(gy.InputError) as caught:
        parameters_with(name, value)
    assert caught.value.field == f"plant.{name}"
    assert repr(caught.value.value) == repr(value)
    assert caught.value.mend and name in str(caught.value) and repr(value) in str(caught.value)


@pytest.mark.parametrize("name", POSITIVE)
def test_zero_is_refused_where_it_has_no_meaning(name: str) -> None:
    with pytest.raises(gy.InputError, match=rf"plant\.{name} = 0\.0: must be positive"):
        parameters_with(name, 0.0)


@pytest.mark.parametrize("name", NOT_NEGATIVE)
def test_zero_is_allowed_where_it_has_a_meaning(name: str) -> None:
    assert getattr(parameters_with(name, 0.0), name) == 0.0


@pytest.mark.parametrize("value", ["2.0", None, True, [1.0], 1j])
def test_parameter_of_another_type_is_refused(value: Any) -> None:
    with pytest.raises(gy.InputError, match=r"plant\.d1"):
        gy.Parameters(d1=value)


@pytest.mark.parametrize(
    ("field", "changes"),
    [
        ("plant.connection", {"connection": "elastic"}),
        ("plant.generator_reaction", {"generator_reaction": 1}),
        ("plant.lever_gyroscopic", {"lever_gyroscopic": "yes"}),
        ("plant.r2", {"r2": 0.005}),
        ("plant.r2", {"r1": 0.203}),
        ("plant.J22", {"J22": 1e-5}),
        ("plant.springs", {"springs": 3}),
        ("plant.J11", {"J11": -21.68}),
        ("plant.variant", {"variant": "improved"}),
        ("plant.radiation", {"radiation": "best"}),
        ("plant.radiation", {"radiation": 3}),
        ("plant.radiation", {"radiation": (gy.Radiation((1.0,), (1.0,)),)}),
        ("plant.excitation_phase", {"excitation_phase": "none"}),
    ],
)
def test_bad_choice_is_named(field: str, changes: dict[str, Any]) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.zhang2017(**changes)
    assert caught.value.field == field
    assert caught.value.mend


def test_replace_names_an_unknown_parameter_and_the_known_ones(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match=r"plant\.dl = 2\.0: unknown parameter.*d1") as caught:
        device.replace(dl=2.0)
    assert caught.value.field == "plant.dl"


@pytest.mark.parametrize("shape", [(13,), (15,), (), (13, 14), (2, 14, 3)])
def test_state_of_another_shape_is_refused(device: gy.Plant, shape: tuple[int, ...]) -> None:
    with pytest.raises(gy.InputError, match="the state has 14 rows"):
        device.derivative(np.zeros(shape), (0.05, 1e-3), (0.0, 0.0))


# --- passivity ---------------------------------------------------------------------------------------------------


def smallest_real_part(p: list[float], q: list[float]) -> float:
    """Least value over x = w^2 >= 0 of Re P(iw)Q(-iw) for n = 3 (DESIGN, closed form)."""
    a, b, c = p[0] * q[0] - p[1], p[1] * q[1] - p[2] * q[0] - p[0] * q[2], p[2] * q[2]
    if a < 0.0:
        return -math.inf
    if b >= 0.0:
        return c
    return c - b * b / (4.0 * a) if a > 0.0 else -math.inf


@given(
    p=st.lists(st.floats(-3.0, 10.0), min_size=3, max_size=3), q=st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3)
)
@settings(max_examples=300, deadline=None)
def test_passivity_is_decided_as_by_the_closed_form_of_third_order(p: list[float], q: list[float]) -> None:
    margin = q[0] * q[1] - q[2]  # Routh
    least = smallest_real_part(p, q)
    scale = max(1.0, *(abs(v) for v in p)) * max(1.0, *q)
    assume(abs(margin) > 1e-6 and (abs(least) > 1e-6 * scale or least == -math.inf))
    assume(abs(p[0] * q[0] - p[1]) > 1e-6 * scale)
    if margin < 0.0:
        with pytest.raises(gy.InputError, match=r"radiation\.q"):
            gy.Radiation(tuple(p), tuple(q))
    elif least < 0.0:
        with pytest.raises(gy.InputError, match=r"radiation\.p.*not passive"):
            gy.Radiation(tuple(p), tuple(q))
    else:
        assert np.min(gy.Radiation(tuple(p), tuple(q)).response(np.geomspace(1e-3, 1e3, 200)).real) >= -1e-9 * scale


@pytest.mark.parametrize(
    ("p", "q", "field"),
    [
        ((1396.494, 4584.783, -1.0), (14.6833, 98.1761, 380.4675), "radiation.p"),  # active at rest
        ((1396.494, 4584.783, 724.177), (14.6833, -98.1761, 380.4675), "radiation.q"),  # unstable
        ((1.0, 2.0, 3.0, 4.0), (14.6833, 98.1761, 380.4675), "radiation.p"),  # improper
        ((1.0, math.nan, 3.0), (14.6833, 98.1761, 380.4675), "radiation.p"),
        ((), (1.0,), "radiation.p"),
        ((-1.0,), (1.0,), "radiation.p"),
        # p2 = 0 without the constraint: negative just above w = 0 because p1 q2 < p0 q3
        ((2000.0, 100.0, 0.0), (14.6833, 98.1761, 380.4675), "radiation.p"),
    ],
)
def test_radiation_that_gives_energy_is_refused(p: tuple[float, ...], q: tuple[float, ...], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.Radiation(p, q)
    assert caught.value.field == field
    assert caught.value.mend


def test_a_fit_on_the_boundary_of_passivity_is_accepted() -> None:
    """Where the constraint binds, p0 q1 = p1 but for rounding; such a fit came out of the deep-water database."""
    from gyroctl.hydrodynamics.passivity import certify

    p = (568.2501898362123, 12775.80214857314, 8.247167822143346e-05)
    q = (22.48270634, 147.10695184, 485.998964)
    p = (p[0], p[0] * q[0], p[2])
    for exact in (p, (p[0], np.nextafter(p[1], 0.0), p[2]), (p[0], p[1], 0.0)):
        assert certify((*exact[:1], exact[1] * (1 - 1e-15), exact[2]), q).passive
        assert gy.Radiation(exact, q).p == exact
    with pytest.raises(gy.InputError, match="not passive"):
        gy.Radiation((p[0], p[1] * (1 + 1e-9), p[2]), q)


def test_radiation_of_first_order_and_of_none() -> None:
    assert gy.Radiation((2.0,), (3.0,)).response(0.0) == pytest.approx(2.0 / 3.0)
    still = gy.Radiation((0.0,), (1.0,))
    plant = gy.zhang2017(radiation=(still, still))
    assert plant.labels[-2:] == ("z1_1", "z3_1")
    assert plant.powers(np.ones(10), (0.0, 0.0), (0.0, 0.0))["radiated"] == 0.0
