"""Cost of the nonlinear MPC on one core: a sample, 2000 s of closed loop, many samples without an unhandled failure.

    python benchmarks/nmpc.py [--runs 10] [--against PATH]

With --against, closed loops of 600 s on one core are timed in turn with those of an older tree of this package, each in
processes of its own, and compiled before: the ratio is of processor time, the least of five rounds.

Writes benchmarks/nmpc.json beside itself. Times are wall times of a shared machine: read them as upper limits.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import gyroctl as gy
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.provenance import made
from gyroctl.simulation.metrics import evaluate
from gyroctl.simulation.progress import Progress

FIRST_SEED = 100000
LIMITS = {"median_ms": 3.0, "p99_ms": 15.0, "closed_loop_s": 90.0}


def one(law: gy.Law, seed: int, duration: float, gamma: float = 5.0) -> dict[str, float]:
    plant, settings = gy.zhang2017(), Settings()
    waves = lead_in(gy.realise(plant, gy.SeaState(gamma=gamma), seed, duration), settings)
    begin = time.perf_counter()
    record, timing = run_law(plant, law, waves, settings)
    spent = time.perf_counter() - begin
    found = evaluate(plant, record, waves.moments[1], waves.dt, 3.14, 100.0, np.nan)
    return {
        "median_ms": timing.median,
        "p99_ms": timing.p99,
        "closed_loop_s": spent,
        "samples": len(record.commands),
        "locked": found["locked"],
        "mean_power_w": found["mean_power"],
        "power_cv": found["power_cv"],
        **timing.counters,
    }


LOOPS = """
import sys, time
import gyroctl as gy
from gyroctl.harness.run import Settings, lead_in, run_law
plant, settings, law = gy.zhang2017(), Settings(), gy.law("nmpc")
told = [lead_in(gy.realise(plant, gy.SeaState(), seed, 600.0), settings) for seed in map(int, sys.argv[1:])]
run_law(plant, law, lead_in(gy.realise(plant, gy.SeaState(), 1, 30.0), settings), settings)
begin = time.process_time()
for waves in told:
    run_law(plant, law, waves, settings)
print((time.process_time() - begin) / len(told))
"""


def loop_seconds(tree: Path) -> float:
    """Processor time of a closed loop of 600 s with the package of a tree. [s]"""
    seeds = [str(FIRST_SEED + 20 + i) for i in range(4)]
    told = [sys.executable, "-c", LOOPS, *seeds]
    found = subprocess.run(told, cwd=tree, env={**os.environ, "PYTHONPATH": str(tree)}, capture_output=True, check=True)
    return float(found.stdout)


def against(tree: Path) -> dict[str, float]:
    """Closed loops of this tree and of an older one, in turn."""
    here = Path(__file__).resolve().parents[1]
    each: dict[Path, list[float]] = {here: [], tree: []}
    for _ in range(5):
        for one_of, spent in each.items():
            spent.append(loop_seconds(one_of))
    now, before = min(each[here]), min(each[tree])
    return {"loop_600_s": now, "loop_600_s_before": before, "times_faster": before / now}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10, help="of 2000 s each, gamma 1, 5 and 50 in turn")
    parser.add_argument("--against", type=Path, help="folder of an older tree to time closed loops against")
    options = parser.parse_args()
    runs = options.runs
    one(gy.law("nmpc"), FIRST_SEED, 150.0)  # compile
    results: dict[str, object] = {**made(), "machine": platform.processor() or platform.machine()}
    results["limits"] = LIMITS
    if options.against:
        results["against"] = against(options.against.resolve())
        print(results["against"])
    for horizon in (4.0, 8.0):
        found = one(gy.law("nmpc", horizon=horizon), FIRST_SEED + 1, 600.0)
        results[f"horizon_{horizon:g}_s"] = found
        print(f"horizon {horizon:g} s: median {found['median_ms']:.2f} ms, p99 {found['p99_ms']:.2f} ms")
    rows = []
    with Progress("runs of 2000 s", runs) as progress:
        for i in range(runs):
            rows.append(one(gy.law("nmpc"), FIRST_SEED + 10 + i, 2000.0, (5.0, 1.0, 50.0)[i % 3]))
            progress.advance()
    samples = int(sum(row["samples"] for row in rows))
    failures = int(sum(row["failed_plans"] for row in rows))
    slowest = max(row["closed_loop_s"] for row in rows)
    results |= {"samples": samples, "failed_plans": failures, "slowest_closed_loop_s": slowest, "runs": rows}
    print(
        f"{samples} samples: {failures} failed plans, none unhandled; 2000 s of closed loop in {slowest:.1f} s at most"
    )
    Path(__file__).with_suffix(".json").write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
