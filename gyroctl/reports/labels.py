"""Where to write the names of points in a plot, so that they cover neither points, nor error bars, nor one another."""

from __future__ import annotations

from collections.abc import Sequence
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
