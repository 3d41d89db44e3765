"""A whole tuning: the budget by counting, resumption to the last bit, its files, and what it refuses to begin."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from small_task import EXAMPLE, SMALL
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.harness.tuned_sets import read_sets
from gyroctl.tuning import bench as tuning_bench
from gyroctl.tuning.goal import METRICS
from gyroctl.tuning.task import Task, build_task, read_task
from gyroctl.tuning.tune import Start, tune
from gyroctl.tuning.waters import Circumstances

BUDGET = 4 * 2 * 160.0 * 3 + 2 * 2 * 2 * 200.0  # three generations, two confirmations


@pytest.fixture
def task() -> Task:
    return build_task(SMALL)


@pytest.fixture
def on(device: gy.Plant) -> Circumstances:
    return Circumstances(device)


def test_tuning_spends_its_budget_and_no_more(task: Task, on: Circumstances, monkeypatch: pytest.MonkeyPatch) -> None:
    jobs: list[tuning_bench.Job] = []
    runner = tuning_bench.Runner.__call__

    def counted(self: tuning_bench.Runner, some: Sequence[tuning_bench.Job]) -> list[tuple[float, ...]]:
        jobs.extend(some)
        return runner(self, some)

    monkeypatch.setattr(tuning_bench.Runner, "__call__", counted)
    found = tune(task, "all", on, BUDGET + 100.0, quiet=True)
    entry = found.sets["all"]
    assert sum(job.duration for job in jobs) == entry["found"]["spent_s"] == BUDGET
    assert {job.seed for job in jobs} == {100128, 100129}
    assert entry["found"]["seeds"] == {"first": 100128, "last": 100129}
    assert set(entry["result"]) == {"mild", "tall"}
    assert entry["result"]["mild"]["runs"] == 2
    assert entry["result"]["mild"]["locked_ci95"][0] < entry["result"]["mild"]["locked"]
    for key in ("date", "version", "start", "plant_sha256", "hydrodynamics_sha256", "budget_s"):
        assert entry["found"][key]


def test_result_is_that_of_a_run_by_hand(task: Task, on: Circumstances) -> None:
    """The confirmed power is the mean over the seeds of the plain simulation: generated and stored."""
    entry = tune(task, "mild", on, BUDGET, quiet=True).sets["mild"]
    law, powers = gy.law(task.law, **entry["parameters"]), []
    for seed in (100128, 100129):
        waves = gy.realise(on.plant, gy.SeaState(hs=0.25, gamma=5.0), seed, duration=200.0)
        ds = gy.simulate(on.plant, law, waves)
        ends = ds.sel(time=[100.0, 200.0], method="nearest")
        states = np.array([ends[name].values for name in on.plant.labels])
        energy = ends.energy_generator.values + on.plant.stored_energy(states)
        powers.append((energy[1] - energy[0]) / 100.0)
    assert entry["result"]["mild"]["mean_power"] == pytest.approx(np.mean(powers), rel=2e-4)


def test_search_depends_on_its_seed_and_its_scores_alone(task: Task, on: Circumstances) -> None:
    def searched(seed: int) -> list[dict[str, float]]:
        other = dataclasses.replace(task, search=dataclasses.replace(task.search, seed=seed))
        return [seen.parameters for seen in tune(other, "mild", on, 2000.0, quiet=True).archive]

    first = searched(1)
    np.random.default_rng().standard_normal(3)
    np.random.seed(7)  # noqa: NPY002
    assert searched(1) == first
    assert searched(2)[:4] != first[:4]


def test_start_of_a_search_is_confirmed_with_what_it_found(task: Task, on: Circumstances) -> None:
    """So that no search ships what is worse."""
    found = tune(task, "mild", on, BUDGET, quiet=True)
    confirmed = [seen.parameters for seen in found.archive if seen.stage == "confirm"]
    start = task.at(np.zeros(len(task.knobs)))
    assert confirmed[0] == start and len(confirmed) > 1 and confirmed[1] != start


class Stopped(Exception):
    """As a user would stop it."""


@pytest.mark.parametrize("after", [1, 13, 27])
def test_stopped_tuning_ends_with_the_same_bits(
    task: Task, on: Circumstances, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    whole = tune(task, "all", on, BUDGET, tmp_path / "whole", quiet=True)
    runner, calls = tuning_bench.Runner.__call__, 0

    def stopping(self: tuning_bench.Runner, some: Sequence[tuning_bench.Job]) -> list[tuple[float, ...]]:
        nonlocal calls
        calls += len(some)
        if calls > after:
            raise Stopped
        return runner(self, some)

    with monkeypatch.context() as patch:
        patch.setattr(tuning_bench.Runner, "__call__", stopping)
        with pytest.raises(Stopped):
            tune(task, "all", on, BUDGET, tmp_path / "parts", quiet=True)
    logs = list((tmp_path / "parts").glob("*.jsonl"))
    if logs:  # and a line that was cut short
        logs[0].write_text(logs[0].read_text() + '{"key": "search 9", "val')
    again = tune(task, "all", on, BUDGET, tmp_path / "parts", quiet=True)
    assert again.sets == whole.sets
    assert again.archive == whole.archive


def test_finished_tuning_runs_nothing_again_and_a_larger_budget_goes_on(
    task: Task, on: Circumstances, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = tune(task, "all", on, BUDGET, tmp_path, quiet=True)
    jobs: list[tuning_bench.Job] = []
    runner = tuning_bench.Runner.__call__

    def counted(self: tuning_bench.Runner, some: Sequence[tuning_bench.Job]) -> list[tuple[float, ...]]:
        jobs.extend(some)
        return runner(self, some)

    monkeypatch.setattr(tuning_bench.Runner, "__call__", counted)
    assert tune(task, "all", on, BUDGET, tmp_path, quiet=True).sets == first.sets
    assert not jobs
    more = tune(task, "all", on, BUDGET + 4 * 2 * 160.0, tmp_path, quiet=True)
    searched = [seen for seen in more.archive if seen.stage == "search"]
    assert searched[:12] == [seen for seen in first.archive if seen.stage == "search"]
    assert len(searched) == 16
    fresh = tune(task, "all", on, BUDGET + 4 * 2 * 160.0, quiet=True)
    assert fresh.sets == more.sets


def test_workers_change_no_bit(task: Task, on: Circumstances) -> None:
    assert tune(task, "all", on, BUDGET, workers=2, quiet=True).sets == tune(task, "all", on, BUDGET, quiet=True).sets


def test_jobs_side_by_side_have_the_bits_of_each_alone(device: gy.Plant) -> None:
    """Other parameters, seas, steps, limits of the coupling, and a law that fails among them."""
    sea, tall = gy.SeaState(), gy.SeaState(hs=0.4, gamma=5.0)
    jobs = [
        tuning_bench.Job(
            "load_angle", (("cc", 0.04 + 0.006 * i),), tall if i % 3 else sea, 100128 + i // 2, 130.0, 0.025
        )
        for i in range(9)
    ]
    runner = tuning_bench.Runner(device, gy.Settings())
    together = runner(jobs)
    assert together == [runner([job])[0] for job in jobs]
    assert len(set(together)) == len(jobs)
    with tuning_bench.Bench(device, gy.Settings(), gy.law("load_angle"), 2) as bench:
        done: list[tuning_bench.Job] = []
        assert bench.perform(jobs, done.append) == together
        assert done == jobs


PLAIN = '''
class Plain:
    """A law that cannot be compiled."""
    period, information = 0.1, "sensors"
    def __init__(self, cc=0.06, cg=4e-4):
        self.cc, self.cg = cc, cg
    def init(self):
        return {"calls": 0}
    def step(self, t, y, state):
        return (self.cc, self.cg), {"calls": state["calls"] + 1}
'''


@pytest.mark.slow
def test_python_law_is_tuned_on_processes_with_the_same_bits(on: Circumstances, tmp_path: Path) -> None:
    (tmp_path / "plain.py").write_text(PLAIN)
    tables = {
        "law": f"{tmp_path}/plain.py:Plain",
        "knobs": {"cg": {"start": 4e-4, "width": 0.5}},
        "seas": {"mild": {"hs": 0.25, "runs": 1}},
        "seeds": {"first": 100128, "count": 1},
        "search": {"population": 4, "window": 104.0, "confirm": 105.0, "runs": 1},
    }
    task, budget = build_task(tables, folder=tmp_path), 4 * 104.0 + 2 * 105.0
    one = tune(task, "mild", on, budget, quiet=True)
    assert tune(task, "mild", on, budget, workers=2, quiet=True).sets == one.sets


def test_law_that_gives_no_number_is_the_worst_and_stops_nothing(device: gy.Plant, tmp_path: Path) -> None:
    text = EXAMPLE.read_text().replace("cg = self.cg + self.gain", "cg = self.cg / 0.0 + self.gain")
    (tmp_path / "bad.py").write_text(text.replace("min(max(cg, 0.0), 0.02)", "cg"))
    runner = tuning_bench.Runner(device, gy.Settings())
    (found,) = runner([tuning_bench.Job(f"{tmp_path}/bad.py:MyLaw", (), gy.SeaState(), 100128, 150.0, 0.01)])
    assert dict(zip(METRICS, found, strict=True))["locked"] == 0.0


def test_tuning_that_begins_at_a_set_owes_what_that_cost(task: Task, on: Circumstances) -> None:
    found = tune(task, "mild", on, 2000.0, quiet=True, start=Start("all", {"cg": 6e-4, "gain": 1e-4}, 5000.0))
    entry = found.sets["mild"]["found"]
    assert (entry["start"], entry["start_from"], entry["spent_before_s"]) == ({"cg": 6e-4, "gain": 1e-4}, "all", 5000.0)
    first = [seen.parameters["cg"] for seen in found.archive if seen.stage == "search"][:4]
    assert 6e-4 * math.exp(-0.5) < np.median(first) < 6e-4 * math.exp(0.5)


def test_further_goal_ships_a_set_of_its_own(on: Circumstances) -> None:
    tables = {**SMALL, "goals": {"gentle": {"motion": 0.2, "power_cv": {"mild": 0.1}}}}
    found = tune(build_task(tables), "all", on, BUDGET + 800.0, quiet=True)
    assert set(found.sets) == {"all", "all-gentle"}
    goals = {sea: entry["motion"] for sea, entry in found.sets["all-gentle"]["goal"].items()}
    assert goals == {"mild": 0.2, "tall": 0.2}
    assert found.sets["all-gentle"]["goal"]["mild"]["power_cv"] == 0.1


def test_log_of_a_tuning_is_found_again_only_where_nothing_has_changed(
    on: Circumstances, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The law's file, its parameters, the plant, the settings, or anything in the package."""

    def logs(task: Task, given: Circumstances) -> set[str]:
        tune(task, "mild", given, 2000.0, tmp_path / "logs", quiet=True)
        return {path.name for path in (tmp_path / "logs").glob("*.jsonl")}

    (tmp_path / "mine.py").write_text(EXAMPLE.read_text())
    tables = {**SMALL, "law": f"{tmp_path}/mine.py:MyLaw"}
    first = logs(build_task(tables, folder=tmp_path), on)
    assert len(first) == 1 and logs(build_task(tables, folder=tmp_path), on) == first
    assert len(logs(build_task({**tables, "fixed": {"period": 0.2}}, folder=tmp_path), on)) == 2
    assert len(logs(build_task(tables, folder=tmp_path), Circumstances(on.plant.replace(d1=1.9)))) == 3
    assert len(logs(build_task(tables, folder=tmp_path), Circumstances(on.plant, gy.Settings(blend=90.0)))) == 4
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text() + "\n\nLIMIT = 0.02\n")
    assert len(logs(build_task(tables, folder=tmp_path), on)) == 5
    monkeypatch.setattr("gyroctl.tuning.tune.code_of", lambda *modules: "another package")
    assert len(logs(build_task(tables, folder=tmp_path), on)) == 6


