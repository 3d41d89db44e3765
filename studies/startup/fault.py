"""The forced loss: a generator that pulls as hard as it can, whatever the law asks for, until the ring stalls."""

from __future__ import annotations

from typing import Any, NamedTuple

from gyroctl.harness.protocol import Counting, Motoring
from gyroctl.plant.compiled import inlined, stepped
from gyroctl.simulation.lock import THRESHOLD, WINDOW

MARKS = 11
"""Ring angles kept, one a second: the first and the last are a window of 10 s apart."""


class Fault(NamedTuple):
    """When the generator is stuck, and where: from `begin` for `least` at least, and until the ring stalls."""

    begin: float = 400.0  # [s]
    least: float = 20.0  # [s]
    most: float = 120.0  # the fault ends then even if the ring has not stalled [s]
    cg: float = 0.02  # generator gain during the fault [Nms]
    wp: float = 3.14  # peak frequency; the ring stalls below half of it, in the mean over 10 s [rad/s]


class Seen(NamedTuple):
    """What is remembered of the ring."""

    marks: tuple[float, ...] = (0.0,) * MARKS  # its angles at the last full seconds [rad]
    end: float = 0.0  # of the fault, 0 before it is known [s]


@inlined
def follow(fault: Fault, t: float, psi: float, seen: Seen) -> Seen:
    """What is seen at t, where the ring is at `psi`."""
    if t < fault.begin - WINDOW:
        return seen
    marks, end = seen.marks, seen.end
    if abs(t - round(t)) < 1e-6:
        marks = marks[1:] + (psi,)  # noqa: RUF005 - numba knows the sum of tuples
    if t >= fault.begin and end == 0.0:
        stalled = marks[-1] - marks[0] < THRESHOLD * fault.wp * WINDOW
        if t >= fault.begin + fault.most or (stalled and t >= fault.begin + fault.least):
            end = t
    return Seen(marks, end)


@inlined
def overruled(fault: Fault, t: float, end: float) -> bool:
    """Whether the generator is stuck at t."""
    return t >= fault.begin and end == 0.0


class StuckState(NamedTuple):
    """State of the law below, and what is seen of the ring."""

    inner: Any
    seen: Seen


class StuckGenerator(NamedTuple):
    """A law whose generator is stuck for a while; the law below goes on without knowing. Build it with `stuck`."""

    fault: Fault  # when, and how long
    law: Any  # the law below
    period: float  # of the law below [s]

    @property
    def motors(self) -> bool:
        """Whether the law below may use the motor."""
        return isinstance(self.law, Motoring) and self.law.motors

    @property
    def information(self) -> Any:
        """What the law below looks at."""
        return self.law.information

    def init(self) -> StuckState:
        """Nothing seen yet."""
        return StuckState(self.law.init(), Seen())

    def step(self, t: float, y: Any, state: StuckState) -> tuple[tuple[float, float], StuckState]:
        """Let the law below decide, and overrule its generator during the fault."""
        (cc, cg), inner = stepped(self.law, t, y, state.inner)
        seen = follow(self.fault, t, y.psi, state.seen)
        if overruled(self.fault, t, seen.end):
            cg = self.fault.cg
        return (cc, cg), StuckState(inner, seen)

    def counters(self, state: StuckState) -> dict[str, float]:
        """Counts of the law below, and the end of the fault [s]."""
        counts = dict(self.law.counters(state.inner)) if isinstance(self.law, Counting) else {}
        return counts | {"fault_ends": float(state.seen.end)}


def stuck(law: Any, fault: Fault | None = None) -> StuckGenerator:
    """Put a law on a device whose generator will be stuck.

    Parameters
    ----------
    law : object
        A law.
    fault : Fault, optional
        When and how long; the usual one without it.

    Returns
    -------
    StuckGenerator
        A law.
    """
    return StuckGenerator(fault or Fault(), law, float(law.period))
