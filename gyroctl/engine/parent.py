"""Processes that end with the one that began them."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from multiprocessing import parent_process
from multiprocessing.connection import wait
from threading import Thread
from types import FrameType
from typing import Any, NoReturn


def end_with_parent() -> None:
    """Let this process end with the one that began it, whatever it waits for.

    It may be a lock of a dead one; or work that never comes: a process of a pool holds both ends of the pipe of its
    work, and is not told when the other side dies. And where that one asks for its end, it ends without a word, also
    within a callback of a library, which would print an exception that is to end it, and go on.
    """
    _end_when_asked(os._exit)
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel, os._exit), daemon=True).start()


def _end_after(sentinel: int, way_out: Callable[[int], Any]) -> None:
    wait([sentinel])
    way_out(1)


def _end_when_asked(way_out: Callable[[int], Any]) -> None:
    """Let the handler of a pool end this process also while a law has been denied the way out."""
    before = signal.getsignal(signal.SIGTERM)
    if not callable(before) or threading.current_thread() is not threading.main_thread():
        return

    def end(number: int, frame: FrameType | None) -> NoReturn:
        setattr(os, "_exit", way_out)  # noqa: B010 - the type of a function that never returns
        try:
            before(number, frame)
        finally:
            way_out(number)
        raise SystemExit(number)  # there is none behind the way out

    signal.signal(signal.SIGTERM, end)
