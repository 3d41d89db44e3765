"""Many states through the same stretch of time: the columns of a derivative by complex step, in one call."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.beyond import signal_room
from gyroctl.plant.compiled import stamped
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import SOURCES, advance
from gyroctl.plant.lagrange import TAPS


@stamped((*SOURCES, __file__))
def hold_each(
    y: NDArray[Any],
    k: Coefficients,
    controls: NDArray[Any],
    start: float,
    hold: float,
    steps: int,
    waves: NDArray[Any],
    waves_dt: float,
) -> None:
    """Advance runs one after the other in place, each as `hold_one` does: `y` (runs, rows), `controls` (2, 1)."""
    cc, cg = controls[0], controls[1]
    work = np.empty((5, y.shape[1]), y.dtype)
    x, slope = work[0], work[1:]
    moments, weight = np.empty(signal_room(k.beyond, 1), waves.dtype), np.empty(TAPS)
    moving, since, held, more = None, 0.0, None, k.beyond
    for i in range(y.shape[0]):
        one = y[i]
        advance(
            one, x, slope, moments, weight, 1, k, cc, cg, start, hold, steps, waves, waves_dt, moving, since, held, more
        )
