"""The figure: error against the lead, one panel for each moment and sea."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.studies.forecast.skill import LEADS, SOURCES, Skill
from gyroctl.studies.style import INK, MUTED, label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES: dict[str, dict[str, Any]] = {
    "true moments": {"color": "#009E73", "marker": "s"},
    "true moments, sea known": {"color": "#009E73", "ls": ":"},
    "sensors": {"color": "#0072B2", "marker": "o"},
    "sensors, sea known": {"color": "#0072B2", "ls": ":"},
    "sensors, generic sea": {"color": MUTED, "ls": "--"},
}
"""How each source is drawn."""


def draw(found: Mapping[str, Skill], note: str) -> Figure:
    """Draw the mean square error over the variance: 0 is perfect, 1 is no better than the mean."""
    figure, axes = sheet(2, len(found), (3.4 * len(found), 6.4), "Forecast of the wave moments", note, sharey=True)
    for column, (name, value) in enumerate(found.items()):
        for j, moment in enumerate((1, 3)):
            panel = axes[j * len(found) + column]
            for s, source in enumerate(SOURCES):
                if np.all(np.isfinite(value.error[s, j])):
                    panel.plot(LEADS, value.error[s, j], ms=4, label=source, **LINES[source])
            panel.axhline(1.0, color=INK, lw=0.8)
            panel.set_ylim(0.0, 1.15)
            label(panel, f"Me{moment}, {name}", "lead [s]", "error / variance [1]")
    axes[0].legend(loc="lower right")
    return figure
