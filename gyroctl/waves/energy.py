"""Power that the waves carry, for the capture width ratio."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from gyroctl.waves.spectrum import SeaState
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


def energy_flux(sea: SeaState, depth: float = math.inf) -> float:
    """Mean power per metre of crest of a sea, rho g times the integral of its spectrum and the group speed. [W/m]

    In deep water rho g^2 Hs^2 Te / (64 pi), with Te = m-1/m0; in shallow water rho g Hs^2 / 16 sqrt(g h).
    """
    x = np.exp(np.linspace(math.log(0.2), math.log(40.0), 8001))  # below it nothing, beyond it 1e-8 of the power
    omega = sea.wp * x
    return float(RHO * G * np.trapezoid(sea.spectrum(omega) * group_speed(omega, depth) * omega, np.log(x)))
