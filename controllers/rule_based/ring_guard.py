"""A guard of the ring speed: where the float would turn the ring back, the flywheel holds it up.

In real water the contact of the spin axis is one of friction: once the ring stands still within a cycle, the
gyroscopic moment presses the axis on the other side of its track, it rolls backwards, and the flywheel is torn down. So
the ring must keep a speed within the cycle, which the linear model never asks for.

The ring is light: at an open coupling the float's torque J4 omega' u3 of (24) changes its speed by some 2 rad/s in one
sample. What holds it is the flywheel, by the coupling: the slip is negative there, so the ring is driven. The
generator has no part in it, its torque is internal to the axis. So less load is no guard, and more coupling is one.

The contact hands on no more than its friction. It is pressed by M3 = J4 omega' psi', and so can hold the ring against
the float only while ``mu J4 omega' psi' > J4 omega' u3``: the ring must be faster than u3/mu, however strong the
coupling. A ring that has once become slower is lost. So the guard holds it up at u3/friction where it is told a
friction, and a growing u3 may be carried on by its own trend.

It is meant for laws that leave the coupling open for a part of the cycle; with one that is never open it acts seldom.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from gyroctl.plant.compiled import inlined
from gyroctl.plant.readings import Readings

RESERVE = 1.0
"""Least speed of the flywheel over that of the gear with which the guard reckons. [rad/s]"""


class RingGuard(NamedTuple):
    """Settings of the guard."""

    floor: float = 0.0  # ring speed that is held up, as a part of that of the waves; 0 for no guard [-]
    trend: float = 0.0  # time by which a growing rate of the float across the axis is carried on [s]
    friction: float = 0.0  # of the contact, as it is reckoned with: the ring is held at u3/friction too; 0 for not [-]
    cc_guard: float = 0.12  # largest coupling that the guard asks for [Nms]
    J2: float = 0.7477  # inertia of the ring with its gear [kg m^2]


@inlined
def growing(guard: RingGuard, period: float, u3: Any, last: Readings) -> Any:
    """Rate u3 of the float across the axis, or where it grows what its trend makes of it. [rad/s]

    `last` are the readings of the sample before, a `period` [s] ago.
    """
    if guard.trend > 0.0 and last.begun > 0.0:
        before = math.sin(last.psi) * last.phi1_rate + math.cos(last.psi) * last.phi3_rate
        return u3 + max(guard.trend / period * (u3 - before), 0.0)
    return u3


@inlined
def held_up(guard: RingGuard, law: Any, y: Any, u3: Any, speed: Any, cc: Any) -> Any:
    """Coupling of a law, or the larger one by which the flywheel holds up the ring. [Nms]

    The guard acts where the float brakes the ring and would have it below the floor within a period, if the coupling
    were open. Then it asks for the coupling that carries the float's torque at the floor:
    ``N cc (omega' - N floor) = J4 omega' u3``. The floor is that of the settings, or u3/friction where that is more.

    Parameters
    ----------
    guard : RingGuard
        Settings.
    law : NamedTuple
        With N, J4, period and the coupling's `bend` [rad/s], see `straightened`.
    y : Measurement
        As the law believes it.
    u3 : float
        Rate of the float across the spin axis, s phi1' + c phi3'. [rad/s]
    speed : float
        Frequency of the waves. [rad/s]
    cc : float
        What the law wants. [Nms]
    """
    if guard.floor > 0.0:
        least, brake = guard.floor * speed, law.J4 * y.omega_rate * u3
        if guard.friction > 0.0:
            least = max(least, u3 / guard.friction)
        if brake > 0.0 and y.psi_rate - law.period * brake / guard.J2 < least:
            slip = max(y.omega_rate - law.N * least, RESERVE)
            return max(cc, min(straightened(law.bend, slip, brake / (law.N * slip)), guard.cc_guard))
    return cc


@inlined
def straightened(bend: float, slip: Any, cc: Any) -> Any:
    """Command that gives the torque cc slip where that of the coupling falls beyond the slip `bend` [rad/s]. [Nms]

    The torque of an eddy-current coupling is cc slip/(1 + (slip/bend)^2); 0 stands for one that goes with the slip.
    """
    if bend > 0.0:
        part = slip / bend
        return cc * (1.0 + part * part)
    return cc
