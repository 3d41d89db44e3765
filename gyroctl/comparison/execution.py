"""A map over work items: neither the number of workers nor the order changes a bit, and what is stored is not run."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from gyroctl.comparison import store
from gyroctl.comparison.items import Item, Outcome, perform
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law, Preparing, innermost
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
                progress.skip()
        laws = {item.name: item.law for item in todo}
        processes = pools.enter_context(ProcessPoolExecutor(workers, mp_context=get_context("spawn")))
        threads = pools.enter_context(ThreadPoolExecutor(workers))
        alone = pools.enter_context(ThreadPoolExecutor(1))
        try:
            parts = _preparations(laws.values(), processes) if workers > 1 and len(todo) > 1 else []
            compiled = {name: compile_law(law) is not None for name, law in laws.items()}
            slow = [item for item in todo if not compiled[item.name]]
            apart = {name: workers > 1 and len(slow) > 1 and _can_be_sent(law) for name, law in laws.items()}
            fast = [(threads, item) for item in todo if compiled[item.name]]
            for stage, beside in ((fast, parts), ([(processes if apart[i.name] else alone, i) for i in slow], [])):
                futures: dict[Future[Any], Item] = {pool.submit(perform, item): item for pool, item in stage}
                for future in as_completed([*futures, *beside]):
                    outcome = future.result()
                    if future in futures:
                        item = futures[future]
                        store.save(results, item.key, outcome.sha256, outcome.values, outcome.series)
                        outcomes[item.name, item.seed] = outcome
                        progress.advance()
        except BaseException:
            for pool in (processes, threads, alone):
                pool.shutdown(wait=False, cancel_futures=True)
            raise
    return outcomes


def _preparations(laws: Iterable[Law], processes: ProcessPoolExecutor) -> list[Future[Any]]:
    """Have slow laws compile what they call, part by part at once: their runs find it done."""
    within = [innermost(law) for law in laws if _can_be_sent(law)]
    return [processes.submit(part) for law in within if isinstance(law, Preparing) for part in law.preparations()]


def _can_be_sent(law: Law) -> bool:
    """Whether a worker process can be given the law: not where it is from a user's file, which that does not know."""
    try:
        pickle.loads(pickle.dumps(law))
    except (pickle.PicklingError, AttributeError, TypeError, ImportError):
        return False
    return not type(law).__module__.startswith("gyroctl_user_")
