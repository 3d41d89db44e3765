"""Pictures of one operating point: multipliers in the unit circle, and the harmonic Nyquist plot with the disk."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.loop_margins.margins import ChannelMargins, open_loop
from gyroctl.plots.orbit import MODES as COLOURS
from gyroctl.studies.style import INK, MUTED, PAPER_COLOUR, colour_of, label, listed, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gyroctl.linearisation import PeriodicOrbit
    from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit
    from gyroctl.studies.margins.measures import LoopAnswer

PANELS = 3
"""Largest number of channels in the Nyquist plot: those with the smallest disk."""


def multipliers(orbit: PeriodicOrbit, loop: LoopOrbit | None, name: str, point: str) -> Figure:
    """Draw the multipliers of orbit and loop in the unit circle, and how long each mode of the orbit takes to decay.

    Dots are those of the constant controls, crosses those of the loop with the law of that `name`, "law NAME", about
    its own orbit; the note says where it has none. Without a law the name is empty.
    """
    drawn = loop is not None and bool(loop.multipliers.size)
    note = f"{point}; dots: the orbit of the constant controls, {orbit.status}; "
    if name:
        own = f"crosses: the loop with the {name} about its own orbit, {loop.status}" if drawn and loop else ""
        note += f"{own or f'none of the loop with the {name}, of which no orbit of one cycle per wave is known'}; "
    note += f"multipliers over one wave period of {orbit.period:.3f} s"
    title = "Floquet multipliers: constant controls" + (f" and {name}" if drawn else "")
    figure, axes = sheet(1, 2, (10.5, 5.0), title, note, width_ratios=(1.15, 1.0))
    circle = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 361))
    axes[0].plot(circle.real, circle.imag, color=INK, lw=1.0)
    for radius in (0.25, 0.5, 0.75):
        axes[0].plot(radius * circle.real, radius * circle.imag, color=MUTED, lw=0.5, ls=":")
    if drawn and loop is not None:
        look: dict[str, Any] = {"color": colour_of(name), "ms": 7, "mew": 1.6, "label": f"with the {name}"}
        axes[0].plot(loop.multipliers.real, loop.multipliers.imag, "x", **look)
    names = [mode.name for mode in orbit.modes]
    for i, mode in enumerate(orbit.modes):
        pair = np.array([mode.multiplier, mode.multiplier.conjugate()])
        words = None if mode.name in names[:i] else mode.name
        axes[0].plot(pair.real, pair.imag, "o", color=COLOURS[mode.name], ms=7, mec="white", label=words)
    label(axes[0], "Inside the circle: decays", "real part", "imaginary part")
    axes[0].set_aspect("equal")
    every = np.concatenate([orbit.multipliers, loop.multipliers if loop is not None else []])
    reach = 1.08 * max(1.0, float(np.max(np.abs(every))))
    axes[0].set_xlim(-reach, reach)
    axes[0].set_ylim(-reach, reach)
    axes[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    _decays(axes[1], orbit)
    return figure


def nyquist(answer: LoopAnswer, name: str, point: str) -> Figure | None:
    """Draw the eigenvalues of the lifted loop transfer with the disk; None where the law feeds nothing back."""
    weak = [(channel, found) for channel, found in answer.weakest() if found.disk < 1.999][:PANELS]
    if answer.loop is None or not weak:
        return None
    note = (
        f"{point}; eigenvalues of the lifted loop transfer as z goes round the unit circle; "
        "the loop is stable while none goes round -1\n"
        "red: the disk that the disk margin keeps free, with its guaranteed gains on the real axis; it allows "
        "another gain in each sample, so that the loci need not touch it"
    )
    title = f"Harmonic Nyquist plot, {name}"
    figure, axes = sheet(1, len(weak), (4.3 * len(weak) + 0.6, 4.9), title, note)
    for panel, (channel, found) in zip(axes, weak, strict=True):
        _nyquist_panel(panel, answer.loop, channel, found, colour_of(name))
    reach = max(panel.get_xlim()[1] for panel in axes)  # one scale: the disks are compared
    for panel in axes:
        panel.set_xlim(-reach, reach)
        panel.set_ylim(-reach, reach)
    return figure


def _nyquist_panel(panel: Any, loop: LoopOrbit, channel: str, found: ChannelMargins, colour: str) -> None:
    _, loci = open_loop(loop, (channel,)).nyquist(400)
    low, high = found.guaranteed_gain
    centre, radius = -0.5 * (low + high), 0.5 * (high - low)
    circle = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 361))
    panel.fill(centre + radius * circle.real, radius * circle.imag, color=PAPER_COLOUR, alpha=0.16, lw=0)
    panel.plot(centre + radius * circle.real, radius * circle.imag, color=PAPER_COLOUR, lw=1.0)
    panel.plot(circle.real, circle.imag, color=MUTED, lw=0.6, ls=":")
    both = np.concatenate([loci, np.conj(loci)])  # the order of the eigenvalues may change: points, not lines
    panel.plot(both.real.ravel(), both.imag.ravel(), ".", color=colour, ms=2.4)
    panel.plot([-1.0], [0.0], "+", color=INK, ms=11, mew=1.8)
    reach = max(1.6, 1.08 * min(max(high, float(np.max(np.abs(loci)))), 6.0))
    panel.set_xlim(-reach, reach)
    panel.set_ylim(-reach, reach)
    panel.set_aspect("equal")
    upper = "no limit" if math.isinf(found.gain[1]) else f"{found.gain[1]:.3g}"
    label(panel, f"{channel}: alpha {found.disk:.2f}, gain up to {upper}", "real part", "imaginary part")


def _decays(panel: Any, orbit: PeriodicOrbit) -> None:
    modes = orbit.modes
    times = [abs(mode.decay_time) for mode in modes]
    rows = range(len(modes))
    panel.barh(rows, times, color=[COLOURS[mode.name] for mode in modes], height=0.62)
    panel.set_xscale("log")
    listed(panel, [mode.name for mode in modes])
    panel.set_xlim(0.5 * min(times), 12.0 * max(times))
    for row, mode, time in zip(rows, modes, times, strict=True):
        grows = "grows, " if mode.rate > 0.0 else ""
        cycle = f", period {mode.period:.3g} s" if math.isfinite(mode.period) else ""
        panel.text(1.1 * time, row, f"{grows}{time:.3g} s{cycle}", va="center", fontsize=8.5, color=MUTED)
    label(panel, "Constant controls: time to fall by e", "time [s]", "")
