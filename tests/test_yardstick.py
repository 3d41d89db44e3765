"""The yardstick: searched for the very sea, device and actuators, found again by content, never replaced silently."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.comparison.experiment import build_experiment
from gyroctl.engine import Store
from gyroctl.harness.constant_pairs import scan
from gyroctl.harness.registry import REAL
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.yardstick import BASELINE, Yardstick, shipped_pairs
from gyroctl.reports import evaluate, judge, summarise
from gyroctl.tuning import best_pair as pairs
from gyroctl.tuning import yardstick
from gyroctl.tuning.best_pair import BestPair, first_grid, searching
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.pair_means import as_it_acts
from gyroctl.tuning.task import read_task
from gyroctl.tuning.yardstick import Search, find_real_yardstick, find_yardstick, unsearched

SEA = gy.SeaState()
WAVES = Realisations(SEA, (3, 1), duration=120.0)
SETTINGS = gy.Settings(blend=40.0)
FOUND = Yardstick(0.05, 6e-4, True, "searched on seeds 100000 to 100063 with 8e+06 s", "k")


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[dict[str, Any]]:
    """Instead of a search: a pair that tells how it was asked, and motion that grows with the sea."""
    seen: list[dict[str, Any]] = []

    def search(plant: Any, sea: Any, budget: float, seeds: Any, goal: Goal, settings: Any, *how: Any) -> BestPair:
        asked = {"plant": plant.coefficients, "sea": sea, "goal": goal, "seeds": seeds, "how": how}
        seen.append({**asked, "actuators": settings.actuators})
        motion = sea.hs
        met = motion <= goal.motion
        return BestPair(0.05, 6e-4 if met else 1e-5, {"phi1_p98": 0.1, "phi3_p98": motion}, met, 1.0, ())

    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(yardstick, "best_pair", search)
    return seen


# --- which pair -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", [1.0, 5.0, 50.0])
def test_pairs_of_the_default_device_ship_with_the_key_of_their_search(
    device: gy.Plant, searches: list[Any], gamma: float
) -> None:
    """After a change of the equations: gyroctl tune constant --for gamma1,gamma5,gamma50 --budget 8e6 --ship."""
    found = find_yardstick(device, gy.SeaState(gamma=gamma))
    assert not searches, "the default device needs no search"
    assert found.searched
    assert found.law == gy.law("best_constant", gamma=gamma)
    assert "100000 to 100063" in found.words


CHANGES: dict[str, Any] = {
    "height": {"sea": gy.SeaState(hs=0.3)},
    "frequency": {"sea": gy.SeaState(wp=3.0)},
    "peak": {"sea": gy.SeaState(gamma=3.3)},
    "heading": {"sea": gy.SeaState(heading=10.0)},
    "kind": {"sea": gy.Regular(height=0.2, wp=3.14)},
    "mass": {"plant": gy.zhang2017(m3=2.5)},
    "damping": {"plant": gy.zhang2017(d1=3.0)},
    "variant": {"plant": gy.zhang2017("paper")},
    "drag": {"plant": gy.zhang2017(drag=0.5)},
    "position": {"plant": gy.zhang2017(position="moving")},
    "losses": {"plant": gy.zhang2017(bearing=0.01)},
    "efficiency": {"plant": gy.zhang2017(generator_efficiency=0.9)},
    "coupling limit": {"settings": gy.Settings(actuators=gy.Actuators(cc_max=0.05))},
    "generator limit": {"settings": gy.Settings(actuators=gy.Actuators(cg_max=4e-4))},
    "resolution": {"settings": gy.Settings(actuators=gy.Actuators(cc_quantum=0.01))},
    "calibration": {"settings": gy.Settings(actuators=gy.Actuators(cc_gain=0.8))},
    "motion limit": {"motion_limit": 0.3},
}
SAME: dict[str, Any] = {
    "sensors": {"settings": gy.Settings(sensors=gy.Sensors.ideal())},
    "lag and delay": {"settings": gy.Settings(actuators=gy.Actuators(cc_lag=0.3, delay=2))},
    "steps of the comparison": {"settings": gy.Settings(dt=0.005, blend=50.0)},
}


@pytest.mark.parametrize("change", CHANGES)
def test_another_sea_device_or_limit_is_searched_anew(device: gy.Plant, searches: list[Any], change: str) -> None:
    asked = {"plant": device, "sea": SEA, **CHANGES[change]}
    first, second = find_yardstick(**asked), find_yardstick(**asked)
    assert len(searches) >= 1 and searches[0]["sea"] == asked["sea"]
    assert first == second and first.searched and first.key
    before = len(searches)
    find_yardstick(**asked)
    assert len(searches) == before, "found again by its content"


@pytest.mark.parametrize("change", SAME)
def test_what_a_constant_pair_does_not_feel_needs_no_search(device: gy.Plant, searches: list[Any], change: str) -> None:
    assert find_yardstick(device, SEA, **SAME[change]).searched
    assert not searches


def test_costly_device_is_searched_for_as_the_smooth_one(searches: list[Any]) -> None:
    realistic = gy.zhang2017(variant="realistic", traction=0.3)
    found = find_yardstick(realistic, SEA)
    before = len(searches)
    assert before >= 1 and "a contact that rolls" in found.words
    smooth = find_yardstick(realistic.rolling.smooth, SEA)
    assert len(searches) == before and (smooth.cc, smooth.cg) == (found.cc, found.cg)
    assert "a contact that rolls" not in smooth.words


@pytest.mark.parametrize("gamma", [1.0, 5.0, 50.0])
def test_pair_of_real_water_is_searched_as_laws_are_tuned_there(searches: list[Any], gamma: float) -> None:
    """Device, seeds and goal are those of the task; it is found again, and another budget is another search."""
    task, sea = read_task("constant", REAL), gy.SeaState(gamma=gamma)
    found = find_real_yardstick(sea, 1.5e5)
    assert len(searches) == 1 and found.searched and (found.cc, found.cg) == (0.05, 6e-4)
    (asked,) = searches
    assert asked["plant"] == gy.zhang2017("realistic", wetted="reduced").coefficients
    assert asked["goal"] == task.goals[""][f"gamma{gamma:g}"] and list(asked["seeds"]) == list(range(100000, 100016))
    assert asked["how"][-1] == (0.01, 500.0, 800.0), "step and lengths of the task"
    assert find_real_yardstick(sea, 1.5e5) == found and len(searches) == 1
    assert find_real_yardstick(sea, 1.6e5).key != found.key and len(searches) == 2
    with pytest.raises(gy.InputError, match="no such sea"):
        find_real_yardstick(gy.SeaState(hs=0.3))


def test_pairs_of_real_water_are_none_of_the_linear_plant(monkeypatch: pytest.MonkeyPatch) -> None:
    """Though they are listed with them: the nearest pair to a sea is a linear one, for both who ask."""
    sets = yardstick.tuned_sets("constant")
    linear = {name: entry for name, entry in sets.items() if not name.startswith(REAL)}
    planted = {f"{REAL}-{name}": {**entry, "parameters": {"cc": 0.1, "cg": 1e-5}} for name, entry in linear.items()}
    # those of real water first: the order of the sets must not matter
    monkeypatch.setattr(yardstick, "tuned_sets", lambda name: {**planted, **linear})
    monkeypatch.setattr("gyroctl.controllers.rule_based.constant.shipped", lambda name: {**planted, **linear})
    for gamma in (1.0, 5.0, 50.0):
        expected = linear[f"gamma{gamma:g}"]["parameters"]
        found = unsearched(gy.SeaState(gamma=gamma), "x")
        assert {"cc": found.cc, "cg": found.cg} == expected
        law: Any = gy.law("best_constant", gamma=gamma)
        assert {"cc": law.cc, "cg": law.cg} == expected


def test_pairs_of_real_water_ship_with_the_key_of_their_search(searches: list[Any]) -> None:
    """And are no pairs of the linear plant; else: gyroctl tune constant --water real --for .. --budget 4e5 --ship."""
    shipped = {name: pair for name, pair in shipped_pairs().items() if name.startswith(REAL)}
    for name, pair in shipped.items():
        gamma = float(name.removeprefix(f"{REAL}-gamma"))
        found = find_real_yardstick(gy.SeaState(gamma=gamma))
        assert (found.cc, found.cg) == pair and not searches
        linear = unsearched(gy.SeaState(gamma=gamma), "x")
        assert (linear.cc, linear.cg) == shipped_pairs()[f"gamma{gamma:g}"]
        assert gy.law("best_constant", gamma=gamma) == linear.law


def test_water_of_another_depth_or_float_is_another_device(searches: list[Any]) -> None:
    plant = gy.zhang2017(position="moving")
    assert plant.geometry is not None
    lighter = plant.replace(geometry=replace(plant.geometry, rho=990.0))
    keys = {find_yardstick(p, SEA).key for p in (plant, plant.replace(depth=3.0), lighter)}
    assert len(keys) == 3
    assert not gy.zhang2017().replace(depth=3.0).water, "a linear plant feels neither"


def test_file_that_is_damaged_or_of_other_content_is_searched_again(
    device: gy.Plant, searches: list[Any], tmp_path: Path
) -> None:
    sea = gy.SeaState(hs=0.2)
    find_yardstick(device, sea)
    (file,) = (tmp_path / "cache").rglob("yardsticks/*.run")
    store, stored = Store(file.parent), file.read_bytes()
    record = store.load(file.stem)
    assert record is not None
    pair, content = record.content["pair"], record.content["content"]
    for damaged in (
        b"{",
        stored.replace(b'"cc": 0.05', b'"cc": 0.06'),
        {"pair": pair, "content": {}},
        {"content": content},
    ):
        if isinstance(damaged, bytes):
            file.write_bytes(damaged)
        else:
            store.save(file.stem, damaged)
        searches.clear()
        assert find_yardstick(device, sea).cc == 0.05
        assert len(searches) == 1, damaged
    again = store.load(file.stem)
    assert again is not None and again.content == record.content


def test_limit_of_motion_is_waived_where_no_pair_keeps_it(device: gy.Plant, searches: list[Any]) -> None:
    found = find_yardstick(device, gy.SeaState(hs=0.5))
    assert [math.isinf(entry["goal"].motion) for entry in searches] == [False, True]
    assert found.cg == 6e-4 and "no pair keeps the motion limit" in found.words


def test_what_cannot_be_searched_says_why(
    device: gy.Plant, searches: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    time = np.linspace(0.0, 200.0, 2001)
    record = gy.ElevationRecord(time, 0.1 * np.sin(3.14 * time))
    found = find_yardstick(device, record)
    assert not found.searched and "record" in found.words and not searches
    assert not find_yardstick(device, gy.SeaState(hs=0.2), search=False).searched

    def no_orbit(*_: Any) -> BestPair:
        raise gy.InputError("sea.hs", 0.01, "too small for a locked orbit", "Raise it")

    monkeypatch.setattr(yardstick, "best_pair", no_orbit)
    found = find_yardstick(device, gy.SeaState(hs=0.21))
    assert not found.searched and "too small for a locked orbit" in found.words
    assert (found.cc, found.cg) == shipped_pairs()["gamma5"]
    assert unsearched(gy.SeaState(gamma=30.0), "x").law == gy.law("best_constant", gamma=30.0)


# --- the search -----------------------------------------------------------------------------------------------------


def test_pair_as_it_acts_is_what_the_actuators_give(device: gy.Plant) -> None:
    limits = gy.Actuators(cc_quantum=0.02, cg_quantum=3e-4, cc_gain=0.9)
    waves = lead_in(gy.realise(device, SEA, 100200, 60.0), gy.Settings(blend=20.0))
    for pair in ((0.0582, 4.87e-4), (0.071, 2e-4), (0.05, 1e-4)):
        law = gy.law("constant", cc=pair[0], cg=pair[1])
        record, _ = run_law(device, law, waves, gy.Settings(blend=20.0, actuators=limits))
        np.testing.assert_allclose(record.controls[-1], as_it_acts(pair, limits), rtol=1e-14)
    assert as_it_acts((0.0582, 4.87e-4), gy.Actuators()) == (0.0582, 4.87e-4)


@pytest.mark.parametrize("limits", [{"cc_max": 0.01}, {"cg_max": 1e-5}, {"cc_max": 0.05, "cg_max": 3e-4}, {}])
def test_first_grid_is_within_the_limits_and_never_empty(device: gy.Plant, limits: dict[str, float]) -> None:
    settings = searching(device, gy.Settings(actuators=gy.Actuators(**limits)))
    grid = first_grid(settings)
    assert len(grid) >= 9
    assert all(0.0 < cc <= settings.actuators.cc_max and 0.0 < cg <= settings.actuators.cg_max for cc, cg in grid)


def test_search_leaves_the_first_grid_where_the_best_gain_lies_beyond(
    device: gy.Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A regular wave that holds lock up to a gain above the grid: against a scan of gains beside it."""
    monkeypatch.setattr(pairs, "WINDOW", 250.0)
    monkeypatch.setattr(pairs, "FULL", 250.0)
    monkeypatch.setattr(pairs, "ROUNDS", 4)
    wave = gy.Regular(height=0.3, wp=3.14)
    budget = pairs.FEWEST * 72 * 250.0 / pairs.SHARES[0] + 1.0
    found = pairs.best_pair(device, wave, budget, [100000], Goal(locked=0.98, motion=math.inf), quiet=True)
    assert found.met and found.cg > max(pairs.CG)
    grid = [(cc, cg) for cc in (0.04, 0.06, 0.08) for cg in np.geomspace(1e-3, 1.2e-2, 12).tolist()]
    run = scan(device, wave, grid, [100000], 250.0, workers=1, quiet=True)
    held = run.mean_power[run.locked]
    assert found.means["mean_power"] >= 0.9 * held.max()


