"""What makes no law is refused, by the field that is wrong and with the mend."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import casadi as ca
import control
import numpy as np
import pytest
from test_law_from import casadi_filter, governor

import gyroctl as gy


def untrue(y: Any, calls: list[int] = []) -> tuple[float, float]:  # noqa: B006 - the fault that is to be found
    """Answer differently each time."""
    calls.append(1)
    return 0.05, 1e-5 * len(calls)


STATIC = control.ss([], [], [], [[1e-4]])
FORGETFUL = ca.Function("f", [ca.SX.sym("y", 7), ca.SX.sym("x")], [ca.SX([0.05, 1e-4])], ["y", "state"], ["u"])
"""It takes a state and gives none."""

REFUSED: list[tuple[str, Callable[[], Any]]] = [
    ("law_from.source", lambda: gy.law_from(3.0)),  # type: ignore[arg-type]
    ("law_from.source", lambda: gy.law_from(control.tf([1, 0, 0], [1, 1]), reads="psi_rate", sets="cg")),
    ("law_from.source", lambda: gy.law_from(control.ss([], [], [], [[1e-4]], True), reads="psi_rate", sets="cg")),
    ("law_from.source", lambda: gy.law_from(control.ss([], [], [], [[np.nan]]), reads="psi_rate", sets="cg")),
    ("law_from.source", lambda: gy.law_from(lambda speed, rate: (0.0, 0.0))),
    ("law_from.source", lambda: gy.law_from(lambda y: (math.nan, 0.0))),
    ("law_from.source", lambda: gy.law_from(lambda y: 0.05)),
    ("law_from.source", lambda: gy.law_from(lambda y: (0.05, y.speed))),
    ("law_from.source", lambda: gy.law_from(untrue)),
    ("law_from.source", lambda: gy.law_from([[1e-4], [2e-4]], over={"psi_rate": [3.0, 4.0]}, cc=0.05)),
    ("law_from.source", lambda: gy.law_from([1e-4, -2e-4], over={"psi_rate": [3.0, 4.0]}, cc=0.05)),
    ("law_from.source", lambda: gy.law_from(ca.Function("f", [ca.SX.sym("a")], [0.05]))),
    ("law_from.reads", lambda: gy.law_from(STATIC, reads="speed", sets="cg")),
    ("law_from.reads", lambda: gy.law_from(STATIC, reads="psi", sets="cg")),
    ("law_from.reads", lambda: gy.law_from(STATIC, reads=["psi_rate", "u1"], sets="cg")),
    ("law_from.reads", lambda: gy.law_from(STATIC, sets="cg")),
    ("law_from.sets", lambda: gy.law_from(STATIC, reads="psi_rate", sets="power")),
    ("law_from.method", lambda: gy.law_from(STATIC, reads="psi_rate", sets="cg", method="guess")),
    ("law_from.period", lambda: gy.law_from(control.tf([1e-4], [1.0, 0.5], 0.2), reads="u1", sets="cg", period=0.1)),
    ("law_from.period", lambda: gy.law_from(lambda y: (0.0, 0.0), period=-1.0)),
    ("law_from.at.psi_rate", lambda: gy.law_from(STATIC, reads="psi_rate", sets="cg", at={"psi_rate": math.nan})),
    ("law_from.at", lambda: gy.law_from(STATIC, reads="psi_rate", sets="cg", at={"speed": 1.0})),
    ("law_from.over", lambda: gy.law_from([1e-4, 2e-4], cc=0.05)),
    ("law_from.over", lambda: gy.law_from([1e-4, 2e-4], over={"psi": [0.0, 1.0]}, cc=0.05)),
    ("law_from.over.psi_rate", lambda: gy.law_from([1e-4, 2e-4], over={"psi_rate": [4.0, 3.0]}, cc=0.05)),
    ("law_from.cc", lambda: gy.law_from([1e-4, 2e-4], over={"psi_rate": [3.0, 4.0]})),
    ("law_from.cc", lambda: gy.law_from([1e-4, 2e-4], over={"psi_rate": [3.0, 4.0]}, cc=-1.0)),
    ("law_from.cc_max", lambda: gy.law_from(lambda y: (0.0, 0.0), cc_max=math.inf)),
    ("law_from.smooth", lambda: gy.law_from([1e-4], over={"psi_rate": [3.0]}, cc=0.05, smooth=-1.0)),
    ("law_from.init", lambda: gy.law_from(governor)),
    ("law_from.init", lambda: gy.law_from(lambda y: (0.0, 0.0), init=(1.0,))),
    ("law_from.init", lambda: gy.law_from(casadi_filter())),
    ("law_from.source", lambda: gy.law_from(FORGETFUL, init=(0.0,))),
]


@pytest.mark.parametrize(("field", "build"), REFUSED, ids=[f"{i} {field}" for i, (field, _) in enumerate(REFUSED)])
def test_what_is_no_law_is_refused_by_field(field: str, build: Callable[[], Any]) -> None:
    with pytest.raises(gy.InputError) as caught:
        build()
    assert caught.value.field == field and caught.value.mend
