"""The fit of the reduced wetted surface to the panels of any float."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.reduced import ReducedSurface
from gyroctl.hydrodynamics.table import Hydrodynamics
from gyroctl.waves.pressure import pressure_rows, wetted_surface
from gyroctl.waves.spectrum import SeaState

Floats = NDArray[np.float64]

DEGREES = (4, 5)
"""Highest powers of the immersion in R1 and R3."""

HEIGHTS = (0.25, 0.5, 0.75)
"""Significant heights of the seas, over the height of the hull."""

PEAK = 0.754
"""Peak frequency, over sqrt(g / height of the hull)."""

SCATTER = 0.18
"""Standard deviation of the immersion, over the way from fully under to dry."""

SOFT = 0.04
"""Width of the clip, over the same way."""

SAMPLES, SEED = 6000, 14


class Drawn(NamedTuple):
    """Instants in random waves: linear moments (2, n), angle (n,), and what the panels add (2, n)."""

    linear: Floats
    phi3: Floats
    added: Floats


def fit_wetted(hydro: Hydrodynamics, hs: float | None = None, wp: float | None = None) -> Hydrodynamics:
    """Fit the reduced wetted surface and keep it with the table.

    Instants are drawn from random seas of three heights, at positions whose immersion scatters from fully under to dry
    independently of the waves: no device enters, the fit is the float's.

    Parameters
    ----------
    hydro : Hydrodynamics
        With hull.
    hs : float, optional
        Middle of the three significant wave heights; half the height of the hull where it is not given. [m]
    wp : float, optional
        Peak frequency; from the size of the hull where it is not given. [rad/s]

    Returns
    -------
    Hydrodynamics
        With `wetted`, whose errors are those on the instants that were fitted.

    Raises
    ------
    InputError
        Field ``plant.wetted``: the table holds no hull.
    """
    hull = hydro.with_hull("wetted")
    tall = float(np.ptp(hull.vertices[:, 2]))
    middle = hs or HEIGHTS[1] * tall
    heights = [middle * share / HEIGHTS[1] for share in HEIGHTS]
    peak = wp or PEAK * float(np.sqrt(hydro.g / tall))
    low, high = ends(hull)
    surface = wetted_surface(hull, hydro.depth, 0.0, hydro.rho, hydro.g)
    rng = np.random.default_rng(SEED)
    parts = [draw(surface, SeaState(hs=h, wp=peak), SCATTER * (high - low), rng, hydro.g) for h in heights]
    linear, phi3, added = (np.concatenate([part[i] for part in parts], axis=-1) for i in range(3))
    fit = fitted(Drawn(linear, phi3, added), low, high, SOFT * (high - low), surface.stiffness)
    return replace(hydro, wetted=fit._replace(hs=max(heights), wp=peak))


def ends(hull: Hull) -> tuple[float, float]:
    """Angles phi3 at which the float is just under still water, and just out of it. [rad]"""
    offset = hull.vertices - hull.hinge

    def heights(angle: float) -> Floats:
        return np.asarray(hull.hinge[2] + np.sin(angle) * offset[:, 1] + np.cos(angle) * offset[:, 2])

    def root(end: float, extreme: Any) -> float:
        inner, outer = 0.0, end
        for _ in range(60):
            middle = 0.5 * (inner + outer)
            inner, outer = (middle, outer) if extreme(heights(middle)) * end < 0.0 else (inner, middle)
        return 0.5 * (inner + outer)

    return root(-1.5, np.max), root(1.5, np.min)


def draw(surface: Any, sea: SeaState, scatter: float, rng: np.random.Generator, g: float = 9.81) -> Drawn:
    """Draw instants of a sea, with the immersion scattered by `scatter` [rad]; the float is not displaced."""
    from gyroctl.plant.wetted import ALONG, PRESSURE, ROWS, evaluate

    omega = np.asarray(2.0 * np.pi / 500.0 * np.arange(1, 1001) * sea.wp / 3.14, dtype=np.float64)
    amplitude = np.sqrt(2.0 * sea.spectrum(omega) * omega[0]) * np.exp(2j * np.pi * rng.uniform(size=omega.size))
    waves = pressure_rows(surface, omega, g) * amplitude
    time = rng.uniform(0.0, 2.0 * np.pi / omega[0], SAMPLES)
    rows = np.empty((SAMPLES, ROWS))
    for some in np.array_split(np.arange(SAMPLES), 12):
        rows[some] = (waves @ np.exp(1j * omega[:, None] * time[some])).real.T
    linear = rows[:, [PRESSURE, PRESSURE + ALONG]].T
    phi3 = linear[1] / surface.stiffness + rng.normal(0.0, scatter, SAMPLES)
    added = np.empty((2, SAMPLES))
    evaluate(surface, np.zeros(SAMPLES), phi3, rows, added)
    return Drawn(linear, phi3, added)


def fitted(drawn: Drawn, low: float, high: float, soft: float, stiffness: float) -> ReducedSurface:
    """Least squares of both polynomials."""
    from gyroctl.plant.reduced import clipped, reduced

    bare = ReducedSurface((0.0,), (0.0,), low, high, soft, stiffness, 0.0, 0.0, 0.0, 0.0)
    raw = drawn.phi3 - drawn.linear[1] / stiffness
    x = np.asarray(clipped(reduced(bare, False), raw))
    basis1 = drawn.linear[0] * x ** np.arange(1, DEGREES[0] + 1)[:, None]
    basis3 = -stiffness * x ** np.arange(2, DEGREES[1] + 1)[:, None]
    rest = drawn.added[1] + stiffness * (x - raw)
    moment1, moment3 = (np.linalg.lstsq(b.T, y, rcond=None)[0] for b, y in ((basis1, drawn.added[0]), (basis3, rest)))
    miss = drawn.added[0] - moment1 @ basis1, rest - moment3 @ basis3
    error1, error3 = (float(np.sqrt(np.mean(m**2) / np.mean(y**2))) for m, y in zip(miss, drawn.added, strict=True))
    return bare._replace(
        moment1=tuple(map(float, moment1)), moment3=tuple(map(float, moment3)), error1=error1, error3=error3
    )
