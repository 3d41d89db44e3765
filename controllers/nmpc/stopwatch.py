"""How long a sample takes, told within compiled code: a clock of the system, and counts by time that tell quantiles."""

from __future__ import annotations

import ctypes
import math
import time
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.by_address import function_of
from gyroctl.plant.compiled import inlined

SHORTEST, LONGEST = 1e-6, 10.0  # [s]
PER_DOUBLING = 32  # counts, so that a time is known to a hundredth
BINS = math.ceil(PER_DOUBLING * math.log2(LONGEST / SHORTEST))

clock_at = function_of(types.int32(types.int64, types.uintp))
"""POSIX ``clock_gettime``: it needs no interpreter lock."""


def clock_address() -> int:
    """Address of the clock, 0 on a system without it: nothing is timed there."""
    try:
        return ctypes.cast(ctypes.CDLL(None).clock_gettime, ctypes.c_void_p).value or 0
    except (OSError, AttributeError, TypeError):
        return 0


MONOTONIC = getattr(time, "CLOCK_MONOTONIC", 0)


@inlined
def seconds(address: int, room: Any) -> float:
    """Time of the clock at an address [s]; `room` (2,) takes its seconds and nanoseconds."""
    if address == 0:
        return 0.0
    clock_at(address)(MONOTONIC, room.ctypes.data)
    return float(room[0]) + 1e-9 * float(room[1])


@inlined
def note(spent: float, counts: Any) -> None:
    """Count a time [s]."""
    if spent > 0.0:
        place = int(PER_DOUBLING * math.log2(max(spent / SHORTEST, 1.0)))
        counts[min(place, counts.size - 1)] += 1


def quantile(counts: NDArray[np.int64], part: float) -> float:
    """Time that a `part` of what was counted did not exceed, the middle of its bin [s]; NaN where nothing was timed."""
    total = np.cumsum(counts)
    if total[-1] == 0:
        return math.nan
    return float(SHORTEST * 2.0 ** ((np.searchsorted(total, part * total[-1]) + 0.5) / PER_DOUBLING))
