"""Dispersion of linear waves at any depth: wavenumber and group velocity."""

from __future__ import annotations

import numpy as np

from gyroctl.hydrodynamics.table import Floats


def wavenumber(omega: Floats, depth: float, g: float = 9.81) -> Floats:
    """Solve w^2 = g k tanh(k h) by Newton's method.

    Parameters
    ----------
    omega : ndarray (n,)
        Frequencies. [rad/s]
    depth : float
        Water depth, ``inf`` for deep water. [m]
    g : float
        Gravity. [m/s^2]

    Returns
    -------
    ndarray (n,)
        Wavenumbers. [rad/m]
    """
    deep = np.asarray(omega, dtype=np.float64) ** 2 / g
    if not np.isfinite(depth):
        return deep
    target = deep * depth
    x = np.maximum(target, np.sqrt(target))  # above the root, from where Newton descends monotonically
    for _ in range(50):
        t = np.tanh(x)
        x = x - (x * t - target) / (t + x * (1.0 - t**2))
    return np.asarray(x / depth, dtype=np.float64)


def group_velocity(omega: Floats, depth: float, g: float = 9.81) -> Floats:
    """Return the group velocity dw/dk. (n,) [m/s]."""
    k = wavenumber(omega, depth, g)
    if not np.isfinite(depth):
        return np.asarray(0.5 * omega / k, dtype=np.float64)
    kh = np.minimum(k * depth, 300.0)
    return np.asarray(0.5 * omega / k * (1.0 + 2.0 * kh / np.sinh(2.0 * kh)), dtype=np.float64)
