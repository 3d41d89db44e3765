"""`gyroctl laws check`: the example passes, and each fault is found by the check that is there for it."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.harness.law_check import check_law, laws_of
from gyroctl.harness.law_trials import Check

EXAMPLE = Path(__file__).parents[1] / "docs" / "examples" / "my_law.py"
DOCS = Path(__file__).parents[1] / "docs" / "experiment.md"
TEXT = EXAMPLE.read_text()

FAULTS = {
    "a third command": ("answer", "(self.cc, min(max(cg, 0.0), 0.02))", "(self.cc, min(max(cg, 0.0), 0.02), 1.0)"),
    "no state": ("answer", "), State(speed)", "), None"),
    "another kind of state": ("answer", "), State(speed)", "), (speed, 0.0)"),
    "not finite": ("answer", "min(max(cg, 0.0), 0.02)", "math.inf"),
    "raises": ("answer", "cg = self.cg + ", "cg = y.nothing + "),
    "period of its own": ("period", "period: float = 0.1 ", "period: float = 0.25"),
    "fast period": ("period", "period: float = 0.1 ", "period: float = 0.05"),
    "information": ("information", '"sensors"', '"oracle"'),
    "below zero": ("bounds", "min(max(cg, 0.0), 0.02)", "cg - 5e-4"),
    "beyond the limit": ("bounds", "(self.cc,", "(0.06 + 5.0 * max(y.psi_rate - 3.0, 0.0),"),
    "hidden state": ("pure step", "speed = state", "HIDDEN.append(t); speed = 1e-3 * len(HIDDEN) + state"),
    "random numbers": ("repeatable", "speed = state", "speed = random.random() + state"),
    "square root": ("shocks", "cg = self.cg", "cg = 1e-9 * math.sqrt(y.psi_rate + 2.0) + self.cg"),
    "division": ("shocks", "cg = self.cg", "cg = 1e-9 / y.psi_rate + self.cg"),
    "exponential": ("shocks", "cg = self.cg", "cg = 1e-9 * math.exp(abs(y.omega_rate) / 100.0) + self.cg"),
    "poisoned state": ("shocks", "speed = state", "speed = math.exp(min(y.phi1, 1e3)) * 0.0 + state"),
}


def checked(tmp_path: Path, device: gy.Plant, old: str = "", new: str = "", runs: int = 2) -> dict[str, Check]:
    assert old in TEXT
    text = TEXT.replace(old, new) if old else TEXT
    text = text.replace("from typing", "import math\nimport random\nfrom typing", 1).replace(
        "class State", "HIDDEN = []\n\n\nclass State", 1
    )
    (tmp_path / "mine.py").write_text(text)
    return {check.name: check for check in check_law(f"{tmp_path / 'mine.py'}:MyLaw", device, runs)}


def test_example_passes_every_check(device: gy.Plant) -> None:
    found = {check.name: check for check in check_law(f"{EXAMPLE}:MyLaw", device, 2)}
    assert [check for check in found.values() if not check.passed] == []
    for name in (
        "builds",
        "information",
        "period",
        "answer",
        "bounds",
        "pure step",
        "repeatable",
        "compiled",
        "shocks",
        "dropout",
        "step size",
        "cost",
    ):
        assert name in found
    assert "to the last bit" in found["compiled"].found


def test_example_is_short_and_the_one_of_the_docs() -> None:
    body = TEXT[TEXT.index("class State") :]
    assert len([line for line in body.splitlines() if line.strip()]) <= 22
    assert body.strip() in DOCS.read_text()


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_found_by_its_check(fault: str, tmp_path: Path, device: gy.Plant) -> None:
    name, old, new = FAULTS[fault]
    found = checked(tmp_path, device, old, new)
    assert not found[name].passed
    assert found[name].mend


def test_list_of_checks_ends_where_the_law_cannot_run(tmp_path: Path, device: gy.Plant) -> None:
    assert "bounds" not in checked(tmp_path, device, "period: float = 0.1 ", "period: float = 0.25")


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("class MyLaw(NamedTuple)", "class MyLaw", "no NamedTuple"),
        ("speed: float  #", "speed: object  #", "numbers"),
        ("gain: float = 5e-4", "gain: Any = 'high'", "field gain"),
        ("speed = state.speed", "speed = {'a': [0.0]}['a'][0] + state.speed", "Python"),
    ],
)
def test_what_cannot_be_compiled_says_why(tmp_path: Path, device: gy.Plant, old: str, new: str, why: str) -> None:
    text = TEXT.replace("self.gain", "5e-4") if "gain" in old else TEXT
    if "object" in new:  # a state that is no tuple of floats
        text, old, new = text, "State(speed)", "[speed]"
        text = text.replace("State(3.14)", "[3.14]").replace("state.speed", "state[0]")
        why = "no tuple of floats"
    assert old in text
    (tmp_path / "mine.py").write_text(text.replace(old, new))
    found = {check.name: check for check in check_law(f"{tmp_path / 'mine.py'}:MyLaw", device, 2)}
    assert found["compiled"].passed
    if "plain Python" in found["compiled"].found:
        assert why in found["compiled"].found
    else:  # numba has learnt it
        assert "to the last bit" in found["compiled"].found


def test_registered_law_is_checked_too(device: gy.Plant) -> None:
    assert all(check.passed for check in check_law("load_angle", device, 2))


def test_laws_of_a_file(tmp_path: Path) -> None:
    assert laws_of(EXAMPLE) == [f"{EXAMPLE}:MyLaw"]
    (tmp_path / "none.py").write_text("x = 1\n")
    with pytest.raises(gy.InputError, match="defines no class"):
        laws_of(tmp_path / "none.py")
    with pytest.raises(gy.InputError, match="there is no file"):
        laws_of(tmp_path / "missing.py")


@pytest.mark.slow
def test_command_lists_and_checks_and_ends_with_two_on_failure(tmp_path: Path) -> None:
    runner = CliRunner()
    assert "load_angle" in runner.invoke(app, ["laws"]).output
    good = runner.invoke(app, ["laws", "check", str(EXAMPLE), "--runs", "2"])
    assert good.exit_code == 0
    assert "pass" in good.output and "FAIL" not in good.output
    (tmp_path / "mine.py").write_text(TEXT.replace("min(max(cg, 0.0), 0.02)", "-1.0"))
    bad = runner.invoke(app, ["laws", "check", f"{tmp_path}/mine.py:MyLaw", "--runs", "2"])
    assert bad.exit_code == 2
    assert "FAIL" in bad.output
