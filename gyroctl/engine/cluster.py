"""Work on other machines, by Dask: a scheduler hands it out, workers do it, and the store keeps the results.

Nothing is kept on the way: what this process has stored is done, and anything else, a worker, the scheduler, this
process, may end at any time. A worker that would give other bits, for its code, its libraries or its processor, is left
out. Whoever reaches a scheduler can run code on it and on its workers: it belongs into a network of one's own.
"""

from __future__ import annotations

import logging
import math
import re
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from enum import Enum
from importlib import import_module
from typing import Any, NamedTuple

from gyroctl.engine.memory import keep_freed
from gyroctl.engine.store import aloud, differences
from gyroctl.errors import InputError, visible
from gyroctl.fingerprint import code_of, made_with

ADDRESS = re.compile(r"(tcp|tls|ucx|ws|wss)://[\w.\-\[\]:]+:\d{1,5}(/[\w./\-]*)?")

PATIENCE = 30.0
"""For a scheduler to answer. [s]"""

FEWEST = 8
"""Threads for which work is cut into pieces at least, since workers may still come."""

AHEAD = 2
"""Pieces of work for each thread of a worker that are handed out: no more are in the scheduler's memory."""

TALKING = ("distributed", "tornado", "asyncio")
"""Those who log what happens to a connection."""

SAME = 'Install the same versions everywhere; for processors that differ see the page "On other machines"'


class Lost(Enum):
    """Why a piece of work has no answer, in words."""

    WORKER = "lost its worker again and again, perhaps for want of memory"
    MEMORY = "found too little memory on its worker: give workers more, or a shorter duration"


class Elsewhere(NamedTuple):
    """What a worker answers whose bits may be others."""

    worker: str
    made_with: dict[str, Any]


class Task(NamedTuple):
    """A piece of work."""

    what: Any  # sent to a worker
    own: Any  # what it is here, where it stays
    modules: tuple[str, ...]  # of this package, that do it
    code: str  # their hash here


@contextmanager
def connected(scheduler: Any) -> Iterator[Any]:
    """Give a client: that of an address, which is closed at the end, or the user's own.

    Raises
    ------
    InputError
        Field ``scheduler``: Dask is not installed, the address is none, or nobody answers there.
    """
    try:
        dask: Any = import_module("distributed")
    except ImportError:
        problem = "dask.distributed is not installed"
        raise InputError("scheduler", str(scheduler), problem, 'pip install "gyroctl[cluster]"') from None
    if isinstance(scheduler, dask.Client):
        if scheduler.asynchronous:
            raise InputError("scheduler", "Client", "is asynchronous", "Give dask.distributed.Client(address)")
        yield scheduler
        return
    mend = "Give the address that dask scheduler prints, tcp://HOST:8786"
    if not isinstance(scheduler, str) or not ADDRESS.fullmatch(scheduler):
        raise InputError("scheduler", scheduler, "is no address of a scheduler", mend)
    with _without_words():
        try:
            client = dask.Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, RuntimeError) as error:
            raise InputError("scheduler", scheduler, f"does not answer: {visible(str(error))}", mend) from None
        try:
            yield client
        finally:
            client.close(timeout=PATIENCE)


@contextmanager
def _without_words() -> Iterator[None]:
    """Keep Dask from logging: what ends is told here, in one line."""
    known = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in TALKING]
    before = {name: logging.getLogger(name).level for name in known}
    for name in known:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def threads_of(client: Any) -> int:
    """Threads of all workers of a scheduler, one at least."""
    found: dict[str, int] = client.nthreads()
    return max(1, sum(found.values()))


