"""Laws in the loop: what breaks the protocol is named, laws from files, names and parameters, registered laws."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest
from user_law import UserLaw

import gyroctl as gy
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.registry import describe, registered
from gyroctl.harness.run import Settings, run_law

# --- the protocol ------------------------------------------------------------------------------------------------


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
    with pytest.raises(gy.LawError, match=r"'mine' failed at t = 0\.0 s: AttributeError.*test_harness_laws\.py:\d+"):
        run_law(device, law, waves, Settings(blend=20.0), "mine")


def test_numbers_of_numpy_are_numbers(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = UserLaw(lambda t, y, s: (np.array([0.052, 3.5e-4]), s))
    one, _ = run_law(device, law, waves, Settings(blend=20.0))
    two, _ = run_law(device, gy.law("constant", cc=0.052, cg=3.5e-4), waves, Settings(blend=20.0))
    np.testing.assert_array_equal(one.states, two.states)


# --- laws from files ---------------------------------------------------------------------------------------------

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


# --- registered laws ---------------------------------------------------------------------------------------------


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
