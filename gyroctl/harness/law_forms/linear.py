"""A linear time-invariant law: x+ = A x + B e, (cc, cg) = (cc, cg)0 + C x + D e, e the deviation of what it reads.

The order is that of every discrete system: the command at a sample goes by the state before it and the sample itself.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.harness.law_forms.entries import with_entry
from gyroctl.harness.law_forms.signals import SIGNALS, channels_of, heard, kept
from gyroctl.plant.compiled import inlined


class LinearState(NamedTuple):
    """State of the system, and the signals as they were last heard."""

    x: tuple[float, ...]
    seen: tuple[float, ...]


@shown(law_face)
class LinearLaw(NamedTuple):
    """A linear system between sensors and controls."""

    A: tuple[float, ...]  # (n n), row by row
    B: tuple[float, ...]  # (n m)
    C: tuple[float, ...]  # (2 n), rows of cc and cg
    D: tuple[float, ...]  # (2 m)
    reads: tuple[float, ...]  # (m), numbers of its inputs in `SIGNALS`
    point: tuple[float, ...]  # (m), where the deviations count from
    pair: tuple[float, ...]  # cc, cg there [Nms]
    most: tuple[float, ...]  # limits of the command, from 0 to these [Nms]
    N: float  # gear ratio [-]
    period: float  # [s]

    @property
    def information(self) -> Literal["none", "sensors"]:
        """What the law looks at."""
        return "sensors" if any(self.D) or (any(self.B) and any(self.C)) else "none"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by."""
        return channels_of(tuple(SIGNALS[int(which)] for which in self.reads))

    @property
    def facts(self) -> list[tuple[str, str]]:
        """What its repr tells."""
        point = ", ".join(f"{SIGNALS[int(i)]} {at:.4g}" for i, at in zip(self.reads, self.point, strict=True))
        pair = f"cc {self.pair[0]:.4g}, cg {self.pair[1]:.4g} Nms"
        return [("states", str(len(self.C) // 2)), ("about", point), ("where it gives", pair)]

    def init(self) -> LinearState:
        """At rest: on the operating point the command is the pair."""
        return LinearState((0.0,) * (len(self.C) // 2), tuple(self.point))

    def step(self, t: float, y: Any, state: LinearState) -> tuple[tuple[float, float], LinearState]:
        """Take a sample."""
        n, m = len(state.x), len(self.reads)
        seen, x = state.seen, state.x
        for j in range(m):
            value = heard(self.reads[j], y, self.N, state.seen[j])
            seen = with_entry(seen, j, value)
        cc = self.pair[0] + output(self, 0, state.x, seen)
        cg = self.pair[1] + output(self, 1, state.x, seen)
        for i in range(n):
            value = 0.0
            for j in range(n):
                value += self.A[i * n + j] * state.x[j]
            for j in range(m):
                value += self.B[i * m + j] * (seen[j] - self.point[j])
            x = with_entry(x, i, value)
        for j in range(m):
            seen = with_entry(seen, j, kept(self.reads[j], seen[j]))
        command = min(max(cc, 0.0), self.most[0]), min(max(cg, 0.0), self.most[1])
        return command, LinearState(x, seen)


@inlined
def output(law: Any, row: int, x: Any, seen: Any) -> Any:
    """Deviation of a control, row 0 of cc and 1 of cg. [Nms]"""
    n, m = len(x), len(seen)
    value = 0.0
    for j in range(n):
        value += law.C[row * n + j] * x[j]
    for j in range(m):
        value += law.D[row * m + j] * (seen[j] - law.point[j])
    return value
