"""The planning law in real water: what a sample costs on one core, and how quickly closed loops go on two threads.

Run ``python benchmarks/nmpc_water.py`` on an idle machine (two minutes, once everything is compiled); it prints what
it finds and writes it beside itself as ``nmpc_water.json``. The design model has the terms beyond the linear one, the
horizon is 4 s, the set is that for real water, and the law is told of the lag. Waves are made before the clock starts;
what is timed is the loop: sensors, law, actuators, plant. ``--runs`` and ``--length`` make it shorter, to try it out,
and ``--out`` writes elsewhere.
"""

from __future__ import annotations

import argparse
import json
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from clock import here

import gyroctl as gy
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.run import LawTiming, Settings, lead_in, run_law
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.waves import WaveRealisation

PLANT, SEA, LAG = gy.zhang2017("realistic"), gy.SeaState(), 0.02
SETTINGS = Settings(actuators=Actuators(cc_lag=LAG))
LAW: Any = gy.law("nmpc", plant="realistic", lag=LAG)
FIRST_SEED = 100040
"""Among those on which laws are tuned: what is measured here is time."""

THREADS, ALONE = 2, 3
"""Threads of the closed loops side by side, and runs alone by which a sample is timed."""

SHORTEST = SETTINGS.score_from + 20.0
"""Of a run. [s]"""


def waves(runs: int, length: float) -> list[WaveRealisation]:
    """Realisations as a run takes them, blended in from the regular wave."""
    seeds = range(FIRST_SEED, FIRST_SEED + runs)
    return [lead_in(gy.realise(PLANT, SEA, seed, length), SETTINGS) for seed in seeds]


def loop(told: WaveRealisation) -> tuple[Record, LawTiming]:
    """One closed loop."""
    return run_law(PLANT, LAW, told, SETTINGS)


def sample(told: list[WaveRealisation]) -> dict[str, Any]:
    """Time of a sample, one loop after the other on one core: median of the medians, largest of the 99 %. [ms]"""
    timings = [loop(one)[1] for one in told]
    medians, slow = [one.median for one in timings], [one.p99 for one in timings]
    return {"median_ms": float(np.median(medians)), "p99_ms": max(slow), "medians_ms": medians, "p99s_ms": slow}


def side_by_side(told: list[WaveRealisation]) -> dict[str, Any]:
    """All loops on threads: simulated seconds per second of the wall, and what the runs did."""
    with ThreadPoolExecutor(THREADS) as threads:
        begin = time.perf_counter()
        records = [record for record, _ in threads.map(loop, told)]
        spent = time.perf_counter() - begin
    simulated = sum(LAW.period * len(record.commands) for record in records)
    found = [
        evaluate(PLANT, record, one.moments[1], one.dt, SEA.wp, SETTINGS.score_from, np.nan)
        for record, one in zip(records, told, strict=True)
    ]
    return {
        "simulated_s": simulated,
        "wall_s": spent,
        "simulated_s_per_s": simulated / spent,
        "locked": int(sum(one["locked"] for one in found)),
        "mean_power_w": float(np.mean([one["mean_power"] for one in found])),
    }


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=16, help="closed loops side by side")
    parser.add_argument("--length", type=float, default=500.0, help="of each [s]")
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".json"))
    asked = parser.parse_args()
    if asked.runs < 1 or asked.length < SHORTEST:
        parser.error(f"give at least one run, of at least {SHORTEST:g} s")
    loop(waves(1, SHORTEST)[0])  # compile
    told = waves(asked.runs, asked.length)
    content = {**here(), "runs": asked.runs, "length_s": asked.length, "threads": THREADS, "lag_s": LAG}
    content |= {"horizon_s": LAW.horizon, "sample": sample(told[:ALONE]), "loops": side_by_side(told)}
    for name in ("sample", "loops"):
        for key, value in content[name].items():
            print(f"{name:8} {key:20} {value}")
    asked.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
