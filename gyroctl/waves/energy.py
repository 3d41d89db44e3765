"""Power that the waves carry, for the capture width ratio."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from gyroctl.waves.synthesis import Synthesis

RHO, G = 1000.0, 9.81
"""Density of the water [kg/m^3] and gravity [m/s^2]."""


def group_speed(omega: ArrayLike, depth: float = math.inf) -> NDArray[np.float64]:
    """Group speed of linear waves [m/s] at `omega` [rad/s] (same shape) in water of `depth` [m]."""
    w = np.asarray(omega, float)
    if math.isinf(depth):
        return np.asarray(G / (2.0 * w))
    deep = w**2 * depth / G
    kh = deep / np.sqrt(np.tanh(deep))  # start of Newton's method on kh tanh kh = w^2 h / g
    for _ in range(20):
        t = np.tanh(kh)
        kh = kh - (kh * t - deep) / (t + kh * (1.0 - t**2))
    ratio = 2.0 * kh / np.sinh(np.minimum(2.0 * kh, 700.0))
    return np.asarray(0.5 * (1.0 + ratio) * w * depth / kh)


def wave_power(synthesis: Synthesis, depth: float = math.inf) -> float:
    """Mean power per metre of crest, sum of rho g a^2 c_g / 2 over the harmonics. [W/m]"""
    waves = synthesis.waves
    return float(0.5 * RHO * G * np.sum(np.abs(waves.amplitude) ** 2 * group_speed(waves.omega, depth)))
