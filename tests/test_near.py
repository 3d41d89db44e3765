"""Moments next to the float: what a realisation holds along the reach against what acts at the float's own position."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.plant.beyond import HALF
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PSI_RATE
from gyroctl.plant.kernel import hold_one, rows
from gyroctl.plant.near import standing
from gyroctl.plant.reduced import POWERS

Array = NDArray[Any]

ANGLES = (0.0, 0.033, -0.31, 0.58, np.pi - 0.2, np.pi + 0.43, 0.1 - np.pi, 2.0 * np.pi - 0.36)
"""phi1, the float also turned over: between places, on them, and where one ends. [rad]"""


def moving(x: Array) -> Array:
    """Me1 and Me3 at places x, in reaches. [Nm]"""
    return np.stack([100.0 * np.cos(1.3 * x + 0.7), 60.0 * np.sin(1.1 * x - 0.2) + 40.0])


def undisturbed(s: Array) -> Array:
    """F1 and F3 at sin phi1. [Nm]"""
    return np.stack([50.0 - 30.0 * s + 9.0 * s**2 + 2.0 * s**4, 200.0 + 80.0 * s - 50.0 * s**3])


def signals(reduced: bool) -> Array:
    """Signals of an instant, in the order of `Plant.channels`."""
    powers = np.zeros((2, POWERS))
    powers[0, [0, 1, 2, 4]], powers[1, [0, 1, 3]] = (50.0, -30.0, 9.0, 2.0), (200.0, 80.0, -50.0)
    rest = moving(np.zeros(1))[:, 0]
    return np.concatenate([rest, powers.ravel() if reduced else [], moving(np.arange(-HALF, HALF + 1) / HALF).ravel()])


def slope_in_kernel(plant: gy.Plant, x: Array, values: Array) -> Array:
    """Rate of change that a short step of the compiled kernel shows, in waves that stand still."""
    h, y = 1e-6, np.zeros(rows(plant.coefficients))
    y[: x.size] = x
    after = hold_one(y, plant.coefficients, 0.0, 0.0, 1.0, h, 1, np.tile(values, 60), 0.05)
    return (after - y)[PHI1_RATE : PHI1_RATE + 2] / h


@pytest.mark.parametrize("choices", [{}, {"wetted": "reduced"}])
def test_moments_are_those_at_the_float(choices: dict[str, Any]) -> None:
    """A plant whose moments stay at rest, told those at the place where the float is, moves alike."""
    plant, still = gy.zhang2017(position="moving", **choices), gy.zhang2017(**choices)
    for angle in ANGLES:
        x = np.zeros(len(plant.labels))
        x[PHI1], s = angle, np.sin(angle)
        there = np.concatenate([moving(s), undisturbed(s) if choices else []])
        expected = still.derivative(x, (0.0, 0.0), there)[PHI1_RATE : PHI1_RATE + 2]
        values = signals(bool(choices))
        own = plant.derivative(x, (0.0, 0.0), values)[PHI1_RATE : PHI1_RATE + 2]
        np.testing.assert_allclose(own, expected, rtol=0.0, atol=4e-6 * np.max(np.abs(expected)))
        np.testing.assert_allclose(slope_in_kernel(plant, x, values), expected, atol=5e-6 * np.max(np.abs(expected)))


def test_place_is_the_nearest_one() -> None:
    for angle in np.linspace(-7.0, 7.0, 1001):
        number, sense, place = standing(angle)
        assert abs(number - HALF - HALF * np.sin(angle)) <= 0.5 + 1e-9
        assert np.sin(place) == pytest.approx((number - HALF) / HALF, abs=1e-12)
        assert sense * np.cos(angle) >= 0.0 and abs(place - angle) < 0.33
    assert np.isfinite(standing(np.inf)).all() and np.isfinite(standing(np.nan)).all()


def test_what_is_kept_is_what_would_be_made_anew() -> None:
    """Three seconds in one go and step by step, where nothing can be kept: the float passes from place to place."""
    plant = gy.zhang2017(position="moving", wetted="reduced", drag=0.5)
    waves = gy.realise(plant, gy.SeaState(gamma=5.0), 1, 30.0)
    flat, k = np.ascontiguousarray(waves.signals(plant).T).ravel(), plant.coefficients
    y = np.zeros(rows(k))
    y[PHI1], y[PHI1_RATE], y[PSI_RATE], y[OMEGA_RATE] = -0.2, 0.5, 3.14, 70.0
    whole, steps, places = hold_one(y, k, 0.05, 3e-4, 10.0, 3.0, 300, flat, 0.05), y, set()
    for i in range(300):
        places.add(standing(steps[PHI1])[0])
        steps = hold_one(steps, k, 0.05, 3e-4, 10.0 + 0.01 * i, 0.01, 1, flat, 0.05)
    assert len(places) > 3
    np.testing.assert_allclose(steps, whole, rtol=1e-9, atol=1e-9)
