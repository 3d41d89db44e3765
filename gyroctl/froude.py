"""Froude's law of similitude: how a quantity grows with the length of a device, in one water under one gravity.

Lengths go as L, times as sqrt(L), masses as L^3; the power of everything else follows from its unit.
"""

from __future__ import annotations

import re
from functools import lru_cache

POWERS = {"m": 1.0, "kg": 3.0, "s": 0.5, "rad": 0.0, "N": 3.0, "W": 3.5, "J": 4.0}
"""Power of the length of each unit."""

WORD = re.compile(r"(kg|rad|N|W|J|m|s)(?:\^(\d))?")


@lru_cache(maxsize=256)
def power(unit: str) -> float:
    """Power of the length with which a quantity of a unit grows: "m" 1, "Nms" 4.5, "rad/s" -0.5, "-" 0.

    Parameters
    ----------
    unit : str
        Products of kg, m, s, rad, N, W, J, with whole powers, over others: "kg m^2", "Nms^2", "Nms/rad".

    Raises
    ------
    ValueError
        For what is no such unit.
    """
    total = 0.0
    for sign, part in zip((1.0, -1.0), unit.split("/", 1), strict=False):
        if part.strip("- 1()") == "":
            continue
        left = part.strip("()").replace(" ", "")
        while left:
            found = WORD.match(left)
            if found is None:
                raise ValueError(f"{unit!r} is no unit")
            total += sign * POWERS[found[1]] * int(found[2] or 1)
            left = left[found.end() :]
    return total


def growth(unit: str, length: float) -> float:
    """Factor on a quantity of `unit` where all lengths of a device are multiplied by `length`."""
    exponent = power(unit)
    return 1.0 if exponent == 0.0 else float(length) ** exponent


def at_length(low_high: tuple[float, float], unit: str, length: float) -> tuple[float, float]:
    """Range of a quantity of `unit` that is meant at the size of Table 1, at `length` over it."""
    by = growth(unit, length)
    return low_high[0] * by, low_high[1] * by
