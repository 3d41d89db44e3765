"""The device with dry friction in the rolling contact, event by event: it sticks, slides, and changes sides.

Coulomb's law without smoothing. The axis sticks on one side of its track as long as friction can carry what rolling
needs; it slides with the full friction against its slip; where the moment that presses it changes its sign, it is on
the other side at once. Every such instant is found by bisection. The equations are balances of momentum with all five
accelerations and the friction as unknowns, the pressing moment with the accelerations in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]
PHI1, PHI3, PSI, V1, V3, RING, AXIS, FLYWHEEL, MEMORY = range(9)


class Device(NamedTuple):
    """Table 1 and what is derived from it."""

    inertia1: float  # of the lever with added inertia, about either axis [kg m^2]
    inertia3: float
    ring: float  # of ring and half of axis and flywheel, about the lever [kg m^2]
    K: float  # half of axis and flywheel [kg m^2]
    J13: float
    J14: float
    k1: float
    k3: float
    d1: float
    d3: float
    N: float
    traction: float
    p1: Array  # radiation
    q1: Array
    p3: Array
    q3: Array


class Passage(NamedTuple):
    """What came of a run.

    Attributes
    ----------
    states : ndarray, shape (n + 1, 14)
        phi1, phi3, psi, the rates of phi1, phi3, psi, theta, omega, radiation states; at the samples.
    side : ndarray, shape (n + 1,)
        1 where the axis would roll forwards, -1 backwards.
    rubbed : float
        Energy lost in the contact. [J]
    """

    states: Array
    side: Array
    rubbed: float


def device_of(plant: Any) -> Device:
    """Read the device off a plant's parameters."""
    p, (one, three) = plant.parameters, plant.radiation
    turning = (p.J13 + p.J14) / 2.0
    lever = p.J11 + p.J22 / 2.0 + turning + p.m1 * p.a**2 + (p.m2 + p.m3 + p.m4) * (p.a + p.b) ** 2
    inertia = lever + p.Jh1, lever + p.Jh3
    filters = (np.array(values, float) for values in (one.p, one.q, three.p, three.q))
    stiffness = p.k1, p.k3, p.d1, p.d3
    return Device(*inertia, p.J22 + turning, turning, p.J13, p.J14, *stiffness, p.r2 / p.r1, p.traction, *filters)


@njit
def memory(x: Any, first: int, p: Any, q: Any, rate: float, dx: Any) -> float:
    """Radiation moment of a filter, whose rates are written. [Nm]"""
    n = q.size
    moment = 0.0
    top = rate
    for i in range(n):
        top -= q[n - 1 - i] * x[first + i]
        if i < p.size:
            moment += p[p.size - 1 - i] * x[first + i]
        dx[first + i] = x[first + i + 1] if i < n - 1 else 0.0
    dx[first + n - 1] = top
    return moment


@njit
def motion(x: Any, d: Device, cc: float, cg: float, m1: float, m3: float, side: float, slips: float, dx: Any) -> Any:
    """Write the rates; return friction on the axis and pressing moment. `slips`: sign of the slip, 0 for sticking."""
    c, s = np.cos(x[PSI]), np.sin(x[PSI])
    v1, v3, w, axis, fly = x[V1], x[V3], x[RING], x[AXIS], x[FLYWHEEL]
    u1, u3 = c * v1 - s * v3, s * v1 + c * v3
    n1 = d.q1.size
    r1 = memory(x, MEMORY, d.p1, d.q1, v1, dx)
    r3 = memory(x, MEMORY + n1, d.p3, d.q3, v3, dx)
    spin = d.J13 * axis + d.J14 * fly
    coupling = cc * (fly - axis)
    A, b = np.zeros((6, 6)), np.zeros(6)
    # lever: its own momentum, that of axis and flywheel about their spin, and the gyroscopic moments
    A[0, 0], A[0, 1], A[0, 3], A[0, 4] = d.inertia1 + d.K * c * c, -d.K * c * s, c * d.J13, c * d.J14
    A[1, 0], A[1, 1], A[1, 3], A[1, 4] = -d.K * c * s, d.inertia3 + d.K * s * s, -s * d.J13, -s * d.J14
    b[0] = d.K * w * (s * u1 + c * u3) + s * spin * w + d.ring * w * v3 - d.k1 * x[PHI1] - d.d1 * v1 - r1 + m1
    b[1] = d.K * w * (c * u1 - s * u3) + c * spin * w - d.ring * w * v1 - d.k3 * x[PHI3] - d.d3 * v3 - r3 + m3
    # ring, axis, flywheel; the last unknown is the friction on the axis
    A[2, 2], A[2, 5] = d.ring, side * d.N
    b[2] = -(d.K * u1 + spin) * u3
    A[3, 0], A[3, 1], A[3, 3], A[3, 5] = d.J13 * c, -d.J13 * s, d.J13, -1.0
    b[3] = d.J13 * w * u3 + coupling
    A[4, 0], A[4, 1], A[4, 4] = d.J14 * c, -d.J14 * s, d.J14
    b[4] = d.J14 * w * u3 - coupling - cg * fly
    still = 2.0 * d.K * u1 * w - w * (d.J13 * (axis + u1) + d.J14 * (fly + u1))
    if slips == 0.0:
        A[5, 3], A[5, 2] = 1.0, -side * d.N
    else:  # the pressing moment has the opposite sign of the side
        share = slips * side * d.traction / d.N
        A[5, 5], A[5, 0], A[5, 1] = 1.0, -share * d.K * s, -share * d.K * c
        b[5] = share * still
    a = np.linalg.solve(A, b)
    dx[PHI1], dx[PHI3], dx[PSI] = v1, v3, w
    dx[V1], dx[V3], dx[RING], dx[AXIS], dx[FLYWHEEL] = a[0], a[1], a[2], a[3], a[4]
    return a[5], still + d.K * (s * a[0] + c * a[1])


