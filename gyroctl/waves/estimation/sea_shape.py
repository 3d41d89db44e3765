"""The JONSWAP family as three numbers, with the slopes that a fit needs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gyroctl.plant.compiled import inlined
from gyroctl.waves.spectrum import SIGMA_ABOVE, SIGMA_BELOW, SeaState

LEVEL, PEAK, SHARPNESS = range(3)
"""Logarithms of the level, of the peak frequency and of gamma, see `shape_of`."""

LOWEST = (-30.0, math.log(1.5), 0.0)
HIGHEST = (30.0, math.log(6.0), math.log(70.0))
"""Range of the three numbers in a fit."""


@inlined
def log_spectrum(shape: Any, omega: float, slopes: Any) -> float:
    """Return log S at `omega` [rad/s] and write its slopes with respect to the three numbers, (39)-(40)."""
    x = omega / math.exp(shape[PEAK])
    sigma = SIGMA_BELOW if x <= 1.0 else SIGMA_ABOVE
    peak = math.exp(-((x - 1.0) ** 2) / (2.0 * sigma * sigma))
    fall = x**-4
    slopes[LEVEL] = 1.0
    slopes[PEAK] = -5.0 * fall + shape[SHARPNESS] * peak * (x - 1.0) / (sigma * sigma) * x
    slopes[SHARPNESS] = peak
    return float(shape[LEVEL] - 5.0 * math.log(omega) - 1.25 * fall + shape[SHARPNESS] * peak)


def shape_of(sea: SeaState) -> tuple[float, float, float]:
    """Return the three numbers of a sea state."""
    rest = (0.0, math.log(sea.wp), math.log(sea.gamma))
    level = math.log(float(sea.spectrum(np.array([sea.wp]))[0])) - log_spectrum(rest, sea.wp, [0.0, 0.0, 0.0])
    return level, rest[1], rest[2]
