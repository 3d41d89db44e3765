"""Where to write the names of points in a plot, so that they cover neither points, nor error bars, nor one another."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple


class Box(NamedTuple):
    """Rectangle in plot coordinates, each axis from 0 to 1."""

    left: float
    right: float
    bottom: float
    top: float

    def overlap(self, other: Box) -> float:
        """Return the common area."""
        width = min(self.right, other.right) - max(self.left, other.left)
        height = min(self.top, other.top) - max(self.bottom, other.bottom)
        return width * height if width > 0.0 and height > 0.0 else 0.0


class Side(NamedTuple):
    """A place beside a point: direction of the text (-1, 0, 1) along each axis."""

    across: int
    up: int

    @property
    def plotly(self) -> str:
        """Name of the side in plotly."""
        return (
            f"{ {-1: 'bottom', 0: 'middle', 1: 'top'}[self.up] } { {-1: 'left', 0: 'center', 1: 'right'}[self.across] }"
        )


SIDES = (Side(0, 1), Side(0, -1), Side(1, 1), Side(-1, 1), Side(1, -1), Side(-1, -1), Side(1, 0), Side(-1, 0))
GAP = 0.022
LETTER, LINE = 0.0115, 0.05


def place(points: Sequence[tuple[float, float]], names: Sequence[str], obstacles: Sequence[Box]) -> list[Side]:
    """Choose a side for each name, greedily and deterministically.

    Parameters
    ----------
    points : sequence of (x, y)
        The points in plot coordinates, each axis from 0 to 1.
    names : sequence of str
        Their names.
    obstacles : sequence of Box
        What else must stay free, such as error bars.

    Returns
    -------
    list of Side
        One a point: the first side of `SIDES` with the least covered area.
    """
    taken = [*obstacles, *(Box(x - 0.012, x + 0.012, y - 0.02, y + 0.02) for x, y in points)]
    plot, chosen = Box(0.0, 1.0, 0.0, 1.0), []
    for (x, y), name in zip(points, names, strict=True):

        def covered(side: Side, x: float = x, y: float = y, name: str = name) -> float:
            box = _text_box(x, y, name, side)
            inside = box.overlap(plot)
            return sum(box.overlap(other) for other in taken) + (LETTER * len(name) * LINE - inside)

        best = min(SIDES, key=lambda side: round(covered(side), 5))
        chosen.append(best)
        taken.append(_text_box(x, y, name, best))
    return chosen


def _text_box(x: float, y: float, name: str, side: Side) -> Box:
    width = LETTER * len(name)
    left = x - width / 2.0 if side.across == 0 else (x + GAP / 2 if side.across > 0 else x - GAP / 2 - width)
    bottom = y - LINE / 2.0 if side.up == 0 else (y + GAP if side.up > 0 else y - GAP - LINE)
    return Box(left, left + width, bottom, bottom + LINE)


RINGS = (7.0, 16.0, 28.0, 42.0, 58.0, 76.0)
"""Distances of a name from its point that are tried, one after another. [px]"""

TURNS = 16
"""Directions that are tried at each distance."""


def place_freely(
    points: Sequence[tuple[float, float]], sizes: Sequence[tuple[float, float]], obstacles: Sequence[Box], area: Box
) -> list[Box | None]:
    """Find a free place for each name, near its point, covering nothing.

    Parameters
    ----------
    points : sequence of (x, y)
        The points. [px]
    sizes : sequence of (width, height)
        Of their names. [px]
    obstacles : sequence of Box
        What else must stay free, such as error bars. [px]
    area : Box
        Where names may stand. [px]

    Returns
    -------
    list of Box or None
        One a point: the first free place, near ones first; None where every place is covered, so that a name is left
        out rather than written over another.
    """
    taken = [*obstacles, *(Box(x - 6.0, x + 6.0, y - 6.0, y + 6.0) for x, y in points)]
    chosen: list[Box | None] = []
    for (x, y), (width, height) in zip(points, sizes, strict=True):
        found = None
        for box in _places(x, y, width, height):
            inside = area.left <= box.left and box.right <= area.right
            inside = inside and area.bottom <= box.bottom and box.top <= area.top
            if inside and not any(box.overlap(other) > 0.0 for other in taken):
                found = box
                break
        chosen.append(found)
        taken += [found] if found else []
    return chosen


def _places(x: float, y: float, width: float, height: float) -> Iterator[Box]:
    """Boxes about a point, near ones first: at the end of a ray of each direction."""
    for ring in RINGS:
        for turn in range(TURNS):
            angle = 2.0 * math.pi * turn / TURNS
            across, up = math.cos(angle), math.sin(angle)
            centre_x = x + across * (ring + width / 2.0)
            centre_y = y + up * (ring + height / 2.0)
            yield Box(centre_x - width / 2.0, centre_x + width / 2.0, centre_y - height / 2.0, centre_y + height / 2.0)
