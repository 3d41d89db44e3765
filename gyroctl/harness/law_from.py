"""A law in one line: from a linear system, a table, a casadi function, or a function of Python."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness.first_look import first_look
from gyroctl.harness.law_forms.from_casadi import casadi_law, is_casadi
from gyroctl.harness.law_forms.from_linear import CONTROLS, is_linear, linear_law, system_of
from gyroctl.harness.law_forms.from_table import is_table, table_law
from gyroctl.harness.law_forms.signals import SIGNALS, signal
from gyroctl.harness.law_forms.written import Numbers, written
from gyroctl.harness.protocol import Law
from gyroctl.orbits.orbit import Orbit
from gyroctl.plant.measurement import CHANNELS, read
from gyroctl.reading import is_finite

if TYPE_CHECKING:
    import casadi
    import control
    import xarray

CC_MAX, CG_MAX = 0.3, 0.02
"""Limits of the command, those of the default actuators. [Nms]"""

N = 22.555555555555557
"""Gear ratio of Table 1. [-]"""

INSTANTS = 64
"""Instants of a wave period for the mean of a signal on an orbit."""

SOURCE = "law_from.source"


def law_from(
    source: control.LTI
    | casadi.Function
    | xarray.Dataset
    | xarray.DataArray
    | NDArray[Any]
    | Callable[..., Any]
    | Sequence[Any],
    *,
    reads: Sequence[str] | str | None = None,
    sets: Sequence[str] | str | None = None,
    at: Orbit | Mapping[str, float] | None = None,
    over: Mapping[str, Sequence[float]] | None = None,
    cc: float | None = None,
    cg: float | None = None,
    init: Any = (),
    period: float | None = None,
    method: str = "tustin",
    smooth: float = 0.0,
    cc_max: float = CC_MAX,
    cg_max: float = CG_MAX,
    gear_ratio: float = N,
) -> Law:
    """Make a law of something that is none yet, and look at its answers before it is run.

    The law keeps its command within 0 and `cc_max`, `cg_max`. A linear system, a table and a casadi function of scalar
    operations run as machine code; a function of Python does where numba can compile it, and as plain Python elsewhere.

    Parameters
    ----------
    source : control.LTI, casadi.Function, xarray.Dataset, xarray.DataArray, array or callable
        A linear system (of python-control or scipy.signal) from deviations of what it reads to deviations of cc and
        cg, without any sign of its own. A table of commands over measured quantities [Nms], linear between its nodes,
        held beyond its edges: a Dataset of cc and cg, a DataArray, or an array with `over`. A casadi function, or a
        function of Python, of arguments named t [s], y (the measurement), state, or after what they read, that gives
        (cc, cg) [Nms], and with a state ((cc, cg), new state).
    reads : str or sequence of str, optional
        What a linear system reads, input by input; by default the names of its inputs. For functions that take the
        whole measurement: the channels that they look at.
    sets : str or sequence of str, optional
        What a linear system or an array gives, "cc" or "cg"; by default the names of its outputs.
    at : orbit or mapping of str to float, optional
        Operating point of a linear system: values of what it reads [rad, rad/s], 0 where none is given. Of an orbit
        the means over a wave, and its controls.
    over : mapping of str to sequence of float, optional
        Quantities and nodes of an array, axis by axis. [rad, rad/s]
    cc, cg : float, optional
        Controls at the operating point of a linear system, and the one that a table does not hold. [Nms]
    init : tuple, optional
        State of a function before the first sample, a tuple or NamedTuple of floats.
    period : float, optional
        Sampling period, 0.1 s by default; of a system in discrete time its own. [s]
    method : {"tustin", "zoh", "foh", "impulse", "euler", "backward_diff"}
        How a system of continuous time is sampled.
    smooth : float
        Time constant with which the quantities of a table are filtered before it is looked up, 0 for none. [s]
    cc_max, cg_max : float
        Limits of the command. [Nms]
    gear_ratio : float
        Of the device, for the signal slip. [-]

    Returns
    -------
    Law
        For `compare`, `simulate`, `margins` as any other.

    Raises
    ------
    InputError
        Fields ``law_from.source``, ``law_from.reads`` and so on: what cannot be a law, with the mend.

    Notes
    -----
    What may be read: the channels psi, psi_rate, omega_rate, phi1, phi3, phi1_rate, phi3_rate of
    `gyroctl.Measurement`; u1, u3, the float's rate in the frame of the ring, (22)-(23); slip, omega' - N psi';
    float_rate, the modulus of the float's rate. Where a sensor tells nothing the last value stands.
    """
    known = tuple([reads] if isinstance(reads, str) else reads) if reads is not None else None
    named = tuple([sets] if isinstance(sets, str) else sets) if sets is not None else None
    for name in known or ():
        _one_of("law_from.reads", name, SIGNALS)
    for name in named or ():
        _one_of("law_from.sets", name, CONTROLS)
    most = (_number("law_from.cc_max", cc_max, 1.0), _number("law_from.cg_max", cg_max, 1.0))
    ratio = _number("law_from.gear_ratio", gear_ratio, 1e3)
    step = None if period is None else _number("law_from.period", period, 10.0)
    if not (is_finite(smooth) and smooth >= 0.0):
        raise InputError("law_from.smooth", smooth, "is no time constant", "Give it in seconds, 0 for none")
    pair = {name: value for name, value in (("cc", cc), ("cg", cg)) if value is not None}
    for name, value in pair.items():
        if not (is_finite(value) and value >= 0.0):
            raise InputError(f"law_from.{name}", value, "is no control", f"Give {name} >= 0 in Nms")
    if is_linear(source):
        law: Any = _linear(source, known, named, at, pair, most, ratio, step, method)
    elif is_casadi(source):
        point = _point(at, ratio)
        law = casadi_law(source, _state(init), known, point, most, ratio, 0.1 if step is None else step)
    elif is_table(source):
        law = table_law(source, over, named, pair, smooth, most, ratio, 0.1 if step is None else step)
    elif callable(source) and not isinstance(source, type):
        channels = None if known is None else tuple(name for name in CHANNELS if name in known)
        law = written(source, Numbers(init, *most, ratio, 0.1 if step is None else step), channels)
    else:
        mend = "Give a control.LTI, a casadi.Function, a table of cc and cg, or a function that returns (cc, cg)"
        raise InputError(SOURCE, type(source).__name__, "is nothing that a law can be made of", mend)
    first_look(law)
    return law  # type: ignore[no-any-return]


def _linear(
    source: Any,
    reads: tuple[str, ...] | None,
    sets: tuple[str, ...] | None,
    at: Orbit | Mapping[str, float] | None,
    pair: Mapping[str, float],
    most: tuple[float, float],
    ratio: float,
    period: float | None,
    method: str,
) -> Law:
    system, step = system_of(source, period, method)
    inputs = tuple(system.input_labels) if reads is None else reads
    outputs = tuple(system.output_labels) if sets is None else sets
    for field, names, count, known in (
        ("reads", inputs, system.ninputs, SIGNALS),
        ("sets", outputs, system.noutputs, CONTROLS),
    ):
        if len(names) != count or len(set(names)) != count:
            what = "inputs" if field == "reads" else "outputs"
            raise InputError(f"law_from.{field}", names, f"the system has {count} {what}", "Give one name for each")
        for name in names:
            _one_of(f"law_from.{field}", name, known)
    if "psi" in inputs:
        mend = "Let it read u1 and u3, the float's rate in the frame of the ring"
        raise InputError("law_from.reads", "psi", "grows from turn to turn and has no deviation from a point", mend)
    point = _point(at, ratio)
    stands = dict(zip(CONTROLS, (at.cc, at.cg), strict=True)) if isinstance(at, Orbit) else {}
    both = {"cc": 0.0, "cg": 0.0} | stands | dict(pair)
    values = {name: point.get(name, 0.0) for name in inputs}
    return linear_law(system, inputs, outputs, values, (both["cc"], both["cg"]), most, ratio, step)


def _point(at: Orbit | Mapping[str, float] | None, ratio: float) -> dict[str, float]:
    """Values of the signals at the operating point."""
    if at is None:
        return {}
    if isinstance(at, Orbit):
        if at.status == "no orbit":
            raise InputError("law_from.at", at.status, "is no operating point", at.advice)
        samples = [read(x) for x in at.states(INSTANTS)]
        return {
            name: float(np.mean([signal(float(i), y, ratio) for y in samples]))
            for i, name in enumerate(SIGNALS)
            if name != "psi"
        }
    if not isinstance(at, Mapping):
        mend = 'Give an orbit, or values by name, for example {"psi_rate": 3.14}'
        raise InputError("law_from.at", type(at).__name__, "is no operating point", mend)
    for name, value in at.items():
        _one_of("law_from.at", name, SIGNALS)
        if not is_finite(value):
            raise InputError(f"law_from.at.{name}", value, "must be a finite number", "Give it in rad or rad/s")
    return {name: float(value) for name, value in at.items()}


def _state(init: Any) -> tuple[float, ...]:
    """State of a casadi function as a tuple of numbers."""
    try:
        values = tuple(float(value) for value in np.atleast_1d(np.asarray(init, dtype=np.float64)).ravel())
    except (TypeError, ValueError) as error:
        raise InputError("law_from.init", init, "is no row of numbers", "Give a tuple of floats") from error
    if not all(math.isfinite(value) for value in values):
        raise InputError("law_from.init", init, "has entries that are not finite", "Give a tuple of floats")
    return values


def _one_of(field: str, name: Any, known: Sequence[str]) -> None:
    if name not in known:
        raise InputError(field, name, "is not known", f"Choose from {', '.join(known)}")


def _number(field: str, value: Any, most: float) -> float:
    if not (is_finite(value) and 0.0 < value <= most):
        raise InputError(field, value, f"must be a positive number up to {most:g}", "Give it in SI units")
    return float(value)
