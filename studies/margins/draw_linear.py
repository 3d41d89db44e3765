"""Picture of how far the linear model holds: its error against the nonlinear plant over the size of the disturbance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gyroctl.linearisation.lifted import nonlinear_error
from gyroctl.studies.style import MUTED, PAPER_COLOUR, label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gyroctl.linearisation import PeriodicOrbit

SIZES = np.geomspace(1e-6, 1e-1, 11)
"""Disturbances, relative to the typical magnitude of each state and control on the orbit."""


def linear_error(orbit: PeriodicOrbit, point: str) -> tuple[Figure, dict[str, list[float]]]:
    """Draw the relative error of the lifted model over three wave periods, and return it for the record.

    A wrong linearisation would level off; a right one falls in proportion to the disturbance down to rounding.
    """
    errors = nonlinear_error(orbit.linearise(), SIZES)
    note = f"{point}; the model is that about the orbit of these constant controls"
    figure, axes = sheet(1, 1, (6.4, 4.6), "How far the linear model holds", note)
    panel = axes[0]
    panel.loglog(SIZES, errors, "o-", color=PAPER_COLOUR, ms=5, label="lifted model against the nonlinear plant")
    panel.loglog(SIZES, errors[0] / SIZES[0] * SIZES, "--", color=MUTED, lw=1.0, label="in proportion")
    label(panel, "Error falls with the disturbance", "size of the disturbance [1]", "relative error over 3 waves [1]")
    panel.legend(loc="upper left")
    return figure, {"size": SIZES.tolist(), "relative_error": errors.tolist()}
