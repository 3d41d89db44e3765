"""The table of faults: its cases are what they say, laws are told what a case says, and it runs in the small."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.run import Settings
from gyroctl.harness.sensing import Sensors
from gyroctl.plant.measurement import CHANNELS
from gyroctl.statistics import wilson
from gyroctl.studies.evaluation.cases import Case, Outcome, Runs
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.studies.evaluation.faults import BIAS, LOST_FOR, LOST_FROM, READS, faults
from gyroctl.studies.evaluation.perturbed_devices import NOMINAL, Truth, truths
from gyroctl.studies.evaluation.request import request
from gyroctl.studies.evaluation.robustness import FORWARD, faults_table, forward_runs, told

CASES = {truth.name: truth for truth in faults(Settings(), 5.0, 400.0)}
PLAIN = Sensors()


def test_every_case_is_the_realistic_device_in_what_it_does_not_say() -> None:
    base = CASES[NOMINAL]
    assert next(iter(CASES)) == NOMINAL and len(CASES) == len(faults(Settings(), 5.0, 400.0))
    assert base.plant.coefficients == gy.zhang2017("realistic").coefficients
    assert base.settings.actuators.cc_lag == 0.02 and base.settings.sensors == PLAIN
    said = {(t.plant.coefficients, repr((t.settings, t.told, t.sea))) for t in CASES.values()}
    assert len(said) == len(CASES), "no two cases are the same"
    assert len({id(t.plant) for t in CASES.values()}) == len(CASES), "no truth is another's object"


@pytest.mark.parametrize(
    ("case", "field", "value"),
    [
        ("drag 0.3", "drag", 0.3),
        ("drag 1.2", "drag", 1.2),
        ("friction 0.3", "traction", 0.3),
        ("friction 0.8", "traction", 0.8),
        ("bearing 0", "bearing", 0.0),
        ("bearing 0.03 Nm", "bearing", 0.03),
        ("k1 +20 %", "k1", 1.2 * gy.zhang2017().parameters.k1),
        ("J14 -20 %", "J14", 0.8 * gy.zhang2017().parameters.J14),
    ],
)
def test_device_of_a_case_differs_in_one_number(case: str, field: str, value: float) -> None:
    base, plant = CASES[NOMINAL].plant, CASES[case].plant
    assert getattr(plant.parameters, field) == pytest.approx(value)
    assert plant.replace(**{field: getattr(base.parameters, field)}).coefficients == base.coefficients
    assert CASES[case].settings == CASES[NOMINAL].settings


@pytest.mark.parametrize("reads", READS)
@pytest.mark.parametrize("name", CHANNELS)
def test_one_sensor_is_lost_and_no_other(name: str, reads: str) -> None:
    sensors = CASES[f"{name} lost, reads {reads}"].settings.sensors
    for channel in CHANNELS:
        one = getattr(sensors, channel)
        lost = (LOST_FROM, LOST_FOR, reads) if channel == name else (0.0, 0.0, "nothing")
        assert (one.lost_from, one.lost_for, one.lost_reads) == lost
        assert one.noise == getattr(PLAIN, channel).noise
    fate = sensors.arrays(3000, 1).fate
    assert fate.any(axis=1).sum() == 200 and fate[2000:2200, CHANNELS.index(name)].all()


def test_biases_lags_and_late_samples_are_what_they_say() -> None:
    for sign, case in ((1.0, "biases +"), (-1.0, "biases -")):
        assert {c: getattr(CASES[case].settings.sensors, c).bias for c in CHANNELS} == {
            c: sign * bias for c, bias in BIAS.items()
        }
    for lag in (0.01, 0.05, 0.1):
        assert CASES[f"lag {1e3 * lag:.0f} ms"].settings.actuators.cc_lag == lag
    once = CASES["one sample late once"].settings.sensors.arrays(3000, 1).fate
    assert (once > 0).sum() == 7 and (once[2000] > 0).all()
    unknown, known = CASES["commands a sample late"], CASES["commands a sample late, told"]
    assert unknown.settings == known.settings and unknown.settings.actuators.delay == 1
    assert (unknown.told, known.told) == ({}, {"delay": 1})
    assert CASES["sensors a sample late, told"].settings.sensors.phi3.delay == 1


def test_law_is_told_what_it_has_a_parameter_for() -> None:
    planner, simple = Entrant("p", "nmpc", {"horizon": 3.0}), Entrant("load_angle", "load_angle")
    case = CASES["commands a sample late, told"]
    assert told(planner, case).parameters == {"horizon": 3.0, "delay": 1}
    assert told(simple, case).parameters == {}
    assert told(planner, CASES["commands a sample late"]) is planner
    linear = next(truth for truth in truths() if truth.name == "one sample late, told")
    assert told(planner, linear).build().delay == linear.settings.actuators.delay == 1  # type: ignore[attr-defined]


def test_table_runs_its_cases_with_their_seas(tmp_path: Path) -> None:
    """In the small, on a device whose wetted surface is linear: panels would take minutes."""
    sea = CASES["heading turns by 20 deg"].sea

    def small(name: str) -> Truth:
        return CASES[name]._replace(plant=gy.zhang2017(drag=0.5))

    cases = [small(name) for name in (NOMINAL, "phi1_rate lost, reads last", "heading turns by 20 deg")]
    ask = request(tmp_path, "load_angle", ("100000:100001",), 230.0, 1, allow_tuning_seeds=True, quiet=True)
    content, text, _ = faults_table(ask, cases=cases)
    assert not content["failed"] and list(content["cases"]) == [case.name for case in cases]
    assert content["truths"]["heading turns by 20 deg"]["sea"]["heading_end"] == sea.heading_end == 20.0  # type: ignore[union-attr]
    power = {name: {row["law"]: row["power"].value for row in rows} for name, rows in content["cases"].items()}
    assert power["phi1_rate lost, reads last"]["best_constant"] == power[NOMINAL]["best_constant"]
    assert power["phi1_rate lost, reads last"]["load_angle"] != power[NOMINAL]["load_angle"]
    assert power["heading turns by 20 deg"]["best_constant"] != power[NOMINAL]["best_constant"]
    assert "## Locked runs" in text
    head = next(line for line in text.splitlines() if line.startswith("| case") and FORWARD in line)
    assert head.rstrip(" |").endswith("limits")


def test_runs_without_a_reversal_are_counted_and_those_without_numbers_are_not() -> None:
    values = {"reversals": np.array([0.0, 2.0, math.nan, 0.0])}
    runs = Runs(Entrant("load_angle", "load_angle", {}), "load_angle", "sensors", np.arange(4), ("",) * 4, values)
    outcome = Outcome(Case(NOMINAL, CASES[NOMINAL].plant, gy.SeaState(), Settings()), {"load_angle": runs}, {})
    share = forward_runs(outcome)["load_angle"]
    half = wilson(2, 4)
    assert (share.value, share.low, share.high) == pytest.approx((0.5, half.low, half.high))
