"""Closed loops in lanes: each run is the one that the law makes alone, to the last bit."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.protocol import LawError
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.together import run_together
from gyroctl.simulation.metrics import Record

SETTINGS = gy.Settings(blend=10.0)


def realisations(device: gy.Plant, count: int, duration: float = 30.0) -> list[gy.WaveRealisation]:
    return [lead_in(gy.realise(device, gy.SeaState(), seed, duration), SETTINGS) for seed in range(1, count + 1)]


def same(one: Record, other: Record) -> None:
    for name in ("states", "commands", "controls"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.saturations == other.saturations


class Fickle(NamedTuple):
    """Switch the coupling off and on by what the sensors say: every lane at instants of its own."""

    period: float = 0.1

    @property
    def information(self) -> Literal["sensors"]:
        return "sensors"

    def init(self) -> tuple[float, ...]:
        return (0.0,)

    def step(self, t: float, y: Any, state: tuple[float, ...]) -> tuple[tuple[float, float], tuple[float, ...]]:
        return (0.2 if y.phi1_rate > 0.0 else 0.02, 3.5e-4), (state[0] + 1.0,)


class Failing(NamedTuple):
    """Divide by nothing once the float has turned far enough."""

    far: float = 0.25  # [rad]
    period: float = 0.1

    @property
    def information(self) -> Literal["sensors"]:
        return "sensors"

    def init(self) -> tuple[float, ...]:
        return (0.0,)

    def step(self, t: float, y: Any, state: tuple[float, ...]) -> tuple[tuple[float, float], tuple[float, ...]]:
        one = 1.0 / (0.0 if y.phi1 > self.far else 1.0)
        return (0.06, 3.5e-4 * one), state


@pytest.mark.parametrize(
    "law", [gy.law("load_angle"), gy.law("coupling"), Fickle()], ids=lambda law: type(law).__name__
)
@pytest.mark.parametrize("count", [3, 18])  # idle lanes; more than one filling
def test_each_run_has_the_bits_of_the_run_alone(device: gy.Plant, law: Any, count: int) -> None:
    waves = realisations(device, count)
    for each, outcome in zip(waves, run_together(device, law, waves, SETTINGS), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, law, each, SETTINGS)[0])


def test_delay_resolution_and_dropout_act_in_lanes_as_alone(device: gy.Plant) -> None:
    law, channel = gy.law("load_angle"), gy.Channel(noise=0.01, quantum=0.02, delay=2, dropout=0.2)
    actuators = gy.Actuators(delay=1, cg_quantum=1e-5, period=0.05)
    settings = gy.Settings(blend=10.0, sensors=gy.Sensors(psi=channel, phi1_rate=channel), actuators=actuators)
    waves = realisations(device, 4)
    for each, outcome in zip(waves, run_together(device, law, waves, settings), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, law, each, settings)[0])


def test_a_law_that_fails_ends_its_own_run_alone(device: gy.Plant) -> None:
    waves, law = realisations(device, 6, 60.0), Failing()
    outcomes = run_together(device, law, waves, SETTINGS)
    failed = [isinstance(outcome, LawError) for outcome in outcomes]
    assert any(failed) and not all(failed)
    assert all(isinstance(outcome, LawError) for outcome in run_together(device, Failing(-1.0), waves, SETTINGS))
    for each, outcome in zip(waves, outcomes, strict=True):
        if isinstance(outcome, LawError):
            with pytest.raises(LawError) as caught:
                run_law(device, law, each, SETTINGS)
            assert str(outcome) == str(caught.value)
        else:
            same(outcome[0], run_law(device, law, each, SETTINGS)[0])


def test_what_cannot_share_its_steps_runs_by_itself(device: gy.Plant) -> None:
    settings = gy.Settings(blend=10.0, actuators=gy.Actuators(cg_lag=0.2))
    waves = realisations(device, 2)
    for each, outcome in zip(waves, run_together(device, gy.law("load_angle"), waves, settings), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, gy.law("load_angle"), each, settings)[0])
