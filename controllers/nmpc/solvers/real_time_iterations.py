"""Real-time iterations: one linearisation of the horizon, one quadratic program, one safeguarded step.

After Diehl, Bock, Schloeder (SIAM J. Control Optim. 43 (2005) 1714-1736). Full steps lose lock: the plan sits at
pull-out, where a linear model flatters. So each step is shortened until the true cost falls, and the proximal weight
follows the ratio of true to promised decrease as in the Levenberg-Marquardt method: the cost never rises.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc import solvers
from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.controllers.nmpc.problem import predict
from gyroctl.controllers.nmpc.solvers.riccati import PATIENCE, empty_riccati_room, solve, solve_briefly
from gyroctl.controllers.nmpc.solvers.subproblem import (
    NOT_FINITE,
    SOLVED,
    Step,
    Subproblem,
    empty_subproblem,
    linearise,
)
from gyroctl.plant.compiled import inlined, part, put, put_table, source_stamp, within

PROXIMAL_MIN, PROXIMAL_MAX = 1.0, 1e5  # [J/(Nms)^2]
GOOD, POOR = 0.75, 0.25  # ratio of true to promised decrease above and below which the proximal weight changes
HALVINGS = 6


class Room(NamedTuple):
    """Arrays that an iteration works in."""

    qp: Subproblem
    inner: Any  # RiccatiRoom
    states: NDArray[np.float64]  # (n STEPS + 1, m)
    ahead: NDArray[np.float64]  # (n STEPS + 1, m)
    d: NDArray[np.float64]  # (n,)
    trial: NDArray[np.float64]  # (n,)


class Improvement(NamedTuple):
    """What iterations did to a plan."""

    before: float  # cost [J]
    after: float  # [J]
    proximal: float  # weight to go on with [J/(Nms)^2]
    promised: float  # decrease of the last subproblem [J]: small where the plan is near a local optimum
    status: int  # of the last subproblem, see `subproblem.SOLVED`
    newton: int  # Newton steps of the solver, or its iterations


@inlined
def empty_room(n: int, m: int) -> Room:
    """Room for plans of `n` intervals with a model of `m` states."""
    states, ahead = np.zeros((STEPS * n + 1, m)), np.zeros((STEPS * n + 1, m))
    return Room(empty_subproblem(n, m), empty_riccati_room(n, m), states, ahead, np.zeros(n), np.zeros(n))


@inlined
def at_rest(proximal: float) -> float:
    """Weight to go on with where a program promised nothing: look further next time."""
    return max(proximal / 3.0, PROXIMAL_MIN)


@inlined
def went_well(decrease: float, promised: float, share: float, proximal: float) -> float:
    """Weight to go on with after a `share` of a step made the cost fall by so much, where so much was `promised`."""
    ratio = decrease / promised
    if share == 1.0 and ratio > GOOD:
        proximal /= 3.0
    elif share < 1.0 or ratio < POOR:
        proximal *= 3.0
    return min(max(proximal, PROXIMAL_MIN), PROXIMAL_MAX)


def _advance(stamp: str) -> Callable[..., tuple[float, float]]:
    @part()
    def advance(
        step: Any, problem: Any, cc: Any, d: Any, cost: float, promised: float, proximal: float, room: Any
    ) -> tuple[float, float]:
        """Go along `d` as far as the cost falls; `cc`, and `room.states` with it, are changed in place.

        Returned are the cost of the plan [J] and the proximal weight to go on with.
        """
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        if not promised > 0.0:  # the plan stands, or the weight holds it
            return cost, at_rest(proximal)
        part = 1.0
        for _ in range(HALVINGS):
            for i in range(cc.size):
                room.trial[i] = min(max(cc[i] + part * d[i], 0.0), problem.cc_max)
            found = predict(step, problem, room.trial, room.ahead)
            if found < cost:  # not a number counts as no improvement
                put(room.trial, cc)
                put_table(room.ahead, room.states)
                return found, went_well(cost - found, promised, part, proximal)
            part *= 0.5
        return cost, min(9.0 * proximal, PROXIMAL_MAX)

    return advance


SOURCES = solvers.SOURCES
advance = _advance(source_stamp(SOURCES))


linearised = within(linearise)


def _iterate(stamp: str, briefly: bool) -> Callable[..., Improvement]:
    @part()
    def iterate(
        step: Any,
        tangent: Any,
        problem: Any,
        cc: Any,
        proximal: float,
        iterations: int,
        newton: int,
        tolerance: float,
        room: Any,
    ) -> Improvement:
        """Improve the plan `cc` (n,) [Nms] in place by real-time iterations.

        Each linearisation gets at most `newton` steps, down to the `tolerance` [Nms] of `riccati.solve`: each of its
        iterates is feasible and better than the last, so that a few serve as well as the solution. `step` and `tangent`
        come from `prediction`, `proximal` [J/(Nms)^2] from the last plan; the `room` is overwritten.
        """
        stamp  # noqa: B018 - as above
        for i in range(cc.size):
            cc[i] = min(max(cc[i], 0.0), problem.cc_max)
        first = predict(step, problem, cc, room.states)
        cost, promised, status, total = first, 0.0, SOLVED, 0
        for _ in range(iterations):
            if not linearised(tangent, problem, cc, room.states, room.qp):
                status = NOT_FINITE
                break
            room.d[:] = 0.0
            if briefly:
                found = solve_briefly(room.qp, proximal, room.d, tolerance, min(newton, PATIENCE), room.inner)
            else:
                found = solve(room.qp, proximal, room.d, tolerance, newton, room.inner)
            status, promised = found.status, -found.value
            total += found.iterations
            if status == NOT_FINITE:
                break
            cost, proximal = advance(step, problem, cc, room.d, cost, promised, proximal, room)
        return Improvement(first, cost, proximal, promised, status, total)

    return iterate


iterate = _iterate(source_stamp(SOURCES), False)
iterate_briefly = _iterate(source_stamp(SOURCES), True)
"""`iterate` with at most PATIENCE Newton steps per subproblem: the same to the bit up to there, sooner compiled."""


class QpSolver(Protocol):
    """A solver of subproblems that keeps what it needs, such as `osqp_solver.OsqpSolver`."""

    def solve(self, qp: Subproblem, proximal: float, d: NDArray[np.float64]) -> Step:
        """Write the solution into `d` (n,)."""
        ...


def iterate_with(
    solver: QpSolver, step: Any, tangent: Any, problem: Any, cc: Any, proximal: float, iterations: int, room: Room
) -> Improvement:
    """Improve a plan in place as `iterate` does, with any solver of the subproblems."""
    np.clip(cc, 0.0, problem.cc_max, out=cc)
    first = predict(step, problem, cc, room.states)
    cost, promised, status, total = first, 0.0, SOLVED, 0
    for _ in range(iterations):
        if not linearise(tangent, problem, cc, room.states, room.qp):
            status = NOT_FINITE
            break
        room.d[:] = 0.0
        found = solver.solve(room.qp, proximal, room.d)
        status, promised = found.status, -found.value
        total += found.iterations
        if status == NOT_FINITE:
            break
        cost, proximal = advance(step, problem, cc, room.d, cost, promised, proximal, room)
    return Improvement(first, cost, proximal, promised, status, total)
