"""Every public name of the package, in the order of the flow: what the reference shows and what its tests walk.

Public is what a room exports: ``__all__`` of ``gyroctl`` and of the packages below it. Where a name was written, which
may be a file further down, is read from the imports of the room.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any

import gyroctl

FLOW: dict[str, tuple[str, ...]] = {
    "Device": ("zhang2017", "device", "Plant", "Parameters", "Radiation"),
    "Seas": ("SeaState", "Regular", "Bichromatic", "TabulatedSpectrum", "ElevationRecord"),
    "Seas from files": ("read_spectrum", "read_record"),
    "Waves": ("realise", "WaveRealisation"),
    "Lock": ("lock_orbit", "PeriodicOrbit", "margins"),
    "Laws": ("law", "law_from", "check_law", "Law", "Measurement", "Sensors", "Channel", "Actuators"),
    "Runs": ("simulate", "Settings", "scan"),
    "Comparison": ("compare", "find_yardstick", "Yardstick"),
    "Errors": ("InputError", "LawError"),
}
"""Names of ``gyroctl`` by what they are for, along the flow; `groups` puts what is not named here at the end."""

ROOMS: tuple[str, ...] = (
    "devices",
    "plant",
    "hydrodynamics",
    "waves",
    "waves.estimation",
    "orbits",
    "linearisation",
    "simulation",
    "statistics",
    "controllers.rule_based",
    "controllers.gain_scheduled",
    "controllers.nmpc",
    "controllers.supervisor",
    "reports",
    "engine",
    "fingerprint",
    "studies.paper",
    "studies.margins",
    "studies.bound",
    "studies.evaluation",
    "studies.site",
    "studies.startup",
    "studies.forecast",
    "studies.device",
    "studies.connection",
)
"""Rooms with a face of their own, in the order of the flow; `rooms` finds them, and a test compares."""

NO_LIBRARY = ("cli",)
"""Rooms whose names are called by the command line, not by a user."""


@dataclass(frozen=True)
class Name:
    """A public name.

    Parameters
    ----------
    room : str
        Module that exports it, as it is imported: ``gyroctl.waves``.
    name : str
        The name there.
    home : str
        Module in which it is written.
    """

    room: str
    name: str
    home: str

    @property
    def thing(self) -> Any:
        """What it stands for."""
        return getattr(importlib.import_module(self.room), self.name)

    @property
    def key(self) -> tuple[str, str]:
        """Where it is written and how it is called there."""
        return self.home, self.thing.__name__ if isinstance(self.thing, type | FunctionType) else self.name

    @property
    def path(self) -> str:
        """How it is imported."""
        return f"{self.room}.{self.name}"

    @property
    def constant(self) -> bool:
        """Whether it is a value rather than a class or a function."""
        return not callable(self.thing) or isinstance(self.thing, dict | tuple)

    @property
    def filled(self) -> bool:
        """Whether it is a function with some of its arguments filled in."""
        return isinstance(self.thing, partial)


def rooms() -> list[str]:
    """Packages below ``gyroctl`` that say what they export."""
    found = []
    for info in pkgutil.walk_packages(gyroctl.__path__, "gyroctl."):
        if info.ispkg and getattr(importlib.import_module(info.name), "__all__", None):
            found.append(info.name.removeprefix("gyroctl."))
    return sorted(set(found) - set(NO_LIBRARY))


def names_of(room: str) -> list[Name]:
    """Public names of a room, which is "" for the package itself."""
    module = f"gyroctl.{room}".rstrip(".")
    exported = importlib.import_module(module).__all__
    return [Name(module, name, home_of(module, name)) for name in sorted(exported, key=str.lower)]


def groups() -> dict[str, list[Name]]:
    """Names of ``gyroctl`` by what they are for."""
    known = {each.name: each for each in names_of("")}
    placed = {title: [known.pop(name) for name in names if name in known] for title, names in FLOW.items()}
    return {**placed, **({"More": list(known.values())} if known else {})}


def all_names() -> Iterator[Name]:
    """Every public name once: where several rooms export it, as the first of them does."""
    yield from first_named().values()


@cache
def first_named() -> dict[tuple[str, str], Name]:
    """Every public name by where it is written and what it is called there, as the first room of the flow has it."""
    found: dict[tuple[str, str], Name] = {}
    for room in ("", *rooms_in_order()):
        for each in names_of(room):
            found.setdefault(each.key, each)
    return found


def rooms_in_order() -> list[str]:
    """Rooms along the flow, those that `ROOMS` does not know at the end."""
    found = rooms()
    return [*(room for room in ROOMS if room in found), *(room for room in found if room not in ROOMS)]


def home_of(module: str, name: str) -> str:
    """Return the module in which a name is written, by following the imports of `module`."""
    origin = importlib.util.find_spec(module)
    assert origin is not None and origin.origin is not None
    file = Path(origin.origin)
    package = module if file.stem == "__init__" else module.rpartition(".")[0]
    stub = file.with_suffix(".pyi")
    tree = ast.parse((stub if stub.is_file() else file).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and any((each.asname or each.name) == name for each in node.names):
            source = (next(each.name for each in node.names if (each.asname or each.name) == name)) or name
            above = package.split(".")[: len(package.split(".")) - (node.level - 1)] if node.level else []
            target = ".".join([*above, *([node.module] if node.module else [])])
            return home_of(target, source) if target.startswith("gyroctl") else target
    return module
