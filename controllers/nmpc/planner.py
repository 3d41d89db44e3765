"""One call per sample: the problem of the moment from flat arrays, and the solver's iterations on it.

A tuple with two dozen fields takes longer to hand to compiled code than the iterations take, and a function pointer
almost as long; so both are bound here, once, and what changes from sample to sample comes as plain arrays.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.descent import descend
from gyroctl.controllers.nmpc.prediction import Orders, pullback_of, step_of
from gyroctl.controllers.nmpc.problem import Problem, Weights

FIELDS = len(Weights._fields)


@lru_cache(maxsize=4)
def planner_of(orders: Orders) -> Any:
    """Compile ``plan(start, moments, now, weights, h, k, cc, length, iterations)`` for filters of these orders.

    `now` holds power [W], last coupling, its limit [Nms] and the control interval [s]; `weights` the fields of
    `Weights`; the rest is as in `Problem` and `descend`, whose answer comes back.
    """
    step, pullback = step_of(orders), pullback_of(orders)

    @njit(nogil=True)  # type: ignore[untyped-decorator]
    def plan(
        start: NDArray[np.float64], moments: NDArray[np.float64], now: NDArray[np.float64],
        weights: NDArray[np.float64], h: NDArray[np.float64], k: NDArray[np.float64], cc: NDArray[np.float64],
        length: float, iterations: int,
    ) -> Any:  # fmt: skip
        cost = Weights(*to_fixed_tuple(weights, FIELDS))
        problem = Problem(start, moments, now[0], now[1], now[2], now[3], h, k, cost)
        return descend(step, pullback, problem, cc, length, iterations)

    return plan
