"""Where the pictures of a report are drawn: sheets of so many pixels, which become SVG of the colours of the page.

A picture is drawn once, when the report is written, for two widths: a desk and a telephone. Nothing is drawn in the
browser, so a page opens at once, prints as it stands and needs no library. Text stays text: it can be searched, copied
and enlarged. A unit of the SVG is a pixel of the width that it was drawn for.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

from gyroctl.names import in_markup
from gyroctl.reports.panel import Panel, Panels, as_markup
from gyroctl.reports.theme import LIGHT, WARNING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FONTS = ("Liberation Sans", "Arial", "Helvetica", "DejaVu Sans")
"""The first three have letters of the same widths; the last is wider, so that what has room there has it everywhere."""

LETTER = 0.6
"""Width of a letter over the size of the type, on the safe side for words of mixed letters."""

INCH = 72.0
"""Units of an inch in SVG of matplotlib: with 72 points to the inch, a point is a pixel."""

VARIABLES = {
    LIGHT.ink: "var(--ink)",
    LIGHT.muted: "var(--muted)",
    LIGHT.grid: "var(--grid)",
    LIGHT.axis: "var(--axis)",
    "#FFFFFF": "var(--card)",
    WARNING: "var(--bad)",
}
"""Colours of the page that stand in a picture; those of the laws are the same on light and dark."""


class Paper(NamedTuple):
    """What a picture is drawn on.

    Parameters
    ----------
    width : int
        Of the sheet. [px]
    type : float
        Size of the letters. [px]
    longest : int
        Letters of a name in a margin; longer ones are cut.
    """

    width: int
    type: float
    longest: int

    @property
    def narrow(self) -> bool:
        """Whether it is that of a telephone."""
        return self.width < 500

    def letters(self, text: str, size: float | None = None) -> float:
        """Width of a text, on the safe side. [px]"""
        return LETTER * (size or self.type) * len(text)

    def short(self, name: str) -> str:
        """Name as it fits a margin."""
        return name if len(name) <= self.longest else f"{name[: self.longest - 1]}…"

    def margin(self, names: Sequence[str]) -> float:
        """Width of a margin with these names and the ticks. [px]"""
        return max((self.letters(self.short(name)) for name in names), default=0.0) + 14.0


DESK = Paper(960, 12.5, 36)
TELEPHONE = Paper(338, 11.5, 15)
TILE = Paper(320, 11.0, 15)
"""Of the small pictures of a law, which stand side by side or below one another."""


class Room(NamedTuple):
    """Margins about the axes, and gaps between them. [px]"""

    left: float = 62.0
    right: float = 14.0
    top: float = 10.0
    bottom: float = 49.0
    across: float = 60.0
    down: float = 60.0


def sheet(
    paper: Paper, heights: Sequence[float], columns: int = 1, room: Room | None = None, share_x: bool = False
) -> tuple[Figure, list[Axes]]:
    """Make a sheet with rows of axes of these heights [px]; axes come row by row."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    room = room or Room()
    height = room.top + sum(heights) + room.down * (len(heights) - 1) + room.bottom
    width = (paper.width - room.left - room.right - room.across * (columns - 1)) / columns
    figure = Figure(figsize=(paper.width / INCH, height / INCH), dpi=INCH)  # no pyplot: no global state, no display
    FigureCanvasAgg(figure)
    axes: list[Axes] = []
    top = height - room.top
    for row in heights:
        for column in range(columns):
            left = room.left + column * (width + room.across)
            place = (left / paper.width, (top - row) / height, width / paper.width, row / height)
            axes.append(figure.add_axes(place, sharex=axes[0] if share_x and axes else None))
        top -= row + room.down
    return figure, axes


def panels(paper: Paper, height: float, found: Sequence[Panel], room: Room | None = None) -> Panels:
    """Make a sheet with these panels below one another, each of this height [px]."""
    room = room or Room()
    return Panels(found, paper.width, paper.type, height, room.left, room.right, room.top, room.down, room.bottom)


class Key(NamedTuple):
    """Entry of a legend, which stands below its picture as text of the page.

    Parameters
    ----------
    label : str
        In words.
    colour : str
        Of the mark.
    kind : {"solid", "dash", "dot", "box", "hole", "bar", "cross"}
        Line, square, or mark.
    """

    label: str
    colour: str
    kind: str


class Drawing(NamedTuple):
    """A picture: what is drawn, what it shows in words, and its legend."""

    figure: Figure | Panels
    alt: str
    keys: tuple[Key, ...] = ()


class Plate(NamedTuple):
    """A picture as it stands in a page: for a desk and for a telephone, or the same for both."""

    wide: str
    narrow: str
    keys: tuple[Key, ...]