# --- its place in a comparison --------------------------------------------------------------------------------------


def test_no_other_law_takes_the_name_of_the_yardstick(device: gy.Plant) -> None:
    weak = {
        "another law": gy.law("load_angle"),
        "a weak pair": gy.law("constant", cc=0.05, cg=1e-5),
        "wrapped": gy.law("supervisor", wraps="best_constant"),
    }
    for what, law in weak.items():
        for known in (None, FOUND):
            with pytest.raises(gy.InputError, match="name is that of the yardstick") as error:
                compare(device, {BASELINE: law}, WAVES, SETTINGS, quiet=True, yardstick=known)
            assert error.value.field == "laws.best_constant", what


@pytest.mark.parametrize(
    "table", [{"law": "constant", "cc": 0.05, "cg": 1e-5}, {"law": "load_angle"}, {"gamma": 50.0}, {"cg": 1e-5}]
)
def test_experiment_file_cannot_replace_it(table: dict[str, Any]) -> None:
    with pytest.raises(gy.InputError) as error:
        build_experiment({"laws": {"best_constant": table, "coupling": {}}})
    assert error.value.field == "laws.best_constant"
    assert list(build_experiment({"laws": {"best_constant": {}, "coupling": {}}}).laws) == ["best_constant", "coupling"]


