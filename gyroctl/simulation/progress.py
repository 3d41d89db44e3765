"""A progress bar with the time left, on anything that takes longer than two seconds."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Any, TypeVar

T = TypeVar("T")

PATIENCE = 2.0
"""Work that ends within this time shows no bar. [s]"""


class Progress(AbstractContextManager["Progress"]):
    """Counts work items; shows a bar on a terminal, or a line now and then elsewhere, once the work takes long.

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
        self.said = self.begin
        self.bar: Any = None
        self.task: Any = None

    def __exit__(self, *failure: object) -> None:
        """Take the bar away."""
        if self.bar is not None:
            self.bar.stop()

    def advance(self, items: int = 1) -> None:
        """Count `items` as done."""
        self.done += items
        now = time.monotonic()
        if self.quiet or now - self.begin < PATIENCE:
            return
        if not sys.stderr.isatty():
            if now - self.said > 10.0 and self.done < self.total:
                self.said = now
                left = (now - self.begin) / self.done * (self.total - self.done)
                print(f"{self.title}: {self.done} of {self.total}, about {left:.0f} s left", file=sys.stderr)
            return
        if self.bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
            self.bar = Bar(*columns, console=Console(stderr=True), transient=True)
            self.bar.start()
            self.task = self.bar.add_task(self.title, total=self.total)
        self.bar.update(self.task, completed=self.done)


def track(items: Iterable[T], title: str, total: int, quiet: bool = False) -> Iterator[T]:
    """Yield `items` and count them on a `Progress`."""
    with Progress(title, total, quiet) as progress:
        for item in items:
            yield item
            progress.advance()
