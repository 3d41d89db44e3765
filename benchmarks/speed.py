"""Speed as ratios in one run: the compiled kernels against SciPy's DOP853 on the same plant and waves.

Run ``python benchmarks/speed.py``; it prints a table and writes it beside itself as ``speed.json``.
"""

from __future__ import annotations

import json
import os
import resource
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from clock import here, least
from integrators import CC, CG, numpy_rhs
from scipy.integrate import solve_ivp

import gyroctl as gy
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.loop import compiled_calls
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.plant.kernel import hold_into, rows
from gyroctl.plant.lagrange import TAPS
from gyroctl.simulation.ensemble import run_ensemble

DURATION = 2000.0
SLICE = 40.0  # of the DOP853 run; its cost per simulated second is even
CHECK = 200.0  # length over which accuracy is compared


def best(work: Callable[[], Any], times: int) -> float:
    """Least processor time of several goes. [s]"""
    return least([work], times)[0]


def main() -> None:
    """Measure and print."""
    plant, sea = gy.zhang2017(), gy.SeaState()
    settings = gy.Settings()
    waves = lead_in(gy.realise(plant, sea, 1, DURATION), settings)
    start, _ = locked_start(plant, sea)
    k, n = plant.coefficients, len(plant.labels)
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    rhs = numpy_rhs()

    def single(duration: float, dt: float) -> np.ndarray:
        y = np.zeros(rows(k))
        y[:n] = start
        controls = np.array([[CC], [CG]])
        hold_into(
            y,
            np.empty((5, y.size)),
            np.empty(6),
            np.empty(TAPS),
            k,
            controls,
            0.0,
            duration,
            round(duration / dt),
            flat,
            waves.dt,
        )
        return y[:n]

    def ensemble(seeds: int, dt: float, workers: int) -> Any:
        return run_ensemble(
            plant, sea, [(CC, CG)], range(1, seeds + 1), start, DURATION, 100.0, dt, workers=workers, quiet=True
        )

    single(1.0, 0.01), ensemble(16, 0.05, 1)  # compile

    # accuracy after 200 s in lock, relative to the size of each state
    def scipy(rtol: float, atol: float, longest: float) -> np.ndarray:
        return solve_ivp(rhs, (0.0, CHECK), start, "DOP853", rtol=rtol, atol=atol, max_step=longest).y[:, -1]

    tight, loose = scipy(1e-11, 1e-12, 0.05), scipy(1e-6, 1e-6, np.inf)
    size = np.maximum(np.abs(tight), 1e-2)
    error = {"dop853": float(np.max(np.abs(loose - tight) / size))}
    for dt in (0.01, 0.0125, 0.02, 0.025):
        error[f"rk4 {dt}"] = float(np.max(np.abs(single(CHECK, dt) - tight) / size))

    reference = best(lambda: solve_ivp(rhs, (0.0, SLICE), start, "DOP853", rtol=1e-6, atol=1e-6), 3) / SLICE * DURATION
    alone = best(lambda: single(DURATION, 0.01), 5)
    lanes = {dt: best(lambda dt=dt: ensemble(64, dt, 1), 3) / 64 for dt in (0.01, 0.025)}
    begin = time.perf_counter()
    ensemble(1000, 0.01, os.cpu_count() or 1)
    many = time.perf_counter() - begin
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6

    # a compiled law's own cost per sample, against that of the loop with constant controls. (Inside the loop a law that
    # switches the coupling also asks for finer steps after each switch: that is the plant's cost, told apart.)
    samples = round(DURATION / 0.1)

    def loop(law: gy.Law) -> float:
        return best(lambda: run_law(plant, law, waves, settings), 5) / samples

    def call(law: gy.Law) -> float:
        machine = compile_law(law)
        assert machine is not None
        y = np.array([0.5, 3.1, 70.0, 0.1, 0.1, 0.2, 0.2])
        compiled_calls(machine.entry, machine.p, machine.s.copy(), y, np.zeros(2), 1)
        return (
            best(lambda: compiled_calls(machine.entry, machine.p, machine.s.copy(), y, np.zeros(2), 100_000), 5)
            / 100_000
        )

    constant = loop(gy.law("constant", cc=CC, cg=CG))
    overhead = {name: call(gy.law(name)) / constant for name in ("constant", "load_angle", "coupling")}
    whole = {name: loop(gy.law(name)) / constant for name in ("load_angle", "coupling")}

    table = {
        **here(),
        "DOP853 rtol 1e-6, NumPy, one run of 2000 s [s]": reference,
        "single run, dt .01 [s]": alone,
        "single run against DOP853": reference / alone,
        "ensemble per run and core, dt .01, waves included [s]": lanes[0.01],
        "ensemble against DOP853 per core, dt .01": reference / lanes[0.01],
        "ensemble against DOP853 per core, dt .025": reference / lanes[0.025],
        "simulated seconds per second and core, dt .01": DURATION / lanes[0.01],
        "1000 runs of 2000 s at dt .01 on all cores, wall [s]": many,
        "peak memory [GB]": memory,
        "error after 200 s, largest relative": error,
        "a compiled law's own time, part of the loop's": overhead,
        "whole closed loop, relative to constant controls": whole,
    }
    for name, value in table.items():
        print(f"{name:56} {value}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
