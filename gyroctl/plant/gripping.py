"""How finely friction in the rolling contact has to be followed."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI, PSI_RATE, Coefficients, states_of
from gyroctl.plant.friction import pressing

RESOLVED = 2.0
"""Largest product of step and rate of the friction: Runge-Kutta 4 is stable up to 2.78."""

FINER = 6.0
"""How much finer the contact is followed while it slides: it grips again within its own time constant. With less each
end of a slide would cost the energy ledger some mJ."""

MANY = 1000.0
"""More steps than a step of the plant is ever divided into."""


@inlined
def substeps(contact: Any, k: Coefficients, y: Any, h: float) -> int:
    """Number of steps into which the friction divides one of `h` [s] that begins at the state `y` of a single run."""
    if contact is None:
        return 1
    needed = h * stiffness(contact, k, y) / RESOLVED
    if needed < MANY:
        steps: int = max(math.ceil(needed), 1)
        return steps
    return 1  # the run has left all bounds


@inlined
def stiffness(contact: Any, k: Coefficients, y: Any) -> Any:
    """Rate at which friction stops the slip on the track, or at which the axis changes sides. [1/s]"""
    psi, v1, v3 = y[PSI].real, y[PHI1_RATE].real, y[PHI3_RATE].real
    w, axis = y[PSI_RATE].real, y[states_of(k) - 1].real
    load = pressing(k, math.cos(psi) * v1 - math.sin(psi) * v3, w, y[OMEGA_RATE].real, axis)
    rate = contact.traction * abs(load) / contact.creep * (k.Gpp + contact.N * contact.N * contact.ring)
    if abs(load) < contact.changing:
        return max(rate, contact.change)
    slip = axis + math.copysign(contact.N, load) * w
    return FINER * rate if abs(slip) > contact.creep else rate
