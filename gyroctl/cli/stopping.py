"""Ctrl-C, or the end that a queue or an operator asks for, ends a command within seconds, whatever it is in.

Python raises KeyboardInterrupt wherever the main thread is: inside a callback of a library it is lost, and a thread
that compiles is waited for. What is finished is stored whole, so that the process may end at any time.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from types import FrameType
from typing import NoReturn

STOPPED = "Stopped. Finished runs are kept and will not be computed again."
CODE = 130
"""Exit code after Ctrl-C; typer's too."""

ASKED = 143
"""Exit code after an end that was asked for (SIGTERM)."""

GRACE = 3.0
"""Time to end in good order. [s]"""

said, asked = threading.Event(), threading.Event()


def end_soon_at_interrupt() -> None:
    """Let the first such signal raise KeyboardInterrupt, and end the process where it is still there after `GRACE`."""
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    if number == signal.SIGTERM:
        asked.set()
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, _once)  # where it were ignored, a process that is started now would ignore it too
    sys.unraisablehook = _unheard  # within the callback of a library what is raised here would be shown, and lost
    threading.Thread(target=_end, daemon=True).start()
    raise KeyboardInterrupt


def _once(number: int, frame: FrameType | None) -> None:
    """Hear no further signal."""


def _unheard(_: object) -> None:
    """Show nothing."""


def _end() -> NoReturn:
    from multiprocessing import active_children

    time.sleep(GRACE)
    for child in active_children():
        child.kill()
    _say_once()
    os._exit(_code())


def _code() -> int:
    return ASKED if asked.is_set() else CODE


def stopped() -> NoReturn:
    """End in good order, and say what became of the work."""
    _say_once()
    sys.exit(_code())


def _say_once() -> None:
    if not said.is_set():
        said.set()
        print(STOPPED, file=sys.stderr, flush=True)
