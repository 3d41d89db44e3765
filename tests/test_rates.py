"""Rates of many states at once, and what is found of a realisation, kept for the next law on it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.comparison.items import KEPT, Realisations
from gyroctl.harness.run import Settings
from gyroctl.plant.rates import rates
from gyroctl.simulation.lock import phase_of_moment, wave_phasor


@pytest.mark.parametrize("told", [{}, {"variant": "paper"}, {"connection": "rigid"}, {"drag": 0.5}])
def test_rates_are_those_of_the_plant(told: dict[str, Any]) -> None:
    """To rounding: cosine and sine of compiled code are not those of the library."""
    plant, rng = gy.zhang2017(**told), np.random.default_rng(5)
    x = rng.normal(size=(len(plant.labels), 300))
    u, signals = 0.1 * rng.random((2, 300)), 50.0 * rng.normal(size=(len(plant.channels), 300))
    expected = plant.derivative(x, u, signals)
    scale = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(rates(plant, x, u, signals) / scale, expected / scale, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("samples", [400, 401])
def test_phasor_is_the_analytic_signal_of_what_passes(samples: int) -> None:
    """Lines on the bins of the transform: one in the band turns alone, one outside and the mean leave nothing."""
    step = 2.0 * np.pi / (samples * 0.1)  # rad/s
    t = 0.1 * np.arange(samples)
    moment = 3.0 + 5.0 * np.cos(20 * step * t + 0.4) + 7.0 * np.cos(40 * step * t)
    found = wave_phasor(moment, 0.1, 22 * step)
    np.testing.assert_allclose(found, 5.0 * np.exp(1j * (20 * step * t + 0.4)), rtol=0.0, atol=1e-12)


def test_line_at_half_the_sampling_rate_has_no_phase() -> None:
    signs = np.cos(np.pi * np.arange(400))
    np.testing.assert_allclose(wave_phasor(signs, 0.1, 10.0 * np.pi), 0.0, atol=1e-12)


def test_pieces_of_all_laws_go_in_turn() -> None:
    """Realisation by realisation, whenever the pieces of a law were added; without a turn as they came."""
    begun = list[str]()

    def work(name: str) -> list[str]:
        begun.append(name)
        return [name]

    under_way: Any = execution._UnderWay(1)
    with ThreadPoolExecutor(1) as threads:
        for law in "ab":
            under_way.add(
                "threads",
                [execution.Work(partial(threads.submit, work, f"{law}{i}"), [f"{law}{i}"], turn=i) for i in range(3)],
            )
        assert [item for item, _ in under_way.ended()] == begun == ["a0", "b0", "a1", "b1", "a2", "b2"]


def test_waves_are_kept_for_the_next_law_on_them() -> None:
    """For the same waves, plant and settings: they are told apart as objects, and another makes its own."""
    plant, waves, settings = gy.zhang2017(), Realisations(gy.SeaState(), (1, 2), 120.0), Settings()
    first = waves.at(plant, 1, settings)
    assert waves.at(plant, 1, settings) is first
    assert waves.at(plant, 2, settings) is not first
    unblended = waves.at(plant, 1, Settings(blend=0.0))
    assert unblended is not first and not np.array_equal(unblended.moments, first.moments)
    assert np.array_equal(waves.made(1, plant, settings).moments, first.moments)


@pytest.mark.parametrize(
    ("told", "duration", "dt"),
    [({"drag": 0.5}, 120.0, None), ({}, 0.05 * KEPT + 0.1, None), ({}, 0.01 * KEPT + 0.1, 0.01)],
)
def test_waves_that_would_fill_the_memory_are_not_kept(told: dict[str, Any], duration: float, dt: float | None) -> None:
    """Long ones, and short ones on a fine grid."""
    plant, settings = gy.zhang2017(**told), Settings(blend=0.0)
    waves = Realisations(gy.SeaState(), (1,), duration, dt)
    assert waves.at(plant, 1, settings) is not waves.at(plant, 1, settings)


def test_phase_of_waves_is_kept_over_a_filling_of_the_lanes() -> None:
    """Three laws on sixteen realisations each, one piece after the other."""
    moments = np.random.default_rng(7).normal(size=(32, 400))
    first = [phase_of_moment(moment, 0.1, 3.1, 0, 400, 0.1) for moment in moments]
    assert all(phase_of_moment(m, 0.1, 3.1, 0, 400, 0.1) is one for m, one in zip(moments, first, strict=True))
