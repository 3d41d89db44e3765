"""The harness by hand: who is told the waves, what a law is shown when, what becomes of its commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import gyroctl as gy
from gyroctl.controllers.supervisor import wrap
from gyroctl.harness.actuation import Actuators, actuate
from gyroctl.harness.protocol import LawError, Measurement
from gyroctl.harness.registry import describe, tuned_seeds, tuned_sets
from gyroctl.harness.run import Settings, run_law
from gyroctl.harness.sensing import Channel, Sensors, measure
from gyroctl.harness.start import locked_start, rest_start

IDEAL = Settings(blend=0.0, sensors=Sensors.ideal())

MEASURED = ("psi", "psi_rate", "omega_rate", "phi1", "phi3", "phi1_rate", "phi3_rate")


@dataclass
class Witness:
    """Law that keeps what it is shown and told, and commands what it is made to."""

    answer: Callable[[float], tuple[float, float]] = lambda t: (0.05, 3e-4)
    information: str = "sensors"
    period: float = 0.1
    told: list[Any] = field(default_factory=list)
    shown: list[tuple[float, Measurement]] = field(default_factory=list)

    def init(self) -> tuple[float]:
        return (0.0,)

    def step(self, t: float, y: Measurement, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        self.shown.append((t, y))
        return self.answer(t), state

    def informed(self, waves: Any) -> Witness:
        self.told.append(waves)
        return self


@pytest.fixture(scope="module")
def waves(device: gy.Plant) -> gy.WaveRealisation:
    return gy.realise(device, gy.SeaState(), 100007, 6.0)


def column(device: gy.Plant, name: str) -> int:
    return device.labels.index(name)


# --- who is told the waves ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("information", "told"), [("none", 0), ("sensors", 0), ("forecast", 1), ("oracle", 1)])
def test_only_laws_that_say_so_are_told_the_waves(
    device: gy.Plant, waves: gy.WaveRealisation, information: str, told: int
) -> None:
    law = Witness(information=information)
    run_law(device, law, waves, IDEAL)
    assert law.told == [waves] * told
    supervised = Witness(information=information)
    run_law(device, wrap(supervised), waves, IDEAL)
    assert supervised.told == [waves] * told, "a supervisor passes on what the law within may know, and no more"


# --- what a law is shown ------------------------------------------------------------------------------------------


def test_law_is_shown_the_state_of_now_under_its_names(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = Witness()
    record, _ = run_law(device, law, waves, IDEAL)
    assert [t for t, _ in law.shown] == pytest.approx([0.1 * i for i in range(60)])
    for name in MEASURED:
        seen = [getattr(y, name) for _, y in law.shown]
        np.testing.assert_array_equal(seen, record.states[:-1, column(device, name)], err_msg=name)


def test_slow_law_is_asked_at_its_own_period(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = Witness(lambda t: (0.05, 1e-4 * (1.0 + t)), period=0.5)
    record, _ = run_law(device, law, waves, IDEAL)
    assert [t for t, _ in law.shown] == pytest.approx([0.5 * i for i in range(12)])
    np.testing.assert_allclose(record.commands[:, 1], 1e-4 * (1.0 + np.repeat(0.5 * np.arange(12), 5)))


def test_each_channel_has_its_own_errors() -> None:
    record = np.random.default_rng(0).standard_normal((4000, 20))
    rows = {"phi1": 0, "psi": 2, "phi3_rate": 5}
    sensors = Sensors.ideal()
    noisy = replace(
        sensors, psi=Channel(noise=0.5), phi1=Channel(bias=0.25), phi3_rate=Channel(delay=3), phi3=Channel(quantum=0.1)
    )
    arrays, y, seen = noisy.arrays(4000, 1), np.zeros(7), []
    for sample in range(4000):
        measure(arrays, sample, record, y)
        seen.append(Measurement(*y.tolist()))
    psi = np.array([s.psi for s in seen]) - record[:, rows["psi"]]
    assert psi.std() == pytest.approx(0.5, rel=0.05)
    np.testing.assert_allclose([s.phi1 for s in seen] - record[:, rows["phi1"]], 0.25)
    late = np.array([s.phi3_rate for s in seen])
    np.testing.assert_array_equal(late[3:], record[:-3, rows["phi3_rate"]])
    rounded = np.array([s.phi3 for s in seen])
    np.testing.assert_allclose(rounded, np.round(record[:, 1] / 0.1) * 0.1, atol=1e-12)
    np.testing.assert_array_equal([s.omega_rate for s in seen], record[:, 7])


def test_sample_that_is_missing_keeps_the_one_before() -> None:
    record = np.arange(400.0)[:, None] * np.ones(20)
    arrays, y, seen = replace(Sensors.ideal(), psi=Channel(dropout=0.5)).arrays(400, 1), np.zeros(7), []
    for sample in range(400):
        measure(arrays, sample, record, y)
        seen.append(y[0])
    fresh = np.array(seen) == np.arange(400.0)
    assert 0.4 < fresh.mean() < 0.6
    assert all(seen[i] == seen[i - 1] for i in range(1, 400) if not fresh[i])


def test_noise_goes_with_the_seed_of_the_waves(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    noisy = Settings(blend=0.0, sensors=replace(Sensors.ideal(), psi_rate=Channel(noise=0.1)))

    def noise(of: gy.WaveRealisation) -> Any:
        law = Witness()
        record, _ = run_law(device, law, of, noisy)
        return np.array([y.psi_rate for _, y in law.shown]) - record.states[:-1, column(device, "psi_rate")]

    np.testing.assert_allclose(noise(waves), noisy.sensors.arrays(60, waves.seed).error[:, 1], atol=1e-12)
    assert not np.allclose(noise(waves), noise(replace(waves, seed=waves.seed + 1)))


# --- what its commands become -------------------------------------------------------------------------------------


def stepping(t: float) -> tuple[float, float]:
    """Controls that change at every sample, of sizes that cannot be mistaken for one another."""
    return 0.05 + 0.03 * math.sin(7.0 * t), 4e-4 * (1.0 + math.cos(5.0 * t))


def test_run_is_the_solution_of_the_equations(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """Held controls, moments of the right joint at the right time: an integrator of another make gives the same."""
    record, _ = run_law(device, Witness(stepping), waves, IDEAL)
    moments = CubicSpline(waves.time, waves.moments, axis=1)
    x = record.states[0, : len(device.labels)]
    for sample in range(20):
        u = stepping(0.1 * sample)
        np.testing.assert_array_equal(record.commands[sample], u)
        np.testing.assert_array_equal(record.controls[sample], u)
        span = (0.1 * sample, 0.1 * (sample + 1))
        x = solve_ivp(lambda t, x, u=u: device.derivative(x, u, moments(t)), span, x, rtol=1e-8, atol=1e-10).y[:, -1]
    np.testing.assert_allclose(record.states[20, : x.size], x, rtol=2e-4, atol=2e-5)


def test_commands_beyond_the_limits_are_recorded_clipped_and_counted(
    device: gy.Plant, waves: gy.WaveRealisation
) -> None:
    law = Witness(lambda t: (0.5, -1e-3) if t > 2.95 else (0.05, 3e-4))
    record, _ = run_law(device, law, waves, IDEAL)
    np.testing.assert_array_equal(record.commands[40], (0.5, -1e-3))
    np.testing.assert_array_equal(record.controls[40], (0.3, 0.0))
    assert record.saturations == 60


@pytest.mark.parametrize("broken", [(math.nan, 3e-4), (0.05, math.inf), (math.nan, math.nan)])
def test_either_command_that_is_no_number_ends_the_run(
    device: gy.Plant, waves: gy.WaveRealisation, broken: tuple[float, float]
) -> None:
    with pytest.raises(LawError, match=r"t = 2\.0"):
        run_law(device, Witness(lambda t: broken if t > 1.95 else (0.05, 3e-4)), waves, IDEAL)


def given(commands: list[tuple[float, float]], **settings: Any) -> Any:
    arrays, held, out = Actuators(**settings).arrays(), np.zeros(2), []
    for sample in range(len(commands)):
        actuate(arrays, sample, np.array(commands), held)
        out.append(held.copy())
    return np.array(out)


def test_limits_are_those_of_their_channel() -> None:
    np.testing.assert_array_equal(given([(1.0, 1.0)], cc_max=0.25, cg_max=0.015), [[0.25, 0.015]])


def test_delayed_command_acts_that_many_samples_later() -> None:
    commands = [(0.01 * i, 1e-4 * i) for i in range(1, 9)]
    np.testing.assert_allclose(given(commands, delay=3)[3:], commands[:-3])


def test_only_a_law_that_starts_the_device_may_use_the_motor(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    settings = replace(IDEAL, actuators=Actuators(cg_min=-0.01))

    @dataclass
    class Motor(Witness):
        motors: bool = True

    for law, least in ((Witness(lambda t: (0.05, -0.005)), 0.0), (Motor(lambda t: (0.05, -0.005)), -0.005)):
        record, _ = run_law(device, law, waves, settings)
        assert record.controls[:, 1].min() == least


# --- starts, scoring, tuned sets ----------------------------------------------------------------------------------


def test_scoring_begins_with_the_sea() -> None:
    assert Settings(blend=70.0).score_from == 70.0
    assert Settings(blend=70.0, start="rest").score_from == 0.0


def test_start_is_on_the_orbit_of_the_wave_of_equal_energy(device: gy.Plant) -> None:
    x, (cc, cg) = locked_start(device, gy.SeaState(hs=0.3))
    orbit = gy.lock_orbit(device, gy.Regular(0.3 / math.sqrt(2.0), 3.14), cc, cg)
    np.testing.assert_allclose(x, orbit.x, rtol=1e-9, atol=1e-12)


def test_ring_at_rest_stands_anywhere(device: gy.Plant) -> None:
    angles = np.array([rest_start(device, seed)[column(device, "psi")] for seed in range(400)])
    assert abs(np.exp(1j * angles).mean()) < 0.1 and np.unique(angles).size == 400
    others = np.delete(rest_start(device, 3), column(device, "psi"))
    assert not others.any()


class Shipped(NamedTuple):
    law: str
    tuning: str


@pytest.mark.parametrize("shipped", [Shipped("constant", "gamma50"), Shipped("constant", "gamma1")])
def test_tuned_set_is_the_law_s_and_its_seeds_are_all_known(shipped: Shipped) -> None:
    entry = tuned_sets(shipped.law)[shipped.tuning]
    built = describe(gy.law(shipped.law, shipped.tuning))
    assert {name: built[name] for name in entry["parameters"]} == entry["parameters"]
    assert built != describe(gy.law(shipped.law)), "the default is another"
    span = entry["found"]["seeds"]
    assert {span["first"], span["last"]} <= tuned_seeds(shipped.law)
