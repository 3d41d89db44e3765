"""Wave clock: frequency, phase and height of the waves as the float feels them; shared by the laws of this folder.

A phase-locked loop of second order on the rates of the float. Of ``phi1' + i phi3'`` the part that turns with the ring
goes as ``exp(-i theta)``; turned by the loop's own angle it stands still, and its imaginary part over the size of the
rates is the sine of the phase error. The loop is what a ring without load and without inertia would do: it needs no
lock of the ring, and so tells a ring that falls behind from waves that become longer. (The slowly filtered ring speed
does not: it follows a ring that stalls.)

The rates are smoothed before: in a broad sea they hold much of the waves above the peak, and the clock would run up to
a sixth too fast (3.6 rad/s at a peak of 3.14 and gamma 1; smoothed over 0.3 s 3.1 to 3.2 at any gamma). What the
smoothing turns the phase by is known, `upright` takes it out.

Source: F. M. Gardner, Phaselock Techniques, 3rd ed., Wiley 2005, chapter 2; critically damped. The error is taken over
a slow amplitude, so that high waves count more than the lulls between them, where the phase of an irregular sea jumps.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from gyroctl.plant.compiled import inlined

SLOWEST, FASTEST = 1.5, 6.0
"""Frequencies between which the clock stays. [rad/s]"""

SMOOTH = 0.3
"""Time constant of the rates that the clock sees. [s]"""

QUIET = 1e-4
"""Mean square of the float rates below which there are no waves to speak of. [rad^2/s^2]"""

TURN = 2.0 * math.pi


class WaveClock(NamedTuple):
    """Settings of the clock."""

    bandwidth: float  # natural frequency of the loop [rad/s]
    memory: float  # longest time over which the mean square of the rates goes [s]
    wp: float = 3.14  # where it begins [rad/s]


class Clock(NamedTuple):
    """State of the clock."""

    theta: float  # angle of the loop [rad]
    speed: float  # its frequency, that of the waves [rad/s]
    square: float  # mean square of the float rates [rad^2/s^2]
    age: float  # time over which that mean goes, 0 before the first sample [s]
    calm1: float  # smoothed phi1' [rad/s]
    calm3: float  # smoothed phi3' [rad/s]


def begin(settings: WaveClock) -> Clock:
    """Return the clock before the first sample."""
    return Clock(0.0, settings.wp, 0.0, 0.0, 0.0, 0.0)


@inlined
def follow(settings: WaveClock, period: float, y: Any, clock: Clock) -> Clock:
    """Advance the clock by one sample of `period` [s] with the measurement `y`."""
    theta, square, calm1, calm3 = clock.theta, clock.square, clock.calm1, clock.calm3
    rates = y.phi1_rate * y.phi1_rate + y.phi3_rate * y.phi3_rate
    if clock.age == 0.0:
        theta, square, calm1, calm3 = y.psi, rates, y.phi1_rate, y.phi3_rate
    age = min(clock.age + period, settings.memory)  # a plain mean at first, so that a chance beginning is forgotten
    square += lag(period, age) * (rates - square)
    calm1 += lag(period, SMOOTH) * (y.phi1_rate - calm1)
    calm3 += lag(period, SMOOTH) * (y.phi3_rate - calm3)
    ahead = (math.sin(theta) * calm1 + math.cos(theta) * calm3) / math.sqrt(max(square, QUIET))
    bandwidth = settings.bandwidth
    speed = min(max(clock.speed - bandwidth * bandwidth * period * ahead, SLOWEST), FASTEST)
    # within one turn, so that a law's state is periodic in a regular wave and has a linear model
    theta = (theta + period * (speed - 2.0 * bandwidth * ahead)) % TURN
    return Clock(theta, speed, square, age, calm1, calm3)


@inlined
def height(clock: Clock) -> Any:
    """Root mean square V of the float rates, never zero. [rad/s]"""
    return math.sqrt(max(clock.square, QUIET))


@inlined
def upright(theta: float, speed: float, period: float) -> float:
    """Phase of the waves from the angle of the clock: without the turn of the smoothing, as it is sampled. [rad]"""
    keep = math.exp(-period / SMOOTH)
    return theta + math.atan2(keep * math.sin(speed * period), 1.0 - keep * math.cos(speed * period))


@inlined
def lag(period: float, time_constant: float) -> float:
    """Part of its way that a first-order lag goes in one sample. [-]"""
    return 1.0 - math.exp(-period / time_constant)


class Easing(NamedTuple):
    """How a load is eased off when the float swings far in phi1, the direction that only a light damping holds."""

    motion: float  # amplitude of phi1 at which the load is halved, whatever the sea: for the limit of motion [rad]
    relative: float  # and in units of the float's motion: a large share of phi1 tells of a ring near pull-out [-]
    recall: float  # time constant of that amplitude [s]


@inlined
def swung(easing: Easing, period: float, y: Any, swing: float) -> Any:
    """Square of the amplitude of phi1, filtered, after one sample. [rad^2]"""
    return swing + lag(period, easing.recall) * (2.0 * y.phi1 * y.phi1 - swing)


@inlined
def eased(easing: Easing, swing: float, V: float, speed: float) -> float:
    """Factor on a load, where the float's rates have the root mean square V and the waves the frequency `speed`."""
    limit = min(easing.motion, easing.relative * V / speed)
    part = swing / (limit * limit)
    return 1.0 / (1.0 + part * part)  # no power: Python's differs from compiled code's in the last bit, now and then
