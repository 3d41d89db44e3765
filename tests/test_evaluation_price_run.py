"""Table `price` with the planner itself, in the linear plant and in real water alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from gyroctl.studies.evaluation import price_steps, request
from gyroctl.studies.evaluation.price import LAW, TOLD, WATER, price_table
from gyroctl.studies.evaluation.real_water import LINEAR


@pytest.mark.slow
def test_planner_wins_back_in_the_water_what_it_lost_there(tmp_path: Path) -> None:
    chain = price_steps.waters()
    ask = request(tmp_path, seeds=["100000:100001"], duration=260.0, allow_tuning_seeds=True, quiet=True)
    content, text, figure = price_table(ask, (chain[0], chain[-1]))
    steps = {step["step"]: step for step in content["steps"]}
    assert list(steps) == [LINEAR, chain[-1].name, *price_steps.CHOICES, price_steps.ORACLE]
    whole = content["totals"]
    assert whole[WATER]["change"].value < -5.0 and whole[LAW]["change"].value > 3.0
    assert whole[TOLD]["change"].value > 0.0 and whole["in all"]["change"].value < 0.0
    assert steps[price_steps.ORACLE]["information"] == "oracle"
    assert steps[price_steps.TOLD]["locked"] == 2 and "perfect preview" in text and len(figure.axes) == 3
