"""The equations as casadi expressions, from the one text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gyroctl.plant import equations
from gyroctl.plant.equations import LEDGER

if TYPE_CHECKING:
    from gyroctl.plant.plant import Plant


def casadi_function(plant: Plant) -> Any:
    """Return ``f(x, u, moments) -> (derivative, powers)`` as a casadi Function.

    Parameters
    ----------
    plant : Plant
        Its constants are numbers in the function.

    Returns
    -------
    casadi.Function
        Inputs x (n,), u = (cc, cg), moments = (Me1, Me3); outputs derivative (n,), powers (5,), see `LEDGER`.
    """
    import casadi

    # numpy functions of the text then return casadi values; the older behaviour differs by the type of the input
    casadi.GlobalOptions.setNumpyMode(1)
    n = len(plant.labels)
    x, u, m = casadi.SX.sym("x", n), casadi.SX.sym("u", 2), casadi.SX.sym("moments", 2)
    dx: list[Any] = [0.0] * (n + len(LEDGER))
    equations.derivative(x, dx, 1, 0, plant.coefficients, u[0], u[1], m[0], m[1])
    return casadi.Function(
        "gyropto",
        [x, u, m],
        [casadi.vertcat(*dx[:n]), casadi.vertcat(*dx[n:])],
        ["x", "u", "moments"],
        ["derivative", "powers"],
    )
