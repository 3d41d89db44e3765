"""What a law goes by where a sensor is lost: of an angle and its rate, each stands in for the other.

A reading is not believed that is no number, or that repeats the last one to the bit or is exactly zero while its
partner says otherwise: a sensor with noise never gives the same bits twice. For it stands

- the rate, the way that the angle has gone since the last sample;
- the angle, its last value and the way by the rate; those of the float fade, so that a bias of the rate stays small;
- the flywheel's speed, which hardly changes in seconds, its last value.

Where angle and rate of a joint are both lost the law is blind there: the ring is taken to turn with the flywheel, the
float to stand, and after a second the command is a cautious pair that holds lock in most seas, see `safely`.

As long as all is well the readings pass unchanged. Nothing here calls a function of `math` then: laws are
differentiated through it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from gyroctl.plant.compiled import inlined
from gyroctl.plant.measurement import Measurement

ANGLE = 0.01
"""Deviation from what the rate says, from which an angle that repeats itself is not believed. [rad]"""

RATE = 0.1
"""Deviation from what the angle says, from which a rate that repeats itself is not believed. [rad/s]"""

SPEED = 10.0
"""Deviation from its last value from which a flywheel's speed of zero is not believed. [rad/s]"""

FADE = 5.0
"""Time constant with which an angle of the float fades that is made from its rate. [s]"""

PATIENCE = 1.0
"""How long a law goes on blind. [s]"""

SAFE = (0.052, 2e-4)
"""Coupling and generator gain of a blind law: near the best constant pair's coupling, below half of its gain. [Nms]"""

TURN = 2.0 * math.pi


class Readings(NamedTuple):
    """Last readings that were numbers, what was believed, and for how long a law has been blind."""

    psi: float  # within a turn [rad]
    psi_rate: float  # [rad/s]
    phi1: float
    phi3: float
    phi1_rate: float
    phi3_rate: float
    at: float  # believed ring angle, within a turn [rad]
    spin: float  # believed speed of the flywheel [rad/s]
    tilt1: float  # believed phi1 [rad]
    tilt3: float  # believed phi3 [rad]
    blind: float  # [s]
    begun: float  # 1 after the first sample


def unread() -> Readings:
    """Before the first sample."""
    return Readings(*[0.0] * len(Readings._fields))


@inlined
def believed(period: float, N: float, y: Any, last: Readings) -> Any:
    """Measurement that a law goes by, and what is kept of it.

    Parameters
    ----------
    period : float
        Sampling period. [s]
    N : float
        Gear ratio.
    y : Measurement
        As the sensors tell it; NaN where one tells nothing.
    last : Readings
        Of the sample before.
    """
    fresh = last.begun == 0.0
    spin = y.omega_rate
    if spin - spin != 0.0 or (spin == 0.0 and last.spin > SPEED):
        spin = N * known(y.psi_rate, 0.0) if fresh else last.spin
    psi, psi_rate, dark = joint(period, 0.0, y.psi, y.psi_rate, last.psi, last.psi_rate, last.at, spin / N, fresh, TURN)
    phi1, phi1_rate, dark1 = joint(
        period, FADE, y.phi1, y.phi1_rate, last.phi1, last.phi1_rate, last.tilt1, 0.0, fresh, 0.0
    )
    phi3, phi3_rate, dark3 = joint(
        period, FADE, y.phi3, y.phi3_rate, last.phi3, last.phi3_rate, last.tilt3, 0.0, fresh, 0.0
    )
    blind = last.blind + period if dark or dark1 or dark3 else 0.0
    return Measurement(psi, psi_rate, spin, phi1, phi3, phi1_rate, phi3_rate), Readings(
        known(y.psi, last.psi) % TURN,
        known(y.psi_rate, last.psi_rate),
        known(y.phi1, last.phi1),
        known(y.phi3, last.phi3),
        known(y.phi1_rate, last.phi1_rate),
        known(y.phi3_rate, last.phi3_rate),
        psi % TURN,
        spin,
        phi1,
        phi3,
        blind,
        1.0,
    )


@inlined
def joint(
    period: float,
    fade: float,
    angle: Any,
    rate: Any,
    angle_before: Any,
    rate_before: Any,
    at: Any,
    otherwise: Any,
    fresh: bool,
    turn: float,
) -> Any:
    """Angle [rad] and rate [rad/s] of a joint as they are believed, and whether both are lost.

    Parameters
    ----------
    period, fade : float
        Sampling period and time constant with which an angle that is made from its rate fades, 0 for none. [s]
    angle, rate : float
        Readings.
    angle_before, rate_before : float
        Last readings that were numbers, the angle within a turn.
    at : float
        Angle that was believed last.
    otherwise : float
        Rate where nothing tells it. [rad/s]
    fresh : bool
        Whether this is the first sample.
    turn : float
        Period of the angle, 0 where it has none. [rad]
    """
    dark = False
    if fresh:
        return known(angle, 0.0), known(rate, otherwise), dark
    here = angle % turn if turn > 0.0 else angle
    still = here - here != 0.0 or here == angle_before or here == 0.0
    if rate - rate != 0.0 or rate == rate_before or rate == 0.0:
        guess = otherwise if still else way(here - at, turn) / period
        # the way since the last sample tells a mean: a gyro with a resolution tells zero wherever the float turns back
        if not abs(0.5 * (rate + rate_before) - guess) <= RATE:
            rate, dark = guess, still
    if still:
        guess = at + period * rate
        if fade > 0.0:
            guess *= 1.0 - period / fade
        # an encoder tells zero once in a while, and the rate may have changed on the way
        if not abs(way(here - guess, turn)) <= ANGLE + 0.5 * period * abs(rate - rate_before):
            angle = guess
    return angle, rate, dark


@inlined
def known(value: Any, other: Any) -> Any:
    """Return a reading, or another value where it is no number."""
    return value if value - value == 0.0 else other


@inlined
def way(difference: Any, turn: float) -> Any:
    """Shortest way that a difference of angles stands for. [rad]"""
    if turn > 0.0 and difference - difference == 0.0:
        return (difference + 0.5 * turn) % turn - 0.5 * turn
    return difference


@inlined
def safely(seen: Readings, cc: Any, cg: Any) -> Any:
    """Command of a law, or the safe pair where it has been blind for too long. [Nms]"""
    if seen.blind > PATIENCE:
        return SAFE
    return cc, cg
