"""The closed loop: one text compiled and as Python, sensors, actuators, laws from files, bad laws refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.actuation import actuate
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.registry import describe, registered
from gyroctl.harness.run import Settings, run_law
from gyroctl.harness.sensing import measure
from gyroctl.harness.start import locked_start
from gyroctl.plant.course import Course, set_out
from gyroctl.plant.kernel import instant
from gyroctl.plant.measurement import CHANNELS, ROWS

Array = NDArray[np.float64]

ROUGH = Settings(
    blend=20.0,
    sensors=gy.Sensors(
        psi=gy.Channel(noise=0.01, quantum=2 * math.pi / 512, delay=1),
        psi_rate=gy.Channel(noise=0.1, dropout=0.1),
        omega_rate=gy.Channel(noise=0.5, bias=1.0, quantum=0.2),
        phi1_rate=gy.Channel(noise=0.02, delay=2, dropout=0.3),
    ),
    actuators=gy.Actuators(
        cc_max=0.2,
        cg_max=0.005,
        cc_lag=0.15,
        cg_lag=0.4,
        cc_rate=0.8,
        cg_rate=0.01,
        cc_quantum=0.004,
        cg_quantum=2e-5,
        delay=2,
    ),
)


@pytest.fixture(scope="module")
def waves(device: gy.Plant) -> gy.WaveRealisation:
    return gy.realise(device, gy.SeaState(), 6, 120.0).blended(20.0)


# --- one text ----------------------------------------------------------------------------------------------------


def test_every_shipped_law_but_the_planner_is_compiled() -> None:
    assert {name for name in registered() if compile_law(gy.law(name)) is None} == {"nmpc"}


@pytest.mark.parametrize("name", sorted(set(registered()) - {"nmpc"}))
@pytest.mark.parametrize("settings", [Settings(blend=20.0), ROUGH], ids=["default", "rough"])
def test_python_loop_has_the_bits_of_the_compiled_loop(
    device: gy.Plant, waves: gy.WaveRealisation, name: str, settings: Settings
) -> None:
    law = gy.law(name)
    one, _ = run_law(device, law, waves, settings, name)
    other, _ = run_law(device, law, waves, settings, name, compiled=False)
    for field in ("states", "commands", "controls"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field))
    assert one.saturations == other.saturations
    assert np.all(np.isfinite(one.states))


def test_a_run_repeats_its_bits_and_follows_its_seed(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = gy.law("load_angle")
    one, two = (run_law(device, law, waves, ROUGH)[0].states for _ in range(2))
    np.testing.assert_array_equal(one, two)
    another = gy.realise(device, gy.SeaState(), 7, 120.0).blended(20.0)
    assert not np.array_equal(run_law(device, law, another, ROUGH)[0].states, one)


def test_closed_loop_follows_the_equations_between_its_samples(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """One held interval by scipy from the recorded state, controls and moments."""
    from scipy.integrate import solve_ivp

    record, _ = run_law(device, gy.law("coupling"), waves, Settings(blend=20.0))
    for sample in (0, 401, 1003):
        u = record.controls[sample]
        near = slice(max(2 * sample - 4, 0), 2 * sample + 7)
        fits = [np.polynomial.Polynomial.fit(waves.time[near], m[near], len(m[near]) - 1) for m in waves.moments]

        def rate(t: float, x: Array, u: Array = u, fits: list[Any] = fits) -> Array:
            return np.asarray(device.derivative(x, u, [fit(t) for fit in fits]), np.float64)

        span = (0.1 * sample, 0.1 * (sample + 1))
        end = solve_ivp(rate, span, record.states[sample, :14], "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
        np.testing.assert_allclose(record.states[sample + 1, :14], end, rtol=2e-5, atol=2e-6)


def test_start_is_the_locked_orbit_or_what_is_given(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    record, _ = run_law(device, gy.law("constant"), waves, Settings(blend=20.0))
    np.testing.assert_array_equal(record.states[0, :14], locked_start(device, waves.sea)[0])
    np.testing.assert_array_equal(record.states[0, 14:], 0.0)
    rest = np.zeros(14)
    record, _ = run_law(device, gy.law("constant"), waves, Settings(blend=20.0), start=rest)
    np.testing.assert_array_equal(record.states[0], 0.0)


def test_law_with_a_longer_period_holds_its_command(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """Three samples of the actuators to one of the law."""
    record, _ = run_law(device, gy.law("load_angle", period=0.3), waves, Settings(blend=20.0))
    commands = record.commands.reshape(400, 3, 2)
    np.testing.assert_array_equal(commands, np.repeat(commands[:, :1], 3, axis=1))
    assert len(np.unique(commands[:, 0, 1])) > 50


@pytest.mark.parametrize("period", [0.25, 0.05, 0.15, 0.0])
def test_period_that_does_not_fit_is_refused(device: gy.Plant, waves: gy.WaveRealisation, period: float) -> None:
    with pytest.raises(gy.InputError, match="multiple of actuators") as caught:
        run_law(device, gy.law("constant", period=period), waves, Settings(blend=20.0), "mine")
    assert caught.value.field == "laws.mine.period"


def test_unstable_step_is_refused_before_anything_runs(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """h * 683 cc > 2.5, by the law's own cc or by the most that the actuator can give."""
    settings = Settings(dt=0.02, blend=20.0)
    with pytest.raises(gy.InputError, match=r"unstable.*dt <=") as caught:
        run_law(device, gy.law("constant", cc=0.25), waves, settings)
    assert caught.value.field == "run.dt"
    with pytest.raises(gy.InputError, match="unstable"):
        run_law(device, UserLaw(lambda t, y, s: ((0.01, 1e-4), s)), waves, settings)
    run_law(device, gy.law("constant", cc=0.052), waves, settings)


