"""A law out of a casadi function: its instructions as a table of numbers, carried out one after the other.

An SX function is a straight line of scalar operations. One text carries out any such line, in Python and in machine
code, so that no function has to be compiled of its own: a new one costs nothing.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.harness.law_forms.entries import with_entry
from gyroctl.harness.law_forms.signals import SIGNALS, channels_of, heard, kept
from gyroctl.plant.compiled import inlined

UNARY = ("ASSIGN", "NEG", "EXP", "LOG", "SQRT", "SQ", "TWICE", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "FABS")
MORE = ("SIGN", "NOT", "TANH", "SINH", "COSH", "INV", "FLOOR", "CEIL")
BINARY = ("ADD", "SUB", "MUL", "DIV", "POW", "CONSTPOW", "FMIN", "FMAX", "LT", "LE", "EQ", "NE", "AND", "OR")
CHOICES = ("IF_ELSE_ZERO", "ATAN2", "HYPOT", "COPYSIGN")
OPERATIONS = (*UNARY, *MORE, *BINARY, *CHOICES)
"""casadi's names of the operations that are known, in the order of their numbers."""

CONSTANT, INPUT, OUTPUT = -1.0, -2.0, -3.0
"""Instructions that are no operation: a number, an input, an output."""

WIDTH = 4
"""Numbers of an instruction: operation, place of its result, and of its two arguments (or the number, the input)."""

ADD, SUB, MUL, DIV = (float(OPERATIONS.index(name)) for name in ("ADD", "SUB", "MUL", "DIV"))
FIRST_BINARY = float(len(UNARY) + len(MORE))

LARGEST_EXPONENT = 709.0
"""Beyond it exp is infinite, where Python would raise."""


class TapeState(NamedTuple):
    """State of the function, and the signals as they were last heard."""

    x: tuple[float, ...]
    seen: tuple[float, ...]


