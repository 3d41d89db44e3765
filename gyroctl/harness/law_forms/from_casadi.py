"""From a casadi function to the law of it: which input is what, and its instructions as a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

from gyroctl.errors import InputError
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.harness.law_forms.signals import SIGNALS, heard, kept
from gyroctl.harness.law_forms.tape import CONSTANT, INPUT, OPERATIONS, OUTPUT, TapeLaw, TapeState
from gyroctl.plant.measurement import CHANNELS

SOURCE = "law_from.source"
MEND = f"Name its inputs t, y (the measurement), state, or after what they read: {', '.join(SIGNALS)}"
EMPTY = (0.0,)
"""State of a function without one: machine code knows no empty row."""

OUTPUTS = "Give one output of cc and cg, or outputs named cc and cg, and with a state one named state or new_state"


@shown(law_face)
@dataclass(frozen=True)
class CalledLaw:
    """A casadi function that is no straight line of scalar operations, called at every sample.

    Parameters
    ----------
    text : str
        The function as casadi writes it.
    shell : TapeLaw
        What is beside the function: what is read, limits, period.
    period : float
        Sampling period. [s]
    """

    text: str
    shell: TapeLaw
    period: float

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by."""
        return self.shell.sensors

    @property
    def facts(self) -> list[tuple[str, str]]:
        """What its repr tells."""
        return [("called", "by casadi at every sample"), ("state", f"{len(self.shell.first)} numbers")]

    def init(self) -> TapeState:
        """Return the first state."""
        return self.shell.init()

    def step(self, t: float, y: Any, state: TapeState) -> tuple[tuple[float, float], TapeState]:
        """Call the function."""
        shell, pairs = self.shell, list(zip(self.shell.reads, state.seen, strict=True))
        seen = [heard(which, y, shell.N, last) for which, last in pairs]
        cc, cg, *x = _flat(self.text)([t, *seen, *state.x])
        cc, cg = min(max(cc, 0.0), shell.most[0]), min(max(cg, 0.0), shell.most[1])
        again = tuple(kept(which, value) for which, value in zip(shell.reads, seen, strict=True))
        return (cc, cg), TapeState(tuple(x), again)


@lru_cache(maxsize=64)
def _flat(text: str) -> Any:
    """Function of a list of numbers from the text of a casadi function of one vector."""
    import casadi as ca

    function = ca.Function.deserialize(text)

    def called(numbers: list[float]) -> list[float]:
        return [float(value) for value in function(numbers).full().ravel()]

    return called


def is_casadi(source: Any) -> bool:
    """Whether it is a casadi function; casadi is not loaded to find that out."""
    return type(source).__module__.partition(".")[0] == "casadi" and type(source).__name__ == "Function"


def casadi_law(
    function: Any,
    first: tuple[float, ...],
    reads: tuple[str, ...] | None,
    at: Mapping[str, float],
    most: tuple[float, float],
    N: float,
    period: float,
) -> TapeLaw | CalledLaw:
    """Make the law of a casadi function.

    Raises
    ------
    InputError
        Fields ``law_from.source``, ``law_from.init``: inputs or outputs that a law does not know, another length of
        the state.
    """
    import casadi as ca

    inputs = {function.name_in(i): function.numel_in(i) for i in range(function.n_in())}
    meant = _meanings(inputs, reads)
    read = tuple(dict.fromkeys(name for group in meant.values() for name in group if name in SIGNALS))
    if not read:
        raise InputError(SOURCE, ", ".join(inputs), "reads nothing", MEND)
    size = next((inputs[name] for name, group in meant.items() if group == ("state",)), 0)
    if size != len(first):
        mend = f"Give init= a tuple of {size} numbers" if size else "Leave init out: the function has no input state"
        raise InputError("law_from.init", first, f"the state of the function has {size} numbers", mend)
    try:
        flat = _flattened(ca.SX, function, meant, read, size)
        tape, places = _instructions(flat)
    except (RuntimeError, NotImplementedError):  # more than scalar operations: a solver, an interpolant
        flat, tape, places = _flattened(ca.MX, function, meant, read, size), EMPTY, 0.0
    numbers = tuple(float(SIGNALS.index(name)) for name in read)
    rest = tuple(float(at.get(name, 0.0)) for name in read)
    law = TapeLaw(tape, places, first or EMPTY, numbers, rest, most, N, period)
    return law if places else CalledLaw(flat.serialize(), law, period)


