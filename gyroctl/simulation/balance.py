"""The balance of a run: what takes from the work of the moments at rest, and what the generator is worth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.equations import INPUTS


def spent(energy: Mapping[str, Any]) -> Any:
    """Energies that take from `wave_input`, summed, less what the waves bring in beyond it; by name, scalars or arrays.

    With the change of the stored energy they make up `wave_input`.
    """
    taken = sum(value for name, value in energy.items() if name not in INPUTS)
    return taken - energy["second_order"] if "second_order" in energy else taken


def electrical(net: NDArray[np.float64], efficiency: float) -> NDArray[np.float64]:
    """Electrical energy of a generator: what it gives is less than what it takes, what it takes as a motor is more.

    Parameters
    ----------
    net : (n,) array
        Mechanical energy so far at the samples, less that of the motor. [J]
    efficiency : float
        Electrical over mechanical energy.

    Returns
    -------
    (n,) array
        Electrical energy so far, from that at the first sample on. [J]
    """
    if efficiency == 1.0:
        return net
    step = np.diff(net)
    worth = np.where(step > 0.0, efficiency * step, step / efficiency)
    return np.concatenate([net[:1], net[0] + np.cumsum(worth)])
