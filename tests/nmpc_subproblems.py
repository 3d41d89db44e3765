"""Subproblems of the planner's real-time iterations: met in closed loop and random, and their cost by hand."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.controllers.nmpc.planner import NEWTON, TOLERANCE
from gyroctl.controllers.nmpc.prediction import STEPS, constants, linear_kind, pullback_of, step_of, tangent_of
from gyroctl.controllers.nmpc.problem import Problem, predict, weights
from gyroctl.controllers.nmpc.solvers import condensed
from gyroctl.controllers.nmpc.solvers import real_time_iterations as rti
from gyroctl.controllers.nmpc.solvers.subproblem import OUTPUTS, Step, Subproblem, empty_subproblem, linearise
from gyroctl.harness.start import locked_start

Array = NDArray[np.float64]
N = 40
CC_MAX = 0.12
DEVICE = gy.zhang2017()
STEP, PULLBACK, TANGENT = (of(linear_kind(DEVICE)) for of in (step_of, pullback_of, tangent_of))
M = 13


class ByCondensing:
    """The dense program, as the planner calls it, behind the interface of the others."""

    def solve(self, qp: Subproblem, proximal: float, d: Array) -> Step:
        return condensed.solve(qp, proximal, d, TOLERANCE, NEWTON, condensed.empty_condensed_room(N, M))


@cache
def horizon(seed: int = 100000, travel: float = 0.0) -> tuple[Problem, Array]:
    """A horizon of an irregular sea from the locked orbit, and a rough plan."""
    sea = gy.SeaState()
    waves = gy.realise(DEVICE, sea, seed, 60.0)
    x, _ = locked_start(DEVICE, sea)
    cost = weights(DEVICE, 2000.0, 0.10, 0.08, 50.0, 3.0, travel, 0.3)  # tight limits: they must matter
    plan = np.random.default_rng(seed).uniform(0.0, CC_MAX, N)
    plan[::3], plan[1::3] = 0.0, CC_MAX
    moments = np.ascontiguousarray(waves.moments.T).ravel()
    start = x[[0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13]]
    return Problem(start, moments, 8.0, 0.03, CC_MAX, 0.1, np.array([0.05]), constants(DEVICE), cost), plan


def later(problem: Problem, sample: int, start: Array, before: float) -> Problem:
    """The horizon that begins at a sample."""
    first = 2 * STEPS * sample
    return problem._replace(start=start, before=before, moments=problem.moments[first:])


@cache
def real_subproblems() -> list[tuple[Subproblem, float]]:
    """Subproblems met in closed loop, the model in the place of the plant, and their proximal weights."""
    out = []
    for seed, travel in ((100000, 0.0), (100001, 200.0)):
        problem, plan = horizon(seed, travel)
        now, proximal, room = problem, 100.0, rti.empty_room(N, M)
        for sample in range(25):
            predict(STEP, now, plan, room.states)
            qp = empty_subproblem(N, M)
            assert linearise(TANGENT, now, plan, room.states, qp)
            out.append((qp, proximal))
            proximal = rti.iterate(STEP, TANGENT, now, plan, proximal, 1, 10, 1e-6, room).proximal
            now = later(problem, sample + 1, room.states[STEPS].copy(), plan[0])
            plan = np.append(plan[1:], plan[-1])
    return out


def random_subproblem(seed: int, n: int = 12, m: int = 9) -> tuple[Subproblem, float]:
    """A subproblem with bounds and limits active, with and without travel."""
    rng = np.random.default_rng(seed)
    qp = empty_subproblem(n, m)
    orthogonal = np.linalg.qr(rng.standard_normal((n, m, m)))[0]
    qp.A[:], qp.b[:] = rng.uniform(0.8, 1.05) * orthogonal, rng.standard_normal((n, m))
    qp.outputs[:] = rng.standard_normal((n, 3))
    qp.low[:], qp.high[:] = (-1.0, -0.7, 0.2), (1.0, 0.7, np.inf)
    qp.weight[:] = rng.uniform(1.0, 30.0, 3)
    qp.terminal[:] = 3.0 * rng.standard_normal(m)
    qp.cc_max[0] = 1.0
    qp.plan[:] = np.clip(rng.uniform(-0.5, 1.5, n), 0.0, 1.0)
    qp.before[0], qp.travel[0] = rng.uniform(), rng.choice([0.0, 2.0])
    return qp, float(10.0 ** rng.uniform(-1.0, 1.0))


def by_hand(qp: Subproblem, proximal: float, d: Array) -> float:
    """The cost as the file's head states it, in plain numpy."""
    n, m = qp.b.shape
    e, total = np.zeros(m), 0.0
    planned = np.concatenate([qp.before, qp.plan])
    moved = planned + np.append(0.0, d)
    for i in range(n):
        e = qp.A[i] @ e + qp.b[i] * d[i]
        y = qp.outputs[i] + e[list(OUTPUTS)]
        total += 0.5 * qp.weight @ np.maximum(0.0, np.maximum(qp.low - y, y - qp.high)) ** 2
    return float(total + qp.terminal @ e + qp.travel[0] * np.sum(np.diff(moved) ** 2) + 0.5 * proximal * d @ d)


def gradient_by_differences(qp: Subproblem, proximal: float, d: Array) -> Array:
    out = np.empty(d.size)
    for i in range(d.size):
        move = np.zeros(d.size)
        move[i] = 1e-5
        out[i] = (by_hand(qp, proximal, d + move) - by_hand(qp, proximal, d - move)) / 2e-5
    return out
