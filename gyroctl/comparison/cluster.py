"""Work items on other machines, by Dask: a scheduler hands them out, workers run them, and the store keeps the results.

Nothing is kept on the way: what this process has stored is done, and anything else, a worker, the scheduler, this
process, may end at any time. A worker that would give other bits, for its code, its libraries or its processor, is left
out. Whoever reaches a scheduler can run code on it and on its workers: it belongs into a network of one's own.
"""

from __future__ import annotations

import logging
import math
import re
import sys
import time
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import cloudpickle

from gyroctl.comparison import items as work
from gyroctl.comparison.alone import in_a_process
from gyroctl.comparison.execution import is_machine, is_ours, perform_packed
from gyroctl.comparison.items import Item, Outcome, failed
from gyroctl.engine.store import aloud, differences
from gyroctl.errors import InputError, visible
from gyroctl.fingerprint import code_of, made_with
from gyroctl.fingerprint.local import sources
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law, Wrapping, innermost
from gyroctl.harness.together import pieces

ADDRESS = re.compile(r"(tcp|tls|ucx|ws|wss)://[\w.\-\[\]:]+:\d{1,5}(/[\w./\-]*)?")

PATIENCE = 30.0
"""For a scheduler to answer. [s]"""

FEWEST = 8
"""Threads for which work is cut into pieces at least, since workers may still come."""

AHEAD = 2
"""Pieces of work for each thread of a worker that are handed out: no more are in the scheduler's memory."""

SAME = "Install the same versions everywhere; for processors that differ see docs/cluster.md"


class Elsewhere(NamedTuple):
    """What a worker answers whose bits may be others."""

    worker: str
    made_with: dict[str, Any]


class Piece(NamedTuple):
    """Items of one law that are handed out at once."""

    items: tuple[Item, ...]  # without their law
    law: bytes
    modules: tuple[str, ...]  # of this package, that compute them
    code: str  # their hash here
    ours: bool  # whether the law comes with this package, and keeps its protocol
    machine: bool  # whether it runs side by side


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
    known = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == "distributed"]
    before = {name: logging.getLogger(name).level for name in known}
    for name in known:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def run_far(client: Any, items: Sequence[Item], _: int = 0) -> Generator[tuple[Item, Outcome], None, None]:
    """Run items on the workers of a scheduler, however many, and yield each with its outcome as they end.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost.
    InputError
        Field ``scheduler``, where no worker would give the same bits.
    """
    dask: Any = import_module("distributed")
    with _told_if_lost(client):
        hands = _Hands(client, dask.as_completed(loop=client.loop))
        waiting = deque(_handed_out(items, max(hands.threads(), FEWEST)))
        if not client.nthreads():
            aloud("The scheduler has no worker yet: waiting for one")
        try:
            while waiting or hands.full:
                while waiting and len(hands.full) < max(4, AHEAD * hands.threads()):
                    hands.take(*waiting.popleft())
                future, piece, whole = hands.next()
                try:
                    found = future.result()
                except dask.KilledWorker:
                    if len(whole) > 1:  # one of them takes its worker with it: which one, each tells alone
                        parts = zip(piece.items, whole, strict=True)
                        waiting.extend((piece._replace(items=(sent,)), [item]) for sent, item in parts)
                    else:
                        what = f"law {whole[0].name!r} lost its worker again and again, perhaps for want of memory"
                        yield whole[0], failed(whole[0], what)
                except ImportError as error:
                    raise InputError("scheduler", hands.address, f"a worker lacks {error}", SAME) from None
                else:
                    if isinstance(found, Elsewhere):
                        hands.leave_out(found)
                        waiting.appendleft((piece, whole))
                    else:
                        yield from zip(whole, found, strict=True)
                del future  # the scheduler keeps a result as long as it is held here
        finally:
            if client.status == "running":
                client.cancel(list(hands.full))


