"""How cost grows: with runs, lanes, states, horizon and cores; and what does not grow with laws, length and runs.

Run ``python benchmarks/growth.py`` (three minutes); it prints a table and writes it beside itself as ``growth.json``.
Times are of the processor, the least of three goes; those over cores are of the wall.

``python benchmarks/growth.py laws length driver`` prints one or more of these alone and writes nothing: pairs, time and
page of a comparison by its laws (eight realisations, made-up metrics); memory of one run, and size of what is kept of
it, by its length; memory of the driver by the runs.
"""

from __future__ import annotations

import json
import os
import sys
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from clock import here, least

import gyroctl as gy
from gyroctl.harness import together
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.plant.kernel import LANES, hold_into, rows
from gyroctl.plant.lagrange import TAPS
from gyroctl.simulation.ensemble import run_ensemble

DEVICE, SEA, SETTINGS = gy.zhang2017(), gy.SeaState(), gy.Settings(blend=20.0)
PAIR = (0.052, 3.5e-4)
START = locked_start(DEVICE, SEA)[0]
LENGTH = 200.0
"""Of the runs. [s]"""

POINTS = {
    "runs": (1, 4, 16, 64, 256, 1024),
    "lanes": tuple(range(1, LANES + 1)),
    "states": (0, 1, 2, 4, 6, 8),
    "horizon": (1.0, 2.0, 4.0, 8.0, 12.0),
}
"""Where each cost is measured: runs of an ensemble, closed loops in lanes, orders of radiation added to each mode,
horizon of the planning law [s]."""


def ensemble(runs: int, workers: int = 1) -> Callable[[], Any]:
    """An ensemble with a constant pair, waves and statistics included."""
    return lambda: run_ensemble(
        DEVICE, SEA, [PAIR], range(1, runs + 1), START, LENGTH, 20.0, 0.01, workers=workers, quiet=True
    )


def over_runs() -> list[dict[str, float]]:
    """Time of a simulated second of one run by how many there are."""
    times = least([ensemble(runs) for runs in POINTS["runs"]], 3)
    return [
        {"runs": runs, "us_per_simulated_second": spent / runs / LENGTH * 1e6}
        for runs, spent in zip(POINTS["runs"], times, strict=True)
    ]


def over_cores() -> list[dict[str, float]]:
    """Wall time of an ensemble by the number of workers."""
    cores = [n for n in (1, 2, 4, 8, 16, 32, 64) if n <= (os.cpu_count() or 1)]
    times = least([ensemble(1024, n) for n in cores], 3, time.perf_counter)
    return [{"cores": n, "times_as_fast": times[0] / spent} for n, spent in zip(cores, times, strict=True)]


def over_lanes() -> list[dict[str, float]]:
    """Time of a simulated second of one closed loop by how many lanes are filled."""
    waves = [lead_in(gy.realise(DEVICE, SEA, seed, LENGTH), SETTINGS) for seed in range(1, LANES + 1)]
    loops = [together.Loop(gy.law("load_angle"), each, SETTINGS) for each in waves]
    alone = least([lambda: run_law(DEVICE, loops[0].law, waves[0], SETTINGS)], 5)[0]
    usual, together.WORTH = together.WORTH, 1
    try:
        times = least([lambda n=n: together.run_together(DEVICE, loops[:n]) for n in POINTS["lanes"]], 4)
    finally:
        together.WORTH = usual
    return [{"lanes": n, "of_a_run_alone": spent / n / alone} for n, spent in zip(POINTS["lanes"], times, strict=True)]


def over_states() -> list[dict[str, float]]:
    """Time of a simulated second of one run by the number of states.

    Radiation of a higher order, the same function: numerator and denominator get common factors.
    """
    waves = lead_in(gy.realise(DEVICE, SEA, 1, LENGTH), SETTINGS)
    flat, u = np.ascontiguousarray(waves.moments.T).ravel(), np.array([[PAIR[0]], [PAIR[1]]])
    works, sizes = [], []
    for extra in POINTS["states"]:
        plant = replace(DEVICE, radiation=tuple(raised(one, extra) for one in DEVICE.radiation))
        state = np.zeros(rows(plant.coefficients))
        state[:8] = START[:8]

        def run(plant: gy.Plant = plant, state: np.ndarray = state) -> None:
            work, moments = np.empty((5, state.size)), np.empty(6)
            steps = round(LENGTH / 0.01)
            y, weight = state.copy(), np.empty(TAPS)
            hold_into(y, work, moments, weight, plant.coefficients, u, 0.0, LENGTH, steps, flat, waves.dt)

        run()  # compile
        works.append(run)
        sizes.append(len(plant.labels))
    times = least(works, 3)
    return [
        {"states": size, "us_per_simulated_second": spent / LENGTH * 1e6}
        for size, spent in zip(sizes, times, strict=True)
    ]


def raised(radiation: Any, extra: int) -> Any:
    """The same transfer function with so many common factors s + 2, s + 3, ..."""
    p, q = np.array(radiation.p), np.array([1.0, *radiation.q])
    for i in range(extra):
        p, q = np.convolve(p, [1.0, 2.0 + i]), np.convolve(q, [1.0, 2.0 + i])
    return replace(radiation, p=tuple(map(float, p)), q=tuple(map(float, q[1:])))


