"""One look for every picture: palettes of light and dark pages, and of the laws.

The law colours are those of Okabe and Ito (distinguishable with every common colour-vision deficiency), continued by
five, enough for the registered laws; marker shape and dash repeat what colour says. The reference law is always grey:
colour means "a law under test".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

REFERENCE_GREY = "#7A828C"
WARNING = "#CF3F35"

FLOWS = {"generator": "#0072B2", "slip": "#E69F00", "hinge": "#CC79A7", "radiated": "#8FB8D0", "stored": "#9AA1A9"}
"""Where the energy goes: the useful share in the strong colour."""

LOCK_SCALE = ((0.0, "#B5472F"), (0.5, "#E3B873"), (0.8, "#8FB3B0"), (1.0, "#12626E"))
"""Probability of lock: warm is bad, petrol is good, pale between; red-green blindness leaves orange against blue."""


class Page(NamedTuple):
    """Colours of a page: text, faint text, grid, axes."""

    ink: str
    muted: str
    grid: str
    axis: str


LIGHT = Page("#1F2933", "#5B6672", "#E6E9ED", "#C3C9D0")
DARK = Page("#E4E8EC", "#A3ADB8", "#2E363F", "#4A545F")


class LawStyle(NamedTuple):
    """How one law looks everywhere: colour, plotly symbol, matplotlib marker and dash."""

    colour: str
    symbol: str
    marker: str
    dash: str


STYLES = (
    LawStyle("#0072B2", "circle", "o", "solid"),
    LawStyle("#D55E00", "square", "s", "solid"),
    LawStyle("#009E73", "diamond", "D", "solid"),
    LawStyle("#CC79A7", "triangle-up", "^", "solid"),
    LawStyle("#E69F00", "cross", "P", "dash"),
    LawStyle("#56B4E9", "pentagon", "p", "dash"),
    LawStyle("#8C6BB1", "star", "*", "dash"),
    LawStyle("#A0522D", "hexagon", "h", "dash"),
    LawStyle("#C2185B", "triangle-down", "v", "dot"),
    LawStyle("#999933", "x", "X", "dot"),
    LawStyle("#5C6BC0", "hourglass", "8", "dot"),
)
"""Of the laws under test, in their order."""

HUES = [style.colour for style in STYLES]


def law_styles(names: Sequence[str], reference: str | None) -> dict[str, LawStyle]:
    """Look of each law by its name; grey for the reference."""
    tested = [name for name in names if name != reference]
    styles = {name: STYLES[i % len(STYLES)] for i, name in enumerate(tested)}
    grey = LawStyle(REFERENCE_GREY, "circle-open", "o", "solid")
    return {name: styles.get(name, grey) for name in names}
