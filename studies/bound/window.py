"""A window as a planning problem, and a plan of it, followed by the prediction model.

    cost = - energy generated - stored energy at the end (flywheel, and a share of the float's)
           + integral of motion beyond its limits, squared
           + difference of the flywheel's energy between the end and the start, squared

The last term is what pins the power: 1 J in the flywheel and 1 J generated are worth the same.

The model is that of the planning law: the linear plant, or the smooth form of what there is beyond it. Where the
coupling lags, a plan says what is asked for, and each model step is given the mean of the coupling on its way there.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.prediction import constants, kind_of, pullback_of, step_of, width_of
from gyroctl.controllers.nmpc.problem import FLYWHEEL, RING_ANGLE, Weights, stage_cost, terminal_cost
from gyroctl.harness.run import beginning
from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point
from gyroctl.plant.equations import OMEGA
from gyroctl.plant.instants import interpolate
from gyroctl.plant.lagrange import TAPS
from gyroctl.studies.bound.cut import Cut

SUBSTEPS = 4
"""Model steps in a control interval: finer than those of a controller, which looks at the plant again every 0.1 s."""

_interpolate = entry_point(interpolate)


class Window(NamedTuple):
    """A window of n control intervals."""

    start: NDArray[np.float64]  # state of the model
    moments: NDArray[np.float64]  # (width (n substeps + 1),) at each model step [Nm, Nm/s]
    width: int  # numbers of an instant, see `prediction.width_of`
    substeps: int
    period: float  # control interval [s]
    h: NDArray[np.float64]  # (1,) model step [s]
    k: NDArray[np.float64]  # constants of the model
    weights: Weights
    closing: float  # weight of the flywheel's change of energy, squared [1/J]
    cc_max: float  # [Nms]
    power_max: float  # [W]
    before: float  # coupling before the window [Nms]
    late: NDArray[np.float64]  # (substeps,) part of the way that the coupling still has before it, mean of a step [-]
    left: float  # and at the end of an interval [-]

    @property
    def intervals(self) -> int:
        """Control intervals."""
        return (self.moments.size // self.width - 1) // self.substeps


class Plan(NamedTuple):
    """Controls of a window and where they lead."""

    cc: NDArray[np.float64]  # (n,) coupling [Nms]
    power: NDArray[np.float64]  # (n,) of the generator [W]
    states: NDArray[np.float64]  # (n + 1, m) states of the model, see `reduced`


def window(cut: Cut, weights: Weights, intervals: int, substeps: int = SUBSTEPS, closing: float = 5e-4) -> Window:
    """Set up the problem of a window.

    Parameters
    ----------
    cut : Cut
        The window.
    weights : Weights
        Of the limits, see `gyroctl.controllers.nmpc.problem.weights`.
    intervals : int
        Control intervals, those of the tail included.
    substeps : int
        Model steps in a control interval.
    closing : float
        Weight of the flywheel's change of energy, squared. [1/J]
    """
    actuators, waves, width = cut.settings.actuators, cut.waves, width_of(kind_of(cut.plant, losses=True))
    h = actuators.period / substeps
    known = waves.moments if width == 2 else np.concatenate([waves.moments, rates(waves.time, waves.moments)])
    flat = np.ascontiguousarray(known.T).ravel()
    moments = _sample(flat, width // 2, 0.0, h / waves.dt, intervals * substeps + 1)
    model = np.array([h]), constants(cut.plant, beyond=True, losses=True), weights, closing
    speed = cut.plant.parameters.N * waves.sea.wp
    limits = actuators.cc_max, 0.7 * actuators.cg_max * speed**2
    before, (late, left) = beginning(cut.plant, waves, cut.settings)[1][0], _lateness(actuators.cc_lag, h, substeps)
    start = reduced(cut.plant, cut.start)
    return Window(start, moments, width, substeps, actuators.period, *model, *limits, before, late, left)


def rates(time: NDArray[np.float64], moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rates of change of moments (2, n) on their grid, by a spline of fifth order. [Nm/s]"""
    from scipy.interpolate import make_interp_spline

    return np.asarray(make_interp_spline(time, moments, k=5, axis=1).derivative()(time))


