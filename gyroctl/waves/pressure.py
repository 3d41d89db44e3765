"""Pressure of the undisturbed waves around the float as polynomials in place, instant by instant.

The head of a component is ``a exp(i (w t - k xi)) cosh(k (h + z)) / cosh(k h)``, xi along the waves. Its polynomials
are a truncated Jacobi-Anger series along the waves and a least-squares fit down, exact at z = 0, where the head is the
elevation. They are linear in the component, so that a row of coefficients is a signal like the moments, and comes from
the same components: no sum of cosines at a panel. Waves beyond `SHORTEST` are too short for the polynomials and too
small to matter beyond their linear moments: they are left out here, and so is the linear part that is taken off.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.panels import Hull

if TYPE_CHECKING:
    from gyroctl.plant.wetted import Surface

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

SHORTEST = 5.4
"""Largest k times half the range of the polynomials: up to 8 rad/s on the shipped float. [rad]"""

SWING = 0.5
"""The polynomials reach as far along the waves as the hull at phi1 of this size. [rad]"""


def wetted_surface(
    hull: Hull, depth: float, heading: float = 0.0, rho: float = 1000.0, g: float = 9.81, length: float = 1.0
) -> Surface:
    """Prepare a hull for the compiled evaluation.

    Parameters
    ----------
    hull : Hull
        Panels and hinge.
    depth : float
        Water depth, ``inf`` for deep water. [m]
    heading : float
        Direction the waves travel to. [deg]
    rho, g : float
        Density of the water [kg/m^3] and gravity [m/s^2].
    length : float
        Length of the device over that of Table 1. [-]

    Returns
    -------
    Surface
    """
    from gyroctl.plant.wetted import CHUNK, ROWS, Surface, evaluate

    centres, normals, spread = hull.patches
    count = -(-len(centres) // CHUNK) * CHUNK
    turning = np.cross(centres, normals)
    place, weight, extent = np.zeros((3, 3, count))
    place[:, : len(centres)] = centres.T
    weight[:, : len(centres)] = rho * g * np.stack([turning[:, 1], turning[:, 2], -turning[:, 0]])
    extent[0], extent[2] = 1e-12 * length**2, 1e-12 * length**2  # empty panels divide by their extent too
    # a panel counts as one whose height is spread evenly with the same variance: half width^2 = 3 variance
    extent[:, : len(centres)] += 3.0 * np.stack([spread[:, 1, 1], spread[:, 1, 2], spread[:, 2, 2]])
    angle = np.deg2rad(heading)
    tall = float(np.ptp(hull.vertices[:, 2]))
    bare = Surface(
        place=place,
        weight=weight,
        spread=extent,
        hinge_y=float(hull.hinge[1]),
        hinge_z=float(hull.hinge[2]),
        reach=hull.reach,
        along=float(np.cos(angle)),
        across=float(np.sin(angle)),
        span=half_range(hull),
        below=min(tall, depth),
        shallow=1.0 / depth,
        still=0.0,
        stiffness=0.0,
    )
    step, out = 1e-3, np.empty((2, 3))
    evaluate(bare, np.zeros(3), np.array([-step, 0.0, step]), np.zeros((3, ROWS)), out)
    return bare._replace(still=float(out[1, 1]), stiffness=float(out[1, 0] - out[1, 2]) / (2.0 * step))


def pressure_rows(surface: Surface, omega: Floats, g: float = 9.81) -> Complexes:
    """Polynomials of waves of amplitude 1.

    Parameters
    ----------
    surface : Surface
        Gives place, site and heading.
    omega : ndarray (k,)
        Frequencies. [rad/s]
    g : float
        Gravity. [m/s^2]

    Returns
    -------
    complex ndarray (ROWS, k)
        Pressure head [m/m], then the linear moments over displacement [Nm/m]; time factor exp(+i w t).
    """
    from gyroctl.plant.wetted import ALONG, DOWN, PRESSURE, ROWS

    rows = np.zeros((ROWS, len(omega)), dtype=np.complex128)
    depth = 1.0 / surface.shallow if surface.shallow > 0.0 else float("inf")
    k = wavenumber(np.asarray(omega, dtype=np.float64), depth, g)
    inside = followed(k, surface.span)
    k = k[inside]
    along, down = powers_along(k * surface.span, ALONG), powers_down(k * surface.below, k * depth, DOWN)
    head = (down[:, None, :] * along[None, :, :]).reshape(PRESSURE, -1)
    at_rest = linear_moments(surface) @ head
    rows[:PRESSURE, inside] = head
    rows[PRESSURE:, inside] = (at_rest[:, None, :] * along[None, :, :]).reshape(2 * ALONG, -1)
    return rows


def half_range(hull: Hull) -> float:
    """Half the range of the polynomials along the waves: as far as the hull comes. [m]"""
    size = float(np.max(np.hypot(hull.vertices[:, 0], hull.vertices[:, 1])))
    return size + hull.reach * float(np.sin(SWING))


def followed(k: Floats, span: float) -> NDArray[np.bool_]:
    """Which waves of wavenumber `k` [rad/m] are long enough for polynomials over half a range of `span` [m]."""
    return np.asarray(k * span <= SHORTEST)


def linear_moments(surface: Surface) -> Floats:
    """Linear Froude-Krylov moments at rest of each polynomial, (2, PRESSURE): what turns heads into moments. [Nm/m]

    Panels that the still water cuts count as in `surface_moments`, of which this is the exact derivative.
    """
    from gyroctl.plant.wetted import ALONG, DOWN

    x, y, z = surface.place
    height = surface.hinge_z + z
    half = np.sqrt(surface.spread[2])
    wet = np.clip((half - height) / (2.0 * half), 0.0, 1.0)
    place = (surface.along * x + surface.across * (y + surface.hinge_y)) / surface.span
    low = np.clip(height / surface.below, -1.0, 0.0)
    powers = (low ** np.arange(DOWN)[:, None])[:, None] * np.clip(place, -1.0, 1.0) ** np.arange(ALONG)[:, None]
    return np.asarray(np.einsum("jn,n,pqn->jpq", surface.weight[1:], wet, powers).reshape(2, -1))


def powers_along(kL: Floats, count: int) -> Complexes:
    """Return powers of s in exp(-i kL s) on [-1, 1], (count, k), from the Jacobi-Anger series."""
    from scipy.special import jv

    order = np.arange(count)
    series = np.where(order == 0, 1.0, 2.0)[:, None] * (-1j) ** order[:, None] * jv(order[:, None], kL[None, :])
    powers = np.zeros((count, count))
    for m in order:
        powers[: m + 1, m] = np.polynomial.chebyshev.cheb2poly(np.eye(count)[m])[: m + 1]
    return np.asarray(powers @ series, dtype=np.complex128)


def powers_down(kD: Floats, kh: Floats, count: int) -> Floats:
    """Return powers of z in cosh(k (h + D z)) / cosh(k h) on [-1, 0], (count, k); 1 at z = 0."""
    z = -0.5 * (1.0 - np.cos(np.pi * (np.arange(40) + 0.5) / 40.0))  # Chebyshev's points weigh the ends
    sink = kD[None, :] * z[:, None]
    echo = np.exp(-2.0 * kh)[None, :]  # 0 in deep water
    truth = (np.exp(sink) + echo * np.exp(-sink)) / (1.0 + echo)
    basis = z[:, None] ** np.arange(1, count)
    fitted, *_ = np.linalg.lstsq(basis, truth - 1.0, rcond=None)
    return np.concatenate([np.ones((1, len(kD))), fitted])
