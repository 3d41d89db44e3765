"""The figure of table `gauge`: power, smoothness and the error of the forecast over what is known of the waves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation.draw import note
from gyroctl.studies.style import GAMMA_COLOURS, label, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = tuple(GAMMA_COLOURS.values())


def draw_gauge(cases: Mapping[str, Sequence[Mapping[str, Any]]], asked: Mapping[str, Any]) -> Figure:
    """Draw the levels from left to right, a colour for each water."""
    figure, axes = sheet(1, 3, (14.0, 4.8), "What a wave gauge up-wave is worth", note(asked))
    for colour, (name, lines) in zip(COLOURS, cases.items(), strict=False):
        shown = [line for line in lines if line["level"] != "none"]
        places = np.arange(len(shown))
        _errors(axes[0], places, [line["power"] for line in shown], colour, name)
        _errors(axes[1], places, [line["cv"] for line in shown], colour, name)
        for style, error in zip(("-", "--", "-.", ":"), list(shown[0]["error"]), strict=False):
            found = [line["error"].get(error, 0.0) for line in shown]
            values = [value if value > 0.0 else np.nan for value in found]  # perfect preview is off the axis
            what = error.removeprefix("error of ")
            axes[2].plot(places, values, style, color=colour, marker="o", ms=3, lw=1.2, label=f"{name}, {what}")
        for axis in axes:
            axis.set_xticks(places, [line["level"] for line in shown], rotation=20, ha="right")
    axes[0].set_ylim(bottom=0.0)
    axes[1].set_ylim(bottom=0.0)
    axes[2].set_yscale("log")
    label(axes[0], "Mean power", "", "mean power [W]")
    label(axes[1], "Smoothness", "", "CV of power")
    label(axes[2], "Forecast", "", "mean square error / variance")
    axes[0].legend()
    axes[2].legend(fontsize=7)
    return figure


def _errors(axis: Axes, x: Any, estimates: Sequence[Estimate], colour: str, name: str) -> None:
    values = np.array([estimate.value for estimate in estimates])
    arms = np.array([(e.value - e.low, e.high - e.value) for e in estimates]).T
    axis.errorbar(x, values, yerr=np.nan_to_num(arms).clip(min=0.0), fmt="o-", color=colour, ms=5, lw=1.0, label=name)
