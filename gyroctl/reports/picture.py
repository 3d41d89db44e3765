"""The picture for the README: the Pareto plot and a stretch of power in time, as a static image."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.reports import layout
from gyroctl.reports.evaluation import Evaluation, LawResult, evaluate
from gyroctl.reports.pareto import pareto_labels, pareto_range, plottable
from gyroctl.reports.theme import LIGHT, LOCK_SCALE, law_styles
from gyroctl.reports.verdict import judge, shown
from gyroctl.statistics import Estimate

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Liberation Sans", "Arial", "Helvetica", "DejaVu Sans"],
    "font.size": 10,
    "text.parse_math": False,  # names are text, whatever is in them
    "axes.edgecolor": LIGHT.axis,
    "axes.labelcolor": LIGHT.muted,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlecolor": LIGHT.ink,
    "grid.color": LIGHT.grid,
    "grid.linewidth": 0.8,
    "text.color": LIGHT.ink,
    "xtick.color": LIGHT.muted,
    "ytick.color": LIGHT.muted,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}
WINDOW = 120.0
"""Length of the stretch in time. [s]"""


def write_picture(source: xr.Dataset | str | Path, path: str | Path) -> Path:
    """Write a static picture of a comparison: power against power CV on the left, power in time on the right.

    Parameters
    ----------
    source : xarray.Dataset, str or Path
        Comparison, its results.nc, or the directory that holds it.
    path : str or Path
        Image file; the ending chooses the format (png, svg, pdf).

    Returns
    -------
    Path
        The written file.

    Raises
    ------
    InputError
        The source is missing or is no comparison.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    ds = layout.open_results(source)
    every = evaluate(ds)
    found = replace(every, laws=shown(every))
    ds = ds.sel(law=[name for name in layout.names(ds) if name in {law.name for law in found.laws}])
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE):
        # The object interface, not pyplot: no global state, no display, safe in any process.
        figure = Figure(figsize=(11.0, 4.3), layout="constrained")
        FigureCanvasAgg(figure)
        if layout.has_examples(ds):
            left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
            _pareto(left, ds, found)
            _power(right, ds, found)
        else:
            _pareto(figure.subplots(), ds, found)
        figure.savefig(target, dpi=180)
    return target


def _pareto(axes: Axes, ds: xr.Dataset, evaluation: Evaluation) -> None:
    from matplotlib.colors import LinearSegmentedColormap

    scale = LinearSegmentedColormap.from_list("lock", LOCK_SCALE)
    styles = law_styles(layout.names(ds), evaluation.reference)
    points = None
    laws = plottable(evaluation)
    right, top = pareto_range(laws)
    for law, side in zip(laws, pareto_labels(laws, right, top), strict=True):
        x, y = law.power_cv, law.power
        axes.errorbar(
            x.value, y.value, xerr=_arms(x), yerr=_arms(y), color=LIGHT.axis, linewidth=1.2, capsize=2.5, zorder=2
        )
        points = axes.scatter(
            x.value,
            y.value,
            c=[law.lock.value],
            cmap=scale,
            vmin=0,
            vmax=1,
            s=85,
            marker=styles[law.name].marker,
            edgecolors="white",
            linewidths=1.0,
            zorder=3,
        )
        axes.annotate(
            law.name,
            (x.value, y.value),
            xytext=(5 * side.across, 8 * side.up),
            textcoords="offset points",
            ha={-1: "right", 0: "center", 1: "left"}[side.across],
            va={-1: "top", 0: "center", 1: "bottom"}[side.up],
            fontsize=9.5,
            fontweight="normal" if law.name == evaluation.reference else "bold",
            zorder=4,
        )
    axes.set_xlim(0.0, right)
    axes.set_ylim(0.0, top)
    axes.set(xlabel="Coefficient of variation of power [1]", ylabel="Mean power [W]", title="Power against smoothness")
    if points is not None:
        bar = axes.figure.colorbar(points, ax=axes, label="P(lock) [1]", aspect=28, pad=0.02)
        bar.outline.set_visible(False)


def _power(axes: Axes, ds: xr.Dataset, evaluation: Evaluation) -> None:
    styles = law_styles(layout.names(ds), evaluation.reference)
    time = np.asarray(ds["time"].values, dtype=np.float64)
    start = max(float(time[0]), 0.5 * float(time[0] + time[-1]) - WINDOW / 2.0)
    stretch = (time >= start) & (time <= start + WINDOW)
    top = 0.0
    # Rough curves first, so that the smooth ones stay visible on top of them.
    for law in sorted(_few(evaluation), key=lambda law: -law.power_cv.value):
        power = ds["example_power"].sel(law=law.name).values[stretch]
        axes.plot(time[stretch], power, label=law.name, color=styles[law.name].colour, linewidth=1.5)
        top = max(top, float(np.nanmax(power)) if np.isfinite(power).any() else 0.0)
    axes.set_xlim(start, min(start + WINDOW, float(time[-1])))
    axes.set_ylim(0.0, 1.18 * top if top > 0.0 else 1.0)
    axes.set(
        xlabel="Time [s]",
        ylabel="Electrical power [W]",
        title=f"Electrical power in the same waves (seed {evaluation.seeds[0]})",
    )
    axes.legend(
        frameon=False, ncols=4, fontsize=9.5, loc="upper left", borderaxespad=0.2, columnspacing=1.4, handlelength=1.4
    )


def _few(evaluation: Evaluation) -> list[LawResult]:
    """At most four laws without an oracle: the winner, the reference, the smoothest, then the strongest."""
    causal = [law for law in evaluation.by_power if law.information != "oracle"] or list(evaluation.by_power)
    first = [judge(evaluation).winner, evaluation.reference, min(causal, key=lambda law: law.power_cv.value).name]
    order = {name: rank for rank, name in reversed(list(enumerate(first))) if name is not None}
    return sorted(causal, key=lambda law: order.get(law.name, len(first)))[:4]


def _arms(estimate: Estimate) -> list[list[float]] | None:
    value, low, high = estimate.value, estimate.low, estimate.high
    return [[value - low], [high - value]] if math.isfinite(low) and math.isfinite(high) else None
