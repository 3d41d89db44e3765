"""Statistics of a comparison against independent oracles: closed forms, tail probabilities, hand-worked examples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm, poisson, ttest_rel

from gyroctl.statistics import (
    FEWEST,
    NOT_DISTINGUISHABLE,
    bootstrap_mean,
    holm,
    lock_probability,
    lock_survival,
    mean_time_to_loss,
    paired_difference,
    paired_differences,
    paired_ratio,
)


@pytest.fixture
def rng():
    """Its own generator for each test: what a test draws does not depend on which tests ran before it."""
    return np.random.default_rng(3)


@pytest.mark.parametrize(("held", "runs"), [(0, 8), (8, 8), (30, 32), (1, 1), (5, 9)])
def test_lock_probability_is_wilsons_closed_form(held, runs):
    z, p = norm.isf(0.025), held / runs
    centre = (p + z**2 / (2 * runs)) / (1 + z**2 / runs)
    half = z / (1 + z**2 / runs) * np.sqrt(p * (1 - p) / runs + z**2 / (4 * runs**2))
    estimate = lock_probability(np.arange(runs) < held)
    assert estimate.value == pytest.approx(p)
    assert (estimate.low, estimate.high) == (
        pytest.approx(centre - half, abs=1e-12),
        pytest.approx(centre + half, abs=1e-12),
    )


def test_lock_probability_of_nothing_says_so():
    estimate = lock_probability([])
    assert np.isnan(estimate.value)
    assert estimate.note == "no runs"


@pytest.mark.parametrize("losses", [1, 2, 7])
def test_mttl_interval_has_the_tails_of_the_poisson_count(losses):
    times = np.full(10, np.nan)
    times[:losses] = np.linspace(100.0, 900.0, losses)
    exposure = times[:losses].sum() + (10 - losses) * 1000.0
    estimate = mean_time_to_loss(times, 1000.0)
    assert estimate.value == pytest.approx(exposure / losses)
    # If the mean were the lower bound, so few losses would have probability 2.5 %; at the upper bound, so many.
    assert poisson.cdf(losses, exposure / estimate.low) == pytest.approx(0.025, rel=1e-9)
    assert poisson.sf(losses - 1, exposure / estimate.high) == pytest.approx(0.025, rel=1e-9)


def test_mttl_without_a_loss_is_a_one_sided_bound():
    estimate = mean_time_to_loss(np.full(8, np.nan), 600.0)
    assert np.isnan(estimate.value)
    assert estimate.high == np.inf
    assert poisson.pmf(0, 8 * 600.0 / estimate.low) == pytest.approx(0.05)
    assert "one-sided" in estimate.note


def test_mttl_with_every_run_lost_uses_only_the_loss_times():
    assert mean_time_to_loss([100.0, 300.0], 600.0).value == pytest.approx(200.0)


def test_mttl_interval_covers_the_truth_as_often_as_it_says():
    rng, mean, hits = np.random.default_rng(11), 800.0, 0
    for _ in range(400):
        times = rng.exponential(mean, 16)
        estimate = mean_time_to_loss(np.where(times < 600.0, times, np.nan), 600.0)
        hits += estimate.low <= mean <= estimate.high
    assert 0.93 <= hits / 400 <= 0.995


def test_survival_of_a_hand_worked_example():
    # Six runs of 10 s: losses at 2, 5, 5; three censored at 10. S = 5/6 after 2, then 5/6 * 3/5 = 1/2 after 5.
    curve = lock_survival([2.0, 5.0, 5.0, np.nan, np.nan, np.nan], 10.0)
    for time, expected in ((0.0, 1.0), (2.0, 5 / 6), (5.0, 0.5), (10.0, 0.5)):
        assert curve.probability[np.flatnonzero(curve.time == time)[0]] == pytest.approx(expected)
    assert curve.censored == 3
    inside = np.isfinite(curve.low)
    assert inside.any()
    assert np.all(curve.low[inside] <= curve.probability[inside])
    assert np.all(curve.probability[inside] <= curve.high[inside])


@given(st.lists(st.one_of(st.none(), st.integers(1, 99)), min_size=1, max_size=20))
@settings(max_examples=60, deadline=None)
def test_survival_ends_at_the_share_of_locked_runs(losses):
    # With censoring only at the end of the run, Kaplan-Meier is the plain share of runs still in lock.
    times = np.array([np.nan if t is None else float(t) for t in losses])
    curve = lock_survival(times, 100.0)
    assert curve.time[0] == 0.0
    assert curve.time[-1] == 100.0
    assert np.all(np.diff(curve.probability) <= 1e-12)
    for time, probability in zip(curve.time, curve.probability, strict=True):
        assert probability == pytest.approx(np.mean(~(times <= time)), abs=1e-12)


@pytest.mark.parametrize("count", range(1, FEWEST))
def test_few_realisations_give_the_mean_and_a_reason_but_no_interval(count):
    values, reference = np.arange(1.0, count + 1.0), np.full(count, 2.0)
    difference, p_value = paired_difference(values, reference)
    for estimate in (bootstrap_mean(values), paired_ratio(values, reference), difference):
        assert np.isfinite(estimate.value)
        assert np.isnan(estimate.low)
        assert np.isnan(estimate.high)
        assert f"{count} realisation" in estimate.note
    assert np.isnan(p_value)


def test_bootstrap_agrees_with_the_normal_interval_of_a_large_sample(rng):
    values = rng.normal(5.0, 2.0, 400)
    estimate = bootstrap_mean(values)
    half = norm.isf(0.025) * values.std(ddof=1) / np.sqrt(values.size)
    assert estimate.value == pytest.approx(values.mean())
    assert estimate.low == pytest.approx(values.mean() - half, abs=0.1 * half)
    assert estimate.high == pytest.approx(values.mean() + half, abs=0.1 * half)


def test_bootstrap_repeats_every_digit_and_scales(rng):
    values = rng.gamma(2.0, 1.0, 12)
    first, again, scaled = bootstrap_mean(values), bootstrap_mean(values), bootstrap_mean(1000.0 * values)
    assert first == again
    assert (scaled.low, scaled.high) == (pytest.approx(1000.0 * first.low), pytest.approx(1000.0 * first.high))


def test_bootstrap_leaves_out_nan_and_says_how_many():
    estimate = bootstrap_mean([1.0, 2.0, np.nan, 3.0, 4.0])
    assert estimate.value == pytest.approx(2.5)
    assert "1 of 5" in estimate.note
    assert bootstrap_mean([np.nan, np.nan]).note == "no finite value"


def test_equal_values_have_an_interval_of_no_width():
    assert bootstrap_mean(np.full(6, 0.4))[:3] == (pytest.approx(0.4),) * 3


def test_pairing_removes_what_the_realisations_share(rng):
    sea = rng.normal(10.0, 3.0, 2000)  # so many that losses unseen, which pairing cannot remove, are few
    noise = rng.normal(0.0, 0.05, 2000)
    ratio = paired_ratio(1.5 * sea + noise, sea)
    alone = bootstrap_mean(1.5 * sea + noise)
    assert ratio.low < 1.5 < ratio.high
    assert ratio.high - ratio.low < 0.3 * (alone.high - alone.low) / sea.mean()


def test_ratio_of_a_proportional_law_is_exact_and_of_no_reference_power_undefined(rng):
    sea = rng.gamma(2.0, 1.0, 8)
    assert paired_ratio(3.0 * sea, sea)[:3] == (pytest.approx(3.0),) * 3
    assert np.isnan(paired_ratio(sea, np.zeros(8)).value)
    assert "not positive" in paired_ratio(sea, np.zeros(8)).note


def test_paired_difference_has_the_p_value_of_the_paired_t_test(rng):
    first, second = rng.normal(2.0, 1.0, 16), rng.normal(1.5, 1.0, 16)
    estimate, p_value = paired_difference(first, second)
    assert p_value == pytest.approx(ttest_rel(first, second).pvalue)
    assert estimate.low < estimate.value < estimate.high


def test_paired_values_of_unequal_length_are_refused():
    with pytest.raises(ValueError, match="equal shapes"):
        paired_difference([1.0, 2.0], [1.0])


def test_holm_of_the_textbook_example():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8), st.floats(0.001, 0.2))
def test_holm_rejects_what_the_step_down_procedure_rejects(p_values, level):
    rejected = set()
    for rank, i in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        if p_values[i] * (len(p_values) - rank) > level:
            break
        rejected.add(i)
    assert {i for i, p in enumerate(holm(p_values)) if p <= level} == rejected


def test_holm_does_not_count_missing_tests():
    adjusted = holm([0.02, float("nan"), 0.5])
    assert adjusted[0] == pytest.approx(0.04)
    assert np.isnan(adjusted[1])


def test_equal_laws_are_not_distinguishable_and_unequal_ones_are(rng):
    sea = rng.normal(2.0, 0.2, 16)
    values = np.array([sea + rng.normal(0.0, 0.1, 16), 2.0 * sea, sea + rng.normal(0.0, 0.1, 16)])
    words = {frozenset((d.first, d.second)): d for d in paired_differences(["a", "b", "c"], values)}
    assert len(words) == 3
    assert words[frozenset("ac")].words == NOT_DISTINGUISHABLE
    assert words[frozenset("ab")].words == words[frozenset("bc")].words == "more"
    assert words[frozenset("ab")].first == "b"


def test_identical_runs_are_not_distinguishable(rng):
    row = rng.gamma(2.0, 1.0, 8)
    (only,) = paired_differences(["a", "b"], np.array([row, row]))
    assert only.words == NOT_DISTINGUISHABLE
    assert only.p_holm == 1.0


def test_false_alarms_over_all_pairs_stay_below_the_level():
    rng, alarms = np.random.default_rng(5), 0
    for _ in range(60):
        found = paired_differences(list("abcd"), rng.normal(2.0, 0.3, (4, 12)))
        alarms += any(d.words != NOT_DISTINGUISHABLE for d in found)
    assert alarms <= 8  # 5 % of 60 is 3; more than 8 has a probability below 0.3 %
