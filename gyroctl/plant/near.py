"""Signals of an instant as the equations see them: about the float's position in place of all along the reach.

A place is a node of the position, X = l i/10; next to the float there is one within 0.052 m. About it a moment is a
cubic in phi1, made of the nine nodes around, or of the polynomial in sin phi1, whichever a realisation carries.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.beyond import HALF, NODES, ORDER, Beyond, base_rows, cubic_rows, moved, node_rows, pair, signal_rows
from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import PHI1
from gyroctl.plant.reduced import POWERS

NEAR = 9
"""Nodes around a place through which a moment is interpolated."""

ANGLES = np.arcsin(np.arange(-HALF, HALF + 1) / HALF)
"""Angle phi1 of each place. [rad]"""

BORDERS = np.arcsin(np.clip((np.arange(NODES + 1) - HALF - 0.5) / HALF, -1.0, 1.0))
MIDDLE, WIDE = 0.5 * (BORDERS[1:] + BORDERS[:-1]) - ANGLES, 0.5 * np.diff(BORDERS)
"""Middle of the range of phi1 that belongs to each place, from the place, and half its width. [rad]"""

FIRST = np.clip(np.arange(NODES) - NEAR // 2, 0, NODES - NEAR)
"""First of the nodes around each place, all of them within the reach."""


def _cubics(whole: list[list[NDArray[np.float64]]]) -> NDArray[np.float64]:
    """Coefficients (places, n, ORDER) over powers of phi1 about each place.

    They are those of polynomials in X about the places, counted in spacings of the nodes, of any degree: cut off as a
    series of Chebyshev's polynomials over half a spacing on either side, which misses a quarter of what Taylor's would.
    """
    table = np.zeros((NODES, len(whole[0]), ORDER))
    for place, row in enumerate(whole):
        for j, coefficients in enumerate(row):
            series = np.polynomial.chebyshev.poly2cheb(coefficients * 0.5 ** np.arange(len(coefficients)))[:ORDER]
            few = np.polynomial.chebyshev.cheb2poly(series)
            table[place, j, : len(few)] = few * 2.0 ** np.arange(len(few))
    c, s = HALF * np.cos(ANGLES)[:, None], HALF * np.sin(ANGLES)[:, None]
    d1, d2, d3 = c, -s / 2.0, -c / 6.0  # X(phi1) about the place
    q0, q1, q2, q3 = np.moveaxis(table, -1, 0)
    return np.stack([q0, q1 * d1, q1 * d2 + q2 * d1**2, q1 * d3 + 2.0 * q2 * d1 * d2 + q3 * d1**3], axis=-1)


def _of_nodes() -> NDArray[np.float64]:
    """Weights (places, NEAR, ORDER) of the nodes around each place in the coefficients about it."""
    whole = []
    for place in range(NODES):
        x = FIRST[place] + np.arange(NEAR) - place
        others = [np.delete(x, j) for j in range(NEAR)]
        whole.append([np.polynomial.polynomial.polyfromroots(o) / np.prod(x[j] - o) for j, o in enumerate(others)])
    return _cubics(whole)


def _of_powers() -> NDArray[np.float64]:
    """Weights (places, POWERS, ORDER) of the powers of sin phi1 in the coefficients about each place."""
    sines = [np.array([i / HALF, 1.0 / HALF]) for i in range(-HALF, HALF + 1)]
    return _cubics([[np.polynomial.polynomial.polypow(sine, power) for power in range(POWERS)] for sine in sines])


OF_NODES = _of_nodes()
"""See `_of_nodes`."""

OF_POWERS = _of_powers()
"""See `_of_powers`."""


def near_signals(beyond: Beyond | None, x: NDArray[Any], moments: Any) -> NDArray[Any]:
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
    rows, known = base_rows(beyond), node_rows(beyond)
    held = 0 if beyond is None else pair(beyond.surface)
    if len(moments) != rows + known + held:
        mend = "Give Me1 and Me3, or all signals in the order of plant.channels"
        problem = f"this plant has {rows + known} signals"
        if held:
            problem += ", and R1 and R3 of its wetted surface, which are known to a run alone"
            mend += ' and these two behind them, or choose wetted = "reduced"'
        raise InputError("moments", len(moments), problem, mend)
    given = np.stack(np.broadcast_arrays(*moments))
    if beyond is None or beyond.position is None:
        return given
    shape = np.broadcast_shapes(given.shape[1:], x.shape[1:])
    given = np.broadcast_to(given.reshape(len(given), *given.shape[1:] or (1,) * len(shape)), (len(given), *shape))
    node, sense, place = (np.broadcast_to(part, shape) for part in np.vectorize(standing)(x[PHI1].real))
    out = np.empty((signal_rows(beyond), *shape), given.dtype)
    out[:rows] = given[:rows]
    powers = POWERS * pair(moved(beyond.position, beyond.reduced))
    sources = [(powers + FIRST[node], OF_NODES), (powers + NODES + FIRST[node], OF_NODES)]
    if powers:
        sources += [(0 * node, OF_POWERS), (0 * node + POWERS, OF_POWERS)]
    for m, (first, table) in enumerate(sources):
        values = np.stack([np.take_along_axis(given, (rows + first + j)[None], 0)[0] for j in range(table.shape[1])])
        about = np.sum(values[..., None] * np.moveaxis(table[node], -2, 0), axis=0)
        about[..., 1::2] *= sense[..., None]
        out[rows + m * ORDER : rows + (m + 1) * ORDER] = np.moveaxis(about, -1, 0)
    out[rows + cubic_rows(beyond)] = place
    out[rows + cubic_rows(beyond) + 1 :] = given[rows + known :]
    return out


@inlined
def near(more: Any, waves: Any, L: int, width: int, where: float, out: Any, at: int) -> None:
    """Write the cubics of the moments about the places of the runs at `where` [grid steps] for the instant `at`.

    The places are there already, see `stand`. In time four samples, each `width` wide, make a cubic, its error 1e-4 of
    the deviation; their coefficients are kept behind the signals, for as long as the instants lie between these samples
    and the float is near the same place.
    """
    if more.position is not None:
        size, part, block = signal_rows(more) * L, cubic_rows(more) * L, node_rows(more)
        base, kept = base_rows(more) * L, 3 * size
        row, known = at * size + base, kept + 4 * part  # sample and place of what is kept, node and sense of the place
        cell = min(max(math.floor(where) - 1, 0), waves.size // width - 4)
        for l in range(L):
            place, before, first = out[row + part + l].real, out[known + l].real, 0
            if out[known + L + l].real == place:
                first = 4 if before == cell else 0
                if before == cell - 1:  # the float is where it was, an interval of the grid later
                    first = 3
                    for i in range(3 * part // L):
                        out[kept + i * L + l] = out[kept + i * L + part + l]
            if first < 4:
                out[known + l], out[known + L + l] = cell, place
                node, sense = int(out[known + 2 * L + l].real), out[known + 3 * L + l].real
                for i in range(first, 4):
                    start = (cell + i) * width + base + block * l
                    about(more.position, more.reduced, waves[start:], node, sense, L, out, kept + i * part + l)
        u = where - cell
        a, b, c, d = u, u - 1.0, u - 2.0, u - 3.0
        t0, t1, t2, t3 = -b * c * d / 6.0, 0.5 * a * c * d, -0.5 * a * b * d, a * b * c / 6.0
        for i in range(part):
            early = t0 * out[kept + i] + t1 * out[kept + part + i]
            out[row + i] = early + (t2 * out[kept + 2 * part + i] + t3 * out[kept + 3 * part + i])


@inlined
def about(position: Any, reduced: Any, block: Any, node: int, sense: float, L: int, out: Any, to: int) -> None:
    """Write the cubics about a place at one sample, from what a realisation holds over the positions."""
    nodes = POWERS * pair(moved(position, reduced)) + FIRST[node]
    weigh(block, nodes, OF_NODES[node], NEAR, sense, L, out, to)
    weigh(block, nodes + NODES, OF_NODES[node], NEAR, sense, L, out, to + ORDER * L)
    if reduced is not None:
        weigh(block, 0, OF_POWERS[node], POWERS, sense, L, out, to + 2 * ORDER * L)
        weigh(block, POWERS, OF_POWERS[node], POWERS, sense, L, out, to + 3 * ORDER * L)


@inlined
def weigh(block: Any, first: int, w: Any, count: int, sense: float, L: int, out: Any, to: int) -> None:
    """Write the four coefficients of one cubic."""
    c0, c1, c2, c3 = 0.0 * block[0], 0.0 * block[0], 0.0 * block[0], 0.0 * block[0]
    for j in range(count):
        v = block[first + j]
        c0, c1, c2, c3 = c0 + v * w[j, 0], c1 + v * w[j, 1], c2 + v * w[j, 2], c3 + v * w[j, 3]
    out[to], out[to + L], out[to + 2 * L], out[to + 3 * L] = c0, sense * c1, c2, sense * c3


@inlined
def forget(position: Any, L: int, out: Any) -> None:
    """Forget what `near` has kept."""
    if position is not None:
        for l in range(L):
            out[out.size - 6 * L + l] = -9.0


@inlined
def standing(angle: float) -> Any:
    """Number of the place next to a float at phi1 = `angle` [rad], sense of cos phi1 there, phi1 of the place."""
    turn = math.floor(angle / math.pi + 0.5) if abs(angle) < 1e9 else 0.0
    sense = 1.0 - 2.0 * (turn - 2.0 * math.floor(0.5 * turn))
    node = math.floor(HALF * math.sin(angle) + 0.5) if abs(angle) < 1e9 else 0.0  # also where a run left all bounds
    number = int(node) + HALF
    return number, sense, turn * math.pi + sense * ANGLES[number]


@inlined
def stand(more: Any, x: Any, L: int, out: Any, begin: bool) -> bool:
    """Write the places next to the floats at the beginning of a step, and tell whether any is another one."""
    changed = False
    if more.position is not None:
        size, own = signal_rows(more) * L, 3 * signal_rows(more) * L + 4 * cubic_rows(more) * L
        row = (base_rows(more) + cubic_rows(more)) * L
        for l in range(L):
            angle = x[PHI1 * L + l].real
            if begin or not abs(angle - out[own + 4 * L + l].real) <= out[own + 5 * L + l].real:
                changed = True
                node, sense, place = standing(angle)
                out[own + 2 * L + l], out[own + 3 * L + l] = node, sense
                out[own + 4 * L + l], out[own + 5 * L + l] = place + sense * MIDDLE[node], WIDE[node]
                for instant in range(3):
                    out[instant * size + row + l] = place
    return changed
