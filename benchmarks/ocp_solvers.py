"""Solvers out of casadi's wheel on the planner's quadratic programs, in the form that they like best: with the states.

A stage holds the state x and as inputs the step d of the coupling and the three slacks of the limits after it:

    min  sum 1/2 (p d^2 + w' s^2) + t' x_n,   x_(i+1) = A_i x_i + b_i d_i,   low <= y(x_(i+1)) - s_i <= high.

HPIPM and fatrop keep that structure. What is timed is their call, with the numbers in their places.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from gyroctl.controllers.nmpc.solvers.subproblem import LIMIT_REACHED, OUTPUTS, SOLVED, Step, Subproblem, bounds

SLACKS = len(OUTPUTS)


class Hpipm:
    """HPIPM (Frison, Diehl, IFAC 2020) for a horizon of n intervals and m states."""

    def __init__(self, n: int, m: int) -> None:
        import casadi

        self.n, self.m = n, m
        self.stage = m + 1 + SLACKS  # x, d, s
        size = n * self.stage + m
        self.into: list[tuple[int, int]] = []
        for i in range(n):
            row, at = i * (m + SLACKS), i * self.stage
            self.into += [(row + r, at + c) for r in range(m) for c in range(m + 1)]  # A and b
            self.into += [(row + r, at + self.stage + r) for r in range(m)]  # -x of the next stage
            self.into += [(row + m + r, at + c) for r in range(SLACKS) for c in range(m + 1)]
            self.into += [(row + m + r, at + m + 1 + r) for r in range(SLACKS)]  # -s
        rows, columns = np.array(self.into).T
        shape = (n * (m + SLACKS), size)
        pattern = casadi.Sparsity.triplet(*shape, rows.tolist(), columns.tolist())
        self.order = np.lexsort((rows, columns))
        self.A = casadi.DM(pattern, np.ones(pattern.nnz()))
        self.H = casadi.DM(casadi.Sparsity.diag(size), np.zeros(size))
        options: dict[str, Any] = {"N": n, "nx": [m] * (n + 1), "nu": [1 + SLACKS] * n + [0], "ng": [SLACKS] * n + [0]}
        options |= {"error_on_fail": False, "print_time": False, "hpipm.mode": "robust", "hpipm.iter_max": 100}
        options |= {f"hpipm.res_{of}_max": at for of, at in zip("gbdm", (1e-6, 1e-8, 1e-8, 1e-7), strict=True)}
        self.solver = casadi.conic("s", "hpipm", {"h": self.H.sparsity(), "a": pattern}, options)
        self.spent = 0.0

    def solve(self, qp: Subproblem, proximal: float, d: np.ndarray) -> Step:
        """Solve a subproblem; the time of the call alone is kept in `spent`. [s]"""
        import casadi

        n, m, stage = self.n, self.m, self.stage
        assert qp.travel[0] == 0.0, "this form has no travel of the coupling"
        numbers, diagonal, linear = [], np.zeros(n * stage + m), np.zeros(n * stage + m)
        low, high = np.full(n * stage + m, -np.inf), np.full(n * stage + m, np.inf)
        least, most = np.zeros(n), np.zeros(n)
        bounds(qp, least, most)
        low[:m] = high[:m] = 0.0
        gap_low, gap_high = np.zeros(n * (m + SLACKS)), np.zeros(n * (m + SLACKS))
        for i in range(n):
            whole = np.column_stack([qp.A[i], qp.b[i]])
            numbers += [whole.ravel(), np.full(m, -1.0), whole[list(OUTPUTS)].ravel(), np.full(SLACKS, -1.0)]
            at, row = i * stage, i * (m + SLACKS) + m
            diagonal[at + m], diagonal[at + m + 1 : at + stage] = proximal, qp.weight
            low[at + m], high[at + m] = least[i], most[i]
            gap_low[row : row + SLACKS] = qp.low - qp.outputs[i]
            gap_high[row : row + SLACKS] = qp.high - qp.outputs[i]
        linear[n * stage :] = qp.terminal
        A = casadi.DM(self.A.sparsity(), np.concatenate(numbers)[self.order])
        H = casadi.DM(self.H.sparsity(), diagonal)
        given = {"h": H, "a": A, "g": linear, "lbx": low, "ubx": high, "lba": gap_low, "uba": gap_high}
        given = {key: casadi.DM(value) for key, value in given.items()}
        begin = time.thread_time()
        found = self.solver(**given)
        self.spent = time.thread_time() - begin
        state = self.solver.stats()
        d[:] = np.clip(np.asarray(found["x"]).ravel()[m::stage][:n], least, most)
        good = bool(state.get("success", False)) and bool(np.all(np.isfinite(d)))
        return Step(SOLVED if good else LIMIT_REACHED, int(state.get("iter_count", 0)), np.nan, np.nan)


class Fatrop:
    """fatrop (Vanroye et al., IROS 2023), through casadi's interface for nonlinear programs.

    Its interface for quadratic programs prints its matrices in the wheel that was tried.
    """

    def __init__(self, n: int, m: int) -> None:
        import casadi

        self.n, self.m = n, m
        x = [casadi.MX.sym(f"x{i}", m) for i in range(n + 1)]
        u = [casadi.MX.sym(f"u{i}", 1 + SLACKS) for i in range(n)]
        step = [casadi.MX.sym(f"step{i}", m, m + 1) for i in range(n)]
        proximal, weight, terminal = casadi.MX.sym("p"), casadi.MX.sym("w", SLACKS), casadi.MX.sym("t", m)
        cost, rows = casadi.dot(terminal, x[n]), []
        for i in range(n):
            d, s = u[i][0], u[i][1:]
            moved = step[i] @ casadi.vertcat(x[i], d)
            cost += 0.5 * proximal * d**2 + 0.5 * casadi.dot(weight, s * s)
            rows += [x[i + 1] - moved]
            rows += [x[0]] if i == 0 else []
            rows += [d, moved[list(OUTPUTS)] - s]
        z = casadi.vertcat(*(part for pair in zip(x, [*u, casadi.MX(0, 1)], strict=True) for part in pair))
        given = casadi.vertcat(*(casadi.vec(one) for one in step), proximal, weight, terminal)
        options = {"structure_detection": "auto"}
        options |= {"error_on_fail": False, "print_time": False}
        one = [True] * m + [False] * (1 + SLACKS)
        options |= {
            "equality": [True] * m + one + one * (n - 1),
            "fatrop.print_level": 0,
            "fatrop.mu_init": 1e-2,
            "fatrop.tol": 1e-6,
        }
        problem = {"x": z, "f": cost, "g": casadi.vertcat(*rows), "p": given}
        self.solver = casadi.nlpsol("s", "fatrop", problem, options)
        self.spent = 0.0

    def solve(self, qp: Subproblem, proximal: float, d: np.ndarray) -> Step:
        """As `Hpipm.solve`."""
        import casadi

        n, m = self.n, self.m
        least, most = np.zeros(n), np.zeros(n)
        bounds(qp, least, most)
        low, high = [], []
        for i in range(n):
            low += [np.zeros(m + (m if i == 0 else 0)), [least[i]], qp.low - qp.outputs[i]]
            high += [np.zeros(m + (m if i == 0 else 0)), [most[i]], qp.high - qp.outputs[i]]
        numbers = [np.column_stack([qp.A[i], qp.b[i]]).ravel(order="F") for i in range(n)]
        p = np.concatenate([*numbers, [proximal], qp.weight, qp.terminal])
        given = {"p": p, "lbg": np.concatenate(low), "ubg": np.concatenate(high), "x0": 0.0}
        given = {key: casadi.DM(value) for key, value in given.items()}
        begin = time.thread_time()
        found = self.solver(**given)
        self.spent = time.thread_time() - begin
        state = self.solver.stats()
        stage = m + 1 + SLACKS
        d[:] = np.clip(np.asarray(found["x"]).ravel()[m::stage][:n], least, most)
        good = bool(state.get("success", False)) and bool(np.all(np.isfinite(d)))
        return Step(SOLVED if good else LIMIT_REACHED, int(state.get("iter_count", 0)), np.nan, np.nan)
