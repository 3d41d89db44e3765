"""Lock and power against the generator gain for three magnetic couplings: the common picture of figures 12 to 14."""

from __future__ import annotations

from typing import Any

import numpy as np

from gyroctl.plant import Parameters
from gyroctl.statistics import bootstrap_mean, lock_probability
from gyroctl.studies.paper.ensembles import COUPLINGS, GAINS, VARIANTS, WP, Setup, lock_grid
from gyroctl.studies.style import (
    COUPLING_COLOURS,
    MARKERS,
    MUTED,
    PAPER_COLOUR,
    Drawing,
    band,
    gain,
    label,
    percent,
    runs_note,
    sea_name,
    sheet,
)

HEADINGS = {"corrected": "Lock kept, corrected plant", "paper": "Lock kept, as printed"}


def lock_curves(setup: Setup, number: int, gamma: float, marked: dict[float, str]) -> Drawing:
    """Draw mean power and the share of realisations that kept lock, for both presets.

    Parameters
    ----------
    setup : Setup
        Realisations.
    number : int
        Number of the figure.
    gamma : float
        Peak enhancement of the sea.
    marked : dict
        Generator gains that the paper speaks of [Nms], each with a word on what it says.
    """
    title = f"Figure {number}: generator gain and magnetic coupling, {sea_name(gamma)}"
    said = "; ".join(f"{words} at {gain(cg)}" for cg, words in marked.items())
    note = (
        f"{runs_note(len(setup.seeds), setup.duration, 'constant cc and cg')}\n"
        f"grey dashes: lock without slip, cg (N ωp)²; red dashes, the paper: {said}"
    )
    figure, axes = sheet(1, 3, (12.0, 4.3), title, note)
    gains = np.array(GAINS[gamma])
    scale = 1e4
    table: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    for variant, panel in zip(VARIANTS, axes[1:], strict=True):
        label(panel, HEADINGS[variant], "cg [$10^{-4}$ Nms]", "")
        grid = lock_grid(setup, variant, gamma)
        for cc in COUPLINGS:
            cases = [grid[cc, cg] for cg in GAINS[gamma]]
            share = np.array([lock_probability(case.locked)[:3] for case in cases])
            power = np.array([bootstrap_mean(case.power)[:3] for case in cases])
            look: dict[str, Any] = {"color": COUPLING_COLOURS[cc], "marker": MARKERS[cc], "ms": 4.5}
            panel.plot(scale * gains, share[:, 0], label=f"cc = {cc}", **look)
            band(panel, scale * gains, share[:, 1], share[:, 2], COUPLING_COLOURS[cc], 0.13)
            if variant == "corrected":
                axes[0].plot(scale * gains, power[:, 0], **look)
                band(axes[0], scale * gains, power[:, 1], power[:, 2], COUPLING_COLOURS[cc], 0.13)
            for case, p, w in zip(cases, share, power, strict=True):
                held = float(case.power[case.locked].mean()) if case.locked.any() else float("nan")
                row = (
                    variant,
                    cc,
                    case.cg,
                    case.locked.size,
                    *p,
                    *w,
                    held,
                    float(case.wave_input.mean()),
                    float(np.nanmedian(case.loss_time)) if not case.locked.all() else float("nan"),
                    float(case.phi1_p98.mean()),
                    float(case.phi3_p98.mean()),
                )
                for name, value in zip(COLUMNS, row, strict=True):
                    table[name].append(value)
        for cg in marked:
            panel.axvline(scale * cg, color=PAPER_COLOUR, lw=0.9, ls="--")
        panel.axhline(0.5, color=MUTED, lw=0.7, ls=(0, (1, 2)))
        percent(panel)
    label(axes[0], "Mean power over all realisations", "cg [$10^{-4}$ Nms]", "power [W]")
    fine = np.linspace(0.0, gains[-1], 50)
    top = axes[0].get_ylim()[1]
    axes[0].plot(scale * fine, fine * (Parameters().N * WP) ** 2, color=MUTED, lw=0.9, ls="--")
    axes[0].set_ylim(0.0, 1.2 * top)
    for panel in axes:
        panel.set_xlim(0.0, 1.04 * scale * gains[-1])
    axes[2].legend(loc="upper right")
    return Drawing(figure, {"": table})


COLUMNS = (
    "variant",
    "cc_nms",
    "cg_nms",
    "realisations",
    "lock_share",
    "lock_low",
    "lock_high",
    "mean_power_w",
    "power_low_w",
    "power_high_w",
    "power_when_locked_w",
    "wave_input_w",
    "median_loss_time_s",
    "phi1_p98_rad",
    "phi3_p98_rad",
)
"""Columns of the data, one row for each preset and pair."""
