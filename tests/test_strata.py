"""Sums over strata that share their realisations: the right number, and intervals that hold the truth."""

from __future__ import annotations

import numpy as np
import pytest

from gyroctl.statistics import per_realisation, stratified_ratio, stratified_share, stratified_sum

CELLS, RUNS = 40, 16


def test_the_sum_is_that_of_weights_and_means():
    values = np.array([[1.0, 2.0, 3.0, 2.0], [10.0, 10.0, 14.0, 10.0]])
    found = stratified_sum(values, [3.0, 0.5])
    assert found.value == pytest.approx(3.0 * 2.0 + 0.5 * 11.0)
    assert found.low < found.value < found.high
    np.testing.assert_allclose(per_realisation(values, [3.0, 0.5]), [8.0, 11.0, 16.0, 11.0])


def test_what_weighs_nothing_may_have_no_number_and_what_weighs_leaves_its_realisation_out():
    values = np.array([[1.0, 2.0, 3.0, 2.0, 2.0], [np.nan] * 5])
    assert stratified_sum(values, [2.0, 0.0]).value == pytest.approx(4.0)
    values[1] = [5.0, np.nan, 5.0, 5.0, 5.0]
    found = stratified_sum(values, [2.0, 1.0])
    assert found.value == pytest.approx(2.0 * 2.0 + 5.0) and "1 of 5" in found.note


def synthetic(rng: np.random.Generator, correlation: float, lost: float) -> tuple[np.ndarray, np.ndarray]:
    """Powers of sea states whose scatter is partly common to all, and their true means."""
    mean = np.linspace(0.5, 4.0, CELLS)
    common, own = rng.normal(size=RUNS), rng.normal(size=(CELLS, RUNS))
    scatter = np.sqrt(correlation) * common + np.sqrt(1.0 - correlation) * own
    kept = rng.random((CELLS, RUNS)) >= lost
    return mean[:, None] * (1.0 + 0.2 * scatter) * kept, mean * (1.0 - lost)


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("lost", [0.0, 0.1])
def test_the_interval_of_a_year_covers_the_truth_in_95_of_100_sites(correlation, lost):
    rng, hits, trials = np.random.default_rng(7), 0, 500
    weights = rng.dirichlet(np.ones(CELLS)) * 8766.0
    for _ in range(trials):
        values, mean = synthetic(rng, correlation, lost)
        found = stratified_sum(values, weights)
        hits += found.low <= weights @ mean <= found.high
    assert 0.93 <= hits / trials <= 0.995


def test_hours_are_shares_times_hours_and_their_interval_covers():
    hits = np.array([[True, False, False, False], [True, True, True, True]])
    found = stratified_share(hits, [100.0, 10.0])
    assert found.value == pytest.approx(35.0)
    assert 0.0 <= found.low < 35.0 < found.high <= 110.0
    rng, inside, trials = np.random.default_rng(3), 0, 200
    share, weights = rng.uniform(0.0, 0.5, CELLS), rng.dirichlet(np.ones(CELLS)) * 8766.0
    for _ in range(trials):
        found = stratified_share(rng.random((CELLS, RUNS)) < share[:, None], weights)
        inside += found.low <= weights @ share <= found.high
    assert inside / trials >= 0.95


def test_what_was_never_seen_may_still_happen():
    found = stratified_share(np.zeros((3, 8), bool), [100.0, 100.0, 100.0])
    assert found.value == 0.0 and found.low == 0.0
    alone = 1.96**2 / (8 + 1.96**2) * 100.0  # Wilson's upper bound of none in eight
    assert found.high == pytest.approx(np.sqrt(3.0) * alone, rel=1e-3)


def test_the_ratio_is_paired():
    rng = np.random.default_rng(5)
    reference = rng.uniform(1.0, 3.0, (CELLS, RUNS))
    weights = rng.dirichlet(np.ones(CELLS))
    exact = stratified_ratio(2.0 * reference, reference, weights)
    assert exact[:3] == pytest.approx((2.0, 2.0, 2.0))
    noisy = stratified_ratio(2.0 * reference + rng.normal(0.0, 0.05, reference.shape), reference, weights)
    assert noisy.low < 2.0 < noisy.high and noisy.high - noisy.low < 0.05
    assert np.isnan(stratified_ratio(reference, 0.0 * reference, weights).value)
