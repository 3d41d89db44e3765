"""Processes of this machine that work, whatever becomes of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, InvalidStateError
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing import get_context
from typing import Any
from weakref import WeakSet

from pebble import CONSTS, ProcessPool

from gyroctl.engine.parent import end_with_parent

HELD = 10.0
"""After which a process no longer waits for the pipe of the pool: one that was killed may have held it. [s]"""


def begin_process(held: float) -> None:
    """Let this process end with the one that began it, and not wait long for what a killed one holds."""
    CONSTS.channel_lock_timeout = held
    end_with_parent()


class Processes:
    """Processes, begun anew where some were killed before any of them had work: pebble gives all of them up then."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.pool = self._begun()
        self.given: WeakSet[Future[Any]] = WeakSet()  # to this pool; somebody waits for them, or they do not matter

    def _begun(self) -> Any:
        return ProcessPool(self.workers, context=get_context("spawn"), initializer=begin_process, initargs=(HELD,))

    def schedule(self, function: Callable[..., Any], args: Sequence[Any], timeout: float | None = None) -> Future[Any]:
        """Let one of them call a function, no longer than `timeout` [s]."""
        try:
            future: Future[Any] = self.pool.schedule(function, args=args, timeout=timeout)
        except RuntimeError:
            self.look()
            self.pool.stop()
            self.pool.join()
            self.pool = self._begun()
            future = self.pool.schedule(function, args=args, timeout=timeout)
        self.given.add(future)
        return future

    def look(self) -> None:
        """Let work end that a pool was given which is no more: pebble forgets what it had not handed on yet."""
        waiting = [one for one in self.given if not one.done()]
        if waiting and not self.pool.active:
            for future in waiting:
                with suppress(InvalidStateError):  # it has ended meanwhile
                    future.set_exception(BrokenProcessPool("the processes were given up"))
            self.given.clear()
