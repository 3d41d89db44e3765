"""Who takes part: laws by name with their parameters, and of what kind they are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from gyroctl.errors import InputError
from gyroctl.harness.code_files import is_file
from gyroctl.harness.plausibility import check_parts
from gyroctl.harness.protocol import Law, innermost
from gyroctl.harness.registry import REAL, build, registered, tuned_sets
from gyroctl.harness.sight import sight
from gyroctl.names import text_of
from gyroctl.reports.layout import REFERENCE

Kind = Literal["constant", "simple", "planning"]

ALL = "all"
"""Name of the one set of parameters for all seas, the default of every law."""


LONGEST_LIST = 20_000
"""Characters of a list of laws that is typed."""


@dataclass(frozen=True)
class Entrant:
    """A law as it takes part."""

    label: str  # name in the tables
    name: str  # registered name, or "file.py:Name"
    parameters: Mapping[str, Any] = field(default_factory=dict)  # what differs from its defaults
    tuning: str = ALL  # set of tuned parameters: "all", or one for a sea alone
    allow_code: tuple[Path, ...] = ()  # files that may run where a tuned set names a law in them

    def build(self) -> Law:
        """Build the law anew: a law that was run may keep what it has worked out, and would be stored as another."""
        tuning = None if self.tuning == ALL else self.tuning
        return build(self.name, self.parameters, tuning, self.allow_code)


def reference(gamma: float = 5.0) -> Entrant:
    """Best constant pair of the sea of that peak enhancement, as it ships."""
    return Entrant(REFERENCE, REFERENCE, {"gamma": gamma})


def pair(cc: float, cg: float) -> Entrant:
    """Take a constant pair as the reference."""
    return Entrant(REFERENCE, "constant", {"cc": cc, "cg": cg})


def parse(text: str) -> list[Entrant]:
    """Read laws as they are given on the command line: ``load_angle,nmpc[information=oracle,horizon=8]``.

    ``tuning`` among the parameters chooses a set of tuned ones.

    Raises
    ------
    InputError
        Field ``laws``: brackets that do not match, or a parameter without a value.
    """
    text_of("laws", text, longest=LONGEST_LIST)
    found, depth, start = [], 0, 0
    for i, sign in enumerate(text + ","):
        depth += (sign == "[") - (sign == "]")
        if sign == "," and depth == 0:
            if text[start:i].strip():
                found.append(_one(text[start:i].strip()))
            start = i + 1
    if depth != 0 or not found:
        raise InputError("laws", text, "is no list of laws", "Give names, for example load_angle,nmpc[horizon=8]")
    return found


def default_entrants() -> list[Entrant]:
    """Every registered law but the reference, which always takes part, with its default parameters."""
    return [Entrant(name, name) for name in registered() if name != REFERENCE]


def with_sets(entrants: Iterable[Entrant], sea: str) -> list[Entrant]:
    """Add to each law with default parameters the set that was tuned for `sea` ("gamma5") alone, where there is one."""
    found = []
    for entrant in entrants:
        found.append(entrant)
        plain = entrant.tuning == ALL and not is_file(entrant.name)
        if plain and entrant.name != "constant" and sea in tuned_sets(entrant.name):  # that set is best_constant
            found.append(replace(entrant, label=f"{entrant.label} ({sea})", tuning=sea))
    return found


def in_real_water(entrants: Iterable[Entrant], sea: str) -> list[Entrant]:
    """Laws as they take part in real water: with the set that they have for it, unless another one was asked for."""
    found = []
    for entrant in entrants:
        free = entrant.tuning == ALL and entrant.name != "constant"  # whose sets there are the best pairs
        found.append(
            replace(entrant, tuning=real_set(tuned_sets(entrant.name, entrant.allow_code), sea)) if free else entrant
        )
    return found


def real_set(sets: Collection[str], sea: str) -> str:
    """Of the tuned sets of a law the one for real water: for all seas, or for `sea` ("gamma5"), or for another sea.

    A law that was never tuned there keeps the set for all seas of the linear plant.
    """
    wanted = (REAL, f"{REAL}-{sea}", *sorted(name for name in sets if name.startswith(f"{REAL}-")))
    return next((name for name in wanted if name in sets), ALL)


def set_in_words(tuning: str, sea: str) -> str:
    """Say which set a law has in real water, and for what it was tuned."""
    if tuning == REAL:
        return f"{REAL}: all seas"
    if tuning.startswith(f"{REAL}-"):
        whose = tuning.removeprefix(f"{REAL}-")
        return f"{tuning}: {'this sea alone' if whose == sea else f'{whose} alone, not this sea'}"
    return f"{tuning}: not tuned in real water"


def kind(built: Law) -> Kind:
    """Whether a law is constant, simple (rules or tables on the sensors) or plans ahead."""
    built = innermost(built)
    level = sight(built).level
    if level == "none":
        return "constant"
    planning = ".nmpc" in type(built).__module__ or level in ("gauge", "forecast", "oracle")
    return "planning" if planning else "simple"


def _one(text: str) -> Entrant:
    name, bracket, inside = text.partition("[")
    if not bracket:
        return Entrant(text, text)
    if not inside.endswith("]") or not name:
        raise InputError("laws", text, "is no law", "Give its parameters in brackets: nmpc[information=oracle]")
    parameters: dict[str, Any] = {}
    for item in inside[:-1].split(","):
        key, equals, value = item.partition("=")
        if not equals or not key.strip() or not value.strip():
            problem = f"{item.strip() or 'nothing'} is no parameter with its value"
            raise InputError("laws", text, problem, "Write key=value between the brackets")
        parameters[key.strip()] = _value(value.strip())
    check_parts(name, parameters)
    tuning = str(parameters.pop("tuning", ALL))
    return Entrant(text, name, parameters, tuning)


def _value(text: str) -> Any:
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return text
