"""A study that was killed, or moved to another folder, goes on to the same bits."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.engine import Store
from gyroctl.engine.again import compared, withhold
from gyroctl.engine.state import RUNS, state
from gyroctl.engine.steps import Asked, Steps, planned
from gyroctl.harness.registry import build
from gyroctl.tuning.task import read_task
from gyroctl.tuning.tune import _key
from gyroctl.tuning.waters import circumstances_of

LAW = """
from pathlib import Path
from typing import NamedTuple
from moved_gains import CC
CG = float((Path(__file__).parent / "cg.txt").read_text())

class Mine(NamedTuple):
    cc: float = CC
    period: float = 0.1
    information = "none"
    def init(self): return ()
    def step(self, t, y, state): return (self.cc, CG), state
"""

EXPERIMENT = """
[run]
duration = 60.0
blend = 40.0
seeds = [1, 2, 3]

[laws.mine]
law = "mine.py:Mine"

[laws.coupling]
"""

TASK = """
law = "mine.py:Mine"

[knobs]
cc = { start = 0.05, width = 0.2 }
"""


def written(folder: Path) -> Path:
    """A study's folder: experiment, task, law, its module and its table."""
    folder.mkdir(parents=True)
    for name, text in (("mine.py", LAW), ("moved_gains.py", "CC = 0.05\n"), ("cg.txt", "2e-4")):
        (folder / name).write_text(text)
    (folder / "mine.toml").write_text(EXPERIMENT)
    (folder / "task.toml").write_text(TASK)
    return folder


def numbers(folder: Path) -> dict[str, Any]:
    """What is stored, by name, without what a clock measured."""
    found = {}
    for path in Store(folder / RUNS).files():
        record = Store(folder / RUNS).load(path.stem)
        assert record is not None
        values = {name: repr(v) for name, v in record.content["values"].items() if not name.startswith("step_ms")}
        found[path.name] = (values, {name: row.tobytes() for name, row in record.arrays.items()})
    return found


