"""What the sensors of the device measure, and where it stands in the plant's state."""

from __future__ import annotations

from difflib import get_close_matches
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE


class Measurement(NamedTuple):
    """What the sensors tell, in SI units. The order is that of every array of measurements."""

    psi: float  # ring angle, counted through turns [rad]
    psi_rate: float  # [rad/s]
    omega_rate: float  # flywheel relative to the ring [rad/s]
    phi1: float  # [rad]
    phi3: float  # [rad]
    phi1_rate: float  # [rad/s]
    phi3_rate: float  # [rad/s]

    def __getattr__(self, name: str) -> float:
        """Answer a name that there is not with those that there are."""
        if name.startswith("_"):  # NumPy and others ask for these at every use
            raise AttributeError(name=name, obj=self)
        near = get_close_matches(name, self._fields, 1)
        meant = f", did you mean {near[0]}?" if near else "."
        raise AttributeError(
            f"a measurement has no {name}{meant} It has {', '.join(self._fields)}", name=name, obj=self
        )


CHANNELS = Measurement._fields
ROWS = (PSI, PSI_RATE, OMEGA_RATE, PHI1, PHI3, PHI1_RATE, PHI3_RATE)
"""Rows of the state that the channels measure."""


def read(x: NDArray[np.float64]) -> Measurement:
    """Measurement of a state (n,), without error."""
    return Measurement(*(float(x[row]) for row in ROWS))
