"""The closed loop: measure -> law.step -> actuate -> advance. One text, run as Python or compiled, bit for bit alike.

A law enters as a function of flat arrays, ``entry(t, y, p, s, u)``: measurements y, parameters p, state s (changed in
place), command u (written). A compiled law comes as a function pointer, so that the loop itself is compiled once
for all laws and kept on disk, and a new law costs a tenth of a second.
"""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable
from functools import lru_cache
from itertools import groupby
from typing import Any, NamedTuple, cast

import numpy as np
from numba import cfunc, float64, njit, void
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray

from gyroctl.harness import actuation, sensing
from gyroctl.harness.actuation import ActuatorArrays, actuate
from gyroctl.harness.protocol import Law, LawError, Measurement
from gyroctl.harness.sensing import CHANNELS, SensorArrays, measure
from gyroctl.plant.compiled import entry_point, source_stamp
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import SOURCES, hold_into, slip_rate, steps_for

Entry = Callable[[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], None]

SWITCHED = 5.0
"""How much finer the slip is resolved after its coupling has changed: its transient carries energy, and with the step
of a steady coupling the ledger would be off by 3e-4 under random switching (4e-7 with this)."""

_SIGNATURE = void(float64, float64[::1], float64[::1], float64[::1], float64[::1])


class Kernel(NamedTuple):
    """What the loop needs to advance the plant: constants, moments on their grid, longest step."""

    k: Coefficients
    waves: NDArray[np.float64]  # flat, sample by sample [Nm]
    waves_dt: float  # [s]
    dt: float  # [s]


def _closed_loop(stamp: str) -> Callable[..., int]:
    def closed_loop(
        entry: Any,
        p: Any,
        s: Any,
        every: int,
        kernel: Kernel,
        sensors: SensorArrays,
        actuators: ActuatorArrays,
        tick: float,
        record: Any,
        commands: Any,
        controls: Any,
        held: Any,
        saturations: Any,
    ) -> int:
        """Run the loop over all rows of `commands`.

        Parameters
        ----------
        entry, p, s, every
            The law: entry function, parameters, state, samples between its calls.
        tick : float
            Period of the loop. [s]
        record : (n + 1, rows) array
            Row 0 holds the start; filled with state and ledger at each sample.
        commands, controls : (n, 2) arrays
            Filled with what the law asked for and with what the actuators gave. [Nms]
        held : (2,) array
            Controls before the first sample. [Nms]
        saturations : (1,) array
            Counts commands beyond the limits.

        Returns
        -------
        int
            The sample at which the law gave a number that is not finite, or -1.
        """
        assert stamp
        y = np.zeros(len(CHANNELS))
        u = np.zeros(2)
        state = record[0].copy()
        work = np.empty((5, state.size))
        moments, weight = np.empty(6), np.empty(8)
        now = np.empty((2, 1))
        for sample in range(commands.shape[0]):
            measure(sensors, sample, record, y)
            if sample % every == 0:
                entry(sample * tick, y, p, s, u)
                if not (math.isfinite(u[0]) and math.isfinite(u[1])):
                    return sample
            commands[sample, 0], commands[sample, 1] = u[0], u[1]
            before = held[0]
            saturations[0] += actuate(actuators, sample, commands, held)
            controls[sample, 0], controls[sample, 1] = held[0], held[1]
            now[0, 0], now[1, 0] = held[0], held[1]
            rate = slip_rate(kernel.k, held[0])
            if sample > 0 and held[0] != before:
                rate = SWITCHED * rate
            steps = steps_for(tick, kernel.dt, rate)
            hold_into(
                state, work, moments, weight, kernel.k, now, sample * tick, tick, steps, kernel.waves, kernel.waves_dt
            )
            record[sample + 1, :] = state
        return -1

    return closed_loop


closed_loop = _closed_loop(source_stamp((*SOURCES, sensing.__file__, actuation.__file__, __file__)))
"""The loop as plain Python."""

compiled_loop = entry_point(closed_loop)
"""The same text, compiled."""


def _calls(entry: Any, p: Any, s: Any, y: Any, u: Any, calls: int) -> None:
    for _ in range(calls):
        entry(0.0, y, p, s, u)


compiled_calls = entry_point(_calls)
"""Call a compiled law over and over, to time it."""


class CompiledLaw(NamedTuple):
    """A law as a function pointer with its parameters and its first state."""

    entry: Any
    p: NDArray[np.float64]
    s: NDArray[np.float64]


