"""The figure: one start, time to lock, and the energy account."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.palette import law_styles
from gyroctl.studies.style import INK, MUTED, RING_SPEED, band, label, percent, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gyroctl.studies.startup.runs import Case


def draw(rest: Sequence[Case], loss: Sequence[Case], note: str) -> Figure:
    """Draw both ensembles."""
    figure, axes = sheet(2, 2, (11.0, 7.4), "Start from rest, and re-lock after a forced loss", note)
    first, first_law = rest[0].series, rest[0].law
    styles = law_styles([case.law for case in (*rest, *loss)])
    early = first["time_s"] <= 300.0
    axes[0].plot(
        first["time_s"][early], first["ring_speed"][early], lw=0.8, color=styles[first_law].colour, label="ring"
    )
    scaled = first["flywheel_speed"][early] / (0.203 / 0.009)
    axes[0].plot(first["time_s"][early], scaled, color=INK, label="flywheel / N")
    axes[0].axhline(3.14, color=MUTED, lw=0.8, ls="--")
    axes[0].legend(loc="lower right")
    label(axes[0], f"One start ({rest[0].law})", "time [s]", RING_SPEED)
    label(axes[1], "Net energy from rest: median, 5 to 95 %", "time [s]", "generator less motor [kJ]")
    label(axes[2], "From rest: locked for good (the same for every law)", "time from the start [s]", "runs")
    label(axes[3], "After the forced loss: locked again for good", "time from the end of the fault [s]", "runs")
    for case in rest:
        colour = styles[case.law].colour
        time, net = case.series["time_s"], case.series["net_energy_j"] / 1e3
        shown = time <= 800.0
        low, middle, high = np.quantile(net[:, shown], [0.05, 0.5, 0.95], axis=0)
        band(axes[1], time[shown], low, high, colour)
        axes[1].plot(time[shown], middle, color=colour, label=case.law)
        axes[2].step(*_share(case.columns["locked_after_s"]), where="post", color=colour, label=case.law)
    for case in loss:
        colour = styles[case.law].colour
        axes[3].step(*_share(case.columns["locked_after_s"]), where="post", color=colour, label=case.law)
    axes[1].axhline(0.0, color=INK, lw=0.9)
    axes[1].legend(loc="upper left")
    axes[2].legend(loc="upper left")
    axes[3].legend(loc="lower right")
    for panel in axes[2:]:
        percent(panel)
    return figure


def _share(times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times in order and the share of runs that got there by then."""
    reached = np.sort(times[np.isfinite(times)])
    return np.concatenate([[0.0], reached]), np.arange(reached.size + 1) / times.size
