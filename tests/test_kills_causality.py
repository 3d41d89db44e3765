"""No law knows the future: commands up to an instant are the same whatever the waves do after it.

Two realisations are made equal up to an instant and different after it. The moments between the samples of their grid
are interpolated over four samples ahead (0.2 s): for that long before the instant the device itself feels the
difference. Up to there every command must have the same bits; and after it some must differ, or nothing was tested.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.registry import registered
from gyroctl.harness.run import Settings, run_law

ALONE = {"constant", "best_constant"}
"""Laws that look at nothing: their commands never differ."""

BETWEEN = 0.2
"""Reach of the interpolation. [s]"""


def two_futures(device: gy.Plant, until: float, duration: float) -> tuple[gy.WaveRealisation, gy.WaveRealisation]:
    """A realisation, and another that is the same up to `until` [s] and, from there on, that of another seed."""
    one, other = (gy.realise(device, gy.SeaState(), seed, duration) for seed in (100003, 100004))
    known = one.time <= until
    moments = np.where(known, one.moments, other.moments)
    return one, replace(one, moments=moments, elevation=np.where(known, one.elevation, other.elevation))


def commands(device: gy.Plant, law: Any, waves: gy.WaveRealisation) -> NDArray[np.float64]:
    record, _ = run_law(device, law, waves, Settings(blend=0.0))
    return record.commands


def first_difference(device: gy.Plant, law: Any, until: float, duration: float) -> float:
    """Time of the first command that differs between the two futures, infinite where none does. [s]"""
    differ = [commands(device, law, waves) for waves in two_futures(device, until, duration)]
    samples = np.flatnonzero(np.any(differ[0] != differ[1], axis=1))
    return 0.1 * float(samples[0]) if samples.size else np.inf


@pytest.mark.parametrize("name", sorted(set(registered()) - {"nmpc"}))
@pytest.mark.parametrize("until", [12.0, 31.4])
def test_commands_do_not_depend_on_waves_to_come(device: gy.Plant, name: str, until: float) -> None:
    first = first_difference(device, gy.law(name), until, 60.0)
    assert first > until - BETWEEN + 1e-9
    assert first == np.inf if name in ALONE else first < until + 5.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parameters", "knows"),
    [({}, 0.0), ({"information": "forecast", "lead": 0.5}, 0.5), ({"information": "forecast", "lead": 1.5}, 1.5)],
    ids=["sensors", "forecast 0.5 s", "forecast 1.5 s"],
)
def test_planner_looks_as_far_as_it_says_and_no_further(
    device: gy.Plant, parameters: dict[str, Any], knows: float
) -> None:
    until = 6.0
    first = first_difference(device, gy.law("nmpc", **parameters), until, 10.0)
    assert first > until - max(knows, BETWEEN) + 1e-9
    assert first < until + 2.0 - knows


@pytest.mark.slow
def test_oracle_is_caught_at_it(device: gy.Plant) -> None:
    """The test sees a law that knows its horizon of four seconds."""
    assert first_difference(device, gy.law("nmpc", information="oracle"), 6.0, 10.0) < 6.0 - 2.0


class Prophet(NamedTuple):
    """Says that it goes by its sensors, and would go by the waves to come if it were told them."""

    moments: tuple[float, ...] = ()
    period: float = 0.1
    information: str = "sensors"

    def init(self) -> tuple[float]:
        return (0.0,)

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        ahead = self.moments[round((t + 2.0) / 0.05)] if len(self.moments) else y.phi3_rate
        return (0.05, 3e-4 + 1e-5 * abs(ahead)), state

    def informed(self, waves: Any) -> Prophet:
        return self._replace(moments=tuple(waves.moments[1].tolist()) + 100 * (0.0,))


def test_law_of_sensors_is_not_told_the_waves(device: gy.Plant) -> None:
    assert first_difference(device, Prophet(), 12.0, 30.0) > 12.0 - BETWEEN + 1e-9
    knowing = first_difference(device, Prophet(information="oracle"), 12.0, 30.0)
    assert knowing == pytest.approx(10.1), "the same law as an oracle sees them two seconds ahead"
