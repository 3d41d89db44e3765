"""The whole sample as machine code, which the loop calls without the interpreter: runs go on threads of one process.

Parts are compiled apart and found by their addresses: the planner, the two functions of its model, and what learns the
sea. So each is compiled once, beside the others, and the sample that holds them together is short.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

from numba import types

from gyroctl.controllers.nmpc import by_address, flat, foresight, power_command, sample, stopwatch
from gyroctl.controllers.nmpc.by_address import ROW, function_of
from gyroctl.controllers.nmpc.kept_code import kept_function
from gyroctl.controllers.nmpc.planner import PLAN
from gyroctl.controllers.nmpc.sample import Constants, Memory
from gyroctl.plant import measurement
from gyroctl.plant.compiled import source_stamp
from gyroctl.waves.estimation import learning, observer, predictor

plan_at = function_of(PLAN)
learn_at = function_of(types.void(ROW, ROW))
entry_at = function_of(types.void(types.float64, ROW, ROW, ROW, ROW))

SOURCES = (
    *observer.SOURCES,
    *predictor.SOURCES,
    *(part.__file__ for part in (by_address, flat, foresight, power_command, sample, stopwatch, measurement)),
    __file__,
)

OPENING = """from math import isfinite

import numpy as np
from numba import cfunc, float64, void
{imports}

STAMP = {stamp!r}


@cfunc(void({types}), cache=True, error_model='numpy')
def {name}({arguments}):
    whole, numbers = p[1 : 1 + int(p[0])].view(np.int64), p[1 + int(p[0]) :]
    counts, values = s[1 : 1 + int(s[0])].view(np.int64), s[1 + int(s[0]) :]
"""

SAMPLE = """
    c = {constants}
    w = {memory}
    plan, step, slope, learn, clock = c.addresses
    room = np.zeros(2, np.int64)
    begin = seconds(clock, room)
    observed(c, w, y)
    if saw(c, w):
        learn_at(learn)(p, s)
    foreseen(c, w)
    powered(c, w)
    more, status = posed(c, w), GOOD
    if more >= 0:
        plan_at(plan)(
            step, slope, w.start, w.moments, w.now, w.weights, c.h, c.k, w.trial, w.other, w.result, c.iterations, more
        )
        if not isfinite(w.result[0]):
            status = FAILED
    if acted(c, w, status, u):
        fell_back(w, c.fallback[0], c.fallback[1], u)
    note(seconds(clock, room) - begin, w.spent)
"""

LEARN = """
    learn({learner}, {memory})
"""


class Texts(NamedTuple):
    """Texts of constants and memory, and the types that they name."""

    constants: Any
    memory: Any
    types: dict[str, Any]


def texts_of(constants: Constants, memory: Memory) -> Texts:
    """Write down how both are built from their rows."""
    kinds: dict[str, Any] = {}
    return Texts(
        flat.text_of(constants, "whole", "numbers", kinds), flat.text_of(memory, "counts", "values", kinds), kinds
    )


def sample_of(texts: Texts) -> Any:
    """Compile ``entry(t, y, p, s, u)``; it is kept on disk and serves all laws whose constants are nested alike."""
    text = SAMPLE.format(constants=flat.joined(texts.constants), memory=flat.joined(texts.memory))
    names = ("observed", "saw", "foreseen", "powered", "posed", "acted", "fell_back", "GOOD", "FAILED")
    return _kept("entry", text, _imports(texts.types) + _lines(sample, names) + ENTRY_IMPORTS, True)


def learn_of(texts: Texts) -> Any:
    """Compile ``learn(p, s)``: the fit of the spectrum, which is rare and long to compile."""
    learner, memory = texts.constants.predictor.learner, texts.memory.forecast.memory
    text = LEARN.format(learner=flat.joined(learner), memory=flat.joined(memory))
    kinds = {kind: texts.types[kind] for kind in (type(learner).__name__, type(memory).__name__)}
    return _kept("learn_flat", text, [*_imports(kinds), f"from {learning.__name__} import learn"], False)


ENTRY_IMPORTS = [f"from {stopwatch.__name__} import note, seconds", f"from {__name__} import learn_at, plan_at"]


def _lines(module: Any, names: Any) -> list[str]:
    return [f"from {module.__name__} import {', '.join(names)}"]


def _imports(kinds: dict[str, Any]) -> list[str]:
    return [f"from {kind.__module__} import {name}" for name, kind in sorted(kinds.items())]


@lru_cache(maxsize=1)
def _stamp() -> str:
    return source_stamp([str(source) for source in SOURCES])


def _kept(name: str, body: str, imports: list[str], timed: bool) -> Any:
    arguments = ["t", "y", "p", "s", "u"] if timed else ["p", "s"]
    kinds = ["float64" if argument == "t" else "float64[::1]" for argument in arguments]
    opening = OPENING.format(
        imports="\n".join(imports), stamp=_stamp(), types=", ".join(kinds), name=name, arguments=", ".join(arguments)
    )
    return kept_function(name, opening + body.lstrip("\n"))
