"""Starts of the search over a whole window: receding horizons, and a beam search over receding horizons.

A receding horizon meets one local optimum after another: a turn of the ring is taken or left out, and half a minute
follows from that. So several of them with different habits go on side by side, and the best are kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.controllers.nmpc.problem import FLYWHEEL, Problem
from gyroctl.controllers.nmpc.solvers.descent import descend
from gyroctl.plant import Plant
from gyroctl.studies.bound.window import Plan, Window, acting, cost_of, follow, model_of


class Habit(NamedTuple):
    """How a receding horizon plans."""

    horizon: int = 80  # control intervals looked ahead
    every: int = 2  # and applied before the next plan
    iterations: int = 6  # gradient steps per plan
    cc_max: float = 0.12  # [Nms]
    cc_first: float = 0.05  # guess of the coupling at the far end [Nms]


HABITS = (
    Habit(),
    Habit(cc_max=0.3),
    Habit(horizon=40),
    Habit(horizon=40, cc_max=0.3),
    Habit(cc_first=0.1),
    Habit(horizon=60, cc_first=0.0, cc_max=0.2),
)
"""Habits that end in different local optima."""


class Track(NamedTuple):
    """How far a receding horizon has come."""

    cc: NDArray[np.float64]  # (i,) so far [Nms]
    power: NDArray[np.float64]  # (i,) so far [W]
    states: NDArray[np.float64]  # (i + 1, m) so far
    plan: NDArray[np.float64]  # (horizon,) coupling planned on [Nms]
    length: float  # step length of the solver
    level: float  # integral part of the power command [W]
    value: float  # energy harvested so far, with a share of the float's, less the penalties [J]


def receding(plant: Plant, w: Window, power: float, habit: Habit = HABITS[0]) -> Plan:
    """Plan of the receding horizon over a window: a start for `optimise`.

    The power follows the flywheel: a proportional-integral command about its speed at the start.

    Parameters
    ----------
    plant : Plant
        The device.
    w : Window
        The window.
    power : float
        Generator power to begin with. [W]
    habit : Habit
        How to plan.
    """
    return Plan(*_continued(plant, w, _begun(w, power, habit), habit, w.intervals)[:3])


def beam(plant: Plant, w: Window, power: float, width: int, piece: int, habits: Sequence[Habit] = HABITS) -> list[Plan]:
    """Beam search over the local optima of receding horizons: plans of a window, the best first.

    After each piece every track that was kept goes on with every habit, and of all the best are kept. One unlucky
    choice, a turn of the ring taken or not, is felt for half a minute; a single receding horizon makes many.

    Parameters
    ----------
    plant : Plant
        The device.
    w : Window
        The window.
    power : float
        Generator power to begin with. [W]
    width : int
        Tracks kept.
    piece : int
        Control intervals between two choices.
    habits : sequence of Habit
        How to plan.
    """
    kept = [_begun(w, power, habits[0])]
    for i in range(0, w.intervals, piece):
        tried = [_continued(plant, w, track, habit, min(i + piece, w.intervals)) for track in kept for habit in habits]
        tried = sorted((track for track in tried if np.isfinite(track.value)), key=lambda track: -track.value)
        kept = []
        for track in tried:
            if len(kept) < width and all(abs(track.value - other.value) > 0.2 for other in kept):  # J: no twins
                kept.append(track)
    return [Plan(*track[:3]) for track in kept]


def _begun(w: Window, power: float, habit: Habit) -> Track:
    nothing = np.empty(0)
    return Track(nothing, nothing, w.start[None, :], np.full(habit.horizon, habit.cc_first), 0.01, power, 0.0)


def _continued(plant: Plant, w: Window, track: Track, habit: Habit, until: int) -> Track:
    """Go on with a track up to interval `until`."""
    step, pullback = model_of(plant)
    n, s, begin = w.intervals, w.substeps, track.cc.size
    known = w.moments.reshape(-1, w.width)
    h = np.array([w.period / STEPS])
    cc, used, path = np.empty(until), np.empty(until), np.empty((until + 1, w.start.size))
    cc[:begin], used[:begin], path[: begin + 1] = track.cc, track.power, track.states
    length, level, plan = track.length, track.level, track.plan
    before = float(cc[begin - 1]) if begin else habit.cc_first
    now_acts = acting(w, w.before, track.cc, np.empty(begin * s))  # all the way again: the coupling that has come of it
    for i in range(begin, until, habit.every):
        ahead = min(habit.horizon, n - i)
        plan = np.concatenate([plan, np.full(max(ahead - plan.size, 0), habit.cc_first)])[:ahead]
        error = path[i, FLYWHEEL] - w.start[FLYWHEEL]
        level = max(level + 5e-4 * habit.every * w.period * error, 0.0)
        now = min(max(level + 0.3 * error, 0.3), w.power_max)
        moments = np.ascontiguousarray(known[s * i : s * (i + ahead) + 1 : s // STEPS]).ravel()
        problem = Problem(path[i].copy(), moments, now, before, habit.cc_max, w.period, h, w.k, w.weights, w.width)
        _, _, length = descend(step, pullback, problem, plan, length, habit.iterations if i else 100)
        m = min(habit.every, until - i)
        cc[i : i + m], used[i : i + m] = plan[:m], now
        states, means = np.empty((m * s + 1, w.start.size)), np.empty(m * s)
        now_acts = acting(w, now_acts, cc[i : i + m], means)
        follow(step, w, i, path[i], means, used[i : i + m], states)
        path[i + 1 : i + m + 1] = states[s::s]
        before, plan = float(plan[m - 1]), plan[m:]
    value = -cost_of(w._replace(closing=0.0), used, path)
    return Track(cc, used, path, plan, length, level, value)
