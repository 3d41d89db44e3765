"""A step of Runge-Kutta 4 for a pack of runs: the ensemble's, and that of closed loops in lanes.

The arithmetic of a lane is that of `kernel.advance`, to the last bit, for plants without terms beyond the linear model
and controls that are held. What differs is where it stands. The four stages are written out, so that their slopes need
no memory. And since psi' is part of the state, the angle of the next stage is known before the slope of this one:
cosine and sine of it are worked out ahead, beside the forces, where a processor would else wait for the one and then
for the other.
"""

from __future__ import annotations

from typing import Any

from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import LEDGER, PSI, PSI_RATE, Coefficients, derivative, states_of
from gyroctl.plant.packs import room, settle
from gyroctl.plant.trigonometry import cos_sin

TURNED = 4
"""Packs of `turned`: cosine and sine of psi at the beginning of the step, room for those of the next stage."""


@inlined
def turn(psi: Any, turned: Any, at: int) -> None:
    """Write cosine and sine of `psi` [rad] into `turned` from `at` on, ahead of all that follows."""
    turned[at], turned[at + 1] = cos_sin(psi)
    settle(turned)


@inlined
def move(one: Any, other: Any, count: int) -> None:
    """Copy packs."""
    for i in range(count):
        other[i] = one[i]


@inlined
def slope(x: Any, dx: Any, k: Coefficients, cc: Any, cg: Any, moments: Any, at: int, turned: Any, first: int) -> None:
    """Write the rates of state `x` and its powers into `dx`, with the moments at `at` and the turn at `first`."""
    known = turned[first], turned[first + 1]
    derivative(x, dx, 1, 0, k, cc, cg, moments[at], moments[at + 1], None, None, 0, known)


@inlined
def step(y: Any, turned: Any, k: Coefficients, cc: Any, cg: Any, moments: Any, at: int, h: Any, ledger: Any) -> None:
    """Take a step with all runs of a pack.

    Parameters
    ----------
    y : Packs
        State and ledger, changed in place.
    turned : Packs
        Cosine and sine of psi, see `TURNED`: of `y` before and afterwards.
    k : Coefficients
        The device, without terms beyond the linear model.
    cc, cg : pack
        Controls. [Nms]
    moments : Packs
        Me1 and Me3 at the start, the middle and the end of the step, from `at` on. [Nm]
    h : float or pack
        Length of the step. [s]
    ledger : anything or None
        None for the generator's row alone: the others are left as they are, and their powers never worked out.
    """
    states = states_of(k)
    begin, end = states, states + len(LEDGER)
    if ledger is None:
        begin = end - 1
    half, sixth = 0.5 * h, h / 6.0
    x, total, second, other = room(), room(), room(), room()

    turn(y[PSI] + half * y[PSI_RATE], turned, 2)
    slope(y, total, k, cc, cg, moments, at, turned, 0)
    for i in range(states):
        x[i] = y[i] + half * total[i]

    turn(y[PSI] + half * x[PSI_RATE], turned, 0)
    slope(x, second, k, cc, cg, moments, at + 2, turned, 2)
    for i in range(states):
        x[i] = y[i] + half * second[i]

    turn(y[PSI] + h * x[PSI_RATE], turned, 2)
    slope(x, other, k, cc, cg, moments, at + 2, turned, 0)
    for i in range(states):
        x[i] = y[i] + h * other[i]
        total[i] = total[i] + 2.0 * (second[i] + other[i])
    for i in range(begin, end):
        total[i] = total[i] + 2.0 * (second[i] + other[i])

    turn(y[PSI] + sixth * (total[PSI] + x[PSI_RATE]), turned, 0)
    slope(x, other, k, cc, cg, moments, at + 4, turned, 2)
    for i in range(states):
        y[i] = y[i] + sixth * (total[i] + other[i])
    for i in range(begin, end):
        y[i] = y[i] + sixth * (total[i] + other[i])
