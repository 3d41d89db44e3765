"""The equations as casadi expressions, from the one text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gyroctl.plant import equations
from gyroctl.plant.equations import LEDGER

if TYPE_CHECKING:
    from gyroctl.plant.plant import Plant


def casadi_derivative(plant: Plant) -> Any:
    """Return ``f(x, u, moments) -> derivative`` as a casadi Function.

    Parameters
    ----------
    plant : Plant
        Its constants are numbers in the function.

    Returns
    -------
    casadi.Function
        Inputs x (n,), u = (cc, cg) [Nms], moments = (Me1, Me3) [Nm]; output derivative (n,).
    """
    inputs, dx = _expressions(plant)
    return _function("gyropto", inputs, dx[: len(plant.labels)], "derivative")


def casadi_powers(plant: Plant) -> Any:
    """Return ``f(x, u, moments) -> powers`` (5,) [W] as a casadi Function, in the order of `LEDGER`."""
    inputs, dx = _expressions(plant)
    return _function("gyropto_powers", inputs, dx[len(plant.labels) :], "powers")


def _expressions(plant: Plant) -> tuple[list[Any], list[Any]]:
    import casadi

    # numpy functions of the text then return casadi values; the older behaviour differs by the type of the input
    casadi.GlobalOptions.setNumpyMode(1)
    n = len(plant.labels)
    x, u, m = casadi.SX.sym("x", n), casadi.SX.sym("u", 2), casadi.SX.sym("moments", 2)
    dx: list[Any] = [0.0] * (n + len(LEDGER))
    equations.derivative(x, dx, 1, 0, plant.coefficients, u[0], u[1], m[0], m[1])
    return [x, u, m], dx


def _function(name: str, inputs: list[Any], outputs: list[Any], label: str) -> Any:
    import casadi

    return casadi.Function(name, inputs, [casadi.vertcat(*outputs)], ["x", "u", "moments"], [label])
