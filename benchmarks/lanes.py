"""Lanes as ratios in one run: the ensemble with and without its ledger, closed loops together against alone.

    python benchmarks/lanes.py                    # on one core
    python benchmarks/lanes.py --against TREE     # beside them the ensemble and the loops of an older checkout

It prints a table and writes it beside itself as ``lanes.json``. Times are of the processor, the least of several goes
in turn; errors of the sensors are drawn in the first one and kept, as in a search that tries laws on the same waves.
The ensemble is also told as a share of what the processor could multiply and add at most, which is measured in the same
run; operations are counted by running the text of a step on numbers that remember what made them.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import gyroctl as gy
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.simulation.ensemble import run_ensemble

DURATION, DT, BLEND = 2000.0, 0.01, 100.0
PAIR = (0.052, 3.5e-4)
LAWS = ("load_angle", "coupling")
ALONE, RUNS, LOOPS = 16, 256, 16
GOES = 4
CHAINS, REPEATS = 5, 1_000_000


def spent(work: Callable[[], Any]) -> float:
    """Processor time of a piece of work. [s]"""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def least(works: Sequence[Callable[[], float]], times: int) -> list[float]:
    """Least of the times that each piece of work tells [s], all in turn so that a busy machine is busy for all."""
    return np.min([[work() for work in works] for _ in range(times)], axis=0).tolist()


class Old:
    """The same work in another checkout, in a process of its own."""

    def __init__(self, tree: Path) -> None:
        self.tree = tree

    def __call__(self) -> dict[str, float]:
        """Processor times of the ensemble and of each law's loops, by name. [s]"""
        place = {**os.environ, "PYTHONPATH": str(self.tree.resolve())}
        command = [sys.executable, str(Path(__file__).resolve()), "--tell"]
        return json.loads(subprocess.run(command, env=place, cwd=self.tree, check=True, capture_output=True).stdout)


def ensemble(runs: int, **how: Any) -> float:
    """Time of an ensemble. [s]"""
    plant, sea = gy.zhang2017(), gy.SeaState()
    start, _ = locked_start(plant, sea)
    seeds = range(1, runs + 1)
    return spent(lambda: run_ensemble(plant, sea, [PAIR], seeds, start, DURATION, BLEND, DT, 0.1, 1, quiet=True, **how))


def alone(name: str, waves: Sequence[gy.WaveRealisation]) -> float:
    """Time of closed loops one by one. [s]"""
    plant, law, settings = gy.zhang2017(), gy.law(name), gy.Settings()
    return spent(lambda: [run_law(plant, law, each, settings) for each in waves])


def together(name: str, waves: Sequence[gy.WaveRealisation]) -> float:
    """Time of the same loops in lanes. [s]"""
    from gyroctl.harness.together import Loop, run_together

    law, settings = gy.law(name), gy.Settings()
    loops = [Loop(law, each, settings) for each in waves]
    return spent(lambda: run_together(gy.zhang2017(), loops))


def realisations() -> list[gy.WaveRealisation]:
    """Waves of the closed loops."""
    return [lead_in(gy.realise(gy.zhang2017(), gy.SeaState(), seed, DURATION), gy.Settings()) for seed in range(LOOPS)]


def tell() -> None:
    """Print what `Old` asks for; this part runs in older checkouts too."""
    waves = realisations()
    works = {"ensemble": lambda: ensemble(RUNS), **{name: lambda name=name: alone(name, waves) for name in LAWS}}
    for name in LAWS:
        alone(name, waves[:1])  # compile
    ensemble(ALONE)
    print(json.dumps({name: work() for name, work in works.items()}))


class Traced:
    """A number that remembers the operation it comes from."""

    def __init__(self, *made_of: Any) -> None:
        self.made_of = [one for one in made_of if isinstance(one, Traced)]

    def cos(self) -> Traced:
        """What NumPy calls: the polynomial of the compiled text, which gives the sine as well."""
        from gyroctl.plant.trigonometry import turned

        _, cosine, self.known = turned(self)
        return cosine

    def sin(self) -> Traced:
        """See `cos`."""
        return self.known


for _name in ("add", "sub", "mul", "truediv"):
    setattr(Traced, f"__{_name}__", lambda a, b: Traced(a, b))
    setattr(Traced, f"__r{_name}__", lambda a, b: Traced(a, b))


