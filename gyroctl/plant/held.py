"""Moments that are too dear for every stage: new every 10 ms, in between on the line through their last two values.

They are to be a small rest of the moments that the stages know, since a value that is held acts late. A model of them
is a NamedTuple with a method ``moments(fields, t, x, L, l) -> R1, R3``: its signals of the realisation, the time [s],
the state of run `l` out of `L` as `equations.derivative` has it; the moments on phi1 and phi3 [Nm].
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import overload
from numpy.typing import NDArray

from gyroctl.plant.compiled import INLINED, inlined

EVERY = 0.01
"""Least time between two evaluations, which take place at the beginning of a Runge-Kutta step; that of a device of the
size of Table 1. [s]"""


class Held(NamedTuple):
    """Held moments of runs side by side."""

    model: Any
    fields: Any  # what the model needs of the realisation
    last: NDArray[np.float64]  # (4 L + 2,) R1 and R3 before, R1 and R3 now [Nm], their two times [s]
    every: float = EVERY  # least time between two evaluations [s]

    @classmethod
    def begun(cls, model: Any, fields: Any, runs: int, every: float = EVERY) -> Held:
        """Return the moments before the first evaluation of so many runs, at least `every` [s] apart."""
        return cls(model, fields, np.full(4 * runs + 2, np.nan), every)


def moments_of(model: Any, fields: Any, t: Any, x: Any, L: int, l: int) -> Any:
    """R1, R3 of a model [Nm]: its method, which compiled callers find by the model's type."""
    return model.moments(fields, t, x, L, l)


@inlined
def renew(held: Any, t: float, x: Any, L: int) -> None:
    """Evaluate the moments at the beginning of a step where it is time to."""
    if held is not None:
        last, now = held.last, 4 * L + 1
        if not t - last[now] < held.every - 1e-9:  # true before the first evaluation too, when the time is no number
            first = not last[now] <= t
            for l in range(L):
                last[l], last[L + l] = last[2 * L + l], last[3 * L + l]
                last[2 * L + l], last[3 * L + l] = moments_of(held.model, held.fields, t, x, L, l)
                if first:
                    last[l], last[L + l] = last[2 * L + l], last[3 * L + l]
            last[now - 1] = t - held.every if first else last[now]
            last[now] = t


@inlined
def extrapolate(held: Any, t: float, L: int, out: Any, at: int) -> None:
    """Write R1 and R3 of all runs at time `t` [s] into `out` from `at` on."""
    if held is not None:
        last, now = held.last, 4 * L + 1
        ahead = (t - last[now]) / (last[now] - last[now - 1])
        for lane in range(2 * L):
            out[at + lane] = last[2 * L + lane] + ahead * (last[2 * L + lane] - last[lane])


def _moments_of(model: Any, fields: Any, t: Any, x: Any, L: int, l: int) -> Any:
    if not isinstance(model, types.BaseNamedTuple):
        return None
    method = _compiled(model.instance_class)
    return lambda model, fields, t, x, L, l: method(model, fields, t, x, L, l)


@lru_cache(maxsize=16)
def _compiled(kind: Any) -> Any:
    return njit(**INLINED)(kind.moments)


overload(moments_of, strict=False)(_moments_of)
