"""The compiled ensemble of linear plants: LANES runs with constant controls from the first instant to the last.

The moments of all instants of a few steps are interpolated before those steps: all runs share their instants, so that
the weights of sixteen instants are one pack, and the samples are put side by side as they are needed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import pack_step, packs
from gyroctl.plant.compiled import aligned, inlined, put, stamped
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import RECORDED, SOURCES
from gyroctl.plant.lagrange import TAPS, weights_at
from gyroctl.plant.pack_step import move, step
from gyroctl.plant.packs import LANES, prefetch

Floats = NDArray[np.float64]

BLOCK = 15
"""Steps whose moments are interpolated at a time: with the start 31 instants, two packs."""

INSTANTS = 2 * LANES

LINE = 8
"""Doubles in a line of the cache."""

WINDOW = 32
"""Samples that stand side by side: few, or they would push the rest out of the cache."""


@stamped((*SOURCES, pack_step.__file__, __file__))
def run_packs(
    y: Floats,
    k: Coefficients,
    cc: Floats,
    cg: Floats,
    hold: float,
    steps: int,
    signals: Floats,
    of_lane: NDArray[np.int64],
    waves_dt: float,
    record: Floats,
    mark: int,
    marked: Floats,
    ledger: Any = None,
) -> None:
    """Run LANES runs with constant controls, in place.

    Parameters
    ----------
    y : (rows * LANES,) array
        State and ledger, at most ROOM rows; those of the end afterwards.
    k : Coefficients
        The device, without terms beyond the linear model.
    cc, cg : (LANES,) arrays
        Controls. [Nms]
    hold, steps
        Length of an interval [s], and the steps in it; the first begins at 0.
    signals : (seeds, 2, n) array
        Me1 and Me3 of each realisation. [Nm]
    of_lane : (LANES,) array
        Realisation of each lane.
    waves_dt : float
        Spacing of the samples. [s]
    record : (len(RECORDED), intervals + 1, LANES) array
        Receives the rows `RECORDED` at both ends of every interval.
    mark : int
        Interval at whose beginning `marked`, of the shape of `y`, receives state and ledger.
    ledger : True or None
        None for the generator's row alone.
    """
    rows, intervals, samples = y.size // LANES, record.shape[1] - 1, signals.shape[2]
    now, controls = aligned(rows * LANES), aligned(2 * LANES)
    waves, window = aligned(2 * (2 * BLOCK + 1) * LANES), aligned(2 * WINDOW * LANES)
    place, weight, first = aligned(INSTANTS), aligned(TAPS * INSTANTS), np.zeros(INSTANTS, np.int64)
    for j in range(INSTANTS):
        place[j] = 0.0
    put(y, now)
    put(cc, controls[:LANES])
    put(cg, controls[LANES:])
    outside, moments, pair = packs.packs(now), packs.packs(waves), packs.packs(controls)
    state = packs.room()
    move(outside, state, rows)
    whole, begin, end = hold / steps, 0, 0  # the window holds the samples from `begin` to before `end`
    written = packs.packs(record.reshape(record.size))
    for i in range(intervals + 1):
        for r in range(len(RECORDED)):
            written[r * (intervals + 1) + i] = state[RECORDED[r]]
        if i == mark:
            move(state, outside, rows)
            put(now, marked)
        if i == intervals:
            break
        for done in range(0, steps, BLOCK):
            count = min(BLOCK, steps - done)
            for j in range(2 * count + 1):
                position = (i * hold + (done + 0.5 * j) * whole) / waves_dt
                first[j] = min(max(math.floor(position) - (TAPS // 2 - 1), 0), samples - TAPS)
                place[j] = position - first[j]
            weigh(place, weight)
            for j in range(2 * count + 1):
                if first[j] + TAPS > end:
                    begin, end = move_on(signals, of_lane, window, begin, end, first[j] - 1)
                interpolate_pack(window, first[j] - begin, weight, j, moments)
            for s in range(count):
                step(state, k, pair[0], pair[1], moments, 4 * s, whole, ledger)
    move(state, outside, rows)
    put(now, y)


@inlined
def weigh(place: Floats, weight: Floats) -> None:
    """Write the weights of the samples at 0 .. 7 for INSTANTS places among them, tap by tap."""
    places, weights = packs.packs(place), packs.packs(weight)
    for half in range(INSTANTS // LANES):
        found = weights_at(places[half])
        for tap in range(TAPS):
            weights[tap * (INSTANTS // LANES) + half] = found[tap]


@inlined
def move_on(
    signals: Floats, of_lane: NDArray[np.int64], window: Floats, begin: int, end: int, wanted: int
) -> tuple[int, int]:
    """Let the window begin at the sample `wanted`, with as many samples as it holds; return its new ends.

    One sample before what is needed first: by rounding an interval may begin a hair before the end of the last one.
    """
    first = max(wanted, 0)
    for i in range(2 * (first - begin) * LANES, 2 * (end - begin) * LANES):  # Me1 and Me3 of each sample in turn
        window[i - 2 * (first - begin) * LANES] = window[i]
    last = min(first + WINDOW, signals.shape[2])
    for sample in range(max(end, first), last):
        for row in range(2):
            for l in range(LANES):
                window[(2 * (sample - first) + row) * LANES + l] = signals[of_lane[l], row, sample]
    flat, n = signals.reshape(signals.size), signals.shape[2]
    for l in range(LANES):
        for row in range(2):
            for line in range(0, WINDOW, LINE):  # those that come next, while the steps are taken
                prefetch(flat, (2 * of_lane[l] + row) * n + min(last + line, n - 1))
    return first, last


@inlined
def interpolate_pack(window: Floats, first: int, weight: Floats, j: int, moments: Any) -> None:
    """Write Me1 and Me3 at instant `j` from the eight samples from `first` on, see `instants.interpolate`."""
    samples, n = packs.packs(window), INSTANTS
    w0, w1, w2, w3 = weight[j], weight[n + j], weight[2 * n + j], weight[3 * n + j]
    w4, w5, w6, w7 = weight[4 * n + j], weight[5 * n + j], weight[6 * n + j], weight[7 * n + j]
    for row in range(2):
        a = 2 * first + row
        total = w0 * samples[a] + w1 * samples[a + 2] + w2 * samples[a + 4] + w3 * samples[a + 6]
        total = total + w4 * samples[a + 8] + w5 * samples[a + 10] + w6 * samples[a + 12] + w7 * samples[a + 14]
        moments[2 * j + row] = total
