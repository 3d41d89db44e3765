"""Law by a table over the locked orbits: operating point and feedback gains, scheduled on what the sensors give.

The table is a grid over three slow quantities, all measured:

- the envelope V, modulus of the slow part of the co-rotating float rate ``u1 + i u3 = exp(i psi)(phi1' + i phi3')``:
  it stands for the wave height, since it is what can pull the ring;
- the peak frequency, as the mean rate at which the float's motion turns, weighted with its square: the ring speed less
  the rate of the load angle, so that a ring that lags behind does not pull its own reference down;
- the bandwidth, as the part of the square of that motion which the slow filter does not pass, over about a minute. (The
  variance of the envelope over its squared mean says nothing: within a minute it is .27 for gamma 1, 5 and 50.)

A cell holds the coupling, the share of the lock capacity that is used, by the generator and by what turns the flywheel
down without it (`bearing`, `windage`), and the course of a few signals on
its orbit, and gains on their deviations: envelope and load angle of a brisker filter (the angle by its sine, so that a
ring that slips a turn asks for no more than one that lags), ring speed, flywheel speed, and what is left of phi1 and
its rate beside the wave's frequency, the swing of the lightly damped horizontal mode. The gains on the ring speed vary
with twice the ring angle and those on the swing with the ring angle: no others act on slow motions, by the half-period
symmetry of the device. Between the nodes every number of the table is interpolated linearly in each direction, so that
the command is continuous; outside, the nearest edge is taken and the sample is counted. The share is one of the live
envelope everywhere, so that the generator lets go altogether where the losses alone take it: in a lull.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.controllers.gain_scheduled.designs import designed
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.compiled import inlined
from gyroctl.plant.readings import Readings, believed, safely, unread

SWING = ("swing_cos", "swing_sin", "swing_rate_cos", "swing_rate_sin")
SIGNALS = ("envelope", "angle", "speed", "speed_cos2", "speed_sin2", "flywheel", *SWING)
"""Deviations that are fed back, in the order of the gains."""

POINT = ("cc", "share", "angle_cos", "angle_sin", "speed_cos2", "speed_sin2", "flywheel")
"""Operating point: coupling [Nms], generator gain and losses as a part of the lock capacity J4 V/N, load angle, ring
speed at twice the ring angle [rad/s], omega'/(N w)."""

ROW = len(POINT) + 2 * len(SIGNALS)
"""Numbers of a cell: operating point, gains to cc, gains to cg."""


class ScheduledState(NamedTuple):
    """Filters of the law.

    Slow and brisk parts of u1, u3 and the latter filtered again [rad/s]; ring speed [rad/s]; means of the squares
    of the slow and brisk envelopes [rad^2/s^2], of that filtered again times its rate of turning, and of its
    square; parts of phi1 [rad] and phi1' [rad/s] that turn with the ring; samples outside the table; 1 once begun; the
    last readings.
    """

    U1: float  # slow part of u1 [rad/s]
    U3: float  # and of u3 [rad/s]
    V1: float  # brisk part of u1 [rad/s]
    V3: float  # and of u3 [rad/s]
    W1: float  # the brisk part filtered again, of u1 [rad/s]
    W3: float  # and of u3 [rad/s]
    speed: float  # ring speed [rad/s]
    slow_square: float  # mean square of the slow envelope [rad^2/s^2]
    square: float  # of the brisk one [rad^2/s^2]
    turning: float  # of that filtered again times its rate of turning [rad^3/s^3]
    weight: float  # of its square [rad^2/s^2]
    phi_c: float  # part of phi1 that turns with the ring, as its cosine [rad]
    phi_s: float  # as its sine [rad]
    rate_c: float  # part of phi1' that does, as its cosine [rad/s]
    rate_s: float  # as its sine [rad/s]
    clamped: float  # samples outside the table [-]
    begun: float  # 1 once begun [-]
    seen: Readings  # the last readings


