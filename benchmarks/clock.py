"""How the benchmarks time: processor time, the least of several goes, all candidates in turn."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
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


def in_tree(script: str, root: Path) -> dict[str, Any]:
    """What a script of this folder says with ``--one``, in a process of its own with the package of a tree."""
    environment = {**os.environ, "PYTHONPATH": str(root)}
    command = [sys.executable, str(Path(script).resolve()), "--one"]
    told = subprocess.run(command, env=environment, cwd=root, check=True, capture_output=True, text=True).stdout
    answer: dict[str, Any] = json.loads(told.splitlines()[-1])
    return answer
