"""The figure of table `real`: power against its smoothness in each sea of real water, with what the targets ask for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gyroctl.reports.layout import REFERENCE
from gyroctl.studies.evaluation.draw import note, power_over_cv
from gyroctl.studies.evaluation.real_lines import TIMES, Line
from gyroctl.studies.evaluation.real_targets import CV, OVER, POWER, Target

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WHOLE = 0.98
"""Share of the runs that hold lock, below which a law is drawn hollow. [1]"""


def draw_real(tables: Mapping[float, Sequence[Line]], targets: Sequence[Target], asked: Mapping[str, Any]) -> Figure:
    """Draw each law as a point with its intervals."""
    words = f"{note(asked)}; hollow: lock in less than {100 * WHOLE:g} % of the runs; shaded: what the targets ask for"
    corners = {
        gamma: [corner(target, table) for target in targets if target.gamma == gamma] for gamma, table in tables.items()
    }
    rows = {gamma: [line.row for line in table] for gamma, table in tables.items()}
    return power_over_cv("The laws in real water", words, rows, corners, lambda row: row.locked >= WHOLE * row.runs)


def corner(target: Target, table: Sequence[Line]) -> tuple[float, float]:
    """Largest CV and least power [W] that a target asks for."""
    limits = {demand.measure: demand.limit for demand in target.demands}
    constant = next((line.row.power.value for line in table if line.row.law == REFERENCE), 0.0)
    return limits.get(CV, math.inf), max(limits.get(POWER, 0.0), TIMES * constant if OVER in limits else 0.0)