@njit
def moment_at(spline: Any, row: int, t: float) -> float:
    """Cubic of a wave moment, on samples every 0.05 s. [Nm]"""
    i = min(int(t / 0.05), spline.shape[1] - 1)
    u = t - 0.05 * i
    return ((spline[0, i, row] * u + spline[1, i, row]) * u + spline[2, i, row]) * u + spline[3, i, row]


@njit
def step(x: Any, d: Device, cc: float, cg: float, spline: Any, t: float, h: float, side: float, slips: float) -> Any:
    """State after a Runge-Kutta step, and its power lost in the contact at the start."""
    k = np.zeros((4, x.size))
    at = x.copy()
    lost = 0.0
    for stage in range(4):
        s = t + (0.0 if stage == 0 else (h if stage == 3 else 0.5 * h))
        m1, m3 = moment_at(spline, 0, s), moment_at(spline, 1, s)
        friction, _ = motion(at, d, cc, cg, m1, m3, side, slips, k[stage])
        share = (1.0 if stage == 0 or stage == 3 else 2.0) * h / 6.0
        lost -= share * friction * (at[AXIS] - side * d.N * at[RING])
        if stage < 3:
            at = x + (h if stage == 2 else 0.5 * h) * k[stage]
    return x + h / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3]), lost


@njit
def broken(x: Any, d: Device, cc: float, cg: float, spline: Any, t: float, side: float, slips: float, room: Any) -> int:
    """Which event a state has passed: 1 the side, 2 the grip, 3 the end of a slip; 0 none."""
    friction, pressing = motion(x, d, cc, cg, moment_at(spline, 0, t), moment_at(spline, 1, t), side, slips, room)
    if pressing * side > 0.0:
        return 1
    if slips == 0.0:
        return 2 if abs(friction) * d.N > d.traction * abs(pressing) else 0
    return 3 if (x[AXIS] - side * d.N * x[RING]) * slips < 0.0 else 0


@njit
def advance(
    x: Any, d: Device, cc: float, cg: float, spline: Any, t: float, end: float, side: float, slips: float
) -> Any:
    """State, side and slip at `end`, and the energy lost in the contact on the way there."""
    room, total = np.zeros(x.size), 0.0
    longest = 0.002
    while t < end - 1e-12:
        h = min(longest, end - t)
        after, lost = step(x, d, cc, cg, spline, t, h, side, slips)
        event = broken(after, d, cc, cg, spline, t + h, side, slips, room)
        if event > 0:
            low, high = 0.0, h
            for _ in range(24):
                middle = 0.5 * (low + high)
                trial, _ = step(x, d, cc, cg, spline, t, middle, side, slips)
                if broken(trial, d, cc, cg, spline, t + middle, side, slips, room) > 0:
                    high = middle
                else:
                    low = middle
            h = high
            after, lost = step(x, d, cc, cg, spline, t, h, side, slips)
            event = broken(after, d, cc, cg, spline, t + h, side, slips, room)
        x, t, total = after, t + h, total + lost
        if event == 1:
            side = -side
            slips = 1.0 if x[AXIS] > side * d.N * x[RING] else -1.0
        elif event == 2:
            m1, m3 = moment_at(spline, 0, t), moment_at(spline, 1, t)
            friction, _ = motion(x, d, cc, cg, m1, m3, side, 0.0, room)
            slips = -1.0 if friction > 0.0 else 1.0
        elif event == 3:
            x[AXIS] = side * d.N * x[RING]
            slips = 0.0 if broken(x, d, cc, cg, spline, t, side, 0.0, room) == 0 else -slips
    return x, side, slips, total


def run(plant: Any, start: Array, waves: Any, command: Callable[[float, Array], tuple[float, float]]) -> Passage:
    """Run the device for as long as the waves last, controls held for 0.1 s.

    Parameters
    ----------
    plant : Plant
        Gives Table 1 and the traction.
    start : ndarray
        State of the plant at t = 0, which rolls.
    waves : WaveRealisation
        Its moments, on a grid of 0.05 s.
    command : callable
        (time [s], state as in `Passage`) -> (cc, cg) [Nms].
    """
    d = device_of(plant)
    count = d.q1.size + d.q3.size
    x = np.concatenate([start[:3], start[4:7], [d.N * start[6], start[7]], start[8 : 8 + count]])
    spline = np.ascontiguousarray(CubicSpline(waves.time, waves.moments.T).c)
    samples, side, slips, rubbed = round(waves.duration / 0.1), 1.0, 0.0, 0.0
    states, sides = [x], [side]
    for i in range(samples):
        cc, cg = command(0.1 * i, x)
        x, side, slips, lost = advance(x, d, cc, cg, spline, 0.1 * i, 0.1 * (i + 1), side, slips)
        states.append(x)
        sides.append(side)
        rubbed += lost
    return Passage(np.array(states), np.array(sides), rubbed)
