"""What the engine costs beside the runs, and what a second worker is worth.

    python benchmarks/engine_overhead.py                  # some five minutes on two idle cores
    python benchmarks/engine_overhead.py --items 8        # a trial

Items of about ``--seconds`` each, of a law from a file, that sleep or compute, in processes of this machine and on
workers of Dask. The rate is that of the items after the first two of each worker, which compile. The overhead is the
time of a worker between the end of one item and the beginning of the next, by its own clock: what else an item takes is
its own, and the processor is not as fast in one minute as in the next. Of items that take no time the overhead is that
of key, driver and store (``store.py``). Writes ``engine_overhead.json`` beside itself.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

from clock import here
from store import measured

import gyroctl as gy
from gyroctl.comparison import cluster, execution
from gyroctl.comparison.execution import Run, execute
from gyroctl.comparison.items import Realisations, perform, work_items
from gyroctl.harness.run import Settings

DEVICE, SETTINGS = gy.zhang2017(), Settings(blend=40.0)

LAWS = '''
"""Laws that take their time: one sleeps, one computes."""

import time
from dataclasses import dataclass
from typing import NamedTuple

SECONDS = {seconds!r}


@dataclass(frozen=True)
class Sleeping:
    period: float = 0.1
    information: str = "none"

    def init(self):
        return None

    def step(self, t, y, state):
        if 490 == round(t / self.period):
            time.sleep(SECONDS)
        return (0.05, 2e-4), None


class Computing(NamedTuple):
    period: float = 0.1
    information = "none"

    def init(self):
        return ()

    def step(self, t, y, state):
        return (0.05, 2e-4), state
'''

SLEEPING, LONG = 50.0, 4000.0
"""Length of the runs that sleep, and of those by which the length of those that compute is found. [s]"""

CLOCK = "ENGINE_OVERHEAD_CLOCK"
"""Variable of the environment: the file where each item notes its process, when it began and when it ended."""


def sent(parcel: Any) -> Any:
    """What a process of this machine is asked for, by the clock."""
    return timed(execution.perform_sent, parcel)


def there(piece: Any) -> Any:
    """What a worker of a cluster is asked for, by the clock."""
    return timed(cluster.run_there, piece)


def timed(perform: Callable[[Any], Any], what: Any) -> Any:
    begin = time.monotonic()
    found = perform(what)
    with open(os.environ[CLOCK], "a", encoding="utf-8") as file:
        file.write(f"{os.getpid()} {begin} {time.monotonic()}\n")
    return found


def items_of(law: Any, duration: float, count: int) -> list[Any]:
    waves = Realisations(gy.SeaState(), tuple(range(20_000, 20_001 + count)), duration)
    return work_items(DEVICE, {"law": law}, waves, SETTINGS, 600.0)[1:]  # the first one keeps its time series


def alone(law: Any, duration: float) -> float:
    """Wall time of an item without the engine, once everything is compiled. [s]"""
    one, *others = items_of(law, duration, 4)
    perform([one])
    begin = time.perf_counter()
    for item in others:
        perform([item])
    return (time.perf_counter() - begin) / len(others)


class Rate(NamedTuple):
    """How fast items are done, after the first two of each worker."""

    each: float  # time in which another one ends [s]
    item: float  # what one takes where it runs [s]
    between: float  # of a worker, from the end of one to the beginning of the next [s]


def rate(law: Any, duration: float, count: int, workers: int, run: Run) -> Rate:
    """Let items be done, and read the clocks of those who did them."""
    stamps, clock = [], Path(os.environ[CLOCK])
    clock.write_text("")

    def noted(items: Any, many: int) -> Iterator[Any]:
        for found in run(items, many):
            stamps.append(time.perf_counter())
            yield found

    with tempfile.TemporaryDirectory() as folder:
        outcomes = execute(items_of(law, duration, count), workers, Path(folder), True, run=noted)  # type: ignore[arg-type]
    failed = [outcome.failure for outcome in outcomes.values() if outcome.failure]
    if failed:
        raise RuntimeError(failed[0])
    of_worker: dict[str, list[tuple[float, float]]] = {}
    for line in clock.read_text().splitlines():
        process, begin, end = line.split()
        of_worker.setdefault(process, []).append((float(begin), float(end)))
    took = [end - begin for times in of_worker.values() for begin, end in times[2:]]
    gaps = [after[0] - before[1] for times in of_worker.values() for before, after in pairwise(times[1:])]
    first = 2 * workers
    each = (stamps[-1] - stamps[first - 1]) / (count - first)
    return Rate(each, sum(took) / len(took), sum(gaps) / len(gaps))


@contextmanager
def where(kind: str, workers: int) -> Iterator[Run]:
    """Processes of this machine, or workers of a cluster on it."""
    if kind == "processes":
        with patch.object(execution, "perform_sent", sent):
            yield execution.run_items
        return
    from distributed import Client, LocalCluster

    given = {"n_workers": workers, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    with LocalCluster(**given) as local, Client(local) as client, patch.object(cluster, "run_there", there):
        yield lambda items, many: cluster.run_far(client, items)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--items", type=int, default=24, help="for each worker")
    parser.add_argument("--seconds", type=float, default=1.0, help="that an item takes")
    parser.add_argument("--only", choices=["processes", "dask"])
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".json"))
    asked = parser.parse_args()
    content: dict[str, Any] = {**here(), "items": asked.items, "nothing": measured(500)}
    with tempfile.TemporaryDirectory() as home:
        file = Path(home) / "laws.py"
        file.write_text(LAWS.format(seconds=asked.seconds), encoding="utf-8")
        os.environ[CLOCK] = str(Path(home) / "clock")
        sleeping, computing = gy.law(f"{file}:Sleeping"), gy.law(f"{file}:Computing")
        length = round(LONG * asked.seconds / alone(computing, LONG), -1)
        kinds = {"sleeping": (sleeping, SLEEPING), "computing": (computing, length)}
        for place in [asked.only] if asked.only else ["processes", "dask"]:
            for name, (law, duration) in kinds.items():
                found = {}
                for workers in (1, 2):
                    with where(place, workers) as run:
                        found[workers] = rate(law, duration, asked.items * workers, workers, run)
                one, two = found[1], found[2]
                row = {"item_s": one.item, "item_beside_another_s": two.item, "times": one.each / two.each}
                row |= {"overhead_ms": 1e3 * one.between, "overhead_of_2_ms": 1e3 * two.between}
                content[f"{name}, {place}"] = row
                print(name, place, json.dumps(row), flush=True)
    asked.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
