"""Figure 9: the seas, JONSWAP with gamma 1, 5 and 50, and the excitation moments they make.

The paper's captions were not available: the content follows the statements of its numerical example.
"""

from __future__ import annotations

import numpy as np

from gyroctl.devices import zhang2017
from gyroctl.studies.paper.drawing import Drawing
from gyroctl.studies.paper.ensembles import BLEND, HS, WP, Setup, sea
from gyroctl.studies.style import GAMMA_COLOURS, MUTED, label, sea_name, sheet
from gyroctl.waves import realise

WINDOW = (600.0, 720.0)
"""Stretch of time shown. [s]"""


def draw(setup: Setup) -> Drawing:
    """Draw the figure from one realisation for each sea."""
    plant = zhang2017()
    omega = np.linspace(1.0, 7.0, 601)
    force = np.abs(plant.excitation(omega))
    title = f"Figure 9: the seas, significant wave height {HS} m, peak frequency {WP} rad/s"
    note = f"JONSWAP (39)-(40); the same random phases (seed {setup.seeds[0]}) in all three seas"
    figure, axes = sheet(2, 2, (10.5, 7.0), title, note, width_ratios=(1.0, 1.4))
    label(axes[0], "Elevation spectrum", "ω [rad/s]", "S [m² s], logarithmic")
    label(axes[2], "Spectrum of the vertical moment", "ω [rad/s]", "|He3|² S [(Nm)² s], logarithmic")
    label(axes[1], "Elevation", "time [s]", "η [m], offset by sea")
    label(axes[3], "Moment about the horizontal axis", "time [s]", "Me3 [Nm], offset by sea")
    spectra: dict[str, np.ndarray] = {"omega_rad_s": omega}
    series: dict[str, np.ndarray] = {}
    for shift, (gamma, colour) in enumerate(GAMMA_COLOURS.items()):
        density = sea(gamma).spectrum(omega)
        waves = realise(plant, sea(gamma), setup.seeds[0], max(setup.duration, WINDOW[1]))
        shown = (waves.time >= WINDOW[0]) & (waves.time <= WINDOW[1])
        axes[0].semilogy(omega, density, color=colour, label=sea_name(gamma))
        axes[2].semilogy(omega, force[1] ** 2 * density, color=colour)
        axes[1].plot(waves.time[shown], waves.elevation[shown] + 0.5 * shift, color=colour, lw=1.1)
        axes[3].plot(waves.time[shown], waves.moments[1, shown] + 1000.0 * shift, color=colour, lw=1.1)
        axes[1].text(WINDOW[1] + 1, 0.5 * shift, sea_name(gamma), color=colour, va="center")
        axes[3].text(WINDOW[1] + 1, 1000.0 * shift, sea_name(gamma), color=colour, va="center")
        series["time_s"] = waves.time[shown]
        signals = {"elevation_m": waves.elevation, "me1_nm": waves.moments[0], "me3_nm": waves.moments[1]}
        for name, values in signals.items():
            series[f"gamma{gamma:g}_{name}"] = values[shown]
        spectra[f"gamma{gamma:g}_elevation_m2s"] = density
        for j in range(2):
            spectra[f"gamma{gamma:g}_me{2 * j + 1}_nm2s"] = force[j] ** 2 * density
    peak = float(np.max(sea(50.0).spectrum(omega)))
    axes[0].set_ylim(peak * 1e-5, peak * 3)
    axes[2].set_ylim(*(np.array([1e-5, 3.0]) * np.max(force[1] ** 2 * sea(50.0).spectrum(omega))))
    axes[0].legend(loc="upper right")
    for panel in (axes[1], axes[3]):
        panel.set_xlim(*WINDOW)
    for panel in (axes[0], axes[2]):
        panel.axvline(WP, color=MUTED, lw=0.8)
    assert WINDOW[0] > BLEND  # the stretch shown is irregular sea only
    return Drawing(figure, {"": spectra, "time_series": series})
