"""Threshold law: two levels of load with hysteresis between them, as an operator would switch.

The device runs loaded while it has reserve and eased while it has not. Two signs of a reserve that is running out are
watched: the used share of the lock capacity, N cg/(J4 V) with V from the float's rate in the frame of the ring, and the
ring speed against that of the waves (`wave_clock`). Either of them past its threshold eases the load; both must be well
back, past thresholds of their own, before the full load returns. Between the thresholds nothing changes, so noise and
waves that come and go do not make it chatter.

The full load itself is a share of the capacity that goes slowly with the height of the waves; both levels have their
coupling.

Source: relay control with hysteresis is as old as the thermostat, Y. Z. Tsypkin, Relay Control Systems, Cambridge
University Press 1984; easing a synchronous generator near its pull-out is load shedding, P. Kundur, Power System
Stability and Control, McGraw-Hill 1994, section 11.1.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.controllers.rule_based.wave_clock import Clock, WaveClock, begin, follow, height, lag
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.readings import Readings, believed, safely, unread


class ThresholdState(NamedTuple):
    """Wave clock; slow parts of u1, u3 and of the ring speed [rad/s]; 1 while eased."""

    clock: Clock
    U1: float
    U3: float
    ring: float
    eased: float
    seen: Readings


@shown(law_face)
class Threshold(NamedTuple):
    """Two levels of generator gain and coupling, switched with hysteresis."""

    share: float = 0.2654  # full load, of the capacity J4 V/N by the height of the waves [-]
    eased: float = 0.1484  # part of it that remains when eased [-]
    cc_full: float = 0.05377  # coupling at full load [Nms]
    cc_eased: float = 0.06423  # and eased [Nms]
    used_high: float = 0.9084  # used share of the lock capacity above which the load is eased [-]
    used_low: float = 0.6414  # and below which it may return [-]
    speed_low: float = 0.8825  # ring speed, of that of the waves, below which the load is eased [-]
    speed_high: float = 0.9355  # and above which it may return [-]
    brisk: float = 2.791  # time constant of the lock capacity [s]
    fast: float = 2.096  # time constant of the ring speed [s]
    clock: WaveClock = WaveClock(bandwidth=0.1774, memory=42.11)
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
        return ("psi", "psi_rate", "phi1_rate", "phi3_rate")

    def init(self) -> ThresholdState:
        """Loaded, the clock begins at the first sample."""
        return ThresholdState(begin(self.clock), 0.0, 0.0, 0.0, 0.0, unread())

    def step(self, t: float, y: Any, state: ThresholdState) -> tuple[tuple[float, float], ThresholdState]:
        """Follow the waves, judge the reserve, switch."""
        y, seen = believed(self.period, self.N, y, state.seen)
        clock = follow(self.clock, self.period, y, state.clock)
        speed, V = clock.speed, height(clock)
        c, s = math.cos(y.psi), math.sin(y.psi)
        first = state.clock.age == 0.0
        brisk = 1.0 if first else lag(self.period, self.brisk)
        U1 = state.U1 + brisk * (c * y.phi1_rate - s * y.phi3_rate - state.U1)
        U3 = state.U3 + brisk * (s * y.phi1_rate + c * y.phi3_rate - state.U3)
        ring = state.ring + (1.0 if first else lag(self.period, self.fast)) * (y.psi_rate - state.ring)

        used = self.share * V / max(math.sqrt(U1 * U1 + U3 * U3), 0.01)  # of the lock capacity, by the full load
        eased = state.eased
        if used > self.used_high or ring < self.speed_low * speed:
            eased = 1.0
        elif used < self.used_low and ring > self.speed_high * speed:
            eased = 0.0
        cg = self.J4 * V / self.N * self.share * (1.0 if eased == 0.0 else self.eased)
        cc = self.cc_full if eased == 0.0 else self.cc_eased
        return safely(seen, cc, min(max(cg, 0.0), self.cg_max)), ThresholdState(clock, U1, U3, ring, eased, seen)
