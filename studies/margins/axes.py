"""Axes of the pictures in the units of a device: a power of ten for cg, ticks and contours near those of Table 1."""

from __future__ import annotations

import math
from typing import NamedTuple

from gyroctl.froude import growth

POWER_LEVELS = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0)
"""Contours of mean power at the size of Table 1. [W]"""

TICKS = {"cc": (0.01, 0.02, 0.05, 0.1, 0.2, 0.3), "height": (0.02, 0.05, 0.1, 0.2, 0.4, 0.8)}
"""Ticks of axes that are logarithmic, at the size of Table 1. [Nms], [m]"""

UNITS = {"cc": "Nms", "height": "m"}


class Gain(NamedTuple):
    """How cg is told: as so many of a power of ten of Nms."""

    scale: float  # what a value in Nms is multiplied by
    unit: str  # as TeX, with the power of ten
    times: str  # the unit after a number


def gain_at(length: float) -> Gain:
    """Return how cg is told on a device `length` times as long as Table 1: there in 1e-3 Nms."""
    power = 3 * math.floor((math.log10(growth("Nms", length)) - 3.0) / 3.0)
    if power == 0:
        return Gain(1.0, "Nms", "Nms")
    return Gain(float(f"1e{-power}"), f"$10^{{{power}}}$ Nms", f"$\\times 10^{{{power}}}$ Nms")


def axis(name: str, length: float) -> tuple[str, float]:
    """Label of an axis, and what its values are multiplied by."""
    gain = gain_at(length)
    labels = {"cc": "cc [Nms]", "cg": f"cg [{gain.unit}]", "wp": "wave frequency [rad/s]", "height": "wave height [m]"}
    return labels[name], gain.scale if name == "cg" else 1.0


def ticks(name: str, length: float, low: float, high: float) -> tuple[list[float], list[str]]:
    """Ticks of an axis between its ends with their words: round numbers near those of Table 1 at this length."""
    grown = [float(f"{value * growth(UNITS[name], length):.1g}") for value in TICKS[name]]
    shown = [value for value in dict.fromkeys(grown) if low <= value * 1.001 and value <= high * 1.001]
    return shown, [f"{value:g}" if value < 1e4 else f"{1e-3 * value:g}k" for value in shown]


def power_levels(length: float, low: float, high: float) -> list[float]:
    """Contours of power between two values: round numbers near those of Table 1 at this length. [W]"""
    grown = [float(f"{value * growth('W', length):.2g}") for value in POWER_LEVELS]
    return [value for value in grown if low < value < high]


def watts(value: float) -> str:
    """A contour's word."""
    return f"{value:g} W" if value < 1e4 else f"{1e-3 * value:g} kW"
