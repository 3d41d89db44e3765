"""The flow with its derivative in many directions at once: the equations are traced, and their tangents go in lanes.

A complex step through the kernel computes the state anew for every direction, with a sine and a cosine each. Here the
text of `derivative` is run once on terms that write down what is done to them: a line for the value, and one for its
change to first order. The lines of the values are compiled as they are, those of the changes into a loop over LANES
directions, which the processor takes eight at a time. The changes are rounded as complex numbers round the imaginary
part of a step of 1e-30, so that both ways give the same bits. Linear model alone: no terms of `Beyond`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import aligned, entry_point, inlined, put
from gyroctl.plant.equations import RADIATION, Coefficients, derivative
from gyroctl.plant.instants import interpolate
from gyroctl.plant.lagrange import TAPS

LANES = 16
"""Directions side by side."""

Floats = NDArray[np.float64]


class _Trace:
    """Lines of a function, in the order in which they were traced."""

    def __init__(self) -> None:
        self.values: list[str] = []
        self.changes: list[str] = []

    def term(self, value: str, change: str = "") -> _Term:
        """Give a value a name, and its change where there is one."""
        at = len(self.values)
        self.values.append(f"v{at} = {value}")
        if change:
            self.changes.append(f"t{at} = {change}")
        return _Term(self, f"v{at}", f"t{at}" if change else "")


class _Term:
    """A number with its change (empty for a constant): what is done to it is written down as complex numbers do it."""

    def __init__(self, trace: _Trace, value: str, change: str) -> None:
        self.trace, self.value, self.change = trace, value, change

    def _of(self, other: Any) -> _Term:
        return other if isinstance(other, _Term) else _Term(self.trace, repr(float(other)), "")

    def _sum(self, sign: str, a: _Term, b: _Term) -> _Term:
        change = a.change
        if b.change:
            change = f"{a.change or '0.0'} {sign} {b.change}"
        return self.trace.term(f"{a.value} {sign} {b.value}", change)

    def __add__(self, other: Any) -> _Term:
        return self._sum("+", self, self._of(other))

    def __radd__(self, other: Any) -> _Term:
        return self._sum("+", self._of(other), self)

    def __sub__(self, other: Any) -> _Term:
        return self._sum("-", self, self._of(other))

    def __rsub__(self, other: Any) -> _Term:
        return self._sum("-", self._of(other), self)

    def __mul__(self, other: Any) -> _Term:
        a, b = self, self._of(other)
        parts = [f"{a.value} * {b.change}"] if b.change else []
        parts += [f"{a.change} * {b.value}"] if a.change else []
        return self.trace.term(f"{a.value} * {b.value}", " + ".join(parts))

    def __rmul__(self, other: Any) -> _Term:
        return self._of(other) * self

    def __truediv__(self, other: Any) -> _Term:
        a, b = self, self._of(other)
        change = f"({a.change or '0.0'} - {a.value} * ({b.change or '0.0'} / {b.value})) / {b.value}"
        return self.trace.term(f"{a.value} / {b.value}", change if a.change or b.change else "")

    def __rtruediv__(self, other: Any) -> _Term:
        return self._of(other) / self

    def __neg__(self) -> _Term:
        return self.trace.term(f"-{self.value}", f"-{self.change}" if self.change else "")

    def cos(self) -> _Term:  # numpy asks for these by their names
        return self._turned("cos", "sin", f"-{self.change}")

    def sin(self) -> _Term:
        return self._turned("sin", "cos", self.change)

    def _turned(self, name: str, slope: str, change: str) -> _Term:
        beside = self.trace.term(f"math.{slope}({self.value})")
        return self.trace.term(f"math.{name}({self.value})", f"{change} * {beside.value}")


def rates_text(orders: tuple[int, int, int, int]) -> str:
    """Text of ``rates(x, X, dx, dX, k, cc, cg, me1, me3)`` for radiation filters of these lengths of p1, q1, p3, q3.

    `x`, `dx` (n,) are state and rate, `X`, `dX` (n LANES,) their changes in each direction, `k` the constants in a row.
    """
    trace = _Trace()
    n, count = RADIATION + orders[1] + orders[3], iter(range(sum(orders) + len(Coefficients._fields)))

    def constant() -> _Term:
        return trace.term(f"k[{next(count)}]")

    lengths = dict(zip(("p1", "q1", "p3", "q3"), orders, strict=True))
    named: dict[str, Any] = {name: constant() for name in Coefficients._fields if name not in (*lengths, "beyond")}
    named |= {name: tuple(constant() for _ in range(length)) for name, length in lengths.items()}
    x = [trace.term(f"x[{i}]", f"X[{i * LANES} + l]") for i in range(n)]
    cc, cg, me1, me3 = (_Term(trace, name, "") for name in ("cc", "cg", "me1", "me3"))
    dx: dict[int, Any] = {}
    derivative(x, dx, 1, 0, Coefficients(**named), cc, cg, me1, me3)
    lines = [*trace.values, *(f"dx[{i}] = {dx[i].value}" for i in range(n)), f"for l in range({LANES}):"]
    lines += [f"    {line}" for line in (*trace.changes, *(f"dX[{i * LANES} + l] = {dx[i].change}" for i in range(n)))]
    return "def rates(x, X, dx, dX, k, cc, cg, me1, me3):\n    " + "\n    ".join(lines) + "\n"


@lru_cache(maxsize=16)
def _tangents(orders: tuple[int, int, int, int]) -> Callable[..., None]:
    scope: dict[str, Any] = {"math": math, "__name__": __name__}
    exec(compile(rates_text(orders), "<rates and their changes>", "exec"), scope)
    return _stepping(inlined(scope["rates"]), "_".join(map(str, orders)))


def _stepping(rates: Callable[..., None], orders: str) -> Callable[..., None]:
    @entry_point
    def advance_changes(
        y: Floats,
        Y: Floats,
        k: Floats,
        cc: float,
        cg: float,
        start: float,
        hold: float,
        steps: int,
        waves: Floats,
        waves_dt: float,
    ) -> None:
        """Advance a state `y` (n,) and its changes `Y` (n LANES,) in place, in the steps of `kernel.advance`."""
        orders  # noqa: B018 - in the closure, by which functions of one text are told apart
        n = y.size
        x, X, dx, dX = np.empty(n), aligned(Y.size), np.empty((4, n)), aligned(4 * Y.size).reshape(4, Y.size)
        moments, weight = np.empty(6), np.empty(TAPS)
        h = hold / steps
        put(y, x)
        put(Y, X)
        interpolate(waves, 1, start / waves_dt, weight, moments, 0)
        for step in range(steps):
            interpolate(waves, 1, (start + (step + 0.5) * h) / waves_dt, weight, moments, 1)
            interpolate(waves, 1, (start + (step + 1.0) * h) / waves_dt, weight, moments, 2)
            for stage in range(4):
                point = (stage + 1) // 2 * 2
                rates(x, X, dx[stage], dX[stage], k, cc, cg, moments[point], moments[point + 1])
                if stage < 3:
                    ahead = 0.5 * h if stage < 2 else h
                    ahead_of(y, dx[stage], ahead, x)
                    ahead_of(Y, dX[stage], ahead, X)
            weighted(y, dx[0], dx[1], dx[2], dx[3], h)
            weighted(Y, dX[0], dX[1], dX[2], dX[3], h)
            put(y, x)
            put(Y, X)
            moments[0], moments[1] = moments[4], moments[5]

    return advance_changes


@inlined
def ahead_of(y: Any, rate: Any, h: float, out: Any) -> None:
    """Write y + h rate."""
    for i in range(y.size):
        out[i] = y[i] + h * rate[i]


@inlined
def weighted(y: Any, first: Any, second: Any, third: Any, fourth: Any, h: float) -> None:
    """Add the step of Runge and Kutta to `y`."""
    for i in range(y.size):
        y[i] = y[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])


def hold_changes(
    x: Floats,
    changes: Floats,
    k: Coefficients,
    cc: float,
    cg: float,
    start: float,
    hold: float,
    steps: int,
    waves: Floats,
    waves_dt: float,
) -> tuple[Floats, Floats]:
    """State and its changes after a held interval, see `kernel.advance`; without a ledger.

    Parameters
    ----------
    x : (n,) array
        State at the start.
    changes : (n, m) array
        Its changes to first order, any number of them.
    k : Coefficients
        Of a plant within the linear model.
    cc, cg, start, hold, steps, waves, waves_dt
        As in `kernel.advance`.

    Returns
    -------
    state : (n,) array
    changes : (n, m) array
    """
    flat = np.array([*k[: Coefficients._fields.index("p1")], *k.p1, *k.q1, *k.p3, *k.q3], np.float64)
    advance = _tangents((len(k.p1), len(k.q1), len(k.p3), len(k.q3)))
    out, end = np.empty_like(changes), x
    for first in range(0, changes.shape[1], LANES):
        part = changes[:, first : first + LANES]
        lanes = np.zeros((x.size, LANES))
        lanes[:, : part.shape[1]] = part
        end, flow = x.copy(), lanes.ravel()
        advance(end, flow, flat, float(cc), float(cg), start, hold, steps, waves, waves_dt)
        out[:, first : first + LANES] = flow.reshape(-1, LANES)[:, : part.shape[1]]
    return end, out
