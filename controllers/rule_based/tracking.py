"""Frequency-tracking law: a phase-locked loop gives frequency and phase of the waves; both controls follow.

The wave clock (`wave_clock`) turns as a ring without load would. So the load angle is simply the angle of the ring
against the clock, ``delta = psi - theta``, and the slip of frequency is ``psi' - theta'``. No filter in the frame of
the ring is needed, and a peak frequency that drifts moves the law's whole operating point along:

- the generator takes a part of the capacity J4 V/N, and a part of what is left of it at this angle, V cos delta: it
  lets go where the ring falls a quarter turn behind the waves, and while it slips;
- it damps the speed of the ring against the clock;
- the coupling goes with the frequency of the waves, and is softened while the ring is behind: a softer coupling damps
  the libration more.

The generator eases off when the float swings far in phi1.

Source: phase-locked loops, F. M. Gardner, Phaselock Techniques, 3rd ed., Wiley 2005; scheduling on a tracked frequency
is how grid converters follow a weak grid, R. Teodorescu, M. Liserre and P. Rodriguez, Grid Converters for Photovoltaic
and Wind Power Systems, Wiley 2011, chapter 4.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.controllers.rule_based.wave_clock import (
    Clock,
    Easing,
    WaveClock,
    begin,
    eased,
    follow,
    height,
    lag,
    swung,
    upright,
)
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.readings import Readings, believed, safely, unread


class TrackingState(NamedTuple):
    """Wave clock; phi1 amplitude squared [rad^2]; ring speed [rad/s] and cos delta, filtered."""

    clock: Clock
    swing: float
    fast: float
    left: float
    seen: Readings


@shown(law_face)
class Tracking(NamedTuple):
    """Generator and coupling scheduled on frequency, height and phase of the waves."""

    share: float = 0.2676  # of the capacity J4 V/N [-]
    margin: float = 0.2539  # of the part V cos delta that is left of it [-]
    damping: float = 1.134  # of the capacity per deviation of the ring speed [s/rad]
    lean: float = 0.04065  # how much slower than the waves the ring may turn without damping [-]
    stiff: float = 0.06481  # coupling of a ring in phase, at the reference frequency [Nms]
    soften: float = -0.1382  # part of it taken away from a ring a quarter turn behind [-]
    rise: float = 0.2429  # power of the frequency with which the coupling goes [-]
    fast: float = 0.3483  # time constant of the ring speed and of cos delta [s]
    easing: Easing = Easing(motion=0.5313, relative=2.55, recall=1.741)
    clock: WaveClock = WaveClock(bandwidth=0.1342, memory=22.09)
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
        return ("psi", "psi_rate", "phi1", "phi1_rate", "phi3_rate")

    def init(self) -> TrackingState:
        """The clock begins at the first sample."""
        return TrackingState(begin(self.clock), 0.0, 0.0, 1.0, unread())

    def step(self, t: float, y: Any, state: TrackingState) -> tuple[tuple[float, float], TrackingState]:
        """Follow the waves, read the load angle, schedule both controls."""
        y, seen = believed(self.period, self.N, y, state.seen)
        clock = follow(self.clock, self.period, y, state.clock)
        speed, V = clock.speed, height(clock)
        swing = swung(self.easing, self.period, y, state.swing)
        begun = 1.0 if state.clock.age == 0.0 else lag(self.period, self.fast)
        fast = state.fast + begun * (y.psi_rate - state.fast)
        behind = (
            upright(state.clock.theta, state.clock.speed, self.period) - y.psi
        )  # load angle, from the clock of this sample [rad]
        left = state.left + (begun if state.clock.age > 0.0 else 0.0) * (math.cos(behind) - state.left)

        pull = self.share + self.margin * max(left, 0.0)
        pull = pull * eased(self.easing, swing, V, speed)
        pull += self.damping * (fast - (1.0 - self.lean) * speed)
        cg = self.J4 * V / self.N * pull
        cc = self.stiff * (speed / self.clock.wp) ** self.rise * (1.0 - self.soften * (1.0 - max(left, 0.0)))
        command = safely(seen, min(max(cc, 0.0), self.cc_max), min(max(cg, 0.0), self.cg_max))
        return command, TrackingState(clock, swing, fast, left, seen)