def hand_out(
    client: Any, perform: Callable[[Any], Any], tasks: Iterable[Task], apart: Callable[[Task], list[Task]]
) -> Generator[tuple[Task, Any], None, None]:
    """Let the workers of a scheduler perform tasks, however many, and yield each with its answer as they end.

    Parameters
    ----------
    client : dask.distributed.Client
        Of the scheduler.
    perform : callable
        Of a module that workers have too; it is given ``task.what``.
    tasks : iterable of Task
        What is to be done.
    apart : callable
        Takes a task apart whose worker was lost again and again: which part of it takes a worker with it, each tells
        alone. A task of one part has a `Lost` for its answer.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost.
    InputError
        Field ``scheduler``, where no worker would give the same bits.
    """
    dask: Any = import_module("distributed")
    with told_if_lost(client):
        hands = _Hands(client, perform, dask.as_completed(loop=client.loop))
        fresh, again = iter(tasks), deque[Task]()

        def following() -> Task | None:
            return again.popleft() if again else next(fresh, None)

        if not client.nthreads():
            aloud("The scheduler has no worker yet: waiting for one")
        try:
            coming = following()
            while coming is not None or hands.full:
                while coming is not None and len(hands.full) < max(4, AHEAD * hands.threads()):
                    hands.take(coming)
                    coming = following()
                future, task = hands.next()
                try:
                    found = future.result()
                except (dask.KilledWorker, MemoryError) as error:
                    parts = apart(task)
                    again.extend(parts if len(parts) > 1 else ())
                    if len(parts) < 2:
                        yield task, Lost.MEMORY if isinstance(error, MemoryError) else Lost.WORKER
                except ImportError as error:
                    raise InputError("scheduler", hands.address, f"a worker lacks {error}", SAME) from None
                else:
                    # what is held here while it is stored would be computed again where its worker dies meanwhile
                    del future
                    if isinstance(found, Elsewhere):
                        hands.leave_out(found)
                        again.append(task)
                    else:
                        yield task, found
                coming = coming or following()
        finally:
            if client.status == "running":
                client.cancel(list(hands.full))


@contextmanager
def told_if_lost(client: Any) -> Iterator[None]:
    """Whatever goes wrong where the scheduler is lost is that."""
    address = client.scheduler.address
    try:
        yield
    except (Exception, CancelledError) as error:
        if client.status == "running" and not isinstance(error, CancelledError):
            raise
        raise ConnectionError(f"the scheduler at {address} was lost") from error


class _Hands:
    """What is handed out to the workers of a scheduler, and which of them are left out."""

    def __init__(self, client: Any, perform: Callable[[Any], Any], ended: Any) -> None:
        self.client, self.perform, self.ended = client, perform, ended
        self.address: str = client.scheduler.address
        self.full: dict[Any, Task] = {}
        self.foreign: dict[str, str] = {}  # by address, what differs
        self._threads, self._asked = 1, -math.inf

    def threads(self) -> int:
        """Threads of all workers, asked for now and then: a cluster grows and shrinks."""
        now = time.monotonic()
        if now - self._asked > 1.0:
            self._threads, self._asked = threads_of(self.client), now
        return self._threads

    def take(self, task: Task) -> None:
        """Hand out a piece of work, to a worker that gives the same bits if one is known."""
        others: dict[str, Any] = {}
        if self.foreign:
            known = [one for one in self.client.nthreads() if one not in self.foreign]
            if not known:
                what = "; ".join(sorted(set(self.foreign.values())))
                raise InputError("scheduler", self.address, f"no worker gives the same bits: {what}", SAME)
            others = {"workers": known, "allow_other_workers": True}  # those that come later too
        future = self.client.submit(there, self.perform, task.what, task.modules, task.code, pure=False, **others)
        self.full[future] = task
        self.ended.add(future)

    def next(self) -> tuple[Any, Task]:
        """Wait for the next one that has ended."""
        future = next(self.ended)
        return future, self.full.pop(future)

    def leave_out(self, found: Elsewhere) -> None:
        """Note a worker whose bits may be others, and say so once."""
        if found.worker not in self.foreign:
            what = differences({"made_with": found.made_with}) or "another version of gyroctl"
            self.foreign[found.worker] = what
            aloud(f"Worker {found.worker} is left out, its bits may be others: {what}")


def there(perform: Callable[[Any], Any], what: Any, modules: tuple[str, ...], code: str) -> Any:
    """Do a piece of work on a worker; one that would give other bits says so instead."""
    if code_of(*modules) != code:
        dask: Any = import_module("distributed")
        return Elsewhere(dask.get_worker().address, made_with())
    keep_freed()
    return perform(what)
