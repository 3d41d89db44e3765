"""When a statement of one realisation agrees with an ensemble: the rules, each a function of numbers alone.

A verdict is "agree", "differ", or "open" where the interval does not decide.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.statistics import CONFIDENCE, FEWEST, Estimate, bootstrap_mean, lock_probability, paired_difference

Verdict = Literal["agree", "differ", "open"]


class Result(NamedTuple):
    """What we found for one statement."""

    value: float
    low: float  # lower end of the 95 % interval; NaN where the number is exact
    high: float
    unit: str
    verdict: Verdict
    note: str = ""


def holds(locked: ArrayLike) -> Result:
    """Judge "keeps lock", said of one realisation: agree where that is the likelier outcome, its interval above 1/2."""
    share = lock_probability(locked)
    held = np.asarray(locked, bool)
    return Result(*share[:3], "", _side(share, 0.5), f"{int(held.sum())} of {held.size} kept lock")


def loses(locked: ArrayLike) -> Result:
    """Judge "loses lock", said of one realisation: agree where that is the likelier outcome; the value is P(kept)."""
    kept = holds(locked)
    opposite: dict[Verdict, Verdict] = {"agree": "differ", "differ": "agree", "open": "open"}
    return kept._replace(verdict=opposite[kept.verdict])


def one_draw(values: ArrayLike, stated: float, rounding: float, unit: str, what: str) -> Result:
    """Judge a number read off one realisation: agree where it lies within the central 95 % of ours.

    Parameters
    ----------
    values : array_like, (n,)
        One number a realisation; NaN where it does not exist.
    stated : float
        The paper's number.
    rounding : float
        Half the last digit that the paper gives: the range is widened by it.
    unit, what : str
        Unit, and whose values these are.

    Returns
    -------
    Result
        Mean with its interval; "open" below four values.
    """
    kept = _finite(values)
    if kept.size < FEWEST:
        return _too_few(kept, unit, what)
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.quantile(kept, (tail, 1.0 - tail))
    inside = low - rounding <= stated <= high + rounding
    mean = bootstrap_mean(kept, zero_if_lost=False)  # of chosen runs: none is lost
    note = f"{kept.size} {what}, 95 % of them {low:.3g} to {high:.3g} {unit}"
    return Result(*mean[:3], unit, "agree" if inside else "differ", note)


def within(values: ArrayLike, bounds: tuple[float, float], unit: str, what: str) -> Result:
    """Judge a stated range: agree where the interval of our mean lies in it, differ where it lies outside."""
    kept = _finite(values)
    if kept.size < FEWEST:
        return _too_few(kept, unit, what)
    mean = bootstrap_mean(kept, zero_if_lost=False)  # of chosen runs: none is lost
    verdict: Verdict = "open"
    if bounds[0] <= mean.low and mean.high <= bounds[1]:
        verdict = "agree"
    elif mean.high < bounds[0] or mean.low > bounds[1]:
        verdict = "differ"
    return Result(*mean[:3], unit, verdict, f"{kept.size} {what}")


def larger(first: ArrayLike, second: ArrayLike, unit: str, note: str) -> Result:
    """Judge "first is larger than second" on identical realisations: the sign of the paired difference."""
    difference, _ = paired_difference(first, second)
    if not np.isfinite(difference.low):
        return Result(difference.value, np.nan, np.nan, unit, "open", difference.note)
    return Result(*difference[:3], unit, _side(difference, 0.0), note)


def close(value: float, stated: float, tolerance: float, unit: str, note: str = "") -> Result:
    """Judge a number without chance: agree where it lies within `tolerance` (relative) of the stated one."""
    verdict: Verdict = "agree" if abs(value - stated) <= tolerance * abs(stated) else "differ"
    return Result(value, np.nan, np.nan, unit, verdict, note or f"tolerance {100 * tolerance:g} %")


def is_true(value: float, fact: bool, unit: str, note: str) -> Result:
    """Judge a fact without chance, with the number that shows it."""
    return Result(value, np.nan, np.nan, unit, "agree" if fact else "differ", note)


def _finite(values: ArrayLike) -> NDArray[np.float64]:
    given: NDArray[np.float64] = np.asarray(values, float)
    return np.asarray(given[np.isfinite(given)])


def _too_few(kept: NDArray[np.float64], unit: str, what: str) -> Result:
    value = float(kept.mean()) if kept.size else np.nan
    return Result(value, np.nan, np.nan, unit, "open", f"only {kept.size} {what}")


def _side(estimate: Estimate, limit: float) -> Verdict:
    if estimate.low > limit:
        return "agree"
    return "differ" if estimate.high < limit else "open"
