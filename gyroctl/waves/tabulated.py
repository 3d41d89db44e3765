"""A user's own spectrum, from a table of frequency and density."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.waves.checks import HEIGHT_MAX, heading_angle, series, store, within
from gyroctl.waves.columns import digest, read_columns

TABLE_MAX, DENSITY_MAX = 1e4, 1e6
"""Frequency [rad/s] and density [m^2 s] beyond which no spectrum is meant."""

_OMEGA = "Give frequencies in rad/s (not Hz), rising from line to line"
_DENSITY = "Give one-sided densities in m^2 s per rad/s, none negative, some positive"


@dataclass(frozen=True)
class TabulatedSpectrum:
    """A spectrum given by a table, linear between its points and zero outside.

    Two spectra are equal when their numbers and heading are: equality and hash go through `sha256`.

    Parameters
    ----------
    omega : array_like, shape (n,)
        Rising frequencies. [rad/s]
    density : array_like, shape (n,)
        One-sided spectral density of the elevation. [m^2 s]
    heading : float
        Direction the waves travel to. [deg]

    Raises
    ------
    InputError
        Fields ``sea.omega``, ``sea.density``, ``sea.heading``.
    """

    omega: NDArray[np.float64] = field(compare=False, repr=False)
    density: NDArray[np.float64] = field(compare=False, repr=False)
    heading: float = 0.0
    sha256: str = field(init=False)

    def __post_init__(self) -> None:
        """Check the table and take its digest."""
        omega, density = series("sea.omega", self.omega, _OMEGA), series("sea.density", self.density, _DENSITY)
        if omega.size < 2 or density.size != omega.size:
            sizes = f"{omega.size} frequencies, {density.size} densities"
            raise InputError("sea.density", sizes, "must be as many as the frequencies, two or more", _DENSITY)
        back = np.flatnonzero(np.diff(omega) <= 0.0)
        if omega[0] < 0.0 or back.size:
            first = 0 if omega[0] < 0.0 else int(back[0]) + 1
            raise InputError("sea.omega", float(omega[first]), "must rise, from 0 or above", _OMEGA)
        if density.min() < 0.0:
            raise InputError("sea.density", float(density.min()), "must not be negative", _DENSITY)
        if density.max() == 0.0:
            raise InputError("sea.density", 0.0, "must not be zero everywhere", _DENSITY)
        within("sea.omega", float(omega[-1]), 0.0, TABLE_MAX, _OMEGA)
        area = float(np.trapezoid(np.minimum(density, DENSITY_MAX), omega))
        within("sea.density", float(density.max()), 0.0, DENSITY_MAX, _DENSITY)
        within("sea.hs", 4.0 * math.sqrt(area), 1e-6, HEIGHT_MAX, _DENSITY)
        if omega[np.argmax(density)] <= 0.0:
            raise InputError("sea.omega", 0.0, "must be positive where the density is greatest", _OMEGA)
        heading = heading_angle(self.heading)
        store(self, omega=omega, density=density, heading=heading, sha256=digest(omega, density))

    @property
    def hs(self) -> float:
        """Significant wave height, four times the root of the area [m]."""
        return 4.0 * math.sqrt(float(np.trapezoid(self.density, self.omega)))

    @property
    def wp(self) -> float:
        """Frequency of the greatest tabulated density [rad/s]."""
        return float(self.omega[np.argmax(self.density)])

    def spectrum(self, omega: ArrayLike) -> NDArray[np.float64]:
        """One-sided spectral density of the elevation at `omega` [rad/s], any shape [m^2 s]."""
        at = np.asarray(omega, dtype=np.float64)
        return np.asarray(np.interp(at, self.omega, self.density, left=0.0, right=0.0), dtype=np.float64)


def read_spectrum(path: str | PathLike[str], heading: float = 0.0) -> TabulatedSpectrum:
    """Read a spectrum from a text file of two columns, omega [rad/s] and S [m^2 s].

    Parameters
    ----------
    path : str or Path
        The file, columns apart by a comma, a semicolon or blanks.
    heading : float
        Direction the waves travel to. [deg]

    Returns
    -------
    TabulatedSpectrum

    Raises
    ------
    InputError
        Field ``sea.file`` for the file, the fields of `TabulatedSpectrum` for its numbers.
    """
    omega, density = read_columns(path, "omega [rad/s], S [m^2 s]")
    return TabulatedSpectrum(omega, density, heading)
