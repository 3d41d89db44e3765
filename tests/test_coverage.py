"""Intervals hold the truth as often as they say: `benchmarks/interval_coverage.py` again, its table against the bar."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binomtest

from gyroctl.statistics import (
    bootstrap_mean,
    intervals,
    lock_probability,
    lock_survival,
    mean_time_to_loss,
    paired_difference,
    paired_ratio,
    wilson,
)

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def coverage() -> Any:
    spec = importlib.util.spec_from_file_location("coverage_of_intervals", ROOT / "benchmarks" / "interval_coverage.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def few_resamples(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A tenth of the resamples: a quantile of them is off by half a percent at most, far below the noise here."""
    monkeypatch.setattr(intervals, "RESAMPLES", 999)
    intervals._kept_weights.cache_clear()
    yield
    intervals._kept_weights.cache_clear()


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    content: dict[str, Any] = json.loads((ROOT / "benchmarks" / "interval_coverage.json").read_text())
    return content


def test_every_interval_is_within_two_points_or_safe_or_says_so(coverage: Any, stored: dict[str, Any]) -> None:
    table = stored["coverage"]
    assert coverage.undercovered(table, coverage.SLACK + noise(stored["samples"])) == []
    assert {count for by_count in table.values() for count in by_count} == {"8", "16", "32", "64", "200"}
    assert set(table) > set(coverage.FAMILIES)


def noise(samples: int) -> float:
    """Three standard errors of a coverage of 95 %."""
    return float(3.0 * np.sqrt(0.95 * 0.05 / samples))


def compare(coverage: Any, stored: dict[str, Any], samples: int, counts: tuple[int, ...]) -> None:
    again = coverage.measure(samples, 2, counts)
    print(f"\n{samples} samples\n{coverage.written(again)}")
    assert coverage.undercovered(again, coverage.SLACK + noise(samples)) == []
    for name, by_count in again.items():
        for count, found in by_count.items():
            for function, cell in found.items():
                there = stored["coverage"][name][count][function]["held"]
                spread = np.sqrt(max(there * (1.0 - there), 0.005) * (1.0 / samples + 1.0 / stored["samples"]))
                assert abs(cell["held"] - there) < 4.5 * spread, (name, count, function)


@pytest.mark.slow
@pytest.mark.usefixtures("few_resamples")
def test_a_smaller_rerun_gives_the_stored_table(coverage: Any, stored: dict[str, Any]) -> None:
    compare(coverage, stored, 200, (8, 32))


@pytest.mark.slow
@pytest.mark.usefixtures("few_resamples")
def test_a_rerun_of_all_counts_gives_the_stored_table(coverage: Any, stored: dict[str, Any]) -> None:
    compare(coverage, stored, 400, (8, 16, 64, 200))


@pytest.mark.parametrize("count", [8, 64])
def test_what_is_measured_is_what_the_public_functions_give(coverage: Any, count: int) -> None:
    for public, measured in coverage.public_functions(count, np.random.default_rng(4)):
        assert public == pytest.approx(measured, rel=1e-9)


@pytest.mark.usefixtures("few_resamples")
def test_bar_sees_an_interval_without_the_lost_run(coverage: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coverage.means, "_may_be_lost", lambda *samples: False)
    monkeypatch.setattr(
        coverage.means, "mean_bounds", lambda values, confidence, losing: intervals.student(values, confidence)
    )
    found = coverage.of_means("law loses 5 %", 8, 400, np.random.default_rng(1))
    assert found["mean"]["told"] < 0.85


@pytest.mark.parametrize("runs", [8, 64])
def test_lower_bound_without_a_loss_is_the_exact_binomial_one(runs: int) -> None:
    values = np.full(runs, 2.0)
    values[0] += 1e-9  # not quite equal: equal values have no interval
    low = bootstrap_mean(values).low
    assert low == pytest.approx(2.0 * 0.025 ** (1.0 / runs), rel=0.02)
    ratio = paired_ratio(1.5 * values + np.arange(runs) * 1e-9, values)
    assert (ratio.low, ratio.high) == (
        pytest.approx(1.5 * 0.025 ** (1.0 / runs), rel=0.02),
        pytest.approx(1.5 / 0.025 ** (1.0 / runs), rel=0.02),
    )


@pytest.mark.parametrize(("runs", "lead"), [(8, 0.5), (64, 0.1), (64, 0.3)])
def test_p_value_is_the_chance_that_rare_losses_made_the_lead(runs: int, lead: float) -> None:
    first, second = np.full(runs, 1.0), np.full(runs, 1.0 - lead)
    assert paired_difference(first, second)[1] == pytest.approx(2.0 * (1.0 - lead) ** runs, rel=0.06)
    assert paired_difference(second, first)[1] == pytest.approx(2.0 * (1.0 - lead) ** runs, rel=0.06)


