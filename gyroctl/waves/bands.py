"""How much of a sea lies where the excitation of a device is not known."""

from __future__ import annotations

import numpy as np

from gyroctl.waves.components import Sea
from gyroctl.waves.directional import DirectionalSpectrum
from gyroctl.waves.excitation import Excited, band
from gyroctl.waves.grid import OMEGA_MAX
from gyroctl.waves.tabulated import TabulatedSpectrum

SAID = 0.01
"""Part of the variance from which on it is told. [-]"""


def outside_band(plant: Excited, sea: Sea) -> tuple[str, ...]:
    """Tell what of a tabulated sea lies below and above the frequencies at which the excitation is known.

    Parameters
    ----------
    plant : Plant
        Gives the excitation.
    sea : any sea of this package
        Others than spectra from a table have nothing to tell.

    Returns
    -------
    tuple of str
        One sentence for each side with at least 1 % of the variance.
    """
    still = getattr(sea, "sea", sea)
    if isinstance(still, DirectionalSpectrum):
        still = still.still
    if not isinstance(still, TabulatedSpectrum):
        return ()
    low, high = band(plant.excitation)
    high = min(high, OMEGA_MAX)
    fine = np.unique(np.concatenate((still.omega, np.clip([low, high], still.omega[0], still.omega[-1]))))
    density = still.spectrum(fine)
    said = []
    for side, edge, part in (("below", low, fine <= low), ("above", high, fine >= high)):
        share = float(np.trapezoid(density[part], fine[part])) / still.moment(0) if part.sum() > 1 else 0.0
        if share >= SAID:
            where = f"{side} {edge:.3g} rad/s, where no waves are made or their moments are not known"
            said.append(f"{share:.0%} of the wave energy lies {where}")
    return tuple(said)
