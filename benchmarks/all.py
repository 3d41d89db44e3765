"""All figures of speed, one part after the other, and how they stand against what is asked for.

Run ``python benchmarks/all.py --against OLDER_TREE`` on an idle machine: an hour on two cores. Each part is a
script beside this one and runs in a process of its own, the older tree with the same script where it is compared;
each writes its JSON, and ``all.json`` holds the figures in one list. ``--only NAME`` runs some parts alone, ``--list``
runs none and lists what the parts have written. The pictures are drawn by ``python docs/write_results.py``.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent


class Part(NamedTuple):
    """A script, and whether it sets an older tree beside this one."""

    against: bool
    more: tuple[str, ...] = ()


PARTS = {
    "integrators": Part(against=False),
    "growth": Part(against=False),
    "lanes": Part(against=True),
    "tuning": Part(against=True),
    "nmpc": Part(against=False, more=("--runs", "4")),
    "nmpc_water": Part(against=False),
    "nmpc_cores": Part(against=True),
    "nmpc_qp": Part(against=False, more=("--seeds", "2", "--duration", "200")),
    "commands": Part(against=True),
    "engine_overhead": Part(against=False),
    "kills": Part(against=False),
    "site": Part(against=False),
    "scale": Part(against=False, more=("--whole",)),
}


class Figure(NamedTuple):
    """A figure: where it stands, and what is asked for."""

    name: str
    part: str
    value: Callable[[Mapping[str, Any]], float]
    bar: float
    least: bool = False  # whether the bar is the least that is asked for; else it is the most
    unit: str = ""


LOOPS = "the older checkout alone against in lanes"


def command(name: str) -> Callable[[Mapping[str, Any]], float]:
    """Wall time of a command. [s]"""
    return lambda found: found["commands"][name]["wall_s"]


def times(kind: str) -> Callable[[Mapping[str, Any]], float]:
    """Rate of two workers over that of one."""
    return lambda found: found[kind]["times"]


def beside(kind: str) -> Callable[[Mapping[str, Any]], float]:
    """Time of an item beside its work. [ms]"""
    return lambda found: found[kind]["overhead_ms"]


def large(name: str) -> Callable[[Mapping[str, Any]], float]:
    """A figure of the whole study, where that is the one that is asked for."""
    return lambda found: {20_000: found["whole"]}[found["whole"]["realisations"]][name]


WORTH, OVER = (1.8, True), (5.0, False, "ms")
"""What a second worker is to be worth; what the engine may take."""

FIGURES = (
    Figure(
        "ensemble with ledger, times the older",
        "lanes",
        lambda f: f["against the older ensemble, with ledger"],
        1.8,
        True,
    ),
    Figure(
        "ensemble without, times the older with it",
        "lanes",
        lambda f: f["against the older ensemble, without ledger"],
        2.4,
        True,
    ),
    Figure("loops of load_angle in lanes, times the older", "lanes", lambda f: f[f"load_angle: {LOOPS}"], 3.0, True),
    Figure("loops of coupling in lanes, times the older", "lanes", lambda f: f[f"coupling: {LOOPS}"], 2.0, True),
    Figure("tuning of load_angle, times the older", "tuning", lambda f: f["times_as_fast"], 2.5, True),
    Figure("a sample of nmpc, horizon 4 s, median", "nmpc", lambda f: f["horizon_4_s"]["median_ms"], 0.35, unit="ms"),
    Figure("a sample of nmpc, horizon 4 s, 99 %", "nmpc", lambda f: f["horizon_4_s"]["p99_ms"], 1.5, unit="ms"),
    Figure("a sample of nmpc in real water, median", "nmpc_water", lambda f: f["sample"]["median_ms"], 0.6, unit="ms"),
    Figure("a sample of nmpc in real water, 99 %", "nmpc_water", lambda f: f["sample"]["p99_ms"], 3.0, unit="ms"),
    Figure(
        "16 loops of nmpc in real water on two threads, simulated s / s",
        "nmpc_water",
        lambda f: f["loops"]["simulated_s_per_s"],
        150.0,
        True,
    ),
    Figure("64 loops of nmpc on all cores, times the older", "nmpc_cores", lambda f: f["times_as_fast"], 2.5, True),
    Figure("first gyroctl compare", "commands", command("compare, cold"), 75.0, unit="s"),
    Figure("first gyroctl simulate --law load_angle, 300 s", "commands", command("simulate, cold"), 8.0, unit="s"),
    Figure("what the planner needs compiled, one core", "commands", command("planner, cold"), 20.0, unit="s"),
    Figure("gyroctl margins --law load_angle", "commands", command("margins"), 45.0, unit="s"),
    Figure("gyroctl lockmap", "commands", command("lockmap"), 15.0, unit="s"),
    Figure("gyroctl reproduce all", "commands", command("reproduce"), 100.0, unit="s"),
    Figure("gyroctl bound --seeds 1", "commands", command("bound"), 45.0, unit="s"),
    Figure(
        "2 processes, times the rate of 1, items that compute", "engine_overhead", times("computing, processes"), *WORTH
    ),
    Figure(
        "2 processes, times the rate of 1, items that sleep", "engine_overhead", times("sleeping, processes"), *WORTH
    ),
    Figure(
        "2 workers of Dask, times the rate of 1, items that compute",
        "engine_overhead",
        times("computing, dask"),
        *WORTH,
    ),
    Figure(
        "2 workers of Dask, times the rate of 1, items that sleep", "engine_overhead", times("sleeping, dask"), *WORTH
    ),
    Figure(
        "key and store of an item",
        "engine_overhead",
        lambda f: f["nothing"]["key_ms"] + f["nothing"]["stored_ms"],
        *OVER,
    ),
    Figure("engine beside an item of 1 s that sleeps", "engine_overhead", beside("sleeping, processes"), *OVER),
    Figure("engine beside an item of 1 s that computes", "engine_overhead", beside("computing, processes"), *OVER),
    Figure("engine beside an item of 1 s that sleeps, Dask", "engine_overhead", beside("sleeping, dask"), *OVER),
    Figure("engine beside an item of 1 s that computes, Dask", "engine_overhead", beside("computing, dask"), *OVER),
    Figure("gyroctl site, 40 sea states", "site", lambda f: f["first"]["wall_s"], 600.0, unit="s"),
    Figure("lost, twice or otherwise after kills, cluster", "kills", lambda f: f["scheduler"]["wrong"], 0.0),
    Figure("lost, twice or otherwise after kills, alone", "kills", lambda f: f["alone"]["wrong"], 0.0),
    Figure("20 000 realisations, 3 laws, 600 s", "scale", large("wall_s"), 1200.0, unit="s"),
    Figure("memory of its driver", "scale", large("driver_mb"), 1000.0, unit="MB"),
)


def listed() -> list[dict[str, Any]]:
    """Every figure that is asked for; its value is None where its part has not written it."""
    found = []
    for figure in FIGURES:
        path = HERE / f"{figure.part}.json"
        content = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
        value: float | None
        try:
            value = float(figure.value(content))
        except KeyError:  # its part was not run, or without an older tree
            value = None
        met = value is not None and (value >= figure.bar if figure.least else value <= figure.bar)
        row = {"figure": figure.name, "value": value, "unit": figure.unit, "bar": figure.bar}
        found.append({**row, "asked": "at least" if figure.least else "at most", "met": met, "part": figure.part})
    return found


def main() -> None:
    """Run the parts, print and write the list."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, help="root of an older tree")
    parser.add_argument("--only", action="append", choices=list(PARTS), help="a part; repeatable")
    parser.add_argument("--list", action="store_true", help="run nothing")
    asked = parser.parse_args()
    for name in () if asked.list else asked.only or PARTS:
        part = PARTS[name]
        command = [sys.executable, str(HERE / f"{name}.py"), *part.more]
        if asked.against and part.against:
            command += ["--against", str(asked.against.resolve())]
        print(f"\n{' '.join(command[1:]).replace(str(ROOT), '.')}\n", flush=True)
        subprocess.run(command, cwd=ROOT, check=True)
    from clock import here

    rows = listed()
    print()
    for row in rows:
        mark = "not measured" if row["value"] is None else "met" if row["met"] else "NOT MET"
        value = "" if row["value"] is None else f"{row['value']:.4g}"
        print(f"{row['figure']:64} {value:>9} {row['unit']:3} {row['asked']} {row['bar']:g}: {mark}")
    content = {**here(), "figures": rows}
    (HERE / "all.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
