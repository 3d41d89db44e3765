"""How a law enters the loop: as a function of flat arrays, ``entry(t, y, p, s, u)``, compiled or plain.

These are the measurements y, parameters p, state s (changed in place) and command u (written). Parameters and state of
a law are nested NamedTuples; a compiled entry builds them from the flat arrays and takes the new state apart again. It
comes as a function pointer, so that the loop itself is compiled once for all laws and kept on disk, and a new law costs
a second.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import cfunc, float64, njit, void
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numpy.typing import NDArray

from gyroctl import nested
from gyroctl.harness.protocol import Law, LawError, Measurement
from gyroctl.nested import NotFlat, Shape
from gyroctl.plant import measurement

_SIGNATURE = void(float64, float64[::1], float64[::1], float64[::1], float64[::1])

_ENTRY = """
def entry(t, y, p, s, u):
    command, new = step({law}, t, {measurement}, {state})
    u[0], u[1] = command
    {taken}
"""


class CompiledLaw(NamedTuple):
    """A law as a function pointer with its parameters and its first state."""

    entry: Any
    p: NDArray[np.float64]
    s: NDArray[np.float64]


class NotCompiled(TypeError):
    """A law that runs as plain Python; the message says why."""


def compile_law(law: Law) -> CompiledLaw | None:
    """Compile a law that is a NamedTuple of floats and tables, or return None where it runs as plain Python.

    Fields may be grouped in NamedTuples, and so may those of the state. A table is a tuple of floats or an array of
    them with one dimension; compiled, the law's `step` gets it as an array: indices and `len` work alike in both. The
    state holds floats alone.
    """
    try:
        return compiled(law)
    except NotCompiled:
        return None


def compiled(law: Law) -> CompiledLaw:
    """Compile a law as `compile_law` does.

    Raises
    ------
    NotCompiled
        Where it cannot be, with the reason.
    """
    if not isinstance(law, tuple):
        raise NotCompiled(f"it is a {type(law).__name__} and no NamedTuple")
    start = law.init()
    if not isinstance(start, tuple):
        raise NotCompiled("its state is no tuple of floats")
    try:
        entry = _compiled_entry(nested.shape(law), nested.shape(start, tables=False, where="its state"))
    except NotFlat as error:
        raise NotCompiled(str(error)) from error
    except (NumbaError, UnsupportedBytecodeError) as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()] or ["numba cannot read it"]
        telling = (line for line in lines if "error" not in line.lower() or len(lines) == 1)
        raise NotCompiled(next(telling, lines[0])[:120]) from error
    return CompiledLaw(entry, _flat(law), _flat(start))


def _flat(value: Any) -> NDArray[np.float64]:
    """Numbers of a nest, and one more, so that the array is never empty."""
    return np.concatenate([*(np.asarray(leaf, np.float64).ravel() for leaf in nested.leaves(value)), np.zeros(1)])


@lru_cache(maxsize=256)
def _compiled_entry(law: Shape, state: Shape) -> Any:
    assert isinstance(law, tuple)
    types: dict[str, Any] = {}
    text = _ENTRY.format(
        law=nested.expression(law, "p", types),
        measurement=nested.expression((Measurement, (None,) * len(Measurement._fields)), "y", types),
        state=nested.expression(state, "s", types),
        taken="; ".join(f"s[{i}] = {place}" for i, place in enumerate(nested.places(state, "new"))) or "pass",
    )
    scope = {**types, "step": njit(error_model="numpy")(law[0].step)}
    exec(compile(text, "<entry of a law>", "exec"), scope)
    return cfunc(_SIGNATURE)(scope["entry"])


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
                f"{line_of(error)}"
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


def line_of(error: BaseException) -> str:
    """Where an exception arose: file and line of its innermost frame, that of the law where it misread its input."""
    frames = traceback.extract_tb(error.__traceback__)
    last = next((frame for frame in reversed(frames) if frame.filename != measurement.__file__), frames[-1])
    return f"{last.filename}:{last.lineno}"
