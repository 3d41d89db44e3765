"""Picture of the bound: every window, and how one of them was harvested."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.froude import growth
from gyroctl.palette import law_styles
from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, OMEGA_RATE
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.outcome import Outcome
from gyroctl.studies.style import INK, MUTED, PAPER_COLOUR, label, sea_name, sheet
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BOUND_LOOKS = {"smooth": ("*", "-", INK), "free": ("x", "--", MUTED)}


def picture(windows: Sequence[Outcome], sea: SeaState, duration: float, plant: Plant) -> Figure:
    """Draw harvests by window, and energy over time in the first, in the units of the device."""
    first, length = windows[0], plant.parameters.length_scale
    watts = growth("W", length)
    lag = first.cut.settings.actuators.cc_lag * plant.parameters.time_scale
    styles = law_styles(list(first.laws), "best_constant")
    note = (
        f"{sea_name(sea.gamma)}, Hs {sea.hs:g} m; windows of {duration:g} s, all runs from the same state; harvest: "
        f"generated and gained by the flywheel; best found: perfect foresight; {plant.name}, coupling lag "
        f"{1e3 * lag:g} ms, 98 % motion at most {first.cut.motion.phi1:.2f}, "
        f"{first.cut.motion.phi3:.2f} rad in the first window"
    )
    linear = first.caps()["cap_w"] is not None
    of_cap = "cap of the float, slip included" if linear else "cap of the linear float, no limit here"
    figure, axes = sheet(1, 2, (10.5, 4.4), "Bound and what the laws reach", note)
    seeds = [str(window.cut.waves.seed) for window in windows]
    place = np.arange(len(windows))
    left, right = axes
    for i, window in enumerate(windows):
        words = of_cap if i == 0 else None
        left.plot(
            [i - 0.3, i + 0.3],
            [window.cap_w * watts] * 2,
            "-" if linear else ":",
            color=PAPER_COLOUR,
            lw=2.0,
            label=words,
        )
    for name in first.bounds:
        marker, dash, colour = BOUND_LOOKS[name]
        words = f"best found, {name} power"
        values = [window.bounds[name].values["harvest_w"] * watts for window in windows]
        left.plot(place, values, marker, color=colour, ms=9, label=words)
        right.plot(*_curve(first, first.bounds[name].record, length), color=colour, label=words, ls=dash)
    for name, style in styles.items():
        values = [window.cut.worth(window.laws[name])["harvest_w"] * watts for window in windows]
        left.plot(place, values, style.marker, color=style.colour, label=name)
        right.plot(*_curve(first, first.laws[name], length), color=style.colour, label=name)
    left.set_xticks(place, seeds)
    left.set_xlim(-0.6, len(windows) - 0.4)
    left.set_ylim(bottom=min(0.0, left.get_ylim()[0]))
    label(left, "By window", "seed of the realisation", "harvest [W]")
    left.legend(loc="lower left")
    label(right, f"Energy over time, seed {seeds[0]}", "time [s]", "energy [J]")
    right.legend(loc="upper left")
    return figure


def _curve(of: Outcome, record: Record, length: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time [s], and energy generated and gained by the flywheel since the start [J]."""
    plant = of.cut.plant
    row = len(plant.labels) + LEDGER.index("generator")
    generated = record.states[:, row] - record.states[0, row]
    speed = record.states[:, OMEGA_RATE]
    time = record.period * np.arange(speed.size, dtype=np.float64)
    energy = generated + 0.5 * plant.parameters.J4 * (speed**2 - speed[0] ** 2)
    return time * growth("s", length), np.asarray(energy * growth("J", length))
