"""Laws and physics at a glance: power as length, lock as a disc, one column a law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from gyroctl.palette import LOCK_SCALE, law_styles
from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import NOTHING
from gyroctl.studies.evaluation.draw import note
from gyroctl.studies.style import AXIS, INK, MUTED, listed, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gyroctl.studies.evaluation.physics_cells import Cell

SCALE, LEAST, MARGIN, NAMES = 0.055, 0.86, 0.16, 2.0
"""Length of a watt, least width of a law's column, room for its disc, and for the names of the cases: so narrow that
the letters can still be read where a page shows the picture 390 pixels wide. [in]"""

ROW = 0.36
"""Height of a case. [in]"""

DISC = 7.0
"""Diameter of the disc. [pt]"""

WORDS = (
    "Bar: mean power [W] and its interval, one scale for all laws; line: that in the linear plant. Disc: how many of "
    "the runs held lock, full where all did; where not, they are counted"
)


def draw_physics(tables: Mapping[str, Mapping[str, Cell]], asked: Mapping[str, Any]) -> Figure:
    """Mean power of each law in each case with its interval, and the share of runs that held lock."""
    from matplotlib.colors import LinearSegmentedColormap

    found = {law: None for table in tables.values() for law in table}
    laws = [law for law in dict.fromkeys([*asked["laws"], *found]) if law in found and law != REFERENCE]
    laws += [law for law in found if law == REFERENCE]
    styles, scale = law_styles(laws, REFERENCE), LinearSegmentedColormap.from_list("lock", LOCK_SCALE)
    columns = {law: [table[law] for table in tables.values() if law in table] for law in laws}
    begins = {law: min(0.0, *map(_low, cells)) - MARGIN / SCALE for law, cells in columns.items()}
    ends = {law: max(0.0, *map(_high, cells)) + 0.5 * MARGIN / SCALE for law, cells in columns.items()}
    widths = [max(LEAST, SCALE * (ends[law] - begins[law])) for law in laws]
    size = (NAMES + sum(widths), 1.9 + ROW * len(tables))
    note_ = f"{note(asked)}. {WORDS}"
    figure, axes = sheet(1, len(laws), size, "The laws in real water", note_, sharey=True, width_ratios=widths)
    for axis, law, width in zip(axes, laws, widths, strict=True):
        linear = next(iter(tables.values())).get(law)
        if linear is not None:
            axis.axvline(linear.row.power.value, color=AXIS, lw=0.9, zorder=0)
        axis.axvline(0.0, color=INK, lw=0.7)
        for i, table in enumerate(tables.values()):
            if law in table:
                _bar(axis, i, table[law], styles[law].colour)
                _disc(axis, begins[law] + 0.4 * MARGIN / SCALE, i, table[law], scale)
        axis.set_xlim(begins[law], begins[law] + width / SCALE)
        axis.set_title(law.replace("_", "\n"), fontsize=9.5)
        axis.set_xticks([])
        axis.tick_params(length=0)
        axis.grid(False)
        for side in ("bottom", "left"):
            axis.spines[side].set_visible(False)
    axes[0].set_ylim(-0.7, len(tables) - 0.4)
    listed(axes[0], list(tables), color=INK)
    return figure


def _bar(axis: Axes, at: int, cell: Cell, colour: str) -> None:
    """Bar with its interval, pale where not every run held lock, and the number above it."""
    power, held, runs = cell.row.power, cell.row.locked, cell.row.runs
    place = at + 0.2
    axis.barh(place, power.value, color=colour, height=0.38, alpha=1.0 if held == runs else 0.45, lw=0)
    if math.isfinite(power.low) and math.isfinite(power.high):
        axis.plot([power.low, power.high], [place, place], color=INK, lw=0.9)
    told = (
        f"{round(power.value, 1) + 0.0:.1f}".replace("-", "\N{MINUS SIGN}") if math.isfinite(power.value) else NOTHING
    )
    box, above = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}, at - 0.2
    axis.text(0.03 / SCALE, above, told, va="center", fontsize=8.5, color=INK, bbox=box)
    if held < runs:
        edge = axis.get_yaxis_transform()
        axis.text(1.0, above, f"{held}/{runs}", transform=edge, va="center", ha="right", fontsize=7.2, color=MUTED)


def _disc(axis: Axes, x: float, at: int, cell: Cell, scale: Any) -> None:
    """Disc that is as full as many runs held lock."""
    share = cell.row.locked / cell.row.runs
    axis.plot(x, at, "o", ms=DISC, mfc="white", mec=scale(share), mew=1.3, clip_on=False)
    axis.plot(x, at, "o", ms=DISC * math.sqrt(share), mfc=scale(share), mec="none", clip_on=False)


def _low(cell: Cell) -> float:
    """Lower end of the interval, or the value where there is none. [W]"""
    power = cell.row.power
    return power.low if math.isfinite(power.low) else power.value


def _high(cell: Cell) -> float:
    """Upper end of the interval, or the value where there is none. [W]"""
    power = cell.row.power
    return power.high if math.isfinite(power.high) else power.value
