"""A figure for each table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.palette import LOCK_SCALE, REFERENCE, LawStyle, law_styles
from gyroctl.statistics import Estimate
from gyroctl.statistics.means import UNTOLD
from gyroctl.studies.evaluation.rows import Row
from gyroctl.studies.evaluation.targets import BARS, LOCKED, MOTION, Bar, missed_by_limit
from gyroctl.studies.style import INK, MUTED, ON_COLOUR, label, sea_name, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GOOD = LOCK_SCALE[-1][1]
"""Where the bars are met."""


def draw_seas(tables: Mapping[float, Sequence[Row]], asked: Mapping[str, Any]) -> Figure:
    """Power against its CV in each sea, with the corners that the bars ask for."""
    corners = {
        gamma: [(bar.cv, _asked(bar, table)) for bar in BARS if bar.gamma == gamma and not bar.one_set]
        for gamma, table in tables.items()
    }
    words = (
        f"{note(asked)}; hollow: motion beyond {MOTION:g} rad or lock in less than {100 * LOCKED:g} % of the runs, "
        "or not in step; shaded: what the bars ask for"
    )
    return power_over_cv("All laws in all seas", words, tables, corners, _kept)


def power_over_cv(
    title: str,
    words: str,
    tables: Mapping[float, Sequence[Row]],
    corners: Mapping[float, Sequence[tuple[float, float]]],
    kept: Callable[[Row], bool],
) -> Figure:
    """Draw power against its CV, an axis for each sea; what is not `kept` is hollow.

    `corners` are by sea the largest CV and the least power [W] of what is asked for.
    """
    styles = law_styles(list(dict.fromkeys(row.law for table in tables.values() for row in table)))
    shared = {"sharex": True, "sharey": True}  # panels that are compared have one scale
    figure, axes = sheet(1, len(tables), (5.2 * len(tables), 5.6), title, words, **shared)
    shown = {gamma: [row for row in table if math.isfinite(row.cv.value)] for gamma, table in tables.items()}
    everywhere = [row for rows in shown.values() for row in rows]
    right = 1.05 * max([_high(row.cv) for row in everywhere] + [0.5])
    asked_for = [power for corner in corners.values() for _, power in corner]
    top = 1.05 * max([_high(row.power) for row in everywhere] + asked_for)
    for axis, (gamma, rows) in zip(axes, shown.items(), strict=True):
        for cv, power in corners[gamma]:
            axis.fill_between([0.0, min(cv, right)], power, top, color=GOOD, alpha=0.07, lw=0)
        for row in rows:
            _point(axis, row.cv, row.power, styles[row.law], kept(row), row.law)
        axis.set_xlim(0.0, right)
        axis.set_ylim(0.0, top)
        label(axis, sea_name(gamma), "CV of power", "mean power [W]" if axis is axes[0] else "")
    _legend(figure, axes)
    return figure


def draw_information(
    levels: Mapping[str, Row], asked: Mapping[str, Any], title: str = "The price of information"
) -> Figure:
    """Power and CV over what is known of the waves."""
    figure, axes = sheet(1, 2, (10.0, 4.6), title, note(asked))
    rows = list(levels.values())
    for axis, heading, unit, estimates in (
        (axes[0], "Mean power", "mean power [W]", [row.power for row in rows]),
        (axes[1], "Smoothness", "CV of power", [row.cv for row in rows]),
    ):
        for at, (row, estimate) in enumerate(zip(rows, estimates, strict=True)):
            style, place = law_styles([row.law])[row.law], Estimate(float(at), math.nan, math.nan)
            _point(axis, place, estimate, style, _kept(row), "")
        axis.set_xticks(range(len(levels)), list(levels), rotation=20, ha="right")
        axis.set_ylim(bottom=0.0)
        label(axis, heading, "", unit)
    return figure


def draw_offdesign(groups: Mapping[str, Sequence[tuple[str, Mapping[str, Row]]]], asked: Mapping[str, Any]) -> Figure:
    """Power over the best constant pair of each sea above, lock below; one column a group of seas.

    Ratios without an interval are not drawn: where the pair has next to nothing they would hide all others.
    """
    names = list(dict.fromkeys(law for group in groups.values() for _, table in group for law in table))
    styles = law_styles(names)
    widths = [max(len(group), 1) + 1.0 for group in groups.values()]
    title, rows_alike = "Off the design, same parameters", {"width_ratios": widths, "sharey": "row"}
    ratios = [row.ratio for group in groups.values() for _, table in group for row in table.values()]
    left_out = any(UNTOLD in ratio.note for ratio in ratios)
    words = note(asked) + "; no ratio where the pair's power cannot be told from zero" * left_out
    figure, axes = sheet(2, len(groups), (13.0, 7.4), title, words, **rows_alike)
    for column, (title, group) in enumerate(groups.items()):
        above, below = axes[column], axes[len(groups) + column]
        for law in names:
            rows = {i: table[law] for i, (_, table) in enumerate(group) if law in table}
            at = np.array(list(rows)) + 0.04 * (names.index(law) - 0.5 * len(names))
            _errors(above, at, [_told(row.ratio) for row in rows.values()], styles[law], law)
            _errors(below, at, [row.lock for row in rows.values()], styles[law], law)
        above.axhline(1.0, color=INK, lw=0.9)
        above.set_ylim(bottom=0.0)
        below.set_ylim(-0.03, 1.03)
        for axis in (above, below):
            axis.set_xticks(range(len(group)), [name for name, _ in group])
            axis.set_xlim(-0.6, len(group) - 0.4)
        label(above, title, "", "power over the best constant pair's" if column == 0 else "")
        label(below, "", "", "runs that held lock" if column == 0 else "")
    _legend(figure, axes)
    return figure


def draw_robustness(
    tables: Mapping[str, Mapping[str, Row]],
    kept: Mapping[str, Mapping[str, Estimate]],
    asked: Mapping[str, Any],
    title: str,
) -> Figure:
    """Lock probability and kept power over cases and laws, as two maps with numbers."""
    from matplotlib.colors import LinearSegmentedColormap

    laws = list(dict.fromkeys(law for table in tables.values() for law in table))
    size = (3.6 + 1.5 * max(len(laws), 2), 2.4 + 0.38 * len(tables))
    figure, axes = sheet(1, 2, size, title, note(asked))
    lock = {name: {law: row.lock for law, row in table.items()} for name, table in tables.items()}
    scale = LinearSegmentedColormap.from_list("lock", LOCK_SCALE)
    for axis, found, span, title in (
        (axes[0], lock, (0.0, 1.0), "Probability\nto hold lock"),
        (axes[1], kept, (0.5, 1.1), "Mean power over that\non the nominal device"),
    ):
        values = [[found[name][law].value if law in found[name] else np.nan for law in laws] for name in tables]
        axis.imshow(np.array(values), cmap=scale, vmin=span[0], vmax=span[1], aspect="auto")
        _numbers(axis, values, span)
        axis.set_xticks(range(len(laws)), laws, rotation=30, ha="right")
        axis.set_yticks(range(len(tables)), list(tables))
        axis.tick_params(length=0, labelcolor=MUTED)
        axis.grid(False)
        axis.set_title(title)
    axes[1].set_yticklabels([])
    return figure


def note(asked: Mapping[str, Any]) -> str:
    """Line below a figure: what was run."""
    own = ", ".join(f"{name} {len(seeds)}" for name, seeds in asked["own_seeds"].items())
    extra = f" ({own})" if own else ""
    return f"Runs of {asked['duration_s']:g} s, {len(asked['seeds'])} realisations{extra}; intervals are 95 %"


def _asked(bar: Bar, table: Sequence[Row]) -> float:
    """Power that a bar asks for in this sea. [W]"""
    constant = next((row.power.value for row in table if row.law == REFERENCE), 0.0)
    return max(bar.power, bar.ratio * constant)


def _high(estimate: Estimate) -> float:
    return estimate.high if math.isfinite(estimate.high) else estimate.value


def _told(estimate: Estimate) -> Estimate:
    """The estimate, or no number where there is no interval for want of power of what it is compared with."""
    return Estimate(math.nan, math.nan, math.nan, estimate.note) if UNTOLD in estimate.note else estimate


def _kept(row: Row) -> bool:
    return not missed_by_limit(row).keys() & {"motion", "lock", "step"}


def _errors(axis: Axes, x: Any, estimates: Sequence[Estimate], style: LawStyle, name: str) -> None:
    values = [estimate.value for estimate in estimates]
    look: dict[str, Any] = {"color": style.colour, "marker": style.marker, "ms": 5, "lw": 0.9, "elinewidth": 0.8}
    axis.errorbar(x, values, yerr=_arms(estimates), label=name, **look)


def _point(axis: Axes, x: Estimate, y: Estimate, style: LawStyle, kept: bool, name: str) -> None:
    look: dict[str, Any] = {"color": style.colour, "marker": style.marker, "mfc": style.colour if kept else "white"}
    look |= {"ms": 7, "mew": 1.4, "lw": 0, "elinewidth": 1.0}
    axis.errorbar(x.value, y.value, xerr=_arms([x]), yerr=_arms([y]), label=name, **look)


def _arms(estimates: Sequence[Estimate]) -> Any:
    """Lengths of the arms below and above, 0 where there is no interval."""
    arms = [(e.value - e.low, e.high - e.value) for e in estimates]
    return np.nan_to_num(np.array(arms).T, nan=0.0, posinf=0.0).clip(min=0.0)


def _legend(figure: Figure, axes: Iterable[Axes]) -> None:
    """One legend for all axes, to the right of them."""
    found: dict[str, Any] = {}
    for axis in axes:
        for handle, name in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(name, handle)
    figure.legend(found.values(), found.keys(), loc="outside right upper")


def _numbers(axis: Axes, values: Sequence[Sequence[float]], span: tuple[float, float]) -> None:
    """Write the numbers into a map, white where it is dark."""
    for i, line in enumerate(values):
        for j, value in enumerate(line):
            if math.isfinite(value):
                dark = abs(value - span[0]) > 0.9 * (span[1] - span[0])
                axis.text(
                    j, i, f"{value:.2f}", ha="center", va="center", fontsize=8, color="white" if dark else ON_COLOUR
                )
