"""One line of a table: a law in a case in numbers with intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports.layout import MOTION_LIMIT
from gyroctl.statistics import Estimate, bootstrap_mean, finite_mean, lock_probability, paired_difference, paired_ratio
from gyroctl.studies.evaluation.cases import Outcome, Runs, common_seeds


@dataclass(frozen=True)
class Row:
    """A law in a case. Means are over all runs, lost ones included; ratios and differences over the common ones.

    Parameters
    ----------
    law, kind, information, tuning : str
        Which law, with which set of parameters.
    runs, locked : int
        Number of runs, and of those that held lock.
    lock : Estimate
        Probability to hold lock, with Wilson's interval. [1]
    power, cv, cv_1s : Estimate
        Mean power [W], its coefficient of variation within a run, and that of its means over 1 s. [1]
    ratio, difference : Estimate
        Mean power over that of the best constant pair of the sea [1], and less it [W].
    p_value : float
        Of the difference, by a paired t-test.
    pairs : int
        Realisations on which both were run.
    power_locked : float
        Mean power of the runs that held lock. [W]
    phi1_p98, phi3_p98, phi1_worst, phi3_worst : float
        98 % motion: mean over the runs and the worst run. [rad]
    cycle_slips : float
        Per 1000 waves.
    slip_loss_w, wave_input_w, saturations, ledger_residual : float
        Means [W], samples a run, and the largest residual of the energy ledger. [1]
    over_limit, outside_model : int
        Runs whose 98 % motion is beyond its limit; runs with any motion beyond the range of the model.
    step_ms_median, step_ms_p99 : float
        Time of a step, median and the worst run's 99 %. [ms]
    fallbacks, deadline_misses : int
        Sums over the runs.
    """

    law: str
    kind: str
    information: str
    tuning: str
    runs: int
    locked: int
    lock: Estimate
    power: Estimate
    cv: Estimate
    cv_1s: Estimate
    ratio: Estimate
    difference: Estimate
    p_value: float
    pairs: int
    power_locked: float
    phi1_p98: float
    phi3_p98: float
    phi1_worst: float
    phi3_worst: float
    cycle_slips: float
    slip_loss_w: float
    wave_input_w: float
    saturations: float
    ledger_residual: float
    over_limit: int
    outside_model: int
    step_ms_median: float
    step_ms_p99: float
    fallbacks: int
    deadline_misses: int

    @property
    def motion(self) -> float:
        """The larger of the two 98 % motions. [rad]"""
        return float(np.maximum(self.phi1_p98, self.phi3_p98))  # what is no number stays none, unlike with max


def rows(outcome: Outcome) -> list[Row]:
    """Rows of a case in the order of its laws, the reference among them."""
    return [row(runs, outcome.reference) for runs in outcome.runs.values()]


def row(runs: Runs, reference: Runs) -> Row:
    """One law against the reference."""
    both = common_seeds(runs, reference)
    own, other = runs.on(both, "mean_power"), reference.on(both, "mean_power")
    difference, p_value = paired_difference(own, other)
    value = runs.values
    locked = value["locked"] > 0.5
    return Row(
        law=runs.entrant.label,
        kind=runs.kind,
        information=runs.information,
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
        phi1_p98=finite_mean(value["phi1_p98"]),
        phi3_p98=finite_mean(value["phi3_p98"]),
        phi1_worst=_largest(value["phi1_p98"]),
        phi3_worst=_largest(value["phi3_p98"]),
        cycle_slips=finite_mean(value["cycle_slips"]),
        slip_loss_w=finite_mean(value["slip_loss_w"]),
        wave_input_w=finite_mean(value["wave_input_w"]),
        saturations=finite_mean(value["saturations"]),
        ledger_residual=_largest(np.abs(value["ledger_residual"])),
        over_limit=int(np.sum(~(np.maximum(value["phi1_p98"], value["phi3_p98"]) <= MOTION_LIMIT))),
        outside_model=int(np.nansum(value["outside_model"])),
        step_ms_median=float(np.median(value["step_ms_median"])),
        step_ms_p99=_largest(value["step_ms_p99"]),
        fallbacks=int(np.nansum(value["fallbacks"])),
        deadline_misses=int(np.nansum(value["deadline_misses"])),
    )


def _largest(values: NDArray[np.float64]) -> float:
    kept = values[np.isfinite(values)]
    return float(kept.max()) if kept.size else float("nan")
