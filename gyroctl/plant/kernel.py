"""Runge-Kutta 4 over one interval of held controls, for one run or for many side by side: the one text.

The moments are given on a coarse grid (0.05 s is 40 samples per wave at the peak frequency) and interpolated by a
Lagrange polynomial on eight samples: error 4e-7 of their standard deviation, 2e-6 at its worst, in the broadest sea
(gamma 1), and no sum of cosines in the loop.
The energy ledger is integrated by the same Runge-Kutta steps as the state: its error is of the same order, also
across the switching of the controls, where a trapezoid would miss the transient of the slip.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import (
    beyond,
    compiled,
    course,
    equations,
    friction,
    gripping,
    hyperbolic,
    instants,
    lagrange,
    packs,
    reduced,
    trigonometry,
    wetted,
)
from gyroctl.plant import held as holding
from gyroctl.plant import near as nearby
from gyroctl.plant.beyond import BEYOND, signal_room, signal_rows
from gyroctl.plant.compiled import aligned, inlined, put, stamped
from gyroctl.plant.course import Course, control_at, effective, lag_rate, next_bend
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PHI1, PHI3, PSI, Coefficients, derivative, powers, states_of
from gyroctl.plant.friction import axis_gear, contact_of
from gyroctl.plant.gripping import substeps
from gyroctl.plant.instants import follow, hold_on, interpolate, stand_at
from gyroctl.plant.lagrange import TAPS
from gyroctl.plant.packs import LANES as LANES

Array = NDArray[Any]
Floats = NDArray[np.float64]

RECORDED = (PHI1, PHI3, PSI, OMEGA_RATE)
"""Rows that `run_lanes` writes down."""

ACCURATE = 50.0
"""Largest product of step and slip rate in `steps_for`, per second of `dt`: 0.5 at dt = 0.01 s, which keeps the ledger
closed to 1e-6 under a steady coupling; where it switches the closed loop asks for more. A longer `dt` asks for less
accuracy here as well. [1/s]"""

LAGGED = 2.0
"""How much finer a lag is resolved than the slip at the same rate: Runge-Kutta sees it as Simpson's rule does."""

SOURCES = (
    *(
        compiled.__file__,
        packs.__file__,
        trigonometry.__file__,
        hyperbolic.__file__,
        beyond.__file__,
        friction.__file__,
        equations.__file__,
    ),
    *(course.__file__, gripping.__file__, nearby.__file__, holding.__file__, lagrange.__file__),
    *(reduced.__file__, wetted.__file__, instants.__file__, __file__),
)


@inlined
def slip_rate(k: Coefficients, cc: Any) -> Any:
    """Rate at which the slip decays: cc (N^2/J2 + 1/J4), zero where the flywheel is rigidly geared. [1/s]

    Where the spin axis may slip on its track, that of the axis alone.
    """
    N = axis_gear(contact_of(k.beyond), k.N)
    return cc * (N * N * k.Gpp - 2.0 * N * k.Gpo + k.Goo)


@inlined
def steps_for(hold: float, dt: float, rate: float) -> int:
    """Number of equal steps over `hold` [s]: none longer than `dt` [s], none longer than the slip allows.

    `rate` [1/s] is in units of the device's own time, the slip's times `Parameters.time_scale`: at another size the
    same accuracy is asked for.
    """
    return max(int(math.ceil(hold / dt - 1e-9)), int(math.ceil(hold * rate / (ACCURATE * dt) - 1e-9)), 1)


