"""`gyroctl status`, `verify` and `clean`, and steps of a report that are kept."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from command_line import Run

from gyroctl.cli.verification import made
from gyroctl.engine import Store, state
from gyroctl.engine.packing import packed, unpacked
from gyroctl.engine.plan import KEPT, Plan, Wanted, plans
from gyroctl.engine.record import Damaged
from gyroctl.engine.steps import Steps
from gyroctl.errors import InputError
from gyroctl.writing import written_whole

EXPERIMENT = """
[run]
duration = 60.0
blend = 40.0
seeds = [1, 2]

[laws.plain]
law = "constant"
"""

LAW = """
from typing import NamedTuple

class Mine(NamedTuple):
    period: float = 0.1
    information = "none"
    def init(self): return ()
    def step(self, t, y, state): return (0.052, 2e-4), state
"""


@pytest.fixture
def study(tmp_path: Path, run: Run) -> Path:
    (tmp_path / "mine.toml").write_text(EXPERIMENT)
    code, _, said = run("compare", tmp_path / "mine.toml", "--out", tmp_path / "out", "--no-search", "--workers", 1)
    assert code == 0, said
    return tmp_path / "out"


def asked(run: Run, *words: object) -> tuple[int, dict[str, Any], str]:
    code, out, said = run(*words)
    return code, json.loads(out) if out else {}, said


def test_status_verify_and_clean(study: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    toml, runs = study.parent / "mine.toml", study / "runs"
    code, told, _ = asked(run, "status", study)
    assert code == 0 and not told["running"]
    assert {line["law"]: (line["done"], line["left"]) for line in told["lines"]} == {
        "plain": (2, 0),
        "best_constant": (2, 0),
    }
    code, told, _ = asked(run, "verify", study, toml, "--share", 1.0, "--workers", 1)
    assert code == 0 and told["verified"] == told["same"] == 4
    assert "  " not in made({"gyroctl": "0.2.0", "commit": "", "made_with": {}})
    assert "numpy" in told["runs"][0]["made"] and "processor" in told["runs"][0]["made"]

    # a run that was edited, with a checksum of its own: only the computation tells
    store = Store(runs)
    record = store.load(next(store.files()).stem)
    assert record is not None
    values = {**record.content["values"], "mean_power": 167000.0}
    store.save(record.key, {**record.content, "values": values}, record.arrays, record.about)
    code, told, _ = asked(run, "verify", study, toml, "--share", 1.0, "--workers", 1)
    assert code == 1 and told["same"] == 3
    assert [each["differs"] for each in told["runs"] if each["differs"]] == [["mean_power"]]

    # and one without
    file = next(store.files())
    file.write_bytes(file.read_bytes().replace(b"mean_power", b"mean_pover"))
    (runs / "old.npz").write_bytes(b"PK")
    store.save("ab" * 32, {}, {}, {"law": "nobody asks for it"})
    with written_whole(runs / "live.run") as part:  # by a study that runs
        part.write_bytes(b"half")
        assert asked(run, "clean", study, "--dry-run")[1]["damaged"]["files"] == 2 and part not in store.files()
    (runs / "live.run").unlink()
    code, told, _ = asked(run, "clean", study, "--dry-run")
    assert code == 0 and told["damaged"]["files"] == 2 and told["stale"]["files"] == 1 and file.exists()
    asked(run, "clean", study)
    assert not file.exists() and len(list(store.files())) == 3
    code, told, _ = asked(run, "status", study)
    assert sum(line["left"] for line in told["lines"]) == 1
    code, told, said = asked(run, "verify", study, "--quick")
    assert code == 2 and "no run of this experiment" in said and "Traceback" not in said
    code, told, said = asked(run, "verify", study)
    assert code == 2 and "there is no such file here" in said, "its experiment is known by its last name"
    monkeypatch.chdir(study.parent)
    code, told, _ = asked(run, "verify", study, "--share", 1.0, "--workers", 1)
    assert code == 0 and told["verified"] == told["same"] == 3
    toml.write_text(EXPERIMENT + "# mine.py:Mine")
    code, told, said = asked(run, "verify", study)
    assert code == 2 and "names code" in said


def test_experiments_in_one_folder_keep_their_results(study: Path, run: Run) -> None:
    """A plan is known by all that is asked: a second experiment of the same laws and seeds takes nothing away."""
    other, runs, more = study.parent / "other.toml", study / "runs", ("--no-search", "--workers", 1)
    other.write_text(EXPERIMENT.replace("[run]", "[run]\ndt = 0.005"))
    assert run("compare", other, "--out", study, *more)[0] == 0
    first = sorted(runs.glob("*.run"))
    assert len(first) == 8 and len(list(runs.glob("*.plan.json"))) == 2
    _, told, _ = asked(run, "clean", study)
    assert told["stale"]["files"] == 0 and sorted(runs.glob("*.run")) == first
    _, told, _ = asked(run, "status", study)
    assert [(line["law"], line["done"]) for line in told["lines"]] == 2 * [("best_constant", 2), ("plain", 2)]
    assert [("mine.toml" in line["command"]) for line in told["lines"]] == [True, True, False, False]
    assert "other.toml" in run("status", study, "--words")[1]

    # the file is edited: what it asked for before is kept and told apart until that is to go
    other.write_text(other.read_text() + "cg = 3e-4\n")
    assert run("compare", other, "--out", study, *more)[0] == 0
    _, told, _ = asked(run, "status", study)
    assert told["of_earlier_runs"] == 2 and sum(line["done"] for line in told["lines"]) == 8
    _, told, _ = asked(run, "clean", study)
    assert told["kept_of_earlier"] == 3 and len(list(runs.glob("*.run"))) == 10
    _, told, _ = asked(run, "clean", study, "--earlier")
    assert told["earlier"]["files"] == 3 and len(list(runs.glob("*.run"))) == 8
    for toml in (study.parent / "mine.toml", other):
        _, told, _ = asked(run, "verify", study, toml, "--share", 1.0, "--workers", 1)
        assert told["stored"] == told["same"] == 4


def test_plans_of_a_folder_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the same laws and seeds; the oldest goes, and what was refused leaves the plan that was there before."""
    for number in range(KEPT + 3):
        with Plan(tmp_path, "", [Wanted(f"{number:064x}", "law", 1)]) as plan:
            pass
        assert plan.path is not None
        os.utime(plan.path, (number, number))
    kept = {item.key for noted in plans(tmp_path) for item in noted.items}
    assert kept == {f"{number:064x}" for number in range(3, KEPT + 3)}
    with suppress(InputError), Plan(tmp_path, "", [Wanted(f"{5:064x}", "law", 1)]):
        raise InputError("scheduler", "x", "is refused", "Give another one")
    assert kept == {item.key for noted in plans(tmp_path) for item in noted.items}


