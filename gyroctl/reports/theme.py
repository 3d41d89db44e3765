"""One look for every picture: palette, type and plotly templates for light and dark pages.

The law colours are those of Okabe and Ito (distinguishable with every common colour-vision deficiency), continued by
five, enough for the registered laws; marker shape and dash repeat what colour says. The reference law is always grey:
colour means "a law under test".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from gyroctl.statistics import Estimate

if TYPE_CHECKING:
    import plotly.graph_objects as go

FONT = "-apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', 'Liberation Sans', Arial, system-ui, sans-serif"
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
CLEAR = "rgba(0,0,0,0)"


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


def template(colours: Page = LIGHT) -> go.layout.Template:
    """Make the plotly template of the project.

    Parameters
    ----------
    colours : Page
        `LIGHT` or `DARK`.

    Returns
    -------
    plotly.graph_objects.layout.Template
        Transparent background, hairline grid, no box, ticks outside, legend above the plot.
    """
    import plotly.graph_objects as go

    axis = {
        "gridcolor": colours.grid,
        "linecolor": colours.axis,
        "tickcolor": colours.axis,
        "zerolinecolor": colours.axis,
        "zerolinewidth": 1,
        "showline": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickfont": {"color": colours.muted, "size": 12},
        "title": {"font": {"color": colours.muted, "size": 13}, "standoff": 10},
        "automargin": True,
    }
    above = {"x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom"}
    return go.layout.Template(
        layout={
            "font": {"family": FONT, "size": 13, "color": colours.ink},
            "paper_bgcolor": CLEAR,
            "plot_bgcolor": CLEAR,
            "colorway": HUES,
            "margin": {"l": 70, "r": 24, "t": 46, "b": 52},
            "xaxis": axis,
            "yaxis": axis,
            "legend": {"orientation": "h", "font": {"size": 12.5}, "bgcolor": CLEAR, **above},
            "hoverlabel": {"font": {"family": FONT, "size": 12.5}},
            "annotationdefaults": {"font": {"color": colours.ink}},
            "hovermode": "closest",
            "modebar": {"bgcolor": CLEAR, "color": colours.axis, "activecolor": colours.muted},
        }
    )


def error_bars(estimates: Sequence[Estimate], colour: str = REFERENCE_GREY, width: float = 1.3) -> dict[str, object]:
    """Error bars; none where an interval is missing."""
    up = [e.high - e.value if math.isfinite(e.high) else None for e in estimates]
    down = [e.value - e.low if math.isfinite(e.low) else None for e in estimates]
    look = {"color": colour, "thickness": width, "width": 4}
    return {"type": "data", "symmetric": False, "array": up, "arrayminus": down, **look}


def finished(figure: go.Figure, height: int) -> go.Figure:
    """Give the figure its template and its height [px]."""
    return figure.update_layout(template=template(), height=height)