# --- the command ---------------------------------------------------------------------------------------------------


def test_command_tunes_ships_and_goes_on(tmp_path: Path) -> None:
    (tmp_path / "my_law.py").write_text(EXAMPLE.read_text())
    task = tmp_path / "mine.toml"
    task.write_text("""
        law = "my_law.py:MyLaw"
        knobs = { cg = { start = 4e-4, width = 0.5 } }
        seas = { mild = { hs = 0.25, runs = 1 } }
        search = { population = 4, window = 160, confirm = 200, runs = 1 }
        seeds = { first = 100128, count = 2 }
    """)
    command = ["tune", str(task), "--for", "mild", "--budget", "1500", "--out", f"{tmp_path}/out", "--workers", "1"]
    first = CliRunner().invoke(app, command)
    assert first.exit_code == 0, first.output
    assert "mild" in first.output and "2/2" in first.output
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"MyLaw.json", "MyLaw.mild.front.csv", "MyLaw.mild.front.png"} <= names
    assert not list(tmp_path.rglob("*.part*"))
    shipped = CliRunner().invoke(app, [*command, "--ship"])
    assert shipped.exit_code == 0
    assert read_sets(tmp_path / "out" / "MyLaw.json") == read_sets(tmp_path / "tuned" / "MyLaw.json")
    parameters = read_sets(tmp_path / "tuned" / "MyLaw.json")["mild"]["parameters"]
    assert gy.law(f"{tmp_path}/my_law.py:MyLaw", tuning="mild").cg == parameters["cg"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["coupling", "--for", "gamma7"], "--for"),
        (["nothing"], "law"),
        (["missing.toml"], "task"),
        (["coupling", "--budget", "10"], "budget"),
        (["coupling", "--from", "gamma7"], "--from"),
        (["coupling", "--experiment", "missing.toml"], "experiment"),
    ],
)
def test_command_refuses_before_it_runs(tmp_path: Path, arguments: list[str], words: str) -> None:
    result = CliRunner().invoke(app, ["tune", *arguments, "--out", str(tmp_path / "out")])
    assert isinstance(result.exception, gy.InputError)
    assert result.exception.field == words
    assert not list(tmp_path.rglob("*.json*"))


