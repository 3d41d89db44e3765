"""Draw the rooms of the package and what they import from each other: ``docs/rooms.svg``.

    python docs/draw_rooms.py

The rooms stand on a staircase, in the order of their layers. An arrow leaves a room to the right and comes down into
the room that is imported, so that all arrows turn right and down: one that led upward would have to cross to the other
side of the stairs. Everything is read from the sources: layers from ``pyproject.toml``, arrows from the import graph,
captions from the first sentence of each room.
"""

from __future__ import annotations

import ast
import math
import re
import textwrap
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

from import_graph import PACKAGE, file_graph, layers, room, rooms_graph, shipped_files

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "rooms.svg"

PAPER, BAND, EDGE, INK, MUTED = "#FCFBF8", "#F2F0EA", "#D9D5CB", "#1F2933", "#5B6672"
STOREYS = (
    ("studies", "#8C5A2B", "commands and studies"),
    ("comparison", "#1D6FA5", "laws, and what judges them"),
    ("errors", "#2F7D5B", "device, waves, orbits, loop"),
)
"""Storeys from above to below: last layer by one of its rooms, colour of its rooms and their arrows, what it is."""

LEFT, TOP = 28, 112
CAPTIONS = 306
"""Room to the left of the first box. [px]"""

ROW, GAP, COLUMN = 46, 8, 43
BOX_WIDTH, BOX_HEIGHT = 142, 38
LANE = 26
"""Distance of the arrows that come in from the right end of a box. [px]"""

TURN = 13
"""Radius of the bend of an arrow. [px]"""

CHARACTER = 0.57
"""Mean width of a character of a caption, on the safe side, in units of its size."""


@dataclass(frozen=True)
class Room:
    """A box of the picture."""

    name: str
    layer: int
    lines: int
    caption: str
    column: int
    colour: str

    @property
    def right(self) -> float:
        """Right end of the box. [px]"""
        return LEFT + CAPTIONS + BOX_WIDTH + self.column * COLUMN

    @property
    def left(self) -> float:
        """Left end of the box. [px]"""
        return self.right - BOX_WIDTH

    @property
    def middle(self) -> float:
        """Height of the middle of the box. [px]"""
        return TOP + self.column * ROW + self.layer * GAP + ROW / 2

    @property
    def lane(self) -> float:
        """Where arrows come down into the box. [px]"""
        return self.right - LANE


def rooms(root: Path = ROOT) -> list[Room]:
    """Read the rooms in the order of their layers."""
    files = shipped_files(root)
    size = Counter({room(module): 0 for module in files})
    for module, path in files.items():
        size[room(module)] += len(path.read_text(encoding="utf-8").splitlines())
    found: list[Room] = []
    storeys = iter(STOREYS)
    last, colour, _ = next(storeys)
    for layer, names in enumerate(layers(root)):
        for name in names:
            caption = _caption(files[f"{PACKAGE}.{name}"])
            found.append(Room(name, layer, size[name], caption, len(found), colour))
        if last in names:
            last, colour, _ = next(storeys, ("", MUTED, ""))
    return found


def draw(root: Path = ROOT) -> str:
    """Return the picture as SVG."""
    boxes = {box.name: box for box in rooms(root)}
    imports = rooms_graph(file_graph(root))
    last = max(boxes.values(), key=lambda box: box.column)
    width, height = last.right + LEFT, last.middle + ROW / 2 + LEFT
    # thick ones first, so that a thin one shows where both share a lane
    arrows = sorted(imports.items(), key=lambda arrow: (-arrow[1], arrow[0]))
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}"'
        f' height="{height:g}" font-family="Helvetica, Arial, Liberation Sans, sans-serif">',
        "<title>The rooms of gyroctl and their imports</title>",
        f'<rect width="{width:g}" height="{height:g}" rx="10" fill="{PAPER}"/>',
        *_bands(list(boxes.values()), width),
        *_heading(len(layers(root))),
        *(_arrow(boxes[source], boxes[target], count) for (source, target), count in arrows),
        *(_head(box) for box in boxes.values() if any(target == box.name for _, target in imports)),
        *(_box(box) for box in boxes.values()),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def structure(svg: str) -> tuple[list[str], set[tuple[str, str]]]:
    """Rooms in their order, and arrows, of a picture that `draw` has made."""
    import xml.etree.ElementTree as ElementTree

    drawn = ElementTree.fromstring(svg)
    boxes = [str(item.get("data-room")) for item in drawn.iter() if item.get("data-room")]
    arrows = {(str(item.get("data-from")), str(item.get("data-to"))) for item in drawn.iter() if item.get("data-from")}
    return boxes, arrows