@contextmanager
def _told_if_lost(client: Any) -> Iterator[None]:
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

    def __init__(self, client: Any, ended: Any) -> None:
        self.client, self.ended, self.address = client, ended, client.scheduler.address
        self.full: dict[Any, tuple[Piece, list[Item]]] = {}
        self.foreign: dict[str, str] = {}  # by address, what differs
        self._threads, self._asked = 1, -math.inf

    def threads(self) -> int:
        """Threads of all workers, asked for now and then: a cluster grows and shrinks."""
        now = time.monotonic()
        if now - self._asked > 1.0:
            self._threads, self._asked = max(1, sum(self.client.nthreads().values())), now
        return self._threads

    def take(self, piece: Piece, whole: list[Item]) -> None:
        """Hand out a piece, to a worker that gives the same bits if one is known."""
        others: dict[str, Any] = {}
        if self.foreign:
            known = [one for one in self.client.nthreads() if one not in self.foreign]
            if not known:
                what = "; ".join(sorted(set(self.foreign.values())))
                raise InputError("scheduler", self.address, f"no worker gives the same bits: {what}", SAME)
            others = {"workers": known, "allow_other_workers": True}  # those that come later too
        future = self.client.submit(run_there, piece, pure=False, **others)
        self.full[future] = piece, whole
        self.ended.add(future)

    def next(self) -> tuple[Any, Piece, list[Item]]:
        """Wait for the next one that has ended."""
        future = next(self.ended)
        return (future, *self.full.pop(future))

    def leave_out(self, found: Elsewhere) -> None:
        """Note a worker whose bits may be others, and say so once."""
        if found.worker not in self.foreign:
            what = differences({"made_with": found.made_with}) or "another version of gyroctl"
            self.foreign[found.worker] = what
            aloud(f"Worker {found.worker} is left out, its bits may be others: {what}")


def _handed_out(items: Sequence[Item], threads: int) -> Iterator[tuple[Piece, list[Item]]]:
    """Share out items law by law, those that run side by side together."""
    of_law: dict[str, list[Item]] = {}
    for item in items:
        of_law.setdefault(item.name, []).append(item)
    for own in of_law.values():
        law = own[0].law
        ours = is_ours(law)
        machine = ours and is_machine(law)
        modules = tuple(sorted({work.__name__, *_modules(law)}))
        common = (by_value(law), modules, code_of(*modules), ours, machine)
        for part in pieces(len(own), threads) if machine else [slice(i, i + 1) for i in range(len(own))]:
            yield Piece(tuple(replace(item, law=None) for item in own[part]), *common), own[part]


def _modules(law: Law) -> Iterator[str]:
    """Modules of this package that a law and those within it are of."""
    one: Any = law
    while one is not None:
        name = type(one).__module__
        if name.startswith("gyroctl."):
            yield name
        one = one.law if isinstance(one, Wrapping) else None


def by_value(law: Law) -> bytes:
    """Pack a law with the text of its own modules: another machine does not have them.

    Raises
    ------
    InputError
        For a law that holds what cannot be packed.
    """
    module = sys.modules.get(type(innermost(law)).__module__)
    local = [] if is_ours(law) else [one for one in _local_modules(law) if one.__name__ != "__main__"]
    if module is not None and not is_ours(law) and module.__name__ != "__main__" and module not in local:
        local.append(module)
    for one in local:
        cloudpickle.register_pickle_by_value(one)
    try:
        packed: bytes = cloudpickle.dumps(law)
    except Exception as error:  # what a user's object may do when it is asked for its parts
        problem = f"cannot be sent to another machine ({type(error).__name__}: {error})"
        raise InputError("law", type(law).__name__, problem, "Keep plain values in it") from error
    finally:
        for one in local:
            cloudpickle.unregister_pickle_by_value(one)
    return packed


def _local_modules(law: Law) -> list[Any]:
    """Modules that lie beside a law from elsewhere and that it imports, one through another."""
    file = vars(type(innermost(law)))["step"].__code__.co_filename if "step" in vars(type(innermost(law))) else ""
    files = {str(path) for path in sources([Path(file)]).files} if file else set()
    found = []
    for one in list(sys.modules.values()):
        where = getattr(one, "__file__", None)
        if where and str(Path(where).resolve()) in files:
            found.append(one)
    return found


def run_there(piece: Piece) -> list[Outcome] | Elsewhere:
    """Run a piece of work on a worker; one that would give other bits says so instead."""
    if code_of(*piece.modules) != piece.code:
        dask: Any = import_module("distributed")
        return Elsewhere(dask.get_worker().address, made_with())
    if not piece.ours:  # whatever such a law does, its run fails alone and can be stopped
        return [outcome for item in piece.items for outcome in in_a_process(item, piece.law)]
    if not piece.machine:
        return [outcome for item in piece.items for outcome in perform_packed(item, piece.law)]
    law = cloudpickle.loads(piece.law)
    compile_law(law)
    return work.perform([replace(item, law=law) for item in piece.items])
