"""How a law enters the loop: as a function of flat arrays, ``entry(t, y, p, s, u)``, compiled or plain.

These are the measurements y, parameters p, state s (changed in place) and command u (written). Parameters and state of
a law are nested NamedTuples; a compiled entry builds them from the flat arrays and takes the new state apart again. It
comes as a function pointer, so that the loop itself is compiled once for all laws, and a new law costs a second. Loop
and laws are kept on disk, by their content.
"""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Callable
from functools import lru_cache
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numba import cfunc, float64, njit, void
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numpy.typing import NDArray

from gyroctl import nested
from gyroctl.harness.protocol import Failure, Law, LawError, Machined, Measurement
from gyroctl.nested import NotFlat, Shape
from gyroctl.plant import measurement
from gyroctl.plant.ingredients import Untold, ingredients
from gyroctl.plant.machine_code import kept_callback

_SIGNATURE = void(float64, float64[::1], float64[::1], float64[::1], float64[::1])

WITHIN = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Compiled for the entry alone: to be called from Python as well takes longer to compile than many a law."""

_ATTEMPT = """
def attempt(t, y, p, s, u):
    command, new = step({law}, t, {measurement}, {state})
    {kept}
    u[0], u[1] = command[0], command[1]
"""
"""A sample of the law: its new state stands behind the old one until it is known to be whole."""

_ENTRY = """
def entry(t, y, p, s, u):
    try:
        attempt(t, y, p, s, u)
    except Exception:
        u[0] = FAILED
    for i in range(SIZE):
        if s[SIZE + i] != s[SIZE + i]:
            u[0] = FAILED
    if u[0] == u[0] and u[1] == u[1]:
        for i in range(SIZE):
            s[i] = s[SIZE + i]
"""
"""A law that raises, or whose new state holds what is no number, leaves its state as it was and a command that is no
number: the loop stops, and the same sample gone through as plain Python says what happened. The attempt is a function
of its own, since everything within a `try` is dear to compile: a minute for a large law."""


class CompiledLaw(NamedTuple):
    """A law as a function pointer with its parameters and its first state, with room for the next one behind it."""

    entry: Any
    p: NDArray[np.float64]
    s: NDArray[np.float64]


class NotCompiled(TypeError):
    """A law that runs as plain Python; the message says why."""


def compile_law(law: Law) -> CompiledLaw | None:
    """Compile a law that is a NamedTuple of floats and tables, or return None where it runs as plain Python.

    One that brings its own machine code (`Machined`) is compiled already.

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
    if isinstance(law, Machined):
        machine = law.machine()
        if machine is None:
            raise NotCompiled("its settings need Python at every sample")
        return CompiledLaw(*machine)
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
    first = _flat(start)
    return CompiledLaw(entry, _flat(law), np.concatenate([first, first]))


def _flat(value: Any) -> NDArray[np.float64]:
    """Numbers of a nest, and one more, so that the array is never empty."""
    return np.concatenate([*(np.asarray(leaf, np.float64).ravel() for leaf in nested.leaves(value)), np.zeros(1)])


@lru_cache(maxsize=256)
def _compiled_entry(law: Shape, state: Shape) -> Any:
    assert isinstance(law, tuple)
    types: dict[str, Any] = {}
    places = nested.places(state, "new")
    size = len(places) + 1  # as `_flat` makes it
    text = _ATTEMPT.format(
        law=nested.expression(law, "p", types),
        measurement=nested.expression((Measurement, (None,) * len(Measurement._fields)), "y", types),
        state=nested.expression(state, "s", types),
        kept="; ".join(f"s[{size + i}] = {place}" for i, place in enumerate(places)) or "pass",
    )
    try:
        content = ingredients(text + _ENTRY, *types.values(), names=("step",))
    except Untold:  # it reads something that may be another thing tomorrow
        content = ""
    # as Python would: a division by zero and an index beyond a table are errors
    step = njit(error_model="python", boundscheck=True, **WITHIN)(_named(law[0].step, content))
    scope = {**types, "step": step, "FAILED": math.nan, "SIZE": size, "__name__": __name__}
    exec(compile(text + _ENTRY, f"<entry of {law[0].__name__}>", "exec"), scope)
    scope["attempt"] = njit(**WITHIN)(_named(scope["attempt"], content))
    entry = _named(scope["entry"], content)
    return kept_callback(entry, _SIGNATURE, content) if content else cfunc(_SIGNATURE)(entry)


