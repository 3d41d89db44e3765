"""Intervals against their own definitions: skewness, pairing, what is no number, direction, level."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from gyroctl.statistics import (
    NOT_DISTINGUISHABLE,
    Estimate,
    bootstrap_mean,
    finite_largest,
    finite_mean,
    holm,
    in_words,
    intervals,
    lock_probability,
    lock_survival,
    mean_time_to_loss,
    paired_difference,
    paired_differences,
    paired_ratio,
)


@pytest.fixture(scope="module")
def skewed() -> np.ndarray:
    return np.exp(1.2 * np.random.default_rng(5).standard_normal(40))


def test_interval_of_a_skewed_mean_leans_to_the_long_tail(skewed: np.ndarray) -> None:
    """Percentiles of the resampled means end too early on the side of the long tail."""
    rng = np.random.default_rng(1)
    means = rng.choice(skewed, (20_000, skewed.size)).mean(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    error = 0.15 * means.std()
    found = bootstrap_mean(skewed)
    assert found.value == pytest.approx(skewed.mean())
    assert found.high > high + 2.0 * error
    mirrored = bootstrap_mean(-skewed)
    assert mirrored.high > -low and mirrored.low < -high - 2.0 * error
    ratio = paired_ratio(skewed, np.ones(skewed.size))
    assert ratio.high > high + 2.0 * error


def test_intervals_are_at_95_percent() -> None:
    values = np.random.default_rng(2).standard_normal(400)
    half = norm.isf(0.025) * values.std(ddof=1) / np.sqrt(values.size)
    found = bootstrap_mean(values)
    assert found.high - found.low == pytest.approx(2.0 * half, rel=0.05)
    assert lock_probability([True] * 30 + [False] * 2).low == pytest.approx(0.7985, abs=1e-3), "Wilson, by hand"


def test_ratio_draws_realisations_and_not_each_law_alone() -> None:
    rng = np.random.default_rng(3)
    sea = rng.uniform(1.0, 5.0, 40)
    own = 2.0 * sea * (1.0 + 0.01 * rng.standard_normal(40))
    found = paired_ratio(own, sea)
    assert found.value == pytest.approx(own.mean() / sea.mean())
    # one run more that is lost is 9 % of forty; laws that are drawn apart would scatter by 17 % either way
    assert 1.8 < found.low < found.value < found.high < 2.21


def test_ratio_is_that_of_the_means() -> None:
    """One poor realisation of the reference does not make the ratio: the mean of the ratios is another number."""
    own, other = np.array([4.0, 5.0, 6.0, 5.0, 4.0, 6.0]), np.array([2.0, 2.5, 3.0, 2.5, 2.0, 0.01])
    found = paired_ratio(own, other)
    assert found.value == pytest.approx(30.0 / 12.01)
    assert found.low <= found.value <= found.high < 10.0


@pytest.mark.parametrize("spoilt", [0, 1])
def test_pair_with_a_run_that_is_no_number_is_told_of_and_never_zero(spoilt: int) -> None:
    rng = np.random.default_rng(4)
    pair = [rng.uniform(5.0, 6.0, 12), rng.uniform(2.0, 3.0, 12)]
    pair[spoilt][3] = np.nan
    kept = [np.delete(values, 3) for values in pair]
    difference, p = paired_difference(*pair)
    ratio = paired_ratio(*pair)
    assert difference.value == pytest.approx(np.mean(kept[0] - kept[1]))
    assert ratio.value == pytest.approx(kept[0].mean() / kept[1].mean())
    assert "1 of 12" in difference.note and "1 of 12" in ratio.note
    assert np.isfinite(p)


def test_what_is_no_number_is_left_out_of_means_and_told() -> None:
    values = np.array([1.0, np.nan, 3.0, 5.0, np.inf, 7.0])
    found = bootstrap_mean(values)
    assert found.value == 4.0 and "2 of 6" in found.note
    assert finite_mean(values) == 4.0 and finite_largest(values) == 7.0
    assert np.isnan(finite_mean([np.nan])) and np.isnan(finite_largest([np.nan]))


def test_difference_has_the_sign_of_first_less_second() -> None:
    first, less = np.tile([5.0, 6.0, 7.0, 8.5], 8), np.tile([1.0, 2.0, 1.5, 2.5], 8)
    found, _ = paired_difference(first, first - less)
    assert found.value == pytest.approx(1.75) and found.low > 0.0
    (pair,) = paired_differences(["poor", "rich"], np.array([first - less, first]))
    assert (pair.first, pair.second, pair.words) == ("rich", "poor", "more")


def test_words_need_the_corrected_test_and_the_interval() -> None:
    sure, open_ = Estimate(1.0, 0.5, 1.5), Estimate(1.0, -0.1, 2.1)
    words = ("more", "less")
    assert in_words(sure, 0.01, words, 0.05) == "more"
    assert in_words(Estimate(-1.0, -1.5, -0.5), 0.01, words, 0.05) == "less"
    assert in_words(sure, 0.2, words, 0.05) == NOT_DISTINGUISHABLE
    assert in_words(open_, 0.01, words, 0.05) == NOT_DISTINGUISHABLE


def test_holm_goes_down_in_steps_and_never_back() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.02, 0.021, 0.9]) == pytest.approx([0.06, 0.06, 0.9])


def test_time_to_loss_counts_the_time_of_every_run() -> None:
    """Two losses at 100 and 300 s, two runs held for 500 s: 1400 s for two losses."""
    found = mean_time_to_loss([100.0, np.nan, 300.0, np.nan], 500.0)
    assert found.value == pytest.approx(700.0)
    none = mean_time_to_loss([np.nan] * 4, 500.0)
    assert none.low == pytest.approx(2000.0 / -np.log(0.05)) and none.high == np.inf


def test_survival_counts_the_runs_that_held() -> None:
    found = lock_survival([100.0, np.nan, 300.0, np.nan], 500.0)
    assert found.censored == 2
    assert found.probability[[0, 1, 2, -1]] == pytest.approx([1.0, 0.75, 0.5, 0.5])


def test_resampling_repeats_every_digit(skewed: np.ndarray) -> None:
    first = bootstrap_mean(skewed)
    intervals._kept_weights.cache_clear()
    assert bootstrap_mean(skewed.copy()) == first


@pytest.mark.parametrize("count", [1, 2, 3])
def test_three_values_have_no_interval(count: int) -> None:
    found = bootstrap_mean(np.arange(1.0, 1.0 + count))
    assert np.isnan(found.low) and np.isnan(found.high) and "no interval" in found.note


def test_ratio_allows_for_one_run_more_that_is_lost_by_either() -> None:
    """In sixteen runs that all held, a share of 17 % may be lost (by the binomial law at 95 %): of either law."""
    rng = np.random.default_rng(6)
    own, other = rng.uniform(5.9, 6.1, 16), rng.uniform(1.98, 2.02, 16)
    found = paired_ratio(own, other)
    assert found.low < 0.85 * found.value and found.high > 1.15 * found.value
