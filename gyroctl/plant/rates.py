"""Rates of change of many states at once, as machine code of the one text, state by state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import entry_point
from gyroctl.plant.equations import LEDGER, Coefficients, derivative

if TYPE_CHECKING:
    from gyroctl.plant.plant import Plant

Floats = NDArray[np.float64]


def rates(plant: Plant, x: Floats, u: Any, signals: Floats) -> Floats:
    """Rates of the states `x` (n, batch), as `plant.derivative` gives them to rounding.

    Parameters
    ----------
    plant : Plant
        The device.
    x : (n, batch) array
        States in the order of `plant.labels`; quickest where each state lies together in memory. [rad, rad/s]
    u : (cc, cg)
        Controls, each (batch,). [Nms]
    signals : (len(channels), batch) array
        Of the waves, in the order of `plant.channels`. [Nm and others]

    Returns
    -------
    (n, batch) array
        [rad/s, rad/s^2]
    """
    if plant.coefficients.beyond is not None:  # what lies beyond asks for its place first
        return plant.derivative(x, u, signals)
    states = np.ascontiguousarray(x.T)
    out = np.empty((states.shape[0], states.shape[1] + len(LEDGER)))
    each(plant.coefficients, states, np.stack([u[0], u[1], signals[0], signals[1]], axis=1), out)
    return out[:, : states.shape[1]].T


@entry_point
def each(k: Coefficients, states: Floats, inputs: Floats, out: Floats) -> None:
    """Write rates and powers of each state, (batch, n), into `out` (batch, n + 5), by cc, cg, Me1, Me3 (batch, 4)."""
    for i in range(states.shape[0]):
        cc, cg, me1, me3 = inputs[i, 0], inputs[i, 1], inputs[i, 2], inputs[i, 3]
        derivative(states[i], out[i], 1, 0, k, cc, cg, me1, me3, None, None)
