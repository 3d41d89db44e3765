"""The wetted surface reduced to polynomials: what the panels add to the linear moments, fitted to them."""

from __future__ import annotations

import math
from typing import NamedTuple

from gyroctl.errors import InputError


class ReducedSurface(NamedTuple):
    """Polynomials of a float in its immersion, the angle x of the lever over the water that lifts it.

    With the linear Froude-Krylov moments F1, F3 and the stiffness k,
    ``x = clip(phi3 - F3/k)``, ``R1 = F1 sum_i moment1[i] x^(i+1)``,
    ``R3 = -k (sum_i moment3[i] x^(i+2) + x - (phi3 - F3/k))``: the clip's ends are the float fully under and dry, where
    the moments no longer change.
    """

    moment1: tuple[float, ...]
    """From the first power on. [1/rad, 1/rad^2, ..]"""
    moment3: tuple[float, ...]
    """From the second power on. [1/rad, ..]"""
    low: float
    """Fully under. [rad]"""
    high: float
    """Dry. [rad]"""
    soft: float
    """Width over which the clip sets in, so that it can be differentiated. [rad]"""
    stiffness: float
    """Of the panels about x3. [Nm/rad]"""
    error1: float
    """Root mean square of what the fit misses of R1, relative to R1. [-]"""
    error3: float
    """The same of R3. [-]"""
    hs: float
    """Greatest significant wave height that was fitted. [m]"""
    wp: float
    """Peak frequency that was fitted. [rad/s]"""


def checked(fit: ReducedSurface) -> ReducedSurface:
    """Return the fit, or refuse what no fit can be.

    Raises
    ------
    InputError
        Field ``wetted fit``.
    """
    numbers = [*fit.moment1, *fit.moment3, fit.low, fit.high, fit.soft, fit.stiffness]
    sound = all(map(math.isfinite, numbers)) and fit.low < 0.0 < fit.high and fit.soft > 0.0 and fit.stiffness > 0.0
    if not sound or len(fit.moment1) < 1 or len(fit.moment3) < 1:
        problem = "is no fit of a wetted surface"
        raise InputError("wetted fit", numbers, problem, "Fit it again: gyroctl hydro fit-wetted FILE")
    return fit
