"""Which of the paper's forms decides over lock: presets, and between them one choice changed at a time."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from gyroctl.devices import zhang2017
from gyroctl.statistics import lock_probability
from gyroctl.studies.paper.ensembles import Case, Pair, Setup, ensemble
from gyroctl.studies.style import GAMMA_COLOURS, INK, MUTED, Drawing, gain, label, runs_note, sea_name, sheet

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

CASES: tuple[tuple[float, Pair], ...] = (
    (5.0, (0.052, 3.5e-4)),
    (5.0, (0.104, 3.5e-4)),
    (50.0, (0.052, 7.5e-4)),
    (1.0, (0.104, 1.5e-4)),
)
"""gamma and (cc, cg) [Nms]."""


@lru_cache(maxsize=4)
def choice_runs(setup: Setup) -> dict[tuple[str, float, Pair], Case]:
    """Cases by (device, gamma, pair)."""
    found = {}
    for name, changes in DEVICES.items():
        plant = zhang2017(**changes)
        for gamma in dict.fromkeys(gamma for gamma, _ in CASES):
            pairs = [pair for g, pair in CASES if g == gamma]
            cases = ensemble(setup, plant, gamma, pairs, f"{name.strip()}, gamma {gamma:g}")
            found.update({(name, gamma, pair): case for pair, case in cases.items()})
    return found


def draw(setup: Setup) -> Drawing:
    """Draw the share of realisations that kept lock for each device and case."""
    runs = choice_runs(setup)
    note = runs_note(len(setup.seeds), setup.duration, "constant cc and cg")
    figure, axes = sheet(1, len(CASES), (12.0, 4.6), "Which choice decides over lock?", note, sharey=True)
    place = np.arange(len(DEVICES))[::-1]
    table: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    for panel, (gamma, (cc, cg)) in zip(axes, CASES, strict=True):
        label(panel, f"{sea_name(gamma)}, cc {cc}, cg {gain(cg)}", "realisations that kept lock", "")
        for y, name in zip(place, DEVICES, strict=True):
            case = runs[name, gamma, (cc, cg)]
            share = lock_probability(case.locked)
            panel.plot(
                [share.low, share.high], [y, y], color=GAMMA_COLOURS[gamma], lw=5, alpha=0.25, solid_capstyle="butt"
            )
            panel.plot(share.value, y, "o", ms=5.5, color=GAMMA_COLOURS[gamma])
            row = (name.strip(), gamma, cc, cg, *share[:3], float(case.power.mean()), float(case.phi1_p98.mean()))
            for column, value in zip(COLUMNS, row, strict=True):
                table[column].append(value)
        panel.axhline(3.5, color=MUTED, lw=0.7, ls=(0, (1, 2)))
        panel.set_xlim(-0.04, 1.04)
        panel.set_xticks([0.0, 0.5, 1.0], ["0 %", "50 %", "100 %"])
        panel.grid(False, axis="y")
    axes[0].set_yticks(place, list(DEVICES), ha="left")
    axes[0].tick_params(axis="y", pad=188, labelcolor=INK)
    for panel in axes:
        panel.tick_params(axis="y", length=0)
    return Drawing(figure, {"": table})


COLUMNS = ("device", "gamma", "cc_nms", "cg_nms", "lock_share", "lock_low", "lock_high", "mean_power_w", "phi1_p98_rad")
