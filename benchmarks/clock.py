"""How the benchmarks time: processor time, the least of several goes, all candidates in turn."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Sequence
from typing import Any

from gyroctl.provenance import made


def least(
    works: Sequence[Callable[[], Any]], times: int, clock: Callable[[], float] = time.process_time
) -> list[float]:
    """Least time of each piece of work [s], all of them in turn so that a busy machine is busy for all."""
    spent: list[list[float]] = [[] for _ in works]
    for _ in range(times):
        for work, seconds in zip(works, spent, strict=True):
            begin = clock()
            work()
            seconds.append(clock() - begin)
    return [min(seconds) for seconds in spent]


def here() -> dict[str, Any]:
    """What made a table, and on which machine."""
    return {**made(), "machine": f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"}
