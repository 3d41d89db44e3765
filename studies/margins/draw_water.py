"""Picture of the margins in real water: what each choice moves, and the drag that replaces the hinge damping."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gyroctl.studies.margins.axes import gain_at
from gyroctl.studies.margins.drag_lock import Counted, DragLock
from gyroctl.studies.margins.water import ALL, ChoiceMargins, shift
from gyroctl.studies.style import INK, MUTED, PAPER_COLOUR, label, listed, percent, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SINGLE, TOGETHER, REFERENCE = "#0072B2", "#8C3A8C", "#AEB6BF"
CURVE = "#C77700"
NO_ORBIT = " no orbit"


def water(
    found: Mapping[str, ChoiceMargins],
    lock: DragLock | None,
    counted: Sequence[Counted],
    point: str,
    length: float = 1.0,
) -> Figure:
    """Draw the margins of each choice, and below where the lock without hinge damping holds.

    Parameters
    ----------
    found : mapping
        Margins by the names of `water.CHOICES`, "linear" first.
    lock : DragLock, optional
        Drag that the lock needs without hinge damping in a regular wave.
    counted : sequence of Counted
        Runs in a sea.
    point : str
        Wave and controls, for the note.
    length : float
        Length of the device over that of Table 1. [-]
    """
    note = f"{point}; one choice on at a time; below: no hinge damping (d1 = 0), the star is the wave above"
    rows = 2 if lock is not None or counted else 1
    figure, axes = sheet(rows, 3, (14.0, 4.8 * rows), "Margins in real water", note)
    linear, gain = found["linear"], gain_at(length)
    folds = {name: 100.0 * shift(one.fold, linear.fold) for name, one in found.items()}
    _bars(axes[0], folds, "{:+.1f} %", True)
    label(axes[0], f"Fold in cg, from {gain.scale * linear.fold:.3g} {gain.times}", "shift of the fold [%]", "")
    _bars(axes[1], {name: one.d1_border for name, one in found.items()}, "{:.3g}", False)
    axes[1].axvline(0.0, color=INK, lw=0.8)
    label(axes[1], "Neimark-Sacker border in d1", "hinge damping that lock needs [Nms/rad]", "")
    _bars(axes[2], {name: 100.0 * one.damping_ratio for name, one in found.items()}, "{:.2g} %", False)
    label(axes[2], "Damping of φ1", "damping ratio of the φ1 mode [%]", "")
    for panel in axes[1:3]:
        panel.set_yticklabels([])
    if rows == 2:
        _lock(axes[3:5], lock)
        _counted(axes[5], counted, lock)
    return figure


def _bars(panel: Any, values: Mapping[str, float], form: str, names: bool) -> None:
    known = [value for value in values.values() if math.isfinite(value)]
    span = max([*known, 0.0]) - min([*known, 0.0]) or 1.0
    for row, (name, value) in enumerate(values.items()):
        if not math.isfinite(value):
            panel.text(0.0, row, NO_ORBIT, va="center", fontsize=8, color=MUTED)
            continue
        colour = REFERENCE if name == "linear" else TOGETHER if name == ALL else SINGLE
        panel.barh(row, value, 0.7, color=colour)
        side = "right" if value < 0.0 else "left"
        panel.text(value, row, f" {form.format(value)} ", va="center", ha=side, fontsize=8, color=MUTED)
    listed(panel, list(values) if names else [""] * len(values))
    panel.set_xlim(min([*known, 0.0]) - 0.25 * span, max([*known, 0.0]) + 0.25 * span)


def _lock(panels: Sequence[Any], lock: DragLock | None) -> None:
    words = {"cc": ("cc [Nms]", "coupling"), "height": ("wave height [m]", "height")}
    for panel, (over, (axis, name)) in zip(panels, words.items(), strict=True):
        if lock is not None:
            line = next(line for line in lock.curves if line.over == over)
            panel.plot(line.at, line.drag, color=CURVE, lw=1.8)
            panel.plot([lock.at[over]], [lock.drag], "*", color=PAPER_COLOUR, ms=13, mec="white")
            panel.set_ylim(0.0, 1.15 * float(max(line.drag)))
            panel.text(0.97, 0.93, "stable", transform=panel.transAxes, ha="right", va="top", color=MUTED, fontsize=9)
            panel.text(0.03, 0.03, "an oscillation grows", transform=panel.transAxes, color=MUTED, fontsize=9)
        label(panel, f"Drag that lock needs over the {name}", axis, "Cd")
    panels[0].set_xscale("log")


def _counted(panel: Any, counted: Sequence[Counted], lock: DragLock | None) -> None:
    for one in counted:
        share = one.share
        error = [[share.value - share.low], [share.high - share.value]]
        panel.errorbar([one.drag], [share.value], error, fmt="o", color=SINGLE, capsize=3, ms=5)
    if lock is not None:
        panel.axvline(lock.drag, color=CURVE, lw=1.2, ls="--")
    runs = counted[0].share.runs if counted else 0
    panel.set_xscale("symlog", linthresh=0.02)
    panel.set_xlim(-0.004, 1.5)
    ticks = (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    panel.minorticks_off()
    percent(panel)
    label(panel, f"Runs that keep lock in a sea, of {runs}", "Cd", "")
