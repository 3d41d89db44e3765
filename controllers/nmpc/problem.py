"""The optimal control problem: the most energy from the waves over a horizon, within the motion limit and in lock.

Free is the coupling cc in each control interval. The generator gives a constant power over the horizon, which a slow
command sets (`gyroctl.controllers.nmpc.power_command`): a constant power costs nothing, since the flywheel stores
minutes of it. What is left to be won is the energy that reaches the flywheel, so the cost is economic:

    cost = - stored energy at the end (flywheel, and a share of the float's)
           + integral of motion beyond its limits, squared
           + integral of ring speed below what it must be, squared      (no stall within the cycle, and grip)
           + what the ring's last angle falls short of `reach`, squared (the reserve of lock, over the long run)
           + travel of cc, squared

The limits are soft: a plan must exist in every state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc import prediction
from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.plant import Plant
from gyroctl.plant.compiled import inlined, part, put, source_stamp
from gyroctl.plant.trigonometry import cos_sin

PHI1, PHI3, RING_ANGLE, V1, V3, RING, FLYWHEEL = range(7)  # rows of the prediction model's state


class Weights(NamedTuple):
    """What the cost weighs, in energy [J]."""

    motion: float  # [J/(rad^2 s)]
    limit1: float  # of |phi1| [rad]
    limit3: float  # of |phi3| [rad]
    lock: float  # [J s/rad^2]
    floor: float  # of the ring speed [rad/s]
    travel: float  # [J/(Nms)^2]
    terminal: float  # share of the float's mechanical energy that counts at the end [-]
    J4: float  # [kg m^2]
    I1: float  # J1 + Jh1 [kg m^2]
    I3: float  # J1 + Jh3 [kg m^2]
    k1: float  # [Nm/rad]
    k3: float  # [Nm/rad]
    turns: float = 0.0  # [J/rad^2]
    reach: float = 0.0  # least ring angle at the end of the horizon [rad]
    grip: float = 0.0  # ring speed that a unit of |u3| asks for, one over the friction that is counted on [-]
    ceiling: float = 100.0  # most that grip asks for [rad/s]


NO_MARGINS = np.zeros(0)

NOW = 4
"""Numbers of a problem that change from sample to sample, `power` to `period`; in a row its margins stand behind."""


class Problem(NamedTuple):
    """One horizon of n control intervals."""

    start: NDArray[np.float64]  # state without omega
    moments: NDArray[np.float64]  # (width (n STEPS + 1),) at each model step, see `prediction.width_of` [Nm, Nm/s]
    power: float  # of the generator [W]
    before: float  # coupling before the first interval [Nms]
    cc_max: float  # [Nms]
    period: float  # control interval [s]
    h: NDArray[np.float64]  # (1,) model step [s]
    k: NDArray[np.float64]  # constants of the model
    weights: Weights
    width: int = 2  # numbers of an instant, see `prediction.width_of`
    margins: NDArray[np.float64] = NO_MARGINS  # (n,) ring speed beyond what is needed, or (0,) for none [rad/s]


def weights(
    plant: Plant, motion: float, limit1: float, limit3: float, lock: float, floor: float, travel: float, terminal: float
) -> Weights:
    """Weights with the inertias and stiffnesses of a device."""
    k = plant.coefficients
    return Weights(motion, limit1, limit3, lock, floor, travel, terminal, k.J4, 1.0 / k.i1, 1.0 / k.i3, k.k1, k.k3)


@inlined
def margin_at(problem: Problem, i: Any) -> Any:
    """Ring speed that is asked for beyond what is needed at the end of the interval `i` [rad/s]."""
    return problem.margins[i] if problem.margins.size > i else 0.0


@inlined
def stage_cost(x: Any, w: Weights, margin: Any, slope: Any) -> Any:
    """Cost per second in `x` with a `margin` of ring speed [rad/s], in J/s; its gradient is added to `slope` (n,)."""
    cost = 0.0
    for row, limit in ((PHI1, w.limit1), (PHI3, w.limit3)):
        beyond = abs(x[row]) - limit
        if beyond > 0.0:
            cost += w.motion * beyond * beyond
            slope[row] += 2.0 * w.motion * (beyond if x[row] > 0.0 else -beyond)
    extra, by_angle, by_v1, by_v3 = grip_needed(x, w)
    below = w.floor + extra + margin - x[RING]
    if below > 0.0:
        cost += w.lock * below * below
        slope[RING] -= 2.0 * w.lock * below
        slope[RING_ANGLE] += 2.0 * w.lock * below * by_angle
        slope[V1] += 2.0 * w.lock * below * by_v1
        slope[V3] += 2.0 * w.lock * below * by_v3
    return cost


@inlined
def grip_needed(x: Any, w: Weights) -> tuple[float, float, float, float]:
    """Ring speed above its floor that the rolling contact asks for [rad/s], and its slopes by RING_ANGLE, V1, V3.

    A contact with friction mu carries the axis round while |u3| <= mu psi', with u3 = sin psi phi1' + cos psi phi3' the
    rate of the float across the axis: in slow motion the friction that rolling needs is the ratio of the two. More than
    a closed coupling can give is not asked for: a plan would let the ring go now to be asked for less later.
    """
    if w.grip > 0.0:
        c, s = cos_sin(x[RING_ANGLE])
        across = s * x[V1] + c * x[V3]
        extra = w.grip * abs(across) - w.floor
        if extra > 0.0 and extra + w.floor > w.ceiling:
            return w.ceiling - w.floor, 0.0, 0.0, 0.0
        if extra > 0.0:
            sense = w.grip if across > 0.0 else -w.grip
            return extra, sense * (c * x[V1] - s * x[V3]), sense * s, sense * c
    return 0.0, 0.0, 0.0, 0.0


@inlined
def terminal_cost(x: Any, w: Weights, slope: Any) -> Any:
    """Cost of the last state [J]; its gradient is added to `slope` (n,)."""
    slope[FLYWHEEL] -= w.J4 * x[FLYWHEEL]
    slope[V1] -= w.terminal * w.I1 * x[V1]
    slope[V3] -= w.terminal * w.I3 * x[V3]
    slope[PHI1] -= w.terminal * w.k1 * x[PHI1]
    slope[PHI3] -= w.terminal * w.k3 * x[PHI3]
    short = max(w.reach - x[RING_ANGLE], 0.0)
    slope[RING_ANGLE] -= 2.0 * w.turns * short
    kinetic = w.I1 * x[V1] * x[V1] + w.I3 * x[V3] * x[V3]
    spring = w.k1 * x[PHI1] * x[PHI1] + w.k3 * x[PHI3] * x[PHI3]
    return w.turns * short * short - 0.5 * (w.J4 * x[FLYWHEEL] * x[FLYWHEEL] + w.terminal * (kinetic + spring))


@inlined
def cost_of(problem: Problem, cc: Any, states: Any) -> Any:
    """Cost of the plan `cc` (n,) [Nms] in its predicted `states` (n STEPS + 1, m) [J]."""
    ignored = np.zeros(problem.start.size)
    cost, last = 0.0, problem.before
    for i in range(cc.size):
        cost += problem.period * stage_cost(states[STEPS * (i + 1)], problem.weights, margin_at(problem, i), ignored)
        cost += problem.weights.travel * (cc[i] - last) ** 2
        last = cc[i]
    return cost + terminal_cost(states[STEPS * cc.size], problem.weights, ignored)


def _compiled(stamp: str) -> tuple[Callable[..., float], Callable[..., None]]:
    """Compile prediction and adjoint; the stamp makes the cache forget code whose parts have changed."""

    @part()
    def predict(step: Any, problem: Problem, cc: Any, states: Any) -> float:
        """Predict the `states` (n STEPS + 1, m) of the plan `cc` (n,) [Nms] and return its cost [J].

        `step` comes from `prediction.step_of`.
        """
        assert stamp
        u, width = np.array([0.0, problem.power]), problem.width
        put(problem.start, states[0])
        for i in range(cc.size):
            u[0] = cc[i]
            for q in range(STEPS * i, STEPS * (i + 1)):
                step(states[q], u, problem.moments[width * q : width * (q + 2)], problem.h, problem.k, states[q + 1])
        total: float = cost_of(problem, cc, states)
        return total

    @part()
    def gradient(pullback: Any, problem: Problem, cc: Any, states: Any, slope: Any) -> None:
        """Write the gradient of the cost by the plan into `slope` (n,), by the adjoint of the predicted `states`."""
        assert stamp
        m, width = problem.start.size, problem.width
        u, weight = np.array([0.0, problem.power]), np.zeros(m)
        by_x, by_u = np.zeros(m), np.zeros(2)
        terminal_cost(states[STEPS * cc.size], problem.weights, weight)
        for i in range(cc.size - 1, -1, -1):
            by_x[:] = 0.0
            stage_cost(states[STEPS * (i + 1)], problem.weights, margin_at(problem, i), by_x)
            for row in range(m):
                weight[row] += problem.period * by_x[row]
            u[0] = cc[i]
            slope[i] = 0.0
            for q in range(STEPS * (i + 1) - 1, STEPS * i - 1, -1):
                given = problem.moments[width * q : width * (q + 2)]
                pullback(states[q], u, given, problem.h, problem.k, weight, by_x, by_u)
                slope[i] += by_u[0]
                put(by_x, weight)
        travel = 2.0 * problem.weights.travel
        for i in range(cc.size):
            slope[i] += travel * (cc[i] - (problem.before if i == 0 else cc[i - 1]))
            if i + 1 < cc.size:
                slope[i] += travel * (cc[i] - cc[i + 1])

    return predict, gradient


SOURCES = (prediction.__file__, __file__)
predict, gradient = _compiled(source_stamp(SOURCES))
