"""Sums over strata, as a year over its sea states, that share their realisations.

A seed is one set of phases, the same in every sea state: neighbouring strata see much the same waves, and their means
are no independent numbers. So the sum is taken for each realisation by itself, and those are independent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.statistics.estimate import CONFIDENCE, FEWEST, Estimate, nothing
from gyroctl.statistics.lock import wilson
from gyroctl.statistics.means import AS_SEEN, bootstrap_mean, ratio_bounds


def per_realisation(values: ArrayLike, weights: ArrayLike) -> NDArray[np.float64]:
    """Weighted sum over the strata for each realisation, (n,): values (strata, n), weights (strata,).

    NaN where a stratum that weighs something has no finite number.

    Parameters
    ----------
    values : array_like, (strata, n)
        One value for each stratum and realisation, in any unit.
    weights : array_like, (strata,)
        Of the strata, not negative. [-] [-]

    Returns
    -------
    (n,) array
        In the unit of the values.

    Raises
    ------
    ValueError
        Where the shapes disagree.
    """
    table, weight = np.asarray(values, np.float64), np.asarray(weights, np.float64)
    if table.ndim != 2 or weight.shape != table.shape[:1]:
        raise ValueError(f"needs (strata, n) values and (strata,) weights, got {table.shape} and {weight.shape}")
    counted = weight != 0.0
    return np.asarray(weight[counted] @ table[counted], np.float64)


def stratified_sum(values: ArrayLike, weights: ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Weighted sum of the means of strata with its interval.

    Measured at 95 % for 16 realisations of 40 strata whose values are correlated by 0 to 0.9 and lost in none to 10 %
    of the runs: covers 94 % to 99 % (`tests/test_strata.py`).

    Parameters
    ----------
    values : array_like, (strata, n)
        One value a stratum and realisation; the realisations are the same in every stratum. In any unit.
    weights : array_like, (strata,)
        Of the strata; what one value is worth in the sum. [-]
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    Estimate
        Sum and interval from the scatter over the realisations; none below four of them. A realisation without a
        number in some stratum is left out of all, and the note says how many.
    """
    return bootstrap_mean(per_realisation(values, weights), confidence, zero_if_lost=False)


def stratified_share(hits: ArrayLike, weights: ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Weighted sum of the shares of runs in which something happened, as hours out of step, with its interval.

    The wider of two intervals: that of the sums for each realisation, and Wilson's of the strata put together as if
    they were independent, which knows that what did not happen in n runs may still happen.
    Source: G. Y. Zou, A. Donner, "Construction of confidence limits about effect measures: a general approach", Stat.
    Med. 27 (2008) 1693-1702.

    Parameters
    ----------
    hits : array_like of bool, (strata, n)
        Whether it happened in a run.
    weights : array_like, (strata,)
        Of the strata, not negative. [-]
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    Estimate
        Sum and interval, within 0 and the sum of the weights.

    Raises
    ------
    InputError
        Field ``confidence``.
    """
    table, weight = np.asarray(hits, bool), np.asarray(weights, np.float64)
    if table.size == 0:
        return nothing("no runs")
    whole = float(weight.sum())
    sums = per_realisation(table, weight)
    value = float(sums.mean())
    each = [wilson(int(row.sum()), row.size, confidence) for row in table]
    below = np.array([one.value - one.low for one in each]) * weight
    above = np.array([one.high - one.value for one in each]) * weight
    low, high = value - float(np.sqrt(below @ below)), value + float(np.sqrt(above @ above))
    note = ""
    if sums.size >= FEWEST and np.ptp(sums) > 0.0:
        shared = bootstrap_mean(sums, confidence, zero_if_lost=False)
        low, high = min(low, shared.low), max(high, shared.high)
    elif sums.size < FEWEST:
        note = f"from {sums.size} realisations"
    return Estimate(value, max(0.0, low), min(whole, high), note)


def stratified_ratio(
    values: ArrayLike, reference: ArrayLike, weights: ArrayLike, confidence: float = CONFIDENCE
) -> Estimate:
    """Ratio of two weighted sums on the same realisations with its interval, Fieller's or that without skewness.

    Parameters
    ----------
    values, reference : array_like, (strata, n)
        One value a stratum and realisation. In any unit, the same for both.
    weights : array_like, (strata,)
        Of the strata. [-]
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    Estimate
        Ratio and interval of runs like those seen [1]; none below four realisations, and none where the sum of the
        reference cannot be told from zero.
    """
    first, second = per_realisation(values, weights), per_realisation(reference, weights)
    both = np.isfinite(first) & np.isfinite(second)
    first, second = first[both], second[both]
    if not first.size or not second.mean() > 0.0:
        return nothing("the reference gives nothing")
    ratio = float(first.mean() / second.mean())
    if first.size < FEWEST:
        return Estimate(ratio, np.nan, np.nan, f"no interval from {first.size} realisations (at least {FEWEST})")
    if np.ptp(first - ratio * second) <= 1e-12 * abs(float(first.mean())):
        return Estimate(ratio, ratio, ratio, "proportional to the reference")
    low, high = ratio_bounds(first, second, confidence, losing=False)
    if not (np.isfinite(low) and np.isfinite(high)):
        return Estimate(ratio, np.nan, np.nan, "no interval: the reference cannot be told from zero")
    return Estimate(ratio, float(low), float(high), AS_SEEN)
