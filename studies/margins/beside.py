"""Work beside other work, on the second core: begun when it is told to, and ended soon where the other one fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from threading import Event
from typing import Generic, TypeVar

Result = TypeVar("Result")
Tick = Callable[[], None]


class Beside(Generic[Result]):
    """Work on a thread of its own."""

    def __init__(self, start: Callable[[], Future[Result]]) -> None:
        self._start = start
        self._future: Future[Result] | None = None

    def begin(self) -> None:
        """Begin now."""
        self._future = self._future or self._start()

    def result(self) -> Result:
        """Wait for the result; whatever the work raised is raised here."""
        self.begin()
        assert self._future is not None
        return self._future.result()


@contextmanager
def beside(work: Callable[[Tick], Result], tick: Tick) -> Iterator[Beside[Result]]:
    """Offer work that calls `tick` now and then: after the end of the context its next call ends it."""
    over = Event()

    def told() -> None:
        if over.is_set():
            raise CancelledError
        tick()

    with ThreadPoolExecutor(1) as pool:
        try:
            yield Beside(lambda: pool.submit(work, told))
        finally:
            over.set()