def _caption(path: Path) -> str:
    """First sentence of what a room says about itself, without its full stop."""
    says = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return re.split(r"\.\s+(?=[A-Z])|\n", says)[0].rstrip(".")


def _wrapped(words: str, characters: int) -> list[str]:
    """Two lines at most, about equally long."""
    tries = [
        textwrap.wrap(words, width, max_lines=2, placeholder=" …", break_on_hyphens=False)
        for width in range(20, characters + 1)
    ]
    widest = tries[-1]
    return next((found for found in tries if len(found) == len(widest) and not found[-1].endswith(" …")), widest)


def _stroke(count: int) -> float:
    """Width of an arrow that stands for `count` imports. [px]"""
    return 0.9 + 0.75 * math.sqrt(count)


def _text(x: float, y: float, words: str, size: float, colour: str = INK, more: str = "") -> str:
    return f'<text x="{x:g}" y="{y:g}" font-size="{size:g}" fill="{colour}"{more}>{escape(words)}</text>'


def _heading(count: int) -> list[str]:
    say = (
        "An arrow leaves a room to the right and comes down into the room that it imports; its width grows with the "
        "number of such imports.",
        f"{count} layers from above to below: all arrows turn right and down, and none joins two rooms of one layer.",
    )
    found = [_text(LEFT, 38, "The rooms of gyroctl", 21, INK, ' font-weight="bold"')]
    found += [_text(LEFT, 63 + 19 * i, line, 13, MUTED) for i, line in enumerate(say)]
    x = LEFT + 290.0
    for _, colour, name in STOREYS:
        found.append(_text(x, 38, name, 13, colour, ' font-weight="bold"'))
        x += 8.5 * len(name) + 30.0
    return found


def _bands(boxes: list[Room], width: float) -> list[str]:
    """One band for each layer, with rooms of one layer in the same band."""
    found = []
    for layer in sorted({box.layer for box in boxes}):
        members = [box for box in boxes if box.layer == layer]
        top, bottom = members[0].middle - ROW / 2, members[-1].middle + ROW / 2
        size = f'x="{LEFT / 2:g}" y="{top:g}" width="{width - LEFT:g}" height="{bottom - top:g}"'
        found.append(f'<rect {size} rx="6" fill="{BAND}"/>')
    return found


def _arrow(source: Room, target: Room, count: int) -> str:
    start, turn, end = source.right, target.lane, target.middle - BOX_HEIGHT / 2 - 5
    y = source.middle
    path = f"M{start:g} {y:g}H{turn - TURN:g}Q{turn:g} {y:g} {turn:g} {y + TURN:g}V{end:g}"
    return (
        f'<path d="{path}" fill="none" stroke="{source.colour}" stroke-width="{_stroke(count):.2f}"'
        f' data-from="{source.name}" data-to="{target.name}"/>'
    )


def _head(box: Room) -> str:
    x, tip = box.lane, box.middle - BOX_HEIGHT / 2
    return f'<path d="M{x - 5.5:g} {tip - 9:g}L{x:g} {tip:g}L{x + 5.5:g} {tip - 9:g}Z" fill="{MUTED}"/>'


def _box(box: Room) -> str:
    size = f'x="{box.left:g}" y="{box.middle - BOX_HEIGHT / 2:g}" width="{BOX_WIDTH}" height="{BOX_HEIGHT}"'
    inside = box.left + 11
    beside, room_for_words = box.left - 13, box.left - 13 - LEFT
    caption = _wrapped(box.caption, int(room_for_words / (CHARACTER * 12)))
    first = box.middle + 4 - 7.5 * (len(caption) - 1)
    return "\n".join(
        [
            f'<g data-room="{box.name}">',
            f'<rect {size} rx="6" fill="white" stroke="{box.colour}" stroke-width="1.6"/>',
            _text(inside, box.middle - 2, box.name, 14, box.colour, ' font-weight="bold"'),
            _text(inside, box.middle + 13, f"{box.lines:,} lines".replace(",", " "), 11, MUTED),
            *(_text(beside, first + 15 * i, line, 12, MUTED, ' text-anchor="end"') for i, line in enumerate(caption)),
            "</g>",
        ]
    )


if __name__ == "__main__":
    PICTURE.write_text(draw(), encoding="utf-8")
