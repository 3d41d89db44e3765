"""Statistics of a comparison: lock probability, time to lose lock, paired differences on identical realisations.

Every function returns numbers with an interval and, where an interval cannot be given, the reason in words instead of
an error: one to three realisations, every run lost and no run lost are ordinary results. Everything is deterministic:
resampling always starts from the same seed, so that a report rebuilt from its file repeats every digit.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError

CONFIDENCE = 0.95
RESAMPLES = 9999
SEED = 20170731
FEWEST = 4
"""Fewest realisations from which an interval of a mean is resampled: below it hardly any resamples differ."""

NOT_DISTINGUISHABLE = "not distinguishable"


class Estimate(NamedTuple):
    """A number with its confidence interval; `note` says why a bound is missing."""

    value: float
    low: float
    high: float
    note: str = ""


class Share(NamedTuple):
    """A share of runs with its Wilson interval."""

    value: float
    low: float
    high: float
    runs: int


class Survival(NamedTuple):
    """Kaplan-Meier estimate of the probability that lock still holds: a step function of time [s] with its interval."""

    time: NDArray[np.float64]
    probability: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    censored: int


class PairedDifference(NamedTuple):
    """Mean of `first` minus `second` on the same realisations, with p-values before and after Holm's correction."""

    first: str
    second: str
    estimate: Estimate
    p_value: float
    p_holm: float
    words: str


def wilson(successes: int, runs: int, confidence: float = CONFIDENCE) -> Share:
    """Share of successes with Wilson's score interval.

    Parameters
    ----------
    successes, runs : int
        Counts.
    confidence : float
        Two-sided confidence level. [1]

    Raises
    ------
    InputError
        For no runs.
    """
    from scipy.stats import binomtest

    if runs < 1:
        raise InputError("samples", runs, "must be at least 1", "Give the number of disturbed runs, for example 128")
    bounds = binomtest(successes, runs).proportion_ci(confidence, method="wilson")
    return Share(successes / runs, float(bounds.low), float(bounds.high), runs)


def lock_probability(locked: ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Probability to hold lock to the end of the run, with Wilson's score interval.

    Parameters
    ----------
    locked : array_like of bool, shape (n,)
        Whether each run held lock.
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    Estimate
        Share of locked runs and its interval [1]; NaN when there are no runs.
    """
    held = np.asarray(locked, dtype=bool)
    if held.size == 0:
        return Estimate(np.nan, np.nan, np.nan, "no runs")
    return Estimate(*wilson(int(held.sum()), held.size, confidence)[:3])


def mean_time_to_loss(loss_time: ArrayLike, duration: float, confidence: float = CONFIDENCE) -> Estimate:
    """Mean time to lose lock (MTLL) from loss times censored at the end of the run.

    Maximum likelihood for exponential times: total time in lock over the number of losses. The chi-square interval
    takes 2(k + 1) degrees of freedom for the lower bound and 2k for the upper, as is exact for k losses in a given
    total time in lock. Without a loss there is no estimate, only a one-sided lower bound of the same confidence.

    Parameters
    ----------
    loss_time : array_like, shape (n,)
        Time of the loss in each run, NaN where lock was never lost. [s]
    duration : float
        Duration of every run. [s]
    confidence : float
        Confidence level. [1]

    Returns
    -------
    Estimate
        MTLL and its interval [s]; the value is NaN and the upper bound infinite when no run lost lock.
    """
    from scipy.stats import chi2

    times = np.asarray(loss_time, dtype=np.float64)
    if times.size == 0:
        return Estimate(np.nan, np.nan, np.nan, "no runs")
    losses = int(np.isfinite(times).sum())
    exposure = float(np.where(np.isfinite(times), np.minimum(times, duration), duration).sum())
    if losses == 0:
        return Estimate(np.nan, -exposure / float(np.log1p(-confidence)), np.inf, "no loss seen: one-sided lower bound")
    tail = (1.0 - confidence) / 2.0
    low = 2.0 * exposure / float(chi2.isf(tail, 2 * losses + 2))
    high = 2.0 * exposure / float(chi2.isf(1.0 - tail, 2 * losses))
    return Estimate(exposure / losses, low, high)


def lock_survival(loss_time: ArrayLike, duration: float, confidence: float = CONFIDENCE) -> Survival:
    """Kaplan-Meier curve of lock, right-censored at the end of the run.

    Parameters
    ----------
    loss_time : array_like, shape (n,)
        Time of the loss in each run, NaN where lock was never lost. [s]
    duration : float
        Duration of every run. [s]
    confidence : float
        Pointwise confidence level (log-log transformed Greenwood interval). [1]

    Returns
    -------
    Survival
        Steps from time 0 to `duration`. Bounds are NaN where Greenwood's variance does not exist (before the first
        loss, and after the last run is lost).
    """
    from scipy.stats import CensoredData, ecdf

    times = np.asarray(loss_time, dtype=np.float64)
    if times.size == 0:
        empty = np.array([np.nan, np.nan])
        return Survival(np.array([0.0, duration]), empty, empty, empty, 0)
    lost = np.isfinite(times)
    held = int((~lost).sum())
    curve = ecdf(CensoredData(uncensored=np.minimum(times[lost], duration), right=np.full(held, duration))).sf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        bounds = curve.confidence_interval(confidence, method="log-log")
    parts = (curve.probabilities, 1.0), (bounds.low.probabilities, np.nan), (bounds.high.probabilities, np.nan)
    probability, low, high = (np.concatenate([[start], values, values[-1:]]) for values, start in parts)
    return Survival(np.concatenate([[0.0], curve.quantiles, [duration]]), probability, low, high, held)


def bootstrap_mean(values: ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Mean over realisations with a bootstrap interval (BCa, fixed seed); NaN is left out and counted in the note.

    Parameters
    ----------
    values : array_like, shape (n,)
        One value a realisation.
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    Estimate
        Mean and interval in the unit of `values`; no interval below four values.
    """
    kept, given = _finite(values), np.size(values)
    if kept.size == 0:
        return Estimate(np.nan, np.nan, np.nan, "no finite value")
    left_out = f"{given - kept.size} of {given} values not finite" if kept.size < given else ""
    same = "all values equal" if _constant(kept, float(np.abs(kept).mean())) else ""
    return _bootstrapped(float(kept.mean()), (kept,), _mean, confidence, same, left_out)


