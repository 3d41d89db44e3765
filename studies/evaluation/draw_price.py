"""The figure of table `price`: power as a waterfall, with smoothness, lock and reversals beside each step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from gyroctl.reports.wording import number, watts
from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation.draw import note
from gyroctl.studies.style import AXIS, GAMMA_COLOURS, INK, MUTED, label, listed, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LESS, MORE = GAMMA_COLOURS[50.0], GAMMA_COLOURS[5.0]
"""Steps that take power and that win it."""

ROW, HEIGHT = 0.42, 0.56
"""Height of a step [in] and of its bar [rows]."""

WORDS = (
    "Each bar begins where the step before ends; grey: power from nothing on, at the beginning and where a group ends. "
    "Lines at the end of a bar are the interval of the paired change: thick in runs like those seen, thin with losses "
    "of lock too rare to be seen. Filled squares: runs that held lock; hollow circles: runs without reversal"
)

Step = Mapping[str, Any]


def draw_price(steps: Sequence[Step], asked: Mapping[str, Any]) -> Figure:
    """Draw the steps from top to bottom.

    Parameters
    ----------
    steps : sequence of mapping
        As the table records them: ``group``, ``step``, ``power``, ``cv``, ``locked``, ``runs``, ``without_reversal``;
        ``change`` and ``seen`` are None for the first. Estimates are `Estimate`.
    asked : mapping
        Of the request, for the note.
    """
    size = (12.0, 2.4 + ROW * len(steps))
    told = f"{note(asked)}. {WORDS}"
    figure, axes = sheet(1, 3, size, "The price list of real water", told, sharey=True, width_ratios=(6.0, 2.0, 1.6))
    starts = begins(steps)
    for i, step in enumerate(steps):
        _bar(axes[0], i, step, starts[i], i == 0 or _ends_group(steps, i))
        cv = step["cv"]
        low, high = _arms(cv)
        axes[1].errorbar(cv.value, i, xerr=[[low], [high]], fmt="o", color=INK, ms=4.5, lw=1.0)
        axes[2].plot(step["locked"] / step["runs"], i, "s", color=INK, ms=5.5)
        axes[2].plot(step["without_reversal"] / step["runs"], i, "o", mfc="none", mec=LESS, mew=1.4, ms=8.5)
    _links(axes[0], steps, starts)
    for axis in axes:
        for i, (one, other) in enumerate(pairwise(steps)):
            if one["group"] != other["group"]:
                axis.axhline(i + 0.5, color=AXIS, lw=0.8)
    axes[0].axvline(0.0, color=INK, lw=0.8)
    axes[1].set_xlim(left=0.0)
    axes[2].set_xlim(-0.06, 1.06)
    axes[2].set_xticks([0.0, 0.5, 1.0], ["none", "half", "all"])
    axes[0].set_ylim(-0.6, len(steps) - 0.4)
    listed(axes[0], [step["step"] for step in steps], color=INK)
    label(axes[0], "Mean power", "mean power [W]", "")
    label(axes[1], "Smoothness", "CV of power", "")
    label(axes[2], "Lock, rolling", "of the runs", "")
    return figure


def begins(steps: Sequence[Step]) -> list[float]:
    """Where each bar begins: at the power of the step before, and at nothing for the first. [W]"""
    return [0.0, *(step["power"].value for step in steps[:-1])]


def _ends_group(steps: Sequence[Step], i: int) -> bool:
    return i + 1 == len(steps) or steps[i + 1]["group"] != steps[i]["group"]


def _bar(axis: Axes, at: int, step: Step, start: float, whole: bool) -> None:
    """Bar of a step with its intervals, the level behind it where it ends a group, and the figures beside it."""
    power, change, seen = step["power"], step["change"], step["seen"]
    if whole:
        axis.barh(at, power.value, color=AXIS, alpha=0.55, height=HEIGHT, lw=0)
    if change is None:
        low, high = _arms(power)
        axis.errorbar(power.value, at, xerr=[[low], [high]], color=INK, lw=0.8)
        far, told = power.value + high, f"{number(power.value)} W"
    else:
        end = start + change.value
        axis.barh(at, change.value, left=start, color=LESS if change.value < 0.0 else MORE, height=HEIGHT, lw=0)
        for one, width in ((change, 0.7), (seen, 2.4)):
            low, high = _arms(one)
            axis.plot([end - low, end + high], [at, at], color=INK, lw=width, solid_capstyle="butt")
        reach = max(_arms(change)[1], _arms(seen)[1])
        sign = "+" if change.value > 0.0 else ""
        far, told = max(start, end + reach), f"{number(power.value)} W ({sign}{watts(change.value)})"
    box = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8}
    axis.annotate(told, (far, at), (5, 0), textcoords="offset points", va="center", fontsize=8, color=MUTED, bbox=box)


def _links(axis: Axes, steps: Sequence[Step], starts: Sequence[float]) -> None:
    """Thin lines from the end of each bar to the beginning of the next one."""
    for i in range(1, len(steps)):
        axis.plot([starts[i], starts[i]], [i - 1, i], color=MUTED, lw=0.6, zorder=0)


def _arms(estimate: Estimate) -> tuple[float, float]:
    """Lengths of an interval below and above the value, 0 where there is none."""
    low, high = estimate.value - estimate.low, estimate.high - estimate.value
    return max(low, 0.0) if math.isfinite(low) else 0.0, max(high, 0.0) if math.isfinite(high) else 0.0
