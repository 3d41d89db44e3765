"""What the engine costs beside the runs, and what a second worker is worth.

    python benchmarks/engine_overhead.py                  # some five minutes on two idle cores
    python benchmarks/engine_overhead.py --items 8        # a trial

Items of about ``--seconds`` each, of a law from a file, in processes of this machine and on workers of Dask: some sleep
and some keep their processor busy, both until that time has passed since their run began, however fast the processor
happens to be; and some compute, which tells what a second worker is worth. The rate is that of the items after the
first two of each worker, which compile; the overhead is the time of an item at that rate less that of the same item in
a loop without the engine, before and after. Of items that take no time the overhead is that of key, driver and store
(``store.py``). Writes ``engine_overhead.json`` beside itself.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from clock import here
from store import measured

import gyroctl as gy
from gyroctl.comparison.cluster import run_far
from gyroctl.comparison.execution import Run, execute, run_items
from gyroctl.comparison.items import Realisations, perform, work_items
from gyroctl.harness.run import Settings

DEVICE, SETTINGS = gy.zhang2017(), Settings(blend=40.0)

LAWS = '''
"""Laws that take their time: one sleeps and one is busy until so many seconds have passed, one computes."""

import time
from dataclasses import dataclass
from typing import NamedTuple

SECONDS, LAST = {seconds!r}, {last!r}


@dataclass(frozen=True)
class Sleeping:
    period: float = 0.1
    information: str = "none"

    def init(self):
        return time.monotonic() + SECONDS

    def step(self, t, y, end):
        if round(t / self.period) == LAST:
            time.sleep(max(0.0, end - time.monotonic()))
        return (0.05, 2e-4), end


@dataclass(frozen=True)
class Busy(Sleeping):
    def step(self, t, y, end):
        if round(t / self.period) == LAST:
            while time.monotonic() < end:
                pass
        return (0.05, 2e-4), end


class Computing(NamedTuple):
    period: float = 0.1
    information = "none"

    def init(self):
        return ()

    def step(self, t, y, state):
        return (0.05, 2e-4), state
'''

SHORT, LONG = 50.0, 4000.0
"""Length of the runs that wait, and of those by which the length of those that compute is found. [s]"""

LAST = 498
"""Step at which they wait: the one before the last."""


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


def rate(law: Any, duration: float, count: int, workers: int, run: Run) -> float:
    """Items in a second, after the first two of each worker."""
    stamps = []

    def noted(items: Any, many: int) -> Iterator[Any]:
        for found in run(items, many):
            stamps.append(time.perf_counter())
            yield found

    with tempfile.TemporaryDirectory() as folder:
        outcomes = execute(items_of(law, duration, count), workers, Path(folder), True, run=noted)  # type: ignore[arg-type]
    failed = [outcome.failure for outcome in outcomes.values() if outcome.failure]
    if failed:
        raise RuntimeError(failed[0])
    first = 2 * workers
    return (count - first) / (stamps[-1] - stamps[first - 1])


@contextmanager
def where(kind: str, workers: int) -> Iterator[Run]:
    """Processes of this machine, or workers of a cluster on it."""
    if kind == "processes":
        yield run_items
        return
    from distributed import Client, LocalCluster

    given = {"n_workers": workers, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    with LocalCluster(**given) as cluster, Client(cluster) as client:
        yield lambda items, many: run_far(client, items)


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
        file.write_text(LAWS.format(seconds=asked.seconds, last=LAST), encoding="utf-8")
        laws = {name: gy.law(f"{file}:{name.capitalize()}") for name in ("sleeping", "busy", "computing")}
        length = round(LONG * asked.seconds / alone(laws["computing"], LONG), -1)
        kinds = {name: (law, length if name == "computing" else SHORT) for name, law in laws.items()}
        for place in [asked.only] if asked.only else ["processes", "dask"]:
            for name, (law, duration) in kinds.items():
                before = alone(law, duration)
                rates = {}
                for workers in (1, 2):
                    with where(place, workers) as run:
                        rates[workers] = rate(law, duration, asked.items * workers, workers, run)
                after = alone(law, duration)
                one = 0.5 * (before + after)
                row = {"item_s": one, "rate_of_1": rates[1], "rate_of_2": rates[2], "times": rates[2] / rates[1]}
                if name != "computing":  # the processor is not as fast in one minute as in the next
                    row |= {"overhead_ms": 1e3 * (1.0 / rates[1] - one), "before_to_after_ms": 1e3 * (after - before)}
                    row |= {"overhead_of_2_ms": 1e3 * (2.0 / rates[2] - one)}
                content[f"{name}, {place}"] = row
                print(name, place, json.dumps(row), flush=True)
    asked.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
