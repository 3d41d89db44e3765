"""Colours of every picture: one table, by what a colour means.

The law colours are those of Okabe and Ito (distinguishable with every common colour-vision deficiency), continued by
some more; marker shape and dash repeat what colour says. A registered law has one look in every picture; the reference
law is always grey: colour means "a law under test".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from typing import NamedTuple

INK, MUTED, GRID = "#1F2933", "#5B6672", "#E6E9ED"
"""Text, faint text and grid on white."""

REFERENCE_GREY = "#7A828C"
WARNING = "#CF3F35"

GAMMA_COLOURS = {1.0: "#8C6BB1", 5.0: "#0072B2", 50.0: "#B5472F"}
"""By peak enhancement of the sea."""

FLOWS = {"generator": "#0072B2", "slip": "#E69F00", "hinge": "#CC79A7", "radiated": "#8FB8D0", "stored": "#9AA1A9"}
"""Where the energy goes: the useful share in the strong colour."""

LOCK_SCALE = ((0.0, "#B5472F"), (0.5, "#E3B873"), (0.8, "#8FB3B0"), (1.0, "#12626E"))
"""Probability of lock: warm is bad, petrol is good, pale between; red-green blindness leaves orange against blue."""


class LawStyle(NamedTuple):
    """How one law looks everywhere: colour, plotly symbol, matplotlib marker and dash."""

    colour: str
    symbol: str
    marker: str
    dash: str


REGISTERED: Mapping[str, LawStyle] = {
    "nmpc": LawStyle("#0072B2", "circle", "o", "solid"),
    "coupling": LawStyle("#D55E00", "square", "s", "solid"),
    "load_angle": LawStyle("#009E73", "diamond", "D", "solid"),
    "scheduled_lqr": LawStyle("#CC79A7", "triangle-up", "^", "solid"),
    "threshold": LawStyle("#E69F00", "cross", "P", "dash"),
    "tracking": LawStyle("#56B4E9", "pentagon", "p", "dash"),
    "stabiliser": LawStyle("#8C6BB1", "star", "*", "dash"),
    "scheduled_lmi": LawStyle("#A0522D", "hexagon", "h", "dash"),
    "supervisor": LawStyle("#C2185B", "triangle-down", "v", "dot"),
    "constant": LawStyle("#999933", "x", "X", "dot"),
}
"""The laws that ship, by name."""

OWN = (
    LawStyle("#5C6BC0", "hourglass", "8", "solid"),
    LawStyle("#00A3A3", "triangle-left", "<", "solid"),
    LawStyle("#7B3F61", "triangle-right", ">", "dash"),
    LawStyle("#6B8E23", "diamond-tall", "d", "dash"),
)
"""Laws of one's own, in their order; after them the looks of laws that are not in the picture."""

STYLES = (*REGISTERED.values(), *OWN)

HUES = [style.colour for style in STYLES]

REFERENCE = "best_constant"
"""Law that is grey, whether others are measured against it or not."""

GREY = LawStyle(REFERENCE_GREY, "circle-open", "o", "solid")
"""Look of what the others are measured against."""


def base_of(name: str) -> str:
    """Law of a case: ``nmpc`` of ``nmpc[information=oracle] (gamma50)``."""
    return name.partition("[")[0].partition(" (")[0].strip()


def law_styles(names: Sequence[str], reference: str | None = REFERENCE) -> dict[str, LawStyle]:
    """Look of each law by its name.

    A registered law has its colour in every picture. Its cases, named ``law[parameter=value]`` or ``law (set)``, have
    that colour too, each with another marker and dash. Laws of one's own take the colours that are left, in their
    order; grey is for the reference.

    Parameters
    ----------
    names : sequence of str
        Laws of a picture, or of a page.
    reference : str, optional
        The law that others are measured against.

    Returns
    -------
    dict of str to LawStyle
    """
    bases = {name: base_of(name) for name in names}
    looks, free = dict(REGISTERED), _free(set(bases.values()))
    styles: dict[str, LawStyle] = {}
    cases: dict[str, int] = {}
    for name in names:
        base = bases[name]
        if name == reference or base == REFERENCE:
            look = GREY
        elif base in looks:
            look = looks[base]
        else:
            look = looks[base] = next(free)
        if base != name:  # the law itself keeps its look wherever it stands in the list
            cases[base] = cases.get(base, 0) + 1
            look = _case(look, cases[base])
        styles[name] = look
    return styles


def _free(present: set[str]) -> Iterator[LawStyle]:
    """Looks for laws of one's own, without an end: where the colours begin again, the markers are shifted."""
    looks = (*OWN, *(look for name, look in reversed(tuple(REGISTERED.items())) if name not in present))
    for number in count():
        shift = number // len(looks)
        look, other = looks[number % len(looks)], looks[(number + shift) % len(looks)]
        yield look if not shift % len(looks) else look._replace(symbol=other.symbol, marker=other.marker)


def _case(look: LawStyle, number: int) -> LawStyle:
    """The look of a law's `number`-th case, from 1: its colour with the marker of another law."""
    own = next((i for i, style in enumerate(STYLES) if style.marker == look.marker), 0)
    other = STYLES[(own + 1 + (number - 1) % (len(STYLES) - 1)) % len(STYLES)]
    return LawStyle(look.colour, other.symbol, other.marker, ("dash", "dot", "dashdot")[(number - 1) % 3])
