"""Confidence bounds of means from few values: of many samples at once, each along the last axis.

Two kinds of bounds. Those from the scatter that was seen: Student's t, Hall's with the skewness taken out, Fieller's
for ratios. And those for what was not seen: in eight runs without a loss up to a third of all runs may be lost, and
a lost run gives about nothing. For these every run gets a random share of the whole (exponential weights, the
Bayesian bootstrap), and so does one run more, which is lost. For values of nought and one that gives the exact
binomial bound; for values that are not negative the lower bound of the mean holds whatever their distribution.

Sources: D. B. Rubin, "The Bayesian bootstrap", Ann. Statist. 9 (1981) 130-134; N. Gaffke, "Three test statistics for
a nonparametric one-sided hypothesis on the mean of a nonnegative variable", Math. Methods Statist. 14 (2005) 451-467;
P. Hall, "On the removal of skewness by transformation", J. R. Statist. Soc. B 54 (1992) 221-228; E. C. Fieller, "Some
problems in interval estimation", J. R. Statist. Soc. B 16 (1954) 175-185.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bounds = tuple[Array, Array]

RESAMPLES = 9999
SEED = 20170731

SKEWNESS = 1.25
"""Factor on the sample's skewness in `unskewed`: few values show less skewness than there is (measured)."""

BLOCK = 2_000_000
"""Weights that are held in memory at a time; what fits in one block is kept for the next call."""


def student(values: Array, confidence: float) -> Bounds:
    """Bounds of the mean by Student's t."""
    from scipy.stats import t

    count, mean = values.shape[-1], values.mean(-1)
    half = float(t.isf(0.5 * (1.0 - confidence), count - 1)) * values.std(-1, ddof=1) / np.sqrt(count)
    return mean - half, mean + half


