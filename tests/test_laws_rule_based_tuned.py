"""Laws by rules as they are tuned: defaults, seeds, the constant pairs, and the bars on tuning seeds."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from lock_numbers import WP
from rule_based_laws import LAWS

import gyroctl as gy
from gyroctl.controllers.rule_based import Constant, best_constant
from gyroctl.controllers.rule_based.shipped import FOLDER, shipped
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.simulation.metrics import evaluate


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.json") if path.stem in LAWS))
def test_defaults_are_the_tuned_set_for_all_seas(name: str) -> None:
    parameters = shipped(name)["all"]["parameters"]
    assert parameters == {key: describe(LAWS[name])[key] for key in parameters}


def test_tuning_and_evaluation_seeds_are_disjoint() -> None:
    for path in FOLDER.glob("*.json"):
        for entry in json.loads(path.read_text())["sets"].values():
            assert entry["found"]["seeds"]["first"] >= 100000


def test_best_constant_takes_the_nearest_gamma() -> None:
    pairs = {
        float(entry["found"]["seas"][name]["sea"]["gamma"]): Constant(**entry["parameters"])
        for name, entry in shipped("constant").items()
        if name in entry["found"]["seas"]  # those of real water are another yardstick
    }
    assert set(pairs) == {1.0, 5.0, 50.0}
    assert best_constant() == best_constant(5.0) == best_constant(3.3) == pairs[5.0]  # log scale: 3.3 is nearer to 5
    assert best_constant(2.0) == best_constant(1.0) == pairs[1.0]
    assert best_constant(20.0) == pairs[50.0]
    with pytest.raises(ValueError, match="gamma"):
        best_constant(0.0)


SEEN = range(100128, 100140)
"""Tuning seeds beyond those that the tuning uses."""


def means(device: gy.Plant, law: Any, sea: gy.SeaState) -> dict[str, float]:
    rows = []
    for seed in SEEN:
        waves = lead_in(gy.realise(device, sea, seed, duration=2000.0), Settings())
        record, _ = run_law(device, law, waves, Settings())
        rows.append(evaluate(device, record, waves.moments[1], waves.dt, sea.wp, waves.blend, math.nan))
    return {key: float(np.mean([row[key] for row in rows])) for key in rows[0]}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "gamma", "power", "power_cv"),
    [
        ("load_angle", 1.0, 2.08, 9.0),
        ("load_angle", 5.0, 4.68, 9.0),
        ("load_angle", 50.0, 6.25, 9.0),
        ("coupling", 5.0, 3.83, 0.35),
    ],
)
def test_bars_of_one_set_for_all_seas(device: gy.Plant, name: str, gamma: float, power: float, power_cv: float) -> None:
    """Mean power and smoothness, every run locked, motion within its limit.

    Not met, and so not here: at gamma 1 `coupling` gives more than twice the power, but moves the float by 0.36 rad.
    """
    found = means(device, LAWS[name], gy.SeaState(gamma=gamma))
    assert found["mean_power"] >= power
    assert found["power_cv"] <= power_cv
    assert found["locked"] == 1.0
    assert max(found["phi1_p98"], found["phi3_p98"]) <= 0.35


@pytest.mark.slow
@pytest.mark.parametrize("name", ["load_angle", "coupling"])
@pytest.mark.parametrize(("hs", "wp"), [(0.15, WP), (0.6, WP), (0.283, 2.7), (0.283, 3.6)])
def test_off_design_power_is_above_that_of_the_sea_s_best_constant_pair(
    device: gy.Plant, name: str, hs: float, wp: float
) -> None:
    """Pairs from a grid on these very seas (16 tuning seeds): 0.86, 8.0, 1.73 and 3.44 W."""
    pair = {(0.15, WP): 0.86, (0.6, WP): 8.0, (0.283, 2.7): 1.73, (0.283, 3.6): 3.44}[(hs, wp)]
    assert means(device, LAWS[name], gy.SeaState(hs=hs, wp=wp))["mean_power"] > pair
