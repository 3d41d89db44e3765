"""Processes that end with the one that began them."""

from __future__ import annotations

import os
from collections.abc import Callable
from multiprocessing import parent_process
from multiprocessing.connection import wait
from threading import Thread
from typing import Any


def end_with_parent() -> None:
    """Let this process end with the one that began it, whatever it waits for.

    It may be a lock of a dead one; or work that never comes: a process of a pool holds both ends of the pipe of its
    work, and is not told when the other side dies.
    """
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel, os._exit), daemon=True).start()


def _end_after(sentinel: int, way_out: Callable[[int], Any]) -> None:
    wait([sentinel])
    way_out(1)
