"""Coupling law: the magnetic coupling works within the cycle, the generator slowly and smoothly.

The flywheel stores minutes of output. So the generator may be slow: like the governor of a turbine it gives a power
that rises with the speed of the flywheel (a droop) about a level that goes with the height of the waves, and so holds
the flywheel a little below the speed of the ring's gear, which makes the slip that the coupling needs. The droop is on
the speed over V: the ring swings within the cycle as the waves are high, and the slip must go with it.

The coupling acts as a clipped semi-active brake on the ring: it can give a torque of the sign of the slip only, so it
gives the wanted torque where the instantaneous slip allows it and none elsewhere. (Filtering the slip instead gives
more power on paper, by sliding: the ring then stalls again and again.)

The torque wanted against the ring, with ``u1 + i u3 = exp(i psi)(phi1' + i phi3')`` and ``-J4 omega' u3`` the torque by
which the float drives the ring in (24):

- most of that driving torque, as it comes: what the float gives within the cycle goes straight through the coupling
  into the flywheel instead of swinging the ring. With a part in u1 beside it, it is the drive of a ring that stands a
  little behind the true one, which holds the true one back from pull-out. The two directions of the float have each
  their part: phi3 drives the ring, phi1 swings in a mode of its own that is lightly damped, and more than its drive
  handed on damps it;
- a part of the synchronising torque J4 omega' u1 where there is any;
- damping of the ring speed about the frequency of the waves (`wave_clock`).

The last but one and the generator ease off when the float swings far in phi1.

Source: clipped semi-active control, D. Karnopp, M. J. Crosby and R. A. Harwood, Vibration control using semi-active
force generators, J. Eng. Ind. 96 (1974) 619-626; the flywheel's droop is the governor of every turbine.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.controllers.rule_based.ring_guard import RingGuard, growing, held_up, straightened
from gyroctl.controllers.rule_based.wave_clock import Clock, Easing, WaveClock, begin, eased, follow, height, swung
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.readings import Readings, believed, safely, unread


class CouplingState(NamedTuple):
    """Wave clock; phi1 amplitude squared [rad^2]."""

    clock: Clock
    swing: float
    seen: Readings


@shown(law_face)
class Coupling(NamedTuple):
    """Torque on the ring by clipped coupling; generator power by a droop of the flywheel speed."""

    through1: float = 2.275  # part of the driving torque handed on, as far as it comes from phi1' [-]
    through3: float = 0.8904  # and from phi3' [-]
    direct1: float = 0.7507  # of the torque a quarter turn from it, in u1, as far as it comes from phi1' [-]
    direct3: float = 0.7673  # and from phi3' [-]
    margin: float = 0.4698  # of the synchronising torque left [-]
    damping: float = 0.2169  # of J4 omega' V per deviation of the ring speed [s/rad]
    easing: Easing = Easing(motion=0.2599, relative=2.547, recall=3.524)
    level: float = 0.2422  # generator power at no mean slip, as a part of J4 omega' V times the waves' frequency [-]
    droop: float = 0.09422  # rise of that part with the flywheel's speed over N V [-]
    clock: WaveClock = WaveClock(bandwidth=0.0815, memory=162.2)
    guard: RingGuard = RingGuard()
    spared: float = 0.0  # part of the generator that is not eased off [-]
    bend: float = 0.0  # slip at which the coupling has its greatest torque; 0: it goes with the slip [rad/s]
    cc_max: float = 0.12  # [Nms]
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
        return ("psi", "psi_rate", "omega_rate", "phi1", "phi1_rate", "phi3_rate")

    def init(self) -> CouplingState:
        """The clock begins at the first sample."""
        return CouplingState(begin(self.clock), 0.0, unread())

    def step(self, t: float, y: Any, state: CouplingState) -> tuple[tuple[float, float], CouplingState]:
        """Follow the waves, want a torque, give what the slip allows; regulate the flywheel."""
        y, seen = believed(self.period, self.N, y, state.seen)
        clock = follow(self.clock, self.period, y, state.clock)
        speed, V = clock.speed, height(clock)
        swing = swung(self.easing, self.period, y, state.swing)
        ease = eased(self.easing, swing, V, speed)

        c, s = math.cos(y.psi), math.sin(y.psi)
        pull = ease * self.margin * max(c * y.phi1_rate - s * y.phi3_rate, 0.0)
        pull += (self.direct1 * c - self.through1 * s) * y.phi1_rate
        pull -= (self.direct3 * s + self.through3 * c) * y.phi3_rate
        pull += self.damping * V * (y.psi_rate - speed)
        torque = self.J4 * y.omega_rate * pull  # against the ring [Nm]
        slip = self.N * y.psi_rate - y.omega_rate
        cc = 0.0
        if torque * slip > 0.0:
            cc = min(straightened(self.bend, slip, torque / (self.N * slip)), self.cc_max)
        u3 = growing(self.guard, self.period, s * y.phi1_rate + c * y.phi3_rate, state.seen)
        cc = held_up(self.guard, self, y, u3, speed, cc)

        part = self.level + self.droop * (y.omega_rate / self.N - speed) / V
        # the speed is kept off zero: a flywheel at rest must not ask for an infinite gain
        cg = (ease + self.spared * (1.0 - ease)) * part * self.J4 * V * speed / max(y.omega_rate, 20.0)
        return safely(seen, cc, min(max(cg, 0.0), self.cg_max)), CouplingState(clock, swing, seen)
