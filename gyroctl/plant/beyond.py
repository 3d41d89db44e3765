"""What acts beyond the linear model: named choices of the plant, each a term that is compiled away where it is off.

The text is smooth, so that it serves NumPy, complex numbers, casadi symbols and the kernels alike: sqrt(x^2 + eps^2)
stands for |x| and tanh for a limit. What the waves bring along for it, beside the two moments at rest, are further
rows of signals. Their order at an instant, each row `L` runs wide:

    Me1, Me3; u, w with drag; F1, F3 with a reduced wetted surface; where the position moves cubics of Me1 and Me3, and
    of F1 and F3 in the place of these two, in phi1 about a place next to the float, and that place; R1, R3, held from
    outside, with a wetted surface.

A realisation carries Me1 and Me3 at even nodes across the reach of the lever, and F1 and F3 as polynomials in sin phi1;
the equations see the cubics, see `gyroctl.plant.near`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gyroctl.plant.compiled import inlined
from gyroctl.plant.friction import SOFT, axis_gear, pressing, rubbing
from gyroctl.plant.hyperbolic import tanh
from gyroctl.plant.reduced import POWERS, reduced_moments

BEYOND = ("second_order", "drag", "bearing", "windage", "rolling_resistance", "contact")
"""Powers of the energy ledger that these terms add behind the others, in this order. [W]"""

HALF = 10
"""Nodes of the position on either side of rest; their spacing is a tenth of the reach, 0.105 m."""

NODES = 2 * HALF + 1
ORDER = 4
"""Coefficients of a moment about a place: as many as the order of the integrator."""

SLOW = 1.0
"""Speed about which bearing, windage and rolling resistance change their sign. [rad/s]"""

STILL = 1e-6
"""Square of the velocity about which drag changes its sign. [m^2/s^2]"""

NOTHING = -0.0
"""What a term adds that is off: x + -0.0 is x whatever x is, so that nothing of it is left when compiled."""


class Position(NamedTuple):
    """Moments at the float's own position."""


class Drag(NamedTuple):
    """Morison drag of the float in the relative velocity."""

    factor1: float  # rho Cd A1 l / 2 [kg]
    factor3: float  # rho Cd A3 l / 2 [kg]
    reach: float  # l [m]
    still: float = STILL  # [m^2/s^2]


class Curve(NamedTuple):
    """Torque of a coupling that falls beyond a slip."""

    slip: float  # slip of the greatest torque [rad/s]


class Cap(NamedTuple):
    """Greatest torque of the coupling."""

    torque: float  # [Nm]


class Losses(NamedTuple):
    """Friction of the bearing, windage of the flywheel, resistance of the rolling contact."""

    bearing: float  # [Nm]
    windage: float  # [Nms^2]
    rolling: float  # lever arm over the ring's radius [-]
    slow: float = SLOW  # [rad/s]
    soft: float = SOFT  # of the load [N^2 m^2]


class Beyond(NamedTuple):
    """The terms of a plant; None for what is off."""

    position: Any = None  # Position
    drag: Any = None  # Drag
    curve: Any = None  # Curve
    cap: Any = None  # Cap
    losses: Any = None  # Losses
    reduced: Any = None  # polynomials of the wetted surface
    surface: Any = None  # True where moments are held from outside, see `held`
    contact: Any = None  # friction of the rolling contact


# --- rows of signals and of the ledger, known when compiled ------------------------------------------------------


@inlined
def pair(term: Any) -> int:
    """Rows of a term that has two signals of its own."""
    if term is None:
        return 0
    return 2


@inlined
def moved(position: Any, reduced: Any) -> Any:
    """Polynomials of the wetted surface where the position moves, else None."""
    if position is None:
        return None
    return reduced


@inlined
def base_rows(beyond: Any) -> int:
    """Signals of an instant that are taken from the realisation one by one."""
    if beyond is None:
        return 2
    return 2 + pair(beyond.drag) + pair(beyond.reduced) - pair(moved(beyond.position, beyond.reduced))


@inlined
def node_rows(beyond: Any) -> int:
    """Signals of an instant that a realisation holds over the positions."""
    if beyond is None:
        return 0
    return POWERS * pair(moved(beyond.position, beyond.reduced)) + NODES * pair(beyond.position)


