"""Waves of one or two frequencies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import FREQUENCY_MAX, HEIGHT_MAX, at_most, heading_angle, positive, store

_HEIGHT = "Give the wave height, crest to trough, in metres, for example 0.2"
_FREQUENCY = "Give the frequency in rad/s, for example 3.14"


@pictured(sea_face)
@dataclass(frozen=True)
class Regular:
    """A regular wave, ``eta = height / 2 * cos(wp t)``; its phase is zero at t = 0 whatever the seed.

    Parameters
    ----------
    height : float
        Wave height, twice the amplitude. [m]
    wp : float
        Frequency. [rad/s]
    heading : float
        Direction the wave travels to. [deg]

    Raises
    ------
    InputError
        Fields ``sea.height``, ``sea.wp``, ``sea.heading``.
    """

    height: float
    wp: float
    heading: float = 0.0

    def __post_init__(self) -> None:
        """Check every field and store it as a float."""
        height, wp = positive("sea.height", self.height, _HEIGHT), positive("sea.wp", self.wp, _FREQUENCY)
        height, wp = at_most("sea.height", height, HEIGHT_MAX, "m"), at_most("sea.wp", wp, FREQUENCY_MAX, "rad/s")
        store(self, height=height, wp=wp, heading=heading_angle(self.heading))

    @property
    def hs(self) -> float:
        """Significant wave height of equal energy, ``sqrt(2) * height`` [m]."""
        return math.sqrt(2.0) * self.height

    @property
    def lines(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Frequency [rad/s] and amplitude [m] of the wave, shape (1,) each."""
        return np.array([self.wp]), np.array([0.5 * self.height])


@pictured(sea_face)
@dataclass(frozen=True)
class Bichromatic:
    """Two regular waves on top of each other: a group. Their two phases are drawn from the seed.

    Parameters
    ----------
    heights : tuple of two floats
        Wave heights, twice the amplitudes. [m]
    frequencies : tuple of two floats
        Frequencies, different from each other. [rad/s]
    heading : float
        Direction both waves travel to. [deg]

    Raises
    ------
    InputError
        Fields ``sea.heights``, ``sea.frequencies``, ``sea.heading``.
    """

    heights: tuple[float, float]
    frequencies: tuple[float, float]
    heading: float = 0.0

    def __post_init__(self) -> None:
        """Check every field and store it as floats."""
        heights = _pair("sea.heights", self.heights, "Give two wave heights in metres, for example [0.15, 0.1]")
        mend = "Give two different frequencies in rad/s, for example [2.9, 3.3]"
        frequencies = _pair("sea.frequencies", self.frequencies, mend)
        if frequencies[0] == frequencies[1]:
            raise InputError("sea.frequencies", self.frequencies, "the two must differ", mend)
        for height, wp in zip(heights, frequencies, strict=True):
            at_most("sea.heights", height, HEIGHT_MAX, "m")
            at_most("sea.frequencies", wp, FREQUENCY_MAX, "rad/s")
        store(self, heights=heights, frequencies=frequencies, heading=heading_angle(self.heading))

    @property
    def hs(self) -> float:
        """Significant wave height of equal energy [m]."""
        return math.sqrt(2.0) * math.hypot(*self.heights)

    @property
    def wp(self) -> float:
        """Frequency of the higher of the two waves, the first where they are equal [rad/s]."""
        return self.frequencies[0] if self.heights[0] >= self.heights[1] else self.frequencies[1]

    @property
    def lines(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Frequencies [rad/s] and amplitudes [m] of the waves, shape (2,) each."""
        return np.array(self.frequencies), 0.5 * np.array(self.heights)


def _pair(field: str, value: object, mend: str) -> tuple[float, float]:
    if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != 2:
        raise InputError(field, value, "must be two numbers", mend)
    return positive(field, value[0], mend), positive(field, value[1], mend)
