"""The steps of the table `price`: what the water takes, one effect on top of the other, and what the law changes.

Both ends are those that ship: values of the water are those of the variant "realistic", values of the law those of its
tuned set for real water. Here stands only which of them belong together, and in which order they come.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from gyroctl.devices import VARIANTS
from gyroctl.errors import InputError
from gyroctl.harness.laws import law
from gyroctl.harness.registry import describe, tuned_sets
from gyroctl.plant import Parameters
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.studies.evaluation.real_water import LINEAR, WATERS, Water

VARIANT, REAL = "realistic", "real"
"""Variant of the device and tuned set of the law in which the steps end."""

LAG = WATERS[-1].lag
"""Time constant of the coupling in the realistic case. [s]"""

EFFECTS: Mapping[str, tuple[str, ...]] = {
    "drag of the float": ("drag",),
    "waves act where the float is": ("position",),
    "wetted surface": ("wetted",),
    "contact that may slip": ("contact", "traction"),
    "friction of the bearings": ("bearing",),
    "windage, rolling resistance": ("windage", "rolling_resistance"),
    "torque of the coupling": ("coupling_cap", "coupling_slip"),
}
"""Effects in the order in which they are switched on, with their choices. What the device is given beyond them comes
as a last one, so that the steps always end in the variant. Drag comes first: without it waves that act where the float
is take the lock, and what comes after could not be told."""

REST, LAGGING = "what else is realistic", "coupling that lags"

CHOICES: Mapping[str, tuple[str, ...]] = {
    "design model of the water": ("plant",),
    "rival plans that live on": ("every", "retries", "rivals", "life"),
    "plan is varied first": ("varied",),
    "ring turns fast enough to grip": ("traction", "floor", "lock"),
    "tuned in the water": (),
    "told of the lag": ("lag",),
}
"""Choices of the law in the order in which they are made, with their parameters; the step without any takes all that
the set has beyond those of the others."""

TOLD, TUNED = "told of the lag", "tuned in the water"
ORACLE = "perfect preview"


class Choice(NamedTuple):
    """A law as it takes part: what is new in it, and all that differs from its linear set."""

    name: str  # in words
    new: Mapping[str, Any]  # parameters that this step sets
    parameters: Mapping[str, Any]  # all of them, those of the steps before among them

    def entrant(self, planner: str) -> Entrant:
        """Law of the step; its tuned set is not asked for, every parameter is given."""
        return Entrant(self.name, planner, dict(self.parameters))


def waters(lag: float = LAG, effects: Mapping[str, Sequence[str]] = EFFECTS) -> tuple[Water, ...]:
    """Waters from the linear device to the realistic one with a coupling that lags, each with all of those before."""
    usual, given = {**vars(Parameters()), **VARIANTS["corrected"]}, VARIANTS[VARIANT]
    beyond = [key for key, value in given.items() if usual.get(key) != value]
    named = {key for keys in effects.values() for key in keys}
    groups = {**effects, REST: [key for key in beyond if key not in named]}
    found, choices = [Water(LINEAR, {})], dict[str, Any]()
    for name, keys in groups.items():
        if set(keys) & set(beyond):  # and what belongs to it, though it be the default
            choices |= {key: given[key] for key in keys if key in given}
            found.append(Water(name, dict(choices), single=len(found) == 1))
    return (*found, Water(LAGGING, dict(choices), lag, single=False))


def choices(planner: str, lag: float = LAG, steps: Mapping[str, Sequence[str]] = CHOICES) -> list[Choice]:
    """Laws from the linear design model to the set for real water, told of the lag.

    Raises
    ------
    InputError
        Field ``planner``: it has no set for real water.
    """
    sets = tuned_sets(planner)
    if REAL not in sets:
        mend = f"Tune it: gyroctl tune {planner} --ship, or take nmpc"
        raise InputError("planner", planner, f'has no tuned set "{REAL}"', mend)
    real = {**sets[REAL]["parameters"], "lag": lag}
    named = {key for keys in steps.values() for key in keys}
    groups = {name: list(keys) or [key for key in real if key not in named] for name, keys in steps.items()}
    usual = describe(law(planner))
    # a law that plans with the water takes its set for it, unless each of its parameters is told
    parameters = {key: usual[key] for key in real if key != "plant"}
    found = []
    for name, keys in groups.items():
        new = {key: real[key] for key in keys if key in real and parameters.get(key) != real[key]}
        parameters = {**parameters, **new}
        found.append(Choice(name, new, parameters))
    return found


def previews(last: Choice) -> list[Choice]:
    """Levels of information beyond the sensors, with the law of the last step."""
    told = {"information": "oracle"}
    return [Choice(ORACLE, told, {**last.parameters, **told})]
