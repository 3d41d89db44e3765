"""Seas that come from several directions: a spreading about the mean heading, or a table over frequency and heading.

Every harmonic has one heading of its own (Miles and Funke 1989; Jefferys 1987: several headings at one frequency stand
in fixed phase to one another, so that the waves would differ from place to place for ever). The headings of neighbours
go through the quantiles of the distribution by the golden ratio, so that any few dozen neighbours have its shape; they
belong to the frequencies and not to the seed. Amplitudes are those of the sea without spreading, and so is the
elevation at the float, to the last bit; the moments differ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import check_text, heading_angle, store, within
from gyroctl.waves.columns import digest
from gyroctl.waves.spectrum import SeaState
from gyroctl.waves.tabulated import TabulatedSpectrum
from gyroctl.waves.two_peaks import TwoPeaks

SPREADINGS = ("cos2s", "normal")
"""``cos(angle / 2)^(2 s)``; the wrapped normal distribution."""

ROUNDED = 2.0
"""Headings are taken to so many degrees: waves of the same one have their transfer worked out together."""

EXPONENT, DEVIATION = (0.5, 1000.0), (0.5, 90.0)
"""Least and largest s of ``cos^2s`` [-] and standard deviation of the wrapped normal distribution [deg]."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

_FINE = np.linspace(-math.pi, math.pi, 14401)


