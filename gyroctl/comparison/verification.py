"""Stored runs computed again: a sample of them, bit by bit."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.comparison.execution import outcome_of, run_items
from gyroctl.comparison.items import Item, Outcome
from gyroctl.engine import Store
from gyroctl.engine.store import differences, heads

CLOCKS = ("step_ms_median", "step_ms_p99", "deadline_misses")
"""What a clock has measured: no two runs have the same."""


@dataclass(frozen=True)
class Verified:
    """What became of a stored run that was computed again."""

    law: str
    seed: int
    about: Mapping[str, Any]  # what made it
    differs: tuple[str, ...]  # numbers and series that are not the same bits; "failed: ..." where the run failed

    @property
    def same(self) -> bool:
        """Whether every bit is."""
        return not self.differs


@dataclass(frozen=True)
class Verification:
    """A sample of stored runs, computed again."""

    found: tuple[Verified, ...]
    stored: int  # runs of this experiment that are stored and believed
    wanted: int  # runs that the experiment asks for
    apart: Mapping[str, int]  # runs that other libraries or processors made, by what differs


def verify(
    items: Sequence[Item],
    folder: Path,
    share: float = 0.05,
    count: int | None = None,
    workers: int = 1,
    seed: int | None = None,
    say: Callable[[str], None] = print,
) -> Verification:
    """Compute a random sample of the stored runs again and compare the bits.

    Parameters
    ----------
    items : sequence of Item
        What the experiment asks for, see `items.work_items`.
    folder : Path
        Of the stored results.
    share : float
        Part of the stored runs, one at least. [1]
    count : int, optional
        How many instead.
    workers : int
        Threads, and processes.
    seed : int, optional
        Of the sample, to draw it again.
    say : callable
        Told what is not believed.
    """
    store = Store(folder, say)
    records = {item.key: record for item in items if (record := store.load(item.key)) is not None}
    store.tell()
    stored = [item for item in items if item.key in records]
    wanted = count if count is not None else math.ceil(share * len(stored))
    sample = random.Random(seed).sample(stored, min(wanted, len(stored)))
    again = {item.key: outcome for item, outcome in run_items(sample, workers)}
    found = []
    for item in sample:
        kept = outcome_of(records[item.key])
        what: tuple[str, ...] = ("its content is that of no run",)
        what = what if kept is None else different(kept, again[item.key])
        found.append(Verified(item.name, item.seed, records[item.key].about, what))
    keys, apart = {item.key for item in items}, dict[str, int]()
    for head in heads(folder):
        if head["key"] not in keys and (other := differences(head)):
            apart[other] = apart.get(other, 0) + 1
    return Verification(tuple(found), len(stored), len(items), apart)


def different(kept: Outcome, again: Outcome) -> tuple[str, ...]:
    """Names of what is not the same bits in two outcomes of a run."""
    if again.failure:
        return (f"failed: {again.failure}",)
    one, two = (_numbers(outcome) for outcome in (kept, again))
    names = sorted({*one, *two})
    return tuple(name for name in names if one.get(name) != two.get(name))


def _numbers(outcome: Outcome) -> dict[str, bytes]:
    """Bits of all that an outcome holds but what a clock measured."""
    values = {name: np.float64(value).tobytes() for name, value in outcome.values.items() if name not in CLOCKS}
    series = {f"series {name}": np.ascontiguousarray(row).tobytes() for name, row in outcome.series.items()}
    return {**values, **series, "waves": outcome.sha256.encode()}
