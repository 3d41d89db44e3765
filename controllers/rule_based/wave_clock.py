"""Wave clock: frequency, phase and height of the waves as the float feels them; shared by the laws of this folder.

A phase-locked loop of second order on the rates of the float. Of ``phi1' + i phi3'`` the part that turns with the ring
goes as ``exp(-i theta)``; turned by the loop's own angle it stands still, and its imaginary part over the size of the
rates is the sine of the phase error. The loop is what a ring without load and without inertia would do: it needs no
lock of the ring, and so tells a ring that falls behind from waves that become longer. The slowly filtered ring speed
does not: it follows a ring that stalls.

Source: the loop of a synchronous reference frame, F. M. Gardner, Phaselock Techniques, 3rd ed., Wiley 2005, chapter 2,
critically damped; normalising the error by a slow amplitude lets high waves count more than the lulls between them,
where the phase of an irregular sea jumps.
"""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined

SLOWEST, FASTEST = 1.5, 6.0
"""Frequencies between which the clock stays. [rad/s]"""

QUIET = 1e-4
"""Mean square of the float rates below which there are no waves to speak of. [rad^2/s^2]"""


@inlined
def follow(
    y: Any, theta: float, speed: float, square: float, age: float, period: float, bandwidth: float, memory: float
) -> tuple[float, float, float, float]:
    """Advance the clock by one sample.

    Parameters
    ----------
    y : Measurement
        Of this sample.
    theta, speed, square, age : float
        Its angle [rad], its frequency [rad/s], mean square of the float rates [rad^2/s^2] and the time over which this
        mean goes [s]; age 0 begins anew at the angle of the ring.
    period : float
        Sampling period. [s]
    bandwidth : float
        Natural frequency of the loop. [rad/s]
    memory : float
        Longest time over which the mean square goes. [s]

    Returns
    -------
    tuple of float
        theta, speed, square and age of the next sample.
    """
    rates = y.phi1_rate * y.phi1_rate + y.phi3_rate * y.phi3_rate
    if age == 0.0:
        theta, square = y.psi, rates
    age = min(age + period, memory)  # a plain mean at first, so that a chance beginning is soon forgotten
    square += lag(period, age) * (rates - square)
    ahead = (math.sin(theta) * y.phi1_rate + math.cos(theta) * y.phi3_rate) / math.sqrt(max(square, QUIET))
    speed = min(max(speed - bandwidth * bandwidth * period * ahead, SLOWEST), FASTEST)
    return theta + period * (speed - 2.0 * bandwidth * ahead), speed, square, age


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
        Amplitude at which the load is halved [rad], whatever the sea: the limit of the motion.
    relative : float
        Amplitude at which it is halved, in units of the float's motion V/speed [-], in whatever sea: a large share of
        phi1 in the motion tells of a ring near pull-out.
    V, speed : float
        Root mean square of the float rates and frequency of the waves. [rad/s]
    """
    limit = min(motion, relative * V / speed)
    return 1.0 / (1.0 + (swing / (limit * limit)) ** 2)
