"""Statistics of a comparison: lock probability, time to lose lock, means, paired ratios and differences.

Every function returns numbers with an interval and, where an interval cannot be given or does not hold for all that
could happen, the reason in words instead of an error: one to three realisations, every run lost and no run lost are
ordinary results. Everything is deterministic: resampling always starts from the same seed, so that a report rebuilt
from its file repeats every digit.

How often the intervals hold the truth is measured, not hoped for: `benchmarks/interval_coverage.py` prints the table.
"""

from gyroctl.statistics.estimate import (
    CONFIDENCE,
    FEWEST,
    NOT_DISTINGUISHABLE,
    Estimate,
    PairedDifference,
    Share,
    Survival,
    finite_largest,
    finite_mean,
)
from gyroctl.statistics.family import holm, in_words, paired_differences
from gyroctl.statistics.lock import lock_probability, lock_survival, mean_time_to_loss, wilson
from gyroctl.statistics.means import bootstrap_mean, paired_difference, paired_ratio
from gyroctl.statistics.strata import per_realisation, stratified_ratio, stratified_share, stratified_sum

__all__ = [
    "CONFIDENCE",
    "FEWEST",
    "NOT_DISTINGUISHABLE",
    "Estimate",
    "PairedDifference",
    "Share",
    "Survival",
    "bootstrap_mean",
    "finite_largest",
    "finite_mean",
    "holm",
    "in_words",
    "lock_probability",
    "lock_survival",
    "mean_time_to_loss",
    "paired_difference",
    "paired_differences",
    "paired_ratio",
    "per_realisation",
    "stratified_ratio",
    "stratified_share",
    "stratified_sum",
    "wilson",
]
