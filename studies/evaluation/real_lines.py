"""One line of the table `real`: a law in a sea of real water, what its runs rest on, and the pair beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from gyroctl.statistics import Estimate, bootstrap_mean, lock_probability, paired_difference
from gyroctl.studies.evaluation.cases import Outcome, Runs, common_seeds
from gyroctl.studies.evaluation.rows import Row, rows

SINGLE_POWER, SINGLE_CV = 9.0, 0.25
"""What a single run is to give at least [W], and its largest CV of power [1]."""

TIMES = 3.0
"""How many times the power of the best constant pair a planning law is to give where it was not tuned for. [1]"""

MEANS: Mapping[str, str] = {
    "turns": "turns_kept",
    "slips": "cycle_slips",
    "reversals": "reversals",
    "phi1": "phi1_p98",
    "phi3": "phi3_p98",
    "beyond": "beyond_validity",
}
"""Means over the runs with their intervals, and the metric of each."""


class Line(NamedTuple):
    """A law in a sea."""

    row: Row
    forward: Estimate  # share of the runs in which the axis never rolls backwards [1]
    single: Estimate  # share of the runs that give `SINGLE_POWER` at a CV within `SINGLE_CV` [1]
    over: Estimate  # mean power less `TIMES` that of the constant pair on the same realisations [W]
    phi1_less: Estimate  # 98 % of |phi1| less that of the constant pair on the same realisations [rad]
    turns: Estimate  # mean ring speed over that of the waves [1]
    slips: Estimate  # per 1000 waves
    reversals: Estimate  # of the rolling, a run
    phi1: Estimate  # 98 % of |phi1| [rad]
    phi3: Estimate  # 98 % of |phi3| [rad]
    beyond: Estimate  # share of the time beyond what the model can say [1]

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        own = {name: getattr(self, name) for name in self._fields if name != "row"}
        return {**vars(self.row), **own}


def lines_of(outcome: Outcome) -> dict[str, Line]:
    """Lines of a sea by law, the one of most power first."""
    found = {law: line(row, outcome.runs[law], outcome.reference) for law, row in rows(outcome).items()}
    return dict(sorted(found.items(), key=lambda item: -item[1].row.power.value))


def line(row: Row, runs: Runs, reference: Runs) -> Line:
    """One law; a run without numbers counts as one with a reversal, and as one that does not give enough.

    Power is told against a multiple of the pair's as a difference: a pair that drains its flywheel has less than none,
    and a ratio to that says nothing.
    """
    value, both = runs.values, common_seeds(runs, reference)
    less, _ = paired_difference(runs.on(both, "phi1_p98"), reference.on(both, "phi1_p98"), zero_if_lost=False)
    over, _ = paired_difference(runs.on(both, "mean_power"), TIMES * reference.on(both, "mean_power"))
    enough = (value["mean_power"] >= SINGLE_POWER) & (value["power_cv"] <= SINGLE_CV)
    means = {name: bootstrap_mean(value[metric], zero_if_lost=False) for name, metric in MEANS.items()}
    return Line(
        row,
        forward=lock_probability(value["reversals"] == 0.0),
        single=lock_probability(enough),
        over=over,
        phi1_less=less,
        **means,
    )