def plate(draw: Callable[[Paper], Drawing], key: str, papers: Sequence[Paper] = (DESK, TELEPHONE)) -> Plate:
    """Draw a picture for each paper; `key` is other than that of every other picture of the page."""
    drawn = list[str]()
    keys: tuple[Key, ...] = ()
    for paper in papers:
        with look(paper):
            figure, alt, keys = draw(paper)
            if isinstance(figure, Panels):
                drawn.append(as_markup(figure, alt))
            else:
                drawn.append(as_svg(figure, f"{key}{len(drawn)}", alt))
    return Plate(drawn[0], drawn[-1] if len(drawn) > 1 else "", keys)


def listed_rows(axes: Axes, names: Sequence[str], paper: Paper) -> None:
    """Make the vertical axis a list of names, the first on top."""
    axes.set_yticks(range(len(names)), [paper.short(name) for name in names])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)


@contextmanager
def look(paper: Paper) -> Iterator[None]:
    """Draw with the look of the reports."""
    import matplotlib as mpl

    style: Any = {
        "font.family": "sans-serif",
        "font.sans-serif": list(FONTS),
        "font.size": paper.type,
        "text.parse_math": False,  # names are text, whatever is in them
        "text.color": LIGHT.ink,
        "axes.edgecolor": LIGHT.axis,
        "axes.labelcolor": LIGHT.muted,
        "axes.labelsize": paper.type,
        "axes.titlesize": paper.type,
        "axes.titlelocation": "left",
        "axes.titlecolor": LIGHT.ink,
        "axes.titlepad": 6.0,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.unicode_minus": True,
        "grid.color": LIGHT.grid,
        "grid.linewidth": 1.0,
        "lines.linewidth": 1.6,
        "xtick.color": LIGHT.axis,
        "ytick.color": LIGHT.axis,
        "xtick.labelcolor": LIGHT.muted,
        "ytick.labelcolor": LIGHT.muted,
        "xtick.major.pad": 6.5,  # clear of the lowest label of the other axis
        "xtick.labelsize": paper.type - 0.5,
        "ytick.labelsize": paper.type - 0.5,
        "figure.facecolor": "none",
        "axes.facecolor": "none",
        "savefig.facecolor": "none",
        "svg.fonttype": "none",
        "svg.hashsalt": "gyroctl",
        "path.simplify": True,
    }
    with mpl.rc_context(style):
        yield


def as_svg(figure: Figure, key: str, alt: str) -> str:
    """SVG element of a figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        From `sheet`, drawn under `look`.
    key : str
        Other than that of every other picture of the page: identifiers begin with it.
    alt : str
        The picture in words.

    Returns
    -------
    str
        Element that takes the width which it is given; equal figures give equal text.
    """
    file = io.StringIO()
    with warnings.catch_warnings():  # the browser finds a font for each letter, whatever the one of this machine has
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    text = file.getvalue()
    width, height = (side * INCH for side in figure.get_size_inches())
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    body = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>|<style.*?</style>|<title>.*?</title>", "", body, flags=re.S)
    body = re.sub(r"<[^>]*>", lambda tag: _of_the_page(tag.group(), key), body)  # tags alone: text is what it is
    body = _styled_once(re.sub(r"\s*\n\s*", "\n", body).strip())
    size = f'viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}"'
    return f'<svg class="drawn" role="img" aria-label="{in_markup(alt)}" {size}>{body}</svg>'


ALIKE = re.compile(r'<use [^>]*?( style="[^"]*")/>\n(?:<use [^>]*?\1/>\n){2,}')
"""Points of one look, one after the other."""

SHAPE = re.compile(r'((?: id="| href="#)[^"]*-)(m[0-9a-f]{10})"')
"""Name of a shape, of which points are."""


def _styled_once(body: str) -> str:
    """Let points of one look share it, and names of shapes be short: a page of many runs is mostly that."""

    def shared(points: re.Match[str]) -> str:
        return f"<g{points[1]}>\n{points.group().replace(points[1], '')}</g>\n"

    short = {name: f"s{k}" for k, name in enumerate(dict.fromkeys(name for _, name in SHAPE.findall(body)))}
    return ALIKE.sub(shared, SHAPE.sub(lambda found: f'{found[1]}{short[found[2]]}"', body))


def _of_the_page(tag: str, key: str) -> str:
    """Tag with identifiers of its own, the colours of the page, and numbers to the hundredth of a pixel."""
    tag = re.sub(r'<g id="[^"]*"', "<g", tag)
    tag = re.sub(r' (?:xlink:)?href="#', f' href="#{key}-', tag)
    tag = tag.replace(' id="', f' id="{key}-').replace("url(#", f"url(#{key}-")
    tag = re.sub(r" font-family: [^;\"]*;?", "", tag)
    tag = re.sub(r' transform="rotate\(-0 [^"]*"', "", tag)
    tag = re.sub(r"#[0-9a-fA-F]{6}", lambda colour: VARIABLES.get(colour.group().upper(), colour.group()), tag)
    return re.sub(r"-?\d+\.\d{3,}", lambda number: f"{round(float(number.group()), 2):.12g}", tag)
