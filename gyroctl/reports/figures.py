"""Figures of the ensemble: one function a figure, each from the dataset and its evaluation to a plotly figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.reports import layout
from gyroctl.reports.evaluation import Evaluation
from gyroctl.reports.theme import FLOWS, REFERENCE_GREY, WARNING, error_bars, finished, law_styles
from gyroctl.reports.verdict import judge
from gyroctl.reports.wording import interval, number, signed
from gyroctl.statistics import NOT_DISTINGUISHABLE

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr

MOST_PAIRS = 15
MOST_LINES = 64
LOST = {"size": 8, "symbol": "x-thin-open", "color": WARNING, "line": {"width": 2}}
MEAN = {"size": 13, "symbol": "line-ew-open", "color": REFERENCE_GREY, "line": {"width": 2.5}}


def power_per_realisation(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """Mean power [W] of every run, lines joining the same realisation; runs that lost lock are open and red."""
    import plotly.graph_objects as go

    laws, styles = evaluation.by_power, law_styles(layout.names(ds), evaluation.reference)
    ranked = ds.sel(law=[law.name for law in laws])
    power, locked = layout.values(ranked, "mean_power"), layout.values(ranked, "locked").astype(bool)
    figure = go.Figure()
    shift = _spread(len(evaluation.seeds))
    for column in range(min(shift.size, MOST_LINES)):
        figure.add_scatter(
            x=np.arange(len(laws)) + shift[column],
            y=power[:, column],
            mode="lines",
            line={"color": REFERENCE_GREY, "width": 0.7},
            opacity=0.35,
            hoverinfo="skip",
            showlegend=False,
        )
    for index, law in enumerate(laws):
        held = {"size": 8, "color": styles[law.name].colour, "opacity": 0.85}
        for chosen, kind, marker in ((locked[index], "held lock", held), (~locked[index], "lost lock", LOST)):
            if chosen.any():
                figure.add_scatter(
                    x=index + shift[chosen],
                    y=power[index, chosen],
                    mode="markers",
                    marker=marker,
                    customdata=[str(evaluation.seeds[k]) for k in np.flatnonzero(chosen)],
                    hovertemplate=f"{law.name}, seed %{{customdata}}<br>%{{y:.3g}} W, {kind}<extra></extra>",
                    showlegend=False,
                )
        figure.add_scatter(
            x=[index + 0.36],
            y=[law.power.value],
            error_y=error_bars([law.power]),
            mode="markers",
            marker=MEAN,
            hovertemplate=f"{law.name}: mean %{{y:.3g}} W ({interval(law.power)})<extra></extra>",
            showlegend=False,
        )
    if not locked.all():
        figure.add_scatter(x=[None], y=[None], mode="markers", name="lost lock", marker=LOST)
    figure.add_scatter(x=[None], y=[None], mode="markers", name="mean and 95 % interval", marker=MEAN)
    figure.update_layout(showlegend=True, margin_b=36)
    ticks = {"tickvals": list(range(len(laws))), "ticktext": [law.name for law in laws]}
    figure.update_xaxes(**ticks, showgrid=False, range=[-0.5, len(laws) - 0.4], zeroline=False)
    figure.update_yaxes(title_text="Mean power of a run [W]", rangemode="tozero")
    return finished(figure, 440)


def survival(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """Kaplan-Meier probability that lock still holds [1] over time [s], with 95 % bands where they stay legible."""
    import plotly.graph_objects as go

    styles = law_styles(layout.names(ds), evaluation.reference)
    figure = go.Figure()
    banded = _banded(evaluation)
    for law in evaluation.by_power:
        curve, style = law.survival, styles[law.name]
        known = np.isfinite(curve.low) & np.isfinite(curve.high)
        if known.any() and law.name in banded:
            x, high = _stairs(curve.time[known], curve.high[known])
            _, low = _stairs(curve.time[known], curve.low[known])
            figure.add_scatter(
                x=np.concatenate([x, x[::-1]]),
                y=np.concatenate([high, low[::-1]]),
                fill="toself",
                fillcolor=_faded(style.colour, 0.12),
                line={"width": 0},
                mode="lines",
                hoverinfo="skip",
                legendgroup=law.name,
                showlegend=False,
            )
        figure.add_scatter(
            x=curve.time,
            y=curve.probability,
            mode="lines",
            line={"shape": "hv", "width": 2.4, "color": style.colour, "dash": style.dash},
            name=f"{law.name}  {law.locked}/{law.runs}",
            legendgroup=law.name,
            hovertemplate=f"{law.name}<br>after %{{x:.0f}} s: %{{y:.2f}}<extra></extra>",
        )
    figure.update_xaxes(title_text="Time [s]", range=[0, evaluation.duration])
    figure.update_yaxes(title_text="P(lock still holds) [1]", range=[-0.02, 1.04])
    return finished(figure, 400)


def motion(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """98 % quantile of |phi1| and |phi3| [rad] of every run against the motion limit."""
    from plotly.subplots import make_subplots

    laws, styles = evaluation.by_power, law_styles(layout.names(ds), evaluation.reference)
    names = [law.name for law in laws]
    figure = make_subplots(rows=1, cols=2, shared_yaxes=True, horizontal_spacing=0.04)
    panels = ("phi1_p98", "|φ<sub>1</sub>|, horizontal"), ("phi3_p98", "|φ<sub>3</sub>|, vertical")
    for column, (variable, title) in enumerate(panels, start=1):
        values = layout.values(ds.sel(law=names), variable)
        for index, law in enumerate(laws):
            over = values[index] > evaluation.motion_limit
            figure.add_scatter(
                x=values[index],
                y=index + _spread(values.shape[1]),
                mode="markers",
                marker={
                    "size": 7,
                    "opacity": 0.8,
                    "color": [WARNING if flag else styles[law.name].colour for flag in over],
                    "symbol": ["x" if flag else "circle" for flag in over],
                },
                customdata=[str(seed) for seed in evaluation.seeds],
                hovertemplate=f"{law.name}, seed %{{customdata}}<br>%{{x:.3f}} rad<extra></extra>",
                showlegend=False,
                row=1,
                col=column,
            )
        limit, axis = evaluation.motion_limit, "" if column == 1 else column
        figure.add_vline(x=limit, line={"color": WARNING, "width": 1.5, "dash": "dash"}, row=1, col=column)
        figure.add_annotation(
            x=limit,
            y=1.0,
            xref=f"x{axis}",
            yref=f"y{axis} domain",
            text=f"limit {limit:g}",
            showarrow=False,
            yanchor="bottom",
            font={"color": WARNING, "size": 12},
        )
        widest = max(float(np.nanmax(values, initial=0.0)), limit)
        figure.update_xaxes(title_text=f"{title}: 98 % quantile [rad]", range=[0, 1.08 * widest], row=1, col=column)
    figure.update_yaxes(**_rows(names))
    return finished(figure, 130 + 52 * len(laws))


def paired_forest(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """Paired differences in mean power [W] with 95 % intervals; grey where the two laws are not distinguishable."""
    import plotly.graph_objects as go

    drawn = {law.name for law in evaluation.laws}
    known = (d for d in evaluation.power_differences if drawn.issuperset((d.first, d.second)))
    pairs = [d for d in known if math.isfinite(d.estimate.value)]
    if len(pairs) > MOST_PAIRS:
        centre = evaluation.reference or evaluation.by_power[0].name
        pairs = [d for d in pairs if centre in (d.first, d.second)]
    figure = go.Figure()
    looks = (
        ("distinguishable", "#0072B2", "square"),
        ("not distinguishable, or no interval", REFERENCE_GREY, "square-open"),
    )
    for apart, (name, colour, symbol) in zip((True, False), looks, strict=True):
        rows = {k: d for k, d in enumerate(pairs) if (d.words in ("more", "less")) is apart}
        if rows:
            figure.add_scatter(
                x=[d.estimate.value for d in rows.values()],
                y=list(rows),
                error_x=error_bars([d.estimate for d in rows.values()], colour=colour, width=1.8),
                mode="markers",
                marker={"size": 10, "color": colour, "symbol": symbol, "line": {"width": 2, "color": colour}},
                name=name,
                customdata=[[interval(d.estimate) or d.estimate.note, number(d.p_holm, 2)] for d in rows.values()],
                hovertemplate="%{x:.3g} W (%{customdata[0]})<br>Holm-corrected p = %{customdata[1]}<extra></extra>",
            )
    figure.add_vline(x=0, line={"color": REFERENCE_GREY, "width": 1.2})
    figure.update_layout(showlegend=True)
    figure.update_xaxes(title_text="Paired difference in mean power [W]", zeroline=False)
    figure.update_yaxes(**_rows([f"{d.first} − {d.second}" for d in pairs]))
    for k, pair in enumerate(pairs):
        words = f"{signed(pair.estimate.value)} W" if pair.words in ("more", "less") else NOT_DISTINGUISHABLE
        words = words if math.isfinite(pair.p_holm) else "no interval"
        figure.add_annotation(x=1.01, xref="paper", y=k, text=words, showarrow=False, xanchor="left", font={"size": 12})
    figure.update_layout(margin_r=140)
    return finished(figure, 130 + 32 * len(pairs))


def energy(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """Where the energy of the waves goes: mean power flows [W] stacked per law, wave input marked."""
    import plotly.graph_objects as go

    laws = evaluation.by_power
    rows = list(range(len(laws)))
    figure = go.Figure()
    for name, colour in FLOWS.items():
        figure.add_bar(
            x=[law.flows[name] for law in laws],
            y=rows,
            orientation="h",
            name=name,
            width=0.56,
            marker={"color": colour, "line": {"width": 0}},
            hovertemplate=f"{name} %{{x:.3g}} W<extra></extra>",
        )
    figure.add_scatter(
        x=[law.wave_input_w for law in laws],
        y=rows,
        mode="markers",
        name="wave input",
        marker={"symbol": "line-ns-open", "size": 30, "color": REFERENCE_GREY, "line": {"width": 2.5}},
        hovertemplate="wave input %{x:.3g} W<extra></extra>",
    )
    figure.update_layout(barmode="relative", legend_traceorder="normal")
    ends = [law.wave_input_w for law in laws] + [sum(max(w, 0.0) for w in law.flows.values()) for law in laws]
    starts = [sum(min(w, 0.0) for w in law.flows.values()) for law in laws]
    right = 1.04 * max([end for end in ends if math.isfinite(end)], default=1.0)
    figure.update_xaxes(title_text="Mean power [W]", range=[_lowest(starts), right])
    figure.update_yaxes(**_rows([law.name for law in laws]))
    return finished(figure, 130 + 46 * len(laws))


def _rows(names: Sequence[str]) -> dict[str, Any]:
    """Vertical axis with a name in each row, the first on top."""
    ticks = {"tickvals": list(range(len(names))), "ticktext": list(names)}
    return {**ticks, "range": [len(names) - 0.5, -0.5], "showgrid": False, "zeroline": False}


def _banded(evaluation: Evaluation) -> set[str]:
    """Laws with a survival band: with more than three laws only the reference and the best, or nothing is legible."""
    if len(evaluation.laws) <= 3:
        return {law.name for law in evaluation.laws}
    winner = judge(evaluation).winner or evaluation.by_power[0].name
    return {winner, evaluation.reference or winner}


def _lowest(starts: Sequence[float]) -> float:
    """Left end of the energy axis: zero, unless a stack goes visibly below."""
    lowest = min([start for start in starts if math.isfinite(start)], default=0.0)
    return 1.1 * lowest if lowest < -0.1 else 0.0


def _spread(count: int) -> np.ndarray:
    """Sideways shifts that part equal values: a low-discrepancy sequence, so that the picture never changes."""
    return 0.36 * ((np.arange(count) * 0.6180339887498949) % 1.0 - 0.5) if count > 1 else np.zeros(1)


def _stairs(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.repeat(time, 2)[1:], np.repeat(values, 2)[:-1]


def _faded(colour: str, alpha: float) -> str:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return f"rgba({red},{green},{blue},{alpha})"