# --- refusals ------------------------------------------------------------------------------------------------------


def test_evaluation_seeds_are_refused(device: gy.Plant) -> None:
    for seeds, extra in (({"first": 150, "count": 64}, ()), ({"first": 20000, "count": 8}, (20003,))):
        task = build_task({**SMALL, "seeds": seeds})
        with pytest.raises(gy.InputError, match="judge laws"):
            tune(task, "all", Circumstances(device, evaluation=frozenset(extra)), BUDGET, quiet=True)


def test_budget_for_less_than_a_generation_is_refused(task: Task, on: Circumstances) -> None:
    with pytest.raises(gy.InputError, match="one generation") as error:
        tune(task, "all", on, BUDGET / 3.0, quiet=True)
    assert error.value.field == "budget"


def test_unknown_knob_and_sea_are_refused(on: Circumstances) -> None:
    with pytest.raises(gy.InputError, match="unknown parameter"):
        tune(build_task({**SMALL, "knobs": {"ratio": {"start": 1.0, "width": 1.0}}}), "all", on, BUDGET, quiet=True)
    with pytest.raises(gy.InputError, match="no sea"):
        tune(build_task(SMALL), "gamma5", on, BUDGET, quiet=True)
    with pytest.raises(gy.InputError, match="ships no task"):
        read_task(f"{EXAMPLE}:MyLaw")
