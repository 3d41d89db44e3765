"""A step of Runge-Kutta 4 for a pack of runs: the ensemble's, and that of closed loops in lanes.

The arithmetic of a lane is that of `kernel.advance`, to the last bit, for plants without terms beyond the linear model
and controls that are held. What differs is where it stands: the four stages are written out, so that no loop and no
memory stands between them, and in each the accelerations come first. All else that a stage does waits for nothing and
nothing waits for it, but a processor looks no further ahead than some two hundred instructions, half a stage.
"""

from __future__ import annotations

from typing import Any

from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import LEDGER, PSI_RATE, Coefficients, derivative, states_of
from gyroctl.plant.packs import room, settle


@inlined
def move(one: Any, other: Any, count: int) -> None:
    """Copy packs."""
    for i in range(count):
        other[i] = one[i]


@inlined
def slope(x: Any, dx: Any, k: Coefficients, cc: Any, cg: Any, moments: Any, at: int, urgent: Any) -> None:
    """Write the rates of state `x` and its powers into `dx`, with the moments from `at` on.

    `urgent` is working space for the acceleration of the ring, the last that is found: what a text does after this
    one, and what only that needs, stays behind it.
    """
    derivative(x, dx, 1, 0, k, cc, cg, moments[at], moments[at + 1])
    urgent[0] = dx[PSI_RATE]
    settle(urgent)


@inlined
def step(y: Any, k: Coefficients, cc: Any, cg: Any, moments: Any, at: int, h: Any, ledger: Any) -> None:
    """Take a step with all runs of a pack.

    Parameters
    ----------
    y : Packs
        State and ledger, changed in place.
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
    x, first, second, third, fourth, urgent = room(), room(), room(), room(), room(), room()
    slope(y, first, k, cc, cg, moments, at, urgent)
    for i in range(states):
        x[i] = y[i] + half * first[i]
    slope(x, second, k, cc, cg, moments, at + 2, urgent)
    for i in range(states):
        x[i] = y[i] + half * second[i]
    slope(x, third, k, cc, cg, moments, at + 2, urgent)
    for i in range(states):
        x[i] = y[i] + h * third[i]
    slope(x, fourth, k, cc, cg, moments, at + 4, urgent)
    for i in range(states):
        y[i] = y[i] + sixth * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
    for i in range(begin, end):
        y[i] = y[i] + sixth * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
