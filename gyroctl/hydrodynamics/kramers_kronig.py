"""Kramers-Kronig relation between radiation damping and added mass; the added mass at infinite frequency from it.

    A(w) - A_inf = (2/pi) PV int_0^inf B(u) / (u^2 - w^2) du

Since PV int du/(u^2 - w^2) vanishes, B(w) may be subtracted from B(u): the integrand is then smooth and every tabulated
frequency gives its own estimate of A_inf. That they agree is a test of the whole table.
"""

from __future__ import annotations

import numpy as np

from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.table import Floats

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def _panels(edges: Floats) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights on consecutive intervals; no node ever falls on an edge."""
    half = 0.5 * np.diff(edges)[:, None]
    middle = 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * _NODES).ravel(), (half * _WEIGHTS).ravel()


def dispersion(omega: Floats, damping: Floats) -> Floats:
    """A(w) - A_inf at the tabulated frequencies, from the damping alone.

    Parameters
    ----------
    omega : ndarray (n,)
        Increasing positive frequencies. [rad/s]
    damping : ndarray (n,)
        Radiation damping, continued below the table by the power law of its first points, above by that of its last.

    Returns
    -------
    ndarray (n,)
        In the unit of damping times seconds.
    """
    u, du = _panels(omega)
    values = spline(omega, damping, u)
    first, last = omega[0], omega[-1]
    below, dbelow = _panels(np.linspace(0.0, 1.0, 3) * first)
    rise = max(_slope(omega[:3], damping[:3]), 0.0)
    x, dx = _panels(np.linspace(0.0, 1.0, 6))  # the tail, u = last / x
    fall = min(_slope(omega[-4:], damping[-4:]), -0.5)
    u = np.concatenate([below, u, last / x])
    du = np.concatenate([dbelow, du, last / x**2 * dx])
    values = np.concatenate([damping[0] * (below / first) ** rise, values, damping[-1] * x**-fall])
    integrand = (values[None, :] - damping[:, None]) / (u[None, :] ** 2 - omega[:, None] ** 2)
    return np.asarray(2.0 / np.pi * integrand @ du, dtype=np.float64)


def _slope(omega: Floats, damping: Floats) -> float:
    """Exponent of the power law through a few points."""
    if np.any(damping <= 0.0):
        return 0.0
    x, y = np.log(omega), np.log(damping)
    return float(np.sum((x - x.mean()) * (y - y.mean())) / np.sum((x - x.mean()) ** 2))


def added_mass_inf(omega: Floats, added_mass: Floats, damping: Floats) -> tuple[float, float]:
    """Return the added mass at infinite frequency and the spread of its estimates over the table.

    Parameters
    ----------
    omega, added_mass, damping : ndarray (n,)
        The table of one direction.

    Returns
    -------
    tuple of float
        Median of the estimates over the frequencies where the damping carries the table, and their largest departure
        from it, relative.
    """
    estimates = added_mass - dispersion(omega, damping)
    low, high = 0.05 * omega[-1] * (1.0 - 1e-6), 0.75 * omega[-1] * (1.0 + 1e-6)  # whatever the digits of a file
    carried = (omega >= low) & (omega <= high)  # away from both continuations
    chosen = estimates[carried] if np.any(carried) else estimates
    value = float(np.median(chosen))
    departure = float(np.max(np.abs(chosen - value)))
    return value, departure / abs(value) if departure > 0.0 else 0.0


def both_added_mass_inf(omega: Floats, added_mass: Floats, damping: Floats) -> Floats:
    """Return the added mass of both rotations at infinite frequency, (2,), from matrices (n, 2, 2)."""
    return np.array([added_mass_inf(omega, added_mass[:, j, j], damping[:, j, j])[0] for j in range(2)])
