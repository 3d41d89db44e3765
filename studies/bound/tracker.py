"""Following a plan of a whole window: the way back to it, found again every few samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point, source_stamp
from gyroctl.studies.bound import window
from gyroctl.studies.bound.shooting import CC_SCALE
from gyroctl.studies.bound.window import Plan, Window, acting, asked, follow, model_of, sizes_of

LAST, MOVE = 10.0, 0.5
"""Weight of the deviation at the end of the way back, and of moves of the coupling away from the plan."""


class Course(NamedTuple):
    """The part of a plan that is to be reached again."""

    first: int  # control interval in which it begins
    before: float  # coupling that acts when it begins [Nms]
    cc: NDArray[np.float64]  # (n,) [Nms]
    power: NDArray[np.float64]  # (n,) [W]
    states: NDArray[np.float64]  # (n + 1, m)
    sizes: NDArray[np.float64]  # (m,) typical size of each state


def _compiled(stamp: str) -> Callable[..., float]:
    """Compile the deviation from a plan; the stamp makes the cache forget code whose parts have changed."""

    @entry_point
    def strayed(
        step: Any, pullback: Any, w: Window, course: Course, start: Any, cc: Any, states: Any, by_cc: Any
    ) -> float:
        """Deviation from the course, squared and summed; its gradient goes into `by_cc` (n,)."""
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        m, s, n, width = start.size, w.substeps, cc.size, w.width
        u, weight, by_x, by_u = np.empty(2), np.zeros(m), np.zeros(m), np.zeros(2)
        acts, by_acting = np.empty(n * s), np.empty(n * s)
        acting(w, course.before, cc, acts)
        follow(step, w, course.first, start, acts, course.power, states)
        cost = 0.0
        for i in range(n - 1, -1, -1):
            factor = LAST if i == n - 1 else 1.0
            for row in range(m):
                away = (states[s * (i + 1), row] - course.states[i + 1, row]) / course.sizes[row]
                cost += 0.5 * factor * away * away
                weight[row] += factor * away / course.sizes[row]
            u[1] = course.power[i]
            move = cc[i] - course.cc[i]
            cost += 0.5 * MOVE * move * move
            by_cc[i] = MOVE * move
            for q in range(s * (i + 1) - 1, s * i - 1, -1):
                at = width * (s * course.first + q)
                u[0] = acts[q]
                pullback(states[q], u, w.moments[at : at + 2 * width], w.h, w.k, weight, by_x, by_u)
                by_acting[q] = by_u[0]
                weight[:] = by_x
        asked(w, by_acting, by_cc)
        return cost

    return strayed


_strayed = _compiled(source_stamp((__file__, window.__file__)))


class Tracker:
    """Holds the plant to a plan: finds the coupling that brings a state back to it, within the bounds.

    A plan of minutes at pull-out must be held by feedback, and it is nearly bang-bang: where the coupling stands on a
    bound a linear regulator has nothing to move. So the way back is planned as well, some seconds ahead.

    Parameters
    ----------
    plant : Plant
        The device.
    w : Window
        The window.
    plan : Plan
        Its plan.
    horizon : int
        Control intervals looked ahead.
    """

    def __init__(self, plant: Plant, w: Window, plan: Plan, horizon: int = 80) -> None:
        self.w, self.plan, self.horizon = w, plan, horizon
        self.model, self.sizes = model_of(plant), sizes_of(plan.states)
        self.cc = plan.cc.copy()

    def back(self, i: int, x: NDArray[np.float64], before: float, iterations: int = 15) -> NDArray[np.float64]:
        """Return the coupling (horizon,) to ask for from interval `i` on, for the state `x` (m,) there. [Nms]

        `before` is the coupling that acts when the interval begins. [Nms]
        """
        from scipy.optimize import Bounds, minimize

        w, plan = self.w, self.plan
        part = slice(i, min(i + self.horizon, plan.cc.size))
        course = Course(i, before, plan.cc[part], plan.power[part], plan.states[i : part.stop + 1], self.sizes)
        states, by_cc = np.empty((course.cc.size * w.substeps + 1, x.size)), np.empty(course.cc.size)

        def value(z: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
            cost = _strayed(*self.model, w, course, x, z * CC_SCALE, states, by_cc)
            return (cost, by_cc * CC_SCALE) if np.isfinite(cost) else (1e9, np.zeros(z.size))

        bounds = Bounds(0.0, w.cc_max / CC_SCALE)
        options = {"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 10}
        begin = self.cc[part] / CC_SCALE
        found = minimize(value, begin, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
        self.cc[part] = found.x * CC_SCALE
        return self.cc[part]
