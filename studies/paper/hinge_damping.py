"""How much hinge damping lock needs: share of realisations that keep lock against d1, for the corrected plant.

The paper has no damping of the horizontal motion beyond radiation, and that is nearly nothing at 1.2 rad/s.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gyroctl.devices import zhang2017
from gyroctl.linearisation import lock_orbit
from gyroctl.statistics import lock_probability
from gyroctl.studies.paper.ensembles import HS, WP, Case, Pair, Setup, ensemble
from gyroctl.studies.style import (
    GAMMA_COLOURS,
    INK,
    MUTED,
    Drawing,
    band,
    gain,
    label,
    percent,
    runs_note,
    sea_name,
    sheet,
)
from gyroctl.waves import Regular

DAMPING = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
"""Hinge damping d1. [Nms/rad]"""

CASES: tuple[tuple[float, Pair], ...] = (
    (5.0, (0.052, 3.5e-4)),
    (5.0, (0.104, 3.5e-4)),
    (50.0, (0.052, 7.5e-4)),
    (1.0, (0.104, 1.5e-4)),
)
"""gamma and (cc, cg) [Nms]: pairs that the paper says to hold, and one with a larger cc."""

DEFAULT = 2.0
"""d1 of the corrected plant. [Nms/rad]"""


@lru_cache(maxsize=4)
def damping_runs(setup: Setup) -> dict[tuple[float, float, Pair], Case]:
    """Cases by (d1, gamma, pair)."""
    found = {}
    for d1 in DAMPING:
        plant = zhang2017(d1=d1)
        for gamma in dict.fromkeys(gamma for gamma, _ in CASES):
            pairs = [pair for g, pair in CASES if g == gamma]
            cases = ensemble(setup, plant, gamma, pairs, f"hinge damping {d1:g}, gamma {gamma:g}")
            found.update({(d1, gamma, pair): case for pair, case in cases.items()})
    return found


def draw(setup: Setup) -> Drawing:
    """Draw lock against hinge damping, and beside it the stability of the locked orbit in the regular wave."""
    runs = damping_runs(setup)
    note = runs_note(len(setup.seeds), setup.duration, "corrected plant, all but d1")
    figure, axes = sheet(1, 2, (10.5, 4.4), "How much hinge damping does lock need?", note)
    label(axes[0], "Irregular sea: realisations that kept lock", "hinge damping d1 [Nms/rad]", "")
    label(
        axes[1],
        "Equivalent regular wave: growth on the locked orbit",
        "hinge damping d1 [Nms/rad]",
        "growth rate ln|λ|/T [1/1000 s]",
    )
    d1 = np.array(DAMPING)
    table: dict[str, list[float]] = {name: [] for name in COLUMNS}
    wave = Regular(HS / np.sqrt(2.0), WP)
    for gamma, (cc, cg) in CASES:
        dash = "-" if cc == 0.052 or gamma == 1.0 else "--"
        share = np.array([lock_probability(runs[d, gamma, (cc, cg)].locked)[:3] for d in DAMPING])
        axes[0].plot(
            d1,
            share[:, 0],
            dash,
            marker="o",
            ms=4,
            color=GAMMA_COLOURS[gamma],
            label=f"{sea_name(gamma)}, cc {cc}, cg {gain(cg)}",
        )
        band(axes[0], d1, share[:, 1], share[:, 2], GAMMA_COLOURS[gamma], 0.12)
        orbits = [lock_orbit(zhang2017(d1=d), wave, cc, cg) for d in DAMPING]
        growth = [1000.0 * float(np.log(np.abs(o.multipliers[0]))) / o.period for o in orbits]
        axes[1].plot(d1, growth, dash, marker="o", ms=4, color=GAMMA_COLOURS[gamma])
        for d, estimate, rate in zip(DAMPING, share, growth, strict=True):
            case = runs[d, gamma, (cc, cg)]
            row = (d, gamma, cc, cg, *estimate, float(case.phi1_p98.mean()), float(case.power.mean()), rate)
            for name, value in zip(COLUMNS, row, strict=True):
                table[name].append(value)
    axes[1].axhline(0.0, color=INK, lw=0.9)
    axes[1].text(DAMPING[-1], 0.3, "above zero: φ1 grows", ha="right", color=MUTED, fontsize=9)
    for panel in axes:
        panel.axvline(DEFAULT, color=MUTED, lw=0.8, ls="--")
    axes[0].text(DEFAULT + 0.03, 0.02, "default", color=MUTED, fontsize=9)
    percent(axes[0])
    axes[1].legend(*axes[0].get_legend_handles_labels(), loc="lower left")
    return Drawing(figure, {"": table})


COLUMNS = (
    "d1_nms",
    "gamma",
    "cc_nms",
    "cg_nms",
    "lock_share",
    "lock_low",
    "lock_high",
    "phi1_p98_rad",
    "mean_power_w",
    "growth_per_1000_s",
)
