"""Laws and physics at a glance: power as length, lock as a marker, one column a law."""

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
    from matplotlib.figure import Figure

    from gyroctl.studies.evaluation.physics_cells import Cell

WIDTH = 5.4
"""Narrow, so that its letters can still be read where a page shows it 390 pixels wide. [in]"""


def draw_physics(tables: Mapping[str, Mapping[str, Cell]], asked: Mapping[str, Any]) -> Figure:
    """Mean power of each law in each case with its interval, and the share of runs that held lock."""
    from matplotlib.colors import LinearSegmentedColormap

    laws = list(dict.fromkeys(law for table in tables.values() for law in table))
    laws = [law for law in laws if law != REFERENCE] + [law for law in laws if law == REFERENCE]
    styles, scale = law_styles(laws, REFERENCE), LinearSegmentedColormap.from_list("lock", LOCK_SCALE)
    words = (
        f"{note(asked)}. Bar: mean power [W], line: that in the linear plant. Disc: runs that held lock, full where all"
    )
    figure, axes = sheet(1, len(laws), (WIDTH, 1.7 + 0.3 * len(tables)), "The laws in real water", words, sharey=True)
    top = max((_high(cell) for table in tables.values() for cell in table.values()), default=1.0)
    for axis, law in zip(axes, laws, strict=True):
        first = next(iter(tables.values())).get(law)
        if first is not None:
            axis.axvline(first.row.power.value, color=AXIS, lw=0.9, zorder=0)
        for i, table in enumerate(tables.values()):
            if law in table:
                _cell(axis, i, table[law], styles[law].colour, scale, top)
        axis.set_xlim(-0.3 * top, 1.5 * top)
        axis.set_title(law.replace("_", " "), fontsize=9.5)
        axis.set_xticks([])
        axis.spines["bottom"].set_visible(False)
        axis.spines["left"].set_visible(False)
    listed(axes[0], list(tables), color=INK)
    for axis in axes:
        axis.grid(False)
        axis.tick_params(length=0)
    return figure


def _cell(axis: Any, at: int, cell: Cell, colour: str, scale: Any, top: float) -> None:
    row = cell.row
    value, share = row.power.value, row.locked / row.runs
    whole = row.locked == row.runs
    look: dict[str, Any] = {"color": colour, "height": 0.62, "alpha": 1.0 if whole else 0.45, "lw": 0}
    axis.barh(at, value, **look)
    if math.isfinite(row.power.low) and math.isfinite(row.power.high):
        axis.plot([row.power.low, row.power.high], [at, at], color=INK, lw=0.9)
    axis.text(
        max(_high(cell), 0.0) + 0.04 * top,
        at,
        number(value, 2 if abs(value) < 10.0 else 3),
        va="center",
        fontsize=8.5,
        color=INK,
    )
    ring = scale(share)
    axis.plot(-0.16 * top, at, "o", ms=6.5, mfc="white", mec=ring, mew=1.3)
    axis.plot(-0.16 * top, at, "o", ms=6.5 * math.sqrt(share), mfc=ring, mec="none")
    if not whole:
        axis.text(1.48 * top, at, f"{row.locked}/{row.runs}", va="center", ha="right", fontsize=7.5, color=MUTED)


def _high(cell: Cell) -> float:
    power = cell.row.power
    return power.high if math.isfinite(power.high) else power.value