@pictured(sea_face)
@dataclass(frozen=True)
class SpreadSea:
    """A stationary sea whose waves come from directions about its mean heading.

    Parameters
    ----------
    sea : SeaState, TwoPeaks or TabulatedSpectrum
        The sea without spreading; its heading is the mean one.
    spreading : str
        "cos2s" or "normal".
    width : float
        Exponent s of "cos2s" [-], standard deviation of "normal" [deg].

    Raises
    ------
    InputError
        Fields ``sea``, ``sea.spreading``, ``sea.width``.
    """

    sea: SeaState | TwoPeaks | TabulatedSpectrum
    spreading: str = "cos2s"
    width: float = 10.0

    def __post_init__(self) -> None:
        """Check every field."""
        if not isinstance(self.sea, SeaState | TwoPeaks | TabulatedSpectrum):
            mend = "Give a SeaState, TwoPeaks or TabulatedSpectrum"
            raise InputError("sea", type(self.sea).__name__, "has no spreading of its own to choose", mend)
        check_text("sea.spreading", self.spreading)
        if self.spreading not in SPREADINGS:
            raise InputError("sea.spreading", self.spreading, "unknown", f"Choose one of {', '.join(SPREADINGS)}")
        cosine = self.spreading == "cos2s"
        mend = "Give the exponent s, for example 10" if cosine else "Give the standard deviation in degrees, as 25"
        store(self, width=within("sea.width", self.width, *(EXPONENT if cosine else DEVIATION), mend))

    @property
    def hs(self) -> float:
        """Significant wave height [m]."""
        return self.sea.hs

    @property
    def wp(self) -> float:
        """Peak frequency [rad/s]."""
        return self.sea.wp

    @property
    def heading(self) -> float:
        """Mean direction the waves travel to [deg]."""
        return self.sea.heading

    @property
    def notes(self) -> tuple[str, ...]:
        """Those of the sea without spreading."""
        return getattr(self.sea, "notes", ())

    def spectrum(self, omega: ArrayLike) -> NDArray[np.float64]:
        """One-sided spectral density of the elevation at `omega` [rad/s], any shape [m^2 s]."""
        return self.sea.spectrum(omega)

    def distribution(self, angle: ArrayLike) -> NDArray[np.float64]:
        """Density over the angle from the mean heading, any shape [rad], with area 1 over a turn. [1/rad]"""
        at = np.asarray(angle, dtype=np.float64)
        if self.spreading == "cos2s":
            log = math.lgamma(self.width + 1.0) - math.lgamma(self.width + 0.5) - 0.5 * math.log(math.pi)
            return np.asarray(0.5 * math.exp(log) * np.abs(np.cos(0.5 * at)) ** (2.0 * self.width))
        deviation = math.radians(self.width)
        turns = at[..., None] + 2.0 * math.pi * np.arange(-3, 4)
        whole = np.exp(-0.5 * (turns / deviation) ** 2).sum(axis=-1)
        return np.asarray(whole / (deviation * math.sqrt(2.0 * math.pi)))

    def headings_at(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heading of each harmonic, shape of `omega` (n,) [deg]."""
        below = np.concatenate(([0.0], np.cumsum(self.distribution(0.5 * (_FINE[1:] + _FINE[:-1])))))
        angle = np.interp(shares(omega.size) * below[-1], below, _FINE)
        return rounded(self.heading + np.degrees(angle))


@pictured(sea_face)
@dataclass(frozen=True)
class DirectionalSpectrum:
    """A spectrum over frequency and heading, linear in frequency between its rows, zero outside.

    Parameters
    ----------
    omega : array_like, shape (n,)
        Rising frequencies. [rad/s]
    headings : array_like, shape (m,)
        Rising headings, evenly spaced, within one turn. [deg]
    density : array_like, shape (n, m)
        One-sided spectral density of the elevation over frequency and heading. [m^2 s/rad]
    notes : tuple of str
        What was done to the numbers of a file.

    Raises
    ------
    InputError
        Fields ``sea.omega``, ``sea.headings``, ``sea.density``.
    """

    omega: NDArray[np.float64] = field(compare=False, repr=False)
    headings: NDArray[np.float64] = field(compare=False, repr=False)
    density: NDArray[np.float64] = field(compare=False, repr=False)
    notes: tuple[str, ...] = field(default=(), compare=False, repr=False)
    sha256: str = field(init=False)

    def __post_init__(self) -> None:
        """Check the table and take its digest."""
        omega, headings = np.array(self.omega, dtype=np.float64), np.array(self.headings, dtype=np.float64)
        density = np.array(self.density, dtype=np.float64)
        mend = "Give densities in m^2 s/rad, one row for each frequency and one column for each heading"
        if omega.ndim != 1 or headings.ndim != 1 or density.shape != (omega.size, headings.size):
            raise InputError("sea.density", f"array of shape {density.shape}", "does not fit the axes", mend)
        if not np.all(np.isfinite(density)) or np.any(density < 0.0):
            raise InputError("sea.density", float(np.min(density)), "must be finite and not negative", mend)
        step = np.diff(headings)
        whole = headings.size >= 3 and np.all(np.isfinite(headings)) and 360.0 + 1e-6 >= step.mean() * headings.size
        if not whole or step.min() <= 0.0 or np.ptp(step) > 1e-3 * step.mean() or np.abs(headings).max() > 720.0:
            mend = "Give three or more rising headings, evenly spaced, within one turn, in degrees"
            raise InputError("sea.headings", headings.size, "are no even headings", mend)
        store(self, omega=omega, headings=headings, density=density, sha256=digest(omega, headings, density))
        for array in (omega, headings, density):
            array.setflags(write=False)
        _ = self.still  # which refuses what is no spectrum

    @cached_property
    def still(self) -> TabulatedSpectrum:
        """The spectrum over frequency alone, with the mean heading."""
        step = math.radians(float(np.diff(self.headings).mean()))
        turn = np.exp(1j * np.radians(self.headings))
        rows = self.density.sum(axis=1) * step
        mean = np.trapezoid(self.density @ turn, self.omega)
        heading = float(np.degrees(np.angle(mean)))
        return TabulatedSpectrum(self.omega, rows, heading_angle(round(heading, 9)), self.notes)

    @property
    def hs(self) -> float:
        """Significant wave height [m]."""
        return self.still.hs

    @property
    def wp(self) -> float:
        """Frequency of the greatest density over all headings together [rad/s]."""
        return self.still.wp

    @property
    def heading(self) -> float:
        """Mean direction the waves travel to, by energy [deg]."""
        return self.still.heading

    @property
    def tp(self) -> float:
        """Peak period [s]."""
        return self.still.tp

    @property
    def te(self) -> float:
        """Energy period, ``2 pi m_-1 / m_0`` [s]."""
        return self.still.te

    @property
    def spread(self) -> float:
        """Circular standard deviation of the headings, ``sqrt(2 (1 - r1))`` (Kuik et al. 1988) [deg]."""
        turn = np.exp(1j * np.radians(self.headings))
        whole = np.trapezoid(self.density.sum(axis=1), self.omega)
        first = abs(np.trapezoid(self.density @ turn, self.omega)) / whole
        return math.degrees(math.sqrt(max(0.0, 2.0 * (1.0 - first))))

    def moment(self, order: int) -> float:
        """Spectral moment over all headings; see `TabulatedSpectrum.moment`."""
        return self.still.moment(order)

    def spectrum(self, omega: ArrayLike) -> NDArray[np.float64]:
        """One-sided spectral density over all headings at `omega` [rad/s], any shape [m^2 s]."""
        return self.still.spectrum(omega)

    def headings_at(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heading of each harmonic, shape of `omega` (n,) [deg]; the mean one where there is no energy."""
        share, found = shares(omega.size), np.full(omega.shape, self.heading)
        step = float(np.diff(self.headings).mean())
        edges = np.append(self.headings - 0.5 * step, self.headings[-1] + 0.5 * step)
        inside = np.flatnonzero((omega >= self.omega[0]) & (omega <= self.omega[-1]))
        for some in np.array_split(inside, max(1, inside.size // 4096)):
            row = np.clip(np.searchsorted(self.omega, omega[some], side="right") - 1, 0, self.omega.size - 2)
            part = ((omega[some] - self.omega[row]) / (self.omega[row + 1] - self.omega[row]))[:, None]
            table = (1.0 - part) * self.density[row] + part * self.density[row + 1]
            below = np.concatenate((np.zeros((len(some), 1)), np.cumsum(table, axis=1)), axis=1)
            for at, level in zip(some, below, strict=True):
                if level[-1] > 0.0:
                    found[at] = np.interp(share[at] * level[-1], level, edges)
        return rounded(found)


def shares(count: int) -> NDArray[np.float64]:
    """Quantiles of neighbours, (count,) between 0 and 1: any few of them are spread evenly."""
    return np.mod(0.5 + GOLDEN * np.arange(1, count + 1, dtype=np.float64), 1.0)


def rounded(headings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Headings to multiples of `ROUNDED` in (-180, 180]."""
    full = np.round(headings / ROUNDED) * ROUNDED
    return np.asarray(180.0 - np.mod(180.0 - full, 360.0))


def within_turn(headings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rising headings, moved by full turns so that the first lies in [-180, 180)."""
    return np.asarray(headings - 360.0 * math.floor((float(headings[0]) + 180.0) / 360.0))
