"""The symmetry of the forced device: half a period later, phi and z change sign and the ring is half a turn on.

It fails where the float moves through the waves or its wetted surface does: `Parameters.symmetric`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA, OMEGA_RATE, PSI, PSI_RATE


def free_rows(plant: Plant) -> NDArray[np.int64]:
    """Rows of an orbit's unknowns: not omega, which is cyclic, and not omega' where it is tied to the ring."""
    tied = (OMEGA,) if plant.parameters.connection == "magnetic" else (OMEGA, OMEGA_RATE)
    return np.array([row for row in range(len(plant.labels)) if row not in tied])


def signs(n: int) -> NDArray[np.float64]:
    """Signs (n,) of the states under half a period."""
    out = -np.ones(n)
    out[[PSI, OMEGA, PSI_RATE, OMEGA_RATE]] = 1.0
    return out


def reflect(x: NDArray[np.float64], sense: int) -> NDArray[np.float64]:
    """Undo half a period of a state (n,) by symmetry."""
    out = signs(x.size) * x
    out[PSI] = x[PSI] - sense * np.pi
    return out


def unwound(x: NDArray[np.float64], sense: int) -> NDArray[np.float64]:
    """Undo the turn of the ring in a whole period, of a state (n,)."""
    out = x.copy()
    out[PSI] = x[PSI] - sense * 2.0 * np.pi
    return out
