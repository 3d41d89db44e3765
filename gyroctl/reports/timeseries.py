"""The example realisation as an interactive time series: one panel a signal, one colour a law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports import layout
from gyroctl.reports.evaluation import Evaluation
from gyroctl.reports.theme import REFERENCE_GREY, law_styles, template
from gyroctl.reports.verdict import judge

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr

PANELS = (
    ("power", "Electrical power [W]"),
    ("ring_speed", "Ring speed [rad/s]"),
    ("phi1", "φ<sub>1</sub>, horizontal motion [rad]"),
    ("phi3", "φ<sub>3</sub>, vertical motion [rad]"),
    ("cc", "Coupling coefficient c<sub>c</sub> [Nms]"),
    ("cg", "Generator coefficient c<sub>g</sub> [Nms]"),
    ("load_share", "Used share of the lock capacity [1]"),
)
POINTS = 2000
"""Most points of a line: two a pixel or so over the whole run, and the first view sample by sample."""


def time_series(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """Elevation, power, ring speed, motion, actuators and load share of the first realisation, over time [s].

    The legend shows and hides a law in all panels; at first only the reference and the best law are shown, and 120 s
    of the run. A line has at most `POINTS` points: every sample of those 120 s, and beside them the least and the
    greatest value of every few seconds, so that each peak shows. All lines have the same times.

    Raises
    ------
    ValueError
        The dataset holds no example time series.
    """
    from plotly.subplots import make_subplots

    from gyroctl.simulation.extremes import STRETCH, few_points, middle  # its room loads SciPy

    if not layout.has_examples(ds):
        raise ValueError("the dataset holds no example time series")
    styles = law_styles(layout.names(ds), evaluation.reference)
    figure = make_subplots(
        rows=1 + len(PANELS),
        cols=1,
        shared_xaxes=True,
        vertical_spacing=0.034,
        subplot_titles=["Wave elevation [m]", *(title for _, title in PANELS)],
    )
    time = np.asarray(ds["time"].values, dtype=np.float64)
    grid = few_points(time, POINTS)
    drawn = time if grid is None else grid.time

    def line(name: str) -> NDArray[np.float32]:
        """Values of all laws, or of all of the waves, in single precision."""
        values = np.asarray(ds[f"example_{name}"].values, dtype=np.float64)
        return np.asarray(values if grid is None else grid(values), dtype=np.float32)

    figure.add_scatter(
        x=drawn,
        y=line("elevation"),
        mode="lines",
        line={"color": REFERENCE_GREY, "width": 1.2},
        showlegend=False,
        hovertemplate="%{y:.3f} m<extra>elevation</extra>",
        row=1,
        col=1,
    )
    shown = _shown_first(evaluation)
    rows = {name: row for row, name in enumerate(layout.names(ds))}
    lines = {signal: line(signal) for signal, _ in PANELS}
    for law in evaluation.laws:
        style = styles[law.name]
        for row, (signal, _) in enumerate(PANELS, start=2):
            figure.add_scatter(
                x=drawn,
                y=lines[signal][rows[law.name]],
                mode="lines",
                line={"color": style.colour, "width": 1.4, "shape": "hv" if signal in ("cc", "cg") else "linear"},
                name=law.name,
                legendgroup=law.name,
                showlegend=row == 2,
                visible=True if law.name in shown else "legendonly",
                hovertemplate=f"%{{y:.3g}}<extra>{law.name}</extra>",
                row=row,
                col=1,
            )
    last = 1 + len(PANELS)
    usual = (time >= middle(time, STRETCH)[0]) & (time <= middle(time, STRETCH)[1])
    even = np.ptp(np.diff(time)) < 1e-6  # what is stored of a long run is its peaks but for the middle
    low, high = _usual_range(ds["example_load_share"].values[:, usual | even])
    figure.update_yaxes(range=[low, high], row=last, col=1)
    figure.update_xaxes(title_text="Time [s]", row=last, col=1)
    figure.update_yaxes(nticks=5)
    for row, (signal, _) in enumerate(PANELS, start=2):
        if signal in ("cc", "cg"):  # a constant signal would otherwise get an axis from -1 to 1
            figure.update_yaxes(range=_actuator_range(ds[f"example_{signal}"].values), row=row, col=1)
    for note in figure.layout.annotations:
        note.update(x=0, xanchor="left", font={"size": 12.5}, yshift=2)
    figure.update_xaxes(range=list(middle(time, STRETCH)))
    figure.update_layout(
        template=template(),
        height=110 + 122 * last,
        hovermode="x",
        legend={"y": 1.035, "yanchor": "bottom"},
        updatemenus=[_zoom_buttons(time, last)],
        margin_t=96,
    )
    return figure


def _shown_first(evaluation: Evaluation) -> set[str]:
    winner = judge(evaluation).winner or evaluation.by_power[0].name
    second = evaluation.reference if evaluation.reference not in (None, winner) else None
    others = [law.name for law in evaluation.by_power if law.name != winner]
    return {winner, second or (others[0] if others else winner)}


def _usual_range(values: NDArray[Any]) -> tuple[float, float]:
    """Range that leaves out the outermost 0.5 %: the load share divides by a rate that passes zero."""
    finite = values[np.isfinite(values)]
    low, high = (float(q) for q in np.quantile(finite, [0.005, 0.995])) if finite.size else (0.0, 1.0)
    low, high = min(low, 0.0), max(high, 1.0)
    return low - 0.05 * (high - low), high + 0.05 * (high - low)


def _actuator_range(values: NDArray[Any]) -> list[float]:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.1 * (high - low) or 1.0
    return [low - (margin if low < 0.0 else 0.25 * margin), high + margin]


def _zoom_buttons(time: NDArray[np.float64], rows: int) -> dict[str, Any]:
    from gyroctl.simulation.extremes import STRETCH, middle

    views = {
        "20 s": list(middle(time, 20.0)),
        "120 s": list(middle(time, STRETCH)),
        "whole run": [float(time[0]), float(time[-1])],
    }
    axes = [f"xaxis{k if k > 1 else ''}.range" for k in range(1, rows + 1)]
    return {
        "type": "buttons",
        "direction": "right",
        "showactive": False,  # plotly's highlight is a fixed near-white, unreadable on a dark page
        "x": 1.0,
        "xanchor": "right",
        "y": 1.035,
        "yanchor": "bottom",
        "pad": {"r": 0, "t": 0},
        "bgcolor": "rgba(128,138,148,0.12)",
        "bordercolor": "rgba(128,138,148,0.35)",
        "font": {"size": 12},
        "buttons": [
            {"label": label, "method": "relayout", "args": [{axis: view for axis in axes}]}
            for label, view in views.items()
        ],
    }
