"""Plan by projected gradients: the structure of the problem is all in the adjoint, the box is a clip.

The optimum is nearly bang-bang, on the bounds in most intervals, where second-order models of the cost have little to
say and the projection finds the active set at once. Steps after Barzilai and Borwein (IMA J. Numer. Anal. 8 (1988)
141-148), projected as in Birgin, Martinez, Raydan (SIAM J. Optim. 10 (2000) 1196-1211), each accepted only if the cost
falls: the cost never rises, so any number of iterations gives a plan no worse than the shifted last one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gyroctl.controllers.nmpc import solvers
from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.controllers.nmpc.problem import Problem, gradient, predict
from gyroctl.plant.compiled import entry_point, source_stamp

LENGTH_MIN, LENGTH_MAX = 1e-8, 1.0  # of a step along the gradient [(Nms)^2/J]


def _descend(stamp: str) -> Any:
    @entry_point
    def descend(
        step: Any, pullback: Any, problem: Problem, cc: Any, length: float, iterations: int
    ) -> tuple[float, float, float]:
        """Improve the plan `cc` (n,) [Nms] in place by so many gradient steps, the first of `length` [(Nms)^2/J].

        `step` and `pullback` come from `prediction`. Returned are the cost before and after [J], and the step length
        to go on with.
        """
        assert stamp
        n = cc.size
        shape = (STEPS * n + 1, problem.start.size)
        states, ahead = np.empty(shape), np.empty(shape)
        slope, new_slope, trial = np.empty(n), np.empty(n), np.empty(n)
        for i in range(n):
            cc[i] = min(max(cc[i], 0.0), problem.cc_max)
        first = predict(step, problem, cc, states)
        cost = first
        gradient(pullback, problem, cc, states, slope)
        for _ in range(iterations):
            for i in range(n):
                trial[i] = min(max(cc[i] - length * slope[i], 0.0), problem.cc_max)
            found = predict(step, problem, trial, ahead)
            if not found < cost:  # not a number counts as no improvement
                length = max(0.3 * length, LENGTH_MIN)
                continue
            gradient(pullback, problem, trial, ahead, new_slope)
            square, product = 0.0, 0.0
            for i in range(n):
                move = trial[i] - cc[i]
                square += move * move
                product += move * (new_slope[i] - slope[i])
                cc[i], slope[i] = trial[i], new_slope[i]
            wanted = square / product if product > 0.0 else 2.0 * length
            length = min(max(wanted, 0.3 * length, LENGTH_MIN), 4.0 * length, LENGTH_MAX)
            cost = found
        return first, cost, length

    return descend


SOURCES = solvers.SOURCES
descend = _descend(source_stamp(SOURCES))
