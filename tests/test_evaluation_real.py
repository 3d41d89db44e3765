"""The table of laws in real water: who takes part with which set, what is made of the runs, the targets, by hand."""

from __future__ import annotations

import json
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kept_results import kept
from result_blocks import real as blocks
from result_blocks import source

import gyroctl as gy
from gyroctl.harness.yardstick import Yardstick
from gyroctl.reports.wording import number
from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation import Request, evaluate_tables, real, request
from gyroctl.studies.evaluation.cases import Case, Outcome, Runs
from gyroctl.studies.evaluation.draw_real import corner
from gyroctl.studies.evaluation.entrants import Entrant, in_real_water, pair, real_set, set_in_words
from gyroctl.studies.evaluation.real_lines import Line, lines_of
from gyroctl.studies.evaluation.real_targets import (
    CV,
    FORWARD,
    IN_STEP,
    LOCKED,
    OVER,
    PHI1_LESS,
    PHI3,
    POWER,
    SINGLE,
    TARGETS,
    Answer,
    Target,
    answer,
    answers,
    least,
    most,
)
from gyroctl.studies.evaluation.real_water import Water
from gyroctl.studies.evaluation.rows import Row
from gyroctl.studies.evaluation.seas import asked_for
from gyroctl.writing import plain

SEEDS = np.arange(100000, 100008)
Z = 1.959964
"""Of the normal distribution, for Wilson's interval at 95 %."""


# --- who takes part, with which set ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sets", "sea", "expected"),
    [
        (("all", "gamma5", "real", "real-gamma5"), "gamma5", "real"),
        (("all", "real-gamma1", "real-gamma5"), "gamma5", "real-gamma5"),
        (("all", "real-gamma5"), "gamma50", "real-gamma5"),
        (("all", "gamma5"), "gamma5", "all"),
        ((), "gamma1", "all"),
    ],
)
def test_set_for_real_water_is_the_widest_that_there_is(sets: tuple[str, ...], sea: str, expected: str) -> None:
    assert real_set(sets, sea) == expected


def test_words_tell_a_set_of_another_sea_from_one_of_this(monkeypatch: pytest.MonkeyPatch) -> None:
    words = [set_in_words(one, "gamma5") for one in ("real", "real-gamma5", "real-gamma1", "all")]
    assert words == [
        "real: all seas",
        "real-gamma5: this sea alone",
        "real-gamma1: gamma1 alone, not this sea",
        "all: not tuned in real water",
    ]


def test_laws_take_their_set_unless_another_was_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    sets: dict[str, Any] = {"all": {}, "real": {}}
    monkeypatch.setattr("gyroctl.studies.evaluation.entrants.tuned_sets", lambda name, allow_code=(): sets)
    given = [Entrant("a", "a", {"x": 1.0}), Entrant("b", "b", {}, "gamma5"), Entrant("constant", "constant")]
    found = in_real_water(given, "gamma5")
    assert [one.tuning for one in found] == ["real", "gamma5", "all"], "the sets of constant are the yardsticks"
    assert found[0].parameters == {"x": 1.0}


def test_planning_law_plans_with_the_device_and_the_lag_that_its_set_tells() -> None:
    (entrant,) = in_real_water([Entrant("nmpc", "nmpc")], "gamma5")
    built: Any = entrant.build()
    assert built.plant.coefficients == gy.zhang2017("realistic").coefficients
    own = gy.law("nmpc", plant="realistic")
    assert built == own, "as the registry takes it for a design model beyond the linear one"
    told = real.set_of(entrant, 5.0)
    assert told["set"] == "real" and "realistic" in told["plant"]
    assert told.get("lag") == getattr(own, "lag", None)


# --- what is made of the runs ---------------------------------------------------------------------------------------


def runs(label: str, **metrics: Any) -> Runs:
    """Planted runs: a number is that of every run."""
    entrant = pair(0.06, 4e-4) if label == "best_constant" else Entrant(label, label, {}, "real")
    names = (
        *("mean_power", "power_cv", "power_cv_1s", "phi1_p98", "phi3_p98", "phi1_max", "phi3_max", "outside_share"),
        *("cycle_slips", "generated_w", "stored_w", "slip_loss_w", "wave_input_w", "saturations", "ledger_residual"),
        *("outside_model", "step_ms_median", "step_ms_p99", "fallbacks", "deadline_misses", "failed", "reversals"),
        *("beyond_validity", "locked", "turns_kept", "waves_counted"),
    )
    usual = {"locked": 1.0, "turns_kept": 1.0, "waves_counted": 450.0, "mean_power": 2.0}
    values = {name: np.full(SEEDS.size, usual.get(name, 0.0)) for name in names}
    values |= {name: np.broadcast_to(np.asarray(value, float), SEEDS.shape) for name, value in metrics.items()}
    return Runs(entrant, "planning", "sensors", SEEDS, tuple(map(str, SEEDS)), values)


