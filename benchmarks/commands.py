"""Wall and processor seconds of the commands that a user waits for, each in a process of its own.

    python benchmarks/commands.py                          # this tree, about a quarter of an hour on two idle cores
    python benchmarks/commands.py --against ../old         # and another one beside it, in turn
    python benchmarks/commands.py --only simulate --only import --times 3

A cold command begins with empty caches, a warm one with those that the same command has filled before it is timed.
Processor seconds are those of the process and of all its children. Writes ``commands.json`` beside itself: of each
command the least of its goes, and the bar that it is to stay below on two idle cores. A tree is a checkout; the
commands run with this Python and its libraries.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from gyroctl.provenance import made

ROOT = Path(__file__).resolve().parents[1]


class Command(NamedTuple):
    """A command, and what is asked of it."""

    arguments: tuple[str, ...]
    limit: float | None  # wall time on two idle cores [s]
    cold: bool = False


GYROCTL = ("-m", "gyroctl")
SIMULATE = (*GYROCTL, "simulate", "--law", "load_angle", "--duration", "300", "--out", "run.nc")
PLANNER = "import gyroctl as gy; [part() for part in gy.law('nmpc').preparations()]"
COMMANDS = {
    "import": Command(("-c", "import gyroctl.cli.app"), None),
    "help": Command((*GYROCTL, "--help"), None),
    "simulate": Command(SIMULATE, None),
    "simulate, cold": Command(SIMULATE, 8.0, True),
    "compare, cold": Command((*GYROCTL, "compare", "--out", "compare"), 75.0, True),
    "planner, cold": Command(("-c", PLANNER), 20.0, True),
    "margins": Command((*GYROCTL, "margins", "--law", "load_angle", "--out", "margins"), 45.0),
    "lockmap": Command((*GYROCTL, "lockmap", "--out", "lockmap"), 15.0),
    "reproduce": Command((*GYROCTL, "reproduce", "all", "--out", "paper"), 100.0),
    "bound": Command((*GYROCTL, "bound", "--seeds", "1", "--out", "bound"), 45.0),
}


class Spent(NamedTuple):
    """What a command took."""

    wall_s: float
    processor_s: float


def run(tree: Path, command: Command, caches: Path, out: Path) -> Spent:
    """Run a command of a tree in the folder `out`, with all that is kept between runs under `caches`."""
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    environment |= {"GYROCTL_CACHE": str(caches / "own"), "NUMBA_CACHE_DIR": str(caches / "numba")}
    for folder in (caches / "own", caches / "numba", out):
        folder.mkdir(parents=True, exist_ok=True)
    before, begin = _children(), time.perf_counter()
    done = subprocess.run(
        [sys.executable, *command.arguments], env=environment, cwd=out, capture_output=True, text=True, check=False
    )
    spent = Spent(time.perf_counter() - begin, _children() - before)
    if done.returncode != 0:
        raise RuntimeError(
            f"{' '.join(command.arguments)} in {tree} ended with {done.returncode}: {done.stderr[-500:]}"
        )
    return spent


def _children() -> float:
    """Processor time of all processes that have ended, and of theirs. [s]"""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measured(trees: Sequence[Path], names: Sequence[str], times: int) -> dict[str, dict[str, list[Spent]]]:
    """Run each command `times` times in each tree, the trees in turn."""
    found: dict[str, dict[str, list[Spent]]] = {}
    for name in names:
        command = COMMANDS[name]
        found[name] = {str(tree): [] for tree in trees}
        with tempfile.TemporaryDirectory() as home:
            for go in range(times if command.cold else times + 1):  # a warm one goes once before it counts
                for place, tree in enumerate(trees):
                    caches = Path(home) / (f"caches {place} {go}" if command.cold else f"caches {place}")
                    spent = run(tree, command, caches, Path(home) / f"out {place} {go}")
                    if command.cold or go > 0:
                        found[name][str(tree)].append(spent)
        for tree in trees:
            best = least(found[name][str(tree)])
            print(
                f"{name:15s} {tree.name:12s} {best.wall_s:7.1f} s wall {best.processor_s:7.1f} s processor", flush=True
            )
    return found


def least(spent: Sequence[Spent]) -> Spent:
    """Least of several goes, each time by itself."""
    return Spent(min(one.wall_s for one in spent), min(one.processor_s for one in spent))


def table(found: dict[str, dict[str, list[Spent]]], here: Path, against: Path | None) -> dict[str, Any]:
    """What is written down of each command."""
    rows: dict[str, Any] = {}
    for name, of in found.items():
        best, command = least(of[str(here)]), COMMANDS[name]
        row: dict[str, Any] = {"command": " ".join(command.arguments), "cold": command.cold, "limit_s": command.limit}
        row |= {"wall_s": round(best.wall_s, 2), "processor_s": round(best.processor_s, 2)}
        if command.limit is not None:
            row["within"] = best.wall_s <= command.limit
        if against is not None:
            old = least(of[str(against)])
            row["before"] = {"wall_s": round(old.wall_s, 2), "processor_s": round(old.processor_s, 2)}
            row["processor_ratio"] = round(old.processor_s / best.processor_s, 2)
        rows[name] = row
    return rows


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="another checkout")
    parser.add_argument("--only", action="append", choices=COMMANDS, help="may repeat")
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".json"))
    asked = parser.parse_args()
    against = asked.against.resolve() if asked.against else None
    trees = [ROOT] if against is None else [against, ROOT]
    head = {**made(), "machine": platform.processor() or platform.machine(), "cores": os.cpu_count()}
    head["load_before"] = os.getloadavg()[0]
    found = measured(trees, asked.only or list(COMMANDS), asked.times)
    asked.out.write_text(json.dumps({**head, "commands": table(found, ROOT, against)}, indent=1) + "\n")


if __name__ == "__main__":
    main()
