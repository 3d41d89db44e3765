"""Signals of the waves at the three instants of a Runge-Kutta step, written side by side for all runs."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.beyond import base_rows, node_rows, signal_rows
from gyroctl.plant.compiled import inlined
from gyroctl.plant.held import extrapolate, renew
from gyroctl.plant.lagrange import TAPS, lagrange_weights
from gyroctl.plant.near import forget, near, stand


@inlined
def interpolate(waves: Any, L: int, position: float, weight: Any, out: Any, at: int, more: Any = None) -> None:
    """Write the signals at `position` [grid steps] into `out`, for the instant `at` of a step.

    `waves` holds for each sample in turn L values of Me1, then L of Me3 and of each further signal of `more`
    (`Beyond`); then, where the position moves, of each run what is known over the positions.
    """
    rows, width, signals = 2, 2 * L, 2 * L
    if more is not None:
        rows, signals = base_rows(more), signal_rows(more) * L
        width = (rows + node_rows(more)) * L
    samples = waves.size // width
    first = min(max(int(math.floor(position)) - (TAPS // 2 - 1), 0), samples - TAPS)
    u = position - first
    lagrange_weights(u, weight)
    w0, w1, w2, w3, w4, w5, w6, w7 = loaded(weight)
    a, b, c, d = four_from(waves, first, width)
    e, f, g, h = four_from(waves, first + 4, width)
    to = out[at * signals :]
    for lane in range(rows * L):
        total = w0 * a[lane] + w1 * b[lane] + w2 * c[lane] + w3 * d[lane]
        to[lane] = total + w4 * e[lane] + w5 * f[lane] + w6 * g[lane] + w7 * h[lane]
    if more is not None:
        near(more, waves, L, width, position, out, at)


@inlined
def loaded(weight: Any) -> Any:
    """Weights as scalars: read in the loop over the lanes they might be what that loop overwrites."""
    return weight[0], weight[1], weight[2], weight[3], weight[4], weight[5], weight[6], weight[7]


@inlined
def four_from(waves: Any, sample: int, width: int) -> Any:
    """Four samples, each an array of its own: an index that is the lane and nothing else is read eight at a time."""
    at = sample * width
    return waves[at:], waves[at + width :], waves[at + 2 * width :], waves[at + 3 * width :]


@inlined
def stand_at(more: Any, x: Any, L: int, out: Any, begin: bool) -> bool:
    """Look where the floats are, see `stand`, at the beginning of an interval or of a step."""
    if begin:
        forget(more.position, L, out)
    return stand(more, x, L, out, begin)


@inlined
def follow(more: Any, x: Any, L: int, out: Any, waves: Any, position: float) -> None:
    """Take the cubics at the beginning of a step, `position` [grid steps], anew where a float has moved on."""
    if stand_at(more, x, L, out, False):
        near(more, waves, L, (base_rows(more) + node_rows(more)) * L, position, out, 0)


@inlined
def hold_on(more: Any, held: Any, t: float, h: float, x: Any, L: int, out: Any) -> None:
    """Write the held moments into the three instants of the step of `h` [s] that begins at `t` [s]."""
    renew(held, t, x, L)
    size = signal_rows(more) * L
    for instant in range(3):
        extrapolate(held, t + 0.5 * instant * h, L, out, (instant + 1) * size - 2 * L)
