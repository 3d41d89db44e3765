"""Runge-Kutta 4 in lanes of which each is at a time of its own and takes a step of its own.

Closed loops need it: after a switch of its coupling a run takes up to eight times the steps of the others, and where
all waited for it they would pay for it. The arithmetic of a lane is that of `kernel.advance`, to the last bit, for
plants without terms beyond the linear model and controls that are held.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import aligned, inlined
from gyroctl.plant.equations import LEDGER, Coefficients, derivative
from gyroctl.plant.kernel import LANES
from gyroctl.plant.lagrange import TAPS, weights_at

Floats = NDArray[np.float64]


class LaneState(NamedTuple):
    """State and working space of LANES runs; entry `row` of a run stands at ``row * LANES + lane``."""

    y: Floats  # state and ledger
    x: Floats  # state at a stage
    slope: Floats  # (4, rows * LANES)
    moments: Floats  # Me1 and Me3 at the start, the middle and the end of the step [Nm]
    taps: Floats  # samples around the instant: Me1 and Me3 of each in turn [Nm]
    cell: Floats  # number of the first of them
    first: Floats  # the same at the instant
    place: Floats  # of the instant, counted from it [grid steps]
    cc: Floats  # [Nms]
    cg: Floats  # [Nms]
    start: Floats  # beginning of the interval [s]
    step: Floats  # steps done in it
    h: Floats  # length of a step, 0 for a lane at rest [s]
    ahead: Floats  # the same for each row: in one loop over all rows no index has to be taken apart
    sixth: Floats  # and a sixth of it


@inlined
def lane_state(rows: int) -> LaneState:
    """Room for LANES runs of so many rows, all at rest."""
    L, size = LANES, rows * LANES
    y, x, slope = aligned(size), aligned(size), aligned(4 * size).reshape(4, size)
    moments, taps = aligned(6 * L), aligned(2 * TAPS * L)
    cell, first, place, cc, cg = aligned(L), aligned(L), aligned(L), aligned(L), aligned(L)
    start, step, h = aligned(L), aligned(L), aligned(L)
    lanes = LaneState(
        y, x, slope, moments, taps, cell, first, place, cc, cg, start, step, h, aligned(size), aligned(size)
    )
    for l in range(L):
        cell[l], cc[l], cg[l] = -1.0, 0.0, 0.0
        set_out(lanes, l, 0.0, 0.0)
    return lanes


@inlined
def set_out(lanes: LaneState, l: int, start: float, h: float) -> None:
    """Let lane `l` begin an interval at the time `start` with steps of `h`. [s]"""
    lanes.start[l], lanes.step[l], lanes.h[l] = start, 0.0, h
    for row in range(lanes.y.size // LANES):
        lanes.ahead[row * LANES + l], lanes.sixth[row * LANES + l] = h, h / 6.0


@inlined
def step_lanes(lanes: LaneState, k: Coefficients, waves: Floats, waves_dt: float) -> None:
    """Take a step in every lane.

    `waves` (LANES, 2 n) holds the moments of each run, sample by sample [Nm], every `waves_dt` [s]. Those at the start
    of an interval have to be there, see `moments_at`.
    """
    L, y, x, moments, ahead, sixth = LANES, lanes.y, lanes.x, lanes.moments, lanes.ahead, lanes.sixth
    size = y.size
    states = size - len(LEDGER) * L
    moments_at(lanes, waves, waves_dt, 1)
    moments_at(lanes, waves, waves_dt, 2)
    for i in range(states):
        x[i] = y[i]
    for stage in range(4):
        part = 0.5 if stage < 2 else 1.0
        point = (stage + 1) // 2 * 2 * L
        dx = lanes.slope[stage]
        for l in range(L):
            me1, me3 = moments[point + l], moments[point + L + l]
            derivative(x, dx, L, l, k, lanes.cc[l], lanes.cg[l], me1, me3)
        if stage < 3:
            for i in range(states):
                x[i] = y[i] + part * ahead[i] * dx[i]
    first, second, third, fourth = lanes.slope[0], lanes.slope[1], lanes.slope[2], lanes.slope[3]
    for i in range(size):
        y[i] = y[i] + sixth[i] * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
    for i in range(2 * L):
        moments[i] = moments[4 * L + i]
    for l in range(L):
        lanes.step[l] += 1.0


@inlined
def moments_at(lanes: LaneState, waves: Floats, waves_dt: float, instant: int) -> None:
    """Write the moments of every lane at the start, the middle or the end, 0, 1 or 2, of its step."""
    L, last = LANES, float(waves.shape[1] // 2 - TAPS)
    ahead = 0.5 * instant
    for l in range(L):
        position = (lanes.start[l] + (lanes.step[l] + ahead) * lanes.h[l]) / waves_dt
        lanes.first[l] = min(max(math.floor(position) - (TAPS // 2 - 1), 0.0), last)
        lanes.place[l] = position - lanes.first[l]
    for l in range(L):
        if lanes.first[l] != lanes.cell[l]:  # every fifth step or less: put its samples beside the others'
            lanes.cell[l] = lanes.first[l]
            at = 2 * int(lanes.first[l])
            for i in range(2 * TAPS):
                lanes.taps[i * L + l] = waves[l, at + i]
    taps, to = lanes.taps, lanes.moments[2 * L * instant :]
    for l in range(L):
        w0, w1, w2, w3, w4, w5, w6, w7 = weights_at(lanes.place[l])
        total = w0 * taps[l] + w1 * taps[2 * L + l] + w2 * taps[4 * L + l] + w3 * taps[6 * L + l]
        total = total + w4 * taps[8 * L + l] + w5 * taps[10 * L + l] + w6 * taps[12 * L + l]
        to[l] = total + w7 * taps[14 * L + l]
        total = w0 * taps[L + l] + w1 * taps[3 * L + l] + w2 * taps[5 * L + l] + w3 * taps[7 * L + l]
        total = total + w4 * taps[9 * L + l] + w5 * taps[11 * L + l] + w6 * taps[13 * L + l]
        to[L + l] = total + w7 * taps[15 * L + l]
