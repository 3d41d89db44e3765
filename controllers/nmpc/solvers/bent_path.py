"""Projected Newton steps within bounds: what is held, and what slope is left.

After Bertsekas (SIAM J. Control Optim. 20 (1982) 221-246). Common to the solvers of a subproblem, whatever
gives them the Newton direction.
"""

from __future__ import annotations

from typing import Any

from gyroctl.plant.compiled import inlined

SUFFICIENT = 1e-4  # share of the linear decrease that a step must bring
ROUNDING = 1e-13  # of cost and slope, relative
SHORTEST = 1e-9  # part of a step below which no decrease can be measured


@inlined
def steepness(d: Any, room: Any) -> tuple[float, float]:
    """Squared size of the slope: of what is left of it within the bounds, and of the whole."""
    square, whole = 0.0, 0.0
    for i in range(d.size):
        left = room.slope[i]
        whole += left * left
        if d[i] <= room.low[i]:
            left = min(left, 0.0)
        if d[i] >= room.high[i]:
            left = max(left, 0.0)
        square += left * left
    return square, whole


@inlined
def hold(d: Any, near: float, room: Any) -> None:
    """Choose the couplings that are put on a bound."""
    for i in range(d.size):
        room.held[i] = False
        if d[i] <= room.low[i] + near and room.slope[i] > 0.0:
            room.held[i], room.direction[i] = True, room.low[i] - d[i]
        elif d[i] >= room.high[i] - near and room.slope[i] < 0.0:
            room.held[i], room.direction[i] = True, room.high[i] - d[i]
