"""The equations as casadi expressions, from the one text."""

from __future__ import annotations

from typing import Any

from gyroctl.plant import equations
from gyroctl.plant.equations import LEDGER, RADIATION, Coefficients


def casadi_derivative(k: Coefficients) -> Any:
    """Return ``f(x, u, moments) -> derivative`` as a casadi Function.

    Parameters
    ----------
    k : Coefficients
        Constants of the plant, numbers in the function.

    Returns
    -------
    casadi.Function
        Inputs x (n,), u = (cc, cg) [Nms], moments = (Me1, Me3) [Nm]; output derivative (n,).
    """
    inputs, dx = _expressions(k)
    return _function("gyropto", inputs, dx[: states(k)], "derivative")


def casadi_powers(k: Coefficients) -> Any:
    """Return ``f(x, u, moments) -> powers`` (5,) [W] as a casadi Function, in the order of `LEDGER`."""
    inputs, dx = _expressions(k)
    return _function("gyropto_powers", inputs, dx[states(k) :], "powers")


def states(k: Coefficients) -> int:
    """Number of states."""
    return RADIATION + len(k.q1) + len(k.q3)


def _expressions(k: Coefficients) -> tuple[list[Any], list[Any]]:
    import casadi

    # numpy functions of the text then return casadi values; the older behaviour differs by the type of the input
    casadi.GlobalOptions.setNumpyMode(1)
    n = states(k)
    x, u, m = casadi.SX.sym("x", n), casadi.SX.sym("u", 2), casadi.SX.sym("moments", 2)
    dx: list[Any] = [0.0] * (n + len(LEDGER))
    equations.derivative(x, dx, 1, 0, k, u[0], u[1], m[0], m[1])
    return [x, u, m], dx


def _function(name: str, inputs: list[Any], outputs: list[Any], label: str) -> Any:
    import casadi

    return casadi.Function(name, inputs, [casadi.vertcat(*outputs)], ["x", "u", "moments"], [label])
