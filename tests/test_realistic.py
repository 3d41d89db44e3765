"""All choices beyond the linear model together: a run, its ledger and card, controls that move, an experiment."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison.experiment import read_experiment
from gyroctl.devices.file import build_device
from gyroctl.harness.run import run_law
from gyroctl.harness.start import locked_start
from gyroctl.simulation.metrics import evaluate
from gyroctl.simulation.validity import UNITS, validity

SEA = gy.SeaState(gamma=5.0)


@pytest.fixture(scope="module")
def plant() -> gy.Plant:
    return gy.zhang2017("realistic")


def residual(plant: gy.Plant, record: object, waves: gy.WaveRealisation) -> dict[str, float]:
    return evaluate(plant, record, waves.moments[1], waves.dt, SEA.wp, 20.0, np.nan)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_run_closes_its_ledger_and_has_a_card(plant: gy.Plant) -> None:
    """Every row of the ledger takes part; what presses the axis comes from accelerations with the wetted surface."""
    settings = gy.Settings(blend=20.0)
    waves = gy.realise(plant, SEA, 1, 120.0).blended(20.0)
    record, _ = run_law(plant, gy.law("load_angle"), waves, settings)
    found = residual(plant, record, waves)
    assert found["ledger_residual"] < 5e-6 and found["mean_power"] > 0.5
    n = len(plant.labels)
    assert plant.labels[-1] == "theta_rate"
    spent = dict(zip(plant.ledger, record.states[-1, n:], strict=True))
    assert all(abs(spent[name]) > 1.0 for name in plant.ledger)
    card = validity(plant, record, waves, 20.0)
    assert list(card) == list(UNITS) and all(np.isfinite(value) for value in card.values())
    # the coupling has a cap, the contact no more than its traction but while it slides
    assert card["coupling_torque_max"] <= 2.0 and card["traction_p99"] < 0.61


@pytest.mark.slow
def test_moments_of_the_surface_along_a_run_are_those_of_its_kernel(plant: gy.Plant) -> None:
    """At samples of the waves, the card's evaluation for all of them at once and the kernel's one by one."""
    waves = gy.realise(plant, SEA, 1, 60.0)
    held = waves.held(plant)
    assert held is not None
    rng, time = np.random.default_rng(1), np.array([5.0, 12.35, 31.8])
    x = np.zeros((len(plant.labels), time.size))
    x[:2] = rng.normal(0.0, 0.2, (2, time.size))
    each = [held.model.moments(held.fields, t, x[:, i], 1, 0) for i, t in enumerate(time)]
    np.testing.assert_allclose(held.model.along(held.fields, time, x).T, each, rtol=1e-9, atol=1e-9)
    between = np.array([5.02])
    near = held.model.along(held.fields, between, x[:, :1])[:, 0]
    np.testing.assert_allclose(near, held.model.moments(held.fields, 5.02, x[:, 0], 1, 0), atol=1.0)


@pytest.mark.parametrize("choices", [{"drag": 0.5, "position": "moving", "bearing": 0.02}, {"contact": "friction"}])
def test_controls_that_move_see_every_term(choices: dict[str, object]) -> None:
    """A coupling that lags by a tenth of a millisecond is one that does not, with all rows of the ledger."""
    device = gy.zhang2017(**choices)
    waves = gy.realise(device, SEA, 1, 60.0).blended(20.0)
    found = []
    for lag in (0.0, 1e-4):
        settings = gy.Settings(blend=20.0, actuators=gy.Actuators(cc_lag=lag))
        record, _ = run_law(device, gy.law("load_angle"), waves, settings)
        assert residual(device, record, waves)["ledger_residual"] < 5e-6
        found.append(record.states[-1, len(device.labels) :])
    np.testing.assert_allclose(found[1], found[0], rtol=0.01, atol=0.5)


def test_an_experiment_takes_the_variant(tmp_path: Path) -> None:
    file = tmp_path / "real.toml"
    file.write_text('[plant]\nvariant = "realistic"\ntraction = 0.45\n[laws.load_angle]\n')
    plant = read_experiment(file).plant
    assert plant.slips and plant.parameters.traction == 0.45 and plant.parameters.wetted == "surface"


@pytest.mark.slow
def test_laws_of_all_kinds_run_in_it(plant: gy.Plant) -> None:
    """A law that plans has the linear device in mind; the card comes with each run."""
    waves = gy.realise(plant, SEA, 2, 40.0).blended(20.0)
    for name in ("coupling", "nmpc"):
        ds = gy.simulate(plant, gy.law(name), waves, gy.Settings(blend=20.0))
        assert np.all(np.isfinite(ds.phi1)) and json.loads(ds.attrs["validity"])["slip_max"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "choice", [{"drag": 1e4}, {"bearing": 1e3}, {"coupling_cap": 1e-6}, {"rolling_resistance": 10.0}]
)
def test_device_that_cannot_lock_is_not_blamed_on_the_sea(choice: dict[str, float]) -> None:
    plant = gy.zhang2017(**choice)
    with pytest.raises(gy.InputError, match="has no locked orbit") as caught:
        gy.simulate(plant, gy.law("constant"), gy.realise(plant, gy.SeaState(), 1, 150.0))
    assert caught.value.field == "plant" and next(iter(choice)) in caught.value.value


@pytest.mark.parametrize("choice", [{"J14": 3671.0}, {"d1": 1e9}, {"length_scale": 2.0, "d1": 1e9}])
def test_changed_device_that_cannot_lock_names_what_was_changed(choice: dict[str, float]) -> None:
    """So does one beside choices of a variant; a sea too small for the device of Table 1 is still the sea's fault."""
    length = choice.get("length_scale", 1.0)
    plant = build_device({**choice, "hydrodynamics_length": length}) if length != 1.0 else gy.zhang2017(**choice)
    with pytest.raises(gy.InputError, match="no lock begins in this sea") as caught:
        locked_start(plant, gy.SeaState(hs=0.283 * length, wp=3.14 / length**0.5))
    name, value = list(choice.items())[-1]
    assert caught.value.field == "plant" and caught.value.value.startswith(f"{name} = {value:.5g} (")
    assert "," not in caught.value.value and "times the length" not in caught.value.value


def test_sea_too_small_is_no_fault_of_an_unchanged_device() -> None:
    with pytest.raises(gy.InputError, match="too small") as caught:
        locked_start(gy.zhang2017(), gy.SeaState(hs=0.002))
    assert caught.value.field == "sea.hs"
    with pytest.raises(gy.InputError) as caught:
        locked_start(gy.zhang2017("realistic"), gy.SeaState(hs=0.002))
    assert caught.value.field == "plant" and caught.value.value == gy.zhang2017("realistic").smooth.name
