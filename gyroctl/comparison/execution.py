"""A map over work items: neither the number of workers nor the order changes a bit, and what is stored is not run."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from gyroctl.comparison import store
from gyroctl.comparison.items import Item, Outcome, perform
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Preparing, innermost
from gyroctl.simulation.progress import Progress

Outcomes = dict[tuple[str, int], Outcome]
"""Results by law and seed."""


def execute(items: Sequence[Item], workers: int, results: Path | None, quiet: bool) -> Outcomes:
    """Run the items that are not stored: compiled laws on threads, the others on processes if there are workers.

    Parameters
    ----------
    items : sequence of Item
        What is wanted.
    workers : int
        Threads or processes.
    results : Path or None
        Folder of the stored results; each one is stored when it is there.
    quiet : bool
        Show no progress.
    """
    outcomes: Outcomes = {}
    with Progress("runs", len(items), quiet) as progress, ExitStack() as pools:
        todo = []
        for item in items:
            stored = store.load(results, item.key)
            if stored is None:
                todo.append(item)
            else:
                outcomes[item.name, item.seed] = Outcome(*stored)
                progress.advance()
        compiled = {item.name: compile_law(item.law) is not None for item in todo}
        fast = [item for item in todo if compiled[item.name]]
        slow = [item for item in todo if not compiled[item.name]]
        threads = pools.enter_context(ThreadPoolExecutor(workers))
        processes = pools.enter_context(_processes(workers, slow))
        try:
            parts = _preparations(slow, processes)  # on a new installation they compile, beside the fast runs
            for pool, batch, beside in ((threads, fast, parts), (processes, slow, [])):
                futures: dict[Future[Any], Item] = {pool.submit(perform, item): item for item in batch}
                for future in as_completed([*futures, *beside]):
                    outcome = future.result()
                    if future in futures:
                        item = futures[future]
                        store.save(results, item.key, outcome.sha256, outcome.values, outcome.series)
                        outcomes[item.name, item.seed] = outcome
                        progress.advance()
        except BaseException:
            for pool in (threads, processes):
                pool.shutdown(wait=False, cancel_futures=True)
            raise
    return outcomes


def _preparations(slow: Sequence[Item], processes: Executor) -> list[Future[Any]]:
    """Have slow laws compile what they call, part by part at once: their runs find it done."""
    if not isinstance(processes, ProcessPoolExecutor):
        return []
    laws = {item.name: innermost(item.law) for item in slow}
    return [
        processes.submit(part) for law in laws.values() if isinstance(law, Preparing) for part in law.preparations()
    ]


def _processes(workers: int, batch: Sequence[Item]) -> Executor:
    """Processes for laws that run as Python; a single thread where one will do, or where a law cannot be sent."""
    if workers == 1 or len(batch) <= 1:
        return ThreadPoolExecutor(1)
    try:
        for law in {item.name: item.law for item in batch}.values():
            pickle.loads(pickle.dumps(law))
            if type(law).__module__.startswith("gyroctl_user_"):
                raise pickle.PicklingError  # a worker process would not know the user's file
    except (pickle.PicklingError, AttributeError, TypeError, ImportError):
        return ThreadPoolExecutor(1)
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
