"""Pressure of the undisturbed waves and of still water over the instantaneously wetted surface: the compiled text.

The float stands at its true position, turned by phi1 about the vertical through the hinge and by phi3 about the lever's
horizontal normal. The pressure is a polynomial in place (see `gyroctl.waves.pressure`), stretched to the free surface
as Wheeler has it, J. D. Wheeler, Method for calculating forces produced by irregular waves, JPT 22 (1970). Only what
this adds to the linear terms is returned: those stay in the Runge-Kutta stages, where a stiffness that is held over a
step would be a delay, and a delayed stiffness feeds the motion.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import compiled, trigonometry
from gyroctl.plant.compiled import inlined, stamped
from gyroctl.plant.equations import PHI1, PHI3
from gyroctl.plant.lagrange import TAPS, lagrange_weights
from gyroctl.plant.trigonometry import cos_sin

Floats = NDArray[np.float64]

ALONG, DOWN = 11, 5
"""Coefficients of the pressure along the waves and down: degrees 10 and 4."""

PRESSURE = ALONG * DOWN
ROWS = PRESSURE + 2 * ALONG
"""Rows of the polynomials at an instant: pressure head, then the linear moments about x1 and x3 over displacement."""

CHUNK = 8
"""The number of panels is a multiple of this: sums run in eight lanes, in an order that is written here."""


class Surface(NamedTuple):
    """Panels of the float and the site, as the compiled evaluation reads them; n panels, a multiple of `CHUNK`."""

    place: Floats  # (3, n) centres from the hinge, lever at rest [m]
    weight: Floats  # (3, n) rho g times y and z of r x n A, and minus its x [N/m^2 m^3]
    spread: Floats  # (3, n) squares of half the vertical extent: times sin^2, sin cos, cos^2 of phi3 [m^2]
    hinge_y: float  # [m]
    hinge_z: float  # [m]
    reach: float  # horizontal distance from the hinge to the centre of the float [m]
    along: float  # cosine of the heading [-]
    across: float  # sine of the heading [-]
    span: float  # half range of the polynomials along the waves [m]
    below: float  # their range downwards [m]
    shallow: float  # 1/depth, 0 in deep water [1/m]
    still: float  # moment about x3 at rest in still water [Nm]
    stiffness: float  # of the panels about x3 [Nm/rad]


@inlined
def surface_moments(surface: Surface, phi1: float, phi3: float, head: Any, work: Any) -> Any:
    """Moments of all pressure on the wetted surface about x1 and the turned x3.

    Parameters
    ----------
    surface : Surface
        Panels and site.
    phi1, phi3 : float
        Position. [rad]
    head : (PRESSURE,) array or longer
        Pressure head of the waves, powers of depth outer, powers of place inner. [m]
    work : (7, n) array
        Working space.

    Returns
    -------
    M1, M3 : float
        [Nm]
    """
    n = surface.place.shape[1]
    (c1, s1), (c3, s3) = cos_sin(phi1), cos_sin(phi3)
    along, across, span = surface.along, surface.across, surface.span
    # place along the waves: x = c1 x' + s1 y'', y = hinge - s1 x' + c1 y'', with y'' = c3 y' - s3 z'
    ax = (along * c1 - across * s1) / span
    turned = (along * s1 + across * c1) / span
    ay, az, a0 = turned * c3, -turned * s3, across * surface.hinge_y / span
    hinge_z, per_depth, shallow = surface.hinge_z, 1.0 / surface.below, surface.shallow
    px, py, pz = surface.place[0], surface.place[1], surface.place[2]
    place, height, q0, q1, q2, q3, q4 = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    top = ALONG - 1
    h0, h1, h2, h3, h4 = (
        head[top],
        head[ALONG + top],
        head[2 * ALONG + top],
        head[3 * ALONG + top],
        head[4 * ALONG + top],
    )
    for i in range(n):
        place[i] = min(max(ax * px[i] + ay * py[i] + az * pz[i] + a0, -1.0), 1.0)
        height[i] = hinge_z + s3 * py[i] + c3 * pz[i]
        q0[i], q1[i], q2[i], q3[i], q4[i] = h0, h1, h2, h3, h4
    for m in range(ALONG - 2, -1, -1):  # Horner along the waves, for each power of the depth
        h0, h1, h2, h3, h4 = head[m], head[ALONG + m], head[2 * ALONG + m], head[3 * ALONG + m], head[4 * ALONG + m]
        for i in range(n):
            x = place[i]
            q0[i] = q0[i] * x + h0
            q1[i] = q1[i] * x + h1
            q2[i] = q2[i] * x + h2
            q3[i] = q3[i] * x + h3
            q4[i] = q4[i] * x + h4
    ss, sc, cc = s3 * s3, 2.0 * s3 * c3, c3 * c3
    yy, yz, zz = surface.spread[0], surface.spread[1], surface.spread[2]
    for i in range(n):
        elevation = q0[i]
        stretched = min((height[i] - elevation) * per_depth / (1.0 + elevation * shallow), 0.0)
        z = max(stretched, -1.0)
        pressure = (((q4[i] * z + q3[i]) * z + q2[i]) * z + q1[i]) * z + elevation - height[i]
        # mean of max(pressure, 0) over a panel of this half extent: a panel that the surface cuts counts in part
        half = math.sqrt(ss * yy[i] + sc * yz[i] + cc * zz[i])
        cut = min(max(pressure, -half), half) + half
        place[i] = cut * cut / (4.0 * half) + max(pressure - half, 0.0)
    a, b, c = _sum(place, surface.weight[0]), _sum(place, surface.weight[1]), _sum(place, surface.weight[2])
    return s3 * a + c3 * b, c


@inlined
def _sum(values: Any, weights: Any) -> Any:
    """Sum of products, in eight lanes."""
    t0, t1, t2, t3, t4, t5, t6, t7 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(0, values.shape[0], CHUNK):
        t0 += values[i] * weights[i]
        t1 += values[i + 1] * weights[i + 1]
        t2 += values[i + 2] * weights[i + 2]
        t3 += values[i + 3] * weights[i + 3]
        t4 += values[i + 4] * weights[i + 4]
        t5 += values[i + 5] * weights[i + 5]
        t6 += values[i + 6] * weights[i + 6]
        t7 += values[i + 7] * weights[i + 7]
    return ((t0 + t4) + (t1 + t5)) + ((t2 + t6) + (t3 + t7))


@inlined
def beyond_linear(surface: Surface, phi1: float, phi3: float, rows: Any, work: Any) -> Any:
    """What the wetted surface adds to the linear terms: R1, R3. [Nm]

    `rows` (ROWS,) are the polynomials at the instant; the rest as in `surface_moments`. The linear Froude-Krylov
    moments that are taken off act at the same place: a plant whose moments stay at rest gives phi1 = 0 here.
    """
    moment1, moment3 = surface_moments(surface, phi1, phi3, rows, work)
    _, s1 = cos_sin(phi1)
    place = min(max(surface.reach * s1 * surface.along / surface.span, -1.0), 1.0)
    linear1, linear3 = rows[PRESSURE + ALONG - 1], rows[PRESSURE + 2 * ALONG - 1]
    for m in range(ALONG - 2, -1, -1):
        linear1 = linear1 * place + rows[PRESSURE + m]
        linear3 = linear3 * place + rows[PRESSURE + ALONG + m]
    return moment1 - linear1, moment3 - surface.still + surface.stiffness * phi3 - linear3


@stamped((compiled.__file__, trigonometry.__file__, __file__))
def evaluate(surface: Surface, phi1: Floats, phi3: Floats, rows: Floats, out: Floats) -> None:
    """Write R1, R3 of `beyond_linear` for many instants into `out` (2, n); phi1, phi3 (n,), rows (n, ROWS)."""
    work = np.empty((7, surface.place.shape[1]))
    for i in range(phi1.shape[0]):
        out[0, i], out[1, i] = beyond_linear(surface, phi1[i], phi3[i], rows[i], work)


class Pressure(NamedTuple):
    """Polynomials of the waves of some realisations, and room to evaluate them for one run after another."""

    rows: Floats  # (realisations, samples, ROWS)
    dt: float  # spacing of the samples [s]
    of_run: NDArray[np.int64]  # (L,) realisation of each run
    now: Floats  # (ROWS,) working space
    weight: Floats  # (TAPS,) working space
    work: Floats  # (7, n) working space
    turning: Any = None  # (3,) headings at the beginning and the end of a turn [rad] and its length [s]; None for none

    @classmethod
    def of(
        cls, surface: Surface, rows: Floats, dt: float, of_run: NDArray[np.int64], turning: Floats | None = None
    ) -> Pressure:
        """Return the polynomials with their working space."""
        work = np.empty((7, surface.place.shape[1]))
        return cls(rows, dt, of_run, np.empty(ROWS), np.empty(TAPS), work, turning)


@inlined
def facing(surface: Surface, turning: Any, t: float) -> Surface:
    """Surface as the waves meet it at time `t` [s]: the polynomials go along the waves, whichever way those travel."""
    if turning is None:
        return surface
    along, across = cos_sin(turning[0] + (turning[1] - turning[0]) * min(max(t / turning[2], 0.0), 1.0))
    return Surface(
        surface.place,
        surface.weight,
        surface.spread,
        surface.hinge_y,
        surface.hinge_z,
        surface.reach,
        along,
        across,
        surface.span,
        surface.below,
        surface.shallow,
        surface.still,
        surface.stiffness,
    )


class WettedSurface(NamedTuple):
    """Model of moments that are held from outside, see `gyroctl.plant.held`: the pressure over the wetted surface."""

    surface: Surface
    moving: float  # 1 where the float moves through the waves, else 0

    def moments(self, fields: Any, t: Any, x: Any, L: int, l: int) -> Any:
        """R1, R3 of a run at time `t` [s]. [Nm]"""
        position = t / fields.dt
        samples = fields.rows.shape[1]
        first = min(max(math.floor(position) - (TAPS // 2 - 1), 0), samples - TAPS)
        lagrange_weights(position - first, fields.weight)
        some = fields.rows[fields.of_run[l]]
        for row in range(ROWS):
            fields.now[row] = fields.weight[0] * some[first, row]
        for i in range(1, TAPS):
            for row in range(ROWS):
                fields.now[row] += fields.weight[i] * some[first + i, row]
        phi1, phi3 = self.moving * x[PHI1 * L + l], x[PHI3 * L + l]
        return beyond_linear(facing(self.surface, fields.turning, t), phi1, phi3, fields.now, fields.work)

    def along(self, fields: Pressure, time: Floats, x: Floats) -> Floats:
        """R1, R3 (2, m) of the first run at samples of its `time` (m,) [s] with the states `x` (n, m). [Nm]"""
        rows = fields.rows[fields.of_run[0]]
        before = np.minimum((time / fields.dt).astype(int), rows.shape[0] - 2)
        part = (time / fields.dt - before)[:, None]
        found = np.empty((2, time.size))
        between = (1.0 - part) * rows[before] + part * rows[before + 1]
        phi1, phi3 = self.moving * x[PHI1], np.array(x[PHI3])
        if fields.turning is None:
            evaluate(self.surface, phi1, phi3, between, found)
            return found
        for i, t in enumerate(time):
            there, at = np.empty((2, 1)), slice(i, i + 1)
            evaluate(facing(self.surface, fields.turning, float(t)), phi1[at], phi3[at], between[at], there)
            found[:, at] = there
        return found