def _named(function: Any, content: str) -> Any:
    """Put the content into the name of a function, by which its machine code is found: no two laws may share that."""
    if not (content and isinstance(function, FunctionType)):
        return function
    parts = function.__code__, function.__globals__, function.__name__, function.__defaults__, function.__closure__
    copy = FunctionType(*parts)
    copy.__qualname__, copy.__module__ = f"{function.__qualname__}_{content[:16]}", function.__module__
    copy.__kwdefaults__ = function.__kwdefaults__
    return copy


class PythonLaw:
    """A law called as plain Python, with its answer checked at each call.

    Parameters
    ----------
    law : Law
        The law.
    name : str
        For messages.
    timer : callable, optional
        Clock that times each call. [s]
    limit : float
        Time that all calls together may take. [s]
    opening : callable, optional
        Told the time before each sample: it opens the window of a law that is told the waves ahead.
    """

    def __init__(
        self,
        law: Law,
        name: str,
        timer: Callable[[], float] = time.perf_counter,
        limit: float = math.inf,
        opening: Callable[[float], None] | None = None,
    ) -> None:
        self.law, self.name, self.timer, self.limit, self.opening = law, name, timer, limit, opening
        self.state = law.init()
        self.seconds: list[float] = []
        self.spent = 0.0

    def __call__(self, t: float, y: NDArray[np.float64], p: object, s: object, u: NDArray[np.float64]) -> None:
        """Take one sample."""
        if self.opening:
            self.opening(float(t))
        begin = self.timer()
        answer = self._answer(float(t), Measurement(*y.tolist()))
        self.seconds.append(self.timer() - begin)
        self.spent += self.seconds[-1]
        if self.spent > self.limit:
            mend = f"{self.limit:g} s are allowed. Compute less in step, or allow more with run.time_limit"
            raise self._failed("too slow", t, f"took {self.spent:.1f} s so far", mend)
        try:
            command, state = answer
            cc, cg = (float(value) for value in command)
        except (TypeError, ValueError):
            mend = "expected ((cc, cg), state) with two numbers. Return the command and the new state, in this order"
            raise self._failed("wrong answer", t, f"returned {answer!r}", mend) from None
        mend = "Guard divisions and square roots in its step"
        if not (math.isfinite(cc) and math.isfinite(cg)):
            raise self._failed("not finite", t, f"gave a command that is not finite, ({cc:g}, {cg:g})", mend)
        if any(isinstance(value, float) and value != value for value in nested.leaves(state)):
            raise self._failed("not finite", t, "gave a new state of which a part is no number", mend)
        u[0], u[1], self.state = cc, cg, state

    def _answer(self, t: float, y: Measurement) -> Any:
        try:
            return self.law.step(t, y, self.state)
        except KeyboardInterrupt:
            raise
        except SystemExit as error:
            mend = f"A law must not end the program, return a command instead, {line_of(error)}"
            raise self._failed("ended the program", t, "called for an exit", mend) from error
        except BaseException as error:
            mend = f"{type(error).__name__}: {error}. Correct its step, {line_of(error)}"
            raise self._failed("raised", t, "failed", mend) from error

    def _failed(self, kind: Failure, t: float, what: str, mend: str) -> LawError:
        return LawError(f"law {self.name!r} {what} at t = {t:.1f} s: {mend}", kind, float(t))


def last_state(law: Law, s: NDArray[np.float64]) -> Any:
    """State of a law, as its `step` knows it, out of the flat one of a compiled run."""
    if isinstance(law, Machined):
        return law.state_of(s)
    return nested.like(law.init(), s.tolist())


def why_it_stopped(law: Law, name: str, t: float, y: NDArray[np.float64], state: NDArray[np.float64]) -> LawError:
    """Go through the sample at which a compiled law stopped as plain Python, and return what that says."""
    again = PythonLaw(law, name)
    again.state = last_state(law, state)
    try:
        again(t, y, None, None, np.zeros(2))
    except LawError as error:
        return error
    what = "numbers that are none when it is compiled, and that plain Python knows"
    return LawError(
        f"law {name!r} gave at t = {t:.1f} s {what}: leave out what numba reads in its own way", "not finite", t
    )


def line_of(error: BaseException) -> str:
    """Where an exception arose: file and line of its innermost frame, that of the law where it misread its input."""
    frames = traceback.extract_tb(error.__traceback__)
    last = next((frame for frame in reversed(frames) if frame.filename != measurement.__file__), frames[-1])
    return f"{last.filename}:{last.lineno}"
