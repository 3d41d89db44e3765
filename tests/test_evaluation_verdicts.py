"""The fair tables, judged by hand: seeds and laws as they are typed, bars, pairing."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation.cases import Runs, check_waves, common_seeds
from gyroctl.studies.evaluation.entrants import Entrant, kind, parse, with_sets
from gyroctl.studies.evaluation.offdesign import never_worse
from gyroctl.studies.evaluation.robustness import kept_power
from gyroctl.studies.evaluation.rows import Row, row
from gyroctl.studies.evaluation.seeds import seed_plan
from gyroctl.studies.evaluation.targets import BARS, Bar, answer, answers, one_set_laws


def made(law: str = "good", power: float = 6.0, cv: float = 0.3, **changes: Any) -> Row:
    """Make a row that keeps the limits."""

    def sure(value: float) -> Estimate:
        return Estimate(value, value, value)

    values: dict[str, Any] = {f.name: sure(1.0) if f.type == "Estimate" else 0.0 for f in dataclasses.fields(Row)}
    values |= {
        "law": law,
        "seeds": "1 to 200",
        "seed_states": {"spent": 200},
        "kind": "simple",
        "information": "sensors",
        "tuning": "all",
        "runs": 200,
        "locked": 200,
        "in_step": 190,
        "pair_in_step": 190,
        "power": sure(power),
        "cv": sure(cv),
        "phi1_p98": 0.3,
        "phi3_p98": 0.2,
    }
    return Row(**{**values, **changes})


def runs(seeds: list[int], power: list[float], label: str = "law", hashes: tuple[str, ...] = ()) -> Runs:
    names = (
        "power_cv",
        "power_cv_1s",
        "phi1_p98",
        "phi3_p98",
        "phi1_max",
        "phi3_max",
        "outside_share",
        "cycle_slips",
        "generated_w",
        "stored_w",
        "slip_loss_w",
        "wave_input_w",
        "saturations",
        "ledger_residual",
        "outside_model",
        "step_ms_median",
        "step_ms_p99",
        "fallbacks",
        "deadline_misses",
        "failed",
    )
    values = {name: np.zeros(len(seeds)) for name in names}
    values |= {"mean_power": np.array(power), "locked": np.ones(len(seeds))}
    values |= {"turns_kept": np.ones(len(seeds)), "waves_counted": np.full(len(seeds), 950.0)}
    return Runs(Entrant(label, label), "simple", "sensors", np.array(seeds), hashes or tuple(map(str, seeds)), values)


# --- seeds and laws as they are typed


def test_seeds_as_typed_include_both_ends() -> None:
    plan = seed_plan(["1:4", "slow=2,9"])
    assert plan.common == (1, 2, 3, 4)
    assert plan.of("slow[lead=1]", "slow") == (2, 9)
    assert plan.of("other") == plan.common
    assert plan.all == (1, 2, 3, 4, 9)
    assert len(seed_plan([]).common) == 64


def test_case_of_a_table_may_have_seeds_of_its_own() -> None:
    plan = seed_plan(["1:4", "@gamma 5=11:14", "slow=2,9", "slow@gamma 1=3"])
    assert plan.of("fast", case="gamma 1") == (1, 2, 3, 4) and plan.of("fast", case="gamma 5") == (11, 12, 13, 14)
    assert plan.of("slow[lead=1]", "slow", case="gamma 5") == (2, 9) and plan.of("slow", case="gamma 1") == (3,)
    assert plan.in_case("gamma 5") == (2, 9, 11, 12, 13, 14), "what no law meets there the reference does not either"
    assert plan.in_case("gamma 50") == (1, 2, 3, 4, 9)


@pytest.mark.parametrize("text", ["", "1:", "a", "1,1", "5:3", "-1", "1.5"])
def test_what_is_no_seed_is_refused(text: str) -> None:
    with pytest.raises(gy.InputError, match="seeds"):
        seed_plan([text])


@pytest.mark.parametrize("text", ["100000", "1,100255", "slow=100100", "7"])
def test_tuning_seeds_are_refused_unless_allowed(text: str) -> None:
    with pytest.raises(gy.InputError, match="tuning"):
        seed_plan([text], tuned_on=(7,))
    assert seed_plan([text], allow_tuning=True, tuned_on=(7,)).all


def test_laws_as_typed() -> None:
    plain, set_, varied = parse("load_angle, load_angle[tuning=gamma5],nmpc[information=oracle,lead=2]")
    assert (plain.name, plain.parameters, plain.tuning) == ("load_angle", {}, "all")
    assert (set_.name, set_.parameters, set_.tuning) == ("load_angle", {}, "gamma5")
    assert (varied.name, varied.parameters) == ("nmpc", {"information": "oracle", "lead": 2})
    for bad in ("", "a[b", "a[b]", "a]x[", "a[=1]"):
        with pytest.raises(gy.InputError, match="laws"):
            parse(bad)


def test_sets_of_a_sea_stand_beside_the_one_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gyroctl.studies.evaluation.entrants.tuned_sets", lambda name: {"all": {}, "gamma5": {}})
    given = [Entrant("a", "a"), Entrant("b", "b", tuning="gamma5"), Entrant("constant", "constant")]
    assert [e.label for e in with_sets(given, "gamma5")] == ["a", "a (gamma5)", "b", "constant"]
    assert [e.label for e in with_sets(given, "gamma1")] == ["a", "b", "constant"]


def test_kinds_of_law() -> None:
    assert kind(gy.law("best_constant")) == "constant"
    assert kind(gy.law("load_angle")) == "simple"
    assert kind(gy.law("supervisor", wraps="best_constant")) == "constant"
    from gyroctl.controllers.nmpc import Nmpc

    assert kind(Nmpc()) == "planning"


# --- bars


def test_bar_is_met_only_where_everything_is_kept() -> None:
    bar = Bar("smooth", 5.0, "simple", "sensors", power=4.5, cv=0.35)
    assert answer(bar, [made()]).met
    for spoilt, word in (
        ({"power": 4.4}, "power"),
        ({"cv": 0.36}, "CV"),
        ({"phi1_p98": 0.351}, "motion"),
        ({"phi3_p98": 0.351}, "motion"),
        ({"locked": 197}, "locked"),
        ({"cv": float("nan")}, "CV"),
        ({"phi1_p98": float("nan")}, "motion"),
        ({"phi3_p98": float("nan")}, "motion"),
    ):
        verdict = answer(bar, [made(**spoilt)])
        assert not verdict.met
        assert verdict.missed[0].startswith(word)
    assert answer(bar, [made(locked=198)]).met, "198 of 200 are 99 %"


def test_run_without_a_number_is_no_success() -> None:
    lost = Estimate(6.0, 5.0, 7.0, "1 of 200 values not finite")
    assert answer(BARS[0], [dataclasses.replace(made(), power=lost)]).missed == ("power: 1 of 200 values not finite",)


def test_strongest_law_that_meets_a_bar_answers_it() -> None:
    bar = Bar("any", 5.0, "simple", "sensors", power=4.5, cv=0.35)
    table = [made("weak", 4.6), made("strong", 5.0), made("rough", 9.0, cv=1.0), made("lost", 9.0, locked=100)]
    assert answer(bar, table).law == "strong"
    nearest = answer(bar, [made("far", 2.0), made("near", 4.4)])
    assert (nearest.law, nearest.met) == ("near", False)


def test_bars_tell_kinds_and_information_apart() -> None:
    oracle = made("seer", 20.0, 0.1, kind="planning", information="oracle")
    found = {(v.bar.name, v.met) for v in answers({5.0: [oracle]})}
    assert ("planning with preview", True) in found
    assert ("planning from sensors", False) in found
    assert ("simple, most power", False) in found
    assert not answer(BARS[0], []).met


def test_ratio_bar_goes_by_the_constant_pair_of_the_sea() -> None:
    bar = next(bar for bar in BARS if bar.gamma == 1.0 and bar.kind == "simple" and not bar.one_set)
    assert bar.ratio == 1.8
    assert answer(bar, [made(ratio=Estimate(1.8, 1.5, 2.0))]).met
    assert not answer(bar, [made(ratio=Estimate(1.79, 1.5, 2.0))]).met
    assert not answer(bar, [made(ratio=Estimate(float("nan"), 0.0, 0.0))]).met


def test_one_set_is_to_reach_85_percent_in_every_sea() -> None:
    one_set = [bar for bar in BARS if bar.one_set]
    assert {bar.gamma for bar in one_set} == {1.0, 5.0, 50.0}
    assert min(bar.power for bar in one_set if bar.gamma == 5.0) == pytest.approx(0.85 * 4.5)
    own = made("own", 20.0, tuning="gamma5", ratio=Estimate(9.0, 9.0, 9.0))
    assert not any(bar.concerns(own) for bar in one_set), "a set for one sea cannot serve three"
    good = made("good", 4.7, ratio=Estimate(1.6, 1.6, 1.6))
    bad = made("bad", 4.7, ratio=Estimate(1.5, 1.5, 1.5))
    served = one_set_laws({gamma: [good, bad, own] for gamma in (1.0, 5.0, 50.0)})
    assert served["good"] == []
    assert len(served["bad"]) == 2
    assert "own" not in served


def test_never_worse_is_said_only_where_it_holds() -> None:
    def against(low: float, value: float, high: float, **changes: Any) -> Row:
        return made(difference=Estimate(value, low, high), ratio=Estimate(1.0 + value, 0.0, 9.0), **changes)

    constant = against(0.0, 0.0, 0.0, law="best_constant", kind="constant", locked=190)
    easy = {
        "best_constant": constant,
        "a": against(0.1, 0.2, 0.3),
        "b": against(0.1, 0.2, 0.3),
        "c": against(0.1, 0.2, 0.3),
    }
    hard = {
        "best_constant": constant,
        "a": against(-0.1, 0.0, 0.3),
        "b": against(-0.2, -0.1, 0.1),
        "c": against(-0.4, -0.3, -0.1, locked=150),
    }
    found = never_worse({"height": [("easy", easy), ("hard", hard)]})
    assert {law: entry["answer"] for law, entry in found.items()} == {
        "a": "never worse",
        "b": "not distinguishable where worse",
        "c": "worse",
    }
    assert found["c"]["lost"] == ["height hard 50/200 (constant 10/200)"]
    assert found["c"]["least_ratio"] == pytest.approx(0.7)
    assert "best_constant" not in found


# --- pairing


def test_ratio_and_difference_use_the_common_realisations_only() -> None:
    law, constant = runs([3, 1, 2], [6.0, 2.0, 4.0]), runs([1, 2, 3, 4], [1.0, 1.0, 2.0, 100.0], "best_constant")
    assert common_seeds(law, constant) == (3, 1, 2)
    found = row(law, constant)
    assert found.pairs == 3
    assert found.ratio.value == pytest.approx(12.0 / 4.0)
    assert found.difference.value == pytest.approx((4.0 + 1.0 + 3.0) / 3.0)
    assert found.power.value == pytest.approx(4.0)


def test_other_waves_under_the_same_seed_are_refused() -> None:
    check_waves([runs([1, 2], [1.0, 1.0]), runs([2], [1.0], "b")])
    with pytest.raises(gy.InputError, match="other waves under seed 2"):
        check_waves([runs([1, 2], [1.0, 1.0]), runs([2], [1.0], "b", ("x",))])


def test_kept_power_pairs_each_law_with_itself() -> None:
    case: Any = None
    from gyroctl.studies.evaluation.cases import Outcome

    nominal = Outcome(case, {"a": runs([1, 2, 3], [1.0, 2.0, 9.0], "a")}, {})
    other = Outcome(case, {"a": runs([2, 1], [1.0, 1.0], "a"), "b": runs([1], [1.0], "b")}, {})
    kept = kept_power(other, nominal)
    assert set(kept) == {"a"}
    assert kept["a"].value == pytest.approx(2.0 / 3.0)
