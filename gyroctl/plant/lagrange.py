"""Lagrange's interpolation on eight even samples, the weights of one instant."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined

TAPS = 8
LAGRANGE = tuple(1.0 / math.prod(i - j for j in range(TAPS) if j != i) for i in range(TAPS))


@inlined
def weights_at(u: Any) -> Any:
    """Weights of the samples at 0 .. 7 for the place `u` among them."""
    v1, v2, v3, v4, v5, v6, v7 = u - 1, u - 2, u - 3, u - 4, u - 5, u - 6, u - 7
    b2 = u * v1  # products of what lies before
    b3 = b2 * v2
    b4 = b3 * v3
    b5 = b4 * v4
    b6 = b5 * v5
    b7 = b6 * v6
    a5 = v7 * v6  # and behind
    a4 = a5 * v5
    a3 = a4 * v4
    a2 = a3 * v3
    a1 = a2 * v2
    a0 = a1 * v1
    c = LAGRANGE
    early = c[0] * a0, u * c[1] * a1, b2 * c[2] * a2, b3 * c[3] * a3
    return (*early, b4 * c[4] * a4, b5 * c[5] * a5, b6 * c[6] * v7, b7 * c[7])


@inlined
def lagrange_weights(u: Any, weight: Any) -> None:
    """Write the weights of the samples at 0 .. 7 for the place `u` among them."""
    weights = weights_at(u)
    for i in range(TAPS):
        weight[i] = weights[i]
