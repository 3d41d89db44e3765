"""What differs between two plants, in the words that make the name of the one that was changed."""

from __future__ import annotations

import dataclasses
from typing import Any, Protocol

from gyroctl.plant.parameters import Parameters


class Device(Protocol):
    """What is compared: a plant."""

    @property
    def parameters(self) -> Parameters: ...  # noqa: D102

    @property
    def radiation(self) -> Any: ...  # noqa: D102

    @property
    def excitation(self) -> Any: ...  # noqa: D102

    @property
    def depth(self) -> float: ...  # noqa: D102


NAMED = 6
"""Changes that the name of a plant tells one by one."""


def differences(plant: Device, origin: Device) -> list[str]:
    """What differs between two plants, in words: numbers by name, and what is no number by its name alone."""
    pairs = [(f.name, plant.parameters, origin.parameters) for f in dataclasses.fields(plant.parameters)]
    values = [(name, getattr(mine, name), getattr(first, name)) for name, mine, first in pairs]
    words = [f"{name} = {_in_words(mine)}" for name, mine, first in values if mine != first]
    if plant.depth != origin.depth:
        words.append(f"depth = {plant.depth:g}")
    if plant.radiation != origin.radiation:
        words.append("other radiation")
    if plant.excitation.sha256 != origin.excitation.sha256:
        words.append("other excitation")
    return words if len(words) <= NAMED else [*words[:NAMED], f"and {len(words) - NAMED} more"]


def _in_words(value: object) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.6g}" if isinstance(value, float | int) else str(value)