def outcome(*each: Runs) -> Outcome:
    case = Case("gamma 5", gy.zhang2017(), gy.SeaState(), gy.Settings())
    return Outcome(case, {one.entrant.label: one for one in each}, {})


def wilson(count: int, n: int) -> tuple[float, float]:
    """Wilson's interval from its quadratic equation (p - x)^2 = z^2 x (1 - x) / n."""
    share, z2 = count / n, Z**2 / n
    roots = np.roots([1.0 + z2, -(2.0 * share + z2), share**2])
    return float(roots.min()), float(roots.max())


def test_runs_without_a_reversal_and_runs_that_give_enough_are_counted() -> None:
    """Of eight runs two roll back and one has no number; of the single ones the limits themselves are enough."""
    reversals = [0.0, 0.0, 3.0, 0.0, 1.0, math.nan, 0.0, 0.0]
    power = [9.0, 12.0, 8.99, 12.0, 12.0, math.nan, 12.0, 12.0]
    cv = [0.25, 0.1, 0.1, 0.2501, 0.1, 0.1, math.nan, 0.1]
    lines = lines_of(outcome(runs("best_constant"), runs("law", reversals=reversals, mean_power=power, power_cv=cv)))
    found = lines["law"]
    for share, count in ((found.forward, 5), (found.single, 4)):
        assert share.value == count / 8
        np.testing.assert_allclose((share.low, share.high), wilson(count, 8), atol=1e-6)
    assert found.reversals.value == pytest.approx(4.0 / 7.0), "a mean leaves out what has no number"
    assert list(lines) == ["law", "best_constant"], "the one of most power first"


def test_motion_beside_the_pair_is_a_paired_difference() -> None:
    """It does not feel what both have from the sea: the interval is Student's of the differences."""
    from scipy.stats import t

    sea = np.linspace(0.3, 0.6, 8)
    off = np.array([-0.02, -0.01, -0.03, 0.0, -0.02, -0.01, -0.03, -0.02])
    found = lines_of(outcome(runs("best_constant", phi1_p98=sea), runs("law", phi1_p98=sea + off, phi3_p98=0.2)))
    less = found["law"].phi1_less
    half = t.ppf(0.975, 7) * off.std(ddof=1) / math.sqrt(8.0)
    assert less.value == pytest.approx(off.mean())
    assert less.low <= off.mean() - half + 1e-12 and less.high >= off.mean() + half - 1e-12
    assert less.high - less.low < 0.5 * (found["law"].phi1.high - found["law"].phi1.low)
    assert found["best_constant"].phi1_less.value == 0.0
    assert found["law"].phi3.value == pytest.approx(0.2) and found["law"].phi1.value == pytest.approx(
        (sea + off).mean()
    )


def test_power_beside_three_times_the_pairs_is_a_paired_difference_whatever_its_sign() -> None:
    pair = np.array([-0.5, 1.0, -1.5, 0.5, -2.0, 1.0, -0.5, -1.0])
    found = lines_of(outcome(runs("best_constant", mean_power=pair), runs("law", mean_power=9.0 + 3.0 * pair)))
    assert found["law"].over.value == pytest.approx(9.0) and found["law"].over.high - found["law"].over.low < 9.0
    assert found["best_constant"].over.value == pytest.approx(-2.0 * pair.mean())


# --- the targets ----------------------------------------------------------------------------------------------------


def sure(value: float, arm: float = 0.0) -> Estimate:
    return Estimate(value, value - arm, value + arm)


GOOD: dict[str, Any] = {
    **{"power": sure(11.0), "cv": sure(0.20), "lock": sure(0.99), "step": sure(0.99), "over": sure(0.0)},
    **{"forward": sure(0.95), "single": sure(0.95), "phi1_less": sure(0.0), "phi3": sure(0.25)},
}
"""What just meets every demand on the planning law."""


