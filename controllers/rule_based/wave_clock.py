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
from typing import Any

from gyroctl.plant.compiled import inlined

SLOWEST, FASTEST = 1.5, 6.0
"""Frequencies between which the clock stays. [rad/s]"""

SMOOTH = 0.3
"""Time constant of the rates that the clock sees. [s]"""

QUIET = 1e-4
"""Mean square of the float rates below which there are no waves to speak of. [rad^2/s^2]"""

TURN = 2.0 * math.pi

Clock = tuple[float, float, float, float, float, float]


def begin(wp: float) -> Clock:
    """Return the clock before the first sample, at the frequency `wp` [rad/s]: first fields of a law's state.

    These are theta [rad] and speed [rad/s] of the loop, square, the mean square of the float rates [rad^2/s^2], age,
    the time over which that mean goes [s], and calm1, calm3, the smoothed rates [rad/s].
    """
    return 0.0, wp, 0.0, 0.0, 0.0, 0.0


@inlined
def follow(y: Any, state: Any, period: float, bandwidth: float, memory: float) -> Clock:
    """Advance the clock by one sample.

    Parameters
    ----------
    y : Measurement
        Of this sample.
    state : NamedTuple
        State of the law, with the fields that `begin` names.
    period : float
        Sampling period. [s]
    bandwidth : float
        Natural frequency of the loop. [rad/s]
    memory : float
        Longest time over which the mean square goes. [s]

    Returns
    -------
    tuple of float
        theta, speed, square, age, calm1, calm3 of the next sample.
    """
    theta, square, calm1, calm3 = state.theta, state.square, state.calm1, state.calm3
    rates = y.phi1_rate * y.phi1_rate + y.phi3_rate * y.phi3_rate
    if state.age == 0.0:
        theta, square, calm1, calm3 = y.psi, rates, y.phi1_rate, y.phi3_rate
    age = min(state.age + period, memory)  # a plain mean at first, so that a chance beginning is soon forgotten
    square += lag(period, age) * (rates - square)
    calm1 += lag(period, SMOOTH) * (y.phi1_rate - calm1)
    calm3 += lag(period, SMOOTH) * (y.phi3_rate - calm3)
    ahead = (math.sin(theta) * calm1 + math.cos(theta) * calm3) / math.sqrt(max(square, QUIET))
    speed = min(max(state.speed - bandwidth * bandwidth * period * ahead, SLOWEST), FASTEST)
    # within one turn, so that a law's state is periodic in a regular wave and has a linear model
    theta = (theta + period * (speed - 2.0 * bandwidth * ahead)) % TURN
    return theta, speed, square, age, calm1, calm3


@inlined
def upright(theta: float, speed: float, period: float) -> float:
    """Phase of the waves from the angle of the clock: without the turn of the smoothing, as it is sampled. [rad]"""
    keep = math.exp(-period / SMOOTH)
    return theta + math.atan2(keep * math.sin(speed * period), 1.0 - keep * math.cos(speed * period))


@inlined
def lag(period: float, time_constant: float) -> float:
    """Part of its way that a first-order lag goes in one sample. [-]"""
    return 1.0 - math.exp(-period / time_constant)


@inlined
def easing(swing: float, motion: float, relative: float, V: float, speed: float) -> float:
    """Factor that eases a load off when the float swings far in phi1, the direction that only a light damping holds.

    Parameters
    ----------
    swing : float
        Square of the amplitude of phi1. [rad^2]
    motion : float
        Amplitude at which the load is halved [rad], whatever the sea: for the limit of the motion.
    relative : float
        Amplitude at which it is halved, in units of the float's motion V/speed [-], in whatever sea: a large share of
        phi1 in the motion tells of a ring near pull-out.
    V, speed : float
        Root mean square of the float rates and frequency of the waves. [rad/s]
    """
    limit = min(motion, relative * V / speed)
    return 1.0 / (1.0 + (swing / (limit * limit)) ** 2)
