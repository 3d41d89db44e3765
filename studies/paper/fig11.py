"""Figure 11: loss of lock, gamma 5, cc 0.052 Nms, cg 1e-3 Nms.

The paper's captions were not available: the content follows its statement that this pair loses lock after about 400 s.
Where the paper has one realisation, the survival curve shows when lock was lost in all of ours, for both presets.
"""

from __future__ import annotations

import numpy as np

from gyroctl.statistics import lock_survival
from gyroctl.studies.paper.drawing import Drawing, gain
from gyroctl.studies.paper.ensembles import VARIANTS, WP, Setup, lock_grid
from gyroctl.studies.paper.time_series import time_series
from gyroctl.studies.style import BAND_COLOUR, MUTED, PAPER_COLOUR, RING_SPEED, label, percent, sea_name, sheet

GAMMA, CC, CG = 5.0, 0.052, 1e-3
PAPER_LOSS = 400.0
"""Time of the loss that the paper states. [s]"""

LOOKS = {"corrected": (BAND_COLOUR, "corrected plant"), "paper": ("#7A828C", "as printed")}


def draw(setup: Setup) -> Drawing:
    """Draw the figure."""
    runs = time_series(setup, GAMMA, CC, CG)
    one = runs.example(lost=True)
    note = (
        f"corrected plant where not said otherwise; strong line: realisation {setup.seeds[one]}; thin lines: the first "
        f"{len(runs.phi1)}; survival: Kaplan-Meier of {len(setup.seeds)} realisations with 95 % intervals"
    )
    title = f"Figure 11: loss of lock, {sea_name(GAMMA)}, cc = {CC} Nms, cg = {gain(CG)} Nms"
    figure, axes = sheet(1, 3, (12.0, 4.1), title, note, width_ratios=(1.25, 1.25, 1.0))

    label(axes[0], "Ring speed, mean of the past 10 s", "time [s]", RING_SPEED)
    label(axes[1], "Electrical power", "time [s]", "power [W]")
    thin = slice(100, None, 20)
    for signal, panel in ((runs.ring_speed_10s, axes[0]), (runs.power, axes[1])):
        panel.plot(runs.time[thin], signal[:, thin].T, color=BAND_COLOUR, lw=0.5, alpha=0.16)
        panel.plot(runs.time[thin], signal[one, thin], color=BAND_COLOUR, lw=1.3)
    axes[0].axhline(0.5 * WP, color=MUTED, lw=0.8, ls="--")
    axes[0].text(runs.time[-1], 0.5 * WP + 0.05, "loss of lock", color=MUTED, ha="right", va="bottom", fontsize=9)
    axes[1].set_ylim(bottom=0.0)

    label(axes[2], "Realisations still in lock", "time [s]", "")
    tables: dict[str, dict[str, np.ndarray]] = {
        "": {
            "time_s": runs.time,
            "ring_speed_10s_rad_s": runs.ring_speed_10s[one],
            "power_w": runs.power[one],
            "phi1_rad": runs.phi1[one],
            "phi3_rad": runs.phi3[one],
        }
    }
    losses: dict[str, np.ndarray] = {"seed": np.array(setup.seeds)}
    for variant in VARIANTS:
        case = lock_grid(setup, variant, GAMMA)[CC, CG]
        curve = lock_survival(case.loss_time, setup.duration)
        colour, words = LOOKS[variant]
        axes[2].step(curve.time, curve.probability, where="post", color=colour, label=words)
        axes[2].fill_between(curve.time, curve.low, curve.high, step="post", color=colour, alpha=0.15, lw=0)
        losses[f"{variant}_loss_time_s"] = case.loss_time
        tables[f"survival_{variant}"] = dict(zip(("time_s", "still_in_lock", "low", "high"), curve[:4], strict=True))
    axes[2].axvline(PAPER_LOSS, color=PAPER_COLOUR, lw=1.0, ls="--", label="paper: about 400 s")
    axes[2].set_xlim(0.0, setup.duration)
    axes[2].legend(loc="upper right")
    percent(axes[2])
    return Drawing(figure, {**tables, "losses": losses})
