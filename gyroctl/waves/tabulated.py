"""A user's own spectrum, from a table of frequency and density."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import HEIGHT_MAX, heading_angle, series, store, within
from gyroctl.waves.columns import digest

TABLE_MAX, DENSITY_MAX = 1e4, 1e6
"""Frequency [rad/s] and density [m^2 s] beyond which no spectrum is meant."""

_OMEGA = "Give frequencies that rise from line to line, from 0 or above; in Python in rad/s"
_DENSITY = "Give one-sided densities in m^2 s per rad/s, none negative, some positive"


@pictured(sea_face)
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
    notes : tuple of str
        What was done to the numbers of a file.

    Raises
    ------
    InputError
        Fields ``sea.omega``, ``sea.density``, ``sea.heading``.
    """

    omega: NDArray[np.float64] = field(compare=False, repr=False)
    density: NDArray[np.float64] = field(compare=False, repr=False)
    heading: float = 0.0
    sha256: str = field(init=False)
    notes: tuple[str, ...] = field(default=(), compare=False, repr=False)

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

    @property
    def tp(self) -> float:
        """Peak period, of the greatest tabulated density [s]."""
        return 2.0 * math.pi / self.wp

    @property
    def te(self) -> float:
        """Energy period, ``2 pi m_-1 / m_0`` [s]."""
        return 2.0 * math.pi * self.moment(-1) / self.moment(0)

    def moment(self, order: int) -> float:
        """Spectral moment, the integral of ``omega**order S`` over the straight lines of the table.

        Parameters
        ----------
        order : int
            From -1 to 4.

        Returns
        -------
        float
            [m^2 (rad/s)^order]

        Raises
        ------
        InputError
            Field ``order``.
        """
        return moment_of(self.omega, self.density, order)

    def spectrum(self, omega: ArrayLike) -> NDArray[np.float64]:
        """One-sided spectral density of the elevation at `omega` [rad/s], any shape [m^2 s]."""
        at = np.asarray(omega, dtype=np.float64)
        return np.asarray(np.interp(at, self.omega, self.density, left=0.0, right=0.0), dtype=np.float64)


def moment_of(omega: NDArray[np.float64], density: NDArray[np.float64], order: int) -> float:
    """Integral of ``omega**order S`` over the straight lines between the points of a table, (n,) each, exactly.

    Raises
    ------
    InputError
        Field ``order``: not a whole number from -1 to 4.
    """
    if isinstance(order, bool) or order not in range(-1, 5):
        raise InputError("order", order, "must be a whole number from -1 to 4", "Give 0 for the variance")
    begin, end, low, high = omega[:-1], omega[1:], density[:-1], density[1:]
    slope = (high - low) / (end - begin)
    level = low - slope * begin
    if order >= 0:
        whole = level * (end ** (order + 1) - begin ** (order + 1)) / (order + 1)
        return float(np.sum(whole + slope * (end ** (order + 2) - begin ** (order + 2)) / (order + 2)))
    if begin[0] == 0.0 and low[0] > 0.0:
        return math.inf
    # Without energy at zero frequency the first line has no level, and its part is finite.
    rises = np.log(end / np.where(begin > 0.0, begin, end))
    return float(np.sum(level * rises + slope * (end - begin)))
