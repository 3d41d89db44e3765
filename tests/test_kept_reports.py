"""Reports that keep what is finished and name what failed, and the margins in Python."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.errors import without_addresses
from gyroctl.loop_margins.closed_loop_orbit import close_loop
from gyroctl.loop_margins.dual_numbers import NotDifferentiable, step_jacobian
from gyroctl.loop_margins.margins import loop_margins
from gyroctl.robustness.shocks import Shock
from gyroctl.statistics import Share
from gyroctl.studies.evaluation.report import TABLES, evaluate_tables
from gyroctl.studies.evaluation.request import request as evaluation_request
from gyroctl.studies.margins import margin_report, measures, request
from gyroctl.writing import Kept

WAVE = gy.Regular(0.2, 3.14)

LAWS = """
import math
from typing import NamedTuple


class One(NamedTuple):
    value: float


class Tupled(NamedTuple):
    cc: float = 0.06
    cg: float = 4e-4
    period: float = 0.1

    @property
    def information(self):
        return "sensors"

    def init(self):
        return One(3.14)

    def step(self, t, y, state):
        speed = state.value + 0.1 * (y.psi_rate - state.value)
        return (self.cc, min(max(self.cg + 2e-4 * (speed - 3.14), 0.0), 0.02)), One(speed)


class Bare(Tupled):
    def init(self):
        return 3.14

    def step(self, t, y, state):
        speed = state + 0.1 * (y.psi_rate - state)
        return (self.cc, min(max(self.cg + 2e-4 * (speed - 3.14), 0.0), 0.02)), speed


class Counter(Tupled):
    def init(self):
        return One(0.0)

    def step(self, t, y, state):
        return (self.cc, min(max(self.cg + 2e-4 * (y.psi_rate - 3.14), 0.0), 0.02)), One(state.value + 1.0)


class Rounded(Counter):
    def step(self, t, y, state):
        command, counted = Counter.step(self, t, y, state)
        return command, One(math.floor(counted.value + 0.5))


class Dead(Tupled):
    def step(self, t, y, state):
        if t > 300.0:
            raise RuntimeError(f"no more of {object()}")
        return (self.cc, self.cg), state
"""


@pytest.fixture(scope="module")
def laws(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("laws") / "laws.py"
    file.write_text(LAWS)
    return file


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the nonlinear measures, which take their time and are tested elsewhere."""
    found = {1.0: Share(1.0, 0.5, 1.0, 4)}, (Shock("psi", 1, 2.0, 3.0),)
    monkeypatch.setattr(measures, "_hit", lambda regime, samples, tick: found)
    monkeypatch.setattr(measures, "DIRECTIONS", measures.DIRECTIONS[:2])
    monkeypatch.setattr("gyroctl.studies.margins.draw_robustness.robustness", lambda *_: _figure())
    monkeypatch.setattr("gyroctl.studies.margins.result.meanings", lambda *_: {})
    monkeypatch.setattr("gyroctl.studies.margins.report.meanings", lambda *_: {})


def _figure() -> Any:
    from matplotlib.figure import Figure

    return Figure()


# --- states of laws ----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_bare_number_as_state_has_the_margins_of_the_same_law_with_a_tuple(device: gy.Plant, laws: Path) -> None:
    start = gy.lock_orbit(device, WAVE, 0.052, 3.5e-4)
    bare, tupled = (close_loop(device, WAVE, gy.law(f"{laws}:{name}"), start) for name in ("Bare", "Tupled"))
    assert bare.status == tupled.status == "stable"
    np.testing.assert_allclose(bare.multipliers, tupled.multipliers, rtol=1e-12, atol=1e-14)
    one, two = loop_margins(bare).channels, loop_margins(tupled).channels
    assert all(one[name].disk == pytest.approx(two[name].disk, rel=1e-9) for name in two)


@pytest.mark.parametrize("name", ["Counter", "Rounded"])
def test_counter_in_the_state_gives_a_status_with_advice(device: gy.Plant, laws: Path, name: str) -> None:
    loop = close_loop(device, WAVE, gy.law(f"{laws}:{name}"), gy.lock_orbit(device, WAVE, 0.052, 3.5e-4))
    assert loop.status == "not periodic" and "multiplier of 1" in loop.advice and "counter" in loop.advice


