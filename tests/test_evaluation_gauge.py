"""Table `gauge`: its levels, what is noted of a planner, and what is made of the runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.studies.evaluation import gauge as table
from gyroctl.studies.evaluation import request
from gyroctl.studies.evaluation.cases import Case
from gyroctl.studies.evaluation.foreseen import LEADS, Noting, forecast_error
from gyroctl.studies.evaluation.real_water import Water

Array = NDArray[np.float64]
SETTINGS = Settings(blend=10.0)


@dataclass(frozen=True)
class Seer:
    """Holds a pair; its memory tells a part of the moments that come, or those of `late` samples before."""

    part: float = 1.0
    late: int = 0
    period: float = 0.1
    information: str = "oracle"
    waves: Any = None

    def informed(self, waves: Any) -> Seer:
        return Seer(self.part, self.late, waves=waves)

    def init(self) -> Any:
        return 0

    def step(self, t: float, y: Any, state: int) -> Any:
        return (0.0582, 4e-4), state + 1

    def memory(self, state: int) -> Any:
        coming = self.waves.moments[:, ::2][:, max(state - self.late, 0) :][:, :40]
        return SimpleNamespace(ahead=self.part * np.pad(coming, ((0, 0), (0, 40 - coming.shape[1]))))


def case(device: gy.Plant) -> Case:
    return Case("linear", device, gy.SeaState(), SETTINGS)


@pytest.mark.parametrize(("part", "expected"), [(1.0, 0.0), (0.0, 1.0), (0.5, 0.25)])
def test_error_is_that_of_what_was_foreseen(device: gy.Plant, part: float, expected: float) -> None:
    seer: Any = Seer(part)
    found = forecast_error(case(device), seer, [100000, 100001], 400.0)
    assert found.shape == (2, len(LEADS))
    np.testing.assert_allclose(found, expected, atol=0.03)


def test_forecast_that_is_a_sample_late_is_found(device: gy.Plant) -> None:
    late: Any = Seer(late=1)
    assert np.all(forecast_error(case(device), late, [100000], 120.0) > 0.02)


def test_too_short_a_run_is_refused(device: gy.Plant) -> None:
    seer: Any = Seer()
    with pytest.raises(gy.InputError, match="duration"):
        forecast_error(case(device), seer, [100000], 60.0)


@pytest.mark.slow
def test_planner_goes_its_way_while_it_is_noted(device: gy.Plant) -> None:
    waves = lead_in(gy.realise(device, gy.SeaState(), 100000, 20.0), SETTINGS)
    law: Any = gy.law("nmpc", horizon=2.0)
    plain, _ = run_law(device, law, waves, SETTINGS)
    noting = Noting(law, (10, 20))
    noted, _ = run_law(device, noting, waves, SETTINGS)
    np.testing.assert_array_equal(plain.commands, noted.commands)
    assert np.array(noting.noted).shape == (200, 2, 2)


def test_levels_differ_in_what_is_seen_alone() -> None:
    for water in table.WATER:
        found = table.levels("nmpc", water)
        laws: dict[str, Any] = {name: entrant.build() for name, entrant in found.items()}
        assert [law.information for law in laws.values()] == ["sensors", "gauge", "gauge", "gauge", "oracle"]
        assert [laws[table.at_distance(d)].gauge.distance for d in table.DISTANCES] == list(table.DISTANCES)
        designs = {law.plant.name for law in laws.values()}
        assert len(designs) == 1 and ("realistic" in designs.pop()) == (water.name != "linear")


@pytest.mark.slow
def test_table_tells_what_the_gauge_is_worth(tmp_path: Path) -> None:
    ask = request(tmp_path, seeds=["100000:100001"], duration=260.0, allow_tuning_seeds=True, quiet=True)
    content, text, figure = table.gauge_table(ask, (Water("linear", {}),))
    lines = {line["level"]: line for line in content["cases"]["linear"]}
    assert list(lines) == ["none", *table.levels("nmpc", table.WATER[1])]
    far = lines[table.at_distance(10.0)]
    assert far["information"] == "gauge"
    assert far["of_oracle"].value == pytest.approx(far["power"].value / lines[table.ORACLE]["power"].value, rel=0.02)
    assert far["power"].value > lines[table.SENSORS]["power"].value
    for name in table.ERRORS:
        assert lines[table.ORACLE]["error"][name] == 0.0
        assert far["error"][name] < 0.3 * lines[table.SENSORS]["error"][name]
    assert content["bar"]["linear"]["met"] and content["bar"]["linear"]["found"] == far["of_oracle"]
    assert "gauge at 10 m" in text and len(figure.axes) == 3
