"""What ships tuned: defaults, how the sets were found, tasks that can be run."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.registry import REAL, real_set, registered, tuned_seeds, tuned_sets
from gyroctl.tuning.record import plant_hash
from gyroctl.tuning.task import read_task
from gyroctl.tuning.waters import circumstances_of

SHIPPED = sorted(name for name in registered() if name not in ("constant", "best_constant") and tuned_sets(name))


@pytest.mark.parametrize("name", SHIPPED)
def test_defaults_are_the_set_for_all_seas(name: str) -> None:
    assert gy.law(name) == gy.law(name, tuning="all")


@pytest.mark.parametrize("name", [*SHIPPED, "constant"])
def test_shipped_sets_tell_how_they_were_found(name: str) -> None:
    for which, entry in tuned_sets(name).items():
        assert entry["found"]["spent_s"] <= entry["found"]["budget_s"]
        dear = name == "nmpc" or which.startswith(REAL)  # a planned run costs a hundred others, real water ten
        for result in entry["result"].values():
            assert result["runs"] == (16 if dear else 64)
            assert result["locked_ci95"][0] <= result["locked"] <= result["locked_ci95"][1] + 1e-12
    last = 100143 if name == "nmpc" else 100063  # explored by hand before the searches, on these too
    assert tuned_seeds(name) == set(range(100000, last + 1))


@pytest.mark.parametrize("name", [*SHIPPED, "best_constant"])
def test_shipped_task_is_one_that_can_be_run(name: str) -> None:
    task = read_task(name)
    if task.knobs:
        gy.law(task.law, **task.at(np.zeros(len(task.knobs))))
    assert math.isclose(sum(sea.weight for sea in task.seas.values()), 1.0)
    assert json.dumps(dataclasses.asdict(task))


WET = ("coupling", "load_angle", "scheduled_lqr", "stabiliser", "threshold", "tracking")
"""Laws without a plan that have a set for real water."""


@pytest.mark.parametrize("name", WET)
def test_sets_for_real_water_say_in_which_water_and_with_what_budget(name: str) -> None:
    on, which = circumstances_of(REAL), real_set(name)
    assert which is not None
    found = tuned_sets(name)[which]["found"]
    assert found["water"] == REAL and found["cc_lag"] == on.settings.actuators.cc_lag
    assert found["plant_sha256"] == plant_hash(on.plant)
    assert 0.0 < found["spent_s"] <= found["budget_s"] and found["seeds"]["first"] == 100000
    assert gy.law(name, tuning=REAL) == gy.law(name, tuning=which) != gy.law(name)


@pytest.mark.parametrize("name", [name for name in SHIPPED if name not in ("nmpc", "scheduled_lmi")])
def test_tasks_for_real_water_search_by_one_rule(name: str) -> None:
    """The same windows, runs, confirmation and seeds; knobs, goals and the spread of the first step are a law's own."""
    task, common = read_task(name, REAL), read_task("load_angle", REAL)
    assert dataclasses.replace(task.search, spread=common.search.spread) == common.search
    assert task.seeds == common.seeds
    gy.law(task.law, **task.at(np.zeros(len(task.knobs))))
