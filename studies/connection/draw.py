"""The figure: lock over the gain with and without the coupling, and the power of each device at its best."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.studies.style import GAMMA_COLOURS, INK, MUTED, band, label, percent, sea_name, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gyroctl.studies.connection.runs import Answer, AtBest, SameGain

MAGNETIC, RIGID = "with the coupling", "rigidly geared"
LOOKS = {MAGNETIC: ("#0072B2", "o", "-"), RIGID: ("#7A828C", "s", "--")}
"""Colour, marker and line of each device."""


def draw(answer: Answer) -> Figure:
    """Draw both halves of the answer: a column for each peak enhancement, the middle height above.

    Parameters
    ----------
    answer : Answer
        From `compare_connections`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    middle = sorted(answer.heights)[len(answer.heights) // 2]
    runs = f"{len(answer.seeds)} realisations of {answer.duration:g} s, the same for both devices"
    note = (
        f"Above: Hs {middle:g} m, runs that hold lock. Below: mean power, each device with the best constant controls "
        "that a search found for it on other realisations; filled where the difference can be told. "
        f"{runs}; intervals are 95 %"
    )
    columns = len(answer.gammas)
    size = (4.0 * max(columns, 2) + 1.6, 6.8)
    figure, axes = sheet(2, columns, size, "Does the magnetic coupling help?", note, sharey="row")
    for column, gamma in enumerate(answer.gammas):
        above, below = axes[column], axes[columns + column]
        _lock(above, [case for case in answer.same_gain if case.gamma == gamma and case.hs == middle])
        _power(below, [case for case in answer.at_best if case.gamma == gamma])
        above.set_title(sea_name(gamma), color=GAMMA_COLOURS.get(gamma, INK))
        if column == 0:
            above.set_ylabel("runs that hold lock")
            below.set_ylabel("mean power [W]")
            figure.legend(*above.get_legend_handles_labels(), loc="outside right upper")
    lowest = min(one.power.low for case in answer.at_best for one in (case.magnetic, case.rigid))
    for panel in axes[columns:]:  # below nothing where a device drains its flywheel
        panel.set_ylim(bottom=min(1.2 * lowest, -0.08 * panel.get_ylim()[1]) if lowest < 0.0 else 0.0)
        panel.axhline(0.0, color=INK, lw=0.9)
    return figure


def _lock(panel: Axes, cases: Sequence[SameGain]) -> None:
    gains = 1e4 * np.array([case.cg for case in cases])
    for name, shares in ((MAGNETIC, [c.magnetic for c in cases]), (RIGID, [c.rigid for c in cases])):
        colour, marker, line = LOOKS[name]
        panel.plot(gains, [s.value for s in shares], marker=marker, ls=line, ms=5, color=colour, label=name)
        band(panel, gains, [s.low for s in shares], [s.high for s in shares], colour, 0.15)
    panel.set_xscale("log")
    ticks = [gain for gain in (1.0, 2.0, 5.0, 10.0, 20.0) if gains.min() <= gain <= gains.max()]
    panel.set_xticks(ticks, [f"{gain:g}" for gain in ticks])
    panel.minorticks_off()
    label(panel, "", "cg [1e-4 Nms]", "")
    percent(panel)


def _power(panel: Axes, cases: Sequence[AtBest]) -> None:
    apart = 0.004 if len(cases) < 2 else 0.08 * min(abs(np.diff(sorted(case.hs for case in cases))))
    for name, sign in ((MAGNETIC, -1.0), (RIGID, 1.0)):
        colour, marker, _ = LOOKS[name]
        for case in cases:
            found = (case.magnetic if name == MAGNETIC else case.rigid).power
            told = case.words in ("more", "less")
            arms = np.nan_to_num([[found.value - found.low], [found.high - found.value]])
            look: dict[str, Any] = {
                "color": colour,
                "marker": marker,
                "ms": 7,
                "mew": 1.4,
                "mfc": colour if told else "white",
            }
            panel.errorbar(case.hs + sign * apart, found.value, yerr=arms, lw=0, elinewidth=1.2, **look)
    panel.set_xticks([case.hs for case in cases], [f"{case.hs:g}" for case in cases])
    label(panel, "", "Hs [m]", "")
    panel.tick_params(axis="x", labelcolor=MUTED)
