"""Ctrl-C ends a command within seconds, whatever its threads and libraries make of the exception.

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
GRACE = 3.0
"""Time to end in good order. [s]"""

said = threading.Event()


def end_soon_at_interrupt() -> None:
    """Let the first Ctrl-C raise KeyboardInterrupt, and end the process where that has not ended it after `GRACE`."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end, daemon=True).start()
    raise KeyboardInterrupt


def _end() -> NoReturn:
    from multiprocessing import active_children

    time.sleep(GRACE)
    for child in active_children():
        child.kill()
    _say_once()
    os._exit(CODE)


def stopped() -> NoReturn:
    """End in good order, and say what became of the work."""
    _say_once()
    sys.exit(CODE)


def _say_once() -> None:
    if not said.is_set():
        said.set()
        print(STOPPED, file=sys.stderr, flush=True)
