"""Processes of this machine that work, whatever becomes of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Future, InvalidStateError
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any, NoReturn, TypeVar
from weakref import WeakSet

from pebble import CONSTS, ProcessExpired, ProcessPool

from gyroctl.engine.apart import CONTEXT
from gyroctl.engine.parent import end_with_parent

Result = TypeVar("Result")

AGAIN = 5
"""Times that work is begun anew which was given up with all processes, before it has failed."""

KILLED_AGAIN = 2
"""Times that work is begun anew whose own process was killed."""

KILLS = (9, 15)
"""Signals by which others end a process: SIGKILL and SIGTERM."""

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
        return ProcessPool(self.workers, context=CONTEXT, initializer=begin_process, initargs=(HELD,))

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


def is_lost(error: BaseException | None) -> bool:
    """Whether work was lost with a process that did not end by its fault, and is begun anew.

    All of them are given up at once where pebble cannot tell what a killed one was doing. And one that was killed while
    it held the pipe of the pool takes the others with it: they end by themselves, as a law may do only through the C
    library (`no_way_out`).
    """
    return isinstance(error, BrokenProcessPool) or (isinstance(error, ProcessExpired) and (error.exitcode or 0) > 0)


def times_anew(error: BaseException | None) -> int:
    """How often work is begun anew that ended so: what was lost with others often, what was killed itself twice.

    Who kills a process from outside, as a machine that wants memory or a scheduler of jobs, says nothing of its law.
    """
    if is_lost(error):
        return AGAIN
    return KILLED_AGAIN if isinstance(error, ProcessExpired) and -(error.exitcode or 0) in KILLS else 0


def how_it_ended(code: int | None, times: int = 1 + KILLED_AGAIN) -> str:
    """How a process ended, by its exit code, and what that says; one that was killed has been so all `times`."""
    if code is not None and code < 0:
        often = f" {times} times" if -code in KILLS else ""
        return f"lost its process{often}, which was killed (signal {-code}), perhaps for want of memory: run again"
    return f"ended its process (exit code {code}): a law must not end the program"


def no_way_out(function: Callable[..., Result], *arguments: Any) -> Result:
    """Call a function where an end of the process without a word is an error: with exit code 0 nobody would notice it.

    Raises
    ------
    SystemExit
        Where the function would end the process.
    """
    way_out = os._exit

    def refuse(status: int) -> NoReturn:
        raise SystemExit(status)

    os._exit = refuse
    try:
        return function(*arguments)
    finally:
        os._exit = way_out
