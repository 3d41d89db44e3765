"""The example realisation in time: a picture of its middle, and all of it for those who want to look closer."""

from __future__ import annotations

import base64
import gzip
import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports import layout
from gyroctl.reports.canvas import Drawing, Key, Paper, Room, panels
from gyroctl.reports.evaluation import Evaluation
from gyroctl.reports.panel import Line, Mark, Panel, Scale, held
from gyroctl.reports.theme import REFERENCE_GREY, law_styles
from gyroctl.reports.verdict import judge
from gyroctl.reports.wording import listed, number
from gyroctl.statistics import finite_mean

if TYPE_CHECKING:
    import xarray as xr

PANELS = (
    ("power", "Electrical power [W]"),
    ("ring_speed", "Ring speed [rad/s]"),
    ("phi1", "φ₁, horizontal motion [rad]"),
    ("phi3", "φ₃, vertical motion [rad]"),
    ("cc", "Coupling coefficient cc [Nms]"),
    ("cg", "Generator coefficient cg [Nms]"),
    ("load_share", "Load share [1], linear up to 1"),
)
POINTS = 2000
"""Most points of a line: two a pixel or so over the whole run, and the first view sample by sample."""

LEVELS = 65534
"""Steps into which the range of a line is parted where it is stored for a closer look: more than a screen has."""

UNKNOWN = 65535
"""What stands for no number there."""

VIEW = {True: 60.0, False: 120.0}
"""Seconds of the picture, on a telephone and on a desk."""


