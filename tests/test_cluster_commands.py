"""Evaluations and tunings on the workers of a Dask scheduler: what comes out is what comes out here."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from small_task import SMALL
from test_cluster import local  # noqa: F401  (a fixture)
from test_evaluation_tables import asked, forbidden

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.studies.evaluation import seas
from gyroctl.studies.evaluation.report import evaluate_tables
from gyroctl.tuning import bench
from gyroctl.tuning.task import build_task
from gyroctl.tuning.tune import tune
from gyroctl.tuning.waters import Circumstances

pytest.importorskip("distributed", reason="needs the extra cluster: dask.distributed")

BUDGET = 4 * 160.0 * 2 + 2 * 2 * 200.0  # two generations, two confirmations


@pytest.mark.slow
def test_tuning_finds_the_same_points_there_and_goes_on_here(
    device: gy.Plant,
    local: Any,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    task, on = build_task(SMALL), Circumstances(device)
    here = tune(task, "mild", on, BUDGET, tmp_path / "here", quiet=True)
    runner_on, ran = bench._runner_on, list[bytes]()

    def noted(packed: bytes) -> bench.Runner:
        ran.append(packed)
        return runner_on(packed)

    with monkeypatch.context() as there:
        there.setattr(bench, "_runner_on", noted)
        found = tune(task, "mild", on, BUDGET, tmp_path / "there", quiet=True, scheduler=local.scheduler_address)
    assert found.archive == here.archive and ran
    logs = [next((tmp_path / place).glob("*.jsonl")) for place in ("here", "there")]
    assert logs[0].name == logs[1].name and logs[0].read_bytes() == logs[1].read_bytes()
    monkeypatch.setattr(bench.Bench, "perform", forbidden)
    assert tune(task, "mild", on, BUDGET, tmp_path / "there", quiet=True).archive == here.archive


@pytest.mark.slow
def test_runs_of_an_evaluation_are_made_there_and_found_here(
    local: Any,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ask = asked(tmp_path, "load_angle")
    monkeypatch.setattr("gyroctl.studies.evaluation.report.TABLES", {"seas": lambda a: seas.seas_table(a, (5.0,))})
    monkeypatch.setattr(execution, "perform", forbidden)  # by this process alone
    there = evaluate_tables(["seas"], replace(ask, scheduler=local.scheduler_address))["seas"]
    rows = json.loads((tmp_path / "seas.json").read_text())["seas"]
    assert not there["failed"] and {row["law"] for row in rows["gamma5"]} >= {"best_constant", "load_angle"}
    evaluate_tables(["seas"], ask)
    assert json.loads((tmp_path / "seas.json").read_text())["seas"] == rows


def test_scheduler_of_an_evaluation_is_met_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(gy.InputError, match="no address") as error:
        evaluate_tables(["seas"], replace(asked(tmp_path), scheduler="tcp://host"))
    assert error.value.field == "scheduler" and not list(tmp_path.iterdir())