# --- sensors -----------------------------------------------------------------------------------------------------


def measured(sensors: gy.Sensors, record: Array, seed: int = 1) -> Array:
    """What a law would see of a record (n, rows): (n, 7)."""
    arrays, y = sensors.arrays(record.shape[0], seed), np.zeros(7)
    out = np.empty((record.shape[0], 7))
    for sample in range(record.shape[0]):
        measure(arrays, sample, record, y)
        out[sample] = y
    return out


@pytest.fixture(scope="module")
def motion() -> Array:
    """A smooth record (2000, 19)."""
    return np.asarray(np.sin(0.05 * np.arange(2000)[:, None] + np.arange(19)) * np.arange(1, 20), np.float64)


def test_ideal_sensors_tell_the_state(motion: Array) -> None:
    np.testing.assert_array_equal(measured(gy.Sensors.ideal(), motion), motion[:, ROWS])
    assert CHANNELS == ("psi", "psi_rate", "omega_rate", "phi1", "phi3", "phi1_rate", "phi3_rate")
    assert ROWS == (2, 6, 7, 0, 1, 4, 5)


def test_default_sensors_have_the_stated_noise(motion: Array) -> None:
    error = measured(gy.Sensors(), motion) - motion[:, ROWS]
    quantum = 2 * math.pi / 4096
    expected = [math.hypot(1e-3, quantum / math.sqrt(12)), 0.02, 0.1, 1e-3, 1e-3, 4e-3, 4e-3]
    np.testing.assert_allclose(np.std(error, axis=0), expected, rtol=0.06)
    assert np.all(np.abs(np.mean(error, axis=0)) < 4 * np.array(expected) / math.sqrt(2000))
    correlation = np.corrcoef(error.T) - np.eye(7)
    assert np.max(np.abs(correlation)) < 0.1
    lagged = np.corrcoef(error[1:, 1], error[:-1, 1])[0, 1]
    assert abs(lagged) < 0.1


def test_bias_quantum_and_delay(motion: Array) -> None:
    sensors = gy.Sensors(
        *[gy.Channel(bias=0.5), gy.Channel(quantum=0.25), gy.Channel(delay=3)], *[gy.Channel() for _ in range(4)]
    )
    seen = measured(sensors, motion)
    np.testing.assert_allclose(seen[:, 0] - motion[:, ROWS[0]], 0.5)
    np.testing.assert_allclose(seen[:, 1] / 0.25, np.round(seen[:, 1] / 0.25), atol=1e-9)
    assert np.max(np.abs(seen[:, 1] - motion[:, ROWS[1]])) <= 0.125 + 1e-12
    np.testing.assert_array_equal(seen[3:, 2], motion[:-3, ROWS[2]])
    np.testing.assert_array_equal(seen[:3, 2], motion[0, ROWS[2]])


