"""The whole window at once, with perfect foresight: the most energy that any (cc, cg)(t) found takes from it.

Free are the coupling in every control interval and the generator's power, which is one number for the window (smooth
power) or one per interval (free power). The optimum runs at pull-out, where the device without feedback is unstable:
a plan of minutes can neither be predicted nor differentiated in one piece. So: direct multiple shooting (Bock, Plitt,
IFAC World Congress 1984). The window is cut into pieces of some seconds, the states at the joints are unknowns as well,
and the gaps are closed by an augmented Lagrangian (Nocedal, Wright, Numerical Optimization, ch. 17), whose exact
gradient is the adjoint of the prediction model. The box is left to L-BFGS-B (Byrd, Lu, Nocedal, Zhu, SIAM J. Sci.
Comput. 16 (1995) 1190-1208). There are very many local optima: what is found depends on the start, and a plan of the
receding horizon (`starts.py`) is a good one. The cost is that of `window.py`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.problem import FLYWHEEL, stage_cost, terminal_cost
from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point
from gyroctl.studies.bound.window import Plan, Window, acting, asked, follow, model_of, sizes_of

PIECE = 50
"""Control intervals between two joints."""

POWER_SCALE, CC_SCALE = 10.0, 0.1
"""Of the unknowns: the optimiser's curvature is poor where they differ in size. [W], [Nms]"""

_stage = entry_point(stage_cost)
_terminal = entry_point(terminal_cost)


class Joints(NamedTuple):
    """How a plan is cut into pieces, and what its gaps cost."""

    piece: int  # control intervals in a piece
    scale: NDArray[np.float64]  # (m,) typical size of each state
    multipliers: NDArray[np.float64]  # (pieces, m) of the gaps before each piece; the first row is not used [J]
    rho: float  # weight of the gaps, squared [J]


class Slopes(NamedTuple):
    """Gradient of the augmented Lagrangian."""

    cc: NDArray[np.float64]  # (n,) [J/(Nms)]
    power: NDArray[np.float64]  # (n,) [J/W]
    nodes: NDArray[np.float64]  # (pieces, m)


@entry_point
def shoot(
    step: Any, pullback: Any, w: Window, cc: Any, power: Any, nodes: Any, joints: Joints, slopes: Slopes, states: Any
) -> float:
    """Augmented Lagrangian of a plan [J] and its gradient.

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
    joints : Joints
        How the gaps count.
    slopes : Slopes
        Overwritten.
    states : (piece substeps + 1, m) array
        Working space.
    """
    m, s, n, width = w.start.size, w.substeps, cc.size, w.width
    u, weight, by_x, by_u = np.empty(2), np.zeros(m), np.zeros(m), np.zeros(2)
    acts, by_acting = np.empty(n * s), np.empty(n * s)
    acting(w, w.before, cc, acts)
    cost, gaps = 0.0, 0.0
    slopes.nodes[:, :], slopes.cc[:] = 0.0, 0.0
    for p in range(nodes.shape[0]):
        a, b = p * joints.piece, min(n, (p + 1) * joints.piece)
        follow(step, w, a, nodes[p], acts[s * a : s * b], power[a:b], states)
        end = states[s * (b - a)]
        weight[:] = 0.0
        if b == n:
            gained = 0.5 * w.weights.J4 * (end[FLYWHEEL] ** 2 - w.start[FLYWHEEL] ** 2)
            cost += _terminal(end, w.weights, weight) + 0.5 * w.closing * gained * gained
            weight[FLYWHEEL] += w.closing * gained * w.weights.J4 * end[FLYWHEEL]
        else:
            for row in range(m):
                gap = (end[row] - nodes[p + 1, row]) / joints.scale[row]
                gaps += joints.multipliers[p + 1, row] * gap + 0.5 * joints.rho * gap * gap
                pull = (joints.multipliers[p + 1, row] + joints.rho * gap) / joints.scale[row]
                weight[row] += pull
                slopes.nodes[p + 1, row] -= pull
        for i in range(b - 1, a - 1, -1):
            by_x[:] = 0.0
            cost += w.period * (_stage(states[s * (i - a + 1)], w.weights, 0.0, by_x) - power[i])
            for row in range(m):
                weight[row] += w.period * by_x[row]
            u[1], slopes.power[i] = power[i], -w.period
            for q in range(s * (i + 1) - 1, s * i - 1, -1):
                u[0], given = acts[q], w.moments[width * q : width * (q + 2)]
                pullback(states[q - s * a], u, given, w.h, w.k, weight, by_x, by_u)
                by_acting[q] = by_u[0]
                slopes.power[i] += by_u[1]
                weight[:] = by_x
        for row in range(m):
            slopes.nodes[p, row] += weight[row]
    asked(w, by_acting, slopes.cc)
    return cost + gaps


