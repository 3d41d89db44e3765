"""One look for every page: type and plotly templates for light and dark pages; colours by `gyroctl.palette`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from gyroctl.palette import FLOWS, GRID, HUES, INK, LOCK_SCALE, MUTED, REFERENCE_GREY, WARNING, LawStyle, law_styles
from gyroctl.statistics import Estimate

if TYPE_CHECKING:
    import plotly.graph_objects as go

__all__ = [  # the colours as well, for the files of this room
    "CLEAR",
    "DARK",
    "FLOWS",
    "FONT",
    "HUES",
    "LIGHT",
    "LOCK_SCALE",
    "REFERENCE_GREY",
    "WARNING",
    "LawStyle",
    "Page",
    "error_bars",
    "finished",
    "law_styles",
    "template",
]

FONT = "-apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', 'Liberation Sans', Arial, system-ui, sans-serif"


class Page(NamedTuple):
    """Colours of a page: text, faint text, grid, axes."""

    ink: str
    muted: str
    grid: str
    axis: str


LIGHT = Page(INK, MUTED, GRID, "#C3C9D0")
DARK = Page("#E4E8EC", "#A3ADB8", "#2E363F", "#4A545F")
CLEAR = "rgba(0,0,0,0)"


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
