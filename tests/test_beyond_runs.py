"""Runs beyond the linear model: the ledger with every choice, equal bits in any company, refusals."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.plant.equations import PHI1_RATE, PHI3_RATE
from gyroctl.simulation.ensemble import run_ensemble
from gyroctl.simulation.metrics import evaluate

SEA = gy.SeaState(gamma=5.0)
CHOICES: dict[str, dict[str, Any]] = {
    "position": {"position": "moving"},
    "drag": {"drag": 0.5},
    "curve": {"coupling_slip": 60.0, "coupling_cap": 2.0},
    "losses": {"bearing": 0.02, "windage": 9.1e-7, "rolling_resistance": 2e-5},
}
ALL = {name: value for choice in CHOICES.values() for name, value in choice.items()}


@pytest.fixture(scope="module")
def linear() -> gy.Plant:
    return gy.zhang2017()


@pytest.fixture(scope="module")
def waves(linear: gy.Plant) -> gy.WaveRealisation:
    return gy.realise(linear, SEA, 1, 600.0)


@pytest.fixture(scope="module", params=[*CHOICES, "all"])
def plant(request: pytest.FixtureRequest) -> gy.Plant:
    return gy.zhang2017(**CHOICES.get(request.param, ALL))


# --- runs --------------------------------------------------------------------------------------------------------


def test_ledger_closes_with_every_choice_and_all(plant: gy.Plant, linear: gy.Plant, waves: gy.WaveRealisation) -> None:
    """Over 600 s to 1e-6 of the wave input; the wave input stays the work of the moments at rest."""
    settings = gy.Settings()
    acting, start = lead_in(waves, settings), locked_start(linear, SEA)[0]
    record, _ = run_law(plant, gy.law("load_angle"), acting, settings, start=start)
    found = evaluate(plant, record, acting.moments[1], acting.dt, SEA.wp, 100.0, np.nan)
    assert found["ledger_residual"] < 1e-6
    v = record.states[:, [PHI1_RATE, PHI3_RATE]]
    work = np.sum(v.T * acting.moments[:, ::2], axis=0)
    n = len(plant.labels)
    assert record.states[-1, n] == pytest.approx(0.1 * np.trapezoid(work), rel=2e-2)


def test_runs_are_alike_alone_and_in_company(plant: gy.Plant, linear: gy.Plant, waves: gy.WaveRealisation) -> None:
    """The same bits in an ensemble whatever stands beside, and those of the single run of constant controls."""
    start = locked_start(linear, SEA)[0]

    def run(seeds: list[int], pairs: list[tuple[float, float]]) -> Any:
        return run_ensemble(plant, SEA, pairs, seeds, start, 60.0, 20.0, quiet=True)

    alone, company = run([3], [(0.052, 3.5e-4)]), run([5, 3, 9, 4], [(0.052, 3.5e-4), (0.03, 2e-4)])
    assert alone.mean_power[0, 0] == company.mean_power[0, 1]
    assert alone.phi1_p98[0, 0] == company.phi1_p98[0, 1]
    settings = gy.Settings(blend=20.0)
    acting = gy.realise(linear, SEA, 3, 60.0).blended(20.0)
    record, _ = run_law(plant, gy.law("constant", cc=0.052, cg=3.5e-4), acting, settings, start=start)
    single = evaluate(plant, record, acting.moments[1], acting.dt, SEA.wp, 20.0, np.nan)
    assert single["generated_w"] == alone.mean_power[0, 0]


def test_efficiency_scales_what_is_sold_and_what_is_stored(linear: gy.Plant, waves: gy.WaveRealisation) -> None:
    settings, worse = gy.Settings(), gy.zhang2017(generator_efficiency=0.8)
    acting, start = lead_in(waves, settings), locked_start(linear, SEA)[0]
    found = []
    for plant in (linear, worse):
        record, _ = run_law(plant, gy.law("constant"), acting, settings, start=start)
        found.append(evaluate(plant, record, acting.moments[1], acting.dt, SEA.wp, 100.0, np.nan))
    for name in ("mean_power", "generated_w", "stored_w", "p98_over_mean"):
        part = 1.0 if name == "p98_over_mean" else 0.8
        assert found[1][name] == pytest.approx(part * found[0][name], rel=1e-9)
    assert found[1]["ledger_residual"] == found[0]["ledger_residual"]


# --- refusals ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "choices, told",
    [
        ({"position": "still"}, "unknown position"),
        ({"drag": -0.1}, "plant.drag"),
        ({"drag_area": (0.1,)}, "plant.drag_area"),
        ({"drag_height": 0.3}, "plant.drag_height"),
        ({"generator_efficiency": 1.2}, "more than it takes"),
        ({"connection": "rigid", "contact": "friction"}, "cannot slip"),
        ({"connection": "rigid", "coupling_cap": 2.0}, "no magnetic coupling"),
        ({"traction": 0.0}, "plant.traction"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(choices: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told) as error:
        gy.zhang2017(**choices)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("choice", [{"position": "moving"}, {"drag": 0.5}, {"wetted": "surface"}])
def test_without_geometry_the_water_is_refused(linear: gy.Plant, choice: dict[str, Any]) -> None:
    bare = dataclasses.replace(linear, geometry=None)
    with pytest.raises(InputError, match="no geometry"):
        bare.replace(**choice)