@inlined
def advance(
    y: Any,
    x: Any,
    slope: Any,
    moments: Any,
    weight: Any,
    L: int,
    k: Coefficients,
    cc: Any,
    cg: Any,
    start: float,
    hold: float,
    steps: int,
    waves: Any,
    waves_dt: float,
    moving: Any = None,
    since: float = 0.0,
    held: Any = None,
    more: Any = None,
) -> None:
    """Advance L runs by `hold` seconds in `steps` equal Runge-Kutta steps with constant `cc`, `cg`, or moving ones.

    Where there is friction in the contact, of a single run, each step is taken in as many as that needs.

    Parameters
    ----------
    y : (rows * L,) array
        State and ledger, changed in place.
    x : (rows * L,) array
        Working space: state at a stage. Apart from `y`, so that the compiler may vectorise.
    slope : (4, rows * L) array
        Working space: slopes of the four stages.
    moments : (signal_room,) array
        Working space: signals at the start, the middle and the end of a step.
    weight : (8,) array
        Working space of the interpolation.
    cc, cg : (L,) arrays
        Controls. [Nms]
    start, hold : float
        Time at the start of the interval, its length. [s]
    waves : flat array
        Moments on the grid [Nm] and further signals, see `interpolate`.
    waves_dt : float
        Its spacing. [s]
    moving : Course, optional
        How the controls of a single run move: `cc`, `cg` then hold their values at `since`, and are working space.
    since : float
        Time between the start of that course and this interval. [s]
    held : Held, optional
        Moments that are held from outside.
    more : Beyond, optional
        `k.beyond`, as an argument of its own: what is off is compiled away.
    """
    whole, size = hold / steps, y.size
    signals, ledger = 2 * L, len(LEDGER) * L
    if more is not None:
        signals, ledger = signal_rows(more) * L, (len(LEDGER) + len(BEYOND)) * L
    states = size - ledger  # nothing depends on the ledger: its rows need no stages
    for i in range(states):
        x[i] = y[i]
    if more is not None:
        stand_at(more, x, L, moments, True)
    interpolate(waves, L, start / waves_dt, weight, moments, 0, more)
    for step in range(steps):
        finer = 1
        if more is not None:
            finer = substeps(more.contact, k, y, whole)
        h = whole / finer
        for part in range(finer):
            now, middle, after = step + part / finer, step + (part + 0.5) / finer, step + (part + 1.0) / finer
            if more is not None:
                follow(more, x, L, moments, waves, (start + now * whole) / waves_dt)
            interpolate(waves, L, (start + middle * whole) / waves_dt, weight, moments, 1, more)
            interpolate(waves, L, (start + after * whole) / waves_dt, weight, moments, 2, more)
            if held is not None:
                hold_on(more, held, start + now * whole, h, x, L, moments)
            for stage in range(4):
                ahead = 0.5 * h if stage < 2 else h
                point = (stage + 1) // 2 * signals
                dx = slope[stage]
                if moving is not None and stage % 2 == 1:  # the middle; the end, which is the start of the next step
                    cc[0], cg[0] = instant(moving, since + (middle if stage == 1 else after) * whole)
                for l in range(L):
                    me1, me3 = moments[point + l], moments[point + L + l]
                    derivative(x, dx, L, l, k, cc[l], cg[l], me1, me3, more, moments, point)
                if stage < 3:
                    for i in range(states):
                        x[i] = y[i] + ahead * dx[i]
            first, second, third, fourth = slope[0], slope[1], slope[2], slope[3]
            for i in range(size):
                y[i] = y[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
            for i in range(states):
                x[i] = y[i]
            for lane in range(signals):
                moments[lane] = moments[2 * signals + lane]


@stamped(SOURCES)
def hold_into(
    y: Array,
    work: Array,
    moments: Array,
    weight: Floats,
    k: Coefficients,
    controls: Array,
    start: float,
    hold: float,
    steps: int,
    waves: Array,
    waves_dt: float,
    held: Any = None,
) -> None:
    """Advance one run in place. `work` (5, rows), `controls` (2, 1); float or complex alike."""
    cc, cg = controls[0], controls[1]
    x, slope, moving, since, more = work[0], work[1:], None, 0.0, k.beyond
    advance(y, x, slope, moments, weight, 1, k, cc, cg, start, hold, steps, waves, waves_dt, moving, since, held, more)


@stamped(SOURCES)
def move_into(
    y: Floats,
    work: Floats,
    moments: Floats,
    weight: Floats,
    k: Coefficients,
    controls: Floats,
    moving: Course,
    start: float,
    hold: float,
    dt: float,
    finer: float,
    pace: float,
    waves: Floats,
    waves_dt: float,
    moved: Floats,
    held: Any = None,
) -> None:
    """Advance one run in place while its controls move, smooth piece by smooth piece.

    Parameters
    ----------
    y, work, moments, weight, k, start, hold, waves, waves_dt, held
        As in `hold_into`.
    controls : (2, 1) array
        Working space.
    moving : Course
        How the controls move from `start` on.
    dt : float
        Longest step. [s]
    finer : float
        How much finer the slip is resolved than under a steady coupling.
    pace : float
        Unit of time of the device over that of Table 1, see `steps_for`.
    moved : (3,) array
        Receives cc, cg at the end, and the root of the mean square of cg over the interval. [Nms]
    """
    cc, cg = controls[0], controls[1]
    x, slope, since, more = work[0], work[1:], 0.0, k.beyond
    while since < hold:
        until = next_bend(moving, since, hold)
        cc[0], cg[0] = instant(moving, since)
        largest = max(cc[0], control_at(moving, 0, until))  # the course is monotone
        rate = max(finer * slip_rate(k, largest), LAGGED * lag_rate(moving, since))
        steps = steps_for(until - since, dt, pace * rate)
        t, part = start + since, until - since
        advance(y, x, slope, moments, weight, 1, k, cc, cg, t, part, steps, waves, waves_dt, moving, since, held, more)
        since = until
    moved[0], moved[1] = instant(moving, hold)
    moved[2] = effective(moving, 1, hold)


@inlined
def instant(moving: Course, t: float) -> Any:
    """cc, cg `t` [s] after the start of their course. [Nms]"""
    return control_at(moving, 0, t), control_at(moving, 1, t)


def hold_one(
    y: Array, k: Coefficients, cc: Any, cg: Any, start: float, hold: float, steps: int, waves: Array, waves_dt: float
) -> Array:
    """Return state and ledger (rows,) after one held interval, see `advance`; float or complex."""
    out = y.copy()
    controls = np.array([[cc], [cg]], y.dtype)
    work = np.empty((5, y.size), y.dtype)
    moments = np.empty(signal_room(k.beyond, 1), waves.dtype)
    held = None  # told, or the compiled loop, which tells it, would need a function of its own
    hold_into(out, work, moments, np.empty(TAPS), k, controls, start, hold, steps, waves, waves_dt, held)
    return out


@stamped(SOURCES)
def run_lanes(
    y: Floats,
    k: Coefficients,
    cc: Floats,
    cg: Floats,
    hold: float,
    steps: int,
    waves: Floats,
    waves_dt: float,
    record: Floats,
    mark: int,
    marked: Floats,
    held: Any = None,
) -> None:
    """Run LANES runs with constant controls, in place.

    Parameters
    ----------
    y : (rows * LANES,) array
        State and ledger, those of the end afterwards.
    cc, cg, hold, steps, waves, waves_dt, held
        As in `advance`; every interval begins a `hold` after the one before, the first at 0.
    record : (len(RECORDED), intervals + 1, LANES) array
        Receives the rows `RECORDED` at both ends of every interval.
    mark : int
        Interval at whose beginning `marked`, of the shape of `y`, receives state and ledger.
    """
    now, x, slope = aligned(y.size), aligned(y.size), aligned(4 * y.size).reshape(4, y.size)
    moments, weight = aligned(signal_room(k.beyond, LANES)), np.empty(TAPS)
    moving, since, more = None, 0.0, k.beyond
    intervals = record.shape[1] - 1
    put(y, now)
    for i in range(intervals):
        if i == mark:
            put(now, marked)
        write_down(now, record, i)
        t, L = i * hold, LANES
        advance(
            now, x, slope, moments, weight, L, k, cc, cg, t, hold, steps, waves, waves_dt, moving, since, held, more
        )
    write_down(now, record, intervals)
    put(now, y)


@inlined
def write_down(y: Any, record: Any, i: int) -> None:
    """Copy the rows `RECORDED` into column `i` of the record."""
    for r in range(len(RECORDED)):
        for l in range(LANES):
            record[r, i, l] = y[RECORDED[r] * LANES + l]


def rows(k: Coefficients) -> int:
    """Rows of state and ledger together."""
    return states_of(k) + powers(k)
