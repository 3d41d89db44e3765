"""Which of the paper's forms decides over lock: presets, and between them one choice changed at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from gyroctl.devices import zhang2017
from gyroctl.statistics import lock_probability
from gyroctl.studies.paper.drawing import Drawing, columns, gain, with_interval
from gyroctl.studies.paper.ensembles import STATED, Setup, stated_cases
from gyroctl.studies.style import GAMMA_COLOURS, INK, MUTED, label, sea_name, sheet

DEVICES: dict[str, dict[str, Any]] = {
    "as printed": {"variant": "paper"},
    "  + complex excitation": {"variant": "paper", "excitation_phase": "complex"},
    "  + no double generator reaction": {"variant": "paper", "generator_reaction": False},
    "  + lever term": {"variant": "paper", "lever_gyroscopic": True},
    "  + accurate radiation fit": {"variant": "paper", "radiation": "accurate"},
    "  + hinge damping d1 = 2": {"variant": "paper", "d1": 2.0},
    "corrected, unweighted fit, d1 = 0": {"radiation": "paper", "d1": 0.0},
    "corrected, unweighted fit, d1 = 1": {"radiation": "paper", "d1": 1.0},
    "corrected, magnitude excitation": {"excitation_phase": "magnitude"},
    "corrected": {},
}
"""Changes that make each device, top to bottom."""


def draw(setup: Setup) -> Drawing:
    """Draw the share of realisations that kept lock for each device and case."""
    runs = {name: stated_cases(setup, zhang2017(**changes), name.strip()) for name, changes in DEVICES.items()}
    note = setup.note("constant cc and cg")
    figure, axes = sheet(1, len(STATED), (12.0, 4.6), "Which choice decides over lock?", note, sharey=True)
    place = np.arange(len(DEVICES))[::-1]
    rows: list[dict[str, Any]] = []
    for panel, (gamma, (cc, cg)) in zip(axes, STATED, strict=True):
        label(panel, f"{sea_name(gamma)}, cc {cc}, cg {gain(cg)}", "realisations that kept lock", "")
        colour = GAMMA_COLOURS[gamma]
        for y, name in zip(place, DEVICES, strict=True):
            case = runs[name][gamma, (cc, cg)]
            share = lock_probability(case.locked)
            panel.plot([share.low, share.high], [y, y], color=colour, lw=5, alpha=0.25, solid_capstyle="butt")
            panel.plot(share.value, y, "o", ms=5.5, color=colour)
            row = {"device": name.strip(), "gamma": gamma, "cc_nms": cc, "cg_nms": cg}
            row |= with_interval("lock_share", "lock", share)
            rows.append({**row, "mean_power_w": float(case.power.mean()), "phi1_p98_rad": float(case.phi1_p98.mean())})
        panel.axhline(3.5, color=MUTED, lw=0.7, ls=(0, (1, 2)))
        panel.set_xlim(-0.04, 1.04)
        panel.set_xticks([0.0, 0.5, 1.0], ["0 %", "50 %", "100 %"])
        panel.grid(False, axis="y")
    axes[0].set_yticks(place, list(DEVICES), ha="left")
    axes[0].tick_params(axis="y", pad=188, labelcolor=INK)
    for panel in axes:
        panel.tick_params(axis="y", length=0)
    return Drawing(figure, {"": columns(rows)})