def test_state_that_is_no_number_is_named_by_its_kind(laws: Path) -> None:
    y = gy.Measurement(0.0, 3.14, 65.0, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(NotDifferentiable, match="holds dict"):
        step_jacobian(gy.law(f"{laws}:Tupled"), 0.0, y, {"speed": 3.0})


def test_texts_of_errors_have_no_addresses() -> None:
    text = without_addresses(f"must be real number, not {object()!r} at all, {print!r}")
    assert text == "must be real number, not object at all, <built-in function print>"


# --- what is finished is kept ------------------------------------------------------------------------------------


def test_stages_are_on_the_disk_as_they_end(tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    kept = Kept({}, path)
    with kept.stage("one"):
        kept.content["one"] = 1
    assert json.loads(path.read_text()) == {"one": 1, "failed": {}}
    with kept.stage("two"):
        raise RuntimeError(f"because of {object()!r}")
    with kept.stage("three"):
        kept.content["three"] = 3
    found = json.loads(path.read_text())
    assert found["one"] == 1 and found["three"] == 3
    assert found["failed"]["two"].startswith("RuntimeError: because of object (test_kept_reports.py, line ")
    with pytest.raises(KeyboardInterrupt), kept.stage("four"):
        raise KeyboardInterrupt
    assert json.loads(path.read_text()) == found


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_margins_of_a_law_that_fails_keep_those_of_the_constant_controls(
    tmp_path: Path, laws: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["margins", "--no-maps", "--law", f"{laws}:Dead", "--out", str(out)])
    assert done.exit_code == 1 and "Failed: law:" in done.output
    content = json.loads((out / "margins.json").read_text())
    assert content["constant_controls"]["power_w"] > 1.0
    assert "RuntimeError" in content["failed"]["law"] and " at 0x" not in json.dumps(content)
    assert {"margin": "law", "reason": content["failed"]["law"]} in content["not_available"]
    assert "multipliers.png" in content["figures"] and (out / "multipliers.png").is_file()


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("stage", ["linear_margins", "law_margins"])
def test_failing_stage_of_the_margins_leaves_the_others(
    stage: str, tmp_path: Path, laws: Path, device: gy.Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(measures, stage, broken)
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4, 1, f"{laws}:Tupled")
    content = margin_report(asked, tmp_path, 4, maps=False, quiet=True)
    failed = {"linear_margins": "law.linear", "law_margins": "law"}[stage]
    assert list(content["failed"]) == [failed] and "Singular matrix" in content["failed"][failed]
    kept = "headroom" if stage == "linear_margins" else "linear"
    assert kept in content["law"] and "constant_controls" in content
    assert json.loads((tmp_path / "margins.json").read_text()) == content


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_margins_in_python(device: gy.Plant) -> None:
    """Numbers as attributes: those of the orbit and of the loop, found without the study."""
    found = gy.margins(device, WAVE, 0.052, 3.5e-4, "load_angle", samples=4, quiet=True)
    orbit = gy.lock_orbit(device, WAVE, 0.052, 3.5e-4)
    loop = loop_margins(close_loop(device, WAVE, gy.law("load_angle"), orbit)).channels
    assert found.status == "stable" and found.failed == {}
    own = close_loop(device, WAVE, gy.law("load_angle"), orbit)
    assert (found.load_angle, found.lock_reserve) == (own.load_angle, own.lock_reserve)
    assert found.loop_status == "stable" and found.lock_share > 3.0 * orbit.lock_share, "the law loads the ring more"
    assert found.orbit.lock_reserve == orbit.lock_reserve, "that of the constant controls stands with their orbit"
    assert f"lock reserve {own.lock_reserve:.4g}" in " ".join(repr(found).split())
    single = [each for each in loop.values() if len(each.channels) == 1]
    assert found.disk == pytest.approx(min(each.disk for each in single), rel=1e-9)
    assert found.delay == min(each.delay for each in single)
    assert found.phase == pytest.approx(min(each.phase for each in single))
    assert found.gain[0] == max(each.gain[0] for each in single)
    assert found.channels["cg"].gain == pytest.approx(loop["cg"].gain)
    assert found.height_headroom == found.headroom["height"].decibel > 3.0
    assert found.basin[1.0].value == 1.0 and found.shocks[0].state == "psi"
    assert found.record()["law"]["linear"]["channels"]["cg"]["disk_alpha"] == found.channels["cg"].disk
    for picture in ("robustness", "multipliers", "nyquist"):
        assert type(found.plot(picture)).__name__ == "Figure"
    with pytest.raises(gy.InputError, match="no such picture"):
        found.plot("lines")


@pytest.mark.usefixtures("quick")
def test_margins_of_constant_controls_and_of_a_law_object(device: gy.Plant) -> None:
    alone = gy.margins(device, WAVE, 0.052, 3.5e-4, samples=4, quiet=True)
    orbit = gy.lock_orbit(device, WAVE, 0.052, 3.5e-4)
    assert alone.power == orbit.power and alone.cg_headroom > 20.0
    assert math.isnan(alone.disk) and alone.channels == {} and math.isnan(alone.gain[0])
    with pytest.raises(gy.InputError, match="no numbers to show"):
        alone.plot("nyquist")
    same = gy.law("constant", cc=0.052, cg=3.5e-4)
    law = gy.margins(device, WAVE, 0.052, 3.5e-4, same, samples=4, quiet=True)
    assert law.power == pytest.approx(orbit.power, rel=1e-3)
    assert law.lock_share == pytest.approx(orbit.lock_share, rel=1e-6), "one definition of the share for both"
    assert law.load_angle == pytest.approx(orbit.load_angle, rel=1e-6)
    assert law.decay_time == pytest.approx(orbit.modes[0].decay_time, rel=1e-3)


def test_evaluation_without_a_case_that_runs_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every case refused: once the picture of no columns was what the user heard of."""

    def refused(*_: object, **__: object) -> None:
        raise gy.InputError("sea.hs", 0.1, "no lock begins here", "Choose another")

    for room in ("seas", "offdesign", "robustness", "information"):
        monkeypatch.setattr(f"gyroctl.studies.evaluation.{room}.run_case", refused)
    ask = evaluation_request(tmp_path, "coupling", ["1:4"], quiet=True)
    for name in ("seas", "robustness"):
        with pytest.raises(gy.InputError, match="no lock begins here"):
            evaluate_tables([name], ask)
        assert "no lock begins here" in (tmp_path / f"{name}.md").read_text()


def test_table_that_fails_does_not_stop_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(ask: object) -> None:
        raise ValueError("Number of columns must be a positive integer")

    made: Any = lambda ask: ({"failed": {}}, "text", _figure())  # noqa: E731
    monkeypatch.setitem(TABLES, "seas", fails)  # type: ignore[arg-type]
    monkeypatch.setitem(TABLES, "robustness", made)
    ask = evaluation_request(tmp_path, "coupling", ["1:4"], quiet=True)
    found = evaluate_tables(["seas", "robustness"], ask)
    assert "Number of columns" in found["seas"]["failed"]["the whole table"]
    assert found["robustness"]["failed"] == {} and (tmp_path / "robustness.md").is_file()
    assert json.loads((tmp_path / "seas.json").read_text())["failed"]
    with pytest.raises(ValueError, match="Number of columns"):
        evaluate_tables(["seas"], ask)


def test_tuning_that_fails_does_not_stop_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gyroctl.tuning.tune import Tuned

    def tuned(task: Any, *_: object, **__: object) -> Tuned:
        if task.law == "coupling":
            raise gy.LawError("law 'coupling' failed at t = 3.0 s")
        return Tuned({})

    monkeypatch.setattr("gyroctl.tuning.tune.tune", tuned)
    monkeypatch.setattr("gyroctl.cli.tune._front", lambda *_: None)
    monkeypatch.setattr("gyroctl.cli.tune._table", lambda *_: None)
    done = CliRunner().invoke(app, ["tune", "coupling", "constant", "--out", str(tmp_path)])
    assert done.exit_code == 1 and "Failed: coupling for all: law 'coupling' failed" in done.output
    assert (tmp_path / "constant.json").is_file() and not (tmp_path / "coupling.json").exists()
    done = CliRunner().invoke(app, ["tune", "coupling", "--out", str(tmp_path)])
    assert isinstance(done.exception, gy.LawError) and "failed at t = 3.0 s" in str(done.exception)


def test_window_that_fails_is_named_and_the_others_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gyroctl.studies.bound import report
    from gyroctl.studies.bound.report import bound_report

    class Outcome:
        def __init__(self, one: Any, seed: int) -> None:
            self.seed = seed

        def record(self) -> dict[str, Any]:
            return {"seed": self.seed}

    def searched(one: Any, *_: object) -> tuple[int]:
        if one.waves.seed == 2:
            raise gy.InputError("seeds", 2, "nothing found keeps the lock", "Choose another seed")
        return (one.waves.seed,)

    class Cut:
        duration = 100.0

        def __init__(self, seed: int) -> None:
            self.waves = type("Waves", (), {"seed": seed})

    unkept = report.Steps(tmp_path / "runs", "", report.MODULES, report.KINDS, "device")
    monkeypatch.setattr(report, "model_cut", lambda plant, sea, seed, duration, *_: Cut(seed))
    monkeypatch.setattr(report, "_steps", lambda *_: unkept)
    monkeypatch.setattr(report, "_searched", searched)
    monkeypatch.setattr(report, "Outcome", Outcome)
    monkeypatch.setattr(report, "summary", lambda records: {"windows": len(records)})
    monkeypatch.setattr(report, "picture", lambda *_: _figure())
    sea = gy.SeaState()
    content = bound_report(gy.zhang2017(), sea, [1, 2, 3], 100.0, {}, tmp_path, quiet=True)
    assert [window["seed"] for window in content["windows"]] == [1, 3]
    assert "nothing found keeps the lock" in content["failed"]["seed 2"]
    assert json.loads((tmp_path / "bound.json").read_text()) == content
    with pytest.raises(gy.InputError, match="nothing found keeps the lock"):
        bound_report(gy.zhang2017(), sea, [2], 100.0, {}, tmp_path / "none", quiet=True)
