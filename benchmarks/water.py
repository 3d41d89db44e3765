"""What the choices beyond the linear model cost: each relative to the linear plant, in one process.

Run ``python -P benchmarks/water.py`` (without -P the file ``coverage.py`` beside it is taken for the package); it
prints a table and writes it beside itself as ``water.json``. With ``--linear`` only the linear plant is timed and
nothing is written: the same file serves a checkout without the choices, to compare.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gyroctl as gy
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.provenance import made
from gyroctl.simulation.ensemble import run_ensemble

LAW, DURATION, SEED = "load_angle", 600.0, 1
CHOICES: dict[str, tuple[dict[str, Any], float | None]] = {
    "position": ({"position": "moving"}, 1.5),
    "drag": ({"drag": 0.5}, 1.5),
    "position and drag": ({"position": "moving", "drag": 0.5}, 1.5),
    "coupling curve, cap and losses": (
        {"coupling_cap": 2.0, "coupling_slip": 20.0, "bearing": 0.01, "windage": 9.1e-7, "rolling_resistance": 1e-5},
        None,
    ),
    "reduced": ({"wetted": "reduced"}, 3.0),
    "reduced, position and drag": ({"wetted": "reduced", "position": "moving", "drag": 0.5}, 3.0),
    "surface": ({"wetted": "surface"}, 150.0),
    "friction": ({"contact": "friction"}, 30.0),
    "realistic": ({"variant": "realistic"}, 200.0),
}
"""Choices and how often the time of the linear plant each may take; None where there is no bar."""

SIDE_BY_SIDE = ("position", "drag", "position and drag", "coupling curve, cap and losses", "reduced, position and drag")
"""Choices that are timed in an ensemble too."""

SECONDS = 3.0
"""Longest time of a run of the realistic plant. [s]"""


def best(work: Callable[[], Any], times: int) -> float:
    """Least processor time of several goes [s]: the machine is shared, a wall clock would time the neighbours."""
    spent = []
    for _ in range(times):
        begin = time.process_time()
        work()
        spent.append(time.process_time() - begin)
    return min(spent)


def ensemble(plant: gy.Plant) -> float:
    """Time of a run of an ensemble: 64 realisations, one pair, one thread. [s]"""
    sea = gy.SeaState()
    start, pair = locked_start(gy.zhang2017(), sea)

    def work() -> object:
        return run_ensemble(plant, sea, [pair], range(1, 65), start, DURATION, 100.0, 0.01, workers=1, quiet=True)

    work()  # compile
    return best(work, 5) / 64


def linear() -> dict[str, float]:
    """Time of a single run with a law and of an ensemble's, linear plant. [s]"""
    plant, sea, settings = gy.zhang2017(), gy.SeaState(), gy.Settings()
    waves = lead_in(gy.realise(plant, sea, SEED, DURATION), settings)
    run_law(plant, gy.law(LAW), waves, settings)  # compile
    return {
        "linear, one run [s]": best(lambda: run_law(plant, gy.law(LAW), waves, settings), 40),
        "linear, ensemble, a run [s]": ensemble(plant),
    }


def cost(choices: dict[str, Any]) -> tuple[float, float, float]:
    """Time of a run, the same over that of the linear plant, and time of what is made of its waves before. [s, -, s]

    Both plants run in turn, for the machine is not as quick at all times.
    """
    settings, works, signals = gy.Settings(), [], 0.0
    for plant in (gy.zhang2017(), gy.zhang2017(**choices)):
        short = lead_in(gy.realise(plant, gy.SeaState(), SEED, 120.0), settings)
        run_law(plant, gy.law(LAW), short, settings)  # compile
        waves = lead_in(gy.realise(plant, gy.SeaState(), SEED, DURATION), settings)
        signals = best(lambda plant=plant, waves=waves: waves.signals(plant), 1)
        works.append(lambda plant=plant, waves=waves: run_law(plant, gy.law(LAW), waves, settings))
    times = 3 if "variant" in choices else 15
    base, spent = zip(*((best(works[0], 3), best(works[1], 1)) for _ in range(times)), strict=True)
    return min(spent), min(spent) / min(base), signals


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--linear", action="store_true", help="time the linear plant alone")
    only = parser.parse_args().linear
    base = linear()
    table: dict[str, Any] = {} if only else {**made()}
    table |= {"machine": f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores", **base}
    for name, value in base.items():
        print(f"{name:34} {value:.5f}", flush=True)
    for name, (choices, bar) in {} if only else CHOICES.items():
        spent, ratio, signals = cost(choices)
        table[name] = {"a run [s]": spent, "relative to linear": ratio, "bar": bar, "signals of the waves [s]": signals}
        told = f"{name:34} {ratio:7.2f}{'' if bar is None else f' of {bar:g}'}, {spent:.3f} s, signals {signals:.3f} s"
        if name in SIDE_BY_SIDE:
            beside = ensemble(gy.zhang2017(**choices)) / base["linear, ensemble, a run [s]"]
            table[name]["ensemble, relative to linear"] = beside
            told += f", ensemble {beside:.2f}"
        print(told, flush=True)
    if not only:
        within = table["realistic"]["a run [s]"] <= SECONDS
        over = [name for name, (_, bar) in CHOICES.items() if bar and table[name]["relative to linear"] > bar]
        print("Above their bar: " + (", ".join(over) or "none"), "" if within else f"; realistic above {SECONDS:g} s")
        Path(__file__).with_suffix(".json").write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