@shown(law_face)
class TapeLaw(NamedTuple):
    """A casadi function between sensors and controls."""

    tape: tuple[float, ...]  # instructions, `WIDTH` numbers each
    places: float  # how many places they work on
    first: tuple[float, ...]  # state before the first sample
    reads: tuple[float, ...]  # numbers of the signals in `SIGNALS`; inputs are time, signals, state
    rest: tuple[float, ...]  # what stands for a signal before it is first heard
    most: tuple[float, ...]  # limits of the command, from 0 to these [Nms]
    N: float  # gear ratio [-]
    period: float  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by."""
        return channels_of(tuple(SIGNALS[int(which)] for which in self.reads))

    @property
    def facts(self) -> list[tuple[str, str]]:
        """What its repr tells."""
        return [("operations", str(len(self.tape) // WIDTH)), ("state", f"{len(self.first)} numbers")]

    def init(self) -> TapeState:
        """Return the first state."""
        return TapeState(tuple(self.first), tuple(self.rest))

    def step(self, t: float, y: Any, state: TapeState) -> tuple[tuple[float, float], TapeState]:
        """Carry out the instructions."""
        seen, x, m = state.seen, state.x, len(self.reads)
        for j in range(m):
            seen = with_entry(seen, j, heard(self.reads[j], y, self.N, state.seen[j]))
        work = [0.0] * int(self.places)
        cc, cg = 0.0, 0.0
        for at in range(len(self.tape) // WIDTH):
            code, into, a, b = (
                self.tape[WIDTH * at],
                int(self.tape[WIDTH * at + 1]),
                self.tape[WIDTH * at + 2],
                int(self.tape[WIDTH * at + 3]),
            )
            if code == CONSTANT:
                work[into] = a
            elif code == INPUT:
                which = int(a)
                if which == 0:
                    work[into] = t
                elif which <= m:
                    work[into] = seen[which - 1]
                else:
                    work[into] = state.x[which - 1 - m]
            elif code == OUTPUT:
                if into == 0:
                    cc = work[int(a)]
                elif into == 1:
                    cg = work[int(a)]
                else:
                    x = with_entry(x, into - 2, work[int(a)])
            elif code < FIRST_BINARY:
                work[into] = unary(code, work[int(a)])
            else:
                work[into] = binary(code, work[int(a)], work[b])
        for j in range(m):
            seen = with_entry(seen, j, kept(self.reads[j], seen[j]))
        command = min(max(cc, 0.0), self.most[0]), min(max(cg, 0.0), self.most[1])
        return command, TapeState(x, seen)


@inlined
def over(v: Any, w: Any) -> Any:
    """Quotient as casadi has it: infinite or no number beyond what Python divides by."""
    return v / w if w != 0.0 else v * math.inf


@inlined
def power(v: Any, w: Any) -> Any:
    """Power as casadi has it: no number where a real one does not exist."""
    if v == 0.0:
        return 0.0 if w > 0.0 else (1.0 if w == 0.0 else math.inf)
    return v**w if v > 0.0 or w == math.floor(w) else math.nan


@inlined
def unary(code: Any, v: Any) -> Any:
    """Carry out an operation on one number, by its place in `OPERATIONS`."""
    if code == 0.0:
        return v
    if code == 1.0:
        return -v
    if code == 2.0:
        return math.exp(v) if v < LARGEST_EXPONENT else math.inf
    if code == 3.0:
        return math.log(v) if v > 0.0 else (-math.inf if v == 0.0 else math.nan)
    if code == 4.0:
        return math.sqrt(v) if v >= 0.0 else math.nan
    if code == 5.0:
        return v * v
    if code == 6.0:
        return 2.0 * v
    if code == 7.0:
        return math.sin(v)
    if code == 8.0:
        return math.cos(v)
    if code == 9.0:
        return math.tan(v)
    if code == 10.0:
        return math.asin(v) if abs(v) <= 1.0 else math.nan
    if code == 11.0:
        return math.acos(v) if abs(v) <= 1.0 else math.nan
    if code == 12.0:
        return math.atan(v)
    if code == 13.0:
        return abs(v)
    if code == 14.0:
        return 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
    if code == 15.0:
        return 1.0 if v == 0.0 else 0.0
    if code == 16.0:
        return math.tanh(v)
    if code == 17.0:
        return math.sinh(v) if abs(v) < LARGEST_EXPONENT else v * math.inf
    if code == 18.0:
        return math.cosh(v) if abs(v) < LARGEST_EXPONENT else math.inf
    if code == 19.0:
        return over(1.0, v)
    if code == 20.0:
        return math.floor(v) * 1.0
    return math.ceil(v) * 1.0


@inlined
def binary(code: Any, v: Any, w: Any) -> Any:
    """Carry out an operation on two numbers, by its place in `OPERATIONS`."""
    if code == ADD:
        return v + w
    if code == SUB:
        return v - w
    if code == MUL:
        return v * w
    if code == DIV:
        return over(v, w)
    kind = code - ADD
    if kind == 4.0 or kind == 5.0:
        return power(v, w)
    if kind == 6.0:
        return min(v, w)
    if kind == 7.0:
        return max(v, w)
    if kind == 8.0:
        return 1.0 if v < w else 0.0
    if kind == 9.0:
        return 1.0 if v <= w else 0.0
    if kind == 10.0:
        return 1.0 if v == w else 0.0
    if kind == 11.0:
        return 1.0 if v != w else 0.0
    if kind == 12.0:
        return 1.0 if v != 0.0 and w != 0.0 else 0.0
    if kind == 13.0:
        return 1.0 if v != 0.0 or w != 0.0 else 0.0
    if kind == 14.0:
        return w if v != 0.0 else 0.0
    if kind == 15.0:
        return math.atan2(v, w)
    if kind == 16.0:
        return math.sqrt(v * v + w * w)
    return math.copysign(v, w)