def over_horizon() -> list[dict[str, float]]:
    """Time of a sample of the planning law by the length of its plan."""
    waves = lead_in(gy.realise(DEVICE, SEA, 1, LENGTH), SETTINGS)
    found = []
    for horizon in POINTS["horizon"]:
        law = gy.law("nmpc", horizon=horizon)
        run_law(DEVICE, law, lead_in(gy.realise(DEVICE, SEA, 1, 30.0), SETTINGS), SETTINGS)  # compile
        timing = run_law(DEVICE, law, waves, SETTINGS)[1]
        found.append({"horizon_s": horizon, "median_ms": timing.median, "p99_ms": timing.p99})
    return found


def over_laws() -> list[dict[str, float]]:
    """Statistics, verdict, summary and page of a comparison by the number of its laws."""
    from gyroctl.reports.evaluation import evaluate
    from gyroctl.reports.report import render
    from gyroctl.reports.summary import summarise
    from gyroctl.reports.verdict import judge

    render(made_up(4))  # load the libraries
    found = []
    for laws in (8, 32, 125, 500, 2000):
        ds = made_up(laws)
        begin = time.process_time()
        evaluation = evaluate(ds)
        judge(evaluation)
        middle = time.process_time()
        page, summary = render(ds, evaluation), json.dumps(summarise(ds, evaluation))
        row = {"laws": laws, "pairs": len(evaluation.power_differences), "statistics_s": middle - begin}
        row |= {"page_s": time.process_time() - middle, "page_mb": len(page) / 1e6, "summary_mb": len(summary) / 1e6}
        found.append(row)
    return found


def made_up(laws: int, runs: int = 8) -> Any:
    """Comparison of so many laws in the layout of a stored one, its numbers drawn at random."""
    import xarray as xr

    from gyroctl.reports import layout

    rng, names = np.random.default_rng(laws), ["best_constant", *(f"law {k}" for k in range(1, laws))]
    power = rng.gamma(20.0, 0.1, (laws, 1)) * rng.normal(1.0, 0.05, (laws, runs))
    numbers = {name: 0.1 * rng.uniform(size=power.shape) for name in (*layout.REQUIRED, *layout.OPTIONAL)}
    numbers |= {"mean_power": power, "generated_w": power, "power_cv": 0.3 + numbers["power_cv"]}
    numbers |= dict.fromkeys(("locked", "in_step"), np.ones(power.shape))
    numbers |= {"loss_time": np.full(power.shape, np.nan), "ledger_residual": np.zeros(power.shape)}
    coords = {"law": names, "realisation": np.arange(1, runs + 1), "sha256": ("realisation", ["0" * 64] * runs)}
    attributes = {"experiment": "{}", "gyroctl_version": "", "created": "", "tuning_seeds": "[]", "duration": 2000.0}
    data = {name: (("law", "realisation"), values) for name, values in numbers.items()}
    return xr.Dataset(data, {**coords, "information": ("law", ["sensors"] * laws)}, attributes)


def over_length() -> list[dict[str, float]]:
    """Memory that one run takes, and points of each time series that are kept of it, by its length."""
    from gyroctl.comparison.compare import Realisations
    from gyroctl.comparison.items import perform, work_items

    found = []
    for length in (2e3, 1e4, 1e5):
        (item,) = work_items(DEVICE, {"pair": gy.law("constant")}, Realisations(SEA, (1,), length), SETTINGS, 1e3)
        tracemalloc.start()
        (outcome,) = perform([item])
        most = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        found.append({"length_s": length, "peak_mb": most, "points": float(outcome.series["time"].size)})
    return found


def over_driver() -> list[dict[str, float]]:
    """Memory that the driver holds by the number of runs, which here are made up and take no time."""
    from gyroctl.comparison import execution
    from gyroctl.comparison.compare import Realisations
    from gyroctl.comparison.items import Item, Outcome, work_items

    names = [f"metric_{k}" for k in range(70)]

    def made(items: list[Item]) -> list[Outcome]:
        return [Outcome(item.sha256, {name: float(item.seed) for name in names}) for item in items]

    plain, execution.perform = execution.perform, made
    found = []
    try:
        for runs in (100, 1000, 10_000):
            waves = Realisations(SEA, tuple(range(runs // 10)), 60.0)
            laws = {f"law {k}": gy.law("constant", cg=1e-4 * (k + 1)) for k in range(10)}
            items = work_items(DEVICE, laws, waves, SETTINGS, 60.0)
            tracemalloc.start()
            outcomes = execution.execute(items, 2, None, True)
            held, most = (size / 1e3 / runs for size in tracemalloc.get_traced_memory())
            tracemalloc.stop()
            found.append({"runs": len(outcomes), "held_kb_each": held, "peak_kb_each": most})
    finally:
        execution.perform = plain
    return found


ALONE = {"laws": over_laws, "length": over_length, "driver": over_driver}
"""Measured when they are asked for by name."""


def table() -> dict[str, Any]:
    """Measure all."""
    ensemble(LANES)()  # compile
    return {
        **here(),
        "length_s": LENGTH,
        "runs": over_runs(),
        "lanes": over_lanes(),
        "states": over_states(),
        "horizon": over_horizon(),
        "cores": over_cores(),
    }


def show(content: dict[str, list[dict[str, float]]]) -> None:
    """Print each table."""
    for name, found in content.items():
        print(name)
        for row in found:
            print("   ", "  ".join(f"{key} {value:.4g}" for key, value in row.items()))


def main() -> None:
    """Measure and print."""
    if sys.argv[1:]:
        show({name: ALONE[name]() for name in sys.argv[1:]})
        return
    content = table()
    show({name: content[name] for name in (*POINTS, "cores")})
    Path(__file__).with_suffix(".json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
