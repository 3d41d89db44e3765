"""Figure 8: hydrodynamics of the float and the rational approximation of its radiation.

The paper's captions were not available: the content follows the statements of its numerical example. Here:
added moment of inertia, radiation damping, excitation, and how well P(s)/Q(s) of order (2,3) follows the radiation.
"""

from __future__ import annotations

import numpy as np

from gyroctl.hydrodynamics import shipped, shipped_fit
from gyroctl.hydrodynamics.radiation import LOW_FREQUENCY
from gyroctl.studies.paper.drawing import Drawing
from gyroctl.studies.paper.ensembles import WP, Setup
from gyroctl.studies.style import INK, MUTED, label, sheet

UPPER = 10.0
"""Highest frequency shown. [rad/s]"""

LOW = (0.7, 2.2)
"""Range of the detail around the free horizontal mode. [rad/s]"""

ROTATIONS = ("φ1, horizontal", "φ3, vertical")
COLOURS = ("#0072B2", "#D55E00")


def draw(setup: Setup) -> Drawing:
    """Draw the figure; it needs no runs."""
    hydro = shipped()
    omega = np.linspace(hydro.omega[0], UPPER, 400)
    shown = hydro.omega <= UPPER
    fits = {name: shipped_fit(name) for name in ("accurate", "paper")}
    note = "Capytaine with the geometry that reproduces Table 1; dots: tabulated, lines: passive fits of order (2,3)"
    figure, axes = sheet(2, 2, (10.5, 7.2), "Figure 8: hydrodynamics of the float and the radiation fit", note)

    quantities = ("A [kg m²]", "B [Nms/rad]", "B1 [Nms/rad]", "|He| [Nm per m]")
    titles = ("Added moment of inertia", "Radiation damping", "Damping of the free horizontal mode", "Excitation")
    for panel, title, quantity in zip(axes, titles, quantities, strict=True):
        label(panel, title, "ω [rad/s]", quantity)
    table: dict[str, np.ndarray] = {"omega_rad_s": omega}
    for j, colour in enumerate(COLOURS):
        axes[0].plot(hydro.omega[shown], hydro.added_mass[j, shown], "o", ms=3, color=colour, label=ROTATIONS[j])
        axes[1].plot(hydro.omega[shown], hydro.damping[j, shown], "o", ms=3, color=colour)
        axes[0].axhline(hydro.added_mass_inf[j], color=colour, lw=0.8, ls=(0, (1, 2)))
        for name, dash in (("accurate", "-"), ("paper", "--")):
            h = fits[name][j](omega)
            axes[0].plot(omega, hydro.added_mass_inf[j] + h.imag / omega, dash, color=colour, lw=1.3)
            axes[1].plot(omega, h.real, dash, color=colour, lw=1.3)
            table[f"added_inertia_{j * 2 + 1}_{name}_kg_m2"] = hydro.added_mass_inf[j] + h.imag / omega
            table[f"damping_{j * 2 + 1}_{name}_nms"] = h.real
        heading = int(np.argmin(np.abs(hydro.headings)))
        force = hydro.excitation[j, heading]
        axes[3].plot(hydro.omega[shown], np.abs(force[shown]), "-", color=colour)
        table[f"excitation_{j * 2 + 1}_nm_per_m"] = np.interp(omega, hydro.omega, np.abs(force))
        phase = np.unwrap(np.angle(force))
        table[f"excitation_{j * 2 + 1}_phase_deg"] = np.interp(omega, hydro.omega, np.rad2deg(phase))
        gap, at = (np.interp(WP, hydro.omega, values) for values in (np.rad2deg(phase), np.abs(force)))
        axes[3].plot(WP, at, "o", ms=4, color=colour)
        words = f"{ROTATIONS[j].split(',')[0]}: phase {gap:.0f}° at {WP} rad/s"
        axes[3].text(*((5.3, 1510.0), (3.5, 2050.0))[j], words, color=colour)
    axes[0].legend(loc="upper right")
    axes[0].text(UPPER, hydro.added_mass_inf[1] + 1.2, "A∞", ha="right", color=COLOURS[1], fontsize=9)
    axes[0].text(0.0, hydro.added_mass_inf[0] + 1.2, "A∞", ha="left", color=COLOURS[0], fontsize=9)

    near = (omega >= LOW[0]) & (omega <= LOW[1])
    known = (hydro.omega >= LOW[0]) & (hydro.omega <= LOW[1])
    axes[2].plot(hydro.omega[known], hydro.damping[0, known], "o", ms=4, color=COLOURS[0], label="tabulated")
    for name, dash, words in (("accurate", "-", "fit, low end weighted"), ("paper", "--", "fit, unweighted")):
        axes[2].plot(omega[near], fits[name][0](omega[near]).real, dash, color=COLOURS[0], label=words)
    axes[2].axvline(LOW_FREQUENCY, color=MUTED, lw=0.8)
    axes[2].text(LOW_FREQUENCY + 0.02, 0.03, "free horizontal mode", color=INK, fontsize=9)
    axes[2].set_ylim(0.0, 2.6)
    axes[2].legend(loc="upper left", bbox_to_anchor=(0.36, 1.0))
    return Drawing(figure, {"": table})
