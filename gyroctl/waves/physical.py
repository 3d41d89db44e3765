"""Whether waves can be: higher than water can stand, or than the device could ride, is a slip of the unit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.waves.directional import DirectionalSpectrum
from gyroctl.waves.excitation import Wave
from gyroctl.waves.record import ElevationRecord
from gyroctl.waves.regular import Bichromatic, Regular
from gyroctl.waves.tabulated import TabulatedSpectrum

if TYPE_CHECKING:
    from gyroctl.plant import Parameters

BREAKING = 0.142
"""Height over length at which a regular wave breaks in deep water (Miche 1944); by tanh(k d) less in shallow. [1]

A sea is judged by the regular wave of equal energy: beyond this limit every crest of it would break.
"""

FROUDE = "Is a larger sea to be brought to the device (scale)? "


@runtime_checkable
class Sized(Protocol):
    """A plant whose dimensions are known; one that is an excitation alone takes any wave."""

    @property
    def parameters(self) -> Parameters:
        """Its dimensions."""

    @property
    def depth(self) -> float:
        """Water depth, infinite where unknown. [m]"""


class RegularWave(Protocol):
    """A wave of one height, as an orbit needs it."""

    @property
    def height(self) -> float:
        """Wave height. [m]"""

    @property
    def wp(self) -> float:
        """Angular frequency. [rad/s]"""


def wavelength(wp: float, depth: float) -> float:
    """Length of the waves of frequency `wp` [rad/s] in water of some depth [m]. [m]"""
    return float(2.0 * math.pi / wavenumber(np.array([wp]), depth)[0])


def check_wave(plant: Sized, wave: RegularWave, field: str = "height") -> None:
    """Refuse a regular wave that breaks, or is higher than the float could follow.

    Raises
    ------
    InputError
        With the largest height that is left.
    """
    _check(plant, wave.height, wave.wp, 1.0, field, "a regular wave")


def check_sea(plant: Sized, sea: Wave) -> None:
    """Refuse a sea that breaks at once, or is higher than the float could follow.

    Raises
    ------
    InputError
        Field of the sea that gives its height, with the largest height that is left.
    """
    if isinstance(sea, Regular):
        check_wave(plant, sea, "sea.height")
    elif isinstance(sea, Bichromatic):
        height = sum(sea.heights)
        _check(plant, height, sea.wp, 1.0, "sea.heights", "two waves with a sum of heights")
    else:
        field, unit = "sea.hs", ""
        if isinstance(sea, ElevationRecord):
            field, unit = "sea.eta", f"Are the elevations in millimetres? {FROUDE}"
        elif isinstance(getattr(sea, "sea", sea), TabulatedSpectrum | DirectionalSpectrum):
            field, unit = "sea.density", f"Are the densities in m^2 s per rad/s? {FROUDE}"
        _check(plant, sea.hs, sea.wp, math.sqrt(2.0), field, "a significant height", unit)


def check_headings(bearings: object) -> None:
    """Refuse waves of many headings, not None, for a plant that follows the surface of waves of one heading.

    Raises
    ------
    InputError
        Field ``plant.wetted``.
    """
    if bearings is not None:
        problem = "follows the surface of waves of one heading, and the waves of this sea have many"
        raise InputError("plant.wetted", "surface", problem, 'Choose wetted = "reduced", or a sea without spreading')


def _check(plant: Sized, height: float, wp: float, over: float, field: str, what: str, unit: str = "") -> None:
    """Refuse a height that is `over` times as high as the regular wave it stands for, where that breaks."""
    length, reach = wavelength(wp, plant.depth), 2.0 * plant.parameters.a
    shallow = math.tanh(2.0 * math.pi / length * plant.depth) if math.isfinite(plant.depth) else 1.0
    most = over * BREAKING * length * shallow
    problem = ""
    if not height <= most:
        problem = f"{what} of {height:.4g} m breaks on waves {length:.3g} m long at {wp:.3g} rad/s"
    if not height <= reach:
        lever = f"the float on its lever of {plant.parameters.a:.3g} m cannot follow {what} of {height:.4g} m"
        problem = f"{problem}, and {lever}" if problem else lever
    if problem:
        raise InputError(field, round(height, 6), problem, f"{unit}Give metres, at most {min(most, reach):.3g} m here")
