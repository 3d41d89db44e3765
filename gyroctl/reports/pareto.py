"""The Pareto plot: power against smoothness, with the probability of lock as colour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gyroctl.reports import layout
from gyroctl.reports.evaluation import Evaluation, LawResult
from gyroctl.reports.labels import Box, Side, place
from gyroctl.reports.theme import LOCK_SCALE, REFERENCE_GREY, error_bars, finished, law_styles
from gyroctl.reports.wording import interval, sees

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr


def pareto(ds: xr.Dataset, evaluation: Evaluation) -> go.Figure:
    """Mean power [W] against power CV [1], colour P(lock), bars the 95 % intervals; best is top left."""
    import plotly.graph_objects as go

    laws = plottable(evaluation)
    right, top = pareto_range(laws)
    styles = law_styles(layout.names(ds), evaluation.reference)
    figure = go.Figure()
    front = _front(laws)
    if len(front) > 1:
        figure.add_scatter(
            x=[law.power_cv.value for law in front],
            y=[law.power.value for law in front],
            mode="lines",
            line={"color": REFERENCE_GREY, "width": 1.2, "dash": "dot"},
            name="front",
            hoverinfo="skip",
        )
    for law, side in zip(laws, pareto_labels(laws, right, top), strict=True):
        figure.add_scatter(
            x=[law.power_cv.value],
            y=[law.power.value],
            error_x=error_bars([law.power_cv]),
            error_y=error_bars([law.power]),
            mode="markers+text",
            marker={
                "size": 15,
                "symbol": styles[law.name].symbol.replace("-open", ""),
                "color": [law.lock.value],
                "coloraxis": "coloraxis",
                "line": {"color": "#FFFFFF", "width": 1.5},
            },
            text=[f"<b>{law.name}</b>" if law.name != evaluation.reference else law.name],
            textposition=side.plotly,
            name=law.name,
            cliponaxis=False,
            hovertemplate=f"<b>{law.name}</b> ({sees(law.information, law.preview)})"
            f"<br>power %{{y:.3g}} W ({interval(law.power)})<br>CV %{{x:.3g}} ({interval(law.power_cv)})"
            f"<br>lock {law.locked}/{law.runs} ({interval(law.lock, 2)})<extra></extra>",
        )
    figure.update_layout(
        showlegend=False,
        coloraxis={
            "cmin": 0,
            "cmax": 1,
            "colorscale": LOCK_SCALE,
            "colorbar": {
                "title": {"text": "P(lock) [1]", "side": "right", "font": {"size": 13}},
                "thickness": 12,
                "outlinewidth": 0,
                "len": 0.9,
            },
        },
        margin_t=20,
    )
    figure.update_xaxes(title_text="Coefficient of variation of power [1]  (← smoother)", range=[0, right])
    figure.update_yaxes(title_text="Mean power [W]", range=[0, top])
    return finished(figure, 460)


def plottable(evaluation: Evaluation) -> list[LawResult]:
    """Laws with a finite mean power and power CV, most power first."""
    return [law for law in evaluation.by_power if math.isfinite(law.power.value) and math.isfinite(law.power_cv.value)]


def pareto_range(laws: Sequence[LawResult]) -> tuple[float, float]:
    """Choose the ends of the CV axis [1] and of the power axis [W], with room for names."""
    right = max((e.high if math.isfinite(e.high) else e.value for e in (law.power_cv for law in laws)), default=1.0)
    top = max((e.high if math.isfinite(e.high) else e.value for e in (law.power for law in laws)), default=1.0)
    return 1.1 * max(right, 1e-9), 1.14 * max(top, 1e-9)


def pareto_labels(laws: Sequence[LawResult], right: float, top: float) -> list[Side]:
    """Side on which to write the name of each law in the Pareto plot."""
    points = [(law.power_cv.value / right, law.power.value / top) for law in laws]
    bars = []
    for (x, y), law in zip(points, laws, strict=True):
        cv, power = law.power_cv, law.power
        if math.isfinite(cv.high):
            bars.append(Box(cv.low / right, cv.high / right, y - 0.008, y + 0.008))
        if math.isfinite(power.high):
            bars.append(Box(x - 0.004, x + 0.004, power.low / top, power.high / top))
    return place(points, [law.name for law in laws], bars)


def _front(laws: Sequence[LawResult]) -> list[LawResult]:
    """Laws that no other law beats in both power and smoothness, smoothest first."""
    front = [
        law
        for law in laws
        if not any(
            o.power.value >= law.power.value and o.power_cv.value <= law.power_cv.value and o is not law for o in laws
        )
    ]
    return sorted(front, key=lambda law: law.power_cv.value)