def _lateness(lag: float, h: float, substeps: int) -> tuple[NDArray[np.float64], float]:
    """Part of its way that a lagging coupling has before it: mean over each model step, and after all of them."""
    if lag == 0.0:
        return np.zeros(substeps), 0.0
    ends = np.exp(-h / lag * np.arange(substeps + 1))
    return lag / h * (ends[:-1] - ends[1:]), float(ends[-1])


def reduced(plant: Plant, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """State (.., m) of the prediction model from that of the plant (.., rows), ledger or not.

    Left out is omega, which is cyclic, and the speed of an axis that may slip: the model rolls.
    """
    rows = [row for row in range(len(plant.rolling.labels)) if row != OMEGA]
    return np.take(np.asarray(x, float), rows, axis=-1)  # in the order of C: sums over it depend on that


@entry_point
def _sample(flat: Any, pairs: int, first: float, spacing: float, count: int) -> Any:
    """Signals, two for each of `pairs`, at `count` points, interpolated as the plant's kernel does."""
    out, weight = np.empty(2 * pairs * count), np.empty(TAPS)
    for i in range(count):
        _interpolate(flat, pairs, first + i * spacing, weight, out, i)
    return out


def model_of(plant: Plant) -> tuple[Any, Any]:
    """Compiled step and pullback of the prediction model, see `prediction`."""
    kind = kind_of(plant, losses=True)  # a promise counts what is lost
    return step_of(kind), pullback_of(kind)


@entry_point
def acting(w: Window, before: float, cc: Any, out: Any) -> float:
    """Write the mean coupling of each model step into `out` (n substeps,); return the coupling at the end. [Nms]

    `cc` (n,) is what is asked for, `before` the coupling that acts when it begins.
    """
    s = w.substeps
    for i in range(cc.size):
        way = before - cc[i]
        for q in range(s):
            out[s * i + q] = cc[i] + w.late[q] * way
        before = cc[i] + w.left * way
    return before


@entry_point
def asked(w: Window, by_acting: Any, by_cc: Any) -> None:
    """Add the gradient by what is asked for to `by_cc` (n,), from that by what acts (n substeps,): the adjoint."""
    s, by_end = w.substeps, 0.0
    for i in range(by_cc.size - 1, -1, -1):
        whole, of_way = by_cc[i], w.left * by_end
        for q in range(s - 1, -1, -1):
            whole += by_acting[s * i + q]
            of_way += w.late[q] * by_acting[s * i + q]
        by_cc[i] = whole + by_end - of_way
        by_end = of_way


@entry_point
def follow(step: Any, w: Window, first: int, start: Any, cc: Any, power: Any, states: Any) -> None:
    """Write the states at every model step from interval `first` on into `states` (n substeps + 1, m).

    `cc` (n substeps,) is the coupling that acts in each model step, see `acting`; `power` (n,) that of the generator.
    """
    u, s = np.empty(2), w.substeps
    states[0, :] = start
    for i in range(power.size):
        u[1] = power[i]
        for q in range(s * i, s * (i + 1)):
            u[0] = cc[q]
            at = w.width * (s * first + q)
            step(states[q], u, w.moments[at : at + 2 * w.width], w.h, w.k, states[q + 1])


def cost_of(w: Window, power: NDArray[np.float64], states: NDArray[np.float64]) -> float:
    """Cost of a plan without gaps from its states (n + 1, m). [J]"""
    ignored = np.zeros(w.start.size)
    gained = 0.5 * w.weights.J4 * (states[-1, FLYWHEEL] ** 2 - w.start[FLYWHEEL] ** 2)
    cost = sum(stage_cost(x, w.weights, 0.0, ignored) for x in states[1:]) - power.sum()
    return float(w.period * cost + terminal_cost(states[-1], w.weights, ignored) + 0.5 * w.closing * gained * gained)


def sizes_of(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Typical size of each state."""
    sizes = np.std(states, axis=0)
    sizes[RING_ANGLE] = 0.3  # the ring angle grows
    return np.asarray(np.maximum(sizes, 1e-6))
