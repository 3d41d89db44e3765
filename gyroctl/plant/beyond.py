"""What acts beyond the linear model: named choices of the plant, each a term that is compiled away where it is off.

The text is smooth, so that it serves NumPy, complex numbers, casadi symbols and the kernels alike: sqrt(x^2 + eps^2)
stands for |x| and tanh for a limit. What the waves bring along for it, beside the two moments at rest, are further
rows of signals. Their order at an instant, each row `L` runs wide:

    Me1, Me3; u, w with drag; F1, F3 with a reduced wetted surface, each as a polynomial in sin phi1 where the position
    moves; the moments about the present position with a moving one; R1, R3, held from outside, with a wetted surface.

The moments over positions are known at even nodes across the reach of the lever. A realisation carries all of them;
the equations see a cubic about a place next to the float, from the eight nodes around it, see `kernel.near`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant.compiled import inlined
from gyroctl.plant.friction import SOFT, axis_gear, pressing, rubbing
from gyroctl.plant.reduced import places, reduced_moments, undisturbed
from gyroctl.plant.trigonometry import sine

BEYOND = ("second_order", "drag", "bearing", "windage", "rolling_resistance", "contact")
"""Powers of the energy ledger that these terms add behind the others, in this order. [W]"""

HALF = 10
"""Nodes of the position on either side of rest; their spacing is a tenth of the reach, 0.105 m."""

NODES = 2 * HALF + 1
NEAR = 8
"""Nodes next to the float through which its moments are interpolated: error 4e-4 of their deviation in a sea of
gamma 1 and 3.6 rad/s, less in any narrower or longer one."""

ORDER = 4
"""Coefficients of the moments about a place: as many as the order of the integrator."""

PLACES = 4
"""Such places per spacing of the nodes; the float is within 13 mm of one when a step begins."""

SLOW = 1.0
"""Speed about which bearing, windage and rolling resistance change their sign. [rad/s]"""

STILL = 1e-6
"""Square of the velocity about which drag changes its sign. [m^2/s^2]"""


class Position(NamedTuple):
    """Moments at the float's own position."""

    scale: float = float(HALF)  # reach over the spacing of the nodes


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
def undisturbed_rows(reduced: Any) -> int:
    """Rows of the linear Froude-Krylov moments."""
    if reduced is None:
        return 0
    return 2 * places(reduced.moving)


@inlined
def base_rows(beyond: Any) -> int:
    """Signals of an instant that are taken from the realisation one by one."""
    if beyond is None:
        return 2
    return 2 + pair(beyond.drag) + undisturbed_rows(beyond.reduced)


@inlined
def node_rows(beyond: Any) -> int:
    """Signals of an instant that a realisation holds over the positions."""
    if beyond is None:
        return 0
    return NODES * pair(beyond.position)


@inlined
def near_rows(position: Any) -> int:
    """Rows of the polynomials about a place next to the float: two of them, and the place."""
    if position is None:
        return 0
    return 2 * ORDER + 1


@inlined
def signal_rows(beyond: Any) -> int:
    """Signals of an instant as the equations see them."""
    if beyond is None:
        return 2
    return base_rows(beyond) + near_rows(beyond.position) + pair(beyond.surface)


@inlined
def signal_room(beyond: Any, L: int) -> int:
    """Numbers for the signals at the three instants of a step of L runs, and for what is worked out on the way."""
    if beyond is None:
        return 6 * L
    return 3 * signal_rows(beyond) * L + pair(beyond.position) // 2 * signal_rest(L)


@inlined
def signal_rest(L: int) -> int:
    """Numbers behind the signals: cubics of four samples, and where and when they hold, see `kernel.near`."""
    return (8 * ORDER + 2) * L


@inlined
def ledger_rows(beyond: Any) -> int:
    """Powers that these terms add to the ledger."""
    if beyond is None:
        return 0
    return len(BEYOND)


# --- terms -------------------------------------------------------------------------------------------------------


@inlined
def displaced(position: Any, phi1: Any, me1: Any, me3: Any, signals: Any, at: int, L: int, l: int, row: int) -> Any:
    """What the moments at the float's position have more than those at rest. [Nm]

    The position is l sin phi1 along x3; it is counted in spacings of the nodes.
    """
    if position is None:
        return 0.0, 0.0
    t = position.scale * sine(phi1) - signals[at + (row + 2 * ORDER) * L + l]
    one = cubic(signals, at + row * L + l, L, t)
    three = cubic(signals, at + (row + ORDER) * L + l, L, t)
    return one - me1, three - me3


