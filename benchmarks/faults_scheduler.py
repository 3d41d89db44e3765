"""A scheduler of Dask that is played: workers end their work in any order, are lost, differ; the scheduler is lost."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from gyroctl.comparison import cluster
from gyroctl.comparison import items as work
from gyroctl.comparison.items import Item, Outcome

Ended = Callable[[Sequence[Item]], list[Outcome]]
"""What runs give."""


class Scheduler:
    """What the hands of a cluster ask of a client of Dask: workers come, end their work in any order, and die."""

    def __init__(
        self, rng: random.Random, ended: Ended, note: Callable[[str], None], turn: Callable[[], None], sound: bool
    ) -> None:
        self.rng, self.ended, self.note, self.turn, self.sound = rng, ended, note, turn, sound
        self.scheduler, self.loop, self.status = SimpleNamespace(address="tcp://played"), self, "running"
        self.workers = {f"worker {number}": 1 for number in range(self.rng.randint(1, 3))}
        self.foreign = {"worker 2"} if not sound and self.rng.random() < 0.3 else set[str]()
        self.futures: list[Played] = []

    def nthreads(self) -> dict[str, int]:
        return dict(self.workers)

    def submit(self, *asked: Any, pure: bool, workers: Sequence[str] = (), **_: Any) -> Played:
        future = Played(asked, self.rng.choice(list(workers) or list(self.workers)))
        self.futures.append(future)
        return future

    def cancel(self, futures: Any) -> None:
        self.futures.clear()

    def next(self) -> Played:
        """The next one that has ended."""
        while True:
            self.turn()
            future = self.rng.choice(self.futures)
            event = 1.0 if self.sound else self.rng.random()
            if event < 0.01:
                self.status = "closed"
                raise CancelledError
            if event < 0.1:
                self.note("worker lost")
                future.losses += 1
                future.worker = self.rng.choice(list(self.workers))
                if future.losses < 3:
                    continue
                future.error = KilledWorker("worker lost")
            self.futures.remove(future)
            if future.error is None:
                future.found = self._done(future)
            return future

    def _done(self, future: Played) -> Any:
        """What a worker answers: by the real function, but for the runs themselves."""
        function, *asked = future.asked
        if future.worker not in self.foreign:
            with patch.object(work, "perform", self.ended), patch.object(cluster, "compile_law", lambda law: None):
                return function(*asked)
        self.note("worker left out")
        with patch.object(sys.modules[function.__module__], "code_of", lambda *_: "another"):
            return function(*asked)


class KilledWorker(Exception):
    """As that of Dask."""


class Played:
    """A piece of work on its way."""

    def __init__(self, asked: Sequence[Any], worker: str) -> None:
        self.asked, self.worker = asked, worker
        self.losses, self.found, self.error = 0, None, None  # type: int, Any, Any

    def result(self) -> Any:
        if self.error is not None:
            raise self.error
        return self.found


class Completed:
    """As `distributed.as_completed`."""

    def __init__(self, loop: Scheduler) -> None:
        self.loop = loop

    def add(self, future: Played) -> None:
        assert future in self.loop.futures

    def __next__(self) -> Played:
        return self.loop.next()


@contextmanager
def played_dask() -> Iterator[None]:
    """Let whoever asks for Dask meet this one."""
    worker = SimpleNamespace(address="worker 2")
    found = SimpleNamespace(as_completed=Completed, KilledWorker=KilledWorker, get_worker=lambda: worker)
    before = sys.modules.get("distributed")
    sys.modules["distributed"] = found  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules["distributed"]
        if before is not None:
            sys.modules["distributed"] = before
