"""From a linear system of python-control or scipy to the law of it: names, sampling, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gyroctl.errors import InputError
from gyroctl.harness.law_forms.linear import LinearLaw
from gyroctl.harness.law_forms.signals import SIGNALS

SOURCE = "law_from.source"
METHODS = {
    "tustin": "bilinear",
    "bilinear": "bilinear",
    "zoh": "zoh",
    "foh": "foh",
    "impulse": "impulse",
    "euler": "euler",
    "backward_diff": "backward_diff",
}
"""Ways to sample a system of continuous time, by the names that python-control and scipy give them."""

CONTROLS = ("cc", "cg")
STATES_MAX = 64
"""A law of more states is no law of a device with fourteen."""


def is_linear(source: Any) -> bool:
    """Whether it is a linear system of python-control or of scipy.signal; neither is loaded to find that out."""
    homes = {kind.__module__.partition(".")[0] for kind in type(source).__mro__}
    return bool(homes & {"control", "scipy"}) and (hasattr(source, "to_ss") or hasattr(source, "dt"))


def system_of(source: Any, period: float | None, method: str) -> tuple[Any, float]:
    """Return the system in discrete time, as a `control.StateSpace`, and its period [s].

    Raises
    ------
    InputError
        Fields ``law_from.source``, ``law_from.period``, ``law_from.method``.
    """
    import control

    if method not in METHODS:
        mend = f"Choose one of {', '.join(METHODS)}"
        raise InputError("law_from.method", method, "is no way to sample a system", mend)
    name = type(source).__name__
    try:
        system = source if isinstance(source, control.StateSpace) else _as_states(source)
    except (ValueError, TypeError, NotImplementedError, control.ControlSlycot) as error:
        mend = "Give a proper system, control.ss(A, B, C, D) where a transfer function cannot be turned into one"
        raise InputError(SOURCE, name, f"has no state space ({error})", mend) from error
    matrices = [np.asarray(getattr(system, key)) for key in "ABCD"]
    if not all(np.isrealobj(matrix) and np.all(np.isfinite(matrix)) for matrix in matrices):
        raise InputError(SOURCE, name, "has entries that are no finite real numbers", "Give a real system")
    if matrices[0].shape[0] > STATES_MAX:
        problem = f"has {matrices[0].shape[0]} states"
        raise InputError(SOURCE, name, problem, f"Reduce it to {STATES_MAX} states, for example by control.balred")
    if system.dt is True:
        mend = "Give the system its sampling time, for example control.ss(A, B, C, D, 0.1)"
        raise InputError(SOURCE, name, "is of discrete time without a sampling time", mend)
    if system.dt:  # discrete already
        if period is not None and not math.isclose(period, system.dt, rel_tol=1e-9):
            mend = "Leave period out, or sample the system anew"
            raise InputError("law_from.period", period, f"the system is sampled at {system.dt:g} s", mend)
        return system, float(system.dt)
    step = 0.1 if period is None else period
    if matrices[0].size == 0:
        return system, step
    sampled = system.sample(step, METHODS[method])
    if not all(np.all(np.isfinite(getattr(sampled, key))) for key in "ABCD"):
        mend = "Choose another period or method"
        raise InputError("law_from.method", method, "gives a system that is not finite", mend)
    sampled.update_names(inputs=system.input_labels, outputs=system.output_labels)
    return sampled, step


def _as_states(source: Any) -> Any:
    """A transfer function, or what scipy.signal has, as a state space."""
    import control

    if not hasattr(source, "to_ss"):
        return control.ss(source)
    dt = getattr(source, "dt", None)
    states = source.to_ss()
    return control.ss(states.A, states.B, states.C, states.D, 0 if dt is None else dt)


def linear_law(
    system: Any,
    reads: tuple[str, ...],
    sets: tuple[str, ...],
    point: dict[str, float],
    pair: tuple[float, float],
    most: tuple[float, float],
    N: float,
    period: float,
) -> LinearLaw:
    """Make the law of a sampled system whose inputs and outputs are known by name."""
    n, m = max(system.nstates, 1), len(reads)
    A, B = np.zeros((n, n)), np.zeros((n, m))
    C, D = np.zeros((2, n)), np.zeros((2, m))
    rows = [CONTROLS.index(name) for name in sets]
    A[: system.nstates, : system.nstates], B[: system.nstates] = system.A, system.B
    C[np.ix_(rows, range(system.nstates))], D[rows] = system.C, system.D
    a, b, c, d = (tuple(float(value) for value in matrix.ravel()) for matrix in (A, B, C, D))
    numbers = tuple(float(SIGNALS.index(name)) for name in reads)
    return LinearLaw(a, b, c, d, numbers, tuple(point[name] for name in reads), pair, most, N, period)
