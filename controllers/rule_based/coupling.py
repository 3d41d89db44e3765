"""Coupling law: the magnetic coupling works within the cycle, the generator slowly and smoothly.

The flywheel stores minutes of output. So the generator may be slow: it gives a power that a PI regulator sets to hold
the flywheel a little below the speed of the ring's gear, which makes the slip that the coupling needs. The coupling
acts as a clipped semi-active brake on the ring: it can give a torque of the sign of the slip only, so it gives the
wanted torque where the instantaneous slip allows it and none elsewhere. (Filtering the slip instead gives more power on
paper, by sliding: the ring then stalls again and again.)

The torque wanted against the ring, with ``u1 + i u3 = exp(i psi)(phi1' + i phi3')`` and ``-J4 omega' u3`` the torque by
which the float drives the ring in (24):

- most of that driving torque, as it comes: what the float gives within the cycle goes straight through the coupling
  into the flywheel instead of swinging the ring. With a part in u1 beside it, it is the drive of a ring that stands a
  little behind the true one, which holds the true one back from pull-out. The two directions of the float have each
  their part: one drives the ring, the other swings in a mode of its own that is lightly damped;
- a share of the lock capacity J4 omega' V and of the synchronising torque J4 omega' U1 that is left;
- damping of the ring speed about the peak frequency.

Shares and generator ease off when the float swings far in phi1, the direction that only a light damping holds.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple


class CouplingState(NamedTuple):
    """Slow parts of u1, u3 [rad/s], phi1 amplitude squared [rad^2], integral part of the power [W], 1 once begun."""

    U1: float
    U3: float
    swing: float
    power: float
    begun: float


class Coupling(NamedTuple):
    """Torque on the ring by clipped coupling; generator power by a slow PI on the flywheel speed."""

    through1: float = 1.14  # part of the driving torque handed on, as far as it comes from phi1' [-]
    through3: float = 0.8621  # and from phi3' [-]
    direct1: float = 0.8299  # of the torque a quarter turn from it, in u1, as far as it comes from phi1' [-]
    direct3: float = 0.6921  # and from phi3' [-]
    share: float = 0.04567  # of the lock capacity [-]
    margin: float = 0.3088  # of the synchronising torque left [-]
    damping: float = 17.98  # torque on the ring per deviation of its speed [Nms]
    slow: float = 0.5391  # time constant of V and of the synchronising torque [s]
    motion: float = 0.3516  # amplitude of phi1 at which shares and generator are halved [rad]
    recall: float = 3.303  # time constant of that amplitude [s]
    speed_ratio: float = 0.9349  # flywheel speed wanted, as a part of N wp [-]
    proportional: float = 0.2337  # generator power per deviation of the flywheel speed [W/(rad/s)]
    integral: float = 0.0003973  # and per its integral [W/rad]
    power: float = 3.0  # integral part at the start [W]
    cc_max: float = 0.12  # [Nms]
    cg_max: float = 0.02  # [Nms]
    wp: float = 3.14  # peak frequency, the speed that the ring is to keep [rad/s]
    N: float = 22.555555555555557  # gear ratio [-]
    J4: float = 0.3671  # inertia of the flywheel [kg m^2]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    def init(self) -> CouplingState:
        """Filters are filled by the first sample."""
        return CouplingState(0.0, 0.0, 0.0, self.power, 0.0)

    def step(self, t: float, y: Any, state: CouplingState) -> tuple[tuple[float, float], CouplingState]:
        """Filter, want a torque, give what the slip allows; regulate the flywheel."""
        c, s = math.cos(y.psi), math.sin(y.psi)
        u1 = c * y.phi1_rate - s * y.phi3_rate
        u3 = s * y.phi1_rate + c * y.phi3_rate
        slow = 1.0 if state.begun == 0.0 else 1.0 - math.exp(-self.period / self.slow)
        U1 = state.U1 + slow * (u1 - state.U1)
        U3 = state.U3 + slow * (u3 - state.U3)
        swing = state.swing + (1.0 - math.exp(-self.period / self.recall)) * (2.0 * y.phi1 * y.phi1 - state.swing)
        ease = 1.0 / (1.0 + (swing / (self.motion * self.motion)) ** 2)

        pull = ease * (self.share * math.sqrt(U1 * U1 + U3 * U3) + self.margin * max(U1, 0.0))
        pull += (self.direct1 * c - self.through1 * s) * y.phi1_rate
        pull -= (self.direct3 * s + self.through3 * c) * y.phi3_rate
        torque = self.J4 * y.omega_rate * pull + self.damping * (y.psi_rate - self.wp)  # against the ring [Nm]
        slip = self.N * y.psi_rate - y.omega_rate
        cc = 0.0
        if torque * slip > 0.0:
            cc = min(torque / (self.N * slip), self.cc_max)

        error = y.omega_rate - self.speed_ratio * self.N * self.wp
        power = max(state.power + self.integral * self.period * error, 0.0)
        # the square is kept off zero: a flywheel at rest must not ask for an infinite gain
        cg = ease * (power + self.proportional * error) / max(y.omega_rate * y.omega_rate, 400.0)
        return (cc, min(max(cg, 0.0), self.cg_max)), CouplingState(U1, U3, swing, power, 1.0)
