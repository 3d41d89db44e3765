"""Every pair of laws at once: differences, Holm's correction, and what they are called."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyroctl.statistics.estimate import CONFIDENCE, NOT_DISTINGUISHABLE, Estimate, PairedDifference, finite_mean
from gyroctl.statistics.means import paired_difference


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
    *,
    zero_if_lost: bool = True,
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
    zero_if_lost : bool
        See `paired_difference`.

    Returns
    -------
    tuple of PairedDifference, length L (L - 1) / 2
        Each pair once, the law with the larger mean first.
    """
    means = [finite_mean(row) for row in values]
    ranked = sorted(range(len(names)), key=lambda i: -means[i] if np.isfinite(means[i]) else np.inf)
    pairs = [(a, b) for k, a in enumerate(ranked) for b in ranked[k + 1 :]]
    results = [paired_difference(values[a], values[b], confidence, zero_if_lost=zero_if_lost) for a, b in pairs]
    corrected = holm([p for _, p in results])
    return tuple(
        PairedDifference(names[a], names[b], estimate, p, p_holm, in_words(estimate, p_holm, words, 1.0 - confidence))
        for (a, b), (estimate, p), p_holm in zip(pairs, results, corrected, strict=True)
    )


def in_words(difference: Estimate, p_holm: float, words: tuple[str, str], level: float) -> str:
    """Say what a difference is: the first or the second of `words` where the corrected test and the interval agree."""
    if not np.isfinite(p_holm):
        return difference.note
    if p_holm < level and (difference.low > 0.0 or difference.high < 0.0):
        return words[0] if difference.value > 0.0 else words[1]
    return NOT_DISTINGUISHABLE
