"""Processes that end with the one that began them."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from multiprocessing import parent_process
from multiprocessing.connection import wait
from threading import Thread
from typing import Any


def end_with_parent() -> None:
    """Let this process end with the one that began it, whatever it waits for.

    It may be a lock of a dead one; or work that never comes: a process of a pool holds both ends of the pipe of its
    work, and is not told when the other side dies. And asked to end (SIGTERM) it ends at once and without a word: a way
    out by Python is lost within a callback of a library, and cannot be told from one that a law takes.
    """
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel, os._exit), daemon=True).start()


def _end_after(sentinel: int, way_out: Callable[[int], Any]) -> None:
    wait([sentinel])
    way_out(1)
