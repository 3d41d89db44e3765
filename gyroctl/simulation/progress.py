"""A progress bar with the time left, on anything that takes longer than two seconds."""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Any, TypeVar

T = TypeVar("T")

PATIENCE = 2.0
"""Work that ends within this time shows no bar. [s]"""

SPOKEN = 10.0
"""Time between two lines where there is no terminal. [s]"""

TRUSTED = 3.0
"""Time over which the rate must have been seen before a time left is told: workers finish their first together. [s]"""

TOGETHER = 0.5
"""What ends within this time ended at once: runs that go side by side. [s]"""

COMPILING = "compiling, and at work on the first; the time left is told after it"


class Progress(AbstractContextManager["Progress"]):
    """Counts work items; shows a bar on a terminal, or a line now and then elsewhere, once the work takes long.

    The time left is estimated from what was finished after the first item, whose time is mostly that of compilation,
    and from the later part of it: laws that take longer come last. Until then it says so.

    Parameters
    ----------
    title : str
        What is being done.
    total : int
        Number of items.
    quiet : bool
        Show nothing.
    """

    def __init__(self, title: str, total: int, quiet: bool = False) -> None:
        self.title, self.total, self.quiet = title, total, quiet
        self.done, self.begin = 0, time.monotonic()
        self.said = self.first = self.begin
        self.seen: deque[tuple[float, int]] = deque()
        self.bar: Any = None
        self.task: Any = None
        self.lock = threading.RLock()
        self.timer = threading.Timer(PATIENCE, self._still_compiling)
        self.timer.daemon = True

    def __enter__(self) -> Progress:
        """Start the clock after which it is said that nothing is finished yet."""
        if not self.quiet:
            self.timer.start()
        return self

    def __exit__(self, *failure: object) -> None:
        """Take the bar away."""
        self.timer.cancel()
        with self.lock:
            self.quiet = True
            if self.bar is not None:
                self.bar.stop()

    def skip(self, items: int = 1) -> None:
        """Count `items` that were found finished: they tell nothing about the time that the others take."""
        self.done += items

    def advance(self, items: int = 1) -> None:
        """Count `items` as done."""
        with self.lock:
            self.done += items
            now = time.monotonic()
            self.first = self.first if self.seen else now
            if not self.seen or (not self.quiet and now - self.seen[-1][0] >= TOGETHER):
                self.seen.append((now, self.done))
            if not self.quiet and now - self.begin >= PATIENCE:
                self._show(now)

    def left(self, now: float) -> float | None:
        """Estimate of the time left, or None where nothing is known of it yet. [s]"""
        if not self.seen:
            return None
        # the later half of the time in which something was finished, and never too little to tell a rate
        later = min(0.5 * (self.first + now), now - TRUSTED)
        while len(self.seen) > 2 and self.seen[1][0] <= later:
            self.seen.popleft()
        since, done = self.seen[0]
        if now - since < TRUSTED or self.done == done:
            return None
        each = (now - since) / (self.done - done)
        latest, begun = self.seen[-1]  # what ends with it counts for the time after it
        if begun > done:
            each = max((latest - since) / (begun - done), each if now - latest >= TOGETHER else 0.0)
        return each * (self.total - self.done)

    def _show(self, now: float) -> None:
        left = self.left(now)
        if not sys.stderr.isatty():
            if now - self.said > SPOKEN and self.done < self.total:
                self.said = now
                time_left = "time left not known yet" if left is None else f"about {left:.0f} s left"
                print(f"{self.title}: {self.done} of {self.total}, {time_left}", file=sys.stderr)
            return
        self._open_bar()
        self.bar.update(self.task, completed=self.done, left="" if left is None else f"about {left:.0f} s left")

    def _still_compiling(self) -> None:
        """Say what takes so long where nothing is finished yet."""
        with self.lock:
            if self.quiet or self.seen:
                return
            words = COMPILING
            if sys.stderr.isatty():
                self._open_bar()
                self.bar.update(self.task, completed=self.done, left=words)
            else:
                print(f"{self.title}: {words}", file=sys.stderr)

    def _open_bar(self) -> None:
        if self.bar is not None:
            return
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
        from rich.progress import Progress as Bar

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[left]}"),
        )
        self.bar = Bar(*columns, console=Console(stderr=True), transient=True)
        self.bar.start()
        self.task = self.bar.add_task(self.title, total=self.total, left="")


def track(items: Iterable[T], title: str, total: int, quiet: bool = False) -> Iterator[T]:
    """Yield `items` and count them on a `Progress`."""
    with Progress(title, total, quiet) as progress:
        for item in items:
            yield item
            progress.advance()