@inlined
def cubic_rows(beyond: Any) -> int:
    """Rows of the cubics about a place next to the float."""
    return ORDER * (pair(beyond.position) + pair(moved(beyond.position, beyond.reduced)))


@inlined
def near_rows(beyond: Any) -> int:
    """Rows of the cubics, and of their place."""
    return cubic_rows(beyond) + pair(beyond.position) // 2


@inlined
def signal_rows(beyond: Any) -> int:
    """Signals of an instant as the equations see them."""
    if beyond is None:
        return 2
    return base_rows(beyond) + near_rows(beyond) + pair(beyond.surface)


@inlined
def signal_room(beyond: Any, L: int) -> int:
    """Numbers for the signals at the three instants of a step of L runs, and for what is worked out on the way."""
    if beyond is None:
        return 6 * L
    return 3 * signal_rows(beyond) * L + signal_rest(beyond, L)


@inlined
def signal_rest(beyond: Any, L: int) -> int:
    """Numbers behind the signals: cubics of four samples, and where and when they hold, see `near.near`."""
    return (4 * cubic_rows(beyond) + 3 * pair(beyond.position)) * L


@inlined
def ledger_rows(beyond: Any) -> int:
    """Powers that these terms add to the ledger."""
    if beyond is None:
        return 0
    return len(BEYOND)


# --- terms -------------------------------------------------------------------------------------------------------


@inlined
def displaced(position: Any, from_place: Any, me1: Any, me3: Any, signals: Any, at: int, L: int, l: int) -> Any:
    """What the moments at the float's position have more than those at rest; `from_place` [rad]. [Nm]"""
    if position is None:
        return NOTHING, NOTHING
    one, three = cubic(signals, at + l, L, from_place), cubic(signals, at + ORDER * L + l, L, from_place)
    return one - me1, three - me3


@inlined
def away(position: Any, phi1: Any, place: Any) -> Any:
    """Angle between the float and the place about which its moments are known. [rad]"""
    if position is None:
        return 0.0
    return phi1 - place


@inlined
def cubic(c: Any, at: int, L: int, t: Any) -> Any:
    """Value of a cubic of four coefficients, L entries apart; in halves, which a processor works out side by side."""
    return (c[at] + t * c[at + L]) + t * t * (c[at + 2 * L] + t * c[at + 3 * L])


@inlined
def dragged(drag: Any, v1: Any, v3: Any, signals: Any, at: int, L: int, l: int) -> Any:
    """Moments of the drag on phi1 and phi3. [Nm]"""
    if drag is None:
        return NOTHING, NOTHING
    r1 = drag.reach * v1 - signals[at + 2 * L + l]
    r3 = drag.reach * v3 - signals[at + 3 * L + l]
    speed = np.sqrt(r1 * r1 + r3 * r3 + drag.still)
    return -drag.factor1 * speed * r1, -drag.factor3 * speed * r3


@inlined
def held_moments(surface: Any, signals: Any, at: int, L: int, l: int, row: int) -> Any:
    """Moments that are held from outside. [Nm]"""
    if surface is None:
        return NOTHING, NOTHING
    return signals[at + row * L + l], signals[at + (row + 1) * L + l]


@inlined
def falling(curve: Any, cc: Any, slip: Any) -> Any:
    """Torque of the coupling, of an eddy current: greatest at the slip of the curve. [Nm]"""
    if curve is None:
        return cc * slip
    part = slip / curve.slip
    return cc * slip / (1.0 + part * part)


@inlined
def capped(cap: Any, torque: Any) -> Any:
    """Torque of the coupling within its greatest one. [Nm]"""
    if cap is None:
        return torque
    return cap.torque * tanh(torque / cap.torque)


@inlined
def coupling_torque(beyond: Any, cc: Any, slip: Any) -> Any:
    """Torque of the magnetic coupling at a slip [rad/s]; without `beyond` its straight line. [Nm]"""
    if beyond is None:
        return cc * slip
    return capped(beyond.cap, falling(beyond.curve, cc, slip))


@inlined
def lost(losses: Any, W: Any, rolling: Any, load: Any) -> Any:
    """Torques of bearing and windage on omega, and of the rolling resistance on the spin axis. [Nm]

    `rolling` is the speed theta' of the spin axis [rad/s], `load` the moment M3 that presses it on the track [Nm].
    """
    if losses is None:
        return NOTHING, NOTHING, NOTHING
    bearing = losses.bearing * tanh(W / losses.slow)
    windage = losses.windage * W * np.sqrt(W * W + losses.slow * losses.slow)
    resistance = losses.rolling * np.sqrt(load * load + losses.soft) * tanh(rolling / losses.slow)
    return bearing, windage, resistance