def time_series(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """Elevation, power, ring speed, motion, actuators and load share of the first realisation, over time [s].

    The winner and the reference, in the middle of the run. The load share has every value: its axis is linear up to 1
    and logarithmic beyond.

    Raises
    ------
    ValueError
        The dataset holds no example time series.
    """
    from gyroctl.simulation.extremes import middle  # its room loads SciPy

    if not layout.has_examples(ds):
        raise ValueError("the dataset holds no example time series")
    time = np.asarray(ds["time"].values, dtype=np.float64)
    begin, end = middle(time, VIEW[paper.narrow])
    inside = (time >= begin) & (time <= end)
    styles = law_styles(layout.names(ds), evaluation.reference)
    chosen = shown_first(evaluation)
    x = Scale(begin, end, "Time [s]")
    elevation = np.asarray(ds["example_elevation"].values[inside], dtype=np.float64)
    found = [Panel(x, _about([elevation]), [Line(time[inside], elevation, REFERENCE_GREY, 1.2)], "Wave elevation [m]")]
    for signal, title in PANELS:
        stored = ds[f"example_{signal}"]
        rows = [np.asarray(stored.sel(law=name).values[inside], dtype=np.float64) for name in chosen]
        steps = signal in ("cc", "cg")
        ends = [held(time[inside], row) if steps else (time[inside], row) for row in rows]
        drawn: list[Line | Mark] = [
            Line(*line, styles[name].colour, 1.3) for name, line in zip(chosen, ends, strict=True)
        ]
        y = _actuator_range(stored.values) if steps else _about(rows)
        if signal == "load_share":
            y, drawn = _beyond_one(rows), [*drawn, Mark(1.0, REFERENCE_GREY, 1.0, level=True)]
        found.append(Panel(x, y, drawn, title))
    sheet = panels(paper, 92.0, found, Room(left=56.0, top=24.0, down=36.0))
    powers = [f"{name} {number(finite_mean(ds['example_power'].sel(law=name).values))} W" for name in chosen]
    alt = (
        f"Wave elevation, power, ring speed, motion, coefficients and load share of {listed(chosen)} from "
        f"{begin:g} to {end:g} s. Mean electrical power over the whole run: {'; '.join(powers)}."
    )
    return Drawing(sheet, alt, tuple(Key(name, styles[name].colour, "solid") for name in chosen))


def closer_look(ds: xr.Dataset, evaluation: Evaluation) -> dict[str, Any]:
    """All laws over the whole run, for the part of the page that is drawn on request.

    Returns
    -------
    dict
        ``text``: base64 of gzip of the lines as 16-bit numbers, each in `LEVELS` steps of its own range; ``head``: what
        they are, with the ends of each range. A line has at most `POINTS` points: every sample of 120 s in the middle,
        and beside them the least and the greatest value of every few seconds. All lines have the same times.
    """
    from gyroctl.simulation.extremes import few_points, middle

    styles = law_styles(layout.names(ds), evaluation.reference)
    time = np.asarray(ds["time"].values, dtype=np.float64)
    grid = few_points(time, POINTS)
    names = [law.name for law in evaluation.laws]
    lines, ranges = list[NDArray[np.uint16]](), list[list[float]]()
    for signal in ("elevation", *(signal for signal, _ in PANELS)):
        values = np.atleast_2d(np.asarray(ds[f"example_{signal}"].values, dtype=np.float64))
        rows = values if signal == "elevation" else values[[layout.names(ds).index(name) for name in names]]
        for row in rows if grid is None else grid(rows):
            steps, ends = in_steps(row)
            lines.append(steps)
            ranges.append(ends)
    packed = gzip.compress(np.stack(lines).astype("<u2").tobytes(), 9, mtime=0)
    head = {
        "time": [round(float(t), 3) for t in (time if grid is None else grid.time)],
        "laws": names,
        "colours": [styles[name].colour for name in names],
        "first": shown_first(evaluation),
        "panels": [list(panel) for panel in PANELS],
        "ranges": ranges,
        "levels": LEVELS,
        "view": list(middle(time, VIEW[False])),
    }
    return {"head": head, "text": base64.b64encode(packed).decode("ascii")}


def in_steps(values: NDArray[np.float64]) -> tuple[NDArray[np.uint16], list[float]]:
    """Line as steps of its own range, and the ends of that; the ends themselves are kept."""
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    steps = np.full(values.size, UNKNOWN, dtype=np.uint16)
    inside = np.isfinite(values)
    steps[inside] = np.round((values[inside] - low) / ((high - low) or 1.0) * LEVELS).astype(np.uint16)
    return steps, [low, high]


def script_safe(value: Any) -> str:
    """JSON that cannot end the script element it stands in, whatever a law is called."""
    text = json.dumps(value, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def shown_first(evaluation: Evaluation) -> list[str]:
    """Winner and reference, or what stands in for them."""
    winner = judge(evaluation).winner or evaluation.by_power[0].name
    second = evaluation.reference if evaluation.reference not in (None, winner) else None
    others = [law.name for law in evaluation.by_power if law.name != winner]
    return list(dict.fromkeys([winner, second or (others[0] if others else winner)]))


def _about(rows: Sequence[NDArray[np.float64]]) -> Scale:
    """Scale with some room about the values."""
    low, high = _ends(np.concatenate(rows))
    room = 0.05 * (high - low) or 0.05 * abs(high) or 0.05
    return Scale(low - room, high + room, "")


def _beyond_one(rows: Sequence[NDArray[np.float64]]) -> Scale:
    """Scale of a load share: linear up to 1, logarithmic beyond, so that every value has its place."""
    most = max(_ends(np.concatenate(rows))[1], 10.0)
    top = 10.0 ** math.ceil(math.log10(most) - 1e-9)
    ticks = [0.0, 0.5, 1.0, *(10.0**k for k in range(1, round(math.log10(top)) + 1))]
    shown = ticks if len(ticks) <= 5 else [0.0, 1.0, *ticks[3 :: max(1, (len(ticks) - 3) // 2)]]
    return Scale(0.0, top, "", "log beyond 1", tuple(shown))


def _actuator_range(values: NDArray[Any]) -> Scale:
    """Scale with zero in it: a constant signal would otherwise get an axis about itself."""
    low, high = _ends(values)
    low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.1 * (high - low) or 1.0
    return Scale(low - (margin if low < 0.0 else 0.25 * margin), high + margin, "")


def _ends(values: NDArray[Any]) -> tuple[float, float]:
    """Least and greatest of the finite values, zeros where there are none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
