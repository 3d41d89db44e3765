"""The linearised horizon for OSQP, the baseline: states eliminated, couplings and slacks left.

Stellato, Banjac, Goulart, Bemporad, Boyd, Math. Program. Comput. 12 (2020) 637-672. The pattern never changes: it is
analysed once, and each subproblem only brings new numbers. A penalty 1/2 w dist(y, [low, high])^2 becomes a quadratic
one on a slack s with low <= y - s <= high. With the states kept as variables, the form which is sparser, OSQP needs
eight times the iterations and thirty times the time: the states' sizes differ by thousands, and a long chain of
equalities spreads errors slowly. Only this file knows OSQP, which is imported when a solver is built.

    z = (d_1..d_n, s_1..s_n);   rows: bounds on d (n), limits (3 n)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.solvers import subproblem
from gyroctl.controllers.nmpc.solvers.subproblem import OUTPUTS, Step, Subproblem, add_product, bounds, evaluate, slope
from gyroctl.plant.compiled import entry_point

FloatArray = NDArray[np.float64]


@entry_point
def respond(qp: Any, out: Any) -> None:
    """Write the response of the outputs to the couplings, row by row, as far as the present: (3 n (n + 1) / 2,)."""
    n, m = qp.b.shape
    last, moved, at = np.zeros((n, m)), np.zeros(m), 0  # the state's response to each coupling
    for i in range(n):
        for j in range(i):
            moved[:] = 0.0
            add_product(qp.A[i], last[j], moved)
            last[j] = moved
        last[i] = qp.b[i]
        for r in range(3):
            out[at : at + i + 1] = last[: i + 1, OUTPUTS[r]]
            at += i + 1
    out[at:] = 0.0
    add_product(last, qp.terminal, out[at:])


@dataclass(frozen=True)
class CondensedForm:
    """A subproblem as 1/2 z'Pz + q'z, low <= G z <= high; matrices with fixed patterns."""

    n: int
    P: Any  # csc_matrix, upper triangle
    G: Any  # csc_matrix
    into_P: NDArray[np.intp]  # where each value belongs in P.data
    into_G: NDArray[np.intp]

    @classmethod
    def build(cls, n: int) -> CondensedForm:
        """Lay out a horizon of `n` intervals."""
        d, s = np.arange(n), n + np.arange(3 * n)
        past = [np.arange(i // 3 + 1) for i in range(3 * n)]  # what an output depends on
        rows = [d, np.repeat(s, [part.size for part in past]), s]
        G, into_G = _pattern(rows, [d, np.concatenate(past), s], (4 * n, 4 * n))
        P, into_P = _pattern([d, d[:-1], s], [d, d[1:], s], (4 * n, 4 * n))
        return cls(n, P, G, into_P, into_G)

    def filled(self, qp: Subproblem, proximal: float) -> tuple[Any, FloatArray, Any, FloatArray, FloatArray]:
        """Return P, q, G, low, high with the numbers of a subproblem; P and G are the form's own, overwritten."""
        n, twice = self.n, 2.0 * qp.travel[0]
        response = np.empty(3 * n * (n + 1) // 2 + n)
        respond(qp, response)
        self.G.data[self.into_G] = np.concatenate([np.ones(n), response[:-n], np.full(3 * n, -1.0)])
        diagonal = np.full(n, proximal + 2.0 * twice)
        diagonal[-1] -= twice
        self.P.data[self.into_P] = np.concatenate([diagonal, np.full(n - 1, -twice), np.tile(qp.weight, n)])
        jump = np.diff(qp.plan, prepend=qp.before[0])
        q, low, high = np.zeros(4 * n), np.empty(4 * n), np.empty(4 * n)
        q[:n] = response[-n:] + twice * (jump - np.append(jump[1:], 0.0))
        bounds(qp, low[:n], high[:n])
        low[n:], high[n:] = (qp.low - qp.outputs).ravel(), (qp.high - qp.outputs).ravel()
        return self.P, q, self.G, low, high


def _pattern(rows: Any, columns: Any, shape: tuple[int, int]) -> tuple[Any, NDArray[np.intp]]:
    """Sparse matrix with ones at the places, and where the k-th place is stored."""
    from scipy.sparse import csc_matrix

    row, column = (np.concatenate([np.ravel(part) for part in parts]) for parts in (rows, columns))
    order = np.lexsort((row, column))
    into = np.empty(order.size, np.intp)
    into[order] = np.arange(order.size)
    starts = np.searchsorted(column[order], np.arange(shape[1] + 1))
    return csc_matrix((np.ones(order.size), row[order], starts), shape=shape), into


class OsqpSolver:
    """OSQP with the pattern of one horizon of `n` intervals and `m` states; its last solution starts the next.

    The `tolerance`, absolute and relative [-], is OSQP's: it stops at the first point within both, or at the `limit` of
    its iterations. With `polish` it solves for the active constraints at the end, to near rounding where it works.
    """

    def __init__(self, n: int, m: int, tolerance: float = 1e-4, limit: int = 4000, polish: bool = False) -> None:
        self.form = CondensedForm.build(n)
        self._settings = dict(eps_abs=tolerance, eps_rel=tolerance, max_iter=limit, polishing=polish, verbose=False)
        self._osqp: Any = None
        self._room = np.zeros(n), np.zeros(n), np.zeros((n, m)), np.zeros((n, 3)), np.zeros(n)

    def solve(self, qp: Subproblem, proximal: float, d: FloatArray) -> Step:
        """Solve a subproblem, as `riccati.solve` does; `d` (n,) is overwritten.

        The status is OSQP's own, at its tolerance; `distance` is the certificate that both solvers share, and is
        pessimistic for a solution which is near its bounds but not on them.
        """
        P, q, G, low, high = self.form.filled(qp, proximal)
        if self._osqp is None:
            import osqp

            self._osqp = osqp.OSQP()
            self._osqp.setup(P, q, G, low, high, **self._settings)
        else:
            self._osqp.update(q=q, l=low, u=high, Px=P.data, Ax=G.data)
        result = self._osqp.solve(raise_error=False)
        status, count = _status(result.info.status_val), result.info.iter
        if status in (subproblem.NOT_FINITE, subproblem.NOT_CONVEX) or not np.all(np.isfinite(result.x)):
            d[:] = 0.0
            return Step(subproblem.NOT_FINITE if status == subproblem.SOLVED else status, count, np.inf, 0.0)
        least, most, states, slopes, steepness = self._room
        bounds(qp, least, most)
        d[:] = 0.0
        nothing = evaluate(qp, proximal, d, states, slopes)
        d[:] = np.clip(result.x[: self.form.n], least, most)
        value = evaluate(qp, proximal, d, states, slopes) - nothing
        slope(qp, proximal, d, slopes, steepness)
        left = np.where(d <= least, np.minimum(steepness, 0.0), steepness)
        left = np.where(d >= most, np.maximum(left, 0.0), left)
        return Step(status, count, float(np.linalg.norm(left)) / proximal, value)


def _status(value: int) -> int:
    import osqp

    names = osqp.SolverStatus
    known = {names.OSQP_SOLVED: subproblem.SOLVED, names.OSQP_NON_CVX: subproblem.NOT_CONVEX}
    for near in (names.OSQP_SOLVED_INACCURATE, names.OSQP_MAX_ITER_REACHED, names.OSQP_TIME_LIMIT_REACHED):
        known[near] = subproblem.LIMIT_REACHED
    return known.get(names(value), subproblem.NOT_FINITE)
