"""Load-angle law: the generator takes a share of what the float can pull, and damps the ring's libration.

A locked ring is a synchronous machine. The float's rate, turned into the frame of the ring,
``u1 + i u3 = exp(i psi)(phi1' + i phi3')``, has the slow part ``U = V exp(i delta)``: V is the co-rotating rate that
can drive the ring and N cg/(J4 V) the used share of its pull-out torque (lock balance: <u3> = -N cg/J4). The law loads
the ring in three parts:

- a share of V, so that the load eases in a lull before the lock is lost;
- a share of U1 = V cos delta, the synchronising torque left: near pull-out it falls to zero and takes its load off, so
  that the angle at which the ring settles is stable wherever it is, tan(-delta) = margin for this part alone;
- the deviation of the ring speed from that of the waves (`wave_clock`): a ring that turns too fast stands in for a
  float that gives more than is taken.

All but the last ease off when the float swings far in phi1, the direction that only a light damping holds.

Source: the power-angle curve and the damping torque of the synchronous machine, P. Kundur, Power System Stability and
Control, McGraw-Hill 1994, chapters 2 and 12; the lock balance is from (24)-(25) of the paper.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.controllers.rule_based.wave_clock import Clock, Easing, WaveClock, begin, eased, follow, height, lag, swung
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.readings import Readings, believed, safely, unread


class LoadAngleState(NamedTuple):
    """Wave clock; phi1 amplitude squared [rad^2]; slow parts of u1, u3, faster ones of u1 and ring speed [rad/s]."""

    clock: Clock
    swing: float
    U1: float
    U3: float
    V1: float
    fast: float
    seen: Readings


@shown(law_face)
class LoadAngle(NamedTuple):
    """Generator gain from the share of lock capacity, its margin and the ring speed; coupling constant."""

    share: float = 0.3494  # of the lock capacity [-]
    margin: float = 0.7102  # of the synchronising torque left [-]
    damping: float = 0.5881  # of the capacity J4 V/N per deviation of the ring speed [s/rad]
    lean: float = 0.03581  # how much slower than the waves the ring may turn without damping [-]
    cc: float = 0.06874  # [Nms]
    slow: float = 5.164  # time constant of the capacity [s]
    brisk: float = 0.7045  # time constant of the synchronising torque [s]
    fast: float = 0.7216  # time constant of the ring speed [s]
    easing: Easing = Easing(motion=0.4909, relative=3.725, recall=2.946)
    clock: WaveClock = WaveClock(bandwidth=0.1218, memory=27.68)
    cg_max: float = 0.02  # [Nms]
    N: float = 22.555555555555557  # gear ratio [-]
    J4: float = 0.3671  # inertia of the flywheel [kg m^2]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by."""
        return ("psi", "psi_rate", "phi1", "phi1_rate", "phi3_rate")

    def init(self) -> LoadAngleState:
        """Filters are filled by the first sample."""
        return LoadAngleState(begin(self.clock), 0.0, 0.0, 0.0, 0.0, 0.0, unread())

    def step(self, t: float, y: Any, state: LoadAngleState) -> tuple[tuple[float, float], LoadAngleState]:
        """Follow the waves, filter, take the shares, add the damping."""
        y, seen = believed(self.period, self.N, y, state.seen)
        clock = follow(self.clock, self.period, y, state.clock)
        speed, V = clock.speed, height(clock)
        swing = swung(self.easing, self.period, y, state.swing)

        c, s = math.cos(y.psi), math.sin(y.psi)
        u1 = c * y.phi1_rate - s * y.phi3_rate
        u3 = s * y.phi1_rate + c * y.phi3_rate
        first = state.clock.age == 0.0
        slow = 1.0 if first else lag(self.period, self.slow)
        U1 = state.U1 + slow * (u1 - state.U1)
        U3 = state.U3 + slow * (u3 - state.U3)
        V1 = state.V1 + (1.0 if first else lag(self.period, self.brisk)) * (u1 - state.V1)
        fast = state.fast + (1.0 if first else lag(self.period, self.fast)) * (y.psi_rate - state.fast)

        pull = self.share * math.sqrt(U1 * U1 + U3 * U3) + self.margin * max(V1, 0.0)
        pull = pull * eased(self.easing, swing, V, speed)
        pull += self.damping * V * (fast - (1.0 - self.lean) * speed)
        cg = self.J4 / self.N * pull
        command = safely(seen, self.cc, min(max(cg, 0.0), self.cg_max))
        return command, LoadAngleState(clock, swing, U1, U3, V1, fast, seen)
