"""Runge-Kutta 4 in lanes of which each is at a time of its own and takes a step of its own.

Closed loops need it: after a switch of its coupling a run takes up to eight times the steps of the others, and where
all waited for it they would pay for it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import aligned, inlined
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.lagrange import TAPS, weights_at
from gyroctl.plant.pack_step import move, step
from gyroctl.plant.packs import LANES, check_room, packs
from gyroctl.plant.packs import room as stacked

Floats = NDArray[np.float64]


class LaneState(NamedTuple):
    """State and working space of LANES runs; entry `row` of a run stands at ``row * LANES + lane``."""

    y: Floats  # state and ledger
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


@inlined
def lane_room(rows: int) -> Floats:
    """Room for LANES runs of so many rows."""
    room: Floats = aligned((rows + 6 + 2 * TAPS + 8) * LANES)
    return room


@inlined
def lane_state(room: Floats, rows: int) -> LaneState:
    """LANES runs at rest in the room of `lane_room`, which the caller is to hold."""
    check_room(rows)
    L = LANES
    y, room = room[: rows * L], room[rows * L :]
    moments, taps, room = room[: 6 * L], room[6 * L : 22 * L], room[22 * L :]
    cell, first, place, cc = room[:L], room[L : 2 * L], room[2 * L : 3 * L], room[3 * L : 4 * L]
    cg, start, done, h = room[4 * L : 5 * L], room[5 * L : 6 * L], room[6 * L : 7 * L], room[7 * L :]
    lanes = LaneState(y, moments, taps, cell, first, place, cc, cg, start, done, h)
    for l in range(L):
        cell[l], cc[l], cg[l] = -1.0, 0.0, 0.0
        set_out(lanes, l, 0.0, 0.0)
    return lanes


@inlined
def set_out(lanes: LaneState, l: int, start: float, h: float) -> None:
    """Let lane `l` begin an interval at the time `start` with steps of `h`. [s]"""
    lanes.start[l], lanes.step[l], lanes.h[l] = start, 0.0, h


@inlined
def step_lanes(lanes: LaneState, k: Coefficients, waves: Floats, waves_dt: float) -> None:
    """Take a step in every lane.

    `waves` (LANES, 2 n) holds the moments of each run, sample by sample [Nm], every `waves_dt` [s]. Those at the start
    have to be there, see `moments_at`.
    """
    moments_at(lanes, waves, waves_dt, 1)
    moments_at(lanes, waves, waves_dt, 2)
    rows, y, moments, state = lanes.y.size // LANES, packs(lanes.y), packs(lanes.moments), stacked()
    move(y, state, rows)
    step(state, k, packs(lanes.cc)[0], packs(lanes.cg)[0], moments, 0, packs(lanes.h)[0], True)
    move(state, y, rows)
    moments[0], moments[1] = moments[4], moments[5]
    for l in range(LANES):
        lanes.step[l] += 1.0


@inlined
def moments_at(lanes: LaneState, waves: Floats, waves_dt: float, instant: int) -> None:
    """Write the moments of every lane at the start, the middle or the end, 0, 1 or 2, of its step."""
    L, last = LANES, float(waves.shape[1] // 2 - TAPS)
    ahead = 0.5 * instant
    for l in range(L):
        position = (lanes.start[l] + (lanes.step[l] + ahead) * lanes.h[l]) / waves_dt
        lanes.first[l] = min(max(np.floor(position) - (TAPS // 2 - 1), 0.0), last)
        lanes.place[l] = position - lanes.first[l]
    for l in range(L):
        if lanes.first[l] != lanes.cell[l]:  # every fifth step or less: put its samples beside the others'
            lanes.cell[l] = lanes.first[l]
            at = 2 * int(lanes.first[l])
            for i in range(2 * TAPS):
                lanes.taps[i * L + l] = waves[l, at + i]
    taps, to = packs(lanes.taps), packs(lanes.moments)
    w0, w1, w2, w3, w4, w5, w6, w7 = weights_at(packs(lanes.place)[0])
    for row in range(2):
        total = w0 * taps[row] + w1 * taps[2 + row] + w2 * taps[4 + row] + w3 * taps[6 + row]
        total = total + w4 * taps[8 + row] + w5 * taps[10 + row] + w6 * taps[12 + row] + w7 * taps[14 + row]
        to[2 * instant + row] = total
