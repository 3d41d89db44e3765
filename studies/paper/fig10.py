"""Figure 10: the device in lock, gamma 5, cc 0.052 Nms, cg 3.5e-4 Nms.

The paper's captions were not available: the content follows its statement that this pair holds lock and gives 1.6 to
2.0 W. Where the paper has one realisation, the shaded band holds 90 % of ours at each instant.
"""

from __future__ import annotations

import numpy as np

from gyroctl.studies.paper.drawing import Drawing, gain, remark
from gyroctl.studies.paper.ensembles import BLEND, WP, Setup, lock_grid
from gyroctl.studies.paper.time_series import time_series
from gyroctl.studies.style import BAND_COLOUR, MUTED, PAPER_COLOUR, RING_SPEED, band, label, sea_name, sheet

GAMMA, CC, CG = 5.0, 0.052, 3.5e-4
PAPER_POWER = (1.6, 2.0)
"""Range of power that the paper states. [W]"""

WINDOW = 60.0
"""Stretch of the float's motion that is shown. [s]"""


def draw(setup: Setup) -> Drawing:
    """Draw the figure."""
    runs = time_series(setup, GAMMA, CC, CG)
    case = lock_grid(setup, "corrected", GAMMA)[CC, CG]
    one = runs.example(lost=False)
    note = (
        f"corrected plant; line: realisation {setup.seeds[one]}; bands: 5 to 95 % of {len(runs.phi1)} realisations at "
        f"each instant; histogram: {int(case.locked.sum())} of {case.locked.size} realisations that kept lock"
    )
    title = f"Figure 10: in lock, {sea_name(GAMMA)}, cc = {CC} Nms, cg = {gain(CG)} Nms"
    figure, axes = sheet(2, 2, (10.5, 6.6), title, note, width_ratios=(1.5, 1.0))

    label(axes[0], "Electrical power", "time [s]", "power [W]")
    thin = slice(None, None, 10)
    low, middle, high = np.quantile(runs.power, (0.05, 0.5, 0.95), axis=0)
    band(axes[0], runs.time[thin], low[thin], high[thin])
    axes[0].plot(runs.time[thin], runs.power[one, thin], color=BAND_COLOUR, lw=0.9)
    axes[0].set_ylim(0.0, 1.15 * float(np.max(high)))
    for edge in PAPER_POWER:
        axes[0].axhline(edge, color=PAPER_COLOUR, lw=0.9, ls="--")
    remark(axes[0], 0.985, 0.06, "dashed: range stated by the paper", PAPER_COLOUR, ha="right")

    label(axes[1], "Mean power of the realisations that kept lock", "mean power [W]", "realisations")
    held = case.power[case.locked]
    if held.size:
        edges = [*np.linspace(min(1.55, held.min()), max(2.05, held.max()), 31)]
        axes[1].hist(held, edges, color=BAND_COLOUR, alpha=0.75, edgecolor="white", lw=0.6)
    axes[1].axvspan(*PAPER_POWER, color=PAPER_COLOUR, alpha=0.08, lw=0)
    for edge in PAPER_POWER:
        axes[1].axvline(edge, color=PAPER_COLOUR, lw=0.9, ls="--")
    axes[1].locator_params(axis="y", integer=True)

    label(axes[2], "Ring speed, mean of the past 10 s", "time [s]", RING_SPEED)
    shown = runs.time >= 10.0
    low_speed, _, high_speed = np.nanquantile(runs.ring_speed_10s[:, shown], (0.05, 0.5, 0.95), axis=0)
    band(axes[2], runs.time[shown][thin], low_speed[thin], high_speed[thin])
    axes[2].plot(runs.time[shown][thin], runs.ring_speed_10s[one, shown][thin], color=BAND_COLOUR, lw=0.9)
    for level in (WP, 0.5 * WP):
        axes[2].axhline(level, color=MUTED, lw=0.8, ls="--")
    words = "dashed: peak frequency, and half of it, where lock counts as lost"
    remark(axes[2], 0.985, 0.06, words, MUTED, ha="right")
    axes[2].set_ylim(0.0, 1.35 * WP)

    label(axes[3], "Motion of the float", "time [s]", "[rad]")
    middle_time = max(BLEND, 0.5 * runs.time[-1])
    part = (runs.time >= middle_time) & (runs.time <= middle_time + WINDOW)
    motion = np.stack([runs.phi1[one, part], runs.phi3[one, part]])
    for angle, colour, words in zip(motion, ("#0072B2", "#D55E00"), ("φ1, horizontal", "φ3, vertical"), strict=True):
        axes[3].plot(runs.time[part], angle, color=colour, label=words)
    axes[3].legend(loc="upper right", ncols=2)
    top = 1.5 * float(np.max(np.abs(motion)))
    axes[3].set_ylim(-top, top)

    series = {
        "time_s": runs.time,
        "power_w": runs.power[one],
        "power_p5_w": low,
        "power_median_w": middle,
        "power_p95_w": high,
        "ring_speed_rad_s": runs.ring_speed[one],
        "flywheel_speed_rad_s": runs.flywheel_speed[one],
        "phi1_rad": runs.phi1[one],
        "phi3_rad": runs.phi3[one],
    }
    table = {
        "seed": np.array(setup.seeds),
        "locked": case.locked.astype(int),
        "loss_time_s": case.loss_time,
        "mean_power_w": case.power,
        "wave_input_w": case.wave_input,
        "phi1_p98_rad": case.phi1_p98,
        "phi3_p98_rad": case.phi3_p98,
    }
    return Drawing(figure, {"": series, "realisations": table})
