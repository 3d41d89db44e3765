"""Every pair of laws at once: differences, Holm's correction, and what they are called."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyroctl.statistics.estimate import CONFIDENCE, NOT_DISTINGUISHABLE, Estimate, PairedDifference, finite_mean
from gyroctl.statistics.means import paired_difference


def holm(p_values: Sequence[float], tests: int = 0) -> list[float]:
    """Holm's step-down correction for several comparisons; NaN stays NaN and does not count as a comparison.

    Where these are some of so many `tests`, chosen by their results, the others count as if each had the greater p: no
    value is smaller than with all of them.

    Source: S. Holm, "A simple sequentially rejective multiple test procedure", Scand. J. Statist. 6 (1979) 65-70.

    Parameters
    ----------
    p_values : sequence of float
        Of each comparison. [-]
    tests : int
        Comparisons in all; 0 for those that are given.

    Returns
    -------
    list of float
        Corrected values, in the same order. [-]
    """
    order = sorted((i for i, p in enumerate(p_values) if np.isfinite(p)), key=lambda i: p_values[i])
    adjusted, running, count = [float("nan")] * len(p_values), 0.0, max(len(order), tests)
    for rank, i in enumerate(order):
        running = max(running, min(1.0, (count - rank) * p_values[i]))
        adjusted[i] = running
    return adjusted


def paired_differences(
    names: Sequence[str],
    values: NDArray[np.float64],
    confidence: float = CONFIDENCE,
    words: tuple[str, str] = ("more", "less"),
    *,
    zero_if_lost: bool = True,
    pairs: Sequence[tuple[str, str]] | None = None,
    tests: int = 0,
) -> tuple[PairedDifference, ...]:
    """Compare every pair of laws on identical realisations, or those given, Holm-corrected over all of them.

    All pairs make up the family, so the words stay right for the pair that looks best afterwards. Two laws count as
    different when the corrected p-value is below 1 - `confidence` and the interval of the single comparison leaves out
    zero.

    Parameters
    ----------
    names : sequence of str, length L
        Names of the laws.
    values : ndarray, shape (L, n)
        One value a law and realisation. In any unit.
    confidence : float
        Confidence level of the single intervals and of the family of tests. [1]
    words : tuple of str
        What to call a difference above and below zero.
    zero_if_lost : bool
        See `paired_difference`.
    pairs : sequence of two names, optional
        Which pairs, where they are not all.
    tests : int
        Pairs among which these were chosen by their results, see `holm`; 0 where they were named beforehand.

    Returns
    -------
    tuple of PairedDifference, length L (L - 1) / 2 or that of `pairs`
        Each pair once, the law with the larger mean first.
    """
    means = [finite_mean(row) for row in values]
    ranked = sorted(range(len(names)), key=lambda i: -means[i] if np.isfinite(means[i]) else np.inf)
    if pairs is None:
        chosen = [(a, b) for k, a in enumerate(ranked) for b in ranked[k + 1 :]]
    else:
        rank = {names[i]: k for k, i in enumerate(ranked)}
        places = (sorted((rank[first], rank[second])) for first, second in pairs)
        chosen = [(ranked[high], ranked[low]) for high, low in places]
    results = [paired_difference(values[a], values[b], confidence, zero_if_lost=zero_if_lost) for a, b in chosen]
    corrected, family = holm([p for _, p in results], tests), max(len(chosen), tests)
    found = []
    for (a, b), (estimate, p), p_holm in zip(chosen, results, corrected, strict=True):
        said = in_words(estimate, p_holm, words, 1.0 - confidence)
        found.append(PairedDifference(names[a], names[b], estimate, p, p_holm, said, family))
    return tuple(found)


def in_words(difference: Estimate, p_holm: float, words: tuple[str, str], level: float) -> str:
    """Say what a difference is: the first or the second of `words` where the corrected test and the interval agree.

    Parameters
    ----------
    difference : Estimate
        The difference with its interval, in its own unit.
    p_holm : float
        Corrected p-value. [-]
    words : (str, str)
        For a positive and a negative difference.
    level : float
        p-value below which it counts. [-]

    Returns
    -------
    str
        One of `words`, or that the two cannot be told apart.
    """
    if not np.isfinite(p_holm):
        return difference.note
    if p_holm < level and (difference.low > 0.0 or difference.high < 0.0):
        return words[0] if difference.value > 0.0 else words[1]
    return NOT_DISTINGUISHABLE
