"""One look for every page: the colours of light and dark pages beside those of `gyroctl.palette`."""

from __future__ import annotations

from typing import NamedTuple

from gyroctl.palette import FLOWS, GRID, HUES, INK, LOCK_SCALE, MUTED, REFERENCE_GREY, WARNING, LawStyle, law_styles

__all__ = [  # the colours as well, for the files of this room
    "DARK",
    "FLOWS",
    "HUES",
    "LIGHT",
    "LOCK_SCALE",
    "REFERENCE_GREY",
    "WARNING",
    "LawStyle",
    "Page",
    "law_styles",
]


class Page(NamedTuple):
    """Colours of a page: text, faint text, grid, axes, and what they stand on."""

    ink: str
    muted: str
    grid: str
    axis: str
    card: str


LIGHT = Page(INK, MUTED, GRID, "#C3C9D0", "#FFFFFF")
DARK = Page("#E4E8EC", "#A3ADB8", "#2E363F", "#4A545F", "#1B2127")
