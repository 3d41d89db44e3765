"""One line of a table: a law in a case in numbers with intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyroctl.reports.layout import MOTION_LIMIT
from gyroctl.statistics import (
    Estimate,
    bootstrap_mean,
    finite_largest,
    finite_mean,
    lock_probability,
    paired_difference,
    paired_ratio,
)
from gyroctl.studies.evaluation.cases import Outcome, Runs, common_seeds


@dataclass(frozen=True)
class Row:
    """A law in a case.

    Means are over all runs, lost ones included; ratios and differences over the realisations that both have.
    """

    law: str
    kind: str
    information: str  # level at which it is judged
    tuning: str  # set of parameters
    runs: int
    locked: int  # runs that held lock
    lock: Estimate  # probability to hold lock, with Wilson's interval [1]
    power: Estimate  # mean power [W]
    cv: Estimate  # coefficient of variation of power within a run [1]
    cv_1s: Estimate  # that of its means over 1 s [1]
    ratio: Estimate  # mean power over that of the best constant pair of the sea [1]
    difference: Estimate  # mean power less that of the best constant pair [W]
    p_value: float  # of the difference, by a paired t-test
    pairs: int  # realisations on which both were run
    power_locked: float  # mean power of the runs that held lock [W]
    phi1_p98: float  # 98 % motion, mean over the runs [rad]
    phi3_p98: float  # 98 % motion, mean over the runs [rad]
    phi1_worst: float  # 98 % motion of the worst run [rad]
    phi3_worst: float  # 98 % motion of the worst run [rad]
    cycle_slips: float  # per 1000 waves
    slip_loss_w: float  # [W]
    wave_input_w: float  # [W]
    saturations: float  # samples a run
    ledger_residual: float  # largest of the energy ledger [1]
    over_limit: int  # runs whose 98 % motion is beyond its limit
    outside_model: int  # runs with any motion beyond the range of the model
    step_ms_median: float  # time of a step [ms]
    step_ms_p99: float  # 99 % of the time of a step in the worst run [ms]
    fallbacks: int  # sum over the runs
    deadline_misses: int  # sum over the runs
    preview: float = math.nan  # how far ahead it is told the waves, infinite for all of them [s]

    @property
    def motion(self) -> float:
        """The larger of the two 98 % motions. [rad]"""
        return float(np.maximum(self.phi1_p98, self.phi3_p98))  # what is no number stays none, unlike with max


def rows(outcome: Outcome) -> dict[str, Row]:
    """Rows of a case by law, in the order in which they were run, the reference among them."""
    return {law: row(runs, outcome.reference) for law, runs in outcome.runs.items()}


def row(runs: Runs, reference: Runs) -> Row:
    """One law against the reference."""
    both = common_seeds(runs, reference)
    own, other = runs.on(both, "mean_power"), reference.on(both, "mean_power")
    difference, p_value = paired_difference(own, other)
    value = runs.values
    locked, motion = value["locked"] > 0.5, np.maximum(value["phi1_p98"], value["phi3_p98"])
    means = ("phi1_p98", "phi3_p98", "cycle_slips", "slip_loss_w", "wave_input_w", "saturations")
    same: dict[str, Any] = {name: finite_mean(value[name]) for name in means}
    same |= {name: int(np.nansum(value[name])) for name in ("outside_model", "fallbacks", "deadline_misses")}
    return Row(
        law=runs.entrant.label,
        kind=runs.kind,
        information=runs.information,
        preview=runs.preview,
        tuning=runs.entrant.tuning,
        runs=locked.size,
        locked=int(locked.sum()),
        lock=lock_probability(locked),
        power=bootstrap_mean(value["mean_power"]),
        cv=bootstrap_mean(value["power_cv"]),
        cv_1s=bootstrap_mean(value["power_cv_1s"]),
        ratio=paired_ratio(own, other),
        difference=difference,
        p_value=p_value,
        pairs=len(both),
        power_locked=finite_mean(value["mean_power"][locked]),
        phi1_worst=finite_largest(value["phi1_p98"]),
        phi3_worst=finite_largest(value["phi3_p98"]),
        ledger_residual=finite_largest(np.abs(value["ledger_residual"])),
        over_limit=int(np.sum(~(motion <= MOTION_LIMIT))),
        step_ms_median=float(np.median(value["step_ms_median"])),
        step_ms_p99=finite_largest(value["step_ms_p99"]),
        **same,
    )
