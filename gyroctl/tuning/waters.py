"""The waters in which laws are tuned: the linear sea with an ideal contact, and real water."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.registry import REAL
from gyroctl.harness.run import Settings
from gyroctl.plant import Plant
from gyroctl.tables import table_of

LINEAR = "linear"

LAG = 0.02
"""With which the coupling follows its command in real water. [s]"""


@dataclass(frozen=True)
class Circumstances:
    """On what a law is tuned.

    Parameters
    ----------
    plant : Plant
        The device.
    settings : Settings
        Steps of the confirming runs, sensors, actuators.
    evaluation : frozenset of int
        Seeds of an experiment that must not be tuned on, beside those that the ledger keeps for judging.
    own : bool
        Whether the plant is a device of one's own: laws are then built for it, see `gyroctl.harness.for_device`.
    """

    plant: Plant
    settings: Settings = field(default_factory=Settings)
    evaluation: frozenset[int] = frozenset()
    own: bool = False

    @property
    def device(self) -> Plant | None:
        """The device that laws are built for, where it is one of one's own."""
        return self.plant if self.own else None


def _real() -> Circumstances:
    """The realistic device, its wetted surface as polynomials: the panels, which take longer, are left to judge."""
    return Circumstances(zhang2017("realistic", wetted="reduced"), Settings(actuators=Actuators(cc_lag=LAG)))


WATERS: Mapping[str, Callable[[], Circumstances]] = {LINEAR: lambda: Circumstances(zhang2017()), REAL: _real}
"""Device, sensors and actuators of each."""

TABLES: Mapping[str, Mapping[str, Any]] = {
    LINEAR: {},
    # A float that surges with the waves swings farther, whatever the law, and constant pairs keep fewer turns: what is
    # asked for is about what they do. The contact is stiff, so that a longer step is none.
    REAL: {"search": {"dt": 0.01}, "goal": {"motion": 0.46, "turns": 0.945, "forward": 0.95}},
}
"""What a task asks for there if it does not say otherwise."""


def circumstances_of(water: str) -> Circumstances:
    """Circumstances of a water.

    Raises
    ------
    InputError
        For an unknown name.
    """
    if water not in WATERS:
        raise InputError("--water", water, "unknown water", f"Choose one of {', '.join(WATERS)}")
    return WATERS[water]()


def on_device(plant: Plant, water: str) -> Circumstances:
    """Circumstances of a device of one's own, in the units of its length: a panelled surface becomes polynomials.

    Raises
    ------
    InputError
        For an unknown water.
    """
    if water not in WATERS:
        raise InputError("--water", water, "unknown water", f"Choose one of {', '.join(WATERS)}")
    if plant.parameters.wetted == "surface":
        plant = plant.replace(wetted="reduced", name=plant.name)
    actuators = Actuators(cc_lag=LAG if water == REAL else 0.0)
    return Circumstances(plant, Settings(actuators=actuators).at(plant.parameters.length_scale), own=True)


def in_water(tables: Mapping[str, Any], water: str) -> dict[str, Any]:
    """Return the tables of a task as they are meant in a water: what stands below its name goes before the rest."""
    own = {key: value for key, value in tables.items() if key not in WATERS}
    return _laid(_laid(own, TABLES[water]), table_of(tables, water))


def _laid(under: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Lay tables over others, knob by knob and entry by entry."""
    found = dict(under)
    for key, value in over.items():
        both = isinstance(value, Mapping) and isinstance(found.get(key), Mapping)
        found[key] = _laid(found[key], value) if both else value
    return found
