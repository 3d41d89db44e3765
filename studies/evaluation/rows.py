"""One line of a table: a law in a case in numbers with intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness.seed_ledger import ledger
from gyroctl.reports.layout import MOTION_LIMIT
from gyroctl.reports.wording import seed_ranges
from gyroctl.simulation.lock import in_step
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
    seeds: str  # realisations, in words
    seed_states: dict[str, int]  # how many of them the ledger holds for spent, in reserve, ..
    runs: int
    failed: int  # runs without numbers
    locked: int  # runs that held lock
    lock: Estimate  # probability to hold lock, with Wilson's interval [1]
    in_step: int  # runs in step with the waves, by the best constant pair of the case
    pair_in_step: int  # how many of as many runs of the best constant pair were
    step: Estimate  # probability to be in step, with Wilson's interval [1]
    turns_kept: float  # mean ring speed over that of the waves [1]
    power: Estimate  # mean power that is judged: generated and stored [W]
    generated_w: float  # its electrical part [W]
    stored_w: float  # change of what flywheel and float store [W]
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
    outside_share: float  # share of the time beyond it [1]
    phi1_max: float  # largest motion of any run [rad]
    phi3_max: float  # largest motion of any run [rad]
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
    step = steps(runs, reference)
    means = ("phi1_p98", "phi3_p98", "outside_share", "cycle_slips", "turns_kept", "saturations")
    flows = ("generated_w", "stored_w", "slip_loss_w", "wave_input_w")
    same: dict[str, Any] = {name: finite_mean(value[name]) for name in (*means, *flows)}
    same |= {name: int(np.nansum(value[name])) for name in ("outside_model", "fallbacks", "deadline_misses")}
    return Row(
        law=runs.entrant.label,
        kind=runs.kind,
        information=runs.information,
        preview=runs.preview,
        tuning=runs.entrant.tuning,
        seeds=seed_ranges(tuple(runs.seeds.tolist())),
        seed_states={state: len(some) for state, some in ledger().states(runs.seeds.tolist()).items()},
        runs=locked.size,
        failed=int(np.nansum(value["failed"])),
        locked=int(locked.sum()),
        lock=lock_probability(value["locked"]),
        in_step=int(step.sum()),
        pair_in_step=round(float(np.mean(steps(reference, reference))) * locked.size),
        step=lock_probability(step),
        power=bootstrap_mean(value["mean_power"]),
        cv=bootstrap_mean(value["power_cv"], zero_if_lost=False),
        cv_1s=bootstrap_mean(value["power_cv_1s"], zero_if_lost=False),
        ratio=paired_ratio(own, other),
        difference=difference,
        p_value=p_value,
        pairs=len(both),
        power_locked=finite_mean(value["mean_power"][locked]),
        phi1_worst=finite_largest(value["phi1_p98"]),
        phi3_worst=finite_largest(value["phi3_p98"]),
        phi1_max=finite_largest(value["phi1_max"]),
        phi3_max=finite_largest(value["phi3_max"]),
        ledger_residual=finite_largest(np.abs(value["ledger_residual"])),
        over_limit=int(np.sum(~(motion <= MOTION_LIMIT))),
        step_ms_median=float(np.nanmedian(value["step_ms_median"])),
        step_ms_p99=finite_largest(value["step_ms_p99"]),
        **same,
    )


def steps(runs: Runs, reference: Runs) -> NDArray[np.bool_]:
    """Which of the runs were in step, (n,), by the reference on the same realisations, see `simulation.lock.in_step`.

    Laws are run in groups that do not all hold the reference, so that the comparison's own verdict is not enough.
    """
    locked = reference.values["locked"] > 0.5
    turns = dict(zip(reference.seeds[locked].tolist(), reference.values["turns_kept"][locked].tolist(), strict=True))
    slips, any_locked = reference.values["cycle_slips"][locked], bool(locked.any())
    typical = float(np.median(list(turns.values()))) if any_locked else np.nan
    usual = float(np.median(slips)) if any_locked else np.nan
    value, n = runs.values, runs.seeds.size
    return in_step(
        value["turns_kept"],
        value["cycle_slips"],
        value["waves_counted"],
        [turns.get(seed, typical) for seed in runs.seeds.tolist()],
        np.full(n, usual),
        np.full(n, any_locked),
    )