def test_dropout_keeps_the_last_value_that_came(motion: Array) -> None:
    channels = {name: gy.Channel(dropout=0.25) for name in CHANNELS}
    seen = measured(gy.Sensors(**channels), motion)
    true = motion[:, ROWS]
    fresh = seen == true
    np.testing.assert_array_equal(fresh[0], True)  # a law never starts blind
    assert np.mean(fresh) == pytest.approx(0.75, abs=0.02)
    for sample in range(1, 2000):
        np.testing.assert_array_equal(seen[sample][~fresh[sample]], seen[sample - 1][~fresh[sample]])


def test_noise_is_that_of_the_realisation_whatever_the_law(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """The same for every law, another for another seed, and not the random numbers of the waves."""
    sensors = gy.Sensors()
    one, same, other = sensors.arrays(500, 3), sensors.arrays(500, 3), sensors.arrays(500, 4)
    np.testing.assert_array_equal(one.error, same.error)
    assert not np.array_equal(one.error, other.error)
    plain = np.random.default_rng(3).standard_normal((500, 7))
    assert abs(np.corrcoef(one.error[:, 1], plain[:, 1])[0, 1]) < 0.2

    class Spy(UserLaw):
        """Notes what it sees."""

    seen: dict[str, list[Any]] = {"a": [], "b": []}

    def spying(key: str, cg: float) -> Any:
        def step(t: float, y: Any, state: Any) -> Any:
            seen[key].append(y)
            return (0.052, cg), state

        return Spy(step)

    records = [
        run_law(device, spying(key, cg), waves, Settings(blend=20.0))[0] for key, cg in (("a", 1e-4), ("b", 1e-3))
    ]
    errors = [
        np.array(seen[key])[:, 3] - record.states[:-1, 0] for key, record in zip(("a", "b"), records, strict=True)
    ]
    np.testing.assert_allclose(errors[0], errors[1], atol=1e-12)
    assert np.std(errors[0]) == pytest.approx(1e-3, rel=0.1)


@pytest.mark.parametrize(
    ("field", "channel"),
    [
        ("sensors.phi1.noise", {"noise": -1.0}),
        ("sensors.phi1.quantum", {"quantum": -0.1}),
        ("sensors.phi1.delay", {"delay": -1}),
        ("sensors.phi1.delay", {"delay": 1.5}),
        ("sensors.phi1.dropout", {"dropout": 1.0}),
        ("sensors.phi1.dropout", {"dropout": -0.1}),
        ("sensors.phi1.bias", {"bias": math.nan}),
        ("sensors.phi1.noise", {"noise": "much"}),
        ("sensors.phi1.noise", {"noise": math.inf}),
    ],
)
def test_bad_sensor_is_named(field: str, channel: dict[str, Any]) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.Sensors(phi1=gy.Channel(**channel))
    assert caught.value.field == field and caught.value.mend


# --- actuators ---------------------------------------------------------------------------------------------------


def actuated(actuators: gy.Actuators, commands: Array, before: tuple[float, float] = (0.0, 0.0)) -> tuple[Array, int]:
    """Controls (n, 2) at the end of each interval after the commands (n, 2), and how many saturated."""
    held, aim, out, count = np.array(before), np.array(before), np.empty_like(commands), 0
    arrays, course = actuators.arrays(), Course(*np.zeros((6, 2)))
    for sample in range(commands.shape[0]):
        count += actuate(arrays, sample, commands, aim)
        set_out(course, arrays.lag, arrays.rate, held, aim)
        held = np.array(instant(course, actuators.period))
        out[sample] = held
    return out, count


COMMANDS = np.random.default_rng(5).uniform([0.0, 0.0], [0.3, 0.02], (200, 2))


def test_plain_actuators_give_what_is_asked_for_to_the_bit() -> None:
    controls, count = actuated(gy.Actuators(), COMMANDS)
    np.testing.assert_array_equal(controls, COMMANDS)
    assert count == 0


def test_limits_clip_and_count_each_channel() -> None:
    commands = np.array([[0.1, 0.01], [0.4, 0.01], [-0.1, 0.03], [0.3, 0.02], [0.0, -1e-9]])
    controls, count = actuated(gy.Actuators(), commands)
    np.testing.assert_array_equal(controls, np.clip(commands, 0.0, [0.3, 0.02]))
    assert count == 1 + 2 + 0 + 1


def test_lag_is_a_first_order_response_to_a_step() -> None:
    """1 - exp(-t/T) at the samples, also from above."""
    steps = np.tile([0.2, 0.01], (30, 1))
    up, _ = actuated(gy.Actuators(cc_lag=0.5, cg_lag=1.0), steps)
    time = 0.1 * np.arange(1, 31)
    np.testing.assert_allclose(up[:, 0], 0.2 * (1 - np.exp(-time / 0.5)), rtol=1e-12)
    np.testing.assert_allclose(up[:, 1], 0.01 * (1 - np.exp(-time / 1.0)), rtol=1e-12)
    down, _ = actuated(gy.Actuators(cc_lag=0.5), np.zeros((30, 2)), (0.2, 0.0))
    np.testing.assert_allclose(down[:, 0], 0.2 * np.exp(-time / 0.5), rtol=1e-12)


def test_rate_limit_is_a_ramp_that_arrives_exactly() -> None:
    controls, _ = actuated(gy.Actuators(cc_rate=0.3, cg_rate=0.05), np.tile([0.1, 0.02], (10, 1)))
    np.testing.assert_allclose(controls[:, 0], [0.03, 0.06, 0.09, *[0.1] * 7], rtol=1e-12)
    assert controls[3, 0] == 0.1 and controls[-1, 1] == 0.02


def test_rate_limit_holds_under_any_command_and_with_lag() -> None:
    controls, _ = actuated(gy.Actuators(cc_rate=0.5, cg_rate=0.02, cc_lag=0.05), COMMANDS)
    change = np.abs(np.diff(controls, axis=0, prepend=0.0))
    assert np.all(change <= np.array([0.05, 0.002]) * (1 + 1e-12))
    assert np.all((controls >= 0.0) & (controls <= [0.3, 0.02]))


def test_quantum_rounds_to_nearest_and_stays_within_the_limit() -> None:
    controls, _ = actuated(gy.Actuators(cc_quantum=0.04, cg_quantum=0.003), COMMANDS)
    inside = controls < np.array([0.3, 0.02])
    levels = controls / [0.04, 0.003]
    np.testing.assert_allclose(levels[inside], np.round(levels[inside]), atol=1e-9)
    assert np.all(controls <= [0.3, 0.02])
    assert np.all(np.abs(controls - COMMANDS) <= np.array([0.02, 0.0015]) + 1e-12)


def test_delay_lets_commands_act_later() -> None:
    controls, _ = actuated(gy.Actuators(delay=3), COMMANDS)
    np.testing.assert_array_equal(controls[3:], COMMANDS[:-3])
    np.testing.assert_array_equal(controls[:3], 0.0)  # none of them acts yet


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("cc_max", 0.0),
        ("cc_max", -0.1),
        ("cg_max", math.nan),
        ("period", 0.0),
        ("period", -0.1),
        ("cc_lag", -1.0),
        ("cg_rate", -1.0),
        ("cc_quantum", math.inf),
        ("delay", -1),
        ("delay", 0.5),
        ("cc_max", "0.3"),
        ("delay", True),
    ],
)
def test_bad_actuator_is_named(field: str, value: Any) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.Actuators(**{field: value})
    assert caught.value.field == f"actuators.{field}" and caught.value.mend


