"""No code from data: a law's file runs from the folder of what names it, or when it was asked for by name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import Run
from test_reports_synthetic import FOUR, save, synthetic

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment, read_experiment
from gyroctl.harness.registry import tuned_sets
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.tuning.task import build_task, read_task

LAW = """
from pathlib import Path

Path({mark!r}).touch()

class Mine:
    period, information = 0.1, "sensors"
    def init(self): return None
    def step(self, t, y, state): return (0.05, 1e-4), None
"""


class Folders:
    """An own folder and another one, with the same law in both that leaves a mark when it is run."""

    def __init__(self, root: Path) -> None:
        self.own, self.other, self.mark = root / "own", root / "other", root / "ran"
        for folder in (self.own / "within", self.own / "tuned", self.other):
            folder.mkdir(parents=True)
        for folder in (self.own, self.own / "within", self.other):
            (folder / "mine.py").write_text(LAW.format(mark=str(self.mark)))
        (self.own / "link.py").symlink_to(self.other / "mine.py")
        (self.own / "linked").symlink_to(self.other)
        (self.own / "round.py").symlink_to(self.own / "round.py")
        self.law = self.other / "mine.py"

    def experiment(self, table: str) -> Path:
        path = self.own / "study.toml"
        path.write_text(f"[run]\nseeds = [1]\n[laws.mine]\n{table}\n")
        return path


@pytest.fixture
def folders(tmp_path: Path) -> Folders:
    return Folders(tmp_path)


OUTSIDE = ("../other/mine.py", "link.py", "linked/mine.py", "within/../../other/mine.py", "{other}/mine.py")


@pytest.mark.parametrize("path", OUTSIDE)
@pytest.mark.parametrize(
    "how", ['law = "{}:Mine"', 'law = "supervisor"\nwraps = "{}:Mine"', 'wraps = {{law = "{}:Mine"}}']
)
def test_experiment_runs_no_file_from_outside_its_folder(path: str, how: str, folders: Folders, run: Run) -> None:
    text = how.format(path.format(other=folders.other))
    file = folders.experiment(text if text.startswith("law") else f'law = "supervisor"\n{text}')
    code, out, err = run("compare", file, "--out", folders.own / "out")
    assert code == 2 and not out and not folders.mark.exists()
    assert "laws.mine." in err and str(folders.law) in err and "--allow-code" in err
    assert not (folders.own / "out").exists()


@pytest.mark.parametrize("path", [*OUTSIDE, "mine.py", "within/mine.py", "within/../mine.py", "../own/mine.py"])
def test_file_that_is_asked_for_runs_and_one_of_the_own_folder_does(path: str, folders: Folders) -> None:
    path = path.format(other=folders.other)
    for text in (f'law = "{path}:Mine"', f'law = "supervisor"\nwraps = {{law = "{path}:Mine"}}'):
        allowed = [folders.law] if "other" in path or "link" in path else []
        assert "mine" in read_experiment(folders.experiment(text), allow_code=allowed).laws
    assert folders.mark.exists()


def test_another_file_that_is_asked_for_allows_nothing_else(folders: Folders) -> None:
    file = folders.experiment('law = "../other/mine.py:Mine"')
    (folders.other / "another.py").write_text("")
    with pytest.raises(gy.InputError, match=r"laws\.mine\.law"):
        read_experiment(file, allow_code=[folders.other / "another.py"])
    with pytest.raises(gy.InputError, match="--allow-code"):
        read_experiment(file, allow_code=[folders.other / "gone.py"])
    assert not folders.mark.exists()
    assert read_experiment(file, allow_code=[folders.other]).laws  # a folder stands for all that is in it


@pytest.mark.parametrize("path", ["round.py", "nul\0.py", "x" * 300 + ".py"])
def test_what_is_no_path_is_refused(path: str, folders: Folders) -> None:
    with pytest.raises(gy.InputError, match=r"laws\.mine\.law"):
        build_experiment({"laws": {"mine": {"law": f"{path}:Mine"}}}, folder=folders.own)


def test_data_allows_itself_nothing(folders: Folders) -> None:
    table: dict[str, Any] = {"law": "../other/mine.py:Mine", "allow_code": [str(folders.law)]}
    for tables in ({"mine": table}, {"mine": {"law": "supervisor", "wraps": table}}, {f"{folders.law}:Mine": {}}):
        with pytest.raises(gy.InputError, match="laws"):
            build_experiment({"laws": tables}, folder=folders.own)
    assert not folders.mark.exists()


def test_task_runs_no_file_from_outside_its_folder(folders: Folders, run: Run) -> None:
    task = folders.own / "task.toml"
    knobs = "[knobs]\ncc = {start = 0.05, width = 0.3}\n"
    for text in ('law = "../other/mine.py:Mine"\n', 'law = "supervisor"\n[fixed]\nwraps = "linked/mine.py:Mine"\n'):
        task.write_text(text + knobs)
        code, _, err = run("tune", task, "--out", folders.own / "out", "--budget", "1e3")
        assert code == 2 and "--allow-code" in err and str(folders.law) in err
        assert read_task(str(task), allow_code=[folders.law]).stem
    with pytest.raises(gy.InputError, match=r"fixed\.allow_code"):
        build_task(
            {
                "law": "supervisor",
                "fixed": {"allow_code": str(folders.law)},
                "knobs": {"cc": {"start": 0.05, "width": 0.3}},
            }
        )
    assert not folders.mark.exists()


def test_task_beside_a_law_that_is_typed_may_name_it(folders: Folders) -> None:
    """The task lies in a folder of its own, tuning/, and its law above it."""
    (folders.own / "tuning").mkdir()
    knobs = "[knobs]\ncc = {start = 0.05, width = 0.3}\n"
    (folders.own / "tuning" / "Mine.toml").write_text(f'law = "../mine.py:Mine"\n{knobs}')
    typed = f"{folders.own}/mine.py:Mine"
    assert read_task(typed).law == typed
    (folders.own / "tuning" / "Mine.toml").write_text(f'law = "../../other/mine.py:Mine"\n{knobs}')
    with pytest.raises(gy.InputError, match="--allow-code"):
        read_task(typed)


def test_tuned_set_runs_no_file_from_outside_the_folder_of_its_law(folders: Folders) -> None:
    (folders.own / "pair.py").write_text("from gyroctl.controllers.supervisor import supervisor as pair\n")
    name = f"{folders.own}/pair.py:pair"
    sets = {"sets": {"rough": {"parameters": {"wraps": f"{folders.law}:Mine"}}}}
    (folders.own / "tuned" / "pair.json").write_text(json.dumps(sets))
    for build in (lambda: gy.law(name, "rough"), lambda: tuned_sets(name), Entrant("x", name, tuning="rough").build):
        with pytest.raises(gy.InputError, match=r"tuned\.rough\.parameters\.wraps.*--allow-code"):
            build()
    assert not folders.mark.exists()
    gy.law(name, "rough", allow_code=[folders.law])
    assert folders.mark.exists()
    sets["sets"]["rough"]["parameters"]["wraps"] = "within/mine.py:Mine"  # relative to the law
    (folders.own / "tuned" / "pair.json").write_text(json.dumps(sets))
    assert gy.law(name, "rough").period == 0.1


def test_law_that_is_typed_runs(folders: Folders) -> None:
    assert gy.law(f"{folders.law}:Mine").period == 0.1
    assert gy.law("supervisor", wraps=f"{folders.own}/link.py:Mine").period == 0.1


@pytest.mark.slow
def test_report_of_results_builds_no_law(folders: Folders, run: Run) -> None:
    """Not even one that the experiment within them names."""
    asked = {"laws": {name: {"law": f"{folders.own}/mine.py:Mine"} for name in FOUR}}
    save(synthetic().assign_attrs(experiment=json.dumps(asked)), folders.own / "results.nc")
    code, _, err = run("report", folders.own)
    assert code == 0, err
    assert not folders.mark.exists()
