"""What keeping finished runs costs: time an item beside its run, when it is stored and when it is found again.

    python benchmarks/store.py

The runs themselves are left out: what is timed is the key, the store and the driver. [ms]
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.comparison.items import Item, Outcome, Realisations, work_items
from gyroctl.harness.run import Settings


def measured(many: int) -> dict[str, float]:
    """Time an item. [ms]"""
    plant, settings = gy.zhang2017(), Settings(blend=40.0)
    waves = Realisations(gy.SeaState(), tuple(range(1, many + 1)), duration=120.0)
    laws = {"load_angle": gy.law("load_angle")}
    work_items(plant, laws, replace(waves, seeds=(1,)), settings, 60.0)
    perform = execution.perform
    done = perform(work_items(plant, laws, replace(waves, seeds=(2,)), settings, 60.0))[0]

    def nothing(items: Sequence[Item]) -> list[Outcome]:
        return [replace(done, sha256=item.sha256) for item in items]

    execution.perform = nothing
    found = {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            items = work_items(plant, laws, waves, settings, 60.0)
            found["key_ms"] = time.perf_counter() - begin
            for name, place in (("without_store_ms", None), ("stored_ms", Path(folder)), ("found_ms", Path(folder))):
                begin = time.perf_counter()
                execution.execute(items, 2, place, True)
                found[name] = time.perf_counter() - begin
    finally:
        execution.perform = perform
    return {"items": len(items), **{name: 1e3 * t / len(items) for name, t in found.items()}}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--items", type=int, default=500)
    print(json.dumps(measured(parser.parse_args().items), indent=1))


if __name__ == "__main__":
    main()
