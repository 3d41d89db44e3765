"""A sea with two peaks: waves of two origins, as a swell under a wind sea, that share the significant height."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import finite, store
from gyroctl.waves.spectrum import SeaState


@pictured(sea_face)
@dataclass(frozen=True)
class TwoPeaks:
    """A stationary sea whose spectrum is the sum of two JONSWAP spectra; both travel in one direction.

    The default is a wind sea at the device's frequency over a swell that is half as fast, with a quarter of the energy.

    Parameters
    ----------
    hs : float
        Significant wave height of both together. [m]
    wp : float
        Peak frequency of the first sea; start and lock are judged by it. [rad/s]
    gamma : float
        Its peak enhancement factor, at least 1. [-]
    wp_second : float
        Peak frequency of the second sea. [rad/s]
    gamma_second : float
        Its peak enhancement factor. [-]
    share : float
        Part of the variance that belongs to the second sea, from 0 to 1. [-]
    heading : float
        Direction the waves travel to. [deg]

    Raises
    ------
    InputError
        Fields ``sea.hs``, ``sea.wp``, ``sea.gamma``, ``sea.wp_second``, ``sea.gamma_second``, ``sea.share``,
        ``sea.heading``.
    """

    hs: float = 0.283
    wp: float = 3.14
    gamma: float = 5.0
    wp_second: float = 1.8
    gamma_second: float = 5.0
    share: float = 0.25
    heading: float = 0.0

    def __post_init__(self) -> None:
        """Check every field and store it as a float."""
        mend = "Give the part of the second sea, for example 0.25"
        share = finite("sea.share", self.share, mend)
        if not 0.0 <= share <= 1.0:
            raise InputError("sea.share", self.share, "must be between 0 and 1", mend)
        first = SeaState(self.hs, self.wp, self.gamma, self.heading)
        try:
            second = SeaState(self.hs, self.wp_second, self.gamma_second)
        except InputError as error:
            raise InputError(f"{error.field}_second", error.value, error.problem, error.mend) from None
        store(self, hs=first.hs, wp=first.wp, gamma=first.gamma, heading=first.heading, share=share)
        store(self, wp_second=second.wp, gamma_second=second.gamma)

    def spectrum(self, omega: ArrayLike) -> NDArray[np.float64]:
        """One-sided spectral density of the elevation at `omega` [rad/s], any shape [m^2 s]."""
        first = SeaState(self.hs, self.wp, self.gamma).spectrum(omega)
        second = SeaState(self.hs, self.wp_second, self.gamma_second).spectrum(omega)
        return np.asarray((1.0 - self.share) * first + self.share * second)
