"""Verdict, evaluation, summary of comparisons made by hand: who may win, what is counted, which column is which."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_reports_synthetic import synthetic

from gyroctl.reports.evaluation import evaluate
from gyroctl.reports.summary import summarise
from gyroctl.reports.verdict import judge

THREE = ("best_constant", "load_angle", "coupling")
LIMIT = 0.35
RUNS = 32
"""Enough of them that no lead here is what rare losses might have made."""


def comparison(laws: tuple[str, ...] = THREE, **changes: dict[str, Any]) -> Any:
    """Calm comparison, in which every law qualifies; `changes` are values of a variable by law."""
    ds = synthetic(laws, RUNS, lock=1.0, examples=False).copy(deep=True)
    for name, value in (("phi1_p98", 0.2), ("phi3_p98", 0.2), ("cycle_slips", 0.0), ("ledger_residual", 0.0)):
        ds[name][:] = value
    for name, by_law in changes.items():
        for law, value in by_law.items():
            ds[name].loc[{"law": law}] = value
    return ds


def test_most_power_wins_where_all_qualify() -> None:
    evaluation = evaluate(comparison())
    assert judge(evaluation).winner == "load_angle"
    assert [law.name for law in evaluation.by_power] == ["load_angle", "coupling", "best_constant"]


@pytest.mark.parametrize("joint", ["phi1_p98", "phi3_p98"])
def test_either_joint_beyond_the_limit_costs_the_win(joint: str) -> None:
    verdict = judge(evaluate(comparison(**{joint: {"load_angle": 1.05 * LIMIT}})))
    assert verdict.winner == "coupling"
    assert any(joint[:4] in sentence and "load_angle" in sentence for sentence in verdict.sentences)
    assert any(f"load_angle {RUNS} of {RUNS}" in caveat for caveat in verdict.caveats)


@pytest.mark.parametrize(
    ("phi1", "phi3", "expected"), [(0.34, 0.34, 0), (0.36, 0.34, RUNS), (0.34, 0.36, RUNS), (0.36, 0.36, RUNS)]
)
def test_runs_over_the_limit_are_counted_by_either_joint(phi1: float, phi3: float, expected: int) -> None:
    evaluation = evaluate(comparison(phi1_p98={"coupling": phi1}, phi3_p98={"coupling": phi3}))
    assert evaluation.law("coupling").over_limit == expected
    assert evaluation.law("load_angle").over_limit == 0


def test_law_that_loses_more_runs_than_the_reference_does_not_win() -> None:
    held = np.array([True] * (RUNS - 1) + [False])
    verdict = judge(evaluate(comparison(locked={"load_angle": held})))
    assert verdict.winner == "coupling"
    assert judge(evaluate(comparison(locked=dict.fromkeys(THREE, held)))).winner == "load_angle"


def test_locked_runs_are_counted_and_their_power_kept_apart() -> None:
    held = np.tile([True, True, False, True, False, True, True, False], RUNS // 8)
    power = np.tile([4.0, 5.0, 1.0, 6.0, 1.0, 4.0, 5.0, 1.0], RUNS // 8)
    found = evaluate(comparison(locked={"coupling": held}, mean_power={"coupling": power})).law("coupling")
    assert (found.locked, found.runs) == (RUNS * 5 // 8, RUNS)
    assert found.lock.value == pytest.approx(5 / 8)
    assert found.power.value == pytest.approx(power.mean())
    assert found.power_locked == pytest.approx(power[held].mean())


def test_ratio_is_the_law_over_the_reference() -> None:
    ds = comparison(mean_power={"best_constant": 2.0, "coupling": np.linspace(3.0, 5.0, RUNS)})
    found = evaluate(ds).law("coupling").ratio
    assert found.value == pytest.approx(2.0)
    assert 1.5 < found.low < 2.0 < found.high < 2.5


def test_without_a_reference_only_causal_laws_set_the_measure_of_lock() -> None:
    """An oracle that never loses lock does not disqualify everyone else."""
    laws = ("load_angle", "coupling", "preview")
    held = np.array([True] * (RUNS - 1) + [False])
    verdict = judge(evaluate(comparison(laws, locked={"load_angle": held, "coupling": held})))
    assert verdict.winner == "load_angle"


def test_worst_motion_is_that_of_its_joint() -> None:
    phi1, phi3 = np.linspace(0.1, 0.31, RUNS), np.linspace(0.1, 0.17, RUNS)
    found = evaluate(comparison(phi1_p98={"coupling": phi1}, phi3_p98={"coupling": phi3})).law("coupling")
    assert (found.phi1_worst, found.phi3_worst) == (phi1.max(), phi3.max())
    assert (found.phi1_p98, found.phi3_p98) == (pytest.approx(phi1.mean()), pytest.approx(phi3.mean()))


def test_caveats_tell_of_an_open_ledger_of_sliding_and_of_seeds_of_tuning() -> None:
    ds = comparison(ledger_residual={"coupling": 2e-3}, cycle_slips={"best_constant": 1.0, "load_angle": 40.0})
    caveats = " ".join(judge(evaluate(ds.assign_attrs(tuning_seeds="[3, 99]"))).caveats)
    assert "ledger does not close" in caveats and "coupling 0.002" in caveats
    assert "cycle slips" in caveats and "load_angle 40" in caveats
    assert "Seeds 3 were used for tuning" in caveats
    assert judge(evaluate(comparison())).caveats == () or "tuning" not in " ".join(
        judge(evaluate(comparison())).caveats
    )


def test_every_number_of_the_summary_is_that_of_its_name() -> None:
    """Each variable has a level of its own, so that no two can be exchanged."""
    means = {
        "p98_over_mean": 3.1,
        "cycle_slips": 3.2,
        "phi1_p98": 0.11,
        "phi3_p98": 0.13,
        "wave_input_w": 17.0,
        "radiated_w": 9.0,
        "hinge_w": 1.7,
        "slip_loss_w": 1.3,
        "stored_w": 0.19,
        "capture_width_ratio": 0.23,
    }
    ds = comparison(**{name: {"coupling": value} for name, value in means.items()})
    found = summarise(ds)["laws"]["coupling"]
    for name, value in means.items():
        assert found[name] == pytest.approx(value), name
    evaluation = evaluate(ds).law("coupling")
    for key, estimate in (
        ("mean_power_ci95", evaluation.power),
        ("power_cv_ci95", evaluation.power_cv),
        ("ratio_ci95", evaluation.ratio),
        ("lock_probability_ci95", evaluation.lock),
    ):
        assert found[key] == [estimate.low, estimate.high], key
    assert found["mean_power_w"] == evaluation.power.value
    assert found["ratio_to_best_constant"] == evaluation.ratio.value