def made(law: str = "law", kind: str = "planning", tuning: str = "real", **changes: Any) -> Line:
    """Make a line that meets all targets of the planning law, but for the changes."""
    own = {name for name in Line._fields if name != "row"}
    values = {**GOOD, **changes}
    empty: dict[str, Any] = {field.name: 0 for field in fields(Row)}
    head = {"law": law, "kind": kind, "information": "sensors", "tuning": tuning}
    row = Row(**{**empty, **head, **{name: value for name, value in values.items() if name not in own}})
    return Line(row, **{name: values.get(name, sure(0.0)) for name in own})


def judged(line: Line, gamma: float = 5.0) -> Answer:
    return next(one for one in answers({gamma: [line]}) if one.target.gamma == gamma and one.target.kind == "planning")


def test_targets_are_those_that_were_set() -> None:
    asked = {(one.name, one.gamma): {(d.measure, d.limit, d.most) for d in one.demands} for one in TARGETS}
    lock = {(LOCKED, 0.99, False), (IN_STEP, 0.99, False)}
    home = {(POWER, 11.0, False), (CV, 0.2, True), (FORWARD, 0.95, False), (SINGLE, 0.95, False)}
    abroad = {(OVER, 0.0, False), (LOCKED, 0.98, False), (FORWARD, 0.9, False)}
    assert asked == {
        ("planning law", 5.0): home | lock | {(PHI1_LESS, 0.0, True), (PHI3, 0.25, True)},
        ("planning law, same parameters", 1.0): abroad,
        ("planning law, same parameters", 50.0): abroad,
        ("a simple law, most power", 5.0): {(POWER, 4.5, False), (FORWARD, 0.95, False)} | lock,
        ("a simple law, smooth", 5.0): {(POWER, 3.5, False), (CV, 0.35, True)} | lock,
    }


WORSE = {
    **{"power": sure(10.99), "cv": sure(0.201), "lock": sure(0.989), "step": sure(0.989), "forward": sure(0.949)},
    **{"single": sure(0.949), "phi1_less": sure(1e-4), "phi3": sure(0.251)},
}


@pytest.mark.parametrize("measure", WORSE)
def test_each_limit_is_one_of_its_own(measure: str) -> None:
    assert judged(made()).verdict == "met"
    found = judged(made(**{measure: WORSE[measure]}))
    assert found.verdict == "not met"
    assert [one.verdict for one in found.findings].count("not met") == 1


@pytest.mark.parametrize(("measure", "value"), [("over", -0.01), ("lock", 0.979), ("forward", 0.899)])
def test_other_seas_ask_for_their_own(measure: str, value: float) -> None:
    enough = {"over": sure(0.0), "lock": sure(0.98), "forward": sure(0.9), "power": sure(4.0), "cv": sure(0.9)}
    assert judged(made(**enough), 50.0).verdict == "met"
    assert judged(made(**{**enough, measure: sure(value)}), 50.0).verdict == "not met"


def test_what_was_not_run_is_open_and_so_is_what_has_no_number() -> None:
    found = {(one.target.name, one.target.gamma): one for one in answers({5.0: [made()]})}
    assert found["planning law, same parameters", 1.0].verdict == "open"
    assert found["a simple law, smooth", 5.0].verdict == "open" and found["a simple law, smooth", 5.0].law == ""
    assert judged(made(power=Estimate(math.nan, math.nan, math.nan))).verdict == "open"
    one_sea = made(tuning="real-gamma5")
    assert judged(one_sea).law == "", "a set of one sea is not the same in all"


def test_verdict_says_where_its_interval_would_say_otherwise() -> None:
    demand = Target("t", 5.0, "planning", (least(POWER, 11.0), most(CV, 0.2)))
    power, cv = answer(demand, [made(power=sure(12.0, 0.5), cv=sure(0.19, 0.02))]).findings
    assert (power.verdict, power.sure, cv.verdict, cv.sure) == ("met", True, "met", False)
    power, cv = answer(demand, [made(power=sure(10.0, 0.5), cv=sure(0.21, 0.02))]).findings
    assert (power.verdict, power.sure, cv.verdict, cv.sure) == ("not met", True, "not met", False)
    (power, _) = answer(demand, [made(power=Estimate(12.0, math.nan, math.nan))]).findings
    assert not power.sure, "two runs have no interval"


