"""Following a plan of a whole window: the way back to it, found again every few samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.prediction import orders_of, pullback_of, step_of
from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point, source_stamp
from gyroctl.studies.bound import full_horizon
from gyroctl.studies.bound.full_horizon import CC_SCALE, Plan, Window, follow, sizes_of


def _compiled(stamp: str) -> Callable[..., float]:
    """Compile the deviation from a plan; the stamp makes the cache forget code whose parts have changed."""

    @entry_point
    def strayed(
        step: Any,
        pullback: Any,
        w: Window,
        first: int,
        start: Any,
        cc: Any,
        power: Any,
        wanted: Any,
        sizes: Any,
        final: float,
        price: float,
        planned: Any,
        states: Any,
        by_cc: Any,
    ) -> float:
        """Deviation from the wanted states (n + 1, m), squared and summed; its gradient goes into `by_cc` (n,)."""
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        m, s, n = start.size, w.substeps, cc.size
        u, weight, by_x, by_u = np.empty(2), np.zeros(m), np.zeros(m), np.zeros(2)
        follow(step, w, first, start, cc, power, states)
        cost = 0.0
        for i in range(n - 1, -1, -1):
            factor = final if i == n - 1 else 1.0
            for row in range(m):
                away = (states[s * (i + 1), row] - wanted[i + 1, row]) / sizes[row]
                cost += 0.5 * factor * away * away
                weight[row] += factor * away / sizes[row]
            u[0], u[1] = cc[i], power[i]
            move = cc[i] - planned[i]
            cost += 0.5 * price * move * move
            by_cc[i] = price * move
            for q in range(s * (i + 1) - 1, s * i - 1, -1):
                at = 2 * (s * first + q)
                pullback(states[q], u, w.moments[at : at + 4], w.h, w.k, weight, by_x, by_u)
                by_cc[i] += by_u[0]
                weight[:] = by_x
        return cost

    return strayed


_strayed = _compiled(source_stamp((__file__, full_horizon.__file__)))


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
        self.step, self.pullback = step_of(orders_of(plant)), pullback_of(orders_of(plant))
        self.sizes = sizes_of(plan.states)
        self.cc = plan.cc.copy()

    def back(self, i: int, x: NDArray[np.float64], iterations: int = 15) -> NDArray[np.float64]:
        """Return the coupling (horizon,) from interval `i` on for the state `x` (m,) there. [Nms]"""
        from scipy.optimize import Bounds, minimize

        part = slice(i, min(i + self.horizon, self.plan.cc.size))
        planned, power, wanted = self.plan.cc[part], self.plan.power[part], self.plan.states[i : part.stop + 1]
        states, by_cc = np.empty((planned.size * self.w.substeps + 1, x.size)), np.empty(planned.size)

        def value(z: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
            cost = _strayed(
                self.step,
                self.pullback,
                self.w,
                i,
                x,
                z * CC_SCALE,
                power,
                wanted,
                self.sizes,
                10.0,
                0.5,
                planned,
                states,
                by_cc,
            )
            return (cost, by_cc * CC_SCALE) if np.isfinite(cost) else (1e9, np.zeros(z.size))

        found = minimize(
            value,
            self.cc[part] / CC_SCALE,
            jac=True,
            method="L-BFGS-B",
            bounds=Bounds(0.0, self.w.cc_max / CC_SCALE),
            options={"maxiter": iterations, "maxfun": 2 * iterations, "maxcor": 10},
        )
        self.cc[part] = found.x * CC_SCALE
        return self.cc[part]
