"""Readings that tell nothing: what an estimator leaves out when a sensor is lost.

A sensor with noise never gives the same bits twice. One that does, or that gives exactly zero, while the model says
that the device has moved, is frozen or dead; it stays so until its reading changes.
"""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined, part

DOUBT = 5.0
"""Innovation, in standard deviations, from which a reading that repeats itself is not believed. Small enough that one
that is believed by chance does no harm, large enough for a sensor whose resolution is coarse. [-]"""


@inlined
def known_or(value: float, other: float) -> float:
    """Return a reading, or another value where it is no number."""
    return value if math.isfinite(value) else other


@part((__file__,))
def doubt(ring: Any, ring_noise: Any, float_spread: Any, y: Any, last: Any, e: Any, missing: Any) -> None:
    """Mark the readings that tell nothing, and take their innovations away.

    Parameters
    ----------
    ring : (3, 3) array
        Variance of psi, psi', omega' before the measurement.
    ring_noise : (3,) array
        Variances of their sensors.
    float_spread : (4,) array
        Variances of the innovations of phi1, phi3, phi1', phi3'.
    y : (7,) array
        The readings.
    last : (7,) array
        Last readings that were numbers; those of this sample afterwards.
    e : (7,) array
        Innovations; zero afterwards where a reading is not believed.
    missing : (7,) array
        1 where the reading of the last sample was not believed; that of this sample afterwards.
    """
    for i in range(7):
        variance = ring[i, i] + ring_noise[i] if i < 3 else float_spread[i - 3]
        far, same = e[i] * e[i] > DOUBT * DOUBT * variance, y[i] == last[i]
        stale = (same and (far or missing[i] > 0.0)) or (far and y[i] == 0.0)
        missing[i] = 1.0 if stale or not math.isfinite(y[i]) else 0.0
        last[i] = known_or(y[i], last[i])
        if missing[i] > 0.0:
            e[i] = 0.0
