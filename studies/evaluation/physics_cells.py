"""One field of the table `physics`: a law in a case, what its runs rest on, and its change against the linear plant."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gyroctl.statistics import Estimate, finite_mean, paired_difference, paired_ratio
from gyroctl.studies.evaluation.cases import Outcome, Runs, common_seeds
from gyroctl.studies.evaluation.rows import Row, rows

CARD = ("reversals", "traction_p99", "beyond_validity")
"""Numbers of the validity card that the table shows, see `gyroctl.simulation.validity`."""


class Cell(NamedTuple):
    """A law in a case: its row, what its runs rest on, and its change against the linear plant."""

    row: Row
    reversals: float  # of the rolling, a run
    traction_p99: float  # friction coefficient that rolling needs 99 % of the time [-]
    beyond_validity: float  # share of the time beyond what the model can say [1]
    of_linear: Estimate  # mean power over its own in the linear plant on the same realisations [1]
    less_linear: Estimate  # mean power less its own in the linear plant on the same realisations [W]

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        own = {name: getattr(self, name) for name in self._fields if name != "row"}
        return {**vars(self.row), **own}


def table_of(outcome: Outcome, linear: Outcome) -> dict[str, Cell]:
    """Cells of a case by law."""
    return {law: _cell(row, outcome.runs[law], linear.runs.get(law)) for law, row in rows(outcome).items()}


def _cell(row: Row, runs: Runs, linear: Runs | None) -> Cell:
    nothing = Estimate(np.nan, np.nan, np.nan, "not run in the linear plant")
    ratio, difference = nothing, nothing
    if linear is not None:
        seeds = common_seeds(runs, linear)
        own, before = runs.on(seeds, "mean_power"), linear.on(seeds, "mean_power")
        ratio, (difference, _) = paired_ratio(own, before), paired_difference(own, before)
    reversals, traction, beyond = (finite_mean(runs.values[name]) for name in CARD)
    return Cell(row, reversals, traction, beyond, ratio, difference)
