"""Coupling law: the magnetic coupling works within the cycle, the generator slowly and smoothly.

The flywheel stores minutes of output. So the generator may be slow, a PI regulator that holds the flywheel a little
below the speed of the ring's gear, which makes the slip that the coupling needs; and the coupling acts as a clipped
semi-active damper on the ring: it can give a torque of the sign of the slip only, so it gives the wanted torque where
the instantaneous slip allows it and none elsewhere. Filtering the slip instead gives more power on paper, by sliding:
the ring then stalls again and again.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple


class CouplingState(NamedTuple):
    """Slow parts of u1, u3 and the ring speed [rad/s], the integral part of cg [Nms], 1 after the first sample."""

    U1: float
    U3: float
    speed: float
    integral: float
    started: float


class Coupling(NamedTuple):
    """Torque on the ring by clipped coupling; generator by a slow PI on the flywheel speed."""

    share: float = 0.3  # of the lock capacity [-]
    damping: float = 8.0  # torque on the ring per deviation of its speed [Nms]
    slow: float = 4.0  # time constant of U [s]
    fast: float = 0.15  # time constant of the ring speed [s]
    speed_ratio: float = 0.85  # flywheel speed wanted, as a part of N wp [-]
    proportional: float = 4.0e-5  # generator gain per deviation of the flywheel speed [Nms/(rad/s)]
    integral: float = 1.0e-6  # and per its integral [Nms/rad]
    cc_max: float = 0.3  # [Nms]
    cg_max: float = 0.02  # [Nms]
    wp: float = 3.14  # peak frequency [rad/s]
    N: float = 22.555555555555557  # gear ratio [-]
    J4: float = 0.3671  # [kg m^2]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    def init(self) -> CouplingState:
        """Filters are filled by the first sample."""
        return CouplingState(0.0, 0.0, 0.0, 3.5e-4, 0.0)

    def step(self, t: float, y: Any, state: CouplingState) -> tuple[tuple[float, float], CouplingState]:
        """Filter, want a torque, give what the slip allows; regulate the flywheel."""
        c, s = math.cos(y.psi), math.sin(y.psi)
        u1 = c * y.phi1_rate - s * y.phi3_rate
        u3 = s * y.phi1_rate + c * y.phi3_rate
        a = 1.0 - math.exp(-self.period / self.slow) if state.started > 0.0 else 1.0
        b = 1.0 - math.exp(-self.period / self.fast) if state.started > 0.0 else 1.0
        U1 = state.U1 + a * (u1 - state.U1)
        U3 = state.U3 + a * (u3 - state.U3)
        speed = state.speed + b * (y.psi_rate - state.speed)
        V = math.sqrt(U1 * U1 + U3 * U3)

        # torque that brakes the ring and drives the flywheel, on the flywheel's side of the gear
        slip = self.N * y.psi_rate - y.omega_rate
        torque = (self.share * self.J4 * V * y.omega_rate + self.damping * (speed - self.wp)) / self.N
        cc = 0.0
        if torque * slip > 0.0:
            cc = min(torque / slip, self.cc_max)

        error = y.omega_rate - self.speed_ratio * self.N * self.wp
        integral = min(max(state.integral + self.integral * self.period * error, 0.0), self.cg_max)
        cg = min(max(integral + self.proportional * error, 0.0), self.cg_max)
        return (cc, cg), CouplingState(U1, U3, speed, integral, 1.0)