def test_tuning_is_known_wherever_its_law_lies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the texts of the law, of its modules and tables and of the task; a change of one of them is another tuning."""
    on, keys = circumstances_of("linear"), []
    for name in ("here", "there/deeper", "changed"):
        folder = written(tmp_path / name)
        monkeypatch.syspath_prepend(str(folder))
        if name == "changed":
            (folder / "task.toml").write_text(TASK.replace("0.2", "0.3"))
        keys.append(_key(read_task(str(folder / "task.toml")), "all", on))
    assert keys[0] == keys[1] != keys[2]


def test_name_is_a_keyword_and_no_parameter_of_data() -> None:
    assert gy.law(name="constant", cc=0.1) == gy.law("constant", cc=0.1) == build("constant", {"cc": 0.1})
    for table in ({"name": "load_angle"}, {"allow_code": "x.py"}, {"given": 1.0}):
        with pytest.raises(gy.InputError, match="unknown parameter"):
            build("constant", table)


def test_steps_that_are_left_are_told(tmp_path: Path) -> None:
    steps = Steps(tmp_path, "a device", ("gyroctl.studies.margins.measures",), (), "a wave")

    def fails() -> float:
        raise ArithmeticError("no end")

    asked = [Asked(steps, name, name) for name in ("one", "two", "three")]
    with planned(tmp_path, "a wave", asked):
        steps("one", lambda: 1.0)
        with pytest.raises(ArithmeticError):
            steps("two", fails)
    found = {line.law: (line.done, line.failed, line.left) for line in state(tmp_path).lines}
    assert found == {"one": (1, 0, 0), "two": (0, 1, 0), "three": (0, 0, 1)}


def test_step_that_ends_its_study_is_told_as_failed(tmp_path: Path) -> None:
    steps = Steps(tmp_path, "a device", ("gyroctl.studies.margins.measures",), (), "a wave")

    def fails() -> float:
        raise ArithmeticError("no end")

    asked = [Asked(steps, name, name) for name in ("one", "two")]
    with pytest.raises(ArithmeticError), planned(tmp_path, "a wave", asked):
        steps("one", fails)
    one, two = state(tmp_path).lines
    assert (one.law, one.done, one.failed, one.left) == ("one", 0, 1, 0) and "ArithmeticError: no end" in one.why
    assert (two.law, two.done, two.failed, two.left) == ("two", 0, 0, 1)


def test_sample_is_withheld_and_compared_bit_by_bit(tmp_path: Path) -> None:
    folder, copy = tmp_path / "study", tmp_path / "copy"
    steps = Steps(folder / RUNS, "a device", ("gyroctl.studies.margins.measures",), ())
    for name, value in (("one", 0.1 + 0.2), ("two", float("nan"))):
        steps(name, lambda value=value: {"share": value})  # type: ignore[misc]
    clock, key = {"values": {"step_ms": 1.0, "power": 2.0}}, "ab" * 32
    Store(folder / RUNS).save(key, clock, None, {"step": "run"})
    sample = withhold(folder, copy, 1.0, None, 1)
    assert sample.stored == len(sample.records) == 3 and not list(Store(copy / RUNS).files())
    again = Steps(copy / RUNS, "a device", steps.modules, ())
    again("one", lambda: {"share": 0.3})
    again("two", lambda: {"share": float("nan")})
    Store(copy / RUNS).save(key, {"values": {"step_ms": 3.0, "power": 2.0}})
    found = {each.about["step"]: each.differs for each in compared(sample, copy, ("step_ms",))}
    assert len(found["one"]) == 1 and not found["two"] and not found["run"]
    assert len(withhold(folder, tmp_path / "another", 0.1, None, 1).records) == 1
    shutil.rmtree(copy / RUNS)
    assert all("not made again" in each.differs[0] for each in compared(sample, copy))


@pytest.mark.slow
def test_study_goes_on_in_another_folder(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was finished in one is not computed again in the other, and a change of the law's table is seen there."""
    here = written(tmp_path / "here")
    monkeypatch.chdir(here)
    code, _, said = run("compare", "mine.toml", "--out", "out", "--no-search", "--workers", 1)
    assert code == 0, said
    before = numbers(here / "out")
    there = tmp_path / "there"
    shutil.move(here, there)
    lost = sorted((there / "out" / RUNS).glob("*.run"))[0]
    lost.unlink()
    kept = {path: path.stat().st_mtime_ns for path in (there / "out" / RUNS).glob("*.run")}
    monkeypatch.chdir(there)
    code, _, said = run("compare", "mine.toml", "--out", "out", "--no-search", "--workers", 1)
    assert code == 0, said
    assert numbers(there / "out") == before
    assert all(path.stat().st_mtime_ns == at for path, at in kept.items())


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="needs a signal to one process")
def test_killed_study_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    """Killed as soon as something is stored, again and again, until it comes through."""
    whole, killed = written(tmp_path / "whole"), written(tmp_path / "killed")
    command = [sys.executable, "-m", "gyroctl", "compare", "mine.toml", "--out", "out", "--no-search", "--workers", "1"]
    subprocess.run(command, cwd=whole, check=True, capture_output=True)
    kills, place = 0, Store(killed / "out" / RUNS)
    for _ in range(20):
        before = len(list(place.files()))
        running = subprocess.Popen(command, cwd=killed, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        while running.poll() is None and len(list(place.files())) == before:
            time.sleep(0.002)
        if running.poll() is None:
            running.send_signal(signal.SIGKILL)
            kills += 1
        running.communicate()
        if running.returncode == 0:
            break
    assert kills >= 1 and running.returncode == 0
    assert numbers(killed / "out") == numbers(whole / "out")
    assert not [path for path in (killed / "out").rglob("*") if ".part" in path.name]
    told = [json.loads((folder / "out" / "summary.json").read_text())["laws"] for folder in (whole, killed)]
    for name in told[0]:
        assert told[0][name]["mean_power_w"] == told[1][name]["mean_power_w"]


@pytest.mark.slow
def test_margins_are_verified_by_their_command(tmp_path: Path) -> None:
    gyroctl = [sys.executable, "-m", "gyroctl"]
    made = [*gyroctl, "margins", "--no-maps", "--samples", "2", "--out", str(tmp_path / "out")]
    subprocess.run(made, check=True, capture_output=True)
    command = [*gyroctl, "verify", str(tmp_path / "out"), "--share", "1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["verified"] == told["same"] == 1 and "constant controls" in told["runs"][0]["of"]
    store = Store(tmp_path / "out" / RUNS)
    record = store.load(next(store.files()).stem)
    assert record is not None
    text = json.dumps(record.content).replace("0.0", "0.25", 1)
    store.save(record.key, json.loads(text), record.arrays, {**record.about})
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and json.loads(done.stdout)["same"] == 0
