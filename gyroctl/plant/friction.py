"""The rolling contact carried by friction: the spin axis may slip on its track, and change to its other side.

Rolling is a constraint, theta' = N psi', and the equations (22)-(25) have it built in. Here the speed theta' of the
spin axis is a state of its own, the last one, and friction is what drives it to the speed at which it would roll. The
gyroscopic moment M3 presses the axis on one side of the track or the other; on the other side it rolls backwards.
Without the accelerations in M3, a few thousandths of it, or friction would be an algebraic loop.

The inertia keeps its shape: axis and flywheel answer each alone to the lever, and the ring to neither, so that the text
of the equations is that of rolling with other constants. Where the contact rolls all of this is compiled away.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gyroctl.plant.compiled import inlined

SIDE = 1.0
"""Moment about which the axis changes to the other side of the track. [Nm]"""

CREEP = 2.0
"""Speed of slip about which friction changes its sign: below it the contact creeps. [rad/s]"""

SOFT = 0.01
"""Square of the moment about which the load on the contact changes its sign. [N^2 m^2]"""


CHANGING, CHANGE = 15.0, 8000.0
"""Load below which the axis may be about to change sides within 0.01 s [Nm], and the rate at which that is followed
[1/s]."""


class Friction(NamedTuple):
    """Friction between spin axis and track; its widths are those of a device of the size of Table 1."""

    traction: float  # coefficient over the gear ratio: torque on the axis over the moment M3 [-]
    N: float  # gear ratio [-]
    ring: float  # inverse inertia of ring, axis and flywheel about the axis of the ring [1/(kg m^2)]
    side: float = SIDE  # [Nm]
    creep: float = CREEP  # [rad/s]
    soft: float = SOFT  # [N^2 m^2]
    changing: float = CHANGING  # [Nm]
    change: float = CHANGE  # [1/s]


@inlined
def contact_of(beyond: Any) -> Any:
    """Friction of a plant; None where the contact rolls."""
    if beyond is None:
        return None
    return beyond.contact


@inlined
def axis_rows(contact: Any) -> int:
    """States that the contact adds behind all others."""
    if contact is None:
        return 0
    return 1


@inlined
def axis_speed(contact: Any, rolling: Any, x: Any, at: int) -> Any:
    """Speed theta' of the spin axis: that of `rolling`, or the state at `at`. [rad/s]"""
    if contact is None:
        return rolling
    return x[at]


@inlined
def axis_gear(contact: Any, N: Any) -> Any:
    """How fast the axis turns with the variable that stands for it in the inertia: with the ring, or itself."""
    if contact is None:
        return N
    return 1.0


@inlined
def axis_momentum(contact: Any, rolling: Any, J3: Any, axis: Any) -> Any:
    """Momentum of the spin axis about itself: that of `rolling`, or of its own speed. [Nms]"""
    if contact is None:
        return rolling
    return 2.0 * J3 * axis


@inlined
def on_axis(contact: Any, rolling: Any, coupling: Any, J3: Any, u3: Any, w: Any) -> Any:
    """Generalised force on the ring that takes the axis along, `rolling` (24), or on the axis alone. [Nm]"""
    if contact is None:
        return rolling
    return coupling + 2.0 * J3 * u3 * w


@inlined
def pressing(k: Any, u1: Any, w: Any, W: Any, axis: Any) -> Any:
    """Moment M3 that presses the axis on its track, without the accelerations. [Nm]"""
    return 2.0 * k.K * u1 * w - w * (2.0 * k.J3 * (u1 + axis) + k.J4 * (u1 + W))


@inlined
def rubbing(contact: Any, load: Any, axis: Any, w: Any) -> Any:
    """Torque of the friction on the axis, then on the ring [Nm], and the power that it takes [W].

    `load` is the moment that presses the axis on its track. [Nm]
    """
    if contact is None:
        return -0.0, 0.0, 0.0 * w  # the first as `beyond.NOTHING`
    side = -np.tanh(load / contact.side) * contact.N
    slip = axis - side * w
    torque = -contact.traction * np.sqrt(load * load + contact.soft) * np.tanh(slip / contact.creep)
    return torque, -side * torque, -torque * slip


@inlined
def ring_rate(contact: Any, rate: Any, k: Any, by_friction: Any, u1: Any, u3: Any, W: Any, axis: Any) -> Any:
    """Acceleration psi'' of the ring; `rate` is that of the variable that stands for the axis. [rad/s^2]"""
    if contact is None:
        return rate
    return contact.ring * (by_friction - (k.K * u1 + 2.0 * k.J3 * axis + k.J4 * W) * u3)


@inlined
def put_axis(contact: Any, dx: Any, at: int, rate: Any) -> None:
    """Write the acceleration of the spin axis into its row of `dx`."""
    if contact is not None:
        dx[at] = rate