@inlined
def cubic(c: Any, at: int, L: int, t: Any) -> Any:
    """Value of a cubic of four coefficients, L entries apart; in halves, which a processor works out side by side."""
    return (c[at] + t * c[at + L]) + t * t * (c[at + 2 * L] + t * c[at + 3 * L])


@inlined
def dragged(drag: Any, v1: Any, v3: Any, signals: Any, at: int, L: int, l: int) -> Any:
    """Moments of the drag on phi1 and phi3. [Nm]"""
    if drag is None:
        return 0.0, 0.0
    r1 = drag.reach * v1 - signals[at + 2 * L + l]
    r3 = drag.reach * v3 - signals[at + 3 * L + l]
    speed = np.sqrt(r1 * r1 + r3 * r3 + drag.still)
    return -drag.factor1 * speed * r1, -drag.factor3 * speed * r3


@inlined
def held_moments(surface: Any, signals: Any, at: int, L: int, l: int, row: int) -> Any:
    """Moments that are held from outside. [Nm]"""
    if surface is None:
        return 0.0, 0.0
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
    return cap.torque * np.tanh(torque / cap.torque)


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
        return 0.0, 0.0, 0.0
    bearing = losses.bearing * np.tanh(W / losses.slow)
    windage = losses.windage * W * np.sqrt(W * W + losses.slow * losses.slow)
    resistance = losses.rolling * np.sqrt(load * load + losses.soft) * np.tanh(rolling / losses.slow)
    return bearing, windage, resistance


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
    bearing, windage, resistance = lost(beyond.losses, W, axis, load)
    more1, more3 = at_position[0] + wetted[0], at_position[1] + wetted[1]
    drag1, drag3 = by_drag
    forces = more1 + drag1, more3 + drag3, friction - axis_gear(beyond.contact, k.N) * resistance, -bearing - windage
    work = more1 * v1 + more3 * v3, -drag1 * v1 - drag3 * v3
    powers = (work[0], work[1], bearing * W, windage * W, resistance * axis, rubbed)
    return forces, powers, on_ring


@inlined
def of_waves(
    beyond: Any, phi1: Any, phi3: Any, v1: Any, v3: Any, me1: Any, me3: Any, signals: Any, at: int, L: int, l: int
) -> Any:
    """Moments of position, drag and wetted surface, a pair each. [Nm]"""
    if signals is None:
        return (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)
    row = base_rows(beyond)
    position = displaced(beyond.position, phi1, me1, me3, signals, at, L, l, row)
    drag = dragged(beyond.drag, v1, v3, signals, at, L, l)
    polynomials = immersed(beyond.reduced, phi1, phi3, signals, at, L, l, 2 + pair(beyond.drag))
    held = held_moments(beyond.surface, signals, at, L, l, row + near_rows(beyond.position))
    return position, drag, (polynomials[0] + held[0], polynomials[1] + held[1])


@inlined
def immersed(reduced: Any, phi1: Any, phi3: Any, signals: Any, at: int, L: int, l: int, row: int) -> Any:
    """Moments that the reduced wetted surface adds. [Nm]"""
    if reduced is None:
        return 0.0, 0.0
    f1, f3 = undisturbed(reduced, phi1, signals, at, L, l, row)
    return reduced_moments(reduced, phi3, f1, f3)


def _weights() -> NDArray[np.float64]:
    """Weights (places, NEAR, ORDER) of the nodes in value and derivatives/n! at all places along eight nodes."""
    at = np.arange((NEAR - 1) * PLACES + 1) / PLACES
    table = np.zeros((at.size, NEAR, ORDER))
    for j in range(NEAR):
        others = [i for i in range(NEAR) if i != j]
        basis = np.polynomial.Polynomial.fromroots(others) / np.prod([j - i for i in others])
        for n in range(ORDER):
            table[:, j, n] = (basis.deriv(n) if n else basis)(at) / math.factorial(n)
    return table


WEIGHTS = _weights()
"""See `_weights`."""
