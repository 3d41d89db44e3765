"""The Pareto plot: power against smoothness, with the probability of lock as colour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gyroctl.reports import layout
from gyroctl.reports.canvas import LETTER, Drawing, Key, Paper, Room, sheet
from gyroctl.reports.coinciding import groups
from gyroctl.reports.evaluation import Evaluation, LawResult
from gyroctl.reports.labels import Box, Side, place, place_freely
from gyroctl.reports.theme import LIGHT, LOCK_SCALE, REFERENCE_GREY, law_styles
from gyroctl.reports.wording import listed, number
from gyroctl.statistics import Estimate

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

MARK = 7.5
"""Radius of a point. [px]"""


def pareto(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """Mean power [W] against power CV [1], colour P(lock), bars the 95 % intervals; best is top left."""
    from matplotlib.colors import LinearSegmentedColormap

    laws = plottable(evaluation)
    right, top = pareto_range(laws)
    styles = law_styles(layout.names(ds), evaluation.reference)
    scale = LinearSegmentedColormap.from_list("lock", LOCK_SCALE)
    figure, (axes,) = sheet(paper, [330.0 if paper.narrow else 400.0], room=Room(left=56.0, right=18.0))
    axes.set_xlim(0.0, right)
    axes.set_ylim(0.0, top)
    front = _front(laws)
    axes.plot([law.power_cv.value for law in front], [law.power.value for law in front], ":", color=REFERENCE_GREY)
    for law in laws:
        x, y = law.power_cv, law.power
        for estimate, along in ((x, True), (y, False)):
            if _bounded(estimate):
                span = [estimate.low, estimate.high]
                axes.plot(*((span, [y.value] * 2) if along else ([x.value] * 2, span)), color=LIGHT.axis, lw=1.2)
        colour, marker = scale(law.lock.value), styles[law.name].marker
        size = 0.7 * MARK if paper.narrow else MARK
        axes.plot(x.value, y.value, marker, ms=1.7 * size, mfc=colour, mec=LIGHT.ink, mew=0.8, zorder=3)
    left_out = _names(axes, laws, paper, evaluation.reference)
    axes.set_xlabel("Coefficient of variation of power [1] (← smoother)")
    axes.set_ylabel("Mean power [W]")
    keys = [Key(f"P(lock) {at:g}", colour, "box") for at, colour in LOCK_SCALE]
    keys += [Key("no other law beats it in both", REFERENCE_GREY, "dot")] if len(front) > 1 else []
    said = "; ".join(f"{law.name} {number(law.power.value)} W at CV {number(law.power_cv.value, 2)}" for law in laws)
    missing = f" Without room for its name: {listed(left_out)}." if left_out else ""
    return Drawing(figure, f"Mean power against power CV of each law: {said}.{missing}", tuple(keys))


def _names(axes: Axes, laws: Sequence[LawResult], paper: Paper, reference: str | None) -> list[str]:
    """Write the names where they cover nothing, those at one point together; return those that found no place."""
    to_pixels = axes.transData.transform
    at = [to_pixels((law.power_cv.value, law.power.value)) for law in laws]
    bars = []
    for law in laws:
        x, y = law.power_cv, law.power
        if _bounded(x):
            (left, low), (right, high) = to_pixels((x.low, y.value)), to_pixels((x.high, y.value))
            bars.append(Box(left, right, low - 1.0, high + 1.0))
        if _bounded(y):
            (left, low), (right, high) = to_pixels((x.value, y.low)), to_pixels((x.value, y.high))
            bars.append(Box(left - 1.0, right + 1.0, low, high))
    together = groups([np.array([law.power_cv.value, law.power.value]) for law in laws])
    names = [" = ".join(paper.short(laws[k].name) for k in group) for group in together]
    size = paper.type - 0.5
    sizes = [(LETTER * size * len(name) + 2.0, 1.25 * size) for name in names]
    box = axes.get_window_extent()
    area = Box(box.x0 + 2.0, box.x1 + 14.0, box.y0 + 2.0, box.y1 + 4.0)
    found = place_freely([tuple(at[group[0]]) for group in together], sizes, bars, area)
    to_data = axes.transData.inverted().transform
    missing = []
    for group, name, place_ in zip(together, names, found, strict=True):
        if place_ is None:
            missing += [laws[k].name for k in group]
            continue
        centre = ((place_.left + place_.right) / 2.0, (place_.bottom + place_.top) / 2.0)
        x, y = to_data(centre)
        point = at[group[0]]
        near_x = min(max(point[0], place_.left), place_.right)
        near_y = min(max(point[1], place_.bottom), place_.top)
        if math.hypot(near_x - point[0], near_y - point[1]) > 12.0:
            line = to_data(np.array([(near_x, near_y), tuple(point)], dtype=np.float64))
            axes.plot(line[:, 0], line[:, 1], color=LIGHT.muted, lw=0.7, zorder=2, scalex=False, scaley=False)
        weight = "normal" if laws[group[0]].name == reference else "bold"
        axes.text(x, y, name, ha="center", va="center", fontsize=size, fontweight=weight, zorder=4)
    return missing


def _bounded(estimate: Estimate) -> bool:
    return math.isfinite(estimate.low) and math.isfinite(estimate.high)


def plottable(evaluation: Evaluation) -> list[LawResult]:
    """Laws with a finite mean power and power CV, most power first."""
    return [law for law in evaluation.by_power if math.isfinite(law.power.value) and math.isfinite(law.power_cv.value)]


def pareto_range(laws: Sequence[LawResult]) -> tuple[float, float]:
    """Choose the ends of the CV axis [1] and of the power axis [W], with room for names."""
    right = max((e.high if math.isfinite(e.high) else e.value for e in (law.power_cv for law in laws)), default=1.0)
    top = max((e.high if math.isfinite(e.high) else e.value for e in (law.power for law in laws)), default=1.0)
    return 1.1 * max(right, 1e-9), 1.14 * max(top, 1e-9)


def pareto_labels(laws: Sequence[LawResult], right: float, top: float) -> list[Side]:
    """Side on which to write the name of each law in the Pareto plot."""
    points = [(law.power_cv.value / right, law.power.value / top) for law in laws]
    bars = []
    for (x, y), law in zip(points, laws, strict=True):
        cv, power = law.power_cv, law.power
        if math.isfinite(cv.high):
            bars.append(Box(cv.low / right, cv.high / right, y - 0.008, y + 0.008))
        if math.isfinite(power.high):
            bars.append(Box(x - 0.004, x + 0.004, power.low / top, power.high / top))
    return place(points, [law.name for law in laws], bars)


def _front(laws: Sequence[LawResult]) -> list[LawResult]:
    """Laws that no other law beats in both power and smoothness, smoothest first."""
    front = [
        law
        for law in laws
        if not any(
            o.power.value >= law.power.value and o.power_cv.value <= law.power_cv.value and o is not law for o in laws
        )
    ]
    return sorted(front, key=lambda law: law.power_cv.value)