def test_saturations_of_a_run_are_counted(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    settings = Settings(blend=20.0, actuators=gy.Actuators(cg_max=3e-4))
    record, _ = run_law(device, gy.law("constant", cg=5e-4), waves, settings)
    assert record.saturations == 1200
    np.testing.assert_array_equal(record.controls[:, 1], 3e-4)
    np.testing.assert_array_equal(record.commands[:, 1], 5e-4)


# --- laws --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class UserLaw:
    """Any function as a law, run as plain Python."""

    call: Callable[[float, Any, Any], Any]
    period: float = 0.1
    information: Any = "sensors"

    def init(self) -> Any:
        return None

    def step(self, t: float, y: Any, state: Any) -> Any:
        return self.call(t, y, state)


class Faulty(NamedTuple):
    """A compiled law that divides by zero after ten seconds."""

    period: float = 0.1

    @property
    def information(self) -> Literal["none"]:
        return "none"

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
        return (0.05, 1e-4 / (t - 10.0) * (t - 10.0)), state


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ((0.05, 1e-4), "expected"),  # state forgotten
        ((0.05, None), "expected"),
        (((0.05,), None), "expected"),
        (((0.05, 1e-4, 0.0), None), "expected"),
        ((("much", 1e-4), None), "expected"),
        (None, "expected"),
        ((np.zeros((2, 2)), None), "expected"),
        (((math.nan, 1e-4), None), "not finite"),
        (((0.05, math.inf), None), "not finite"),
        ((np.array([0.05, math.nan]), None), "not finite"),
    ],
)
def test_law_that_breaks_the_protocol_is_named(
    device: gy.Plant, waves: gy.WaveRealisation, answer: Any, words: str
) -> None:
    def step(t: float, y: Any, state: Any) -> Any:
        return answer if t > 2.0 else ((0.05, 1e-4), state)

    with pytest.raises(gy.LawError, match=words) as caught:
        run_law(device, UserLaw(step), waves, Settings(blend=20.0), "mine")
    assert "'mine'" in str(caught.value) and "t = 2.1 s" in str(caught.value)


