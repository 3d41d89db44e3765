"""Laws and physics at a glance: power as length, lock as a disc, one column a law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.theme import LOCK_SCALE, law_styles
from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.draw import note
from gyroctl.studies.style import AXIS, INK, MUTED, listed, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gyroctl.studies.evaluation.physics_cells import Cell

WIDTH = 5.4
"""Narrow, so that its letters can still be read where a page shows it 390 pixels wide. [in]"""

DISC = 7.0
"""Diameter of the disc. [pt]"""

WORDS = (
    "Bar: mean power [W] and its interval; line: that in the linear plant. Disc: how many of the runs held lock, full "
    "where all did, counted below the power where not all did"
)


def draw_physics(tables: Mapping[str, Mapping[str, Cell]], asked: Mapping[str, Any]) -> Figure:
    """Mean power of each law in each case with its interval, and the share of runs that held lock."""
    from matplotlib.colors import LinearSegmentedColormap

    found = dict.fromkeys(law for table in tables.values() for law in table)
    laws = [law for law in found if law != REFERENCE] + [law for law in found if law == REFERENCE]
    styles, scale = law_styles(laws, REFERENCE), LinearSegmentedColormap.from_list("lock", LOCK_SCALE)
    size = (max(WIDTH, 1.4 + WIDTH * len(laws) / 5.0), 1.9 + 0.34 * len(tables))
    figure, axes = sheet(1, len(laws), size, "The laws in real water", f"{note(asked)}. {WORDS}", sharey=True)
    every = [cell for table in tables.values() for cell in table.values()]
    top, bottom = max(map(_high, every)), min(0.0, *(cell.row.power.value for cell in every))
    for axis, law in zip(axes, laws, strict=True):
        linear = next(iter(tables.values())).get(law)
        if linear is not None:
            axis.axvline(linear.row.power.value, color=AXIS, lw=0.9, zorder=0)
        axis.axvline(0.0, color=INK, lw=0.7)
        at_disc = bottom - 0.17 * top
        for i, table in enumerate(tables.values()):
            if law in table:
                _bar(axis, i, table[law], styles[law].colour, top)
                _disc(axis, at_disc, i, table[law], scale)
        axis.set_xlim(at_disc - 0.12 * top, 1.42 * top)
        axis.set_title(law.replace("_", "\n"), fontsize=9.5)
        axis.set_xticks([])
        axis.tick_params(length=0)
        axis.grid(False)
        for side in ("bottom", "left"):
            axis.spines[side].set_visible(False)
    axes[0].set_ylim(-0.7, len(tables) - 0.3)
    listed(axes[0], list(tables), color=INK)
    return figure


def _bar(axis: Axes, at: int, cell: Cell, colour: str, top: float) -> None:
    """Bar with its interval, pale where not every run held lock, and the number beside it."""
    power, whole = cell.row.power, cell.row.locked == cell.row.runs
    axis.barh(at, power.value, color=colour, height=0.66, alpha=1.0 if whole else 0.45, lw=0)
    if math.isfinite(power.low) and math.isfinite(power.high):
        axis.plot([power.low, power.high], [at, at], color=INK, lw=0.9)
    told = number(power.value, 2 if abs(power.value) < 10.0 else 3)
    box, x = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}, max(_high(cell), 0.0) + 0.05 * top
    axis.text(x, at if whole else at - 0.18, told, va="center", fontsize=8.5, color=INK, bbox=box)
    if not whole:
        held = f"{cell.row.locked} of {cell.row.runs}"
        axis.text(x, at + 0.28, held, va="center", fontsize=6.8, color=MUTED, bbox=box)


def _disc(axis: Axes, x: float, at: int, cell: Cell, scale: Any) -> None:
    """Disc that is as full as many runs held lock."""
    share = cell.row.locked / cell.row.runs
    axis.plot(x, at, "o", ms=DISC, mfc="white", mec=scale(share), mew=1.3, clip_on=False)
    axis.plot(x, at, "o", ms=DISC * math.sqrt(share), mfc=scale(share), mec="none", clip_on=False)


def _high(cell: Cell) -> float:
    """Upper end of the interval, or the value where there is none. [W]"""
    power = cell.row.power
    return power.high if math.isfinite(power.high) else power.value
