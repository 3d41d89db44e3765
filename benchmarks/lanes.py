"""Lanes as ratios in one run: the ensemble in simulated seconds per second, closed loops together against alone.

Run ``python benchmarks/lanes.py``, on one core; it prints a table and writes it beside itself as ``lanes.json``. Times
are of the processor, the least of several goes in turn.
"""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gyroctl as gy
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.harness.together import run_together
from gyroctl.plant.kernel import LANES
from gyroctl.provenance import made
from gyroctl.simulation.ensemble import run_ensemble

DURATION = 2000.0
PAIR = (0.052, 3.5e-4)
LAWS = ("load_angle", "coupling")


def least(works: Sequence[Callable[[], Any]], times: int) -> list[float]:
    """Least processor time of each piece of work [s], all of them in turn so that a busy machine is busy for all."""
    spent: list[list[float]] = [[] for _ in works]
    for _ in range(times):
        for work, seconds in zip(works, spent, strict=True):
            begin = time.process_time()
            work()
            seconds.append(time.process_time() - begin)
    return [min(seconds) for seconds in spent]


def main() -> None:
    """Measure and print."""
    plant, sea, settings = gy.zhang2017(), gy.SeaState(), gy.Settings()
    start, _ = locked_start(plant, sea)
    waves = [lead_in(gy.realise(plant, sea, seed, DURATION), settings) for seed in range(1, LANES + 1)]

    def ensemble(runs: int) -> None:
        run_ensemble(plant, sea, [PAIR], range(1, runs + 1), start, DURATION, dt=0.01, workers=1, quiet=True)

    ensemble(LANES)  # compile
    few, many = least([lambda: ensemble(LANES), lambda: ensemble(16 * LANES)], 3)
    table: dict[str, Any] = {
        **made(),
        "machine": platform.processor() or platform.machine(),
        f"ensemble of {LANES} runs, waves and ledger, dt .01 [simulated s / s]": DURATION * LANES / few,
        f"ensemble of {16 * LANES} runs, waves and ledger, dt .01 [simulated s / s]": DURATION * 16 * LANES / many,
    }
    for name in LAWS:
        law = gy.law(name)
        run_together(plant, law, waves[:2], settings), run_law(plant, law, waves[0], settings)  # compile

        def alone(law: gy.Law = law) -> None:
            for each in waves:
                run_law(plant, law, each, settings)

        def together(law: gy.Law = law) -> None:
            run_together(plant, law, waves, settings)

        one, lanes = least([alone, together], 3)
        table[f"{name}: a run of {DURATION:g} s alone [ms]"] = one / LANES * 1e3
        table[f"{name}: in lanes [ms]"] = lanes / LANES * 1e3
        table[f"{name}: alone against in lanes"] = one / lanes
    for key, value in table.items():
        print(f"{key:72} {value}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
