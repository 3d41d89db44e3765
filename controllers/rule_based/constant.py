"""Constant coupling and generator gain: the paper's device, and the yardstick of every law."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple


class Constant(NamedTuple):
    """Hold both controls."""

    cc: float = 0.052  # [Nms]
    cg: float = 3.5e-4  # [Nms]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["none"]:
        """What the law looks at."""
        return "none"

    def init(self) -> tuple[()]:
        """No state."""
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
        """Return the two constants."""
        return (self.cc, self.cg), state


def best_constant(gamma: float = 5.0) -> Constant:
    """Return the best constant pair found on the tuning seeds."""
    return Constant(cc=0.052, cg=5.0e-4)
