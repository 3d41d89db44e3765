"""Steps of tunings that are kept: `gyroctl status` tells what is left, `gyroctl verify` computes a sample again."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from command_line import Run

from gyroctl.tuning.log import TuningLog
from gyroctl.tuning.stages import Plan as Budget
from gyroctl.tuning.steps_kept import compared, done, noted, withhold

STEPS = {"search 0": [[0.1 + 0.2, float("inf")]], "search 1": [[1.0]], 'confirm {"cc": 0.05}': [[2.0]]}

TASK = """
law = "coupling"
[knobs]
through1 = { start = 2.2, width = 0.2 }
[seas.mild]
hs = 0.25
gamma = 5.0
power = 2.0
runs = 1
[search]
population = 4
window = 160.0
confirm = 200.0
runs = 1
[seeds]
first = 100128
count = 2
"""


def tuned(folder: Path, steps: int = 3) -> AbstractContextManager[None]:
    """A folder with so many steps of a tuning that is not at its end."""
    log = TuningLog(folder / "law.all.jsonl")
    plan = noted(folder, log, "law for all", Budget(3, 2, 1.0, 1.0))
    plan.__enter__()
    for key, value in list(STEPS.items())[:steps]:
        log.add(key, value)
    return plan


def test_status_tells_the_steps_that_are_left(tmp_path: Path, run: Run) -> None:
    plan = tuned(tmp_path)
    code, out, said = run("status", tmp_path)
    told = json.loads(out)
    assert code == 0 and told["running"], said
    counts = {line["law"]: (line["done"], line["left"]) for line in told["lines"]}
    assert counts == {"search": (2, 1), "confirm": (1, 1)}
    plan.__exit__(None, None, None)  # of points that were the same one was confirmed
    told = json.loads(run("status", tmp_path)[1])
    assert not told["running"] and sum(line["left"] for line in told["lines"]) == 0


def test_step_at_which_a_tuning_fails_is_told(tmp_path: Path, run: Run) -> None:
    log = TuningLog(tmp_path / "law.all.jsonl")
    with pytest.raises(ArithmeticError), noted(tmp_path, log, "law for all", Budget(3, 2, 1.0, 1.0)):
        log.add("search 0", STEPS["search 0"])
        raise ArithmeticError("no end")
    search = next(line for line in json.loads(run("status", tmp_path)[1])["lines"] if line["law"] == "search")
    assert (search["done"], search["failed"], search["left"]) == (1, 1, 1) and "no end" in search["why"]


def test_steps_are_withheld_and_compared_bit_by_bit(tmp_path: Path) -> None:
    tuned(tmp_path / "out")
    sample = withhold(tmp_path / "out", tmp_path / "copy", 1.0, None, 1)
    assert sample.stored == len(sample.steps) == 3 and not done(tmp_path / "copy")
    assert all("numpy" in step.made["made_with"] for step in sample.steps)
    log = TuningLog(tmp_path / "copy" / "law.all.jsonl")
    log.add("search 0", [[0.3, float("inf")]])
    log.add("search 1", [[1.0]])
    differs = [
        each.differs for each in sorted(compared(sample.steps, tmp_path / "copy"), key=lambda e: e.about["step"])
    ]
    assert differs[0][0].startswith("not made again") and differs[1] == ("its numbers",) and differs[2] == ()
    assert len(withhold(tmp_path / "out", tmp_path / "less", 0.01, None, 1).steps) == 1
    assert len(TuningLog(tmp_path / "less" / "law.all.jsonl").steps) == 2


def test_tunings_that_cannot_be_verified_are_refused(tmp_path: Path, run: Run) -> None:
    tuned(tmp_path)
    code, _, said = run("verify", tmp_path)
    assert code == 2 and "does not say of which command" in said
    code, _, said = run("verify", tmp_path, "--command", "tune coupling")
    assert code == 2 and "not finished" in said


@pytest.mark.slow
def test_tuning_is_verified_by_its_command(tmp_path: Path) -> None:
    """An edited number under a checksum of its own is found by computing it again."""
    (tmp_path / "task.toml").write_text(TASK)
    gyroctl = [sys.executable, "-m", "gyroctl"]
    made = [*gyroctl, "tune", "task.toml", "--budget", "4000", "--workers", "1", "--out", "out"]
    subprocess.run(made, cwd=tmp_path, check=True, capture_output=True)
    (log,) = (tmp_path / "out").glob("*.jsonl")
    verify = [*gyroctl, "verify", "out", "--share", "1"]
    whole = subprocess.run(verify, cwd=tmp_path, capture_output=True, text=True, check=False)
    told = json.loads(whole.stdout)
    assert whole.returncode == 0 and told["verified"] == told["same"] == len(TuningLog(log).steps) >= 4, whole.stderr
    steps = TuningLog(log).steps
    last = next(key for key in steps if key.startswith("confirm"))
    steps[last][0][0] += 1e-9
    log.unlink()
    for key, value in steps.items():
        TuningLog(log).add(key, value)
    found = subprocess.run(verify, cwd=tmp_path, capture_output=True, text=True, check=False)
    told = json.loads(found.stdout)
    assert found.returncode == 1 and told["verified"] - told["same"] == 1
