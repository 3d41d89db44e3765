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
HUES = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#8C6BB1",
    "#A0522D",
    "#C2185B",
    "#999933",
    "#5C6BC0",
)
SYMBOLS = (
    "circle",
    "square",
    "diamond",
    "triangle-up",
    "cross",
    "pentagon",
    "star",
    "hexagon",
    "triangle-down",
    "x",
    "hourglass",
)
MARKERS = ("o", "s", "D", "^", "P", "p", "*", "h", "v", "X", "8")
DASHES = ("solid", "solid", "solid", "solid", "dash", "dash", "dash", "dash", "dot", "dot", "dot")
REFERENCE_GREY = "#7A828C"
WARNING = "#CF3F35"

FLOWS = {"generator": "#0072B2", "slip": "#E69F00", "hinge": "#CC79A7", "radiated": "#8FB8D0", "stored": "#9AA1A9"}
"""Where the energy goes: the useful share in the strong colour."""

LOCK_SCALE = ((0.0, "#B5472F"), (0.5, "#E3B873"), (0.8, "#8FB3B0"), (1.0, "#12626E"))
"""Probability of lock: warm is bad, petrol is good, pale between; red-green blindness leaves orange against blue."""

LIGHT = {
    "ink": "#1F2933",
    "muted": "#5B6672",
    "grid": "#E6E9ED",
    "axis": "#C3C9D0",
    "paper": "rgba(0,0,0,0)",
    "label": "#FFFFFF",
}
DARK = {
    "ink": "#E4E8EC",
    "muted": "#A3ADB8",
    "grid": "#2E363F",
    "axis": "#4A545F",
    "paper": "rgba(0,0,0,0)",
    "label": "#1B2127",
}


class LawStyle(NamedTuple):
    """How one law looks everywhere."""

    colour: str
    symbol: str
    marker: str
    dash: str


def law_styles(names: Sequence[str], reference: str | None) -> dict[str, LawStyle]:
    """Colour, plotly symbol, matplotlib marker and dash of each law; grey for the reference."""
    styles, used = {}, 0
    for name in names:
        if name == reference:
            styles[name] = LawStyle(REFERENCE_GREY, "circle-open", "o", "solid")
            continue
        slot = used % len(HUES)
        styles[name] = LawStyle(HUES[slot], SYMBOLS[slot], MARKERS[slot], DASHES[slot])
        used += 1
    return styles


def template(colours: dict[str, str] = LIGHT) -> go.layout.Template:
    """Make the plotly template of the project.

    Parameters
    ----------
    colours : dict
        `LIGHT` or `DARK`.

    Returns
    -------
    plotly.graph_objects.layout.Template
        Transparent background, hairline grid, no box, ticks outside, legend above the plot.
    """
    import plotly.graph_objects as go

    axis = {
        "gridcolor": colours["grid"],
        "linecolor": colours["axis"],
        "tickcolor": colours["axis"],
        "zerolinecolor": colours["axis"],
        "zerolinewidth": 1,
        "showline": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickfont": {"color": colours["muted"], "size": 12},
        "title": {"font": {"color": colours["muted"], "size": 13}, "standoff": 10},
        "automargin": True,
    }
    return go.layout.Template(
        layout={
            "font": {"family": FONT, "size": 13, "color": colours["ink"]},
            "paper_bgcolor": colours["paper"],
            "plot_bgcolor": colours["paper"],
            "colorway": list(HUES),
            "margin": {"l": 70, "r": 24, "t": 46, "b": 52},
            "xaxis": axis,
            "yaxis": axis,
            "legend": {
                "orientation": "h",
                "x": 0,
                "xanchor": "left",
                "y": 1.02,
                "yanchor": "bottom",
                "font": {"size": 12.5},
                "bgcolor": "rgba(0,0,0,0)",
            },
            "hoverlabel": {"font": {"family": FONT, "size": 12.5}},
            "annotationdefaults": {"font": {"color": colours["ink"]}},
            "hovermode": "closest",
            "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": colours["axis"], "activecolor": colours["muted"]},
        }
    )


def error_bars(estimates: Sequence[Estimate], colour: str = REFERENCE_GREY, width: float = 1.3) -> dict[str, object]:
    """Error bars; none where an interval is missing."""
    up = [e.high - e.value if math.isfinite(e.high) else None for e in estimates]
    down = [e.value - e.low if math.isfinite(e.low) else None for e in estimates]
    return {
        "type": "data",
        "symmetric": False,
        "array": up,
        "arrayminus": down,
        "color": colour,
        "thickness": width,
        "width": 4,
    }


def finished(figure: go.Figure, height: int) -> go.Figure:
    """Give the figure its template and its height [px]."""
    return figure.update_layout(template=template(), height=height)
