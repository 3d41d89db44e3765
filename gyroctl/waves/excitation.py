"""What this package needs to know of a plant: how waves become moments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.waves.directional import DirectionalSpectrum
from gyroctl.waves.record import ElevationRecord
from gyroctl.waves.tabulated import TabulatedSpectrum

if TYPE_CHECKING:  # the plant brings its compiled kernel along, which waves do not need
    from gyroctl.plant import Excitation


@runtime_checkable
class Excited(Protocol):
    """A plant, as far as waves are concerned."""

    @property
    def excitation(self) -> Excitation:
        """Transfer from elevation to excitation moments."""


class Wave(Protocol):
    """Any sea, as far as its equivalent regular wave is concerned."""

    @property
    def hs(self) -> float:
        """Significant wave height [m]."""

    @property
    def wp(self) -> float:
        """Peak frequency [rad/s]."""

    @property
    def heading(self) -> float:
        """Direction the waves travel to [deg]."""


def equivalent_amplitude(sea: Wave) -> float:
    """Amplitude of the regular wave of equal energy, ``hs / (2 sqrt 2)`` [m].

    Parameters
    ----------
    sea : SeaState
        Any sea with ``hs``, or a regular wave. [m]

    Returns
    -------
    float
        [m]
    """
    return float(sea.hs / (2.0 * np.sqrt(2.0)))


def regular_amplitude(plant: Excited, sea: Wave) -> NDArray[np.complex128]:
    """Complex moments of the equivalent regular wave, ``He_j(wp) hs / (2 sqrt 2)``.

    The moments in time are ``Re(M_j exp(i wp t))``: the wave's crest passes the float centre at t = 0.

    Parameters
    ----------
    plant : Plant
        Gives the excitation.
    sea : any sea of this package
        Gives height, frequency and heading.

    Returns
    -------
    ndarray, shape (2,), complex
        Moments about x1 and x3. [Nm]

    Raises
    ------
    InputError
        Field ``sea.wp``: outside the band of the excitation table.
    """
    low, high = band(plant.excitation)
    if not low <= sea.wp <= high:
        mend = f"Give a frequency in the tabulated band, {low:g} to {high:g} rad/s, or another table"
        if isinstance(sea, TabulatedSpectrum | DirectionalSpectrum | ElevationRecord):
            mend = (
                f"The device knows {low:g} to {high:g} rad/s. Give scale = the sea's length over the device's (Froude)"
            )
        raise InputError("sea.wp", sea.wp, "the excitation is not known at this frequency", mend)
    return plant.excitation(np.array([sea.wp]), sea.heading)[:, 0] * equivalent_amplitude(sea)


def band(excitation: Excitation) -> tuple[float, float]:
    """Lowest and highest tabulated frequency [rad/s]."""
    return float(excitation.omega[0]), float(excitation.omega[-1])
