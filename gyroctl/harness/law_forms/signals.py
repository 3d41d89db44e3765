"""What such a law may read: the channels of the measurement, and quantities made of one sample of them."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.plant.compiled import inlined
from gyroctl.plant.measurement import CHANNELS

DERIVED = ("u1", "u3", "slip", "float_rate")
"""u1, u3: rate of the float in the frame of the ring, (22)-(23); slip: omega' - N psi'; float_rate: its modulus.

All in rad/s. The names u1, u3 and slip are those of the outputs of the linear models."""

SIGNALS = (*CHANNELS, *DERIVED)
"""Names of what may be read, in the order of their numbers."""

UNITS = {name: "rad" if name in ("psi", "phi1", "phi3") else "rad/s" for name in SIGNALS}

NEEDS = {
    "u1": ("psi", "phi1_rate", "phi3_rate"),
    "u3": ("psi", "phi1_rate", "phi3_rate"),
    "slip": ("psi_rate", "omega_rate"),
    "float_rate": ("phi1_rate", "phi3_rate"),
}
"""Channels that a derived signal is made of."""

TURN = 2.0 * math.pi


@inlined
def signal(which: Any, y: Any, N: float) -> Any:
    """Value of a signal by its number in `SIGNALS`.

    Parameters
    ----------
    which : float
        Its number.
    y : Measurement
        One sample.
    N : float
        Gear ratio. [-]
    """
    if which == 0.0:
        return y.psi
    if which == 1.0:
        return y.psi_rate
    if which == 2.0:
        return y.omega_rate
    if which == 3.0:
        return y.phi1
    if which == 4.0:
        return y.phi3
    if which == 5.0:
        return y.phi1_rate
    if which == 6.0:
        return y.phi3_rate
    if which == 9.0:
        return y.omega_rate - N * y.psi_rate
    if which == 10.0:
        return math.sqrt(y.phi1_rate * y.phi1_rate + y.phi3_rate * y.phi3_rate)
    c, s = math.cos(y.psi), math.sin(y.psi)
    if which == 7.0:
        return c * y.phi1_rate - s * y.phi3_rate
    return s * y.phi1_rate + c * y.phi3_rate


@inlined
def heard(which: Any, y: Any, N: float, last: Any) -> Any:
    """Value of a signal, the last one where a sensor that it needs tells nothing."""
    value = signal(which, y, N)
    return value if value - value == 0.0 else last


@inlined
def kept(which: Any, value: Any) -> Any:
    """Keep of a signal, for when its sensor is lost: a ring angle within a turn, or the state would never come back."""
    return value % TURN if which == 0.0 else value


def channels_of(names: tuple[str, ...]) -> tuple[str, ...]:
    """Channels that signals are made of, in the order of the measurement."""
    needed = {channel for name in names for channel in NEEDS.get(name, (name,))}
    return tuple(channel for channel in CHANNELS if channel in needed)
