"""Table `price`: its steps end in what ships, every change is that of the pairs, and the bars show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kept_results import kept
from result_blocks import physics as blocks
from result_blocks import pictures, source
from scipy import stats
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.devices import VARIANTS
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.simulation.metrics import evaluate
from gyroctl.simulation.validity import validity
from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation import price, price_steps, request
from gyroctl.studies.evaluation.cases import Outcome, Runs
from gyroctl.studies.evaluation.draw_price import begins, draw_price
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.studies.evaluation.price import LAW, TOLD, WATER, Stage, lines_of, price_table, setting, staged, totals
from gyroctl.studies.evaluation.price_steps import Choice, choices, previews, waters
from gyroctl.studies.evaluation.real_water import LINEAR, WATERS, Water

SEEDS = np.arange(1, 17)
COLUMNS = (
    *("mean_power", "power_cv", "power_cv_1s", "phi1_p98", "phi3_p98", "phi1_max", "phi3_max", "outside_share"),
    *("cycle_slips", "generated_w", "stored_w", "slip_loss_w", "wave_input_w", "saturations", "ledger_residual"),
    *("outside_model", "step_ms_median", "step_ms_p99", "fallbacks", "deadline_misses", "failed", "reversals"),
)
EVEN = np.resize([1.0, -1.0], 16)
"""Scatter without skewness, so that an interval is Student's."""


def runs(label: str = "nmpc", seeds: Any = SEEDS, **columns: Any) -> Runs:
    """Planted runs; what is not given is zero, and all hold lock."""
    n = len(seeds)
    values = {name: np.zeros(n) for name in COLUMNS}
    values |= {"locked": np.ones(n), "turns_kept": np.ones(n), "waves_counted": np.full(n, 250.0)}
    values |= {name: np.broadcast_to(np.asarray(value, float), n).copy() for name, value in columns.items()}
    hashes = tuple(map(str, seeds))
    return Runs(Entrant(label, label), "planning", "sensors", np.asarray(seeds, np.int64), hashes, values)


def stage(step: str, group: str = WATER, seeds: Any = SEEDS, **columns: Any) -> Stage:
    return Stage(group, step, {"drag": 0.5}, runs(step, seeds, **columns), runs("best_constant"))


# --- the steps -------------------------------------------------------------------------------------------------------


def test_waters_go_from_the_linear_device_to_the_realistic_one_that_lags() -> None:
    chain = waters()
    assert chain[0].plant().parameters == gy.zhang2017().parameters and chain[0].lag == 0.0
    assert chain[-1].plant().parameters == chain[-2].plant().parameters == gy.zhang2017("realistic").parameters
    assert [water.lag for water in chain] == [0.0] * (len(chain) - 1) + [WATERS[-1].lag] and WATERS[-1].lag > 0.0
    assert len({water.name for water in chain}) == len(chain)
    for before, water in pairwise(chain[:-1]):
        assert before.choices.items() < water.choices.items(), "each has what those before have, and more"


def test_effects_come_one_at_a_time_with_all_that_makes_them() -> None:
    chain = waters()
    new = [set(now.choices) - set(before.choices) for before, now in pairwise(chain)]
    assert new[0] == {"drag"}
    assert {"contact", "traction"} in new, "the coefficient is said, though it be the default"
    assert {"position"} in new and {"wetted"} in new and {"bearing"} in new
    assert set.union(*new) <= set(VARIANTS["realistic"])


def test_what_the_variant_gets_one_day_is_a_step_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    wider = {**VARIANTS["realistic"], "drag": 0.7, "generator_efficiency": 0.9}
    monkeypatch.setitem(VARIANTS, "realistic", wider)
    chain = waters(lag=0.03)
    assert chain[1].choices == {"drag": 0.7}
    assert chain[-2].name == price_steps.REST
    assert set(chain[-2].choices) - set(chain[-3].choices) == {"generator_efficiency"}
    assert chain[-1].lag == 0.03 and chain[-1].plant().parameters == gy.zhang2017("realistic").parameters


def built(choice: Choice) -> dict[str, Any]:
    return describe(choice.entrant("nmpc").build())


