"""The whole window at once, with perfect foresight: the most energy that any (cc, cg)(t) found takes from it.

Free are the coupling in every control interval and the generator's power, which is one number for the window (smooth
power) or one per interval (free power). The optimum runs at pull-out, where the device without feedback is unstable:
a plan of minutes can neither be predicted nor differentiated in one piece. So: direct multiple shooting (Bock, Plitt,
IFAC World Congress 1984). The window is cut into pieces of some seconds, the states at the joints are unknowns as well,
and the gaps are closed by an augmented Lagrangian (Nocedal, Wright, Numerical Optimization, ch. 17), whose exact
gradient is the adjoint of the prediction model. The box is left to L-BFGS-B (Byrd, Lu, Nocedal, Zhu, SIAM J. Sci.
Comput. 16 (1995) 1190-1208). There are very many local optima: what is found depends on the start, and a plan of the
receding horizon (`beam.py`) is a good one.

    cost = - energy generated - stored energy at the end (flywheel, and a share of the float's)
           + integral of motion beyond its limits, squared
           + difference of the flywheel's energy between the end and the start, squared

The last term is what pins the power: 1 J in the flywheel and 1 J generated are worth the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.prediction import constants, orders_of, pullback_of, step_of
from gyroctl.controllers.nmpc.problem import FLYWHEEL, Weights, stage_cost, terminal_cost
from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point
from gyroctl.plant.equations import OMEGA
from gyroctl.plant.kernel import TAPS, interpolate

SUBSTEPS = 4
"""Model steps in a control interval: finer than those of a controller, which looks at the plant again every 0.1 s."""

PIECE = 50
"""Control intervals between two joints."""

POWER_SCALE, CC_SCALE = 10.0, 0.1
"""Of the unknowns: the optimiser's curvature is poor where they differ in size. [W], [Nms]"""

_stage = entry_point(stage_cost)
_terminal = entry_point(terminal_cost)
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


@dataclass(frozen=True)
class Plan:
    """Controls of a window and where they lead.

    Parameters
    ----------
    cc : (n,) array
        Coupling. [Nms]
    power : (n,) array
        Generator power. [W]
    states : (n + 1, m) array
        States of the model, without omega.
    cost : float
        Of the problem above. [J]
    gap : float
        Largest gap at a joint, as a part of the typical size of each state. [-]
    iterations : int
        Of the optimiser.
    """

    cc: NDArray[np.float64]
    power: NDArray[np.float64]
    states: NDArray[np.float64]
    cost: float
    gap: float = 0.0
    iterations: int = 0


