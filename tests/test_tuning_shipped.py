"""What ships tuned: defaults, how the sets were found, tasks that can be run."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.registry import REAL, registered, tuned_seeds, tuned_sets
from gyroctl.tuning.task import read_task

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
