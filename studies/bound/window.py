"""A window as a planning problem, and a plan of it, followed by the prediction model.

    cost = - energy generated - stored energy at the end (flywheel, and a share of the float's)
           + integral of motion beyond its limits, squared
           + difference of the flywheel's energy between the end and the start, squared

The last term is what pins the power: 1 J in the flywheel and 1 J generated are worth the same.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.prediction import constants, linear_kind, pullback_of, step_of
from gyroctl.controllers.nmpc.problem import FLYWHEEL, RING_ANGLE, Weights, stage_cost, terminal_cost
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

    start: NDArray[np.float64]  # state without omega
    moments: NDArray[np.float64]  # (2 (n substeps + 1),): Me1, Me3 at each model step [Nm]
    substeps: int
    period: float  # control interval [s]
    h: NDArray[np.float64]  # (1,) model step [s]
    k: NDArray[np.float64]  # constants of the model
    weights: Weights
    closing: float  # weight of the flywheel's change of energy, squared [1/J]
    cc_max: float  # [Nms]
    power_max: float  # [W]

    @property
    def intervals(self) -> int:
        """Control intervals."""
        return (self.moments.size // 2 - 1) // self.substeps


class Plan(NamedTuple):
    """Controls of a window and where they lead."""

    cc: NDArray[np.float64]  # (n,) coupling [Nms]
    power: NDArray[np.float64]  # (n,) of the generator [W]
    states: NDArray[np.float64]  # (n + 1, m) states of the model, without omega


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
    actuators, waves = cut.settings.actuators, cut.waves
    h = actuators.period / substeps
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    moments = _sample(flat, 0.0, h / waves.dt, intervals * substeps + 1)
    model = np.array([h]), constants(cut.plant), weights, closing
    speed = cut.plant.parameters.N * waves.sea.wp
    limits = actuators.cc_max, 0.7 * actuators.cg_max * speed**2
    return Window(reduced(cut.start), moments, substeps, actuators.period, *model, *limits)


def reduced(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """State of the prediction model from that of the plant: omega, which is cyclic, is left out."""
    return np.delete(np.asarray(x, float), OMEGA, axis=-1)


@entry_point
def _sample(flat: Any, first: float, spacing: float, count: int) -> Any:
    """Moments at `count` points, interpolated as the plant's kernel does."""
    out, weight = np.empty(2 * count), np.empty(TAPS)
    for i in range(count):
        _interpolate(flat, 1, first + i * spacing, weight, out, i)
    return out


def model_of(plant: Plant) -> tuple[Any, Any]:
    """Compiled step and pullback of the prediction model, see `prediction`."""
    kind = linear_kind(plant)
    return step_of(kind), pullback_of(kind)


@entry_point
def follow(step: Any, w: Window, first: int, start: Any, cc: Any, power: Any, states: Any) -> None:
    """Write the states at every model step from interval `first` on into `states` (len(cc) substeps + 1, m)."""
    u, s = np.empty(2), w.substeps
    states[0, :] = start
    for i in range(cc.size):
        u[0], u[1] = cc[i], power[i]
        for q in range(s * i, s * (i + 1)):
            at = 2 * (s * first + q)
            step(states[q], u, w.moments[at : at + 4], w.h, w.k, states[q + 1])


def cost_of(w: Window, power: NDArray[np.float64], states: NDArray[np.float64]) -> float:
    """Cost of a plan without gaps from its states (n + 1, m). [J]"""
    ignored = np.zeros(w.start.size)
    gained = 0.5 * w.weights.J4 * (states[-1, FLYWHEEL] ** 2 - w.start[FLYWHEEL] ** 2)
    cost = sum(stage_cost(x, w.weights, ignored) for x in states[1:]) - power.sum()
    return float(w.period * cost + terminal_cost(states[-1], w.weights, ignored) + 0.5 * w.closing * gained * gained)


def sizes_of(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Typical size of each state."""
    sizes = np.std(states, axis=0)
    sizes[RING_ANGLE] = 0.3  # the ring angle grows
    return np.asarray(np.maximum(sizes, 1e-6))