def test_yardstick_takes_part_and_the_report_says_that_it_was_searched(device: gy.Plant) -> None:
    laws = {"mine": gy.law("constant", cc=0.05, cg=6e-4), BASELINE: gy.law("best_constant")}
    ds = compare(device, laws, WAVES, SETTINGS, workers=1, quiet=True, yardstick=FOUND)
    assert list(ds.law.values) == ["mine", BASELINE]
    np.testing.assert_array_equal(ds.mean_power.sel(law=BASELINE), ds.mean_power.sel(law="mine"))
    found = evaluate(ds)
    assert not any("not searched" in sentence for sentence in judge(found).sentences)
    assert summarise(ds)["yardstick"]["searched"] is True
    added = compare(device, {"mine": laws["mine"]}, WAVES, SETTINGS, workers=1, quiet=True, yardstick=FOUND)
    assert list(added.law.values) == ["mine", BASELINE]


def test_verdict_says_that_a_pair_was_not_searched(device: gy.Plant) -> None:
    laws = {"mine": gy.law("load_angle"), BASELINE: gy.law("best_constant")}
    ds = compare(device, laws, WAVES, SETTINGS, workers=1, quiet=True)
    text = " ".join(judge(evaluate(ds)).sentences)
    assert "best_constant was not searched for this sea and device" in text
    without = ds.assign_attrs({key: value for key, value in ds.attrs.items() if key != "yardstick"})
    del without.attrs["yardstick"]
    assert "was not searched" in " ".join(judge(evaluate(without)).sentences)
    alone = compare(device, {"mine": laws["mine"]}, WAVES, SETTINGS, workers=1, quiet=True)
    assert not any("best_constant" in sentence for sentence in judge(evaluate(alone)).sentences)


