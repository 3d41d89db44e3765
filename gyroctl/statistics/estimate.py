"""What statistics return: numbers with their intervals, and the reason in words where an interval is missing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

CONFIDENCE = 0.95
"""Two-sided confidence level of all intervals. [1]"""

FEWEST = 4
"""Fewest realisations from which an interval of a mean is given: below it the scatter is not known."""

NOT_DISTINGUISHABLE = "not distinguishable"
"""Word for a difference whose sign the runs do not tell."""


class Estimate(NamedTuple):
    """A number with its confidence interval; `note` says why a bound is missing, or what the interval leaves out.

    Parameters
    ----------
    value : float
        The number, in its own unit.
    low, high : float
        Ends of the interval, in the same unit; NaN where there is none.
    note : str
        Why a bound is missing, or what the interval leaves out.
    """

    value: float
    low: float
    high: float
    note: str = ""


class Share(NamedTuple):
    """A share of runs with its Wilson interval.

    Parameters
    ----------
    value : float
        The share. [-]
    low, high : float
        Ends of the interval. [-]
    runs : int
        How many runs it is of.
    """

    value: float
    low: float
    high: float
    runs: int


class Survival(NamedTuple):
    """Kaplan-Meier estimate of the probability that lock still holds: a step function of time [s] with its interval.

    Parameters
    ----------
    time : (n,) array
        Instants at which the estimate steps. [s]
    probability : (n,) array
        From each of them on. [-]
    low, high : (n,) array
        Ends of the interval. [-]
    censored : int
        Runs that ended in lock.
    """

    time: NDArray[np.float64]
    probability: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    censored: int


class PairedDifference(NamedTuple):
    """Mean of `first` minus `second` on the same realisations, with p-values before and after Holm's correction.

    Parameters
    ----------
    first, second : str
        Names of the two.
    estimate : Estimate
        Mean of `first` minus `second` with its interval, in their unit.
    p_value, p_holm : float
        Before and after the correction. [-]
    words : str
        What the difference is, see `in_words`.
    tests : int
        Comparisons over which it is corrected.
    """

    first: str
    second: str
    estimate: Estimate
    p_value: float
    p_holm: float
    words: str
    tests: int = 1  # over which it is corrected


def nothing(note: str) -> Estimate:
    """No number, and why."""
    return Estimate(np.nan, np.nan, np.nan, note)


def finite(values: ArrayLike) -> NDArray[np.float64]:
    """Keep what is a finite number."""
    given = np.asarray(values, dtype=np.float64)
    return given[np.isfinite(given)]


def finite_mean(values: ArrayLike) -> float:
    """Mean of the finite values, NaN without a warning when there are none.

    Parameters
    ----------
    values : array_like
        Numbers of any shape, in any unit.

    Returns
    -------
    float
        In the same unit.
    """
    kept = finite(values)
    return float(kept.mean()) if kept.size else float("nan")


def finite_largest(values: ArrayLike) -> float:
    """Largest of the finite values, NaN when there are none.

    Parameters
    ----------
    values : array_like
        Numbers of any shape, in any unit.

    Returns
    -------
    float
        In the same unit.
    """
    kept = finite(values)
    return float(kept.max()) if kept.size else float("nan")


def join(*notes: str) -> str:
    """Notes that say something, one after the other."""
    return "; ".join(note for note in notes if note)