@inlined
def slowing(losses: Any, gear: Any, W: Any, rolling: Any, load: Any) -> Any:
    """Generalised forces of the losses on psi and omega [Nm], and their powers [W]; `gear` is theta' over psi'."""
    if losses is None:
        return NOTHING, NOTHING, (0.0 * W, 0.0 * W, 0.0 * W)
    bearing, windage, resistance = lost(losses, W, rolling, load)
    return -gear * resistance, -bearing - windage, (bearing * W, windage * W, resistance * rolling)


@inlined
def further(
    beyond: Any, k: Any, motion: Any, u1: Any, me1: Any, me3: Any, signals: Any, at: int, L: int, l: int
) -> Any:
    """Generalised forces on phi1, phi3, psi, omega beyond the linear model [Nm], and their powers `BEYOND` [W].

    Parameters
    ----------
    beyond : Beyond
        The terms.
    k : Coefficients
        Constants of the device.
    motion : tuple
        phi1, phi3, psi and the rates of phi1, phi3, psi, omega, theta.
    u1 : scalar
        Rate of the lever about the spin axis. [rad/s]
    me1, me3 : scalar
        Moments at rest. [Nm]
    signals : (signal_rows * L,) buffer or None
        Signals of the instant from `at` on; None for still water at rest.
    """
    phi1, phi3, _, v1, v3, w, W, axis = motion
    at_position, by_drag, wetted = of_waves(beyond, phi1, phi3, v1, v3, me1, me3, signals, at, L, l)
    load = pressing(k, u1, w, W, axis)
    friction, on_ring, rubbed = rubbing(beyond.contact, load, axis, w)
    on_psi, on_omega, losses = slowing(beyond.losses, axis_gear(beyond.contact, k.N), W, axis, load)
    more1, more3 = at_position[0] + wetted[0], at_position[1] + wetted[1]
    drag1, drag3 = by_drag
    forces = more1 + drag1, more3 + drag3, friction + on_psi, on_omega
    work = more1 * v1 + more3 * v3, -drag1 * v1 - drag3 * v3
    return forces, (*work, *losses, rubbed), on_ring


@inlined
def of_waves(
    beyond: Any, phi1: Any, phi3: Any, v1: Any, v3: Any, me1: Any, me3: Any, signals: Any, at: int, L: int, l: int
) -> Any:
    """Moments of position, drag and wetted surface, a pair each. [Nm]"""
    if signals is None:
        return (NOTHING, NOTHING), (NOTHING, NOTHING), (NOTHING, NOTHING)
    row, size = base_rows(beyond), near_rows(beyond)
    from_place = away(beyond.position, phi1, signals[at + (row + size - 1) * L + l])
    position = displaced(beyond.position, from_place, me1, me3, signals, at + row * L, L, l)
    drag = dragged(beyond.drag, v1, v3, signals, at, L, l)
    f1, f3 = undisturbed(beyond.position, beyond.reduced, from_place, signals, at, L, l, row)
    polynomials = immersed(beyond.reduced, phi3, f1, f3)
    held = held_moments(beyond.surface, signals, at, L, l, row + size)
    return position, drag, (polynomials[0] + held[0], polynomials[1] + held[1])


@inlined
def immersed(reduced: Any, phi3: Any, f1: Any, f3: Any) -> Any:
    """Moments that the reduced wetted surface adds. [Nm]"""
    if reduced is None:
        return NOTHING, NOTHING
    return reduced_moments(reduced, phi3, f1, f3)


@inlined
def undisturbed(position: Any, reduced: Any, from_place: Any, signals: Any, at: int, L: int, l: int, row: int) -> Any:
    """Linear Froude-Krylov moments F1, F3 at the float's position; `row` is the first of the cubics. [Nm]"""
    if reduced is None:
        return NOTHING, NOTHING
    if position is None:
        return signals[at + (row - 2) * L + l], signals[at + (row - 1) * L + l]
    first, second = at + (row + 2 * ORDER) * L + l, at + (row + 3 * ORDER) * L + l
    return cubic(signals, first, L, from_place), cubic(signals, second, L, from_place)
