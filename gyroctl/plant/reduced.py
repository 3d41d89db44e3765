"""The wetted surface reduced to polynomials, one text for NumPy, complex step, casadi and the kernels.

The clip of the immersion is smooth: sqrt(y^2 + soft^2) stands for |y|, shifted and scaled so that value and slope at
rest stay those of the linear plant.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gyroctl.plant.compiled import inlined

POWERS = 11
"""Coefficients of a moment over the reach of the lever: degree 10."""


class Reduced(NamedTuple):
    """Polynomials of a float; see `gyroctl.hydrodynamics.reduced.ReducedSurface`."""

    moment1: tuple[float, ...]  # highest power first, down to the first [-]
    moment3: tuple[float, ...]  # highest power first, down to the second [-]
    low: float  # [rad]
    high: float  # [rad]
    soft: float  # [rad]
    shift: float  # of the clip at rest [rad]
    scale: float  # 1/slope of the clip at rest [-]
    stiffness: float  # [Nm/rad]
    moving: Any = None  # polynomials of F1 and F3 in sin phi1 where the position moves: True, else None


def reduced(fit: Any, moving: bool) -> Reduced:
    """Prepare the polynomials of a fit for the equations."""
    low, high, soft = float(fit.low), float(fit.high), float(fit.soft)
    bare = Reduced((), (), low, high, soft, 0.0, 1.0, float(fit.stiffness))
    step = 1e-30j
    slope = float(np.imag(clipped(bare, step)) / 1e-30)
    return bare._replace(
        moment1=tuple(float(v) for v in reversed(fit.moment1)),
        moment3=tuple(float(v) for v in reversed(fit.moment3)),
        shift=float(np.real(clipped(bare, 0.0))),
        scale=1.0 / slope,
        moving=True if moving else None,
    )


@inlined
def clipped(r: Reduced, x: Any) -> Any:
    """Immersion between its two ends. [rad]"""
    below, above = x - r.low, r.high - x
    less = np.sqrt(below * below + r.soft * r.soft) - below
    more = np.sqrt(above * above + r.soft * r.soft) - above
    return (x + 0.5 * (less - more) - r.shift) * r.scale


def undisturbed_names(moving: Any) -> tuple[str, ...]:
    """Names of the signals of the linear Froude-Krylov moments."""
    if moving is None:
        return "F1", "F3"
    return tuple(f"{moment}^{i}" for moment in ("F1", "F3") for i in range(POWERS))


@inlined
def reduced_moments(r: Reduced, phi3: Any, f1: Any, f3: Any) -> Any:
    """What the wetted surface adds to the linear moments: R1, R3. [Nm]

    Parameters
    ----------
    r : Reduced
        The polynomials.
    phi3 : scalar
        Angle of the lever. [rad]
    f1, f3 : scalar
        Linear Froude-Krylov moments. [Nm]
    """
    raw = phi3 - f3 / r.stiffness
    x = clipped(r, raw)
    one, three = 0.0 * x, 0.0 * x
    for i in range(len(r.moment1)):
        one = (one + r.moment1[i]) * x
    for i in range(len(r.moment3)):
        three = (three + r.moment3[i]) * x
    return f1 * one, -r.stiffness * (three * x + x - raw)
