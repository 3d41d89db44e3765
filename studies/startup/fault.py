"""The forced loss: a generator that pulls as hard as it can, whatever the law asks for, until the ring stalls."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from gyroctl.plant.compiled import inlined
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


@inlined
def follow(fault: Fault, t: float, psi: float, seen: Any) -> Any:
    """Ring angles at the last full seconds, and the end of the fault, 0 before it is known [s]: what is `seen` at t."""
    marks, end = seen[:-1], seen[-1]
    if t < fault.begin - WINDOW:
        return seen
    if abs(t - round(t)) < 1e-6:
        marks = marks[1:] + (psi,)  # noqa: RUF005 - numba knows the sum of tuples
    if t >= fault.begin and end == 0.0:
        stalled = marks[-1] - marks[0] < THRESHOLD * fault.wp * WINDOW
        if t >= fault.begin + fault.most or (stalled and t >= fault.begin + fault.least):
            end = t
    return marks + (end,)  # noqa: RUF005


@inlined
def overruled(fault: Fault, t: float, end: float) -> bool:
    """Whether the generator is stuck at t."""
    return t >= fault.begin and end == 0.0


@dataclass(frozen=True)
class StuckGenerator:
    """A law whose generator is stuck for a while, in plain Python; `stuck` makes one that compiles where it can.

    Parameters
    ----------
    law : Law
        The law below; it goes on without knowing.
    fault : Fault
        When, and where.
    """

    law: Any
    fault: Fault

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

    def init(self) -> tuple[Any, tuple[float, ...]]:
        """State of the law below, and what has been seen."""
        return self.law.init(), (0.0,) * (MARKS + 1)

    def step(self, t: float, y: Any, state: Any) -> tuple[tuple[float, float], Any]:
        """Let the law below decide, and overrule its generator during the fault."""
        inner, seen = state
        (cc, cg), inner = self.law.step(t, y, inner)
        seen = follow(self.fault, t, y.psi, seen)
        return (cc, self.fault.cg if overruled(self.fault, t, seen[-1]) else cg), (inner, seen)

    def counters(self, state: Any) -> dict[str, float]:
        """Counts of the law below, and the end of the fault [s]."""
        return _counters(self.law, state[0], state[1][-1])


def stuck(law: Any, fault: Fault | None = None) -> Any:
    """Put a law on a device whose generator will be stuck: one NamedTuple where the law and its state are such."""
    fault, start = fault or Fault(), law.init()
    if not (isinstance(law, tuple) and hasattr(start, "_fields")):
        return StuckGenerator(law, fault)
    compose: Any = _composed
    return compose(type(law), type(start))(*fault, *law)


@lru_cache(maxsize=64)
def _composed(law_type: Any, state_type: Any) -> Any:
    inner_step, faults, states = inlined(law_type.step), len(Fault._fields), len(state_type._fields)

    def step(self: Any, t: float, y: Any, state: Any) -> Any:
        """Let the law below decide, and overrule its generator during the fault."""
        fault, law = Fault(*self[:faults]), law_type(*self[faults:])
        (cc, cg), inner = inner_step(law, t, y, state_type(*state[:states]))
        seen = follow(fault, t, y.psi, state[states:])
        if overruled(fault, t, seen[-1]):
            cg = fault.cg
        return (cc, cg), state_kind(*(inner[:] + seen))

    make: Any = namedtuple
    marks = [f"mark_{i}" for i in range(MARKS)]
    state_kind = make("StuckState", [*state_type._fields, *marks, "fault_ends"])
    kind = make("Stuck", [*(f"fault_{name}" for name in Fault._fields), *law_type._fields])
    kind.law = property(lambda self: law_type(*self[faults:]))
    kind.motors = property(lambda self: bool(getattr(self.law, "motors", False)))
    kind.information = property(lambda self: self.law.information)
    kind.init = lambda self: state_kind(*self.law.init(), *(0.0,) * (MARKS + 1))
    kind.step = step
    kind.counters = lambda self, state: _counters(self.law, state_type(*state[:states]), state[-1])
    return kind


def _counters(law: Any, state: Any, end: float) -> dict[str, float]:
    counts: dict[str, float] = dict(law.counters(state)) if hasattr(law, "counters") else {}
    return counts | {"fault_ends": float(end)}
