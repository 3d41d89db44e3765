"""Wave periods as scatter tables have them, each a part of the peak period by the moments of the spectrum."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from gyroctl.waves.spectrum import jonswap_shape

PERIODS = {"Tp": "peak period", "Te": "energy period, m-1/m0", "T1": "mean period, m0/m1", "Tz": "zero-crossing period"}
"""Kinds of period, and what each is; Tz is the root of m0/m2."""

FURTHEST = 400.0
"""Where the moments end, as a multiple of the peak frequency: of m2 less than 1e-5 lies beyond. [-]"""


@lru_cache(maxsize=64)
def over_peak_period(kind: str, gamma: float) -> float:
    """Period of a kind over the peak period of a JONSWAP spectrum of that peak enhancement. [-]"""
    if kind == "Tp":
        return 1.0
    m: dict[int, float] = {order: _moment(order, gamma) for order in (-1, 0, 1, 2)}
    if kind == "Te":
        return m[-1] / m[0]
    return m[0] / m[1] if kind == "T1" else math.sqrt(m[0] / m[2])


def _moment(order: int, gamma: float) -> float:
    """Moment of the spectrum over x = omega / wp, of (0, inf)."""
    log = np.linspace(math.log(0.2), math.log(FURTHEST), 40001)
    x = np.exp(log)
    beyond = FURTHEST ** (order - 4) / (4 - order)  # of the tail x^-5
    return float(np.trapezoid(jonswap_shape(x, gamma) * x ** (order + 1), log)) + float(beyond)
