"""Load-angle law: the generator takes a share of what the float can pull, and damps the ring's libration.

A locked ring is a synchronous machine. The float's rate, turned into the frame of the ring,
``u1 + i u3 = exp(i psi)(phi1' + i phi3')``, has the slow part ``U = V exp(i delta)``: V is the co-rotating rate that can
drive the ring and N cg/(J4 V) the used share of its pull-out torque (lock balance, DESIGN: <u3> = -N cg/J4). The law
asks for a constant share of V, so that the load eases in a lull before the lock is lost, and adds a term on the
deviation of the ring speed, as a power-system stabiliser does on a synchronous machine.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple


class LoadAngleState(NamedTuple):
    """Slow parts of u1 and u3 [rad/s], filtered ring speed [rad/s], 1 after the first sample."""

    U1: float
    U3: float
    speed: float
    started: float


class LoadAngle(NamedTuple):
    """Generator gain from the share of lock capacity and the ring speed; coupling constant."""

    share: float = 0.25  # of the lock capacity [-]
    damping: float = 0.004  # generator gain per deviation of the ring speed [Nms/(rad/s)]
    slow: float = 4.0  # time constant of U [s]
    fast: float = 0.25  # time constant of the ring speed [s]
    cc: float = 0.104  # [Nms]
    cg_max: float = 0.02  # [Nms]
    wp: float = 3.14  # peak frequency, the speed that the ring is to keep [rad/s]
    capacity: float = 0.01628  # J4/N [kg m^2]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    def init(self) -> LoadAngleState:
        """Filters are filled by the first sample."""
        return LoadAngleState(0.0, 0.0, 0.0, 0.0)

    def step(self, t: float, y: Any, state: LoadAngleState) -> tuple[tuple[float, float], LoadAngleState]:
        """Filter, take the share, add the damping."""
        c, s = math.cos(y.psi), math.sin(y.psi)
        u1 = c * y.phi1_rate - s * y.phi3_rate
        u3 = s * y.phi1_rate + c * y.phi3_rate
        a = 1.0 - math.exp(-self.period / self.slow) if state.started > 0.0 else 1.0
        b = 1.0 - math.exp(-self.period / self.fast) if state.started > 0.0 else 1.0
        U1 = state.U1 + a * (u1 - state.U1)
        U3 = state.U3 + a * (u3 - state.U3)
        speed = state.speed + b * (y.psi_rate - state.speed)
        V = math.sqrt(U1 * U1 + U3 * U3)
        cg = self.share * self.capacity * V + self.damping * (speed - self.wp)
        return (self.cc, min(max(cg, 0.0), self.cg_max)), LoadAngleState(U1, U3, speed, 1.0)
