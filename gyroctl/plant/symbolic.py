"""The equations as casadi expressions, from the one text."""

from __future__ import annotations

from typing import Any

from gyroctl.plant import equations
from gyroctl.plant.beyond import signal_rows
from gyroctl.plant.equations import RADIATION, Coefficients, powers


def casadi_derivative(k: Coefficients) -> Any:
    """Return ``f(x, u, moments) -> derivative`` as a casadi Function.

    Parameters
    ----------
    k : Coefficients
        Constants of the plant, numbers in the function.

    Returns
    -------
    casadi.Function
        Inputs x (n,), u = (cc, cg) [Nms], moments = (Me1, Me3) [Nm] and what `Plant.near` adds; output derivative (n,).
    """
    import casadi

    # numpy functions of the text then return casadi values; the older behaviour differs by the type of the input
    casadi.GlobalOptions.setNumpyMode(1)
    n = RADIATION + len(k.q1) + len(k.q3)
    x, u, moments = casadi.SX.sym("x", n), casadi.SX.sym("u", 2), casadi.SX.sym("moments", signal_rows(k.beyond))
    dx: list[Any] = [0.0] * (n + powers(k))
    equations.derivative(x, dx, 1, 0, k, u[0], u[1], moments[0], moments[1], k.beyond, moments)
    names = ["x", "u", "moments"], ["derivative"]
    return casadi.Function("gyropto", [x, u, moments], [casadi.vertcat(*dx[:n])], *names)