def unskewed(values: Array, confidence: float) -> Bounds:
    """Bounds of the mean by t after Hall's cubic transformation, which takes the skewness out."""
    from scipy.stats import t

    count, mean, deviation = values.shape[-1], values.mean(-1), values.std(-1)
    third = ((values - mean[..., None]) ** 3).mean(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        skewness = np.where(deviation > 0.0, third / deviation**3, 0.0)
    skewness = skewness * (SKEWNESS * np.sqrt(count * (count - 1.0)) / (count - 2.0))
    skewness = np.where(np.abs(skewness) < 1e-6, 1e-6, skewness)  # the inverse below loses its digits at none
    quantile = float(t.isf(0.5 * (1.0 - confidence), count - 1)) / np.sqrt(count - 1.0)

    def inverse(at: float) -> Array:
        root = np.cbrt(1.0 + skewness * (at - skewness / (6.0 * count)))
        return np.asarray(3.0 / skewness * (root - 1.0), dtype=np.float64)

    return mean - deviation * inverse(quantile), mean - deviation * inverse(-quantile)


def fieller(first: Array, second: Array, confidence: float) -> Bounds:
    """Bounds of a ratio of means by Fieller: the ratios r for which t finds no mean in first - r second.

    Infinite where the mean of `second` cannot be told from zero: no bound holds then.
    """
    from scipy.stats import t

    count, top, bottom = first.shape[-1], first.mean(-1), second.mean(-1)
    quantile = float(t.isf(0.5 * (1.0 - confidence), count - 1)) ** 2 / count
    shared = ((first - top[..., None]) * (second - bottom[..., None])).sum(-1) / (count - 1.0)
    a = bottom**2 - quantile * second.var(-1, ddof=1)
    b = top * bottom - quantile * shared
    root = np.sqrt(np.maximum(b**2 - a * (top**2 - quantile * first.var(-1, ddof=1)), 0.0))
    bounded = a > 0.0
    a = np.where(bounded, a, 1.0)
    return np.where(bounded, (b - root) / a, -np.inf), np.where(bounded, (b + root) / a, np.inf)


def unskewed_ratio(first: Array, second: Array, confidence: float) -> Bounds:
    """Bounds of a ratio of means by `unskewed` bounds of what it leaves."""
    bottom = second.mean(-1)
    ratio = first.mean(-1) / bottom
    low, high = unskewed(first - ratio[..., None] * second, confidence)
    return ratio + low / bottom, ratio + high / bottom


def rarely_lost_mean(values: Array, confidence: float) -> Array:
    """Lower bound of the mean, were one run more lost."""
    (sums,), _, whole = _resample(values)
    return _quantile(sums / _beside(whole, sums), 0.5 * (1.0 - confidence))


def rarely_lost_ratio(first: Array, second: Array, confidence: float) -> Bounds:
    """Bounds of the ratio of means, were one run more lost: one of `first` for the lower, of `second` for the upper."""
    (top, bottom), more, _ = _resample(first, second)
    tail, more = 0.5 * (1.0 - confidence), _beside(more, top)
    low = _quantile(top / (bottom + more * second.mean(-1)), tail)
    return low, _quantile((top + more * first.mean(-1)) / bottom, 1.0 - tail)


def rarely_lost_difference(first: Array, second: Array, confidence: float) -> Bounds:
    """Bounds of the mean of first - second, were one run more lost, as for the ratio."""
    (sums,), more, whole = _resample(first - second)
    tail, more, whole = 0.5 * (1.0 - confidence), _beside(more, sums), _beside(whole, sums)
    low = _quantile((sums - more * second.mean(-1)) / whole, tail)
    return low, _quantile((sums + more * first.mean(-1)) / whole, 1.0 - tail)


def chance_of_no_lead(first: Array, second: Array) -> Array:
    """Two-sided p-value of the mean of first - second, were one run more of the law with more lost.

    Twice the probability that the weighted sum behind `rarely_lost_difference` has not the sign of the mean; by the
    saddlepoint, so that it may be as small as Holm's correction needs (exact to a few percent of itself).
    Source: R. Lugannani, S. Rice, "Saddle point approximation ...", Adv. Appl. Probab. 12 (1980) 475-490.
    """
    from scipy.stats import norm

    sign = np.where(first.mean(-1) >= second.mean(-1), 1.0, -1.0)
    lost = -np.where(sign > 0.0, second.mean(-1), first.mean(-1))
    values = np.concatenate([sign[..., None] * (first - second), lost[..., None]], axis=-1)
    lowest = values.min(-1)
    hopeless = values.sum(-1) <= 0.0  # the one lost run takes the lead away
    left, right = np.where(hopeless | (lowest >= 0.0), -1.0, 1.0 / np.where(lowest < 0.0, lowest, -1.0)), 0.0 * lowest
    for _ in range(60):  # halves the bracket of the saddlepoint, at which the slope of the cumulants is nought
        middle = 0.5 * (left + right)
        with np.errstate(divide="ignore", invalid="ignore"):
            uphill = (values / (1.0 - middle[..., None] * values)).sum(-1) > 0.0
        left, right = np.where(uphill, left, middle), np.where(uphill, middle, right)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = 1.0 - right[..., None] * values
        root = -np.sqrt(2.0 * np.log(spread).sum(-1))
        scale = right * np.sqrt(((values / spread) ** 2).sum(-1))
        tail = norm.cdf(root) + norm.pdf(root) * (1.0 / root - 1.0 / scale)
    tail = np.where(lowest >= 0.0, 0.0, np.where(hopeless | ~(root < -1e-3), 0.5, tail))
    return np.asarray(np.clip(2.0 * tail, 0.0, 1.0), dtype=np.float64)


def _resample(*samples: Array) -> tuple[list[Array], Array, Array]:
    """Weighted sums of each sample, a row a resample; the weight of the one run more; the sum of all weights."""
    count = samples[0].shape[-1]
    parts = [([weights @ values.T for values in samples], more, whole) for weights, more, whole in _weights(count)]
    sums = [np.concatenate([part[0][i] for part in parts]) for i in range(len(samples))]
    return sums, np.concatenate([part[1] for part in parts]), np.concatenate([part[2] for part in parts])


def _weights(count: int) -> Iterator[tuple[Array, Array, Array]]:
    rows = max(1, BLOCK // (count + 1))
    if rows >= RESAMPLES:
        yield _kept_weights(count)
        return
    rng = np.random.default_rng(SEED)
    for start in range(0, RESAMPLES, rows):
        yield _split(rng.standard_exponential((min(rows, RESAMPLES - start), count + 1)))


@lru_cache(maxsize=8)
def _kept_weights(count: int) -> tuple[Array, Array, Array]:
    return _split(np.random.default_rng(SEED).standard_exponential((RESAMPLES, count + 1)))


def _split(weights: Array) -> tuple[Array, Array, Array]:
    return np.ascontiguousarray(weights[:, :-1]), weights[:, -1].copy(), weights.sum(1)


def _beside(weights: Array, sums: Array) -> Array:
    """Weights, one a resample, against the sums of one or of many samples."""
    return weights if sums.ndim == 1 else weights[:, None]


def _quantile(resamples: Array, at: float) -> Array:
    return np.asarray(np.quantile(resamples, at, axis=0), dtype=np.float64)
