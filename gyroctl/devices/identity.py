"""Which device a plant is: what was changed against Table 1, and a hash that tells two devices apart.

Water and friction are no part of a device's identity: the same device stands in the linear water and in the real one.
"""

from __future__ import annotations

import hashlib
import json
import math
from functools import cache
from typing import Any

from gyroctl.devices.entries import ENTRIES, GROUPS
from gyroctl.devices.scaling import scaled_parameters
from gyroctl.devices.zhang import VARIANTS, zhang2017
from gyroctl.hydrodynamics import excitation_table, shipped
from gyroctl.hydrodynamics.scaling import scaled
from gyroctl.plant import Parameters, Plant

OF_WATER = ("The float in the water", "Contact, coupling, losses", "Form of the equations")
"""Groups of entries that do not tell one device from another, the connection of the flywheel aside."""

OWN = ("connection", *(name for group, own in GROUPS.items() if group not in OF_WATER for name in own))
"""Entries by which a device is known."""

ROUNDING = 1e-9
"""Relative difference that no change of a number makes."""


def identity(plant: Plant) -> str:
    """SHA-256 of the device: its dimensions, masses, stiffness and hydrodynamics, whatever the water."""
    own = {name: _exact(getattr(plant.parameters, name)) for name in OWN}
    table = [plant.excitation.sha256, float(plant.depth).hex()]
    return hashlib.sha256(json.dumps([own, table], sort_keys=True).encode()).hexdigest()


def is_shipped(plant: Plant) -> bool:
    """Whether a plant is the device of the paper, in whichever variant."""
    return identity(plant) in _shipped()


@cache
def _shipped() -> frozenset[str]:
    return frozenset(identity(zhang2017(variant)) for variant in VARIANTS)


def table_1(length: float) -> Parameters:
    """Table 1 for a device that is `length` times as long as the paper's."""
    return Parameters() if length == 1.0 else scaled_parameters(Parameters(), length)


def changed(plant: Plant, first: Parameters | None = None, within: float = ROUNDING) -> dict[str, tuple[Any, Any]]:
    """Entries that are not those of Table 1 at the plant's own length, or of `first`: by name, both values.

    A number has to differ by more than the part `within`.
    """
    own, first = plant.parameters, first or table_1(plant.parameters.length_scale)
    pairs = {name: (getattr(first, name), getattr(own, name)) for name in ENTRIES if name != "length_scale"}
    return {name: pair for name, pair in pairs.items() if not _alike(*pair, within)}


def other_hydrodynamics(plant: Plant) -> bool:
    """Whether the moments of the waves are not those of the shipped table, at the plant's own length."""
    length = plant.parameters.length_scale
    table = shipped() if length == 1.0 else scaled(shipped(), length)
    phase: Any = getattr(plant.excitation, "phase", "complex")
    return bool(plant.excitation.sha256 != excitation_table(table, phase=phase).sha256)


def device_record(plant: Plant) -> dict[str, Any]:
    """What a result says of its device, for JSON: name, hash, length, changes against Table 1, hydrodynamics."""
    units = {name: ENTRIES[name].unit for name in ENTRIES}
    rows = {
        name: {"table_1": before, "device": now, "unit": units[name]} for name, (before, now) in changed(plant).items()
    }
    return {
        "name": plant.name,
        "sha256": identity(plant),
        "length_scale": plant.parameters.length_scale,
        "changed": rows,
        "hydrodynamics": "own" if other_hydrodynamics(plant) else "shipped",
        "hydrodynamics_sha256": plant.excitation.sha256,
        "depth_m": plant.depth if math.isfinite(plant.depth) else None,
    }


def changes_in_words(
    plant: Plant, most: int = 6, first: Parameters | None = None, within: float = ROUNDING
) -> list[str]:
    """What was changed against Table 1, or `first`, see `changed`: length, number by number, hydrodynamics."""
    length = plant.parameters.length_scale
    words = [] if length == 1.0 else [f"{length:g} times the length of Table 1"]
    found = changed(plant, first, within)
    numbers = [f"{name} = {_word(now)} ({_word(before)})" for name, (before, now) in found.items()]
    words += numbers if len(numbers) <= most else [*numbers[:most], f"and {len(numbers) - most} more"]
    return [*words, "own hydrodynamics"] if other_hydrodynamics(plant) else words


def _alike(before: Any, now: Any, within: float = ROUNDING) -> bool:
    if isinstance(before, str | bool) or isinstance(now, str | bool):
        return bool(before == now)
    if isinstance(before, tuple):
        return all(_alike(a, b, within) for a, b in zip(before, now, strict=True))
    return math.isclose(before, now, rel_tol=within, abs_tol=0.0)


def _exact(value: Any) -> str:
    return value if isinstance(value, str) else float(value).hex()


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, tuple):
        return "/".join(f"{v:.5g}" for v in value)
    return f"{value:.5g}" if isinstance(value, float | int) else str(value)