def test_one_simple_law_is_to_keep_all_demands_at_once() -> None:
    strong = made("strong", "simple", power=sure(6.0), cv=sure(0.5), step=sure(0.5))
    smooth = made("smooth", "simple", power=sure(3.6), cv=sure(0.3))
    table = {5.0: [strong, smooth, made("nmpc")]}
    found = {one.target.name: one for one in answers(table) if one.target.kind == "simple"}
    assert found["a simple law, smooth"].verdict == "met" and found["a simple law, smooth"].law == "smooth"
    assert found["a simple law, most power"].verdict == "not met", "neither has power and step together"
    better = made("better", "simple", power=sure(5.0), cv=sure(0.3))
    again = {one.target.name: one for one in answers({5.0: [strong, smooth, better]}) if one.target.kind == "simple"}
    assert {one.law for one in again.values()} == {"better"} and {one.verdict for one in again.values()} == {"met"}


def test_nearest_law_is_that_of_the_smallest_gaps() -> None:
    """By hand: 0.9 W of 4.5 are a fifth, and so are 0.198 of 0.99; a law of more power that is never in step is far."""
    near = made("near", "simple", power=sure(3.6), step=sure(0.792))
    far = made("far", "simple", power=sure(6.0), step=sure(0.0), cv=sure(0.9))
    target = next(one for one in TARGETS if one.name == "a simple law, most power")
    assert (target.shortfall(near), target.shortfall(far)) == (pytest.approx(0.4), pytest.approx(1.0))
    assert answer(target, [far, near]).law == "near"
    assert [one.verdict for one in answer(target, [far, near]).findings] == ["not met", "met", "not met", "met"]


def test_corner_of_the_figure_is_what_a_target_asks_for() -> None:
    constant = made("best_constant", "constant", power=sure(1.5))
    corners = {(one.name, one.gamma): corner(one, [constant]) for one in TARGETS}
    assert corners["planning law", 5.0] == (0.2, 11.0)
    assert corners["planning law, same parameters", 1.0] == (math.inf, 4.5)


