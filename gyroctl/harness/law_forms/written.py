"""A law out of a function of Python: it gets what its arguments are named for, and is compiled where numba can.

The law is a NamedTuple of a class made for the function, whose `step` calls it: so the harness compiles, times and
differentiates it as any law that was written out. The class bears the content of the function in its name, by which
laws are told apart; where the content cannot be told, nothing is stored.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from numba.extending import register_jitable

from gyroctl.errors import NOT_GIVEN, InputError, visible
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.harness.law_forms.signals import DERIVED, SIGNALS, channels_of, signal
from gyroctl.plant.ingredients import Untold, ingredients
from gyroctl.plant.measurement import CHANNELS

STEP = """
def step(self, t, y, state):
    {answer}
    command = min(max(command[0], 0.0), self.cc_max), min(max(command[1], 0.0), self.cg_max)
    return command, new
"""

WHOLE = ("t", "y", "state")
"""Arguments that are no signals: time [s], the measurement, the state."""

MEND = f"Name its arguments t, y, state, or after what they read: {', '.join(SIGNALS)}"


class Numbers(NamedTuple):
    """Numbers of such a law."""

    first: Any  # state before the first sample
    cc_max: float  # [Nms]
    cg_max: float  # [Nms]
    N: float  # gear ratio [-]
    period: float  # [s]


def written(function: Callable[..., Any], numbers: Numbers, given: tuple[str, ...] | None = None) -> Any:
    """Make a law of a function.

    Parameters
    ----------
    function : callable
        Of arguments named t, y, state or after signals; it returns (cc, cg), with a state ((cc, cg), new state).
    numbers : Numbers
        State before the first sample, limits, gear ratio, period.
    given : tuple of str, optional
        Channels that it reads, where it takes the whole measurement and does not read all.

    Raises
    ------
    InputError
        Field ``law_from.source``: arguments of other names, or a state that is taken and not given.
    """
    arguments = arguments_of(function)
    stateful = "state" in arguments
    if stateful and numbers.first == ():
        mend = "Give init= a tuple of floats, the state before the first sample"
        raise InputError(
            "law_from.init", NOT_GIVEN, "the function takes a state, and there is none to begin with", mend
        )
    if not stateful and numbers.first != ():
        mend = "Leave init out, or let the function take an argument state and return ((cc, cg), state)"
        raise InputError("law_from.init", numbers.first, "the function takes no state", mend)
    return _class(function, arguments, given)(*numbers)


def arguments_of(function: Callable[..., Any]) -> tuple[str, ...]:
    """Names of the arguments, each of them known.

    Raises
    ------
    InputError
        Field ``law_from.source``.
    """
    name = str(getattr(function, "__name__", type(function).__name__))
    try:
        found = inspect.signature(function).parameters.values()
    except (TypeError, ValueError) as error:
        raise InputError("law_from.source", name, "does not tell its arguments", MEND) from error
    plain = [p for p in found if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) and p.default is p.empty]
    others = [p for p in found if p.kind is p.KEYWORD_ONLY and p.default is p.empty]
    names = tuple(p.name for p in plain)
    if len(names) == 1 and names[0] not in (*WHOLE, *SIGNALS):
        return ("y",)
    strange = [each for each in (*names, *(p.name for p in others)) if each not in (*WHOLE, *SIGNALS)]
    if strange or others:
        raise InputError("law_from.source", strange[0] if strange else name, "is no argument that a law can give", MEND)
    return names


@lru_cache(maxsize=256)
def _class(function: Callable[..., Any], arguments: tuple[str, ...], given: tuple[str, ...] | None) -> type[Any]:
    """Class of the laws of a function: its own in the module of the function, as if it were written there."""
    read = channels_of(tuple(name for name in arguments if name in SIGNALS))
    if "y" in arguments:
        read = CHANNELS if given is None else given
    name = str(getattr(function, "__name__", type(function).__name__))
    title = "".join(sign if sign.isalnum() else "_" for sign in visible(name)).strip("_") or "function"
    plain = {**{each: f"y.{each}" for each in CHANNELS}, **{each: each for each in WHOLE}}
    derived = {each: f"signal({float(SIGNALS.index(each))}, y, self.N)" for each in DERIVED}
    call = f"function({', '.join({**plain, **derived}[each] for each in arguments)})"
    answer = f"command, new = {call}" if "state" in arguments else f"command, new = {call}, state"
    module = str(getattr(function, "__module__", "") or "__main__")
    as_python = {"error_model": "python", "boundscheck": True}  # what Python refuses is refused compiled as well
    callee = register_jitable(**as_python)(function) if inspect.isfunction(function) else function
    scope: dict[str, Any] = {"function": callee, "signal": signal, "__name__": module}
    exec(compile(STEP.format(answer=answer), f"<law from {title}>", "exec"), scope)
    content = _content(function)

    class Written(NamedTuple):
        """A function between sensors and controls."""

        first: Any
        cc_max: float
        cg_max: float
        N: float
        period: float

    members: dict[str, Any] = {
        "information": property(lambda self: "sensors" if read else "none"),
        "sensors": property(lambda self: read),
        "init": lambda self: self.first,
        "step": scope["step"],
        "function": staticmethod(function),  # its file is the law's
        "untold": content is None,
        "called": title,
        "__reduce__": lambda self: (written, (function, Numbers(*self), given)),
        "__module__": module,
        "__doc__": inspect.getdoc(function) or f"The function {title} as a law.",
        "__qualname__": f"Written.{title}.{content or 'untold'}.{'.'.join(arguments)}",
    }
    for key, value in members.items():
        setattr(Written, key, value)
    Written.__name__ = title
    return shown(law_face)(Written)


def _content(function: Callable[..., Any]) -> str | None:
    """Hash of a function with all that it reads; None where that cannot be told."""
    try:
        text = ingredients(function) if inspect.isfunction(function) else None
    except Untold:
        return None
    return hashlib.sha256(text.encode()).hexdigest()[:32] if text else None
