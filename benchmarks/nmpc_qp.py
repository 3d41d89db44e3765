"""Solvers of the receding horizon: cost per quadratic program and per improvement of a plan, power in closed loop.

Run ``python benchmarks/nmpc_qp.py`` (about ten minutes); it prints a table and writes it beside itself as
``nmpc_qp.json``. The true moments are seen ahead and all states are known: the solvers differ, nothing else.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from ocp_solvers import Fatrop, Hpipm

import gyroctl as gy
from gyroctl.controllers.nmpc.power_command import PowerCommand
from gyroctl.controllers.nmpc.prediction import (
    STEPS,
    beside_of,
    constants,
    linear_kind,
    pullback_of,
    step_of,
    tangent_of,
)
from gyroctl.controllers.nmpc.problem import Problem, predict, weights
from gyroctl.controllers.nmpc.solvers import condensed, side_by_side
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.descent import descend
from gyroctl.controllers.nmpc.solvers.osqp_solver import OsqpSolver
from gyroctl.controllers.nmpc.solvers.riccati import empty_riccati_room, solve
from gyroctl.controllers.nmpc.solvers.subproblem import SOLVED, empty_subproblem, linearise
from gyroctl.harness.run import lead_in
from gyroctl.harness.start import locked_start
from gyroctl.plant.kernel import hold_one, rows, slip_rate, steps_for
from gyroctl.provenance import made
from gyroctl.simulation.metrics import Record, evaluate

PERIOD, CC_MAX, START = 0.1, 0.12, 100.0
SPEED_RATIO = 0.8
STATES = np.array([0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13])
DEVICE, SEA = gy.zhang2017(), gy.SeaState()
KIND = linear_kind(DEVICE)
STEP, PULLBACK, TANGENT, SIDE = (of(KIND) for of in (step_of, pullback_of, tangent_of, beside_of))
COST = weights(DEVICE, motion=2000.0, limit1=0.25, limit3=0.25, lock=50.0, floor=1.57, travel=0.0, terminal=0.3)
NEWTON, TOLERANCE = 6, 1e-4  # most Newton steps per subproblem, and where it counts as solved [Nms]

Improve = Callable[[Problem, np.ndarray, float], tuple[float, bool]]
"""Improves a plan in place: problem, plan, memory -> memory, whether the solver was content."""


def by_descent(n: int, iterations: int) -> Improve:
    """Projected gradient steps."""

    def improve(problem: Problem, cc: np.ndarray, memory: float) -> tuple[float, bool]:
        _, after, length = descend(STEP, PULLBACK, problem, cc, memory or 1e-3, iterations)
        return length, bool(np.isfinite(after))

    return improve


def by_riccati(n: int, iterations: int) -> Improve:
    """Real-time iterations, all compiled."""
    room = rti.empty_room(n, STATES.size)

    def improve(problem: Problem, cc: np.ndarray, memory: float) -> tuple[float, bool]:
        found = rti.iterate(STEP, TANGENT, problem, cc, memory or 100.0, iterations, NEWTON, TOLERANCE, room)
        return found.proximal, found.status == SOLVED

    return improve


def by_condensing(n: int, iterations: int) -> Improve:
    """Real-time iterations with the dense program in the couplings alone."""
    room, times = side_by_side.empty_side_by_side(1, n, STATES.size), np.array([iterations])

    def improve(problem: Problem, cc: np.ndarray, memory: float) -> tuple[float, bool]:
        proximal, plans = np.array([memory or 100.0]), cc[None, :]
        side_by_side.improve(STEP, SIDE, TANGENT, problem, plans, proximal, times, NEWTON, TOLERANCE, room)
        return float(proximal[0]), bool(room.status[0] == SOLVED)

    return improve


def by_osqp(n: int, iterations: int) -> Improve:
    """Real-time iterations, each subproblem by OSQP."""
    room, solver = rti.empty_room(n, STATES.size), OsqpSolver(n, STATES.size)

    def improve(problem: Problem, cc: np.ndarray, memory: float) -> tuple[float, bool]:
        found = rti.iterate_with(solver, STEP, TANGENT, problem, cc, memory or 100.0, iterations, room)
        return found.proximal, found.status == SOLVED

    return improve


SOLVERS = {"descent": by_descent, "condensed": by_condensing, "riccati": by_riccati, "osqp": by_osqp}


@cache
def sea(seed: int, duration: float) -> tuple[Any, np.ndarray, np.ndarray]:
    """Waves, their moments flat, and the start."""
    waves = lead_in(gy.realise(DEVICE, SEA, seed, duration + 20.0), gy.Settings())
    start = np.zeros(rows(DEVICE.coefficients))
    start[:14] = locked_start(DEVICE, SEA)[0]
    return waves, np.ascontiguousarray(waves.moments.T).ravel(), start


def closed_loop(
    improve: Improve, n: int, seed: int, duration: float, every: int = 0
) -> tuple[dict[str, float], np.ndarray, int, list[tuple[Problem, np.ndarray, float]]]:
    """One run; returns metrics, time per plan [s], how often the solver was not content, every `every`-th problem."""
    waves, flat, y = sea(seed, duration)
    k, h = constants(DEVICE), np.array([PERIOD / STEPS])
    samples = round(duration / PERIOD)
    states, controls, spent = np.zeros((samples + 1, y.size)), np.zeros((samples, 2)), np.zeros(samples)
    regulator = PowerCommand(SPEED_RATIO * DEVICE.parameters.N * SEA.wp, 1.5, 0.005, 0.0, 0.9, 6.0)
    plan, memory, mean, applied, discontent = np.full(n, 0.05), 0.0, 8.0, 0.05, 0
    states[0], kept = y, []
    for sample in range(samples):
        power, mean = regulator.step(y[7], mean, PERIOD, sample * PERIOD, 0.02)
        first = 2 * STEPS * sample
        window = flat[first : first + 2 * (STEPS * n + 1)]
        problem = Problem(y[STATES], window, power, applied, CC_MAX, PERIOD, h, k, COST)
        if every and sample % every == every - 1:
            kept.append((problem, plan.copy(), memory))
        begin = time.thread_time()
        memory, content = improve(problem, plan, memory)
        spent[sample] = time.thread_time() - begin
        discontent += not content
        applied, controls[sample] = plan[0], (plan[0], power / y[7] ** 2)
        plan = np.append(plan[1:], plan[-1])
        steps = steps_for(PERIOD, 0.02, slip_rate(DEVICE.coefficients, applied))
        y = hold_one(y, DEVICE.coefficients, *controls[sample], sample * PERIOD, PERIOD, steps, flat, waves.dt)
        states[sample + 1] = y
    record = Record(states, controls, controls, PERIOD, 0)
    found = evaluate(DEVICE, record, waves.moments[1], waves.dt, SEA.wp, START, np.nan)
    stored = 0.5 * DEVICE.parameters.J4 * (y[7] ** 2 - states[round(START / PERIOD), 7] ** 2) / (duration - START)
    return {**found, "net_power": found["generated_w"] + stored}, spent[10:], discontent, kept


def programs(n: int, kept: list[tuple[Problem, np.ndarray, float]]) -> list[dict[str, Any]]:
    """Time each solver on the same quadratic programs."""
    m = STATES.size
    states, qp, room = np.empty((STEPS * n + 1, m)), empty_subproblem(n, m), empty_riccati_room(n, m)
    solvers: dict[str, Any] = {f"osqp {t:g}": OsqpSolver(n, m, tolerance=t) for t in (1e-3, 1e-4, 1e-6)}
    solvers |= {"hpipm": Hpipm(n, m), "fatrop": Fatrop(n, m)}
    dense = condensed.empty_condensed_room(n, m)
    names = ["linearise", "condensed", "riccati", *solvers]
    spent: dict[str, list[float]] = {name: [] for name in names}
    far: dict[str, list[float]] = {name: [] for name in names}
    work: dict[str, list[int]] = {name: [] for name in names}
    content: dict[str, list[bool]] = {name: [] for name in names}
    for problem, plan, proximal in kept:
        predict(STEP, problem, plan, states)
        begin = time.thread_time()
        linearise(TANGENT, problem, plan, states, qp)
        spent["linearise"].append(time.thread_time() - begin)
        exact, d = np.zeros(n), np.zeros(n)
        solve(qp, proximal, exact, 1e-12, 1000, room)
        for name in names[1:]:
            d[:] = 0.0
            begin = time.thread_time()
            if name == "condensed":
                found = condensed.solve(qp, proximal, d, 1e-9, 200, dense)
            elif name == "riccati":
                found = solve(qp, proximal, d, 1e-9, 200, room)
            else:
                found = solvers[name].solve(qp, proximal, d)
            took = time.thread_time() - begin
            spent[name].append(getattr(solvers.get(name), "spent", took))  # of casadi's the call alone
            far[name].append(float(np.max(np.abs(d - exact))))
            work[name].append(found.iterations)
            content[name].append(found.status == SOLVED)
    return [
        {
            "horizon_s": n * PERIOD,
            "solver": name,
            "count": len(kept),
            **milliseconds(np.array(spent[name])),
            "iterations_median": float(np.median(work[name])) if work[name] else None,
            "error_median_nms": float(np.median(far[name])) if far[name] else None,
            "error_max_nms": max(far[name]) if far[name] else None,
            "not_solved": content[name].count(False),
        }
        for name in names
    ]


def milliseconds(spent: np.ndarray) -> dict[str, float]:
    """Median and 99 % of times [s], in ms."""
    return {"ms_median": 1e3 * float(np.median(spent)), "ms_p99": 1e3 * float(np.percentile(spent, 99))}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=6, help="tuning seeds from 100000 on")
    parser.add_argument("--duration", type=float, default=600.0, help="of each run [s]")
    options = parser.parse_args()
    seeds = [100000 + i for i in range(options.seeds)]
    where = Path(__file__).with_suffix(".json")
    result: dict[str, Any] = {
        **made(),
        "machine": platform.processor() or platform.machine(),
        "python": platform.python_version(),
        "seeds": seeds,
        "duration_s": options.duration,
        "programs": [],
        "closed_loop": [],
    }
    for n in (40, 80):
        *_, kept = closed_loop(by_riccati(n, 1), n, seeds[0], 200.0, every=10)
        programs(n, kept[:3])  # compile
        for line in programs(n, kept[5:]):
            print(line, flush=True)
            result["programs"].append(line)
    for n, name, iterations in (
        (40, "descent", 10),
        (40, "descent", 30),
        (40, "condensed", 1),
        (40, "riccati", 1),
        (40, "riccati", 3),
        (40, "osqp", 1),
        (80, "descent", 10),
        (80, "descent", 30),
        (80, "condensed", 1),
        (80, "riccati", 1),
        (80, "riccati", 3),
        (80, "osqp", 1),
    ):
        runs = [closed_loop(SOLVERS[name](n, iterations), n, seed, options.duration) for seed in seeds]
        metrics = [run[0] for run in runs]
        line = {
            "horizon_s": n * PERIOD,
            "solver": name,
            "iterations": iterations,
            **milliseconds(np.concatenate([run[1] for run in runs])),
            "net_power_w": [round(float(m["net_power"]), 3) for m in metrics],
            "net_power_mean_w": float(np.mean([m["net_power"] for m in metrics])),
            "power_cv": float(np.mean([m["power_cv"] for m in metrics])),
            "locked": int(sum(m["locked"] for m in metrics)),
            "phi1_p98": float(np.mean([m["phi1_p98"] for m in metrics])),
            "phi1_p98_max": float(max(m["phi1_p98"] for m in metrics)),
            "phi3_p98": float(np.mean([m["phi3_p98"] for m in metrics])),
            "not_solved": sum(run[2] for run in runs),
            "plans": sum(run[1].size for run in runs),
        }
        print(line, flush=True)
        result["closed_loop"].append(line)
        where.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
