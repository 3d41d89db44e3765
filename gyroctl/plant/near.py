"""Signals of an instant as the equations see them: about the float's position in place of all along the reach."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.beyond import HALF, NEAR, NODES, base_rows, signal_rows
from gyroctl.plant.equations import PHI1


def near_signals(beyond: Any, x: NDArray[Any], moments: Any) -> NDArray[Any]:
    """Return the rows of `signal_rows` for a state (n,) or (n, batch), as the kernel makes them.

    Parameters
    ----------
    beyond : Beyond or None
        Terms of the plant.
    x : array
        State; real parts decide which nodes are near.
    moments : sequence
        Signals in the order of `Plant.channels`, scalars or (batch,).

    Raises
    ------
    InputError
        For another number of signals.
    """
    rows = base_rows(beyond)
    moving = beyond is not None and beyond.position is not None
    if beyond is not None and beyond.surface is not None:
        problem = "the moments of the wetted surface are known to a run alone"
        raise InputError("plant.wetted", "surface", problem, 'Choose wetted = "reduced", or give Me1 and Me3 alone')
    if len(moments) != rows + 2 * NODES * moving:
        mend = "Give Me1 and Me3, or all signals in the order of plant.channels"
        raise InputError("moments", len(moments), f"this plant has {rows + 2 * NODES * moving} signals", mend)
    given = np.stack(np.broadcast_arrays(*moments))
    if not moving:
        return given
    first = np.floor(HALF * np.sin(x[PHI1].real)) - (NEAR // 2 - 1)
    first = np.clip(first, -HALF, HALF - NEAR + 1)
    shape = np.broadcast_shapes(given.shape[1:], first.shape)
    out = np.empty((signal_rows(beyond), *shape), given.dtype)
    out[:rows] = given[:rows].reshape(rows, *given.shape[1:])
    whole = np.broadcast_to(given[rows:], (2 * NODES, *shape))
    index = np.broadcast_to(first.astype(int) + HALF, shape)
    for m in range(2):
        near = np.stack([np.take_along_axis(whole, (index + m * NODES + j)[None], 0)[0] for j in range(NEAR)])
        for n in range(1, NEAR):
            near[n:] = (near[n:] - near[n - 1 : -1]) * (1.0 / n)
        out[rows + m * NEAR : rows + (m + 1) * NEAR] = near
    out[rows + 2 * NEAR] = first
    return out