def test_law_goes_from_the_linear_set_to_the_shipped_one() -> None:
    steps = choices("nmpc")
    linear, last = describe(gy.law("nmpc")), gy.law("nmpc", plant="realistic", lag=price_steps.LAG)
    first = built(steps[0])
    assert {key for key in first if first[key] != linear[key]} == {"plant"}
    assert built(steps[-1]) == describe(last)
    assert built(steps[-2]) == {**describe(last), "lag": 0.0}
    for before, now in pairwise(steps):
        one, other = built(before), built(now)
        assert {key for key in one if one[key] != other[key]} == set(now.new), now.name
    assert set(steps[1].new) == {"every", "retries", "rivals", "life"} and steps[1].new["rivals"] > 1
    assert "traction" in steps[3].new and "flywheel" in steps[4].new


def test_set_that_is_tuned_anew_is_taken_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that has the lag, leaves the rivals alone, and has a parameter that no step names."""
    set_ = {"plant": "realistic", "traction": 0.2, "travel": 3.0, "lag": 0.05}
    monkeypatch.setattr(price_steps, "tuned_sets", lambda _: {"real": {"parameters": set_}})
    found = {choice.name: choice for choice in choices("nmpc", lag=0.04)}
    assert [dict(choice.new) for choice in found.values()] == [
        {"plant": "realistic"},
        {},
        {},
        {"traction": 0.2},
        {"travel": 3.0},
        {"lag": 0.04},
    ]
    assert found[price_steps.TUNED].parameters["lag"] == 0.0
    assert found[price_steps.TOLD].parameters == {**set_, "lag": 0.04}


def test_planner_without_a_set_for_real_water_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(price_steps, "tuned_sets", lambda _: {"all": {"parameters": {}}})
    with pytest.raises(gy.InputError) as caught:
        choices("nmpc")
    assert caught.value.field == "planner" and "real" in str(caught.value)


def test_preview_is_all_that_the_last_step_lacks() -> None:
    last = choices("nmpc")[-1]
    (oracle,) = previews(last)
    assert built(oracle) == {**built(last), "information": "oracle"}


def test_setting_is_written_as_it_is_typed() -> None:
    assert setting({"drag": 0.5, "wetted": "surface", "life": 8.0}) == "drag = 0.5, wetted = surface, life = 8"
    assert setting({}) == "nothing"


# --- what is made of the runs ----------------------------------------------------------------------------------------


def test_change_is_that_of_the_pairs_with_its_interval() -> None:
    sea = 3.0 * np.sin(SEEDS)  # what both have of the same sea drops out
    before = stage("before", mean_power=10.0 + sea, power_cv=0.2 + 0.01 * sea)
    now = stage("now", mean_power=8.0 + sea + 0.5 * EVEN, power_cv=0.25 + 0.01 * sea + 0.02 * EVEN)
    first, line = lines_of([before, now])
    assert first.change is None and first.before == "" and first.words == ""
    assert line.change is not None and line.seen is not None and line.cv_change is not None
    assert line.before == "before"
    arm = stats.t.ppf(0.975, 15) * np.std(EVEN, ddof=1) / 4.0
    for found, mean, scatter in ((line.seen, -2.0, 0.5), (line.cv_change, 0.05, 0.02)):
        assert found.value == pytest.approx(mean)
        assert (found.low, found.high) == pytest.approx((mean - scatter * arm, mean + scatter * arm), rel=1e-6)
    assert line.change.value == line.seen.value
    assert line.change.low < line.seen.low and line.change.high > line.seen.high, "losses that were not seen"


def test_only_realisations_that_both_have_are_paired() -> None:
    before = stage("before", seeds=SEEDS[:12], mean_power=SEEDS[:12])
    now = stage("now", seeds=SEEDS[4:], mean_power=SEEDS[4:] + 2.0)
    line = lines_of([before, now])[1]
    assert line.seen is not None and line.seen.value == pytest.approx(2.0) and line.seen.low == pytest.approx(2.0)
    assert line.row.power.value == pytest.approx(np.mean(SEEDS[4:] + 2.0))


def test_runs_without_reversal_are_counted_and_none_without_numbers() -> None:
    back = [0.0] * 9 + [1.0, 7.0, np.nan] + [0.0] * 4
    line = lines_of([stage("one", reversals=back, locked=[0.0] * 3 + [1.0] * 13)])[0]
    assert (line.without_reversal, line.row.locked) == (13, 13)


def test_words_are_those_of_the_corrected_test() -> None:
    chain = [stage("a", mean_power=10.0 + 0.1 * EVEN), stage("b", mean_power=3.0 - 0.1 * EVEN)]
    chain += [stage("c", mean_power=3.0 + 2.0 * EVEN), stage("d", mean_power=12.0 - 0.1 * EVEN)]
    lines = lines_of(chain)
    assert [line.words for line in lines] == ["", "takes", "not distinguishable", "wins"]
    p = sorted(line.p_value for line in lines[1:])
    assert sorted(line.p_holm for line in lines[1:])[0] == pytest.approx(3.0 * p[0])


def test_groups_add_up_to_the_whole() -> None:
    powers = {"linear": 17.0, "drag": 14.0, "lags": 4.0, "tuned": 10.0, "told": 11.0, "oracle": 13.0}
    groups = [WATER] * 3 + [LAW] * 2 + [TOLD]
    chain = [stage(step, g, mean_power=p + 0.1 * EVEN) for (step, p), g in zip(powers.items(), groups, strict=True)]
    found = totals(chain)
    ends = {name: (one["from"], one["to"], round(one["seen"].value, 9)) for name, one in found.items()}
    assert ends == {
        WATER: ("linear", "lags", -13.0),
        LAW: ("lags", "told", 7.0),
        TOLD: ("told", "oracle", 2.0),
        "in all": ("linear", "told", -6.0),
    }


def test_step_without_runs_is_left_out_and_the_next_stands_against_the_one_before() -> None:
    case: Any = None
    laws = {name: runs(name, mean_power=p) for name, p in (("first", 9.0), ("third", 11.0), ("best_constant", 2.0))}
    wanted = [Choice(name, {}, {}) for name in ("first", "second", "third")]
    lines = lines_of(staged(Outcome(case, laws, {"second": "failed"}), wanted, LAW))
    assert [line.step for line in lines] == ["first", "third"]
    assert lines[1].before == "first" and lines[1].change is not None and lines[1].change.value == 2.0


# --- the picture -----------------------------------------------------------------------------------------------------


def recorded() -> list[dict[str, Any]]:
    chain = [stage("linear", mean_power=17.0 + EVEN), stage("drag", mean_power=14.0 - 0.5 * EVEN)]
    chain += [stage("told", LAW, mean_power=15.5 + EVEN, reversals=EVEN > 0.0)]
    return [line.record() for line in lines_of(chain)]


def test_bars_go_from_the_step_before_to_their_own() -> None:
    steps = recorded()
    assert begins(steps) == pytest.approx([0.0, 17.0, 14.0])
    figure = draw_price(steps, {"own_seeds": {}, "seeds": [1], "duration_s": 500.0})
    bars: Any = figure.axes[0].patches
    spans = [(bar.get_x(), bar.get_x() + bar.get_width(), round(bar.get_y() + 0.5 * bar.get_height())) for bar in bars]
    expected = sorted([(0.0, 17.0, 0), (0.0, 14.0, 1), (17.0, 14.0, 1), (0.0, 15.5, 2), (14.0, 15.5, 2)])
    np.testing.assert_allclose(sorted(spans), expected, rtol=1e-12)
    change: Estimate = steps[1]["change"]
    lines: Any = figure.axes[0].lines
    ends = [line.get_xdata() for line in lines if len(line.get_xdata()) == 2]
    for one in (change, steps[1]["seen"]):
        assert any(np.allclose(each, (17.0 + one.low, 17.0 + one.high)) for each in ends)
    marks: Any = figure.axes[2].lines
    shares = [line.get_xdata()[0] for line in marks if line.get_marker() == "o"]
    assert shares == [1.0, 1.0, 0.5]


# --- the table -------------------------------------------------------------------------------------------------------


def by_hand(settings: Settings, law: gy.Law, **device: Any) -> tuple[float, int]:
    """Mean power, and runs without reversal, of two runs with that law in that device."""
    plant, sea, powers, forward = gy.zhang2017(**device), gy.SeaState(gamma=5.0), [], 0
    for seed in (100000, 100001):
        waves = lead_in(gy.realise(plant, sea, seed, 130.0), settings)
        record, _ = run_law(plant, law, waves, settings)
        powers.append(evaluate(plant, record, waves.moments[1], waves.dt, sea.wp, 100.0, 1.0)["mean_power"])
        forward += validity(plant, record, waves, 100.0)["reversals"] == 0.0
    return float(np.mean(powers)), forward


def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chain: tuple[Water, ...]) -> tuple[Mapping[str, Any], str]:
    """The table with a law that is quick in the place of the planner."""
    monkeypatch.setattr(price, "choices", lambda planner, lag: [Choice("stiffer", {"cc": 0.08}, {"cc": 0.08})])
    monkeypatch.setattr(price, "previews", lambda last: [])
    told: Any = {"planner": "constant", "workers": 1, "quiet": True}
    ask = request(tmp_path, "constant", ["100000:100001"], 130.0, allow_tuning_seeds=True, **told)
    content, text, _ = price_table(ask, chain)
    return content, text


def test_steps_are_those_devices_and_laws_bit_for_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chain = (Water(LINEAR, {}), Water("drag", {"drag": 1.0}), Water("lag", {"drag": 1.0}, 0.05))
    content, text = table(tmp_path, monkeypatch, chain)
    usual = Settings()
    lags = replace(usual, actuators=replace(usual.actuators, cc_lag=0.05))
    expected = [by_hand(usual, gy.law("constant")), by_hand(usual, gy.law("constant"), drag=1.0)]
    expected += [by_hand(lags, law, drag=1.0) for law in (gy.law("constant"), gy.law("constant", cc=0.08))]
    steps = content["steps"]
    assert [(step["power"].value, step["without_reversal"]) for step in steps] == expected
    assert [dict(step["sets"]) for step in steps] == [{}, {"drag": 1.0}, {"actuators.cc_lag": 0.05}, {"cc": 0.08}]
    assert [step["group"] for step in steps] == [WATER, WATER, WATER, LAW]
    powers = [power for power, _ in expected]
    assert [step["change"].value for step in steps[1:]] == pytest.approx(np.diff(powers).tolist(), rel=1e-12)
    assert content["totals"]["in all"]["change"].value == pytest.approx(powers[-1] - powers[0], rel=1e-12)
    assert "| lag | actuators.cc_lag = 0.05 |" in text and "| stiffer | cc = 0.08 |" in text


def test_a_water_that_cannot_be_built_is_told_and_skipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chain = (Water(LINEAR, {}), Water("not so", {"drag": -1.0}), Water("drag", {"drag": 1.0}))
    content, _ = table(tmp_path, monkeypatch, chain)
    assert list(content["failed"]) == ["not so"] and "drag" in content["failed"]["not so"]
    assert [step["step"] for step in content["steps"]] == [LINEAR, "drag", "stiffer"]
    assert content["steps"][1]["before"] == LINEAR
    with pytest.raises(gy.InputError, match="drag"):
        table(tmp_path, monkeypatch, chain[:2])


def test_page_is_written_from_what_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gyroctl.writing import write_json

    lines = recorded()
    chain = [stage("linear", mean_power=17.0 + EVEN), stage("drag", mean_power=14.0 - 0.5 * EVEN)]
    asked = {"duration_s": 500.0, "seeds": [1], "own_seeds": {}, "laws": ["nmpc"], "seed_states": {"spent": [1]}}
    report = {"gamma": 5.0, "pair": {}, "steps": lines, "totals": totals(chain), "request": asked, "failed": {}}
    report |= {"command": "gyroctl evaluate price", "gyroctl_version": "0", "date": "2026-01-01"}
    write_json(tmp_path / "price.json", report)
    found = kept("price", source.json.loads((tmp_path / "price.json").read_text(encoding="utf-8")))
    for module in (blocks, pictures, source):
        monkeypatch.setattr(module, "result", lambda name: found)
    text = blocks.price()
    assert "| drag | `drag = 0.5` | 14.0" in text and "| 8 of 16 |" in text and "linear → drag" in text
    assert text.rstrip().endswith("version 0, 2026-01-01.*")
    figure = pictures.PICTURES["docs/price.png"].figure()
    assert len(figure.axes[0].patches) == 5


def test_tuning_seeds_are_refused(tmp_path: Path) -> None:
    told = ["evaluate", "price", "--seeds", "100000:100001", "--duration", "260", "--out", str(tmp_path / "out")]
    found = CliRunner().invoke(app, told)
    assert found.exit_code != 0 and "kept for tuning" in f"{found.output} {found.exception}"
    assert not (tmp_path / "out").exists()