@shown(law_face)
class Scheduled(NamedTuple):
    """Both controls from the table: operating point plus gains times deviations.

    The tables are tuples of floats; `gyroctl.controllers.gain_scheduled.table` reads them from a file.
    """

    envelopes: tuple[float, ...]  # nodes of V, increasing [rad/s]
    frequencies: tuple[float, ...]  # nodes of the peak frequency, increasing [rad/s]
    bandwidths: tuple[float, ...]  # nodes of the bandwidth, increasing [-]
    cells: tuple[float, ...]  # rows of ROW numbers, envelope slowest, then frequency, bandwidth [units of the cell]
    load: float = 1.0  # factor on the generator gain of the operating point [-]
    effort: float = 1.0  # factor on the feedback [-]
    slow: float = 5.0  # time constant of the envelope [s]
    brisk: float = 1.2  # time constant of the load angle [s]
    fast: float = 0.2  # time constant of the ring speed [s]
    memory: float = 60.0  # time constant of peak frequency and bandwidth [s]
    notch: float = 5.0  # time constant of the part of phi1 that turns with the ring [s]
    least: float = 0.01  # floor of the envelope, where an angle says nothing [rad/s]
    cc_min: float = 0.03  # the feedback goes no lower: at less the horizontal swing grows [Nms]
    cc_max: float = 0.12  # [Nms]
    cg_max: float = 0.02  # [Nms]
    wp: float = 3.14  # peak frequency at the start [rad/s]
    N: float = 22.555555555555557  # gear ratio [-]
    J4: float = 0.3671  # inertia of the flywheel [kg m^2]
    bearing: float = 0.0  # friction of the flywheel's bearing that is taken off the share [Nm]
    windage: float = 0.0  # and its windage [Nms^2]
    counting: float = 1.0  # 0: samples outside the table are not counted [-]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by; the flywheel's speed where any cell feeds it back."""
        gains = (len(POINT) + n * len(SIGNALS) + SIGNALS.index("flywheel") for n in range(2))
        spin = any(self.cells[row + gain] for gain in gains for row in range(0, len(self.cells), ROW))
        return ("psi", "psi_rate", *(("omega_rate",) if spin else ()), "phi1", "phi1_rate", "phi3_rate")

    def init(self) -> ScheduledState:
        """Filters are filled by the first sample; the peak frequency starts at `wp`."""
        return ScheduledState._make([*[0.0] * (len(ScheduledState._fields) - 1), unread()])

    def clamped(self, state: ScheduledState) -> int:
        """Samples so far at which the schedule was asked outside its table."""
        return round(state.clamped)

    def counters(self, state: ScheduledState) -> dict[str, int]:
        """Counts of a run from its last state."""
        return {"clamped": self.clamped(state)}

    def uncounted(self) -> Scheduled:
        """Return the same law without its count: what only counts does not come back after a wave."""
        return self._replace(counting=0.0)

    def designed(self) -> dict[str, Any] | None:
        """Cells of the law's table with their margins; None where no table of these numbers is known."""
        return designed(self)

    def step(self, t: float, y: Any, state: ScheduledState) -> tuple[tuple[float, float], ScheduledState]:
        """Filter, look up, feed back."""
        y, seen = believed(self.period, self.N, y, state.seen)
        c, s = math.cos(y.psi), math.sin(y.psi)
        u1 = c * y.phi1_rate - s * y.phi3_rate
        u3 = s * y.phi1_rate + c * y.phi3_rate
        first = state.begun == 0.0
        slow = 1.0 if first else 1.0 - math.exp(-self.period / self.slow)
        brisk = 1.0 if first else 1.0 - math.exp(-self.period / self.brisk)
        fast = 1.0 if first else 1.0 - math.exp(-self.period / self.fast)
        memory = 1.0 if first else 1.0 - math.exp(-self.period / self.memory)
        notch = 1.0 - math.exp(-self.period / self.notch)
        U1 = state.U1 + slow * (u1 - state.U1)
        U3 = state.U3 + slow * (u3 - state.U3)
        V1 = state.V1 + brisk * (u1 - state.V1)
        V3 = state.V3 + brisk * (u3 - state.V3)
        speed = state.speed + fast * (y.psi_rate - state.speed)
        square = state.square + memory * (V1 * V1 + V3 * V3 - state.square)
        slow_square = state.slow_square + memory * (U1 * U1 + U3 * U3 - state.slow_square)
        # filtered twice: the part of the float's motion that turns backwards would pull the frequency down
        W1 = state.W1 + brisk * (V1 - state.W1)
        W3 = state.W3 + brisk * (V3 - state.W3)
        turned = 0.0 if first else (state.W1 * W3 - state.W3 * W1) / self.period
        weight = state.weight + memory * (W1 * W1 + W3 * W3 - state.weight)
        rate = self.wp * weight if first else y.psi_rate * (W1 * W1 + W3 * W3) - turned
        turning = state.turning + memory * (rate - state.turning)

        envelope = math.sqrt(U1 * U1 + U3 * U3)
        frequency = turning / max(weight, 1e-9)
        bandwidth = 1.0 - slow_square / max(square, 1e-9)
        i, a, outside_i = _locate(self.envelopes, envelope)
        j, b, outside_j = _locate(self.frequencies, frequency)
        k, d, outside_k = _locate(self.bandwidths, bandwidth)
        outside = 1.0 if outside_i + outside_j + outside_k > 0 else 0.0
        across = ROW * len(self.bandwidths)
        here = (
            across * (i * len(self.frequencies) + j) + ROW * k,
            across * len(self.frequencies) if i + 1 < len(self.envelopes) else 0,
            across if j + 1 < len(self.frequencies) else 0,
            ROW if k + 1 < len(self.bandwidths) else 0,
        )
        at = (a, b, d)

        # what is left of phi1 and its rate beside the part that turns with the ring
        swing = y.phi1 - state.phi_c * c - state.phi_s * s
        swing_rate = y.phi1_rate - state.rate_c * c - state.rate_s * s
        phi_c, phi_s = state.phi_c + 2.0 * notch * swing * c, state.phi_s + 2.0 * notch * swing * s
        rate_c, rate_s = state.rate_c + 2.0 * notch * swing_rate * c, state.rate_s + 2.0 * notch * swing_rate * s
        cos2, sin2 = c * c - s * s, 2.0 * s * c
        size = math.sqrt(V1 * V1 + V3 * V3 + self.least * self.least)
        off = speed - frequency - _mix(self.cells, here, at, 4) * cos2 - _mix(self.cells, here, at, 5) * sin2
        deviations = (
            size - envelope,
            (V3 * _mix(self.cells, here, at, 2) - V1 * _mix(self.cells, here, at, 3)) / size,
            off,
            off * cos2,
            off * sin2,
            y.omega_rate / self.N - _mix(self.cells, here, at, 6) * frequency,
            swing * c,
            swing * s,
            swing_rate * c,
            swing_rate * s,
        )
        cc = _mix(self.cells, here, at, 0)
        cg = self.load * _mix(self.cells, here, at, 1) * self.J4 * envelope / self.N
        cg -= losses(self.bearing, self.windage, self.N * frequency)
        for n in range(len(SIGNALS)):
            cc += self.effort * _mix(self.cells, here, at, len(POINT) + n) * deviations[n]
            cg += self.effort * _mix(self.cells, here, at, len(POINT) + len(SIGNALS) + n) * deviations[n]

        # the count of samples outside is rounded so that it carries no derivative: margins are those of the feedback
        out = math.floor(state.clamped + 0.5) + self.counting * outside
        command = safely(seen, min(max(cc, self.cc_min), self.cc_max), min(max(cg, 0.0), self.cg_max))
        means, parts = (slow_square, square, turning, weight), (phi_c, phi_s, rate_c, rate_s)
        return command, ScheduledState(U1, U3, V1, V3, W1, W3, speed, *means, *parts, out, 1.0, seen)


