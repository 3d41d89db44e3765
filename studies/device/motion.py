"""How a device moves: natural frequencies, lock capacity and slip in a regular wave, by closed formulas."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gyroctl.froude import growth
from gyroctl.orbits.flow import Forcing
from gyroctl.orbits.guess import estimated_share
from gyroctl.orbits.wave import Wave
from gyroctl.plant import Plant
from gyroctl.plant.kernel import slip_rate
from gyroctl.simulation.ensemble import UNSTABLE

COUPLING, LOAD = 0.052, 1e-4
"""Controls at which slip and lock are told, at the size of Table 1. [Nms]"""


class Oscillation(NamedTuple):
    """A motion of the float in still water, the ring at rest."""

    frequency: float  # [rad/s]
    damping: float  # ratio [-]


class Lock(NamedTuple):
    """What a regular wave can pull, estimated by harmonic balance."""

    height: float  # [m]
    wp: float  # [rad/s]
    sense: int  # of rotation in which more is pulled
    capacity: float  # largest cg of the lock [Nms]
    power: float  # at that load [W]


class Slip(NamedTuple):
    """How fast the slip of the coupling decays."""

    coupling: float  # [Nms]
    rate: float  # [1/s]
    largest: float  # coupling that is stable at the usual step [Nms]


def oscillations(plant: Plant) -> dict[str, Oscillation | None]:
    """Natural oscillations of phi1 and phi3 with radiation and hinge damping; None where the float only creeps back.

    Roots of (J + Jh) s^2 + d s + k + s P(s)/Q(s).
    """
    k = plant.coefficients
    found: dict[str, Oscillation | None] = {}
    for name, inverse, spring, hinge, radiation in (
        ("phi1", k.i1, k.k1, k.d1, plant.radiation[0]),
        ("phi3", k.i3, k.k3, k.d3, plant.radiation[1]),
    ):
        denominator = [1.0, *radiation.q]
        body = np.polymul([1.0 / inverse, hinge, spring], denominator)
        roots = np.roots(np.polyadd(body, np.polymul([1.0, 0.0], radiation.p)))
        turning = [root for root in roots if root.imag > 1e-9 * abs(root)]
        wanted = math.sqrt(spring * inverse)
        root = min(turning, key=lambda r: abs(abs(r) - wanted)) if turning else None
        found[name] = None if root is None else Oscillation(float(abs(root)), float(-root.real / abs(root)))
    return found


def lock(plant: Plant, height: float | None = None, wp: float | None = None) -> Lock | None:
    """Lock capacity in a regular wave, by default 0.2 m at 3.14 rad/s as Table 1 is long; None if it pulls nowhere."""
    length, plain = plant.parameters.length_scale, plant.smooth
    at = Wave(height or 0.2 * length, wp or 3.14 * growth("rad/s", length))
    load = LOAD * growth("Nms", length)
    forcing = Forcing.of(plain, at)
    shares = {sense: estimated_share(plain, forcing, load, sense) for sense in (1, -1)}
    sense = min(shares, key=lambda one: shares[one])
    if not math.isfinite(shares[sense]):
        return None
    capacity = load / shares[sense]
    return Lock(at.height, at.wp, sense, capacity, capacity * (plant.parameters.N * at.wp) ** 2)


def slip(plant: Plant) -> Slip:
    """Decay of the slip at a usual coupling, and the largest coupling that the usual step allows."""
    coupling = COUPLING * growth("Nms", plant.parameters.length_scale)
    rate: Any = float(slip_rate(plant.rolling.coefficients, coupling))
    largest = math.inf if rate == 0.0 else coupling * UNSTABLE / (plant.step * rate)
    return Slip(coupling, rate, largest)
