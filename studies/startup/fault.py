"""The forced loss: a generator that pulls as hard as it can, whatever the law asks for, until the ring stalls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gyroctl.simulation.lock import THRESHOLD, WINDOW


@dataclass(frozen=True)
class StuckGenerator:
    """A law whose generator gain is stuck for a while.

    Parameters
    ----------
    law : Law
        The law below; it goes on without knowing.
    begin : float
        Start of the fault. [s]
    least, most : float
        The fault lasts for `least` at least, and until the mean ring speed over 10 s is below half of wp, but no
        longer than `most`. [s]
    cg : float
        Generator gain during the fault. [Nms]
    wp : float
        Peak frequency. [rad/s]
    """

    law: Any
    begin: float = 400.0
    least: float = 20.0
    most: float = 120.0
    cg: float = 0.02
    wp: float = 3.14

    @property
    def motors(self) -> bool:
        """Whether the law below may use the motor."""
        return bool(getattr(self.law, "motors", False))

    @property
    def period(self) -> float:
        """Sampling period. [s]"""
        return float(self.law.period)

    @property
    def information(self) -> Any:
        """What the law below looks at."""
        return self.law.information

    def init(self) -> tuple[Any, tuple[float, ...], float]:
        """State of the law below, ring angles of the last 10 s [rad], end of the fault, 0 before it is known [s]."""
        return self.law.init(), (), 0.0

    def step(self, t: float, y: Any, state: Any) -> tuple[tuple[float, float], Any]:
        """Let the law below decide, and overrule its generator during the fault."""
        inner, angles, end = state
        (cc, cg), inner = self.law.step(t, y, inner)
        angles = (*angles, y.psi)[-round(WINDOW / self.period) - 1 :]
        if t >= self.begin and end == 0.0:
            stalled = angles[-1] - angles[0] < THRESHOLD * self.wp * WINDOW
            if t >= self.begin + self.most or (stalled and t >= self.begin + self.least):
                end = t
            else:
                cg = self.cg
        return (cc, cg), (inner, angles, end)

    def counters(self, state: Any) -> dict[str, float]:
        """Counts of the law below, and the end of the fault [s]."""
        counts: dict[str, float] = dict(self.law.counters(state[0])) if hasattr(self.law, "counters") else {}
        return counts | {"fault_ends": float(state[2])}
