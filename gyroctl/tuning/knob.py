"""A parameter that a search varies, and its coordinate in the search."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.tables import check_known, checked_table, names_of, number
from gyroctl.waves.checks import within

LARGEST_KNOB = 1e6
"""Size beyond which neither a start nor a change of a parameter is meant."""


@dataclass(frozen=True)
class Knob:
    """A parameter and the coordinate x of its search: start * exp(width x), or start + width x.

    Parameters
    ----------
    name : str
        Parameter of the law.
    start : float
        Where the search begins.
    width : float
        A large change: of the logarithm, or of the value itself.
    scale : {"log", "linear"}
        Which of the two.
    least, most : float
        Bounds; what lies beyond is set to them.
    """

    name: str
    start: float
    width: float
    scale: str = "log"
    least: float = -math.inf
    most: float = math.inf

    def value(self, x: float) -> float:
        """Return the value at coordinate `x`, to four digits: what ships is what was run."""
        value = self.start * math.exp(self.width * x) if self.scale == "log" else self.start + self.width * x
        return float(f"{min(max(value, self.least), self.most):.4g}")

    def coordinate(self, value: float) -> float:
        """Coordinate of a value."""
        far = math.log(value / self.start) if self.scale == "log" else value - self.start
        return far / self.width

    def beginning(self, start: float) -> Knob:
        """Return the knob with another start."""
        if self.scale == "log" and start <= 0.0:
            return self
        return replace(self, start=min(max(start, self.least), self.most))


def knob_of(path: str, name: str, given: Any) -> Knob:
    """Build a knob from its entry, whose name in errors is `path`.

    Raises
    ------
    InputError
        For an unknown or missing entry, or a value out of range.
    """
    entry = checked_table(path, given)
    check_known(path, entry, [key for key in names_of(Knob) if key != "name"])
    for key in ("start", "width"):
        if key not in entry:
            raise InputError(f"{path}.{key}", NOT_GIVEN, "is missing", f"Give {key} as a number")
    scale = entry.get("scale", "log")
    if scale not in ("log", "linear"):
        raise InputError(f"{path}.scale", scale, "unknown scale", "Choose log or linear")
    values = {key: number(f"{path}.{key}", value) for key, value in entry.items() if key != "scale"}
    knob = Knob(name, scale=scale, **values)
    for key in ("start", "width"):
        within(f"{path}.{key}", getattr(knob, key), -LARGEST_KNOB, LARGEST_KNOB, "Give it in the unit of the law")
    if knob.width <= 0.0:
        raise InputError(f"{path}.width", knob.width, "must be positive", "Give what would be a large change")
    if scale == "log" and knob.start <= 0.0:
        raise InputError(f"{path}.start", knob.start, "has no logarithm", 'Give a positive start, or scale = "linear"')
    if not knob.least <= knob.start <= knob.most:
        raise InputError(f"{path}.start", knob.start, "is outside least and most", "Put it between them")
    return knob
