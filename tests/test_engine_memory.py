"""Memory on a worker of a cluster: what was freed is used again, whatever Dask has told glibc."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

from gyroctl.engine.memory import FORBIDS, as_usual

pytestmark = pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="needs glibc")

FAULTS = """
import resource
import numpy as np
from gyroctl.engine.memory import keep_freed

if {keep}:
    keep_freed()
np.ones(1_000_000)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(20):
    np.ones(1_000_000)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(keep: bool, environment: dict[str, str]) -> int:
    """Pages of memory that the system clears while an array of 8 MB is made twenty times."""
    command = [sys.executable, "-c", FAULTS.format(keep=keep)]
    return int(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)


def test_worker_that_must_not_keep_memory_keeps_it_all_the_same() -> None:
    forbidden = {**os.environ, FORBIDS: "65536"}
    most = faults(False, forbidden)
    assert faults(True, forbidden) < 0.2 * most
    assert FORBIDS not in as_usual(forbidden) and faults(False, as_usual(forbidden)) < 0.2 * most
