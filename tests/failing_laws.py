"""Laws that fail, each in its own way, after half a minute that is like that of any other law."""

from __future__ import annotations

import os
import sys
import time
from typing import Any, NamedTuple

GIVEN_UP = 30.0  # [s]
COUNT = [0]


class Well(NamedTuple):
    """Holds the controls, and never fails."""

    cc: float = 0.06
    cg: float = 3e-4
    period: float = 0.1

    @property
    def information(self) -> str:
        return "sensors"

    def init(self) -> tuple[float]:
        return (0.0,)

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        return (self.cc, self.cg), state


class Raises(NamedTuple):
    """Raises, compiled."""

    cg: float = 3e-4
    period: float = 0.1
    information = Well.information
    init = Well.init

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        if t > GIVEN_UP:
            raise ValueError("no more")
        return (0.06, self.cg), state


class Beyond(NamedTuple):
    """Reads beyond its table, compiled."""

    table: tuple[float, ...] = (3e-4, 3e-4)
    period: float = 0.1
    information = Well.information
    init = Well.init

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        return (0.06, self.table[int(t / 15.0)]), state


class Divides(NamedTuple):
    """Divides by zero, compiled; the quotient is hidden by a limit."""

    cg: float = 3e-4
    period: float = 0.1
    information = Well.information
    init = Well.init

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        left = 1.0 if t <= GIVEN_UP else 0.0
        return (0.06, min(self.cg / left, 0.01)), state


class Nothing(NamedTuple):
    """Carries what is no number in its state, compiled."""

    cg: float = 3e-4
    period: float = 0.1
    information = Well.information
    init = Well.init

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        huge = 1e308 if t > GIVEN_UP else 1.0
        return (0.06, self.cg), (huge * 10.0 - huge * 10.0,)


class Half(NamedTuple):
    """One of its two controls is no number, compiled."""

    cg: float = 3e-4
    period: float = 0.1
    information = Well.information
    init = Well.init

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        huge = 1e308 if t > GIVEN_UP else 1.0
        return (0.06, self.cg + (huge * 10.0 - huge * 10.0)), (state[0] + 1.0,)


class Endless(NamedTuple):
    """Never comes back, compiled."""

    cg: float = 3e-4
    period: float = 0.1
    information = Well.information
    init = Well.init

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        x = 0.0
        while t > GIVEN_UP:
            x = 0.5 * x + 1.0
        return (0.06, self.cg + 0.0 * x), state


class Plain:
    """A law with hidden state, as plain Python."""

    period, information = 0.1, "sensors"

    def __init__(self) -> None:
        self.calls = 0

    def init(self) -> tuple[float]:
        return (0.0,)

    def step(self, t: float, y: Any, state: Any) -> Any:
        self.calls += 1
        COUNT[0] += 1
        return self.late() if t > GIVEN_UP else ((0.06, 3e-4), state)

    def late(self) -> Any:
        return (0.06, 3e-4 * (1.0 + 1e-6 * (self.calls + COUNT[0]))), (0.0,)


class Exits(Plain):
    def late(self) -> Any:
        sys.exit(0)


class Dies(Plain):
    def late(self) -> Any:
        os._exit(0)


class Sleeps(Plain):
    def late(self) -> Any:
        time.sleep(3600.0)


class Infinite(Plain):
    def late(self) -> Any:
        return (0.06, float("inf")), (0.0,)


class Three(Plain):
    def late(self) -> Any:
        return 0.06, 3e-4, (0.0,)


class Words(Plain):
    def late(self) -> Any:
        return ("much", "little"), (0.0,)


class Interrupts(Plain):
    def late(self) -> Any:
        raise MemoryError("full")
