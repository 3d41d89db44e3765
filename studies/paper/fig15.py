"""Figure 15: what each sea gives, and what it allows.

The paper's captions were not available: the content follows its statement on the mean wave input of about 16.7 W, and
sets the powers that it states for the three seas (1.6 to 2.0 W, 3.5 W, 0.62 W) beside the best pair that holds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gyroctl.statistics import bootstrap_mean, lock_probability
from gyroctl.studies.paper.drawing import Drawing, columns, gain, remark, with_interval
from gyroctl.studies.paper.ensembles import VARIANTS, Case, Setup, lock_grid
from gyroctl.studies.style import GAMMA_COLOURS, INK, MUTED, PAPER_COLOUR, label, percent, sea_name, sheet

PAPER_INPUT = 16.7
"""Mean wave input that the paper states. [W]"""

PAPER_POWER = {1.0: (0.62, 0.62), 5.0: (1.6, 2.0), 50.0: (3.5, 3.5)}
"""Power that the paper states by gamma, lowest and highest. [W]"""

REFERENCE = {1.0: (0.104, 1.5e-4), 5.0: (0.052, 3.5e-4), 50.0: (0.052, 7.5e-4)}
"""Pair whose wave input is shown: the one that the paper says to hold. [Nms]"""

BEHIND = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
"""Keeps words legible on a line."""

ENOUGH = 0.9
"""Share of realisations that must keep lock for a pair to count as one that holds."""


def best_pair(grid: dict[tuple[float, float], Case]) -> Case | None:
    """Pair of highest mean power among those that keep lock in 90 % of the realisations; None where there is none."""
    holding = [case for case in grid.values() if case.locked.mean() >= ENOUGH]
    return max(holding, key=lambda case: float(case.power.mean()), default=None)


def draw(setup: Setup) -> Drawing:
    """Draw the figure."""
    title, note = "Figure 15: what each sea gives and allows", setup.note("constant cc and cg")
    figure, axes = sheet(1, 3, (12.0, 4.3), title, note, width_ratios=(1.0, 1.45, 0.9))
    label(axes[0], "Wave input by realisation", "", "mean wave input [W]")
    label(axes[1], "Power of the best pair that holds (90 % keep lock)", "", "mean power [W]")
    label(axes[2], "Lock kept at the paper's pair", "", "")
    rows = []
    rng = np.random.default_rng(0)
    for place, (gamma, colour) in enumerate(GAMMA_COLOURS.items()):
        for offset, variant in zip((-0.17, 0.17), VARIANTS, strict=True):
            grid, x = lock_grid(setup, variant, gamma), place + offset
            reference, best = grid[REFERENCE[gamma]], best_pair(grid)
            face = colour if variant == "corrected" else "white"
            look: dict[str, Any] = {"color": colour, "mfc": face}
            scattered = x + rng.uniform(-0.07, 0.07, reference.wave_input.size)
            axes[0].plot(scattered, reference.wave_input, "o", ms=2.6, mew=0.5, alpha=0.5, **look)
            given, share = bootstrap_mean(reference.wave_input, zero_if_lost=False), lock_probability(reference.locked)
            axes[0].plot([x - 0.12, x + 0.12], [given.value] * 2, color=INK, lw=1.8)
            reach = [[share.value - share.low], [share.high - share.value]]
            axes[2].errorbar(x, share.value, reach, fmt="o", ms=6, **look)
            power = bootstrap_mean(best.power)[:3] if best else (np.nan,) * 3
            if best:
                axes[1].bar(x, power[0], 0.3, color=face, edgecolor=colour)
                words = f"cc {best.cc:g}\ncg {gain(best.cg)}"
                axes[1].text(x, power[0] + 0.08, words, ha="center", fontsize=7.5, color=MUTED, bbox=BEHIND)
            else:
                axes[1].text(x, 0.12, "none\nholds", color=MUTED, ha="center", va="bottom", fontsize=8.5)
            row = {"variant": variant, "gamma": gamma, **with_interval("wave_input_w", "wave_input", given, "_w")}
            row |= {"reference_cc_nms": reference.cc, "reference_cg_nms": reference.cg}
            row |= with_interval("best_power_w", "best_power", power, "_w")
            row |= {"best_cc_nms": best.cc if best else np.nan, "best_cg_nms": best.cg if best else np.nan}
            rows.append({**row, **with_interval("lock_share", "lock", share)})
        for stated in dict.fromkeys(PAPER_POWER[gamma]):
            axes[1].plot([place - 0.36, place + 0.36], [stated] * 2, color=PAPER_COLOUR, lw=1.2, ls="--")
    axes[0].axhline(PAPER_INPUT, color=PAPER_COLOUR, lw=1.2, ls="--")
    remark(axes[0], 0.98, 0.03, "dashed: stated by the paper; bar: mean", PAPER_COLOUR, fontsize=8.5, ha="right")
    axes[0].set_ylim(bottom=0.0)
    percent(axes[2])
    for panel in axes:
        panel.set_xticks(range(3), [sea_name(gamma) for gamma in GAMMA_COLOURS])
        panel.grid(False, axis="x")
        panel.set_xlim(-0.5, 2.5)
    axes[1].set_ylim(0.0, axes[1].get_ylim()[1] * 1.08)
    remark(axes[1], 0.02, 0.97, "filled: corrected plant\nopen: as printed", INK, fontsize=8.5, va="top")
    return Drawing(figure, {"": columns(rows)})
