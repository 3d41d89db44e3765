"""How much hinge damping lock needs: share of realisations that keep lock against d1, for the corrected plant.

The paper has no damping of the horizontal motion beyond radiation, and that is nearly nothing at 1.2 rad/s.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gyroctl.devices import zhang2017
from gyroctl.linearisation import lock_orbit
from gyroctl.statistics import lock_probability
from gyroctl.studies.paper.drawing import Drawing, columns, gain, with_interval
from gyroctl.studies.paper.ensembles import HS, STATED, WP, Setup, stated_cases
from gyroctl.studies.style import GAMMA_COLOURS, INK, MUTED, band, label, percent, sea_name, sheet
from gyroctl.waves import Regular

DAMPING = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
"""Hinge damping d1. [Nms/rad]"""

DEFAULT = 2.0
"""d1 of the corrected plant. [Nms/rad]"""


def draw(setup: Setup) -> Drawing:
    """Draw lock against hinge damping, and beside it the stability of the locked orbit in the regular wave."""
    plants = {d: zhang2017(d1=d) for d in DAMPING}
    runs = {d: stated_cases(setup, plant, f"hinge damping {d:g}") for d, plant in plants.items()}
    note = setup.note("corrected plant, all but d1")
    figure, axes = sheet(1, 2, (10.5, 4.4), "How much hinge damping does lock need?", note)
    against = "hinge damping d1 [Nms/rad]"
    label(axes[0], "Irregular sea: realisations that kept lock", against, "")
    title = "Equivalent regular wave: growth on the locked orbit"
    label(axes[1], title, against, "growth rate ln|λ|/T [1/1000 s]")
    d1 = np.array(DAMPING)
    rows: list[dict[str, Any]] = []
    wave = Regular(HS / np.sqrt(2.0), WP)
    for gamma, (cc, cg) in STATED:
        cases = [runs[d][gamma, (cc, cg)] for d in DAMPING]
        share = np.array([lock_probability(case.locked)[:3] for case in cases])
        orbits = [lock_orbit(plant, wave, cc, cg) for plant in plants.values()]
        growth = [1000.0 * float(np.log(np.abs(o.multipliers[0]))) / o.period for o in orbits]
        colour = GAMMA_COLOURS[gamma]
        look: dict[str, Any] = {"ls": "-" if cc == 0.052 or gamma == 1.0 else "--", "marker": "o", "ms": 4}
        axes[0].plot(d1, share[:, 0], color=colour, label=f"{sea_name(gamma)}, cc {cc}, cg {gain(cg)}", **look)
        band(axes[0], d1, share[:, 1], share[:, 2], colour, 0.12)
        axes[1].plot(d1, growth, color=colour, **look)
        for d, case, estimate, rate in zip(DAMPING, cases, share, growth, strict=True):
            row = {"d1_nms": d, "gamma": gamma, "cc_nms": cc, "cg_nms": cg}
            row |= with_interval("lock_share", "lock", estimate)
            row |= {"phi1_p98_rad": float(case.phi1_p98.mean()), "mean_power_w": float(case.power.mean())}
            rows.append({**row, "growth_per_1000_s": rate})
    axes[1].axhline(0.0, color=INK, lw=0.9)
    axes[1].text(DAMPING[-1], 0.3, "above zero: φ1 grows", ha="right", color=MUTED, fontsize=9)
    for panel in axes:
        panel.axvline(DEFAULT, color=MUTED, lw=0.8, ls="--")
    axes[0].text(DEFAULT + 0.03, 0.02, "default", color=MUTED, fontsize=9)
    percent(axes[0])
    axes[1].legend(*axes[0].get_legend_handles_labels(), loc="lower left")
    return Drawing(figure, {"": columns(rows)})
