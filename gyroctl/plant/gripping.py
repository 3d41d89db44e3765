"""How finely friction in the rolling contact has to be followed."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI, PSI_RATE, Coefficients, states_of
from gyroctl.plant.friction import CREEP, pressing

RESOLVED = 2.0
"""Largest product of step and rate of the friction: Runge-Kutta 4 is stable up to 2.78."""

FINER = 6.0
"""How much finer the contact is followed while it slides: it grips again within its own time constant. With less each
end of a slide would cost the energy ledger some mJ."""

CHANGING, CHANGE = 15.0, 8000.0
"""Load below which the axis may be about to change sides within 0.01 s [Nm], and the rate at which that is followed
[1/s]."""

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
    rate = contact.traction * abs(load) / CREEP * (k.Gpp + contact.N * contact.N * contact.ring)
    if abs(load) < CHANGING:
        return max(rate, CHANGE)
    slip = axis + math.copysign(contact.N, load) * w
    return FINER * rate if abs(slip) > CREEP else rate
