"""One Newton system of the linearised horizon, solved in O(n) by a Riccati recursion: one sweep back, one forth."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.solvers import SOURCES
from gyroctl.controllers.nmpc.solvers.subproblem import OUTPUTS, add_product, add_transposed, transposed_product
from gyroctl.plant.compiled import entry_point, inlined, put, source_stamp

FloatArray = NDArray[np.float64]


class SweepRoom(NamedTuple):
    """Arrays that the solvers work in."""

    low: FloatArray  # (n,)
    high: FloatArray  # (n,)
    slope: FloatArray  # (n,)
    direction: FloatArray  # (n,)
    trial: FloatArray  # (n,)
    barrier: FloatArray  # (n,) curvature which the bounds add
    states: FloatArray  # (n, m)
    ahead: FloatArray  # (n, m)
    slopes: FloatArray  # (n, 3)
    new_slopes: FloatArray  # (n, 3)
    curvature: FloatArray  # (n, 3) of the penalties
    gain: FloatArray  # (n, m + 2): by the state, by the coupling before, constant
    held: NDArray[np.bool_]  # (n,)


@inlined
def empty_sweep_room(n: int, m: int) -> SweepRoom:
    """Room for a horizon of `n` intervals of a model with `m` states."""
    new = np.zeros
    couplings = new(n), new(n), new(n), new(n), new(n), new(n)
    states = new((n, m)), new((n, m))
    outputs = new((n, 3)), new((n, 3)), new((n, 3))
    return SweepRoom(*couplings, *states, *outputs, new((n, m + 2)), np.zeros(n, np.bool_))


def _sweep(stamp: str) -> Callable[..., bool]:
    """Compile the sweep; the stamp is as in `subproblem`."""

    @entry_point
    def sweep(qp: Any, proximal: float, room: Any) -> bool:
        """Solve the linear-quadratic problem about the present point; return whether it is convex.

        Read are `room.slope`, `room.curvature` of the outputs, `room.barrier` of the couplings, `room.held` and, for
        the held couplings, `room.direction`; written is `room.direction` of the others, and the states it leads to in
        `room.ahead`. The cost to go, with l the change before, is 1/2 e'Pe + l c'e + 1/2 gamma l^2 + v'e + nu l. The
        pivots are those of the Hessian by the free couplings: all are positive where it is convex.
        """
        assert stamp
        n, m = qp.b.shape
        p, w, c, v = np.zeros((m, m)), np.zeros((m, m)), np.zeros(m), np.zeros(m)
        pb, by_state, moved = np.zeros(m), np.zeros(m), np.zeros(m)
        gamma, nu = 0.0, 0.0
        twice, last_travel = 2.0 * qp.travel[0], 0.0
        empty = True  # P is zero until an output beyond its limit has been met
        for i in range(n - 1, -1, -1):
            a, b = qp.A[i], qp.b[i]
            for r in range(3):
                if room.curvature[i, r] != 0.0:
                    p[OUTPUTS[r], OUTPUTS[r]] += room.curvature[i, r]
                    empty = False
            # pb = P b + c; by_state = A' pb; moved = A' v; by_itself, constant: the quadratic in p_i
            by_itself, constant = gamma + twice + proximal + room.barrier[i], room.slope[i] + nu
            pb[:], by_state[:], moved[:] = 0.0, 0.0, 0.0
            if not empty:
                add_product(p, b, pb)
            for row in range(m):
                by_itself += b[row] * (pb[row] + 2.0 * c[row])
                constant += b[row] * v[row]
                pb[row] += c[row]
            add_transposed(a, pb, by_state)
            add_transposed(a, v, moved)
            if not empty:  # P becomes A' P A
                transposed_product(p.T, a, w)
                transposed_product(a, w, p)
            last_travel = -twice
            if room.held[i]:
                given = room.direction[i]
                for row in range(m):
                    c[row] = 0.0
                    v[row] = moved[row] + by_state[row] * given
                gamma, nu = twice, last_travel * given
                continue
            if not by_itself > 0.0:
                return False
            for row in range(m):
                room.gain[i, row] = -by_state[row] / by_itself
            room.gain[i, m] = -last_travel / by_itself
            room.gain[i, m + 1] = -constant / by_itself
            for row in range(m):
                factor = room.gain[i, row]
                if not empty:
                    for column in range(m):
                        p[row, column] += factor * by_state[column]
                c[row] = factor * last_travel
                v[row] = moved[row] + factor * constant
            gamma = twice + room.gain[i, m] * last_travel
            nu = room.gain[i, m] * constant
            if not empty:
                continue
            for row in range(m):  # the travel couples to the state even where P was zero
                if by_state[row] != 0.0:
                    empty = False
            if not empty:
                for row in range(m):
                    for column in range(m):
                        p[row, column] = room.gain[i, row] * by_state[column]
        e, before = np.zeros(m), 0.0
        for i in range(n):
            if not room.held[i]:
                total = room.gain[i, m] * before + room.gain[i, m + 1]
                for row in range(m):
                    total += room.gain[i, row] * e[row]
                room.direction[i] = total
            before = room.direction[i]
            for row in range(m):
                moved[row] = qp.b[i, row] * before
            add_product(qp.A[i], e, moved)
            put(moved, e)
            put(e, room.ahead[i])
        return True

    return sweep


sweep = _sweep(source_stamp(SOURCES))
