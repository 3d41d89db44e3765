"""A locked orbit over one wave, and its multipliers in the unit circle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.palette import INK, MUTED, WARNING
from gyroctl.plots.style import label, sheet, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 96
"""Instants of a wave."""

MODES = {
    "libration": "#0072B2",
    "horizontal": "#E08A00",
    "vertical": "#009E73",
    "slip": "#CC79A7",
    "radiation": "#7A8793",
}
"""Colours of the modes."""

RING, FLOAT1, FLOAT3 = "#0072B2", "#E08A00", "#009E73"


def orbit_figure(orbit: Any) -> Figure:
    """Draw the motion of ring and float over a wave, and the multipliers by the names of their modes."""
    states, labels = orbit.states(POINTS), orbit.plant.labels
    time = np.arange(POINTS + 1) * orbit.period / POINTS
    row = {name: np.append(states[:, i], states[0, i]) for i, name in enumerate(labels)}
    note = (
        f"{orbit.plant.name}; wave of height {orbit.wave.height:g} m at {orbit.wave.wp:g} rad/s; cc {orbit.cc:g}, "
        f"cg {orbit.cg:g} Nms; {orbit.status}, {orbit.power:.3g} W, {100 * orbit.lock_share:.0f} % of the capacity used"
    )
    with styled():
        title = "Locked orbit over one wave"
        figure, (ring, body, circle) = sheet(1, 3, (12.0, 4.0), title, note, width_ratios=(1.0, 1.0, 1.1))
        ring.plot(time, row["psi_rate"], color=RING)
        wave = orbit.sense * orbit.wave.wp
        ring.axhline(wave, color=MUTED, lw=0.9, ls="--")
        ring.annotate("wave", (time[-1], wave), color=MUTED, fontsize=8.5, ha="right", va="bottom")
        label(ring, "Ring", "time [s]", "ring speed ψ\N{PRIME} [rad/s]")
        body.plot(time, row["phi1"], color=FLOAT1, label="φ1")
        body.plot(time, row["phi3"], color=FLOAT3, ls="--", label="φ3")
        body.legend(loc="upper right")
        label(body, "Float", "time [s]", "angle [rad]")
        _multipliers(circle, orbit)
    return figure


def _multipliers(axes: Any, orbit: Any) -> None:
    angle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361))
    axes.plot(angle.real, angle.imag, color=INK, lw=1.0)
    drawn: set[str] = set()
    for mode in orbit.modes:
        pair = np.array([mode.multiplier, np.conj(mode.multiplier)])
        name = None if mode.name in drawn else mode.name
        drawn.add(mode.name)
        outside = WARNING if abs(mode.multiplier) >= 1.0 else "white"
        axes.plot(pair.real, pair.imag, "o", color=MODES.get(mode.name, MUTED), ms=7, mec=outside, label=name)
    axes.set_aspect("equal")
    reach = 1.08 * max(1.0, float(np.max(np.abs(orbit.multipliers))))
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    label(axes, "Multipliers over a wave", "real part [1]", "imaginary part [1]")