def test_plans_of_other_code_go_with_their_results(study: Path, run: Run) -> None:
    runs = study / "runs"
    (plan,) = runs.glob("*.plan.json")
    for path in sorted(runs.glob("*.run")):
        record = Store(runs).load(path.stem)
        assert record is not None
        Store(runs).save(record.key, record.content, record.arrays, {**record.about, "code": {"gyroctl.version": "1"}})
    _, told, _ = asked(run, "clean", study)
    assert told["stale"]["files"] == 5 and not plan.exists(), "or status would call its runs left"


def test_damaged_results_are_not_told_done(study: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    one, two, three, _ = sorted((study / "runs").glob("*.run"))
    one.write_bytes(one.read_bytes()[:-1])
    two.write_bytes(three.read_bytes())
    _, told, _ = asked(run, "status", study)
    assert told["damaged"] == 2 and sum(line["done"] for line in told["lines"]) == 2
    assert sum(line["left"] for line in told["lines"]) == 0
    words = run("status", study, "--words")[1]
    assert "2 damaged, will be computed again" in words and "all is done" not in words
    assert asked(run, "clean", study, "--dry-run")[1]["damaged"]["files"] == 2
    monkeypatch.setattr(state, "CHECKED", 1)
    _, told, _ = asked(run, "status", study)
    assert told["unchecked"] == 3 and told["damaged"] == 1
    one.unlink()
    one.mkdir()
    assert f"{one} is a folder: remove it" in run("status", study, "--words")[1]
    assert f"{one} is a folder where a file belongs" in run("clean", study, "--words")[1] and one.is_dir()


@pytest.mark.slow
def test_whole_series_and_laws_from_elsewhere_are_verified_as_they_were_compared(tmp_path: Path, run: Run) -> None:
    """The first run of each law is kept otherwise with whole series, and is then another result."""
    (tmp_path / "own").mkdir()
    law = tmp_path / "mine.py"
    law.write_text(LAW)
    toml, out = tmp_path / "own" / "mine.toml", tmp_path / "out"
    toml.write_text(f'{EXPERIMENT}\n[laws.mine]\nlaw = "{law}:Mine"\n')
    allowed = ("--allow-code", law, "--workers", 1)
    code, _, said = run("compare", toml, "--out", out, "--no-search", "--full-series", *allowed)
    assert code == 0, said
    for more, stored in (((), 3), (("--full-series",), 6)):
        code, told, said = asked(run, "verify", out, toml, "--share", 1.0, *more, *allowed)
        assert code == 0 and told["stored"] == told["same"] == stored, said
    code, _, said = asked(run, "verify", out, toml)
    assert code == 2 and "--allow-code" in said
    code, _, said = asked(run, "verify", out)
    assert code == 2 and "EXPERIMENT.toml" in said, "the folder does not say what may run"


@pytest.mark.parametrize("command", ["status", "verify", "clean"])
def test_folders_without_results_are_refused(command: str, tmp_path: Path, run: Run) -> None:
    for folder, why in ((tmp_path / "none", "no such folder"), (tmp_path, "no stored results")):
        code, _, said = run(command, folder)
        assert code == 2 and why in said


class Pair(NamedTuple):
    cc: float
    cg: float


@dataclass(frozen=True)
class Found:
    pairs: tuple[Pair, ...]
    share: dict[float, Pair]
    power: np.ndarray[Any, Any]
    none: None = None


FOUND = Found((Pair(0.1, float("inf")),), {0.5: Pair(0.1 + 0.2, -0.0)}, np.array([[1.0, np.nan]]))


def test_what_is_packed_comes_back() -> None:
    content, arrays = packed(FOUND)
    again = unpacked(json.loads(json.dumps(content)), arrays, (Pair, Found))
    assert again.pairs == FOUND.pairs and again.share == FOUND.share and isinstance(again.share[0.5], Pair)
    np.testing.assert_array_equal(again.power, FOUND.power)
    with pytest.raises(Damaged):
        unpacked(content, arrays, (Pair,))
    with pytest.raises(TypeError):
        packed({"code": print})


def test_steps_that_are_finished_are_found_again(tmp_path: Path) -> None:
    calls: list[str] = []

    def computed() -> Found:
        calls.append("computed")
        return FOUND

    def steps(given: str = "a device", kinds: tuple[type, ...] = (Pair, Found)) -> Steps:
        return Steps(tmp_path, given, ("gyroctl.studies.margins.measures",), kinds)

    for _ in range(2):
        assert steps()("headroom", computed).pairs == FOUND.pairs
    assert len(calls) == 1
    steps()("basin", computed)
    steps("another device")("headroom", computed)
    assert len(calls) == 3
    steps(kinds=(Pair,))("headroom", computed)
    assert len(calls) == 4, "of another shape"
    steps("")("headroom", computed)
    steps("")("headroom", computed)
    assert len(calls) == 6, "what is not known is not kept"
