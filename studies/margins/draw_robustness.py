"""Picture of what a lock withstands: headroom, basin stability, smallest shocks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.studies.margins.axes import gain_at
from gyroctl.studies.margins.measures import Margins
from gyroctl.studies.style import MUTED, band, colour_of, label, listed, percent, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOMS = {"cg": "cg up", "height": "height down", "frequency_down": "frequency down", "frequency_up": "frequency up"}
UNITS = {"phi1": "rad", "phi3": "rad", "psi": "rad"}


def robustness(cases: dict[str, Margins], point: str, length: float = 1.0) -> Figure:
    """Draw the margins beyond the linear of one or two cases by name, of a device `length` times as long as Table 1."""
    note = f"{point}; bars at full length with an arrow: no limit within the range tried; intervals are 95 %"
    figure, axes = sheet(1, 3, (13.0, 5.0), "What the lock withstands", note, width_ratios=(1.0, 0.9, 1.25))
    _headroom(axes[0], cases, length)
    _basin(axes[1], cases)
    _shocks(axes[2], cases)
    handles, names = axes[1].get_legend_handles_labels()
    axes[1].legend(handles, names, loc="lower left")
    return figure


def _headroom(panel: Any, cases: dict[str, Margins], length: float) -> None:
    width, gain = 0.7 / len(cases), gain_at(length)
    rooms = [room.decibel for margins in cases.values() for room in margins.headroom.values()]
    top = max(1.0, *(room for room in rooms if math.isfinite(room)))
    for c, (name, margins) in enumerate(cases.items()):
        for row, room in enumerate(margins.headroom[key] for key in ROOMS):
            at = row + (c - 0.5 * (len(cases) - 1)) * width
            free = not math.isfinite(room.decibel)
            length = 1.1 * top if free else room.decibel
            panel.barh(at, length, 0.9 * width, color=colour_of(name), alpha=0.35 if free else 1.0)
            limit = room.limit * (gain.scale if room.quantity == "cg" and not room.relative else 1.0)
            unit = {"cg": "$\\times$" if room.relative else gain.times, "height": "m", "wp": "rad/s"}[room.quantity]
            words = f" {room.decibel:.1f} dB, to {limit:.3g} {unit}" if not free else " no limit found \u2192"
            panel.text(0.0 if free else room.decibel, at, words, va="center", fontsize=8, color=MUTED)
    listed(panel, list(ROOMS.values()))
    panel.set_xlim(0.0, 1.75 * top)
    label(panel, "Headroom to the end of lock", "room [dB]", "")


def _basin(panel: Any, cases: dict[str, Margins]) -> None:
    for name, margins in cases.items():
        sizes = np.array(list(margins.basin))
        shares = list(margins.basin.values())
        panel.plot(sizes, [s.value for s in shares], "-o", color=colour_of(name), ms=5, label=name)
        band(panel, sizes, [s.low for s in shares], [s.high for s in shares], colour_of(name), 0.15)
    label(panel, "Basin: share that locks again", "size of the random disturbance", "")
    percent(panel)


def _shocks(panel: Any, cases: dict[str, Margins]) -> None:
    width = 0.7 / len(cases)
    states = list(dict.fromkeys(shock.state for margins in cases.values() for shock in margins.shocks))
    largest = {s.state: s.largest for margins in cases.values() for s in margins.shocks}
    for c, (name, margins) in enumerate(cases.items()):
        for shock in margins.shocks:
            at = states.index(shock.state) + (c - 0.5 * (len(cases) - 1)) * width
            free = math.isnan(shock.size)
            part = 1.0 if free else shock.size / shock.largest
            panel.barh(at, shock.sign * part, 0.9 * width, color=colour_of(name), alpha=0.22 if free else 1.0)
            if not free:
                side = "left" if shock.sign > 0 else "right"
                words = f"{shock.size:.3g}"
                panel.text(shock.sign * (part + 0.03), at, words, va="center", fontsize=8, color=MUTED, ha=side)
    panel.axvline(0.0, color=MUTED, lw=0.8)
    ticks = [f"{state}\n\u00b1{largest[state]:.3g} {UNITS.get(state, 'rad/s')}" for state in states]
    listed(panel, ticks, fontsize=8)
    panel.set_xlim(-1.3, 1.3)
    label(panel, "Smallest shock that breaks lock (pale: none does)", "part of the largest that was tried", "")
