"""How the benchmarks measure: processor time, the least of several goes, all in turn; memory of a command."""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

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


MEMORY = "most_memory"
"""File beside which a watched module runs, that tells its memory."""

WATCHED = f"""
import atexit, re, runpy, sys
from pathlib import Path

def tell():
    Path("{MEMORY}").write_text(re.search(r"VmHWM:\\s*(\\d+) kB", Path("/proc/self/status").read_text())[1])

atexit.register(tell)
runpy.run_module(sys.argv.pop(1), run_name="__main__", alter_sys=True)
"""
"""Runs a module, and tells the most memory that was its own. `ru_maxrss` of a child is that of its parent, if larger:
it is handed on where a process begins another one."""


class Used(NamedTuple):
    """What a command took."""

    wall: float  # [s]
    processor: float  # with that of its processes that have ended [s]
    memory: float  # at most, of its own process [MB]


def watched(module: str, words: Sequence[str], folder: Path, root: Path) -> Used:
    """Run ``python -m MODULE WORDS`` in a folder, with the package of a tree, and say what it took."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run(
        [sys.executable, "-c", WATCHED, module, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(root)},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    wall, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Used(wall, processor, int((folder / MEMORY).read_text(encoding="utf-8")) / 1e3)


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
