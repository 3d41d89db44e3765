"""Lagrange's interpolation on eight even samples, the weights of one instant."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined

TAPS = 8
LAGRANGE = tuple(1.0 / math.prod(i - j for j in range(TAPS) if j != i) for i in range(TAPS))


@inlined
def lagrange_weights(u: Any, weight: Any) -> None:
    """Write the weights of the samples at 0 .. 7 for the place `u` among them."""
    before = 1.0
    for i in range(TAPS):
        weight[i] = before * LAGRANGE[i]
        before = before * (u - i)
    after = 1.0
    for i in range(TAPS):
        weight[TAPS - 1 - i] = weight[TAPS - 1 - i] * after
        after = after * (u - (TAPS - 1 - i))
