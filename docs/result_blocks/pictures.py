"""Pictures of the pages, drawn from the committed results; each holds the hash of what it was drawn from and by."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation.rows import Row
from result_blocks.source import result
from result_blocks.speed import draw_growth

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KEY = "Results"
"""Name of the entry of a PNG that holds the hash."""

LOOK = ("gyroctl/palette.py", "gyroctl/plots/style.py")
"""Code that all pictures are drawn by: colours and style."""


class Picture(NamedTuple):
    """A picture: the results that it shows, how it is drawn, and the file with the code that draws."""

    source: str
    figure: Callable[[], Figure]
    code: str

    def draw(self, path: Path, key: str) -> None:
        """Write the picture with its key."""
        from gyroctl.studies.style import styled

        with styled():
            self.figure().savefig(path, format="png", metadata={"Software": "gyroctl", KEY: key})


def key_of(path: Path) -> str:
    """Hash of what a picture was drawn from, empty where it says none."""
    from PIL import Image

    with Image.open(path) as image:
        return str(image.info.get(KEY, ""))


def row_of(record: Mapping[str, Any]) -> Row:
    """A row of a table from what is kept of it; what is not kept is NaN."""
    values = {field.name: record.get(field.name, math.nan) for field in fields(Row)}
    for name in ("power", "cv", "ratio", "lock", "step", "cv_1s", "difference"):
        values[name] = _estimate(record.get(name))
    return Row(**{name: math.nan if value is None else value for name, value in values.items()})


def _estimate(record: Mapping[str, Any] | None) -> Estimate:
    if record is None:
        return Estimate(math.nan, math.nan, math.nan)
    value, low, high = (math.nan if record[key] is None else record[key] for key in ("value", "low", "high"))
    return Estimate(value, low, high, record["note"])


def _seas() -> Figure:
    from gyroctl.studies.evaluation.draw import draw_seas

    found = result("seas")
    tables = {float(sea.removeprefix("gamma")): [row_of(row) for row in rows] for sea, rows in found["seas"].items()}
    return draw_seas(tables, found["request"])


def _physics() -> Figure:
    from gyroctl.studies.evaluation.draw_physics import draw_physics
    from gyroctl.studies.evaluation.physics_cells import Cell

    found, unused = result("physics"), _estimate(None)
    tables = {
        case: {row["law"]: Cell(row_of(row), math.nan, math.nan, math.nan, unused, unused) for row in rows}
        for case, rows in found["cases"].items()
    }
    return draw_physics(tables, found["request"])


def _price() -> Figure:
    from gyroctl.studies.evaluation.draw_price import draw_price

    found = result("price")
    estimates = ("power", "cv", "change", "seen")
    steps = [
        {**step, **{name: None if step[name] is None else _estimate(step[name]) for name in estimates}}
        for step in found["steps"]
    ]
    return draw_price(steps, found["request"])


def _gauge() -> Figure:
    from gyroctl.studies.evaluation.draw_gauge import draw_gauge

    found = result("gauge")
    cases = {
        case: [{**line, "power": _estimate(line["power"]), "cv": _estimate(line["cv"])} for line in lines]
        for case, lines in found["cases"].items()
    }
    return draw_gauge(cases, found["request"])


def _forecast() -> Figure:
    from gyroctl.studies.forecast.draw import draw
    from gyroctl.studies.forecast.skill import Skill

    found = result("forecast")
    skills = {
        sea: Skill(
            np.array([np.array(rows, float) for rows in sources.values()]),
            np.zeros((2, 2)),
            np.zeros((2, 2, 0)),
            np.zeros((0, 0, 2, 0)),
        )
        for sea, sources in found["error"].items()
    }
    return draw(skills, found["note"])


def _water() -> Figure:
    from gyroctl.statistics import Share
    from gyroctl.studies.margins.drag_lock import Counted, Curve, DragLock
    from gyroctl.studies.margins.draw_water import water
    from gyroctl.studies.margins.water import ChoiceMargins

    found = result("margins_water")
    kept, asked = found["water"], found["request"]
    choices = {
        name: ChoiceMargins(**{key: math.nan if value is None else value for key, value in one.items()})
        for name, one in kept["choices"].items()
    }
    drag = kept["drag_that_locks"]
    curves = tuple(Curve(line["over"], np.array(line["at"]), np.array(line["drag"])) for line in drag["curves"])
    counted = [
        Counted(run["drag"], Share(run["locked"] / run["runs"], *run["ci95"], run["runs"]), run["in_step"], math.nan)
        for run in kept["sea"]["runs"]
    ]
    wave, controls = asked["wave"], asked["controls"]
    point = f"wave of {wave['height_m']:g} m at {wave['wp_rad_s']:g} rad/s; "
    point += f"cc = {controls['cc_nms']:g}, cg = {controls['cg_nms']:g} Nms"
    return water(choices, DragLock(**{**drag, "curves": curves}), counted, point)


def _connection() -> Figure:
    from gyroctl.studies.connection import answer_of, draw

    return draw(answer_of(result("connection")))


_EVALUATION = "studies/evaluation"

PICTURES: Mapping[str, Picture] = {
    "docs/seas.png": Picture("docs/results/seas.json", _seas, f"{_EVALUATION}/draw.py"),
    "docs/physics.png": Picture("docs/results/physics.json", _physics, f"{_EVALUATION}/draw_physics.py"),
    "docs/price.png": Picture("docs/results/price.json", _price, f"{_EVALUATION}/draw_price.py"),
    "docs/gauge.png": Picture("docs/results/gauge.json", _gauge, f"{_EVALUATION}/draw_gauge.py"),
    "docs/forecast.png": Picture("docs/results/forecast.json", _forecast, "studies/forecast/draw.py"),
    "docs/margins_water.png": Picture("docs/results/margins_water.json", _water, "studies/margins/draw_water.py"),
    "docs/connection.png": Picture("docs/results/connection.json", _connection, "studies/connection/draw.py"),
    "docs/growth.png": Picture("benchmarks/growth.json", draw_growth, "docs/result_blocks/speed.py"),
}