@pytest.mark.slow
def test_command_searches_for_the_sea_of_the_experiment(searches: list[Any], tmp_path: Path) -> None:
    toml = tmp_path / "e.toml"
    toml.write_text(
        "[sea]\nhs = 0.25\n[plant]\nd1 = 3.0\n[run]\nduration = 120\nblend = 40\nseeds = [1, 2]\nmotion_limit = 0.3\n"
        "[actuators]\ncc_max = 0.1\n[laws.coupling]\n"
    )
    done = CliRunner().invoke(app, ["compare", str(toml), "--out", f"{tmp_path}/out", "--workers", "1"])
    assert done.exit_code == 0, done.output
    (asked,) = searches
    assert asked["sea"] == gy.SeaState(hs=0.25)
    assert (asked["goal"].motion, asked["actuators"].cc_max) == (0.3, 0.1)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["yardstick"]["cg"] == 6e-4 and summary["yardstick"]["searched"]
    assert "not searched" not in done.output
    searches.clear()
    other = toml.read_text().replace("0.25", "0.24")
    toml.write_text(other)
    done = CliRunner().invoke(app, ["compare", str(toml), "--no-search", "--out", f"{tmp_path}/out", "--workers", "1"])
    assert not searches and "not searched" in " ".join(done.output.split())


def test_content_holds_every_number_of_the_sea_and_the_device(device: gy.Plant) -> None:
    """A key that forgets a field would give one sea the pair of another."""
    base = Search(device, SEA, gy.Settings(), Goal())
    keys = {base.key}
    for sea in (replace(SEA, hs=0.2), replace(SEA, wp=3.0), replace(SEA, gamma=2.0), replace(SEA, heading=1.0)):
        keys.add(base._replace(sea=sea).key)
    for name, value in (("m1", 20.0), ("k1", 150.0), ("d3", 1.0), ("J14", 0.4), ("d", 0.6)):
        keys.add(base._replace(plant=gy.zhang2017(**{name: value})).key)
    keys |= {base._replace(goal=Goal(locked=0.9)).key, base._replace(budget=1e6).key, base._replace(seeds=[1]).key}
    assert len(keys) == 13
