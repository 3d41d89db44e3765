"""Libration stabiliser: a load that follows the waves, and a power-system stabiliser that damps the swings about it.

The ring's libration is the rotor oscillation of a synchronous machine on a grid: slow, and damped by little more than
the slip. There a stabiliser adds to a steady operating point a signal made of the rotor speed: a washout takes out what
is lasting, so that the operating point stays, and a lead-lag turns the phase so that the torque comes with the speed.
Here:

- operating point: a share of the capacity J4 V/N with V from the height of the waves, and a constant coupling;
- governor: the lasting part of the ring speed's deviation from the waves (`wave_clock`) moves the load by a droop. The
  grid of a machine is stiff; the waves are not, and with the washout alone the ring drifts off and stalls;
- stabiliser: the rest, through the lead-lag, moves the load against it and may move the coupling: a softer coupling
  damps more.

The operating point eases off when the float swings far in phi1.

Source: F. P. deMello and C. Concordia, Concepts of synchronous machine stability as affected by excitation control,
IEEE Trans. Power App. Syst. 88 (1969) 316-329; P. Kundur, Power System Stability and Control, McGraw-Hill 1994,
section 12.5.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from gyroctl.controllers.rule_based.wave_clock import Clock, Easing, WaveClock, begin, eased, follow, height, lag, swung
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.readings import Readings, believed, safely, unread


class StabiliserState(NamedTuple):
    """Wave clock; phi1 amplitude squared [rad^2]; lasting speed deviation and lagged part of the rest [rad/s]."""

    clock: Clock
    swing: float
    lasting: float
    lagged: float
    seen: Readings


@shown(law_face)
class Stabiliser(NamedTuple):
    """Load-following operating point, governor on the lasting, stabiliser on the passing deviation of the speed."""

    share: float = 0.228  # of the capacity J4 V/N [-]
    steady: float = 0.07101  # coupling of the operating point [Nms]
    governor: float = 0.5193  # of the capacity per lasting deviation of the ring speed [s/rad]
    lean: float = 0.05729  # how much slower than the waves the ring may turn without it [-]
    stabiliser: float = 0.1902  # of the capacity per passing deviation [s/rad]
    soften: float = 0.1022  # part of the coupling taken away per passing deviation [s/rad]
    washout: float = 8.087  # time constant that parts lasting from passing [s]
    lead: float = 0.2827  # time constants of the lead-lag [s]
    behind: float = 0.8514  # [s]
    easing: Easing = Easing(motion=0.3071, relative=3.31, recall=1.579)
    clock: WaveClock = WaveClock(bandwidth=0.1269, memory=28.7)
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
        return ("psi_rate", "phi1", "phi1_rate", "phi3_rate")

    def init(self) -> StabiliserState:
        """The clock begins at the first sample."""
        return StabiliserState(begin(self.clock), 0.0, 0.0, 0.0, unread())

    def step(self, t: float, y: Any, state: StabiliserState) -> tuple[tuple[float, float], StabiliserState]:
        """Follow the waves, part the deviation by the washout, lead it, add it to the operating point."""
        y, seen = believed(self.period, self.N, y, state.seen)
        clock = follow(self.clock, self.period, y, state.clock)
        speed, V = clock.speed, height(clock)
        swing = swung(self.easing, self.period, y, state.swing)

        deviation = y.psi_rate - (1.0 - self.lean) * speed
        lasting = state.lasting + lag(self.period, self.washout) * (deviation - state.lasting)
        passing = deviation - lasting
        lagged = state.lagged + lag(self.period, self.behind) * (passing - state.lagged)
        signal = lagged + self.lead / self.behind * (passing - lagged)  # (1 + lead s)/(1 + behind s)

        pull = self.share * eased(self.easing, swing, V, speed)
        pull += self.governor * lasting + self.stabiliser * signal
        cg = self.J4 * V / self.N * pull
        cc = self.steady * (1.0 - self.soften * signal)
        command = safely(seen, min(max(cc, 0.0), self.cc_max), min(max(cg, 0.0), self.cg_max))
        return command, StabiliserState(clock, swing, lasting, lagged, seen)