def optimise(
    plant: Plant, w: Window, start: Plan, smooth: bool, rounds: int, iterations: int, rho: float = 30.0
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

    Returns
    -------
    Plan
        A plan with gaps is no plan, until it has been followed by the true plant.
    """
    from scipy.optimize import Bounds, minimize

    step, pullback = model_of(plant)
    n, m = w.intervals, w.start.size
    pieces, powers = -(-n // PIECE), 1 if smooth else n
    joints = Joints(PIECE, sizes_of(start.states), np.zeros((pieces, m)), rho)
    slopes = Slopes(np.empty(n), np.empty(n), np.empty((pieces, m)))
    states = np.empty((PIECE * w.substeps + 1, m))
    origin = start.states[PIECE:n:PIECE].copy()  # unknowns are the deviations from the start

    def unpack(z: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        nodes = np.vstack([w.start, (z[n + powers :].reshape(pieces - 1, m)) * joints.scale + origin])
        return z[:n] * CC_SCALE, np.broadcast_to(z[n : n + powers] * POWER_SCALE, n).copy(), nodes

    def value(z: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        total = shoot(step, pullback, w, *unpack(z), joints, slopes, states)
        if not np.isfinite(total):  # the line search comes nearer again
            return 1e9, np.zeros(z.size)
        of_power = np.array([slopes.power.sum()]) if smooth else slopes.power
        of_nodes = (slopes.nodes[1:] * joints.scale).ravel()
        return total, np.concatenate([slopes.cc * CC_SCALE, of_power * POWER_SCALE, of_nodes])

    power = np.array([start.power.mean()]) if smooth else start.power
    free = np.full((pieces - 1) * m, np.inf)
    z = np.concatenate([np.clip(start.cc, 0.0, w.cc_max) / CC_SCALE, power / POWER_SCALE, np.zeros(free.size)])
    top = np.concatenate([np.full(n, w.cc_max / CC_SCALE), np.full(powers, w.power_max / POWER_SCALE), free])
    bounds = Bounds(np.concatenate([np.zeros(n + powers), -free]), top)
    options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 20, "ftol": 1e-9, "gtol": 1e-5}
    for _ in range(rounds):
        z = minimize(value, z, jac=True, method="L-BFGS-B", bounds=bounds, options=options).x
        gaps = _gaps(step, w, *unpack(z), states) / joints.scale
        joints.multipliers[1:] += joints.rho * gaps
        joints = joints._replace(rho=2.0 * joints.rho)
    cc, power, nodes = unpack(z)
    return Plan(cc, power, _path(step, w, cc, power, nodes, states))


def _gaps(step: Any, w: Window, cc: Any, power: Any, nodes: Any, states: Any) -> NDArray[np.float64]:
    gaps, acts = np.empty((len(nodes) - 1, w.start.size)), _acts(w, cc)
    for p in range(len(nodes) - 1):
        part = slice(p * PIECE, (p + 1) * PIECE)
        follow(step, w, part.start, nodes[p], acts[part].ravel(), power[part], states)
        gaps[p] = states[PIECE * w.substeps] - nodes[p + 1]
    return gaps


def _path(step: Any, w: Window, cc: Any, power: Any, nodes: Any, states: Any) -> NDArray[np.float64]:
    """States at every interval, piece by piece."""
    path, acts = np.empty((cc.size + 1, w.start.size)), _acts(w, cc)
    for p, node in enumerate(nodes):
        a, b = p * PIECE, min(cc.size, (p + 1) * PIECE)
        follow(step, w, a, node, acts[a:b].ravel(), power[a:b], states)
        path[a : b + 1] = states[: (b - a) * w.substeps + 1 : w.substeps]
    return path


def _acts(w: Window, cc: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coupling that acts in each model step, (n, substeps). [Nms]"""
    acts = np.empty(cc.size * w.substeps)
    acting(w, w.before, cc, acts)
    return acts.reshape(-1, w.substeps)
