"""Lock and power against the generator gain for three magnetic couplings: the common picture of figures 12 to 14."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Parameters
from gyroctl.statistics import bootstrap_mean, lock_probability
from gyroctl.studies.paper.drawing import Drawing, columns, gain, with_interval
from gyroctl.studies.paper.ensembles import COUPLINGS, GAINS, VARIANTS, WP, Case, Setup, lock_grid
from gyroctl.studies.style import MUTED, PAPER_COLOUR, band, label, percent, sea_name, sheet

LOOKS: dict[float, dict[str, Any]] = {
    0.052: {"color": "#0072B2", "marker": "o", "ms": 4.5},
    0.104: {"color": "#E08A00", "marker": "s", "ms": 4.5},
    0.156: {"color": "#009E73", "marker": "D", "ms": 4.5},
}
"""By magnetic coupling cc. [Nms]"""

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
        f"{setup.note('constant cc and cg')}.\nGrey dashes: power of a lock without slip, cg (N ωp)². "
        f"Red dashes, the paper: {said}."
    )
    figure, axes = sheet(1, 3, (12.0, 4.3), title, note)
    gains = np.array(GAINS[gamma])
    scale = 1e4
    rows: list[dict[str, Any]] = []
    for variant, panel in zip(VARIANTS, axes[1:], strict=True):
        label(panel, HEADINGS[variant], "cg [$10^{-4}$ Nms]", "")
        grid = lock_grid(setup, variant, gamma)
        for cc in COUPLINGS:
            cases = [grid[cc, cg] for cg in GAINS[gamma]]
            share = np.array([lock_probability(case.locked)[:3] for case in cases])
            power = np.array([bootstrap_mean(case.power)[:3] for case in cases])
            panel.plot(scale * gains, share[:, 0], label=f"cc = {cc}", **LOOKS[cc])
            band(panel, scale * gains, share[:, 1], share[:, 2], LOOKS[cc]["color"], 0.13)
            if variant == "corrected":
                axes[0].plot(scale * gains, power[:, 0], **LOOKS[cc])
                band(axes[0], scale * gains, power[:, 1], power[:, 2], LOOKS[cc]["color"], 0.13)
            rows += [_row(variant, *found) for found in zip(cases, share, power, strict=True)]
        for cg in marked:
            panel.axvline(scale * cg, color=PAPER_COLOUR, lw=0.9, ls="--")
        panel.axhline(0.5, color=MUTED, lw=0.7, ls=(0, (1, 2)))
        percent(panel)
    label(axes[0], "Mean power of all runs, corrected plant", "cg [$10^{-4}$ Nms]", "power [W]")
    fine = np.linspace(0.0, gains[-1], 50)
    top = axes[0].get_ylim()[1]
    axes[0].plot(scale * fine, fine * (Parameters().N * WP) ** 2, color=MUTED, lw=0.9, ls="--")
    axes[0].set_ylim(0.0, 1.2 * top)
    for panel in axes:
        panel.set_xlim(0.0, 1.04 * scale * gains[-1])
    axes[2].legend(loc="upper right")
    return Drawing(figure, {"": columns(rows)})


def _row(variant: str, case: Case, share: NDArray[np.float64], power: NDArray[np.float64]) -> dict[str, Any]:
    """Row of the data: one preset and pair."""
    locked = case.locked
    return {
        "variant": variant,
        "cc_nms": case.cc,
        "cg_nms": case.cg,
        "realisations": locked.size,
        **with_interval("lock_share", "lock", share),
        **with_interval("mean_power_w", "power", power, "_w"),
        "power_when_locked_w": float(case.power[locked].mean()) if locked.any() else np.nan,
        "wave_input_w": float(case.wave_input.mean()),
        "median_loss_time_s": float(np.nanmedian(case.loss_time)) if not locked.all() else np.nan,
        "phi1_p98_rad": float(case.phi1_p98.mean()),
        "phi3_p98_rad": float(case.phi3_p98.mean()),
    }