def operations(ledger: bool) -> int:
    """Operations of a step of one lane that its result needs, and of the interpolation of its moments."""
    from gyroctl.plant import pack_step
    from gyroctl.plant.kernel import rows
    from gyroctl.plant.lagrange import TAPS
    from gyroctl.plant.packs import ROOM

    k, pack_step.room = gy.zhang2017().coefficients, lambda: [None] * ROOM
    y = [Traced() for _ in range(rows(k))]
    begun = set(map(id, y))
    pack_step.step(y, k, Traced(), Traced(), [Traced() for _ in range(6)], 0, DT, ledger or None)
    found: dict[int, Traced] = {}
    left = [one for one in y if id(one) not in begun]
    while left:
        one = left.pop()
        if one.made_of and id(one) not in found:
            found[id(one)] = one
            left += one.made_of
    return len(found) + 2 * 2 * (2 * TAPS - 1)  # two moments at two new instants


def peak() -> float:
    """Operations per second of independent chains of fused multiplications and additions."""
    from llvmlite import ir
    from numba import njit
    from numba.extending import intrinsic

    from gyroctl.plant.compiled import aligned
    from gyroctl.plant.packs import LANES, PACK, VECTOR, packs

    @intrinsic
    def fused(_: Any, a: Any, b: Any, c: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            kind = ir.FunctionType(VECTOR, [VECTOR] * 3)
            return builder.call(builder.module.declare_intrinsic(f"llvm.fma.v{LANES}f64", (), kind), args)

        return PACK(PACK, PACK, PACK), codegen

    @njit(error_model="numpy")
    def chains(room: Any, repeats: int) -> None:
        held = packs(room)
        a, b, c, d, e, factor, term = held[0], held[1], held[2], held[3], held[4], held[5], held[6]
        for _ in range(repeats):
            a, b, c = fused(a, factor, term), fused(b, factor, term), fused(c, factor, term)
            d, e = fused(d, factor, term), fused(e, factor, term)
        held[0], held[1], held[2], held[3], held[4] = a, b, c, d, e

    room = aligned((CHAINS + 2) * LANES)
    room[:] = 0.5
    chains(room, 1)
    (seconds,) = least([lambda: spent(lambda: chains(room, REPEATS))], 10)
    return 2 * LANES * CHAINS * REPEATS / seconds


def main() -> None:
    """Measure and print."""
    from gyroctl.provenance import made

    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--against", type=Path, help="an older checkout")
    asked.add_argument("--tell", action="store_true", help=argparse.SUPPRESS)
    options = asked.parse_args()
    if options.tell:
        tell()
        return
    waves, most = realisations(), peak()
    kinds = {"with ledger": {}, "without ledger": {"ledger": False}}
    works = {}
    for n in (ALONE, RUNS):
        for kind, how in kinds.items():
            works[f"ensemble of {n} runs, {kind}"] = lambda n=n, how=how: ensemble(n, **how)
    works |= {f"{name} alone": lambda name=name: alone(name, waves) for name in LAWS}
    works |= {f"{name} in lanes": lambda name=name: together(name, waves) for name in LAWS}
    for name in LAWS:
        alone(name, waves[:1]), together(name, waves[:4])  # compile
    for how in kinds.values():
        ensemble(1, **how)
    before: dict[str, float] = {}
    if options.against:
        old, goes = Old(options.against), []
        works["older checkout"] = lambda: goes.append(old()) or 0.0
    found = dict(zip(works, least(list(works.values()), GOES), strict=True))
    if options.against:
        before = {name: min(go[name] for go in goes) for name in goes[0]}
    table: dict[str, Any] = {
        **made(),
        "machine": platform.processor() or platform.machine(),
        "most that the processor multiplies and adds [operations / s]": most,
    }
    for kind, how in kinds.items():
        count = operations(not how)
        table[f"operations of a step of one lane, {kind}"] = count
        for n in (ALONE, RUNS):
            rate = DURATION * n / found[f"ensemble of {n} runs, {kind}"]
            table[f"ensemble of {n} runs, waves included, dt .01, {kind} [simulated s / s]"] = rate
        table[f"share of the most, {kind}"] = rate / DT * count / most
        if before:
            table[f"against the older ensemble, {kind}"] = (
                before["ensemble"] / found[f"ensemble of {RUNS} runs, {kind}"]
            )
    for name in LAWS:
        one, lanes = found[f"{name} alone"], found[f"{name} in lanes"]
        table[f"{name}: a run of {DURATION:g} s alone [ms]"] = one / LOOPS * 1e3
        table[f"{name}: in lanes [ms]"] = lanes / LOOPS * 1e3
        table[f"{name}: alone against in lanes"] = one / lanes
        if before:
            table[f"{name}: the older checkout alone against in lanes"] = before[name] / lanes
    for key, value in table.items():
        print(f"{key:80} {value}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
