"""casadi's functions as machine code: the same numbers, called as functions and by address."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from gyroctl.controllers.nmpc import casadi_to_numba as translation
from gyroctl.controllers.nmpc.by_address import function_at


@njit
def call(function, a, b, first, second):
    function(a, b, first, second)


of_four = function_at(4)


@njit
def call_by_address(address, a, b, first, second):
    of_four(address)(a, b, first, second)


def test_translated_function_is_casadis():
    import casadi

    x, y = casadi.SX.sym("x", 3), casadi.SX.sym("y", 2)
    value = casadi.vertcat(
        casadi.sin(x[0]) / (1 + y[0] ** 2),
        casadi.fmax(x[1], y[1]) - casadi.if_else(x[2] > 0, x[2] * y[0], -3.0),
        casadi.sqrt(casadi.fabs(x[2])) + casadi.exp(-x[1]) * casadi.cos(y[1]) + 2 * x[0] ** 3,
        (y[1] - x[0] * x[1]) * (x[2] * y[0] - x[1]),  # products that are taken into a difference, on either side
    )
    compiled = translation.compiled("sample", [x, y], [value, casadi.jacobian(value, x)])
    reference = casadi.Function("f", [x, y], [value, casadi.densify(casadi.jacobian(value, x))])
    rng = np.random.default_rng(0)
    for sample in range(50):
        a, b = rng.standard_normal(3), rng.standard_normal(2)
        first, second = np.zeros(4), np.zeros(12)
        if sample % 2:
            call_by_address(compiled.address, a, b, first, second)
        else:
            call(compiled, a, b, first, second)  # compiled; called directly it would run as Python
        expected = reference(a, b)
        np.testing.assert_allclose(first, np.asarray(expected[0]).ravel(), rtol=1e-14, atol=1e-14)
        np.testing.assert_allclose(second, np.asarray(expected[1]).ravel("F"), rtol=1e-14, atol=1e-14)


def test_unknown_operation_is_refused():
    import casadi

    x = casadi.SX.sym("x", 1)
    with pytest.raises(NotImplementedError, match="OPERATIONS"):
        translation.source("sample", [x], [casadi.atan2(x, 2.0)])