@pytest.mark.parametrize("compiled", [True, False])
def test_compiled_law_that_is_not_finite_is_named(device: gy.Plant, waves: gy.WaveRealisation, compiled: bool) -> None:
    """0/0 at t = 10 s; Python itself would raise, the compiled law gives NaN: both must end in a LawError."""
    with pytest.raises(gy.LawError, match=r"'faulty'.*t = 10\.0 s"):
        run_law(device, Faulty(), waves, Settings(blend=20.0), "faulty", compiled=compiled)


class Forgetful(NamedTuple):
    """Looks like a compiled law, but returns the command without the state."""

    period: float = 0.1

    @property
    def information(self) -> Literal["none"]:
        return "none"

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: Any) -> Any:
        return 0.05, 1e-4


def test_wrong_shape_of_a_law_that_would_be_compiled_is_named_too(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    with pytest.raises(gy.LawError, match=r"'mine' returned \(0\.05, 0\.0001\) at t = 0\.0 s.*Return"):
        run_law(device, Forgetful(), waves, Settings(blend=20.0), "mine")


def test_error_inside_a_law_names_its_file_and_line(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = UserLaw(lambda t, y, s: ((y.psi_rate_filtered, 1e-4), s))
    with pytest.raises(gy.LawError, match=r"'mine' failed at t = 0\.0 s: AttributeError.*test_harness\.py:\d+"):
        run_law(device, law, waves, Settings(blend=20.0), "mine")


def test_numbers_of_numpy_are_numbers(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = UserLaw(lambda t, y, s: (np.array([0.052, 3.5e-4]), s))
    one, _ = run_law(device, law, waves, Settings(blend=20.0))
    two, _ = run_law(device, gy.law("constant", cc=0.052, cg=3.5e-4), waves, Settings(blend=20.0))
    np.testing.assert_array_equal(one.states, two.states)


USER_FILE = '''
from typing import Any, Literal, NamedTuple


class Memory(NamedTuple):
    last: float


class Mine(NamedTuple):
    """A user's law."""

    gain: float = 1e-5
    period: float = 0.1
    information = "sensors"

    def init(self) -> Memory:
        return Memory(0.0)

    def step(self, t: float, y: Any, state: Memory) -> Any:
        speed = 0.9 * state.last + 0.1 * y.omega_rate
        return (0.06, max(self.gain * speed, 0.0)), Memory(speed)


class NoStep:
    period, information = 0.1, "none"

    def init(self) -> None: ...


class Knowing(Mine):
    information = "everything"


number = 3
'''


@pytest.fixture
def user_file(tmp_path: Path) -> Path:
    file = tmp_path / "my_law.py"
    file.write_text(USER_FILE)
    return file


def test_law_from_a_users_file_runs_compiled_and_as_python(
    device: gy.Plant, waves: gy.WaveRealisation, user_file: Path
) -> None:
    law = gy.law(f"{user_file}:Mine", gain=8e-6)
    assert describe(law) == {"gain": 8e-6, "period": 0.1}
    assert compile_law(law) is not None
    one, _ = run_law(device, law, waves, Settings(blend=20.0))
    other, _ = run_law(device, law, waves, Settings(blend=20.0), compiled=False)
    np.testing.assert_array_equal(one.states, other.states)
    assert np.all(one.controls[:, 0] == 0.06)


@pytest.mark.parametrize(
    ("name", "field", "words"),
    [
        ("cunning", "law", "unknown law.*constant"),
        ("", "law", "unknown law"),
        ("nowhere.py:Mine", "law", "there is no file nowhere.py"),
        ("{file}:Yours", "law", "defines no Yours"),
        ("{file}:NoStep", "law", "has no `step`"),
        ("{file}:Knowing", "information", "unknown level"),
    ],
)
def test_bad_name_of_a_law_says_what_there_is(user_file: Path, name: str, field: str, words: str) -> None:
    with pytest.raises(gy.InputError, match=words) as caught:
        gy.law(name.format(file=user_file))
    assert field in caught.value.field


def test_name_in_a_file_that_is_no_law_is_refused(user_file: Path) -> None:
    with pytest.raises(gy.InputError):
        gy.law(f"{user_file}:number")


@pytest.mark.parametrize("text", ["def broken(:\n", "import a_module_that_is_not_there\n", "1 / 0\n"])
def test_file_that_cannot_be_imported_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "bad.py"
    file.write_text(text)
    with pytest.raises(gy.InputError, match="cannot be imported"):
        gy.law(f"{file}:Mine")


@pytest.mark.parametrize(
    ("name", "parameters", "field"),
    [
        ("constant", {"cd": 0.1}, "laws.constant.cd"),
        ("constant", {"cc": -0.1}, "laws.constant.cc"),
        ("constant", {"cg": -1e-4}, "laws.constant.cg"),
        ("constant", {"cc": math.nan}, "laws.constant.cc"),
        ("constant", {"cc": "big"}, "laws.constant.cc"),
        ("constant", {"cc": True}, "laws.constant.cc"),
        ("load_angle", {"share": math.inf}, "laws.load_angle.share"),
        ("best_constant", {"gamma": -1.0}, "laws.best_constant"),
    ],
)
def test_bad_parameter_of_a_law_is_named(name: str, parameters: dict[str, Any], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.law(name, **parameters)
    assert caught.value.field.startswith(field) and caught.value.mend


def test_every_registered_law_keeps_the_protocol() -> None:
    """A state that passes through, two numbers, a level of information, and the shipped tuning as its default."""
    names = registered()
    assert {"constant", "best_constant", "load_angle", "coupling"} <= set(names)
    for name in names:
        law = gy.law(name)
        assert isinstance(law, gy.Law)
        assert law.information in ("none", "sensors", "forecast", "oracle")
        y = gy.Measurement(1.0, 3.1, 69.0, 0.05, 0.1, 0.1, -0.2)
        (cc, cg), state = law.step(0.0, y, law.init())
        (again, _), _ = law.step(0.0, y, law.init()), state
        assert again == (cc, cg), "a step must not change the law"
        assert math.isfinite(cc) and math.isfinite(cg)


def test_blend_is_put_in_once(device: gy.Plant) -> None:
    plain = gy.realise(device, gy.SeaState(), 2, 60.0)
    settings = Settings(blend=20.0)
    one = gy.simulate(device, gy.law("constant"), plain, settings)
    two = gy.simulate(device, gy.law("constant"), plain.blended(20.0), settings)
    assert one.attrs["sha256"] == two.attrs["sha256"] == plain.blended(20.0).sha256
    np.testing.assert_array_equal(one.phi3, two.phi3)
    unblended = gy.simulate(device, gy.law("constant"), plain, Settings(blend=0.0))
    assert unblended.attrs["sha256"] == plain.sha256
