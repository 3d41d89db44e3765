"""Which sensors each law says that it reads: those, and no other, change its command."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rule_based_laws import LAWS

import gyroctl as gy
from gyroctl.harness.protocol import Sensing
from gyroctl.plant.measurement import CHANNELS, Measurement

N, PERIOD, WP = 22.5, 0.1, 3.14

SENSING = (*LAWS, "constant", "scheduled_lqr", "scheduled_lmi", "supervisor")


def course() -> np.ndarray[Any, Any]:
    """Readings (samples, 7): a flywheel comes to speed, a locked ring begins to sway, the waves have deep lulls."""
    t = PERIOD * np.arange(900)
    psi = WP * t + 1.2 + (0.1 + 1.5 * np.clip(t / 10.0 - 3.0, 0.0, 1.0)) * np.sin(0.5 * t)
    psi_rate = np.gradient(psi, PERIOD)
    size = 0.11 * (1.0 - 0.9 * np.sin(0.07 * t) ** 8)
    phi1, phi3 = size * np.cos(WP * t), -size * np.sin(WP * t)
    rates = -WP * size * np.sin(WP * t), -WP * size * np.cos(WP * t)
    spin = N * WP * np.minimum(t / 20.0, 1.0) + 1.0 + np.sin(0.2 * t)
    return np.stack([psi, psi_rate, spin, phi1, phi3, *rates], axis=1)


def commands(law: Any, readings: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    state, found = law.init(), []
    for i, row in enumerate(readings):
        command, state = law.step(i * PERIOD, Measurement(*row.tolist()), state)
        found.append(command)
    return np.array(found)


@pytest.mark.parametrize("name", SENSING)
def test_a_law_reads_the_sensors_that_it_names(name: str) -> None:
    """Each reading off by a fifth of its swing, never lost, from the second sample on: at the first all may be read."""
    law = gy.law(name)
    assert isinstance(law, Sensing)
    readings = course()
    plain, swing = commands(law, readings), np.minimum(np.std(readings, axis=0), 1.0)
    wobble = 0.2 * (np.sin(0.37 * np.arange(len(readings))) + 0.4)
    wobble[0] = 0.0
    read = []
    for i, channel in enumerate(CHANNELS):
        other = readings.copy()
        other[:, i] += swing[i] * wobble
        if not np.array_equal(commands(law, other), plain):
            read.append(channel)
    assert tuple(read) == law.sensors


def test_the_supervisor_reads_what_the_law_within_reads() -> None:
    """A law that does not say what it reads may read all."""
    assert "phi1" not in gy.law("supervisor", wraps="threshold").sensors
    assert "phi1" in gy.law("supervisor", wraps="coupling").sensors

    class Silent:
        period, information = 0.1, "sensors"

        def init(self) -> tuple[()]:
            return ()

        def step(self, t: float, y: Measurement, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
            return (0.05, 1e-4 * y.phi3), state

    assert gy.law("supervisor", wraps=Silent()).sensors == CHANNELS
