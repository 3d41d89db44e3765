"""Tables and figures of an evaluation as they are read: columns no wider than numbers, titles whole, nothing hidden."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from test_evaluation_verdicts import made

from gyroctl.statistics import Estimate, bootstrap_mean, paired_ratio
from gyroctl.studies.evaluation.draw import draw_offdesign, draw_robustness
from gyroctl.studies.evaluation.page import in_html
from gyroctl.studies.evaluation.rows import Row
from gyroctl.studies.evaluation.writing import markdown_table, with_interval

ASKED: dict[str, Any] = {"own_seeds": {}, "duration_s": 300.0, "seeds": [1, 2, 3, 4]}
SCATTERED = bootstrap_mean([0.1, 0.1, 0.2, 9.0, 0.1])
UNTOLD = paired_ratio([1.0, 2.0, 1.0, 2.0], [-3.0, 4.0, -2.0, 2.0])


def test_what_an_interval_leaves_out_stands_below_the_table_once() -> None:
    scattered, untold = with_interval(SCATTERED), with_interval(UNTOLD)
    assert scattered.endswith(")†") and untold == "6.00‡" and len(scattered) < 25
    table, *told = markdown_table(["law", "power [W]"], [["a", scattered], ["b", scattered], ["c", "1.0"]]).split(
        "\n\n"
    )
    assert len(table.splitlines()) == 5 and told == [f"† {SCATTERED.note}."]
    *_, last = markdown_table(["law", "ratio"], [["a", scattered], ["b", untold]]).split("\n\n")
    assert last == f"‡ {UNTOLD.note}."
    assert "\n\n" not in markdown_table(["law", "ratio"], [["a", with_interval(bootstrap_mean([1.0, 1.1, 0.9, 1.0]))]])
    assert in_html(markdown_table(["law", "ratio"], [["a", untold]]), "t").count("<p>") == 1
    missing = bootstrap_mean([1.0, 1.1, 0.9, 1.0, math.nan])
    assert "1 of 5 values not finite" in with_interval(missing), "how many it is stays with the number"


def offdesign(ratio: Estimate) -> Any:
    first = {"good": made("good", ratio=ratio), "best_constant": made("best_constant")}
    second = {"good": made("good"), "best_constant": made("best_constant")}
    return draw_offdesign({"significant height": [("0.15 m", first), ("0.2 m", second)]}, ASKED)


def test_ratio_to_next_to_nothing_hides_no_other() -> None:
    for ratio, top in ((UNTOLD, 1.5), (Estimate(6.0, 4.0, 8.0), 8.0)):
        figure = offdesign(ratio)
        above = figure.axes[0]
        drawn = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in above.lines])
        words = " ".join(text.get_text() for text in figure.findobj(lambda one: hasattr(one, "get_text")))
        assert (np.nanmax(drawn) == 6.0) == (top > 2.0) and (above.get_ylim()[1] < 2.0) == (top < 2.0)
        assert ("told from zero" in words) == (top < 2.0)


@pytest.mark.parametrize("many", [1, 2, 4])
def test_titles_of_the_maps_are_whole(many: int) -> None:
    laws = [f"law_{number}" for number in range(many)]
    tables: dict[str, dict[str, Row]] = {f"case {k}": {law: made(law) for law in laws} for k in range(5)}
    kept = {name: {law: Estimate(1.0, 1.0, 1.0) for law in laws} for name in tables}
    figure = draw_robustness(tables, kept, ASKED, "Faults and other devices in real water")
    figure.canvas.draw()
    first, second = (axis.title.get_window_extent() for axis in figure.axes)
    assert first.x1 < second.x0 and second.x1 <= figure.bbox.x1
