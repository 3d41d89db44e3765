"""Laws made in a line: against scipy, casadi and the formulas that they were made of; compiled as Python."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca
import control
import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import RegularGridInterpolator
from scipy.signal import cont2discrete, dlsim

import gyroctl as gy
from gyroctl.harness.law_entry import compiled
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.law_forms.signals import SIGNALS
from gyroctl.harness.law_forms.tape import OPERATIONS, TapeLaw
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.loop_margins.closed_loop_orbit import close_loop
from gyroctl.loop_margins.dual_numbers import step_jacobian

RNG = np.random.default_rng(7)
GAIN = 3e-4


def measurements(count: int) -> list[gy.Measurement]:
    """Readings near a ring in lock, all channels on the move."""
    rows = RNG.normal(0.0, 1.0, (count, 7)) * [0.0, 0.2, 1.0, 0.1, 0.1, 0.3, 0.3] + [0.0, 3.14, 70.0, 0, 0, 0, 0]
    rows[:, 0] = 0.314 * np.arange(count)
    return [gy.Measurement(*row) for row in rows.tolist()]


def commands(law: Any, rows: list[gy.Measurement]) -> Any:
    """Commands of a law, sample by sample, in plain Python."""
    state, found = law.init(), []
    for sample, y in enumerate(rows):
        command, state = law.step(law.period * sample, y, state)
        found.append(command)
    return np.array(found)


# --- linear systems ----------------------------------------------------------------------------------------------

A, B = np.array([[-0.5, 2.0], [-2.0, -0.7]]), np.array([[1.0, 0.0], [0.3, 0.5]])
C, D = 1e-4 * np.array([[1.0, 0.4], [40.0, 9.0]]), 1e-4 * np.array([[2.0, 0.0], [30.0, 5.0]])
POINT = {"psi_rate": 3.14, "omega_rate": 70.0}


@pytest.mark.parametrize("method", ["tustin", "zoh", "foh", "euler", "backward_diff"])
def test_linear_law_is_the_system_that_scipy_simulates(method: str) -> None:
    system = control.ss(A, B, C, D, inputs=list(POINT), outputs=["cg", "cc"])
    law = gy.law_from(system, at=POINT, cc=0.1, cg=5e-3, method=method)
    rows = measurements(200)
    inputs = np.array([[y.psi_rate - 3.14, y.omega_rate - 70.0] for y in rows])
    sampled = cont2discrete((A, B, C, D), 0.1, "bilinear" if method == "tustin" else method)
    _, expected, _ = dlsim(sampled, inputs)
    found = commands(law, rows)
    np.testing.assert_allclose(found[:, 1] - 5e-3, expected[:, 0], rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(found[:, 0] - 0.1, expected[:, 1], rtol=1e-9, atol=1e-14)


def test_transfer_function_of_discrete_time_keeps_its_period() -> None:
    law: Any = gy.law_from(control.tf([1e-4, 2e-5], [1.0, -0.6], 0.2), reads="u1", sets="cg", cg=1e-3, cc=0.05)
    assert law.period == 0.2
    rows = measurements(50)
    u1 = [math.cos(y.psi) * y.phi1_rate - math.sin(y.psi) * y.phi3_rate for y in rows]
    x, expected = 0.0, []
    for k in range(50):  # y[k] = 0.6 y[k-1] + 1e-4 u[k] + 2e-5 u[k-1]
        x = 0.6 * x + 1e-4 * u1[k] + (2e-5 * u1[k - 1] if k else 0.0)
        expected.append(max(1e-3 + x, 0.0))
    np.testing.assert_allclose(commands(law, rows)[:, 1], expected, rtol=1e-12)


def test_static_gain_on_an_orbit_gives_the_controls_of_the_orbit_on_its_mean(device: gy.Plant) -> None:
    orbit = gy.lock_orbit(device, gy.Regular(0.2, 3.14), 0.052, 3.5e-4)
    law: Any = gy.law_from(control.ss([], [], [], [[GAIN]]), reads="psi_rate", sets="cg", at=orbit)
    assert law.point[0] == pytest.approx(3.14, rel=1e-3)  # the ring turns once a wave
    y = gy.Measurement(0.0, law.point[0] + 0.1, 70.0, 0.0, 0.0, 0.0, 0.0)
    (cc, cg), _ = law.step(0.0, y, law.init())
    assert (cc, cg) == (0.052, pytest.approx(3.5e-4 + 0.1 * GAIN))


def test_command_stays_within_its_limits_and_a_lost_sensor_leaves_the_last_value() -> None:
    law: Any = gy.law_from(control.ss([], [], [], [[1.0]]), reads="psi_rate", sets="cg", at=POINT, cc=0.05, cg=5e-3)
    for rate, expected in ((9.0, 0.02), (-9.0, 0.0)):
        y = gy.Measurement(0.0, rate, 70.0, 0.0, 0.0, 0.0, 0.0)
        assert law.step(0.0, y, law.init())[0] == (0.05, expected)
    soft: Any = gy.law_from(control.ss([], [], [], [[1e-3]]), reads="psi_rate", sets="cg", at=POINT, cc=0.05, cg=5e-3)
    heard = gy.Measurement(0.0, 4.0, 70.0, 0.0, 0.0, 0.0, 0.0)
    first, state = soft.step(0.0, heard, soft.init())
    again, _ = soft.step(0.1, heard._replace(psi_rate=math.nan), state)
    assert again == first


# --- tables ------------------------------------------------------------------------------------------------------

SPEED, RATE = np.array([2.8, 3.0, 3.1, 3.5]), np.array([0.1, 0.2, 0.5])
TABLE = 1e-3 * RNG.uniform(0.1, 1.0, (4, 3))


def grid(rate: float, motion: float) -> gy.Measurement:
    return gy.Measurement(1.0, rate, 70.0, 0.0, 0.0, 0.6 * motion, 0.8 * motion)


def test_table_gives_its_nodes_and_between_them_what_scipy_interpolates() -> None:
    coords = {"psi_rate": SPEED, "float_rate": RATE}
    law: Any = gy.law_from(xr.Dataset({"cg": (("psi_rate", "float_rate"), TABLE)}, coords), cc=0.06)
    for i, j in itertools.product(range(4), range(3)):
        (cc, cg), _ = law.step(0.0, grid(SPEED[i], RATE[j]), law.init())
        assert cc == 0.06 and cg == pytest.approx(TABLE[i, j], rel=1e-12)
    expected = RegularGridInterpolator((SPEED, RATE), TABLE)
    for rate, motion in RNG.uniform([2.8, 0.1], [3.5, 0.5], (40, 2)).tolist():
        cg = law.step(0.0, grid(rate, motion), law.init())[0][1]
        assert cg == pytest.approx(float(expected((rate, motion))), rel=1e-10)
    assert law.step(0.0, grid(9.0, 9.0), law.init())[0][1] == pytest.approx(TABLE[-1, -1])  # held beyond the edge


def test_table_of_an_array_filters_what_it_is_looked_up_by() -> None:
    law: Any = gy.law_from([1e-4, 5e-4], over={"psi_rate": [3.0, 4.0]}, cc=0.06, smooth=0.4)
    rows = [gy.Measurement(0.0, 3.0, 70.0, 0, 0, 0, 0)] + [gy.Measurement(0.0, 4.0, 70.0, 0, 0, 0, 0)] * 5
    found = commands(law, rows)[:, 1]
    left = (1.0 - 0.1 / (0.1 + 0.4)) ** np.arange(6)  # of the step, after each sample
    np.testing.assert_allclose(found, 1e-4 + 4e-4 * (1.0 - left), rtol=1e-12)


# --- casadi ------------------------------------------------------------------------------------------------------


def casadi_filter() -> ca.Function:
    """A filter and a saturation, with a state."""
    y, x = ca.SX.sym("y", 7), ca.SX.sym("x")
    command = ca.vertcat(0.06 + 0.01 * ca.sin(y[0]), 4e-4 + GAIN * ca.tanh(x) * ca.if_else(y[1] > 3.1, 1.0, 0.5))
    return ca.Function("filter", [y, x], [command, 0.9 * x + 0.1 * (y[1] - 3.14)], ["y", "state"], ["u", "state_next"])


def test_casadi_law_is_its_formula_in_python() -> None:
    law: Any = gy.law_from(casadi_filter(), init=(0.2,))
    rows, x, expected = measurements(100), 0.2, []
    for y in rows:
        half = 1.0 if y.psi_rate > 3.1 else 0.5
        expected.append((0.06 + 0.01 * math.sin(y.psi), max(4e-4 + GAIN * math.tanh(x) * half, 0.0)))
        x = 0.9 * x + 0.1 * (y.psi_rate - 3.14)
    np.testing.assert_allclose(commands(law, rows), expected, rtol=1e-12)


def test_casadi_function_of_signals_by_name_and_of_one_vector_are_the_same_law() -> None:
    a, b, v = ca.SX.sym("u1"), ca.SX.sym("psi_rate"), ca.SX.sym("v", 2)
    named = ca.Function("f", [a, b], [0.05, 1e-4 * (a + b)], ["u1", "psi_rate"], ["cc", "cg"])
    vector = ca.Function("f", [v], [ca.vertcat(0.05, 1e-4 * (v[0] + v[1]))])
    rows = measurements(20)
    first = commands(gy.law_from(named), rows)
    np.testing.assert_array_equal(first, commands(gy.law_from(vector, reads=["u1", "psi_rate"]), rows))
    assert len(np.unique(first[:, 1])) > 10


def test_casadi_function_that_is_no_straight_line_is_called() -> None:
    table = ca.interpolant("table", "linear", [[2.5, 3.5]], [1e-4, 3e-4])
    rate = ca.MX.sym("psi_rate")
    law: Any = gy.law_from(ca.Function("f", [rate], [0.05, table(rate)], ["psi_rate"], ["cc", "cg"]))
    assert not isinstance(law, TapeLaw)
    y = gy.Measurement(0.0, 3.0, 70.0, 0, 0, 0, 0)
    assert law.step(0.0, y, law.init())[0] == (0.05, pytest.approx(2e-4))
    assert law_fingerprint(law)


UNARY: dict[str, Callable[[Any], Any]] = {
    **{name: getattr(ca, name) for name in ("exp", "log", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan")},
    **{name: getattr(ca, name) for name in ("fabs", "sign", "tanh", "sinh", "cosh", "floor", "ceil")},
    "not": lambda v: ca.logic_not(v > 0.3),
    "invert": lambda v: 1.0 / v,
    "square and twice": lambda v: v * v + 2.0 * v - v,
}
BINARY: dict[str, Callable[[Any, Any], Any]] = {
    **{name: getattr(ca, name) for name in ("fmin", "fmax", "atan2", "hypot", "copysign")},
    "less": lambda v, w: (v < w) + 2.0 * (v <= w) + 4.0 * (v == w) + 8.0 * (v != w),
    "logic": lambda v, w: ca.logic_and(v > 0.0, w > 0.0) + 2.0 * ca.logic_or(v > 0.0, w > 0.0),
    "power": lambda v, w: ca.power(v, w) + v**3,
    "arithmetic": lambda v, w: v * w - v / w + w,
    "choice": lambda v, w: ca.if_else(v < w, v, 2.0 * w),
}


@pytest.mark.parametrize("name", [*UNARY, *BINARY])
def test_operation_is_that_of_casadi_where_it_is_a_number(name: str) -> None:
    """Each over values of both signs, zero and one: what casadi says is no command is none here."""
    v, w = ca.SX.sym("phi1"), ca.SX.sym("phi3")
    answer = UNARY[name](v) if name in UNARY else BINARY[name](v, w)
    exact = ca.Function("f", [v, w], [answer])
    scaled = ca.Function("f", [v, w], [0.05, 1e-2 + 1e-4 * answer], ["phi1", "phi3"], ["cc", "cg"])
    law: Any = gy.law_from(ca.Function("g", [v, w], [0.05, ca.fmax(v, 0.0)], ["phi1", "phi3"], ["cc", "cg"]))
    made = law_of_function(scaled, law)
    for a, b in itertools.product((-1.7, -0.4, 0.0, 0.6, 1.0, 2.3), repeat=2):
        expected, y = float(exact(a, b)), gy.Measurement(0.0, 3.14, 70.0, a, b, 0.0, 0.0)
        found = made.step(0.0, y, made.init())[0][1]
        if math.isfinite(expected):
            assert found == pytest.approx(min(max(1e-2 + 1e-4 * expected, 0.0), 0.02), rel=1e-12), (a, b)


def law_of_function(function: ca.Function, like: Any) -> Any:
    """A law of a function that may have no number at the first look."""
    from gyroctl.harness.law_forms.from_casadi import casadi_law

    made = casadi_law(function, (), None, {}, tuple(like.most), like.N, like.period)
    assert isinstance(made, TapeLaw) and len(OPERATIONS) == 40
    return made


# --- functions ---------------------------------------------------------------------------------------------------


class Slow(NamedTuple):
    """State of the function below."""

    speed: float


def governor(t: float, y: Any, state: Slow) -> tuple[tuple[float, float], Slow]:
    """Follow the ring slowly."""
    speed = state.speed + 0.3 * (y.psi_rate - state.speed)
    return (0.06, 4e-4 + GAIN * math.tanh(speed - 3.14)), Slow(speed)


def test_function_with_a_state_is_followed() -> None:
    law: Any = gy.law_from(governor, init=Slow(3.14))
    speed, expected = 3.14, []
    rows = measurements(30)
    for y in rows:
        speed += 0.3 * (y.psi_rate - speed)
        expected.append((0.06, 4e-4 + GAIN * math.tanh(speed - 3.14)))
    np.testing.assert_allclose(commands(law, rows), expected, rtol=1e-14)


def test_arguments_are_what_their_names_say() -> None:
    y = gy.Measurement(0.3, 3.2, 70.0, 0.01, 0.02, 0.1, 0.2)
    c, s = math.cos(0.3), math.sin(0.3)
    expected = {"u1": c * 0.1 - s * 0.2, "u3": s * 0.1 + c * 0.2, "slip": 70.0 - 22.555555555555557 * 3.2}
    expected |= {"float_rate": math.hypot(0.1, 0.2), **y._asdict()}
    assert set(expected) == set(SIGNALS)
    for name, value in expected.items():
        law: Any = gy.law_from(eval(f"lambda {name}: (0.15 + 1e-3 * {name}, 0.0)"))
        assert law.step(0.0, y, law.init())[0][0] == pytest.approx(0.15 + 1e-3 * value, rel=1e-12)
        assert law.information == "sensors" and set(law.sensors) <= set(y._fields)
    clock: Any = gy.law_from(lambda t: (0.05 + 0.01 * t, 0.0))
    assert clock.information == "none" and clock.step(2.0, y, clock.init())[0] == (0.07, 0.0)


# --- all of them -------------------------------------------------------------------------------------------------


def made() -> dict[str, Any]:
    """A law of each form."""
    system = control.ss(A, B, C, D, inputs=list(POINT), outputs=["cg", "cc"])
    return {
        "linear": gy.law_from(system, at=POINT, cc=0.1, cg=1e-3),
        "table": gy.law_from([2e-4, 4e-4, 6e-4], over={"psi_rate": [2.9, 3.1, 3.3]}, cc=0.06, smooth=1.0),
        "casadi": gy.law_from(casadi_filter(), init=(0.0,)),
        "function": gy.law_from(lambda y: (0.06, 4e-4 + 2e-4 * (y.psi_rate - 3.14))),
    }


@pytest.mark.parametrize("form", ["linear", "table", "casadi", "function"])
def test_compiled_law_gives_the_same_bits_as_python(form: str, device: gy.Plant) -> None:
    law, settings = made()[form], Settings(blend=5.0)
    compiled(law)
    waves = lead_in(gy.realise(device, gy.SeaState(), 100000, duration=15.0), settings)
    fast, _ = run_law(device, law, waves, settings)
    plain, _ = run_law(device, law, waves, settings, compiled=False)
    np.testing.assert_array_equal(fast.commands, plain.commands)
    assert len(np.unique(fast.commands[:, 1])) > 50


def test_derivative_of_a_law_is_that_of_what_it_was_made_of() -> None:
    """By which gain and phase margins are found."""
    y = gy.Measurement(0.5, 3.2, 71.0, 0.01, 0.02, 0.1, 0.2)
    laws = made()
    linear = laws["linear"]
    _, by_y, by_state = step_jacobian(linear, 0.0, y, linear.init())
    np.testing.assert_allclose(by_y[1, 1:3], np.array(linear.D).reshape(2, 2)[1], rtol=1e-12)
    np.testing.assert_allclose(by_state[2:4, :2], np.array(linear.A).reshape(2, 2), rtol=1e-12)
    _, by_y, _ = step_jacobian(laws["table"], 0.0, y, laws["table"].init())
    assert by_y[1, 1] == pytest.approx(2e-4 / 0.2)
    state = laws["casadi"].init()._replace(x=(0.3,))
    _, by_y, by_state = step_jacobian(laws["casadi"], 0.0, y, state)
    assert by_y[0, 0] == pytest.approx(0.01 * math.cos(0.5))
    assert by_state[1, 0] == pytest.approx(GAIN / math.cosh(0.3) ** 2)
    follower: Any = gy.law_from(governor, init=Slow(3.14))
    _, by_y, _ = step_jacobian(follower, 0.0, y, Slow(3.14))
    assert by_y[1, 1] == pytest.approx(0.3 * GAIN / math.cosh(0.3 * 0.06) ** 2)


def test_fingerprint_changes_with_the_content_and_with_nothing_else() -> None:
    def scaled(gain: float) -> Any:
        return gy.law_from(lambda y: (0.06, gain * y.psi_rate))

    def system(gain: float) -> Any:
        return gy.law_from(control.ss([], [], [], [[gain]]), reads="psi_rate", sets="cg", cc=0.06)

    def table(gain: float) -> Any:
        return gy.law_from([gain, 2.0 * gain], over={"psi_rate": [3.0, 3.3]}, cc=0.06)

    def symbolic(gain: float) -> Any:
        rate = ca.SX.sym("psi_rate")
        return gy.law_from(ca.Function("f", [rate], [0.06, gain * rate], ["psi_rate"], ["cc", "cg"]))

    for make in (scaled, system, table, symbolic):
        first, again, other = (law_fingerprint(make(gain)) for gain in (1e-4, 1e-4, 2e-4))
        assert first and first == again != other


def test_what_cannot_be_told_is_stored_nowhere() -> None:
    seen: Any = object()
    law = gy.law_from(lambda y: (0.06 if seen else 0.05, 1e-4 * y.psi_rate))
    assert law_fingerprint(law) == ""


def test_check_takes_a_law_and_finds_nothing(device: gy.Plant) -> None:
    from gyroctl.harness.law_check import Question, pure, repeats, shape

    for law in made().values():
        asked = Question(law, tuple(measurements(30)))
        assert all(look.passed for look in (shape(law), pure(asked), repeats(asked)))


@pytest.mark.slow
def test_whole_check_passes_on_each_form(device: gy.Plant) -> None:
    for name, law in made().items():
        failed = [line for line in gy.check_law(law, device, runs=2) if not line.passed and line.name != "step size"]
        assert not failed, name


@pytest.mark.slow
def test_laws_made_in_a_line_have_linear_margins(device: gy.Plant) -> None:
    """A proportional law by three roads has the same multipliers in the loop, and so the same margins."""
    wave = gy.Regular(0.2, 3.14)
    orbit = gy.lock_orbit(device, wave, 0.052, 3.5e-4)
    rate = ca.SX.sym("psi_rate")
    answer = ca.vertcat(0.052, 3.5e-4 + 2e-4 * (rate - 3.14))
    gain = control.ss([], [], [], [[2e-4]], inputs=["psi_rate"], outputs=["cg"])
    laws = [
        gy.law_from(gain, at={"psi_rate": 3.14}, cc=0.052, cg=3.5e-4),
        gy.law_from(ca.Function("f", [rate], [answer], ["psi_rate"], ["u"])),
        gy.law_from(lambda psi_rate: (0.052, 3.5e-4 + 2e-4 * (psi_rate - 3.14))),
    ]
    loops = [close_loop(device, wave, law, orbit, settle=60) for law in laws]
    assert [loop.status for loop in loops] == ["stable"] * 3
    largest = [float(np.abs(loop.multipliers[0])) for loop in loops]
    assert largest == pytest.approx([largest[0]] * 3, rel=1e-8)
    assert largest[0] != pytest.approx(float(np.abs(orbit.multipliers[0])), rel=1e-7)  # it is fed back


@pytest.mark.slow
def test_laws_made_in_a_line_take_part_in_a_comparison(device: gy.Plant) -> None:
    waves = [gy.realise(device, gy.SeaState(), seed, 90.0) for seed in (1, 2)]
    ds = gy.compare(device, made(), waves, gy.Settings(blend=20.0), quiet=True)
    assert not ds.failed.any() and np.isfinite(ds.mean_power).all() and (ds.ledger_residual < 1e-6).all()
