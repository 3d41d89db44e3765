"""A law of one's own: it eases the generator when the ring slows down."""

from __future__ import annotations

from typing import Any, NamedTuple


class State(NamedTuple):
    speed: float  # slow part of the ring speed [rad/s]


class MyLaw(NamedTuple):
    """Constant coupling; generator gain by the slow ring speed."""

    cc: float = 0.06  # [Nms]
    cg: float = 5e-4  # at the speed of the waves [Nms]
    gain: float = 5e-4  # per deviation of the ring speed [Nms/(rad/s)]
    slow: float = 0.3  # part of a new measurement taken at each sample [-]
    period: float = 0.1  # [s]

    @property
    def information(self) -> str:
        return "sensors"

    def init(self) -> State:
        return State(3.14)

    def step(self, t: float, y: Any, state: State) -> tuple[tuple[float, float], State]:
        speed = state.speed + self.slow * (y.psi_rate - state.speed)
        cg = self.cg + self.gain * (speed - 3.14)
        return (self.cc, min(max(cg, 0.0), 0.02)), State(speed)