@inlined
def losses(bearing: Any, windage: Any, speed: Any) -> Any:
    """Generator gain that would brake as bearing and windage do, at a flywheel speed [rad/s]. [Nms]"""
    return bearing / max(speed, 1.0) + windage * speed


@inlined
def _locate(nodes: Any, value: Any) -> Any:
    """Interval of `value` among the nodes, its place in it from 0 to 1, and 1 where it is outside the nodes."""
    last = len(nodes) - 1
    if last == 0:
        return 0, 0.0, 0
    if value < nodes[0]:
        return 0, 0.0, 1
    if value > nodes[last]:
        return last - 1, 1.0, 1
    i = 0
    while i < last - 1 and value >= nodes[i + 1]:
        i += 1
    return i, (value - nodes[i]) / (nodes[i + 1] - nodes[i]), 0


@inlined
def _mix(cells: Any, here: Any, at: Any, entry: int) -> Any:
    """One number of the table, linear in each of the three directions."""
    corner, di, dj, dk = here
    a, b, d = at
    o = corner + entry
    low = (1.0 - b) * ((1.0 - d) * cells[o] + d * cells[o + dk])
    low += b * ((1.0 - d) * cells[o + dj] + d * cells[o + dj + dk])
    high = (1.0 - b) * ((1.0 - d) * cells[o + di] + d * cells[o + di + dk])
    high += b * ((1.0 - d) * cells[o + di + dj] + d * cells[o + di + dj + dk])
    return (1.0 - a) * low + a * high
