"""Load-angle law: the generator takes a share of what the float can pull, and damps the ring's libration.

A locked ring is a synchronous machine. The float's rate, turned into the frame of the ring,
``u1 + i u3 = exp(i psi)(phi1' + i phi3')``, has the slow part ``U = V exp(i delta)``: V is the co-rotating rate that
can drive the ring and N cg/(J4 V) the used share of its pull-out torque (lock balance: <u3> = -N cg/J4). The law loads
the ring in three parts:

- a share of V, so that the load eases in a lull before the lock is lost;
- a share of U1 = V cos delta, the synchronising torque left: near pull-out it falls to zero and takes its load off, so
  that the angle at which the ring settles is stable wherever it is, tan(-delta) = margin for this part alone;
- the deviation of the ring speed, as a power-system stabiliser does on a synchronous machine.

All but the last ease off when the float swings far in phi1, the direction that only a light damping holds.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple


class LoadAngleState(NamedTuple):
    """Slow parts of u1, u3, faster part of u1, ring speed [rad/s], phi1 amplitude squared [rad^2], 1 once begun."""

    U1: float
    U3: float
    V1: float
    speed: float
    swing: float
    begun: float


class LoadAngle(NamedTuple):
    """Generator gain from the share of lock capacity, its margin and the ring speed; coupling constant."""

    share: float = 0.6146  # of the lock capacity [-]
    margin: float = 0.629  # of the synchronising torque left [-]
    damping: float = 0.004897  # generator gain per deviation of the ring speed [Nms/(rad/s)]
    cc: float = 0.06211  # [Nms]
    slow: float = 9.196  # time constant of V [s]
    brisk: float = 1.47  # time constant of the synchronising torque [s]
    fast: float = 0.4376  # time constant of the ring speed [s]
    motion: float = 0.546  # amplitude of phi1 at which the shares are halved [rad]
    recall: float = 2.968  # time constant of that amplitude [s]
    cg_max: float = 0.02  # [Nms]
    wp: float = 3.14  # peak frequency, the speed that the ring is to keep [rad/s]
    N: float = 22.555555555555557  # gear ratio [-]
    J4: float = 0.3671  # inertia of the flywheel [kg m^2]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    def init(self) -> LoadAngleState:
        """Filters are filled by the first sample."""
        return LoadAngleState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, t: float, y: Any, state: LoadAngleState) -> tuple[tuple[float, float], LoadAngleState]:
        """Filter, take the shares, add the damping."""
        c, s = math.cos(y.psi), math.sin(y.psi)
        u1 = c * y.phi1_rate - s * y.phi3_rate
        u3 = s * y.phi1_rate + c * y.phi3_rate
        first = state.begun == 0.0
        slow = 1.0 if first else 1.0 - math.exp(-self.period / self.slow)
        brisk = 1.0 if first else 1.0 - math.exp(-self.period / self.brisk)
        fast = 1.0 if first else 1.0 - math.exp(-self.period / self.fast)
        U1 = state.U1 + slow * (u1 - state.U1)
        U3 = state.U3 + slow * (u3 - state.U3)
        V1 = state.V1 + brisk * (u1 - state.V1)
        speed = state.speed + fast * (y.psi_rate - state.speed)
        swing = state.swing + (1.0 - math.exp(-self.period / self.recall)) * (2.0 * y.phi1 * y.phi1 - state.swing)

        ease = 1.0 / (1.0 + (swing / (self.motion * self.motion)) ** 2)
        pull = self.share * math.sqrt(U1 * U1 + U3 * U3) + self.margin * max(V1, 0.0)
        cg = self.J4 / self.N * ease * pull + self.damping * (speed - self.wp)
        return (self.cc, min(max(cg, 0.0), self.cg_max)), LoadAngleState(U1, U3, V1, speed, swing, 1.0)
