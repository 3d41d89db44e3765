"""What a study of many realisations costs: one in full, and the parts of which a larger one is made.

    python benchmarks/scale.py                       # the parts, a minute on an idle core
    python benchmarks/scale.py --whole               # and 20 000 realisations, 3 compiled laws, 600 s, in one command
    python benchmarks/scale.py --whole --realisations 500

Parts are processor time of one core for each run and law, but for the time that the disk takes to sync a record. From
them follows what a million realisations cost: the runs are shared out among the cores, what the process that was
started does for each run is not. Writes ``scale.json`` beside itself; the whole study is kept of an earlier call where
none is asked for.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from clock import here, watched
from growth import made_up

import gyroctl as gy
from gyroctl.comparison import compare, execution
from gyroctl.comparison.items import Item, Outcome, Realisations, perform, work_items
from gyroctl.engine import Store
from gyroctl.engine.store import stored
from gyroctl.harness.run import Settings
from gyroctl.reports.evaluation import evaluate
from gyroctl.reports.report import render
from gyroctl.reports.summary import summarise

ROOT = Path(__file__).resolve().parents[1]
DEVICE, SETTINGS, DURATION = gy.zhang2017(), Settings(blend=40.0), 600.0
LAWS = ("coupling", "load_angle", "best_constant")
LANES = 16
REALISATIONS, CORES = 1_000_000, (2, 64, 1000)
"""Of the study on paper."""

FEW, MANY = 200, 1000
"""Realisations from whose difference follows what one more costs."""


def spent(work: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of all threads, and what came out."""
    begin = time.process_time()
    found = work()
    return time.process_time() - begin, found


