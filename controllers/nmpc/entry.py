"""The whole sample as machine code, which the loop calls without the interpreter: runs go on threads of one process.

Parts are compiled apart and found by their addresses: the planner, the two functions of its model, and what learns the
sea. So each is compiled once, beside the others, and the sample that holds them together is short.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

from numba import types

from gyroctl.controllers.nmpc import by_address, flat, foresight, power_command, sample, stopwatch, views
from gyroctl.controllers.nmpc.by_address import ROW, function_of
from gyroctl.controllers.nmpc.kept_code import kept_function
from gyroctl.controllers.nmpc.planner import PLAN
from gyroctl.controllers.nmpc.sample import Constants, Memory
from gyroctl.plant import equations, measurement
from gyroctl.plant.compiled import source_stamp
from gyroctl.waves.estimation import learning, observer, predictor

plan_at = function_of(PLAN)
learn_at = function_of(types.void(ROW, ROW))
entry_at = function_of(types.void(types.float64, ROW, ROW, ROW, ROW))

SOURCES = (
    *observer.SOURCES,
    *predictor.SOURCES,
    *(part.__file__ for part in (by_address, flat, foresight, power_command, sample, stopwatch, views, measurement)),
    __file__,
)

OPENING = """from math import isfinite

import numpy as np
from numba import float64, void

from gyroctl.controllers.nmpc.views import view
{imports}

STAMP = {stamp!r}


@kept(void({types}))
def {name}({arguments}):
    many, some = int(p[0]), int(s[0])
    whole, numbers = p[1 : 1 + many].view(np.int64), view(p, 1 + many, (p.size - 1 - many,))
    counts, values = s[1 : 1 + some].view(np.int64), view(s, 1 + some, (s.size - 1 - some,))
"""

SAMPLE = """
    estimate, forecast, w, law = {estimate}, {forecast}, {work}, {law}
    plan, step, slope, beside, learn, clock = law.addresses
    room = np.zeros(2, np.int64)
    begin = seconds(clock, room)
    observed({estimator}, estimate, law, w, y)
    look_to_then({estimator}, estimate)
    speed = estimate.then[OMEGA_RATE]
    ahead, moments, predictor = {ahead}, {moments}, {predictor}
    if take(predictor, forecast, estimate.me_hat[0], estimate.me_hat[1], placed(estimate)):
        learn_at(learn)(p, s)
    predict(predictor, forecast, ahead)
    between(forecast.now, ahead, law.period, moments)
    powered(law, w, speed)
    doubted(law, w, forecast.placed.spread)
    more, status = posed(law, w, estimate.then), GOOD
    if more >= 0:
        plan_at(plan)(
            step, slope, beside, w.start, acted_on(law, ahead, moments), w.now, w.weights, law.h, law.k, w.trial,
            w.rivals, w.result, law.iterations, more, law.varied, law.newton,
        )
        if not isfinite(w.result[0]):
            status = FAILED
    if acted(law, w, speed, seen_ring(estimate, y), estimate.held[0], status, u):
        fell_back(w, law.fallback[0], law.fallback[1], u)
    note(seconds(clock, room) - begin, {spent})
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
    groups = {**texts.constants._asdict(), **texts.memory._asdict()}
    text = SAMPLE.format(**{name: flat.joined(group) for name, group in groups.items()})
    kinds = {name: kind for name, kind in texts.types.items() if kind not in (Constants, Memory)}
    return _kept("entry", text, [*_imports(kinds), *PARTS], True)


def learn_of(texts: Texts) -> Any:
    """Compile ``learn(p, s)``: the fit of the spectrum, which is rare and long to compile."""
    learner, memory = texts.constants.predictor.learner, texts.memory.forecast.memory
    text = LEARN.format(learner=flat.joined(learner), memory=flat.joined(memory))
    kinds = {kind: texts.types[kind] for kind in (type(learner).__name__, type(memory).__name__)}
    return _kept("learn_flat", text, [*_imports(kinds), f"from {learning.__name__} import learn"], False)


PARTS = [
    f"from {__name__} import learn_at, plan_at",
    f"from {foresight.__name__} import between",
    f"from {sample.__name__} import FAILED, GOOD, acted, acted_on, doubted, fell_back",
    f"from {sample.__name__} import observed, placed, posed, powered, seen_ring",
    f"from {stopwatch.__name__} import note, seconds",
    f"from {equations.__name__} import OMEGA_RATE",
    f"from {observer.__name__} import look_to_then",
    f"from {predictor.__name__} import predict, take",
]


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
