"""Laws beside one another: power, its smoothness, and whether they stayed in lock, run by run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.errors import InputError
from gyroctl.palette import MUTED, law_styles
from gyroctl.plots.style import label, listed, sheet, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NEEDED = ("mean_power", "power_cv", "locked", "phi1_p98", "phi3_p98")


def comparison_figure(ds: Any) -> Figure:
    """Draw a comparison: a row for each law, a dot for each realisation, a bar at their mean.

    Parameters
    ----------
    ds : xarray.Dataset
        From `gyroctl.compare`.

    Raises
    ------
    InputError
        For variables or dimensions that are missing.
    """
    missing = [name for name in NEEDED if name not in ds.variables]
    missing += [name for name in ("law", "realisation") if name not in ds.dims]
    if missing:
        mend = "Give the dataset of gyroctl.compare with all its variables, laws and realisations"
        raise InputError("dataset", missing[0], "is not in it", mend)
    laws = [str(name) for name in ds["law"].values]
    looks = law_styles(laws)
    runs = int(ds.sizes["realisation"])
    duration = float(ds.attrs.get("duration", np.nan))
    note = f"{ds.attrs.get('plant', '')}; {runs} realisations of {duration:g} s; bar: mean"
    size = (11.5, 1.6 + 0.42 * len(laws))
    with styled(formulas=False):
        widths = (1.4, 1.0, 1.0, 1.0)
        figure, axes = sheet(1, 4, size, "Laws on identical waves", note, sharey=True, width_ratios=widths)
        _dots(axes[0], ds, "mean_power", laws, looks)
        label(axes[0], "Power", "mean power [W]", "")
        _dots(axes[1], ds, "power_cv", laws, looks)
        label(axes[1], "Smoothness", "standard deviation over mean [1]", "")
        _dots(axes[2], ds, "phi1_p98", laws, looks)
        limit = ds.attrs.get("motion_limit")
        if limit is not None:
            axes[2].axvline(float(limit), color=MUTED, lw=0.9, ls="--")
        label(axes[2], "Motion", "98 % of φ1 [rad]", "")
        for row, name in enumerate(laws):
            share = 100.0 * float(np.mean(np.asarray(ds["locked"].sel(law=name).values, dtype=np.float64)))
            axes[3].barh(row, share, color=looks[name].colour, height=0.55)
        axes[3].set_xlim(0.0, 104.0)
        label(axes[3], "Lock", "runs in lock [%]", "")
        listed(axes[0], laws)
    return figure


def _dots(axes: Any, ds: Any, variable: str, laws: list[str], looks: Any) -> None:
    for row, name in enumerate(laws):
        values = np.asarray(ds[variable].sel(law=name).values, dtype=np.float64)
        values = values[np.isfinite(values)]
        spread = row + 0.12 * np.cos(2.4 * np.arange(values.size))  # beside one another, the same in every picture
        axes.plot(values, spread, looks[name].marker, color=looks[name].colour, ms=3.6, alpha=0.55, mew=0.0)
        if values.size:
            axes.plot([values.mean()] * 2, [row - 0.3, row + 0.3], color=looks[name].colour, lw=2.4)
    low, high = axes.get_xlim()
    axes.set_xlim(min(0.0, low), high + 0.04 * (high - min(0.0, low)))