def parts() -> dict[str, float]:
    """What a run of one law costs, part by part."""
    found = {}
    laws = {name: gy.law(name) for name in LAWS}
    waves = Realisations(gy.SeaState(), tuple(range(1, FEW + 1)), DURATION)
    work_items(DEVICE, laws, replace(waves, seeds=(1, 2)), SETTINGS, 60.0)  # what is done once
    taken, items = spent(lambda: work_items(DEVICE, laws, waves, SETTINGS, 60.0))
    found["key_ms"] = 1e3 * taken / len(items)
    tracemalloc.start()
    again = work_items(DEVICE, laws, waves, SETTINGS, 60.0)
    found["asked_kb"] = tracemalloc.get_traced_memory()[0] / len(again) / 1e3
    tracemalloc.stop()
    of_law = {name: [item for item in items if item.name == name and not item.example][:LANES] for name in LAWS}
    for own in of_law.values():
        perform(own)  # compile
    taken, outcomes = spent(lambda: [outcome for own in of_law.values() for outcome in perform(own)])
    found["run_ms"] = 1e3 * taken / len(outcomes)
    found |= stored_and_found(items, outcomes[0])
    found |= driven(items, outcomes[0])
    found |= told(outcomes[0])
    found["libraries_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    found["piece_mb"] = most_mb(2000.0, LANES)
    found["long_run_mb"] = most_mb(1e5, 1)
    return found


def most_mb(duration: float, many: int) -> float:
    """Most memory that runs of one piece take at a time."""
    waves = Realisations(gy.SeaState(), tuple(range(1, many + 1)), duration)
    items = work_items(DEVICE, {LAWS[0]: gy.law(LAWS[0])}, waves, SETTINGS, 600.0)
    tracemalloc.start()
    perform(items)
    most = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return most


def stored_and_found(items: Sequence[Item], outcome: Outcome) -> dict[str, float]:
    """A record, written and read."""
    content = {"sha256": outcome.sha256, "values": dict(outcome.values)}
    with tempfile.TemporaryDirectory() as folder:
        store, begin = Store(Path(folder)), time.perf_counter()
        taken, _ = spent(lambda: [store.save(item.key, content, {}, {"case": ""}) for item in items])
        wall = time.perf_counter() - begin
        size = sum(path.stat().st_size for path in stored(Path(folder)))
        read, _ = spent(lambda: [store.load(item.key) for item in items])
    many = len(items)
    return {
        "stored_ms": 1e3 * taken / many,
        "synced_wall_ms": 1e3 * wall / many,
        "found_ms": 1e3 * read / many,
        "record_kb": size / many / 1e3,
    }


def driven(items: Sequence[Item], outcome: Outcome) -> dict[str, float]:
    """What the driver does and holds beside that."""

    def nothing(some: Sequence[Item]) -> list[Outcome]:
        return [replace(outcome, sha256=item.sha256, values=dict(outcome.values)) for item in some]

    plain, execution.perform = execution.perform, nothing
    try:
        taken, _ = spent(lambda: execution.execute(items, 2, None, True))
        tracemalloc.start()
        outcomes = execution.execute(items, 2, None, True)
        held = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
    finally:
        execution.perform = plain
    return {"handed_out_ms": 1e3 * taken / len(items), "held_kb": held / len(outcomes) / 1e3}


def told(outcome: Outcome) -> dict[str, float]:
    """Table of results, statistics, report and summary: what one more realisation costs for each law."""
    laws = {name: gy.law(name) for name in LAWS}

    def table(many: int) -> Any:
        waves = Realisations(gy.SeaState(), tuple(range(1, many + 1)), DURATION)
        return compare._dataset(laws, waves, {name: [outcome] * many for name in LAWS})

    def page(many: int) -> int:
        ds = made_up(len(LAWS), many)
        found = evaluate(ds)
        return len(render(ds, found)) + len(json.dumps(summarise(ds, found)))

    table(LANES), page(LANES)  # load the libraries
    times, sizes = [], []
    for many in (FEW, MANY):
        taken, _ = spent(lambda many=many: table(many))
        more, size = spent(lambda many=many: page(many))
        times.append(taken + more)
        sizes.append(size)
    runs = len(LAWS) * (MANY - FEW)
    return {"told_ms": 1e3 * (times[1] - times[0]) / runs, "told_kb": (sizes[1] - sizes[0]) / runs / 1e3}


def on_paper(one: dict[str, float]) -> list[dict[str, float]]:
    """A study of `REALISATIONS` by the number of cores: the runs shared out, the driver by itself."""
    runs = REALISATIONS * len(LAWS)
    driver = one["key_ms"] + one["stored_ms"] + one["handed_out_ms"] + one["told_ms"]
    rows = []
    for cores in CORES:
        shared, alone = runs * one["run_ms"] / 1e3 / cores, runs * driver / 1e3
        disk = runs * one["synced_wall_ms"] / 1e3 / 4  # threads that write
        # on a few cores the driver takes its part of them; on many it has one of its own
        wall = (shared + alone / cores) if cores <= (os.cpu_count() or 1) else max(shared, alone, disk)
        row = {"cores": cores, "runs_h": shared / 3600.0, "driver_h": alone / 3600.0, "disk_h": disk / 3600.0}
        row |= {"wall_h": max(wall, disk) / 3600.0, "core_h": runs * (one["run_ms"] + driver) / 3.6e6}
        row |= {
            "driver_gb": runs * (one["held_kb"] + one["asked_kb"]) / 1e6,
            "stored_gb": runs * one["record_kb"] / 1e6,
        }
        rows.append(row)
    return rows


def whole(realisations: int) -> dict[str, Any]:
    """One command: its time, and the most memory that its process took; the best constant pair is there unasked."""
    with tempfile.TemporaryDirectory() as home:
        place = Path(home)
        seeds = ", ".join(str(seed) for seed in range(10_000, 10_000 + realisations))
        text = f"[run]\nduration = {DURATION}\nblend = {SETTINGS.blend}\nseeds = [{seeds}]\n"
        (place / "study.toml").write_text(text + "".join(f"[laws.{name}]\n" for name in LAWS[:2]))
        words = ["compare", "study.toml", "--out", "out", "--no-search"]
        used = watched("gyroctl", words, place, ROOT)
        out = place / "out"
        sizes = {name: (out / name).stat().st_size / 1e6 for name in ("results.nc", "report.html", "summary.json")}
        records = stored(out / "runs")
        table = {"realisations": realisations, "laws": len(LAWS), "duration_s": DURATION, "wall_s": round(used.wall, 1)}
        table |= {"processor_s": round(used.processor, 1), "driver_mb": round(used.memory, 1)}
        table |= {f"{name}_mb": round(size, 2) for name, size in sizes.items()}
        return {**table, "records": len(records), "records_mb": round(sum(p.stat().st_size for p in records) / 1e6, 1)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--whole", action="store_true", help="run a study in full")
    parser.add_argument("--realisations", type=int, default=20_000, help="of that study")
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".json"))
    asked = parser.parse_args()
    known = json.loads(asked.out.read_text(encoding="utf-8")) if asked.out.is_file() else {}
    one = parts()
    content = {**here(), "realisations": REALISATIONS, "laws": len(LAWS), "duration_s": DURATION, "parts": one}
    content["on_paper"] = on_paper(one)
    if "whole" in known:
        content["whole"] = known["whole"]
    print(json.dumps(content, indent=1), flush=True)
    if asked.whole:
        content["whole"] = {**here(), **whole(asked.realisations)}
        print(json.dumps(content["whole"], indent=1))
    asked.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
