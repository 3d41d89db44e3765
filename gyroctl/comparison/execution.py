"""A map over work items: neither the number of workers nor the order changes a bit, and what is stored is not run.

The package's own compiled laws run on threads. Its other laws, and every law from elsewhere, run in processes of their
own, where each run gets the law anew: whatever such a law does, the run fails alone, and can be stopped.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ThreadPoolExecutor, wait
from contextlib import closing, contextmanager
from faulthandler import cancel_dump_traceback_later, dump_traceback_later
from functools import partial
from heapq import heappop, heappush
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import cloudpickle
from pebble import ProcessExpired

from gyroctl.comparison.items import Item, Outcome, about, failed, perform
from gyroctl.comparison.kept import kept
from gyroctl.comparison.parcels import Parcel, law_of, opened, parcels
from gyroctl.comparison.processes import AGAIN, Processes, how_it_ended, no_way_out, times_anew
from gyroctl.disk import DISK, Disk
from gyroctl.engine import Record, Store
from gyroctl.engine.plan import Plan, Wanted
from gyroctl.errors import InputError
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law, Machined, Preparing, innermost
from gyroctl.harness.together import pieces
from gyroctl.harness.travelling import by_value, is_ours
from gyroctl.simulation.progress import Progress

Outcomes = dict[tuple[str, int], Outcome]
"""Results by law and seed."""

AHEAD = 4
"""Pieces of work for each worker that are begun or have not been taken yet, of threads and of processes each."""

LOOK = 1.0
"""After which it is looked whether the processes are still there, where nothing ends. [s]"""

GRACE = 30.0
"""What a process may take beside its run: start, compilation. [s]"""

LONGEST = 1e6
"""Any run. [s]"""


Run = Callable[[Sequence[Item], int], Generator[tuple[Item, Outcome], None, None]]
"""Runs items and yields each with its outcome as they end; where it runs them changes no bit."""


def execute(
    items: Sequence[Item],
    workers: int,
    results: Path | None,
    quiet: bool,
    case: str = "",
    run: Run | None = None,
    disk: Disk = DISK,
) -> Outcomes:
    """Run the items that are not stored.

    Parameters
    ----------
    items : sequence of Item
        What is wanted.
    workers : int
        Threads, and processes.
    results : Path or None
        Folder of the stored results; each one is stored when it is there, but not a failure.
    quiet : bool
        Show no progress.
    case : str
        What these runs are of, for `gyroctl status`.
    run : callable, optional
        What runs them, by default `run_items` on this machine.
    disk : Disk
        The file system.

    Raises
    ------
    OSError
        Where a result cannot be stored; those that are finished are whole.
    """
    outcomes: Outcomes = {}
    store, laws = Store(results, disk=disk), len({item.name for item in items})
    with Progress("runs", len(items), quiet) as progress:
        todo = []
        for item in items:
            stored = outcome_of(store.load(item.key))
            if stored is None:
                todo.append(item)
            else:
                outcomes[item.name, item.seed] = kept(item, stored, laws)
                progress.skip()
        store.tell()
        if todo:
            store.tell_apart({item.key for item in items}, {(case, item.name) for item in todo})
        plan = Plan(results, case, [Wanted(item.key, item.name, item.seed) for item in items], disk)
        with plan, store.beside() as save, closing((run or run_items)(todo, workers)) as ended:
            for item, outcome in ended:
                if (item.name, item.seed) in outcomes:
                    continue  # a result that came twice is the same one
                if outcome.failure:
                    plan.failed(item.key or f"{item.name} {item.seed}", outcome.failure)
                else:
                    content = {"sha256": outcome.sha256, "values": dict(outcome.values)}
                    save(item.key, content, outcome.series, about(item, case))
                outcomes[item.name, item.seed] = kept(item, outcome, laws)
                progress.advance()
    return outcomes


def outcome_of(record: Record | None) -> Outcome | None:
    """Outcome that was stored; what is no outcome is run again."""
    sha256, values = (record.content.get(name) if record is not None else None for name in ("sha256", "values"))
    if record is None or not isinstance(sha256, str) or not isinstance(values, dict):
        return None
    numbers = all(isinstance(value, float) for value in values.values())
    series = all(row.ndim == 1 and row.dtype.kind in "fiub" for row in record.arrays.values())
    return Outcome(sha256, values, dict(record.arrays)) if numbers and series else None


def run_items(items: Sequence[Item], workers: int) -> Generator[tuple[Item, Outcome], None, None]:
    """Run items, and yield each with its outcome as they end.

    Laws are compiled one after the other, and what is compiled runs meanwhile; slow laws begin in their processes as
    soon as what they compile on a new installation is done.
    """
    laws = {item.name: item.law for item in items}
    fast = [name for name, law in laws.items() if is_ours(law) and is_fast(law)]
    quick = set(fast)
    slow = [name for name in laws if name not in quick]
    of_law: dict[str, list[Item]] = {name: [] for name in laws}
    for item in items:
        of_law[item.name].append(item)
    with _pools(workers) as (threads, processes):
        under_way = _UnderWay(AHEAD * workers, processes.look)
        several = workers > 1 and len(items) > 1
        parts = [processes.schedule(_prepare, args=(part,)) for part in _all_parts(laws)] if several else []

        def begin(name: str) -> None:
            """By threads, side by side, what is machine code, and by processes the rest."""
            own, law = of_law[name], laws[name]
            machine = name in quick or (is_ours(law) and is_machine(law))
            shares = [own[part] for part in pieces(len(own), workers)] if machine else [[item] for item in own]
            if machine or (is_ours(law) and not several):
                turns = enumerate(shares)
                work = [Work(partial(threads.submit, perform, share), share, turn=turn) for turn, share in turns]
                under_way.add("threads", work)
            else:
                sending = zip(_sending(own, processes), own, strict=True)
                under_way.add("processes", [Work(send, [item]) for send, item in sending])

        def begin_slow() -> None:
            while slow:
                begin(slow.pop(0))

        for name in fast:
            if all(part.done() for part in parts):
                begin_slow()
            compile_law(laws[name])
            begin(name)
            yield from under_way.done()  # what has ended is not held until all have begun
        yield from under_way.ended(parts)
        if slow:
            begin_slow()
            yield from under_way.ended()


class Work(NamedTuple):
    """What begins some items, these, how often it was begun anew, and its turn among its kind: the smallest is next.

    Pieces of several laws take turns seed by seed: what is found of a realisation is still kept for the next law.
    """

    begin: Callable[[], Future[Any]]
    items: list[Item]
    again: int = 0
    turn: int = 0


class _UnderWay:
    """Work that runs, no more of each kind at a time than `most`: what has ended and is not taken yet is in memory."""

    def __init__(self, most: int, look: Callable[[], None] = lambda: None) -> None:
        self.most, self.look = most, look  # what is called now and then while nothing ends
        self.waiting: dict[str, list[tuple[int, int, Work]]] = {}  # heaps: by turn, then as they came
        self.came = count()
        self.running: dict[Future[Any], tuple[str, Work]] = {}

    def add(self, kind: str, work: Iterable[Work]) -> None:
        """Let work wait for its turn among its kind, or begin."""
        for one in work:
            self._wait(kind, one)
        self._begin()

    def _wait(self, kind: str, work: Work) -> None:
        heappush(self.waiting.setdefault(kind, []), (work.turn, next(self.came), work))

    def _begin(self) -> None:
        for kind, waiting in self.waiting.items():
            free = self.most - sum(one == kind for one, _ in self.running.values())
            for _ in range(min(free, len(waiting))):
                _, _, work = heappop(waiting)
                self.running[work.begin()] = kind, work

    def done(self) -> Iterator[tuple[Item, Outcome]]:
        """Items with their outcomes of the work that has ended by now."""
        ready = deque(future for future in self.running if future.done())
        while ready:
            yield from self._taken(ready.popleft())

    def _taken(self, future: Future[Any]) -> Iterator[tuple[Item, Outcome]]:
        kind, work = self.running.pop(future)
        if work.again < times_anew(future.exception()):
            self._wait(kind, work._replace(again=work.again + 1))
            self._begin()
            return
        self._begin()
        outcomes = _outcomes_of(future, work.items)
        del future  # it keeps its result as long as it is kept
        yield from zip(work.items, outcomes, strict=True)

    def ended(self, beside: Sequence[Future[Any]] = ()) -> Iterator[tuple[Item, Outcome]]:
        """Items with their outcomes as they end, and no sooner the end than that of what runs beside them."""
        while self.running or not all(one.done() for one in beside):
            if not self._one_has_ended(beside):
                self.look()
            yield from self.done()

    def _one_has_ended(self, beside: Sequence[Future[Any]]) -> bool:
        """Wait a while for one to end. It is kept nowhere here: it keeps its result as long as it is."""
        open_ones = [*self.running, *(one for one in beside if not one.done())]
        return bool(wait(open_ones, timeout=LOOK, return_when=FIRST_COMPLETED).done)


@contextmanager
def _pools(workers: int) -> Iterator[tuple[ThreadPoolExecutor, Processes]]:
    """Threads and processes; whatever stops the work stops both at once."""
    threads = ThreadPoolExecutor(workers)
    processes = Processes(workers)
    try:
        yield threads, processes
        processes.pool.close()
    except BaseException:
        processes.pool.stop()
        raise
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        processes.pool.join()


def is_fast(law: Law) -> bool:
    """Whether a law is compiled at once."""
    return isinstance(innermost(law), tuple)


def is_machine(law: Law) -> bool:
    """Whether a law of ours is machine code, so that its runs go side by side."""
    return is_fast(law) or (isinstance(law, Machined) and law.machine() is not None)


def _parts(law: Law) -> Sequence[Any]:
    """What a slow law of ours compiles on a new installation, part by part: its runs find it done."""
    within = innermost(law)
    return within.preparations() if is_ours(law) and isinstance(within, Preparing) else ()


def _all_parts(laws: Mapping[str, Law]) -> list[Callable[[], Any]]:
    return [part for law in laws.values() for part in _parts(law)]


def _prepare(part: Callable[[], Any]) -> None:
    """Compile a part in this process; what it gives stays here, on disk is what counts."""
    part()


def _sending(items: Sequence[Item], processes: Processes) -> Iterator[Callable[[], Future[Any]]]:
    """Yield what sends each item of a law to a process."""
    item = items[0]
    try:
        law = by_value(item.law)
    except InputError as error:
        for one in items:
            failure: Future[Any] = Future()
            failure.set_result([failed(one, f"law {one.name!r} {error.problem}. {error.mend}")])
            yield partial(_given, failure)
        return
    for parcel in parcels(items, law):
        yield partial(processes.schedule, perform_sent, (parcel,), parcel.item.time_limit + GRACE)


def _given(future: Future[Any]) -> Future[Any]:
    return future


def perform_sent(parcel: Parcel) -> list[Outcome]:
    """Run an item in this process: with a law of its own, or the compiled one that holds no state.

    Who waits for it ends it after its limit. Where nobody does any more, since that process was killed, it ends by
    itself, whatever its law is in the middle of.
    """
    item = parcel.item
    try:
        with _ended_after(2.0 * (item.time_limit + GRACE)):
            return no_way_out(perform_packed, parcel)
    except BaseException as error:
        return [failed(item, f"law {item.name!r} failed in its process with {type(error).__name__}: {error}")]


@contextmanager
def _ended_after(limit: float) -> Iterator[None]:
    """End this process after a while [s], even where machine code lets no other thread run."""
    with open(os.devnull, "w") as nowhere:
        dump_traceback_later(min(limit, LONGEST), exit=True, file=nowhere)
        try:
            yield
        finally:
            cancel_dump_traceback_later()


def perform_packed(parcel: Parcel) -> list[Outcome]:
    """Run an item whose law is packed: with a law of its own, unless that is compiled and holds no state."""
    law = law_of(parcel) if compile_law(law_of(parcel)) is not None else cloudpickle.loads(parcel.law)
    return perform([opened(parcel, law)])


def _outcomes_of(future: Future[Any], items: Sequence[Item]) -> list[Outcome]:
    """Results of items, or how their runs failed."""
    try:
        outcomes: list[Outcome] = future.result()
    except TimeoutError:
        what = "took longer than {0:g} s: compute less in step, or allow more with run.time_limit"
    except ProcessExpired as error:
        what = how_it_ended(error.exitcode)
    except BrokenExecutor:
        what = how_it_ended(-9, 1 + AGAIN)
    else:
        return outcomes
    return [failed(item, f"law {item.name!r} {what.format(item.time_limit)}") for item in items]
