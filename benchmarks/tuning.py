"""Time of a tuning of `load_angle` at a budget of 3e5 s, on one core.

Run ``python benchmarks/tuning.py --against OLDER_TREE``: it tunes in turn with this tree and with the other one, checks
that both found the same numbers, and writes the ratio beside itself as ``tuning.json``. The task is the one that ships,
for the sea of gamma 5, with 48 tuning seeds instead of 64: with all of them two confirmations are beyond the budget.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
BUDGET, SEEDS, GOES = 3e5, 48, 3


def one() -> dict[str, Any]:
    """Tune once, everything compiled before: processor time [s] and what was found."""
    import gyroctl as gy
    from gyroctl.tuning.task import read_task
    from gyroctl.tuning.tune import tune
    from gyroctl.tuning.waters import Circumstances

    task = read_task("load_angle")
    task = dataclasses.replace(task, seeds=dataclasses.replace(task.seeds, count=SEEDS))
    on = Circumstances(gy.zhang2017())
    short = dataclasses.replace(task, search=dataclasses.replace(task.search, window=150.0, confirm=150.0))
    tune(short, "gamma5", on, 5e4, quiet=True)
    begin = time.process_time()
    entry = tune(task, "gamma5", on, BUDGET, quiet=True).sets["gamma5"]
    spent = time.process_time() - begin
    return {"seconds": spent, "found": [entry["parameters"], entry["result"]]}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, help="root of an older tree")
    parser.add_argument("--one", action="store_true", help="tune once and print the time")
    asked = parser.parse_args()
    if asked.one:
        print(json.dumps(one()))
        return
    from clock import here, in_tree

    trees = {"this": ROOT} | ({"older": asked.against.resolve()} if asked.against else {})
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in trees}
    for _ in range(GOES):
        for name, root in trees.items():
            found[name].append(in_tree(__file__, root))
    content = {**here(), "budget_s": BUDGET, "seeds": SEEDS}
    content |= {f"{name}_s": min(go["seconds"] for go in goes) for name, goes in found.items()}
    if asked.against:
        results = [go["found"] for goes in found.values() for go in goes]
        if any(result != results[0] for result in results):
            raise SystemExit("the two trees found different numbers")
        content["times_as_fast"] = content["older_s"] / content["this_s"]
    for key, value in content.items():
        print(f"{key:20} {value}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