def paired_ratio(values: ArrayLike, reference: ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
    """Ratio of two means on the same realisations, with a paired bootstrap interval: realisations are drawn.

    Parameters
    ----------
    values, reference : array_like, shape (n,)
        One value a realisation, in the same order.
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    Estimate
        mean(values) / mean(reference) and its interval. [1]
    """
    first, second, left_out = _pairs(values, reference)
    if first.size == 0 or not second.mean() > 0.0:
        return Estimate(np.nan, np.nan, np.nan, _join("the reference mean is not positive", left_out))
    ratio = float(first.mean() / second.mean())
    proportional = _constant(first - ratio * second, float(np.abs(first).mean()))
    same = "proportional to the reference" if proportional else ""
    return _bootstrapped(ratio, (first, second), _mean_ratio, confidence, same, left_out)


def paired_difference(
    values: ArrayLike, reference: ArrayLike, confidence: float = CONFIDENCE
) -> tuple[Estimate, float]:
    """Mean difference on the same realisations: paired bootstrap interval and the p-value of a paired t-test.

    The exact sign-flip test would be free of assumptions, but its p-value cannot fall below 2^(1 - n): with eight
    realisations and Holm's correction over a dozen pairs it could never tell any two laws apart.

    Parameters
    ----------
    values, reference : array_like, shape (n,)
        One value a realisation, in the same order.
    confidence : float
        Two-sided confidence level. [1]

    Returns
    -------
    tuple of Estimate and float
        mean(values - reference) with its interval, and the p-value (NaN below four pairs).
    """
    from scipy.stats import ttest_1samp

    first, second, left_out = _pairs(values, reference)
    difference = first - second
    if difference.size == 0:
        return Estimate(np.nan, np.nan, np.nan, "no finite pair"), np.nan
    mean = float(difference.mean())
    scale = float(np.abs(np.concatenate([first, second])).mean())
    same = "all differences equal" if _constant(difference, scale) else ""
    estimate = _bootstrapped(mean, (difference,), _mean, confidence, same, left_out)
    if difference.size < FEWEST:
        return estimate, np.nan
    if same:
        return estimate, 1.0 if abs(mean) <= 1e-12 * scale else 0.0
    return estimate, float(ttest_1samp(difference, 0.0).pvalue)


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's step-down correction for several comparisons; NaN stays NaN and does not count as a comparison.

    Source: S. Holm, "A simple sequentially rejective multiple test procedure", Scand. J. Statist. 6 (1979) 65-70.
    """
    order = sorted((i for i, p in enumerate(p_values) if np.isfinite(p)), key=lambda i: p_values[i])
    adjusted, running = [float("nan")] * len(p_values), 0.0
    for rank, i in enumerate(order):
        running = max(running, min(1.0, (len(order) - rank) * p_values[i]))
        adjusted[i] = running
    return adjusted


def paired_differences(
    names: Sequence[str],
    values: NDArray[np.float64],
    confidence: float = CONFIDENCE,
    words: tuple[str, str] = ("more", "less"),
) -> tuple[PairedDifference, ...]:
    """Compare every pair of laws on identical realisations, Holm-corrected over all pairs.

    All pairs make up the family, so the words stay right for the pair that looks best afterwards. Two laws count as
    different when the corrected p-value is below 1 - `confidence` and the interval of the single comparison leaves out
    zero.

    Parameters
    ----------
    names : sequence of str, length L
        Names of the laws.
    values : ndarray, shape (L, n)
        One value a law and realisation.
    confidence : float
        Confidence level of the single intervals and of the family of tests. [1]
    words : tuple of str
        What to call a difference above and below zero.

    Returns
    -------
    tuple of PairedDifference, length L (L - 1) / 2
        Each pair once, the law with the larger mean first.
    """
    means = [finite_mean(row) for row in values]
    ranked = sorted(range(len(names)), key=lambda i: -means[i] if np.isfinite(means[i]) else np.inf)
    pairs = [(a, b) for k, a in enumerate(ranked) for b in ranked[k + 1 :]]
    results = [paired_difference(values[a], values[b], confidence) for a, b in pairs]
    corrected = holm([p for _, p in results])
    return tuple(
        PairedDifference(names[a], names[b], estimate, p, p_holm, in_words(estimate, p_holm, words, 1.0 - confidence))
        for (a, b), (estimate, p), p_holm in zip(pairs, results, corrected, strict=True)
    )


def finite_mean(values: ArrayLike) -> float:
    """Mean of the finite values, NaN without a warning when there are none."""
    kept = _finite(values)
    return float(kept.mean()) if kept.size else float("nan")


def finite_largest(values: ArrayLike) -> float:
    """Largest of the finite values, NaN when there are none."""
    kept = _finite(values)
    return float(kept.max()) if kept.size else float("nan")


def in_words(difference: Estimate, p_holm: float, words: tuple[str, str], level: float) -> str:
    """Say what a difference is: the first or the second of `words` where the corrected test and the interval agree."""
    if not np.isfinite(p_holm):
        return difference.note
    if p_holm < level and (difference.low > 0.0 or difference.high < 0.0):
        return words[0] if difference.value > 0.0 else words[1]
    return NOT_DISTINGUISHABLE


def _finite(values: ArrayLike) -> NDArray[np.float64]:
    given = np.asarray(values, dtype=np.float64)
    return given[np.isfinite(given)]


def _pairs(values: ArrayLike, reference: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], str]:
    first, second = np.asarray(values, dtype=np.float64), np.asarray(reference, dtype=np.float64)
    if first.shape != second.shape:
        raise ValueError(f"paired values need equal shapes, got {first.shape} and {second.shape}")
    both = np.isfinite(first) & np.isfinite(second)
    note = "" if both.all() else f"{int((~both).sum())} of {both.size} pairs not finite"
    return first[both], second[both], note


def _bootstrapped(
    value: float,
    samples: tuple[NDArray[np.float64], ...],
    statistic: Callable[..., NDArray[np.float64]],
    confidence: float,
    same: str,
    left_out: str,
) -> Estimate:
    """Value of the statistic with its interval; `same` says why all resamples agree, where they do.

    BCa bounds, and percentile bounds where BCa does not exist (acceleration undefined for nearly degenerate samples).
    """
    from scipy.stats import bootstrap

    count = samples[0].size
    if count < FEWEST:
        few = f"no interval from {count} realisation{'s' if count > 1 else ''} (at least {FEWEST})"
        return Estimate(value, np.nan, np.nan, _join(few, left_out))
    if same:
        return Estimate(value, value, value, _join(same, left_out))
    options: dict[str, Any] = {"paired": True, "vectorized": True, "n_resamples": RESAMPLES, "batch": 1000}
    for method in ("BCa", "percentile"):
        options |= {"method": method, "rng": np.random.default_rng(SEED)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            bounds = bootstrap(samples, statistic, confidence_level=confidence, **options).confidence_interval
        if np.isfinite(bounds.low) and np.isfinite(bounds.high):
            break
    return Estimate(value, float(bounds.low), float(bounds.high), left_out)


def _mean(values: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
    return np.asarray(np.mean(values, axis=axis))


def _mean_ratio(values: NDArray[np.float64], reference: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
    return np.asarray(np.mean(values, axis=axis) / np.mean(reference, axis=axis))


def _constant(values: NDArray[np.float64], scale: float) -> bool:
    return bool(np.ptp(values) <= 1e-12 * scale)


def _join(*notes: str) -> str:
    return "; ".join(note for note in notes if note)