def compile_law(law: Law) -> CompiledLaw | None:
    """Compile a law that is a NamedTuple of floats and tables, or return None where it cannot be compiled.

    A table is a tuple of floats or an array of them with one dimension. Compiled, the law's `step` gets it as an array:
    indices and `len` work alike in both. The state is a tuple of floats alone.
    """
    if not isinstance(law, tuple):
        return None
    start = law.init()
    if not _is_floats(start):
        return None
    layout = tuple(_length(value) for value in law)
    if None in layout:
        return None
    try:
        entry = _compiled_entry(*cast(Any, (type(law), type(start), len(start), layout)))
    except (NumbaError, UnsupportedBytecodeError):
        return None
    parameters = [np.asarray(value, np.float64).ravel() for value in law]
    return CompiledLaw(entry, np.concatenate([*parameters, np.zeros(1)]), np.array([*start, 0.0]))


def _is_floats(value: Any) -> bool:
    return isinstance(value, tuple) and all(_is_number(v) for v in value)


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)


def _length(value: Any) -> int | None:
    """Length of a table, -1 for a number, None for what cannot be compiled."""
    if _is_number(value):
        return -1
    if isinstance(value, np.ndarray):
        return int(value.size) if value.ndim == 1 and value.dtype == np.float64 else None
    return len(value) if _is_floats(value) else None


@lru_cache(maxsize=256)
def _compiled_entry(law_type: type[Any], state_type: type[Any], states: int, layout: tuple[int, ...]) -> Any:
    step = njit(error_model="numpy")(law_type.step)
    fields = _fields(layout)
    pack = njit(_pack_plain(states)) if state_type is tuple else njit(_pack_named(state_type, states))
    unpack = njit(_unpack_nothing if states == 0 else _unpack)

    def entry(t: Any, y: Any, p: Any, s: Any, u: Any) -> None:
        law = law_type(*fields(p))
        command, new = step(law, t, Measurement(*to_fixed_tuple(y, 7)), pack(s))
        u[0], u[1] = command
        unpack(new, s)

    return cfunc(_SIGNATURE)(entry)


def _fields(layout: tuple[int, ...]) -> Any:
    """Compiled function from the flat parameters to the tuple of a law's fields: numbers and tables in their order."""
    build, begin = njit(lambda p: ()), 0
    for is_table, run in groupby(layout, key=lambda length: length >= 0):
        for length in run if is_table else [sum(1 for _ in run)]:
            build = _joined(build, _table_at(begin, length) if is_table else _numbers_at(begin, length))
            begin += length
    return build


def _numbers_at(begin: int, count: int) -> Any:
    return njit(lambda p: to_fixed_tuple(p[begin : begin + count], count))


def _table_at(begin: int, length: int) -> Any:
    return njit(lambda p: (p[begin : begin + length],))


def _joined(left: Any, right: Any) -> Any:
    return njit(lambda p: left(p) + right(p))


def _pack_plain(states: int) -> Callable[[Any], Any]:
    if states == 0:
        return lambda s: ()
    return lambda s: to_fixed_tuple(s, states)


def _pack_named(state_type: type[Any], states: int) -> Callable[[Any], Any]:
    if states == 0:
        return lambda s: state_type()
    return lambda s: state_type(*to_fixed_tuple(s, states))


def _unpack(new: Any, s: Any) -> None:
    for i in range(len(new)):
        s[i] = new[i]


def _unpack_nothing(new: Any, s: Any) -> None:
    pass


class PythonLaw:
    """A law called as plain Python, with the shape of its answers checked at each call."""

    def __init__(self, law: Law, name: str, timer: Callable[[], float] | None = None) -> None:
        self.law, self.name, self.timer = law, name, timer
        self.state = law.init()
        self.seconds: list[float] = []

    def __call__(self, t: float, y: NDArray[np.float64], p: object, s: object, u: NDArray[np.float64]) -> None:
        """Take one sample."""
        begin = self.timer() if self.timer else 0.0
        try:
            answer = self.law.step(float(t), Measurement(*y.tolist()), self.state)
        except Exception as error:
            raise LawError(
                f"law {self.name!r} failed at t = {t:.1f} s: {type(error).__name__}: {error}. Correct its step, "
                f"{_line_of(error)}"
            ) from error
        if self.timer:
            self.seconds.append(self.timer() - begin)
        try:
            command, self.state = answer
            u[0], u[1] = (float(value) for value in command)
        except (TypeError, ValueError):
            raise LawError(
                f"law {self.name!r} returned {answer!r} at t = {t:.1f} s: expected ((cc, cg), state) with two numbers. "
                "Return the command and the new state, in this order."
            ) from None


def _line_of(error: BaseException) -> str:
    """Where an exception arose: file and line of its innermost frame."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{last.filename}:{last.lineno}"
