"""Memory that was freed is used again: what glibc does by itself, and Dask forbids its workers.

Dask starts workers with ``MALLOC_TRIM_THRESHOLD_``, so that what was freed goes back to the system at once. A run makes
and frees arrays of megabytes: each of them is then mapped and cleared by the system anew, which takes a third of the
time of the run.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping
from functools import lru_cache

FORBIDS = "MALLOC_TRIM_THRESHOLD_"
"""Variable of the environment by which glibc gives back at once."""

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
KEPT, MAPPED = 1 << 26, 1 << 25
"""What may stay unused, and from which size on an array is mapped for itself: the most that glibc comes to by itself.
[B]"""


def as_usual(environment: Mapping[str, str]) -> dict[str, str]:
    """Environment of a program that keeps what it has freed."""
    return {name: value for name, value in environment.items() if name != FORBIDS}


@lru_cache(maxsize=1)
def keep_freed() -> None:
    """Let this process keep what it has freed, where its environment forbids it; another C library is left alone."""
    if FORBIDS not in os.environ:
        return
    try:
        option = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    option(M_TRIM_THRESHOLD, KEPT)
    option(M_MMAP_THRESHOLD, MAPPED)
