"""A run with constant controls by itself, where runs do not share their steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.beyond import signal_room
from gyroctl.plant.compiled import put, stamped
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import RECORDED, SOURCES, hold_into
from gyroctl.plant.lagrange import TAPS

Floats = NDArray[np.float64]


@stamped((*SOURCES, __file__))
def run_alone(
    y: Floats,
    k: Coefficients,
    controls: Floats,
    hold: float,
    steps: int,
    waves: Floats,
    waves_dt: float,
    record: Floats,
    mark: int,
    marked: Floats,
    held: Any = None,
) -> None:
    """Run one run as `run_lanes` does many: `y`, `marked` (rows,), `controls` (2, 1), `record` (..., intervals + 1)."""
    work = np.empty((5, y.size))
    moments, weight = np.empty(signal_room(k.beyond, 1)), np.empty(TAPS)
    for i in range(record.shape[1]):
        if i == mark:
            put(y, marked)
        for r in range(len(RECORDED)):
            record[r, i] = y[RECORDED[r]]
        if i < record.shape[1] - 1:
            hold_into(y, work, moments, weight, k, controls, i * hold, hold, steps, waves, waves_dt, held)
