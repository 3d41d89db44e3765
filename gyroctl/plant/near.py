"""Signals of an instant as the equations see them: about the float's position in place of all along the reach."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.beyond import HALF, NEAR, NODES, ORDER, PLACES, WEIGHTS, base_rows, pair, signal_rest, signal_rows
from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import PHI1
from gyroctl.plant.trigonometry import sine


def near_signals(beyond: Any, x: NDArray[Any], moments: Any) -> NDArray[Any]:
    """Return the rows of `signal_rows` for a state (n,) or (n, batch), as the kernel makes them.

    Parameters
    ----------
    beyond : Beyond or None
        Terms of the plant.
    x : array
        State; real parts decide which nodes are near.
    moments : sequence
        Signals in the order of `Plant.channels`, scalars or (batch,); where the wetted surface is followed, R1 and R3
        behind them, which are known to a run alone.

    Raises
    ------
    InputError
        For another number of signals.
    """
    rows = base_rows(beyond)
    moving = beyond is not None and beyond.position is not None
    held = 0 if beyond is None else pair(beyond.surface)
    if len(moments) != rows + 2 * NODES * moving + held:
        mend = "Give Me1 and Me3, or all signals in the order of plant.channels"
        problem = f"this plant has {rows + 2 * NODES * moving} signals"
        if held:
            problem += ", and R1 and R3 of its wetted surface, which are known to a run alone"
            mend += ' and these two behind them, or choose wetted = "reduced"'
        raise InputError("moments", len(moments), problem, mend)
    given = np.stack(np.broadcast_arrays(*moments))
    if not moving:
        return given
    place = np.clip(np.floor(HALF * PLACES * np.sin(x[PHI1].real) + 0.5) / PLACES, -HALF, HALF)
    shape = np.broadcast_shapes(given.shape[1:], place.shape)
    place = np.broadcast_to(place, shape)
    first = np.clip(np.floor(place) - (NEAR // 2 - 1), -HALF, HALF - NEAR + 1)
    weights = np.moveaxis(WEIGHTS[np.round((place - first) * PLACES).astype(int)], (-2, -1), (0, 1))
    out = np.empty((signal_rows(beyond), *shape), given.dtype)
    out[:rows] = given[:rows].reshape(rows, *given.shape[1:])
    whole = np.broadcast_to(given[rows : rows + 2 * NODES].reshape(2 * NODES, *given.shape[1:]), (2 * NODES, *shape))
    for m in range(2):
        at = first.astype(int) + HALF + m * NODES
        around = np.stack([np.take_along_axis(whole, (at + j)[None], 0)[0] for j in range(NEAR)])
        out[rows + m * ORDER : rows + (m + 1) * ORDER] = np.sum(around[:, None] * weights, axis=0)
    out[rows + 2 * ORDER] = place
    out[rows + 2 * ORDER + 1 :] = given[rows + 2 * NODES :].reshape(held, *given.shape[1:])
    return out


@inlined
def near(position: Any, waves: Any, L: int, base: int, width: int, where: float, out: Any, at: int) -> None:
    """Write the cubics of the moments about the places of the runs at `where` [grid steps] for the instant `at`.

    The places are there already, see `stand`. `base` is where the nodes begin within a sample. In time four samples
    make a cubic, its error 1e-4 of the deviation; their coefficients are kept behind the signals, for as long as the
    instants lie between the same samples and the float is near the same place.
    """
    if position is not None:
        size = (out.size - signal_rest(L)) // 3
        row, kept = at * size + base, 3 * size
        known = kept + 8 * ORDER * L  # sample and place of what is kept
        cell = min(max(math.floor(where) - 1, 0), waves.size // width - 4)
        for l in range(L):
            place = out[row + 2 * ORDER * L + l].real
            if out[known + l].real != cell or out[known + L + l].real != place:
                out[known + l], out[known + L + l] = cell, place
                for i in range(4):
                    around(
                        waves[(cell + i) * width + base + 2 * NODES * l :], place, L, out, kept + 2 * i * ORDER * L + l
                    )
        u = where - cell
        a, b, c, d = u, u - 1.0, u - 2.0, u - 3.0
        t0, t1, t2, t3 = -b * c * d / 6.0, 0.5 * a * c * d, -0.5 * a * b * d, a * b * c / 6.0
        part = 2 * ORDER * L
        for i in range(part):
            early = t0 * out[kept + i] + t1 * out[kept + part + i]
            out[row + i] = early + (t2 * out[kept + 2 * part + i] + t3 * out[kept + 3 * part + i])


@inlined
def around(nodes: Any, place: float, L: int, out: Any, to: int) -> None:
    """Write both cubics about a place at one sample, from the eight nodes around it."""
    first = first_node(place)
    w = WEIGHTS[max(int((place - first) * PLACES + 0.5), 0)]
    for m in range(2):
        v = nodes[m * NODES + int(first) + HALF :]
        for n in range(ORDER):
            early = v[0] * w[0, n] + v[1] * w[1, n] + v[2] * w[2, n] + v[3] * w[3, n]
            late = v[4] * w[4, n] + v[5] * w[5, n] + v[6] * w[6, n] + v[7] * w[7, n]
            out[to + (m * ORDER + n) * L] = early + late


@inlined
def forget(position: Any, L: int, out: Any) -> None:
    """Forget what `near` has kept."""
    if position is not None:
        for l in range(L):
            out[out.size - 2 * L + l] = -1.0


@inlined
def first_node(place: float) -> float:
    """First of the eight nodes around a place, all of them within the reach."""
    return min(max(math.floor(place) - (NEAR // 2 - 1.0), -1.0 * HALF), HALF - NEAR + 1.0)


@inlined
def stand(position: Any, x: Any, L: int, out: Any, row: int, size: int) -> bool:
    """Write the places next to the floats at the beginning of a step, and tell whether any is another one.

    They stand in row `row` of each of the three instants of a step, `size` entries apart.
    """
    changed = False
    if position is not None:
        for l in range(L):
            place = np.floor(HALF * PLACES * sine(x[PHI1 * L + l].real) + 0.5) / PLACES
            if not place > -1.0 * HALF:  # also where a run has left all bounds
                place = -1.0 * HALF
            if place > HALF:
                place = 1.0 * HALF
            if out[row + l].real != place:
                changed = True
            for instant in range(3):
                out[instant * size + row + l] = place
    return changed
