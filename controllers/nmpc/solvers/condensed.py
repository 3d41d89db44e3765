"""The linearised horizon without its states: a dense program in the couplings alone, by projected Newton steps.

The same method as in `riccati`, on the same program; here the states are eliminated once (Bock, Plitt, IFAC Proc. Vol.
17 (1984) 1603-1608), in O(n^2), and each Newton system is a dense one in the free couplings, whose matrix is the
proximal weight plus the few limits that act. With 13 states that takes 0.4 of the time of the Riccati sweeps at 40
intervals and 0.75 at 80; beyond about a hundred the sweeps, in O(n), win.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.solvers import SOURCES, subproblem
from gyroctl.controllers.nmpc.solvers.bent_path import ROUNDING, SHORTEST, SUFFICIENT, hold, steepness
from gyroctl.controllers.nmpc.solvers.subproblem import OUTPUTS, Step
from gyroctl.plant.compiled import inlined, part, put, source_stamp, zero_table, zeros
from gyroctl.plant.fused import EIGHT, add_eights
from gyroctl.plant.row_sums import add_rows

FloatArray = NDArray[np.float64]


class CondensedRoom(NamedTuple):
    """Arrays that the solver works in. Outputs are counted 3 i + r: phi1, phi3, ring speed after interval i."""

    low: FloatArray  # (n,)
    high: FloatArray  # (n,)
    slope: FloatArray  # (n,)
    direction: FloatArray  # (n,)
    trial: FloatArray  # (n,)
    values: FloatArray  # (3 n,) outputs
    slopes: FloatArray  # (3 n,) of the penalties
    new_slopes: FloatArray  # (3 n,)
    reply: FloatArray  # (n, 3 n): of each output to each coupling
    terminal: FloatArray  # (n,) slope of the terminal cost
    padded: FloatArray  # (m fours,) A of an interval, its rows filled up with zeros to a multiple of four
    front: FloatArray  # (blocks, fours EIGHT): states after an interval by the couplings of a block, side by side
    ahead: FloatArray  # the same
    acting: FloatArray  # (3 n, n): replies of the outputs whose limits act to the free couplings
    factors: FloatArray  # (3 n,)
    hessian: FloatArray  # (n, n) of the free couplings, then its factor U with U' U
    right: FloatArray  # (n,)
    free: NDArray[np.int64]  # (n,)
    held: NDArray[np.bool_]  # (n,)


@inlined
def empty_condensed_room(n: int, m: int) -> CondensedRoom:
    """Room for a horizon of `n` intervals of a model with `m` states."""
    new, k = zeros, 3 * n
    blocks, fours = (n + EIGHT - 1) // EIGHT, (m + 3) // 4 * 4
    couplings = new(n), new(n), new(n), new(n), new(n)
    outputs = new(k), new(k), new(k), zero_table(n, k), new(n)
    states = new(m * fours), zero_table(blocks, fours * EIGHT), zero_table(blocks, fours * EIGHT)
    system = zero_table(k, n), new(k), zero_table(n, n), new(n)
    return CondensedRoom(*couplings, *outputs, *states, *system, np.zeros(n, np.int64), np.zeros(n, np.bool_))


@part(SOURCES)
def condense(qp: Any, room: Any) -> None:
    """Eliminate the states: write the replies of the outputs, and the slope of the terminal cost, by each coupling."""
    n, m = qp.b.shape
    front, ahead, padded = room.front, room.ahead, room.padded
    fours = padded.size // m
    front[:, :] = 0.0
    ahead[:, :] = 0.0
    for i in range(n):
        for row in range(m):
            for column in range(m):
                padded[fours * row + column] = qp.A[i, row, column]
        for block in range(i // EIGHT + 1):
            begin, now, later = EIGHT * block, front[block], ahead[block]
            later[: EIGHT * m] = 0.0
            for k in range(0, fours, 4):
                for row in range(m):
                    add_eights(padded, fours * row + k, now, k, later, row)
            if i < begin + EIGHT:
                for row in range(m):
                    later[EIGHT * row + i - begin] = qp.b[i, row]
            for r in range(3):
                for l in range(min(i + 1 - begin, EIGHT)):
                    room.reply[begin + l, 3 * i + r] = later[EIGHT * OUTPUTS[r] + l]
        front, ahead = ahead, front
    for j in range(n):
        total = 0.0
        for row in range(m):
            total += qp.terminal[row] * front[j // EIGHT, EIGHT * row + j % EIGHT]
        room.terminal[j] = total


@part(SOURCES)
def condensed_cost(qp: Any, proximal: float, d: Any, slopes: Any, room: Any) -> float:
    """Cost of a change `d`, with the slopes of the penalties by the outputs written."""
    n, values = d.size, room.values
    for i in range(n):
        for r in range(3):
            values[3 * i + r] = qp.outputs[i, r]
    add_rows(d, room.reply, 0, n, values, 0, values.size)
    cost, last, planned = 0.0, 0.0, qp.before[0]
    for i in range(n):
        for r in range(3):
            value = values[3 * i + r]
            beyond = value - min(max(value, qp.low[r]), qp.high[r])
            slopes[3 * i + r] = qp.weight[r] * beyond
            cost += 0.5 * qp.weight[r] * beyond * beyond
        jump = qp.plan[i] + d[i] - planned - last
        cost += qp.travel[0] * jump * jump + 0.5 * proximal * d[i] * d[i] + room.terminal[i] * d[i]
        last, planned = d[i], qp.plan[i]
    return cost


@part(SOURCES)
def condensed_slope(qp: Any, proximal: float, d: Any, room: Any) -> None:
    """Write the gradient by `d`, from the slopes that `condensed_cost` left."""
    n, twice, out = d.size, 2.0 * qp.travel[0], room.slope
    for i in range(n):
        out[i] = proximal * d[i] + room.terminal[i]
        before = qp.before[0] if i == 0 else qp.plan[i - 1] + d[i - 1]
        out[i] += twice * (qp.plan[i] + d[i] - before)
        if i + 1 < n:
            out[i] += twice * (qp.plan[i] + d[i] - qp.plan[i + 1] - d[i + 1])
    for k in range(3 * n):
        if room.slopes[k] != 0.0:
            for j in range(k // 3 + 1):
                out[j] += room.slopes[k] * room.reply[j, k]


@part(SOURCES)
def newton_direction(qp: Any, proximal: float, room: Any) -> bool:
    """Write `room.direction` of the couplings that are not held; return whether the program is convex."""
    n, U, right, free, factors = room.held.size, room.hessian, room.right, room.free, room.factors
    twice = 2.0 * qp.travel[0]
    count, acting = 0, 0
    for i in range(n):
        if not room.held[i]:
            free[count], right[count] = i, -room.slope[i]
            if i > 0 and room.held[i - 1]:
                right[count] += twice * room.direction[i - 1]
            if i + 1 < n and room.held[i + 1]:
                right[count] += twice * room.direction[i + 1]
            count += 1
    for k in range(3 * n):
        if room.slopes[k] != 0.0:
            weight, moved = qp.weight[k % 3], 0.0
            for i in range(k // 3 + 1):
                if room.held[i]:
                    moved += room.reply[i, k] * room.direction[i]
            for f in range(count):
                room.acting[acting, f] = room.reply[free[f], k]
                right[f] -= weight * moved * room.acting[acting, f]
            room.values[acting] = weight
            acting += 1
    for f in range(count):
        for g in range(f, count):
            U[f, g] = 0.0
        U[f, f] = proximal + (twice if free[f] + 1 == n else 2.0 * twice)
        if f + 1 < count and free[f + 1] == free[f] + 1:
            U[f, f + 1] = -twice
        for a in range(acting):
            factors[a] = room.values[a] * room.acting[a, f]
        add_rows(factors, room.acting, 0, acting, U[f], f, count)
    for f in range(count):
        for k in range(f):
            factors[k] = -U[k, f]
        add_rows(factors, U, 0, f, U[f], f, count)
        if not U[f, f] > 0.0:
            return False
        pivot = np.sqrt(U[f, f])
        for g in range(f, count):
            U[f, g] /= pivot
    for f in range(count):
        right[f] /= U[f, f]
        for g in range(f + 1, count):
            right[g] -= U[f, g] * right[f]
    for f in range(count - 1, -1, -1):
        total = right[f]
        for g in range(f + 1, count):
            total -= U[f, g] * right[g]
        right[f] = total / U[f, f]
        room.direction[free[f]] = right[f]
    return True


def _solve(stamp: str) -> Callable[..., Step]:
    """Compile the solver; the stamp is as in `subproblem`."""

    @part()
    def solve(qp: Any, proximal: float, d: Any, tolerance: float, limit: int, room: Any) -> Step:
        """Solve a subproblem that `linearise` has filled; the arguments are those of `riccati.solve`."""
        stamp  # noqa: B018 - read, so that it belongs to the closure which numba's cache compares
        condense(qp, room)
        for i in range(d.size):
            room.low[i], room.high[i], room.trial[i] = -qp.plan[i], qp.cc_max[0] - qp.plan[i], 0.0
        nothing = condensed_cost(qp, proximal, room.trial, room.slopes, room)
        for i in range(d.size):
            d[i] = min(max(d[i], room.low[i]), room.high[i])
        cost = condensed_cost(qp, proximal, d, room.slopes, room)
        rounding = ROUNDING * (1.0 + abs(cost) + abs(nothing))
        distance, status, count = np.inf, subproblem.LIMIT_REACHED, 0
        for count in range(limit + 1):
            condensed_slope(qp, proximal, d, room)
            square, whole = steepness(d, room)
            distance = np.sqrt(square) / proximal
            if not np.isfinite(distance + cost):
                status = subproblem.NOT_FINITE
                break
            if distance <= tolerance or square <= ROUNDING**2 * whole:  # the slope itself is no better known
                status = subproblem.SOLVED
                break
            if count == limit:
                break
            hold(d, min(1e-6, distance) * qp.cc_max[0], room)
            if not newton_direction(qp, proximal, room):
                status = subproblem.NOT_CONVEX
                break
            accepted, cost = _shortened(qp, proximal, d, cost, rounding, room)
            if not accepted:  # as near as rounding lets the cost tell
                break
        return Step(status, count, distance, cost - nothing)

    return solve


@inlined
def _shortened(qp: Any, proximal: float, d: Any, cost: float, rounding: float, room: Any) -> tuple[bool, float]:
    """Go along the bent path as far as the cost falls; return whether it did, and the cost."""
    part = 1.0
    while part > SHORTEST:
        decrease = 0.0
        for i in range(d.size):
            room.trial[i] = min(max(d[i] + part * room.direction[i], room.low[i]), room.high[i])
            decrease -= room.slope[i] * (room.trial[i] - d[i])
        found = condensed_cost(qp, proximal, room.trial, room.new_slopes, room)
        if found <= cost - SUFFICIENT * decrease + rounding:
            put(room.trial, d)
            put(room.new_slopes, room.slopes)
            return True, found
        part *= 0.5
    return False, cost


solve = _solve(source_stamp(SOURCES))