def _meanings(inputs: Mapping[str, int], reads: tuple[str, ...] | None) -> dict[str, tuple[str, ...]]:
    """What each input of the function is: ("t",), ("state",), or the signals of its entries."""
    unnamed = [name for name in inputs if name not in ("t", "y", "state", *SIGNALS)]
    found: dict[str, tuple[str, ...]] = {name: (name,) for name in inputs if name not in unnamed and name != "y"}
    if "y" in inputs:
        found["y"] = CHANNELS if reads is None or inputs["y"] == len(CHANNELS) else reads
    elif unnamed and reads is not None:
        found[unnamed.pop(0)] = reads
    elif unnamed and inputs[unnamed[0]] == len(CHANNELS):
        found[unnamed.pop(0)] = CHANNELS
    if unnamed and "state" not in inputs and unnamed[0] == list(inputs)[-1] and len(inputs) > 1:
        found[unnamed.pop(0)] = ("state",)
    if unnamed:
        raise InputError(SOURCE, unnamed[0], "is no input that a law can give", MEND)
    for name, group in found.items():
        if group != ("state",) and inputs[name] != len(group):
            raise InputError(SOURCE, name, f"has {inputs[name]} entries, and what it reads has {len(group)}", MEND)
    return {name: found[name] for name in inputs}


def _flattened(kind: Any, function: Any, meant: Mapping[str, tuple[str, ...]], read: tuple[str, ...], size: int) -> Any:
    """Function of one vector, time, signals and state, that gives one, command and new state."""
    import casadi as ca

    m = len(read)
    whole = kind.sym("whole", 1 + m + max(size, 1))
    x = whole[1 + m :]

    def given(group: tuple[str, ...]) -> Any:
        if group == ("state",):
            return x
        return ca.vertcat(*(whole[0 if name == "t" else 1 + read.index(name)] for name in group))

    arguments = [given(group) for group in meant.values()]
    shaped = [ca.reshape(each, *function.size_in(i)) for i, each in enumerate(arguments)]
    answers = function.call(shaped, True, False) if kind is ca.SX else function.call(shaped)
    names = [function.name_out(i) for i in range(function.n_out())]
    parts = {name: ca.vec(ca.densify(answer)) for name, answer in zip(names, answers, strict=True)}
    apart = "cc" in parts and "cg" in parts
    command = ca.vertcat(parts.pop("cc"), parts.pop("cg")) if apart else parts.pop(names[0])
    if command.numel() == 2 + size and size and not parts:
        command, new = command[:2], command[2:]
    else:
        # a state that stood still would be a multiplier of 1 in the loop: without one it is set anew at each sample
        forgotten = size > 0 and not parts
        new = parts.pop(next(iter(parts))) if size and parts else kind.zeros(0 if forgotten else max(size, 1))
    if command.numel() != 2 or parts or new.numel() != max(size, 1):
        raise InputError(SOURCE, ", ".join(names), "is not what a law answers", OUTPUTS)
    return ca.Function("law", [whole], [ca.vertcat(command, new)])


def _instructions(flat: Any) -> tuple[tuple[float, ...], float]:
    """Instructions of a function of scalars, and how many places they work on.

    Raises
    ------
    NotImplementedError
        For an operation that is not known.
    """
    import casadi as ca

    known = {getattr(ca, f"OP_{name}"): float(code) for code, name in enumerate(OPERATIONS)}
    tape: list[float] = []
    for k in range(flat.n_instructions()):
        code, into, given = flat.instruction_id(k), flat.instruction_output(k), flat.instruction_input(k)
        if code == ca.OP_CONST:
            tape += [CONSTANT, into[0], flat.instruction_constant(k), 0.0]
        elif code == ca.OP_INPUT:
            tape += [INPUT, into[0], given[1], 0.0]
        elif code == ca.OP_OUTPUT:
            tape += [OUTPUT, into[1], given[0], 0.0]
        elif code in known:
            tape += [known[code], into[0], given[0], given[-1]]
        else:
            raise NotImplementedError(code)
    return tuple(float(number) for number in tape), float(flat.sz_w())
