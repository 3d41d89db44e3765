"""Tasks and sets of a tuning: fields, knobs and plans of a task, files of sets, sets of a user's law."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from small_task import EXAMPLE, SMALL

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.harness.registry import real_set
from gyroctl.harness.tuned_sets import read_sets, write_sets
from gyroctl.tuning.task import Knob, build_task
from gyroctl.tuning.tune import planned
from gyroctl.tuning.waters import circumstances_of

# --- tasks ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"knob": {}}, "knob"),
        ({"knobs": {}}, "knobs"),
        ({"knobs": {"cg": 4e-4}}, "knobs.cg"),
        ({"knobs": {"cg": {"start": 4e-4}}}, "knobs.cg.width"),
        ({"knobs": {"cg": {"start": "a", "width": 1.0}}}, "knobs.cg.start"),
        ({"knobs": {"cg": {"start": -1.0, "width": 1.0}}}, "knobs.cg.start"),
        ({"knobs": {"cg": {"start": 1.0, "width": 0.0}}}, "knobs.cg.width"),
        ({"knobs": {"cg": {"start": 1.0, "width": 1.0, "most": 0.5}}}, "knobs.cg.start"),
        ({"knobs": {"cg": {"start": 1.0, "width": 1.0, "scale": "cubic"}}}, "knobs.cg.scale"),
        ({"knobs": {"cg": {"start": 1.0, "width": 1.0, "step": 1.0}}}, "knobs.cg.step"),
        ({"goal": {"motion": 0.0}}, "goal.motion"),
        ({"goal": {"turns": -0.1}}, "goal.turns"),
        ({"goal": {"locked": 1.2}}, "goal.locked"),
        ({"goal": {"power_cv": {"gamma5": 0.3}}}, "goal.power_cv.gamma5"),
        ({"goals": {"smooth": 0.2}}, "goals.smooth"),
        ({"seas": {"all": {}}}, "seas.all"),
        ({"seas": {"mild": {"depth": 1.0}}}, "seas.mild.depth"),
        ({"seas": {"mild": {"tp": 2.0, "wp": 3.0}}}, "seas.mild.tp"),
        ({"seas": {"mild": {"weight": 0.0}}}, "seas.mild.weight"),
        ({"search": {"population": 2}}, "search.population"),
        ({"search": {"seed": 2**32}}, "search.seed"),
        ({"search": {"population": 8.5}}, "search.population"),
        ({"search": {"confirm_share": 1.0}}, "search.confirm_share"),
        ({"seeds": {"count": 0}}, "seeds.count"),
        ({"method": "luck"}, "method"),
    ],
)
def test_bad_task_is_refused_by_field(changes: dict[str, Any], field: str) -> None:
    with pytest.raises(gy.InputError) as error:
        build_task({**SMALL, **changes})
    assert error.value.field == field
    assert error.value.mend


def test_unknown_parameter_of_a_task_is_named_as_it_stands_there(tmp_path: Path) -> None:
    """Also of a law in a file, whose name is a path."""
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text(encoding="utf-8"))
    law = {"law": "mine.py:MyLaw"}
    for field, tables in {
        "knobs.gian": {"knobs": {"gian": {"start": 0.2, "width": 0.1}}},
        "fixed.gian": {"knobs": {"cg": {"start": 0.2, "width": 0.1}}, "fixed": {"gian": 1.0}},
    }.items():
        with pytest.raises(gy.InputError, match="Perhaps gain is meant") as error:
            build_task({**SMALL, "fixed": {}, **law, **tables}, folder=tmp_path).first()
        assert error.value.field == field


def test_sea_of_a_task_may_have_a_peak_period() -> None:
    task = build_task({**SMALL, "seas": {"mild": {"hs": 0.2, "tp": 2.0}}})
    assert task.seas["mild"].sea == gy.SeaState(0.2, np.pi)


def test_turns_and_reversals_that_a_water_asks_for_may_be_waived() -> None:
    goal = {"real": {"goal": {"turns": 0.0, "forward": 0.0}}}
    assert build_task({**SMALL, **goal}, water="real").goals[""]["mild"].turns == 0.0
    assert build_task(SMALL, water="real").goals[""]["mild"].forward > 0.9


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(start=st.floats(1e-4, 1e3), width=st.floats(0.05, 2.0), x=st.floats(-2.0, 2.0), log=st.booleans())
def test_knob_and_its_coordinate_are_inverse(start: float, width: float, x: float, log: bool) -> None:
    knob = Knob("k", start, width, "log" if log else "linear")
    value = knob.value(x)
    assert knob.value(0.0) == pytest.approx(start, rel=5e-4)
    size = abs(value) / (start * width) if log else abs(value) / width  # values are rounded to four digits
    assert knob.coordinate(value) == pytest.approx(x, abs=1e-3 * (1.0 + (1.0 / width if log else size)))


def test_knob_keeps_its_bounds() -> None:
    knob = Knob("k", 1.0, 1.0, "linear", 0.5, 1.5)
    assert [knob.value(x) for x in (-2.0, 0.25, 2.0)] == [0.5, 1.25, 1.5]


@pytest.mark.parametrize("budget", [2e6, 4e6, 2e7])
def test_plan_keeps_to_the_budget(budget: float) -> None:
    task = build_task({"law": "coupling", "knobs": {"margin": {"start": 0.7, "width": 0.2}}})
    for which in ("all", "gamma1"):
        plan = planned(task, task.served(which), budget)
        spent = plan.generations * plan.generation + plan.points * plan.confirmation
        assert budget - plan.generation < spent <= budget


# --- sets and users' files -----------------------------------------------------------------------------------------


def test_sets_merge_and_come_back(tmp_path: Path) -> None:
    path = tmp_path / "tuned" / "mine.json"
    write_sets(path, "mine", {"all": {"parameters": {"cg": 0.1}}})
    write_sets(path, "mine", {"gamma1": {"parameters": {"cg": 0.2}}})
    assert {name: entry["parameters"]["cg"] for name, entry in read_sets(path).items()} == {"all": 0.1, "gamma1": 0.2}
    path.write_text("{")
    with pytest.raises(gy.InputError, match="cannot be read"):
        read_sets(path)


def test_named_set_of_a_users_law(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text())
    name = f"{tmp_path}/mine.py:MyLaw"
    write_sets(tmp_path / "tuned" / "MyLaw.json", "MyLaw", {"rough": {"parameters": {"cg": 0.00123, "gain": 0.1}}})
    assert gy.law(name, tuning="rough").cg == 0.00123
    assert gy.law(name, tuning="rough", cg=0.001)._asdict()["cg"] == 0.001
    with pytest.raises(gy.InputError, match="Choose one of rough"):
        gy.law(name, tuning="calm")


def test_a_law_goes_into_real_water_with_the_set_for_all_seas_or_that_of_the_default_sea(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text())
    name, file = f"{tmp_path}/mine.py:MyLaw", tmp_path / "tuned" / "MyLaw.json"
    write_sets(file, "MyLaw", {"all": {"parameters": {"cg": 1e-3}}, "real-gamma1": {"parameters": {"cg": 2e-3}}})
    assert real_set(name) is None
    with pytest.raises(gy.InputError, match="no such set"):
        gy.law(name, tuning="real")
    for which, cg in (("real-gamma5", 3e-3), ("real", 4e-3)):
        write_sets(file, "MyLaw", {which: {"parameters": {"cg": cg}}})
        assert real_set(name) == which and gy.law(name, tuning="real").cg == cg
    assert gy.law(name, tuning="real-gamma5").cg == 3e-3  # who names the sea gets its own


def test_users_file_is_loaded_once_and_again_when_it_changes(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text())
    name = f"{tmp_path}/mine.py:MyLaw"
    assert type(gy.law(name)) is type(gy.law(name, cg=1e-3))  # so that it is compiled once
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text().replace("gain: float = 5e-4", "gain: float = 7e-4"))
    assert gy.law(name).gain == 7e-4


def test_a_water_lays_its_own_tables_over_the_rest() -> None:
    """Knob by knob; what it does not say stays, and its sets have names of their own."""
    tables = {
        "law": "constant",
        "knobs": {"cc": {"start": 0.05, "width": 0.3}, "cg": {"start": 3e-4, "width": 0.5}},
        "goal": {"power_cv": 0.3},
        "real": {"knobs": {"cg": {"start": 2e-4}}, "fixed": {"period": 0.2}, "goal": {"motion": 0.5}},
    }
    dry, wet = build_task(tables), build_task(tables, water="real")
    assert [knob.start for knob in dry.knobs] == [0.05, 3e-4] and [knob.start for knob in wet.knobs] == [0.05, 2e-4]
    assert wet.knobs[1].width == 0.5 and wet.fixed == {"period": 0.2} and dry.fixed == {}
    dry_goal, wet_goal = dry.goals[""]["gamma5"], wet.goals[""]["gamma5"]
    assert (dry_goal.motion, dry_goal.turns, dry_goal.forward, dry_goal.power_cv) == (0.34, 0.0, 0.0, 0.3)
    assert (wet_goal.motion, wet_goal.turns, wet_goal.forward, wet_goal.power_cv) == (0.5, 0.945, 0.95, 0.3)
    assert (dry.named("all"), dry.named("gamma1"), wet.named("all"), wet.named("gamma1")) == (
        *("all", "gamma1"),
        *("real", "real-gamma1"),
    )
    assert dry.search.dt == 0.025 and wet.search.dt == 0.01


def test_water_that_nobody_knows() -> None:
    with pytest.raises(InputError, match=r"--water.*linear, real"):
        circumstances_of("dead sea")
    device = circumstances_of("real")
    assert device.plant.slips and device.settings.actuators.cc_lag == 0.02
