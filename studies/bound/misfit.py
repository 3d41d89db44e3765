"""What the design model misses of the plant along a run, as moments: a plan that is made anew near that run knows them.

The design model guesses what acts on a float that moves, from the moments at rest; the plant follows its wetted
surface. Their difference over each control interval is attributed to two moments that are held over it. That is
iterative learning: run, see what came otherwise than planned, plan again with what was seen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.problem import V1, V3
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.window import Window, acting, follow, model_of, reduced

UNIT = 1.0
"""Moment by which the answer of the model is asked. [Nm]"""

REFINED = 2
"""Steps with that answer after the first one: the model is not linear in the moments, by a few hundredths."""


def missed(plant: Plant, w: Window, record: Record) -> NDArray[np.float64]:
    """Moments (n, 2) that the model of a window lacks in each interval of a run through it. [Nm]"""
    step, _ = model_of(plant)
    n, s, rows = record.commands.shape[0], w.substeps, [V1, V3]
    path = reduced(plant, record.states)
    acts, states = np.empty(n * s), np.empty((s + 1, path.shape[1]))
    acting(w, w.before, record.commands[:, 0].copy(), acts)
    known = w.moments.reshape(-1, w.width)
    found = np.zeros((n, 2))
    for i in range(n):
        power = np.array([record.controls[i, 1] * record.states[i, OMEGA_RATE] ** 2])
        part = known[s * i : s * (i + 1) + 1]

        def ends(more: NDArray[np.float64], i: int = i, part: NDArray[np.float64] = part) -> NDArray[np.float64]:
            held = part.copy()
            held[:, :2] += more
            alone = w._replace(moments=held.ravel())
            follow(step, alone, 0, path[i], acts[s * i : s * (i + 1)], power, states)  # noqa: B023
            return states[s, rows].copy()

        bare = ends(np.zeros(2))
        answer = np.stack([(ends(UNIT * way) - bare) / UNIT for way in np.eye(2)], axis=1)
        found[i] = np.linalg.solve(answer, path[i + 1, rows] - bare)
        for _ in range(REFINED):
            found[i] += np.linalg.solve(answer, path[i + 1, rows] - ends(found[i]))
    return found


def mended(plant: Plant, w: Window, record: Record) -> Window:
    """Return the window with the moments that its model missed in a run; beyond the end of the run they fade."""
    found = missed(plant, w, record)
    middle = w.period * (np.arange(len(found)) + 0.5)
    time = w.h[0] * np.arange(w.moments.size // w.width)
    known = w.moments.reshape(-1, w.width).copy()
    for j in range(2):
        known[:, j] += np.interp(time, middle, found[:, j], right=0.0)
    return w._replace(moments=known.ravel())
