"""The supervisor on the device: start from rest, unloading, re-lock, hand-over, and what the motor costs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from lock_numbers import J4, WP, N

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment
from gyroctl.controllers.supervisor import Rules, Supervisor, wrap
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PSI
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.studies.startup import Fault, startup_report, stuck

REST = Settings(start="rest", actuators=gy.Actuators(cg_min=-0.02))
LOCKED = Settings(blend=50.0, actuators=gy.Actuators(cg_min=-0.02))


@dataclass(frozen=True)
class Odd:
    """A law with a state that no compiler knows."""

    cg: float = 3e-4
    period: float = 0.1
    information: str = "none"

    def init(self) -> dict[str, int]:
        return {"steps": 0}

    def step(self, t: float, y: Measurement, state: dict[str, int]) -> tuple[tuple[float, float], dict[str, int]]:
        return (0.06, self.cg), {"steps": state["steps"] + 1}

    def counters(self, state: dict[str, int]) -> dict[str, int]:
        return {"fallbacks": state["steps"]}


@dataclass(frozen=True)
class Plain:
    """A law that is no NamedTuple, and so runs as plain Python."""

    law: Any

    @property
    def period(self) -> float:
        return float(self.law.period)

    @property
    def information(self) -> str:
        return str(self.law.information)

    def init(self) -> Any:
        return self.law.init()

    def step(self, t: float, y: Measurement, state: Any) -> Any:
        return self.law.step(t, y, state)


class Greedy(NamedTuple):
    """An ordinary law that asks for a motor at every second sample."""

    cc: float = 0.06
    period: float = 0.1

    @property
    def information(self) -> str:
        return "none"

    def init(self) -> tuple[float]:
        return (1.0,)

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        return (self.cc, 5e-4 * state[0]), (-state[0],)


def waves_of(device: gy.Plant, seed: int, duration: float, settings: Settings) -> gy.WaveRealisation:
    return lead_in(gy.realise(device, gy.SeaState(), seed, duration), settings)


def scored(device: gy.Plant, record: Record, waves: gy.WaveRealisation, settings: Settings) -> dict[str, float]:
    rest = settings.start == "rest"
    return evaluate(device, record, waves.moments[1], waves.dt, WP, settings.score_from, math.nan, from_rest=rest)


# --- the whole -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["load_angle", "coupling", "constant"])
def test_a_device_found_locked_is_the_law_alone_to_the_last_bit(device: gy.Plant, name: str) -> None:
    law = gy.law(name)
    waves = waves_of(device, 100001, 200.0, LOCKED)
    alone, _ = run_law(device, law, waves, LOCKED)
    held, timing = run_law(device, wrap(law), waves, LOCKED)
    np.testing.assert_array_equal(held.states, alone.states)
    assert timing.counters["time_produce"] == pytest.approx(200.0)
    assert timing.counters["unloads"] == timing.counters["starts"] == 0.0


@pytest.mark.parametrize("name", ["load_angle", "coupling", "constant"])
def test_compiled_composition_has_the_bits_of_plain_python(device: gy.Plant, name: str) -> None:
    law = gy.law(name)
    waves = waves_of(device, 100002, 220.0, REST)
    wrapped = wrap(law)
    assert compile_law(wrapped) is not None
    one, counts = run_law(device, wrapped, waves, REST)
    two, _ = run_law(device, wrapped, waves, REST, compiled=False)
    three, again = run_law(device, wrap(Plain(law)), waves, REST)
    np.testing.assert_array_equal(one.states, two.states)
    np.testing.assert_array_equal(one.states, three.states)
    assert dict(counts.counters) == dict(again.counters)
    assert counts.counters["catches"] == 1.0


@pytest.mark.parametrize("name", ["load_angle", "coupling"])
def test_starts_from_rest_and_pays_for_it(device: gy.Plant, name: str) -> None:
    for seed in (100010, 100011, 100012):
        waves = waves_of(device, seed, 900.0, REST)
        record, timing = run_law(device, wrap(gy.law(name)), waves, REST)
        found = scored(device, record, waves, REST)
        assert found["locked"] == 1.0
        assert found["lock_begins"] < 220.0
        assert found["ledger_residual"] < 1e-6
        assert 0.0 < found["payback_time"] < 900.0
        assert found["net_energy"] > 0.0
        # by hand: power of the motor from gains and speeds; no less than what the flywheel then holds
        cg, speed = record.controls[:, 1], record.states[:, OMEGA_RATE]
        power = np.minimum(cg, 0.0) * 0.5 * (speed[:-1] ** 2 + speed[1:] ** 2)
        assert found["motor_energy"] == pytest.approx(-0.1 * power.sum(), rel=1e-3)
        assert found["motor_energy"] > 0.5 * J4 * (Rules().speed_ratio * N * WP) ** 2 * 0.9
        assert -power.min() < 1.02 * Rules().motor_power
        assert found["generated_w"] * 900.0 == pytest.approx(found["net_energy"])
        share = timing.counters["time_produce"] / 900.0
        assert found["availability"] == pytest.approx(share, abs=0.03)


def test_nothing_starts_without_a_motor(device: gy.Plant) -> None:
    """An experiment that allows no motor: asked for, refused, counted."""
    settings = Settings(start="rest")
    waves = waves_of(device, 100003, 200.0, settings)
    record, _ = run_law(device, wrap(gy.law("load_angle")), waves, settings)
    assert record.saturations > 100
    assert record.controls.min() == 0.0
    assert np.isnan(scored(device, record, waves, settings)["lock_begins"])
    bare, _ = run_law(device, gy.law("load_angle"), waves, REST)
    found = scored(device, bare, waves, REST)
    assert (found["locked"], found["loss_time"], found["availability"]) == (0.0, 10.0, 0.0)


def test_negative_gain_of_an_ordinary_law_never_motors(device: gy.Plant) -> None:
    waves = waves_of(device, 100004, 100.0, LOCKED)
    record, _ = run_law(device, Greedy(), waves, LOCKED)
    assert record.saturations == 500
    assert record.controls[:, 1].min() == 0.0
    wrapped, timing = run_law(device, wrap(Greedy()), waves, LOCKED)
    assert wrapped.commands[:, 1].min() == 0.0
    assert timing.counters["clipped"] == 500.0
    np.testing.assert_array_equal(wrapped.states, record.states)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["load_angle", "coupling"])
def test_locks_again_after_a_generator_that_pulled_too_hard(device: gy.Plant, name: str) -> None:
    waves = waves_of(device, 100005, 450.0, LOCKED)
    bare, _ = run_law(device, stuck(gy.law(name), Fault(begin=150.0)), waves, LOCKED)
    law = stuck(wrap(gy.law(name)), Fault(begin=150.0))
    assert compile_law(law) is not None
    record, timing = run_law(device, law, waves, LOCKED)
    end = timing.counters["fault_ends"]
    assert 170.0 <= end < 260.0
    np.testing.assert_array_equal(record.controls[1500 : round(10.0 * end), 1], 0.02)
    found = scored(device, record, waves, LOCKED)
    assert found["locked"] == 0.0  # a loss is a loss
    assert found["loss_time"] <= end + 1.0
    psi = record.states[-600:, PSI]
    assert psi[-1] - psi[0] > 0.75 * WP * 60.0
    assert found["motor_energy"] > 100.0
    assert found["ledger_residual"] < 1e-6
    assert np.diff(bare.states[:, -1]).min() >= 0.0
    plain, _ = run_law(device, stuck(wrap(Plain(gy.law(name))), Fault(begin=150.0)), waves, LOCKED)
    np.testing.assert_array_equal(plain.states, record.states)


def test_any_python_law_can_be_wrapped_and_begins_anew_at_the_pull(device: gy.Plant) -> None:
    waves = waves_of(device, 100006, 300.0, REST)
    law = gy.law("supervisor", wraps=Odd())
    assert isinstance(law, Supervisor)
    record, timing = run_law(device, law, waves, REST)
    counts = timing.counters
    assert counts["catches"] == 1.0
    assert counts["fallbacks"] == pytest.approx(10.0 * (300.0 - counts["time_start"]), abs=2)  # stepped from PULL on
    np.testing.assert_allclose(record.controls[-1], (0.06, 3e-4))
    assert law.information == "sensors"


def test_motor_is_negative_generator_power_in_the_ledger(device: gy.Plant) -> None:
    waves = waves_of(device, 100007, 150.0, REST)
    record, _ = run_law(device, wrap(gy.law("coupling")), waves, REST)
    generator = record.states[:, len(device.labels) + LEDGER.index("generator")]
    assert generator.min() < -400.0
    dx = device.derivative(record.states[1000, :14], (0.0, -0.01), (0.0, 0.0))
    power = device.power(record.states[1000, :14], (0.0, -0.01))
    assert power == pytest.approx(-0.01 * record.states[1000, OMEGA_RATE] ** 2)
    assert np.all(np.isfinite(np.asarray(dx)))


# --- stored results, experiments, study ------------------------------------------------------------------------------


def test_stored_results_know_the_wrapped_law() -> None:
    one, two = (law_fingerprint(gy.law("supervisor", wraps=name)) for name in ("load_angle", "coupling"))
    assert one and two and one != two
    assert law_fingerprint(gy.law("supervisor", wraps=gy.law("coupling"))) == two
    assert law_fingerprint(gy.law("supervisor", confirm=6.0)) != law_fingerprint(gy.law("supervisor"))
    inner = gy.law("supervisor", wraps={"law": "load_angle", "share": 0.5})
    assert law_fingerprint(inner) != one
    assert describe(inner)["law_share"] == 0.5
    assert describe(wrap(Odd()))["law_cg"] == 3e-4  # type: ignore[arg-type]
    assert describe(wrap(Odd()))["confirm"] == Rules().confirm  # type: ignore[arg-type]


def test_start_at_rest_is_the_same_for_every_law_and_has_no_blend(device: gy.Plant) -> None:
    waves = gy.realise(device, gy.SeaState(), 100008, 60.0)
    assert lead_in(waves, REST) is waves
    first = [run_law(device, gy.law(name), waves, REST)[0].states[0] for name in ("load_angle", "supervisor")]
    np.testing.assert_array_equal(*first)
    assert np.count_nonzero(first[0]) == 1
    assert 0.0 < first[0][PSI] < 2.0 * math.pi


def test_experiment_from_rest(device: gy.Plant) -> None:
    tables: dict[str, Any] = {
        "run": {"start": "rest", "duration": 90.0, "seeds": [100009]},  # shorter than the blend that there is not
        "laws": {"a": {"law": "supervisor", "wraps": {"law": "coupling", "cc_max": 0.1}}},
        "actuators": {"cg_min": -0.02},
    }
    asked = build_experiment(tables)
    assert (asked.settings.start, asked.settings.score_from) == ("rest", 0.0)
    assert describe(asked.laws["a"])["law_cc_max"] == 0.1
    assert asked.record()["run"]["start"] == "rest"
    waves = [gy.realise(device, gy.SeaState(), 100009, 90.0)]
    ds = gy.compare(device, asked.laws, waves, asked.settings, workers=1, quiet=True, tuning_seeds=())
    assert float(ds.starts.sel(law="a").item()) == 1.0
    assert ds.attrs["start"] == "rest"


@pytest.mark.slow
def test_study_writes_table_data_and_figure(tmp_path: Path) -> None:
    """A small one: what is written agrees with what is returned."""
    result = startup_report(tmp_path, (100020, 100021), ("load_angle",), dt=0.01, durations=(500.0, 600.0), quiet=True)
    assert result["rest"]["load_angle"]["runs"] == 2
    assert result["rest"]["load_angle"]["locked"] == 2
    assert result["loss"]["load_angle"]["lost"] == 2
    rows = (tmp_path / "startup_rest.csv").read_text().splitlines()
    assert len(rows) == 3
    columns = dict(zip(rows[0].split(","), rows[1].split(","), strict=True))
    assert float(columns["locked_after_s"]) <= 200.0
    assert "| load_angle | 2/2 |" in (tmp_path / "startup.md").read_text()
    assert (tmp_path / "startup.png").stat().st_size > 20_000
