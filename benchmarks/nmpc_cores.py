"""Closed loops of the planning law on all cores, as a comparison runs them, and what they are worth.

Run ``python benchmarks/nmpc_cores.py --against OLDER_TREE`` on an idle machine (five minutes on two cores): 64 runs of
600 s in each tree, on the same waves. It prints wall times, their ratio and the paired differences of power and CV with
their intervals, and writes them beside itself as ``nmpc_cores.json``. The seeds are spent.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SEEDS, LENGTH = 64, 600.0
METRICS = ("mean_power", "power_cv", "locked", "turns_kept")


def one() -> dict[str, Any]:
    """Run the comparison, everything compiled before: wall time [s] and metrics by seed."""
    import gyroctl as gy
    from gyroctl.comparison.compare import Realisations, compare

    plant, law = gy.zhang2017(), {"nmpc": gy.law("nmpc")}

    def run(seeds: int, length: float) -> Any:
        waves = Realisations(gy.SeaState(), tuple(range(1, seeds + 1)), length)
        return compare(plant, law, waves, gy.Settings(), quiet=True, tuning_seeds=())

    run(2, 150.0)
    begin = time.perf_counter()
    found = run(SEEDS, LENGTH)
    spent = time.perf_counter() - begin
    return {"wall_s": spent, **{name: found[name].values[0].astype(float).tolist() for name in METRICS}}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="root of an older tree")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.one:
        print(json.dumps(one()))
        return
    from clock import here, in_tree

    from gyroctl.statistics.intervals import student

    this = in_tree(__file__, ROOT)
    content = {**here(), "runs": SEEDS, "length_s": LENGTH, "wall_s": this["wall_s"]}
    content |= {name: float(np.mean(this[name])) for name in METRICS}
    content["simulated_s_per_s"] = SEEDS * LENGTH / this["wall_s"]
    if asked.against:
        older = in_tree(__file__, asked.against.resolve())
        content |= {"older_wall_s": older["wall_s"], "times_as_fast": older["wall_s"] / this["wall_s"]}
        for name in METRICS:
            content[f"older_{name}"] = float(np.mean(older[name]))
            gap = np.array(this[name]) - np.array(older[name])
            content[f"{name}_more"] = [float(gap.mean()), *map(float, student(gap, 0.95))]
    for key, value in content.items():
        print(f"{key:24} {value}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