def reduced(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """State of the prediction model from that of the plant: omega, which is cyclic, is left out."""
    return np.delete(np.asarray(x, float), OMEGA, axis=-1)


def window(
    plant: Plant,
    start: NDArray[np.float64],
    moments: NDArray[np.float64],
    dt: float,
    intervals: int,
    weights: Weights,
    period: float = 0.1,
    at: float = 0.0,
    substeps: int = SUBSTEPS,
    cc_max: float = 0.3,
    power_max: float = 80.0,
    closing: float = 5e-4,
) -> Window:
    """Set up a window.

    Parameters
    ----------
    plant : Plant
        The device.
    start : (m,) array
        State of the plant at the start.
    moments : (2, samples) array
        Moments on their grid. [Nm]
    dt : float
        Their spacing. [s]
    intervals : int
        Control intervals.
    weights : Weights
        Of the limits, see `gyroctl.controllers.nmpc.problem.weights`.
    period : float
        Control interval. [s]
    at : float
        Time of the start on the grid of the moments. [s]
    substeps : int
        Model steps in a control interval.
    cc_max, power_max : float
        Limits of the controls. [Nms], [W]
    closing : float
        Weight of the flywheel's change of energy, squared. [1/J]
    """
    h = period / substeps
    flat = np.ascontiguousarray(moments.T).ravel()
    sampled = _sample(flat, at / dt, h / dt, intervals * substeps + 1)
    return Window(
        reduced(start), sampled, substeps, period, np.array([h]), constants(plant), weights, closing, cc_max, power_max
    )


@entry_point
def _sample(flat: Any, first: float, spacing: float, count: int) -> Any:
    """Moments at `count` points, interpolated as the plant's kernel does."""
    out, weight = np.empty(2 * count), np.empty(TAPS)
    for i in range(count):
        _interpolate(flat, 1, first + i * spacing, weight, out, i)
    return out


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


@entry_point
def shoot(
    step: Any,
    pullback: Any,
    w: Window,
    cc: Any,
    power: Any,
    nodes: Any,
    piece: int,
    scale: Any,
    multipliers: Any,
    rho: float,
    states: Any,
    by_cc: Any,
    by_power: Any,
    by_nodes: Any,
) -> tuple[float, float]:
    """Augmented Lagrangian of a plan and its gradient.

    Parameters
    ----------
    step, pullback : cfunc
        See `prediction`.
    w : Window
        The window.
    cc, power : (n,) arrays
        The plan. [Nms], [W]
    nodes : (pieces, m) array
        State at the start of each piece; the first is given.
    piece : int
        Control intervals in a piece.
    scale : (m,) array
        Typical size of each state.
    multipliers : (pieces, m) array
        Of the gaps before each piece; the first row is not used. [J]
    rho : float
        Weight of the gaps, squared. [J]
    states : (piece substeps + 1, m) array
        Working space.
    by_cc, by_power, by_nodes : arrays
        Gradients, overwritten.

    Returns
    -------
    tuple of float
        Cost of the plan alone, and with the terms of the gaps. [J]
    """
    m, s, n = w.start.size, w.substeps, cc.size
    u, weight, by_x, by_u = np.empty(2), np.zeros(m), np.zeros(m), np.zeros(2)
    cost, gaps = 0.0, 0.0
    by_nodes[:, :] = 0.0
    for p in range(nodes.shape[0]):
        a, b = p * piece, min(n, (p + 1) * piece)
        follow(step, w, a, nodes[p], cc[a:b], power[a:b], states)
        end = states[s * (b - a)]
        weight[:] = 0.0
        if b == n:
            gained = 0.5 * w.weights.J4 * (end[FLYWHEEL] ** 2 - w.start[FLYWHEEL] ** 2)
            cost += _terminal(end, w.weights, weight) + 0.5 * w.closing * gained * gained
            weight[FLYWHEEL] += w.closing * gained * w.weights.J4 * end[FLYWHEEL]
        else:
            for row in range(m):
                gap = (end[row] - nodes[p + 1, row]) / scale[row]
                gaps += multipliers[p + 1, row] * gap + 0.5 * rho * gap * gap
                pull = (multipliers[p + 1, row] + rho * gap) / scale[row]
                weight[row] += pull
                by_nodes[p + 1, row] -= pull
        for i in range(b - 1, a - 1, -1):
            by_x[:] = 0.0
            cost += w.period * (_stage(states[s * (i - a + 1)], w.weights, by_x) - power[i])
            for row in range(m):
                weight[row] += w.period * by_x[row]
            u[0], u[1] = cc[i], power[i]
            by_cc[i], by_power[i] = 0.0, -w.period
            for q in range(s * (i + 1) - 1, s * i - 1, -1):
                pullback(states[q - s * a], u, w.moments[2 * q : 2 * q + 4], w.h, w.k, weight, by_x, by_u)
                by_cc[i] += by_u[0]
                by_power[i] += by_u[1]
                weight[:] = by_x
        for row in range(m):
            by_nodes[p, row] += weight[row]
    return cost, cost + gaps


def optimise(
    plant: Plant,
    w: Window,
    start: Plan,
    smooth: bool = True,
    rounds: int = 6,
    iterations: int = 200,
    rho: float = 30.0,
    tick: Callable[[], None] | None = None,
) -> Plan:
    """Improve a plan of a window.

    Parameters
    ----------
    plant : Plant
        The device.
    w : Window
        The window.
    start : Plan
        Where to start.
    smooth : bool
        One power for the window, the mean of the start; else one per interval.
    rounds, iterations : int
        Of the augmented Lagrangian, and of L-BFGS-B in each at most.
    rho : float
        Weight of the gaps in the first round; doubled in each. [J]
    tick : callable, optional
        Called after each round.

    Returns
    -------
    Plan
        With its gap: a plan with gaps is no plan, until it has been followed by the true plant.
    """
    from scipy.optimize import Bounds, minimize

    step, pullback = step_of(orders_of(plant)), pullback_of(orders_of(plant))
    n, m = w.intervals, w.start.size
    pieces = -(-n // PIECE)
    states = np.empty((PIECE * w.substeps + 1, m))
    by_cc, by_power, by_nodes = np.empty(n), np.empty(n), np.empty((pieces, m))
    scale = sizes_of(start.states)
    powers = 1 if smooth else n
    multipliers = np.zeros((pieces, m))
    cost = start.cost

    def unpack(z: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        nodes = np.vstack([w.start, (z[n + powers :].reshape(pieces - 1, m)) * scale + origin])
        return z[:n] * CC_SCALE, np.broadcast_to(z[n : n + powers] * POWER_SCALE, n).copy(), nodes

    def value(z: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        nonlocal cost
        cc, power, nodes = unpack(z)
        cost, total = shoot(
            step, pullback, w, cc, power, nodes, PIECE, scale, multipliers, weight, states, by_cc, by_power, by_nodes
        )
        if not np.isfinite(total):  # the line search comes nearer again
            return 1e9, np.zeros(z.size)
        of_power = np.array([by_power.sum()]) if smooth else by_power
        return total, np.concatenate([by_cc * CC_SCALE, of_power * POWER_SCALE, (by_nodes[1:] * scale).ravel()])

    origin = start.states[PIECE:n:PIECE].copy()  # unknowns are the deviations from the start
    z = np.concatenate(
        [
            np.clip(start.cc, 0.0, w.cc_max) / CC_SCALE,
            (np.array([start.power.mean()]) if smooth else start.power) / POWER_SCALE,
            np.zeros((pieces - 1) * m),
        ]
    )
    top = np.concatenate([np.full(n, w.cc_max / CC_SCALE), np.full(powers, w.power_max / POWER_SCALE)])
    free = np.full((pieces - 1) * m, np.inf)
    bounds = Bounds(np.concatenate([np.zeros(n + powers), -free]), np.concatenate([top, free]))
    weight, done = rho, 0
    for _ in range(rounds):
        found = minimize(
            value,
            z,
            jac=True,
            method="L-BFGS-B",
            bounds=bounds,
            options={"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 20, "ftol": 1e-9, "gtol": 1e-5},
        )
        z, done = found.x, done + int(found.nit)
        gaps = _gaps(step, w, *unpack(z), states) / scale
        multipliers[1:] += weight * gaps
        weight *= 2.0
        if tick:
            tick()
    value(z)
    cc, power, nodes = unpack(z)
    return Plan(cc, power, _path(step, w, cc, power, nodes, states), float(cost), float(np.abs(gaps).max()), done)


def _gaps(step: Any, w: Window, cc: Any, power: Any, nodes: Any, states: Any) -> NDArray[np.float64]:
    gaps = np.empty((len(nodes) - 1, w.start.size))
    for p in range(len(nodes) - 1):
        part = slice(p * PIECE, (p + 1) * PIECE)
        follow(step, w, part.start, nodes[p], cc[part], power[part], states)
        gaps[p] = states[PIECE * w.substeps] - nodes[p + 1]
    return gaps


def _path(step: Any, w: Window, cc: Any, power: Any, nodes: Any, states: Any) -> NDArray[np.float64]:
    """States at every interval, piece by piece."""
    path = np.empty((cc.size + 1, w.start.size))
    for p, node in enumerate(nodes):
        a, b = p * PIECE, min(cc.size, (p + 1) * PIECE)
        follow(step, w, a, node, cc[a:b], power[a:b], states)
        path[a : b + 1] = states[: (b - a) * w.substeps + 1 : w.substeps]
    return path


def cost_of(w: Window, power: NDArray[np.float64], states: NDArray[np.float64]) -> float:
    """Cost of a plan without gaps from its states (n + 1, m). [J]"""
    ignored = np.zeros(w.start.size)
    gained = 0.5 * w.weights.J4 * (states[-1, FLYWHEEL] ** 2 - w.start[FLYWHEEL] ** 2)
    cost = sum(stage_cost(x, w.weights, ignored) for x in states[1:]) - power.sum()
    return float(w.period * cost + terminal_cost(states[-1], w.weights, ignored) + 0.5 * w.closing * gained * gained)


def sizes_of(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Typical size of each state."""
    sizes = np.std(states, axis=0)
    sizes[2] = 0.3  # the ring angle grows
    return np.asarray(np.maximum(sizes, 1e-6))