def test_p_value_is_that_of_the_weights_it_stands_for(rng: np.random.Generator) -> None:
    first, second = rng.normal(1.3, 0.3, 8), rng.normal(1.0, 0.3, 8)
    values = np.append(first - second, -second.mean())
    chance = 2.0 * float((rng.standard_exponential((400000, 9)) @ values <= 0.0).mean())
    assert float(intervals.chance_of_no_lead(first, second)) == pytest.approx(chance, rel=0.08)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(6)


def test_more_weights_than_fit_in_memory_give_the_same(monkeypatch: pytest.MonkeyPatch, rng: Any) -> None:
    values = rng.gamma(2.0, 1.0, 40)
    whole = bootstrap_mean(values)
    monkeypatch.setattr(intervals, "BLOCK", 41 * 1000)
    assert bootstrap_mean(values)[:3] == pytest.approx(whole[:3], rel=1e-12)


def test_interval_does_not_depend_on_the_unit(rng: Any) -> None:
    first, second = rng.gamma(2.0, 1.0, 12), rng.gamma(2.0, 1.0, 12)
    assert paired_ratio(1e-3 * first, 1e-3 * second)[:3] == pytest.approx(paired_ratio(first, second)[:3], rel=1e-9)
    difference, p_value = paired_difference(first, second)
    scaled, again = paired_difference(1e3 * first, 1e3 * second)
    assert scaled[:3] == pytest.approx(1e3 * np.array(difference[:3]), rel=1e-9)
    assert again == pytest.approx(p_value, rel=1e-9)


def test_reference_that_cannot_be_told_from_zero_gives_no_interval() -> None:
    ratio = paired_ratio([2.0, 2.1, 1.9, 2.0], [0.01, 0.01, 0.01, 2.0])
    assert np.isnan(ratio.low) and np.isnan(ratio.high)
    assert "cannot be told from zero" in ratio.note


def test_values_of_both_signs_say_that_the_interval_is_one_of_runs_like_those_seen(rng: Any) -> None:
    assert "like those seen" in bootstrap_mean(rng.normal(0.0, 1.0, 16)).note
    assert "like those seen" in bootstrap_mean(rng.normal(5.0, 0.1, 16), zero_if_lost=False).note
    assert bootstrap_mean(rng.normal(5.0, 0.1, 16)).note == ""


def test_run_that_did_not_finish_is_not_held_and_is_named() -> None:
    locked = lock_probability([1.0, 1.0, np.nan, 1.0])
    assert locked.value == 0.75
    assert "1 of 4 runs not finished" in locked.note
    finished = [True, True, False, True]
    lasting = mean_time_to_loss([100.0, np.nan, np.nan, np.nan], 600.0, finished=finished)
    assert lasting.value == pytest.approx(1300.0)
    assert "1 of 4 runs not finished" in lasting.note
    assert lock_survival([100.0, np.nan, np.nan, np.nan], 600.0, finished=finished).probability[-1] == pytest.approx(
        2 / 3
    )


def test_few_lost_runs_name_the_exact_bound() -> None:
    assert "exact upper bound 0.997" in lock_probability(np.arange(8) < 7).note
    assert "exact lower bound 0.00316" in lock_probability(np.arange(8) < 1).note
    assert lock_probability(np.arange(8) < 8).note == lock_probability(np.arange(8) < 4).note == ""


def test_losses_at_no_constant_rate_are_named(rng: Any) -> None:
    def note(times: Any) -> str:
        return mean_time_to_loss(np.where(times < 600.0, times, np.nan), 600.0).note

    assert "early" in note(300.0 * rng.weibull(0.4, 64))
    assert "late" in note(500.0 * rng.weibull(4.0, 64))
    named = sum(bool(note(rng.exponential(800.0, 32))) for _ in range(300))
    assert named <= 10  # 1 % of 300 is 3


def test_curve_of_lock_has_an_interval_at_every_time() -> None:
    curve = lock_survival([2.0, 5.0, 5.0, np.nan, np.nan, np.nan], 10.0)
    for held, at in ((6, 0), (5, 1), (3, 2), (3, -1)):
        share, exact = wilson(held, 6), binomtest(held, 6).proportion_ci(method="exact")
        high = exact.high if held == 5 else share.high
        assert (curve.probability[at], curve.low[at], curve.high[at]) == pytest.approx((held / 6, share.low, high))