def blocks_of(content: dict[str, Any], ask: Request, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """What the pages show of a table once its report is kept."""
    made = {"command": "gyroctl evaluate real", "gyroctl_version": "0", "date": "2026-11-28"}
    report = json.loads(json.dumps(plain({**made, "request": ask.record(), **content})))
    own = kept("real", report)
    results = {"real": own, **dict.fromkeys(blocks.LATER, own), "seas": {**made, "seas": {"gamma5": []}}}
    monkeypatch.setattr(blocks, "result", results.__getitem__)
    monkeypatch.setattr(source, "result", results.__getitem__)
    return {name: make() for name, make in blocks.BLOCKS.items()}


def test_targets_are_those_of_the_report_in_which_a_law_was_judged_last(monkeypatch: pytest.MonkeyPatch) -> None:
    """Target by target and sea by sea: two targets of one name are not one, and an open one replaces nothing."""

    def told(name: str, gamma: float, law: str, verdict: str) -> dict[str, Any]:
        return {"name": name, "gamma": gamma, "law": law, "verdict": verdict}

    first = [told("planning", 1.0, "nmpc", "a"), told("planning", 50.0, "nmpc", "b"), told("simple", 5.0, "stop", "c")]
    results: dict[str, Any] = {name: {"targets": []} for name in blocks.BEST}
    results["real"] = {"targets": first}
    results["real_nmpc"] = {"targets": [told("planning", 50.0, "nmpc", "later"), told("simple", 5.0, "", "open")]}
    monkeypatch.setattr(blocks, "result", results.__getitem__)
    assert [one["verdict"] for one in blocks._targets()] == ["a", "later", "c"]


# --- the whole table ------------------------------------------------------------------------------------------------


def test_case_is_the_realistic_device_with_a_coupling_that_lags(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what a law is run on is no object that a law holds."""
    met: list[Case] = []

    def ran(case: Case, entrants: Any, ask: Request) -> Outcome:
        met.append(case)
        assert [one.tuning for one in entrants] == ["all", "real"]
        return outcome(runs("best_constant"), runs("nmpc", mean_power=12.0, power_cv=0.1))

    monkeypatch.setattr("gyroctl.studies.evaluation.seas.run_case", ran)
    monkeypatch.setattr(real, "find_real_yardstick", lambda *_: Yardstick(0.06, 4e-4, True, "planted"))
    ask = request(tmp_path, "nmpc", ("100000:100007",), 230.0, 1, allow_tuning_seeds=True, quiet=True)
    content, _, _ = real.real_table(ask)
    assert [case.name for case in met] == ["gamma 1", "gamma 5", "gamma 50"]
    for case, gamma in zip(met, (1.0, 5.0, 50.0), strict=True):
        assert case.truth.coefficients == gy.zhang2017("realistic").coefficients and case.sea == gy.SeaState(
            gamma=gamma
        )
        assert case.settings.actuators.cc_lag == 0.02 and case.settings.sensors == gy.Settings().sensors
    law = content["seas"]["gamma50"][0]
    assert (law["law"], law["ratio"].value, law["difference"].value) == ("nmpc", 6.0, 10.0)


def test_table_runs_its_seas_with_the_pair_of_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the small, on a device whose wetted surface is linear: panels would take minutes."""
    asked: list[tuple[float, float]] = []

    def known(sea: gy.SeaState, budget: float, *_: Any) -> Yardstick:
        asked.append((sea.gamma, budget))
        return Yardstick(0.06, 1e-4 * sea.gamma, True, "as it was planted")

    monkeypatch.setattr(real, "find_real_yardstick", known)
    ask = request(tmp_path, "load_angle", ("100000:100001",), 230.0, 1, allow_tuning_seeds=True, quiet=True)
    water = Water("small", {"drag": 0.5}, lag=0.02)
    content, text, figure = real.real_table(ask, (5.0, 3.0), water)
    assert asked == [(5.0, 4e5), (3.0, 4e5)]
    assert not content["failed"] and list(content["seas"]) == ["gamma5", "gamma3"]
    assert content["water"]["lag_s"] == 0.02 and content["pairs"]["gamma3"]["cg"] == pytest.approx(3e-4)
    for sea in content["seas"].values():
        lines = {line["law"]: line for line in sea}
        assert set(lines) == {"best_constant", "load_angle"}
        assert lines["best_constant"]["ratio"].value == 1.0
        law, constant = lines["load_angle"], lines["best_constant"]
        assert law["ratio"].value == pytest.approx(law["power"].value / constant["power"].value)
        assert law["phi1_less"].value == pytest.approx(law["phi1"].value - constant["phi1"].value)
        assert law["forward"].value == 1.0, "a contact that rolls and stays loaded"
    told = content["sets"]["gamma5"]["load_angle"]
    assert told["set"] in text and told["words"] in text
    verdicts = {(one["name"], one["gamma"]): one["verdict"] for one in content["targets"]}
    assert verdicts["planning law", 5.0] == "open" and verdicts["a simple law, smooth", 5.0] in ("met", "not met")
    assert "as it was planted" in text and "## Targets" in text and len(figure.axes) == 2
    shown = blocks_of(content, ask, monkeypatch)
    for line in content["seas"]["gamma5"]:
        assert f"{number(line['power'].value)} |" in shown["real"] and f"`{line['law']}`" in shown["laws-real"]
    assert "0.0600" in shown["real"] and told["words"] in shown["real"]
    assert "Targets: " in shown["laws-real"] and "planning law: open" in shown["real-targets"]
    again = replace(ask, budget=1e6, given=ask.given | {"budget"})
    monkeypatch.setattr("gyroctl.comparison.execution.perform", None)
    repeated, _, _ = real.real_table(again, (5.0,), water)
    assert asked[-1] == (5.0, 1e6)
    assert repeated["seas"]["gamma5"] == content["seas"]["gamma5"], "finished runs are not run again"


def test_single_seas_may_be_asked_for_of_tables_that_have_seas(tmp_path: Path) -> None:
    ask = request(tmp_path, "coupling", ["1:2"], only="gamma 50, gamma 5")
    assert asked_for(ask, (1.0, 5.0, 50.0)) == [5.0, 50.0]  # in the order of the table
    assert asked_for(replace(ask, only=()), (1.0, 5.0)) == [1.0, 5.0]
    with pytest.raises(gy.InputError, match="no case of this table"):
        asked_for(replace(ask, only=("gamma 7",)), (1.0, 5.0))
    with pytest.raises(gy.InputError, match="faults is always whole"):
        evaluate_tables(["real", "faults"], ask)
    assert not any(tmp_path.iterdir())
