"""Locked orbits beyond the linear model: the whole period where the symmetry fails, the same result where it holds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.linearisation.held_flow import HeldFlow
from gyroctl.orbits.flow import Forcing, flow
from gyroctl.orbits.modes import find_modes
from gyroctl.orbits.monodromy import monodromy
from gyroctl.orbits.orbit_map import OrbitMap
from gyroctl.orbits.symmetry import free_rows, reflect
from gyroctl.plant import Parameters

WAVE = gy.Regular(height=0.2, wp=3.14)
SMOOTH: dict[str, Any] = {"drag": 0.5, "coupling_slip": 60.0, "bearing": 0.01, "windage": 9.1e-7}


def defect(plant: gy.Plant) -> float:
    """How far half a period is from a mirror."""
    orbit = gy.lock_orbit(plant, WAVE, 0.052, 1e-4)
    half = flow(plant, orbit.x, 0.052, 1e-4, Forcing.of(plant, WAVE), 0.5)[: orbit.x.size]
    free = free_rows(plant)
    return float(np.max(np.abs((reflect(half, 1) - orbit.x)[free])))


@pytest.mark.slow
def test_symmetry_holds_but_for_the_position() -> None:
    assert defect(gy.zhang2017(**SMOOTH)) < 1e-8
    assert defect(gy.zhang2017(position="moving", drag=0.5)) > 1e-3


def test_both_periods_give_the_same_orbit_where_the_symmetry_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    plant = gy.zhang2017(**SMOOTH)
    half = gy.lock_orbit(plant, WAVE, 0.052, 1e-4)
    monkeypatch.setattr(Parameters, "symmetric", property(lambda self: False))
    whole = gy.lock_orbit(plant, WAVE, 0.052, 1e-4)
    np.testing.assert_allclose(whole.x, half.x, atol=1e-8)
    np.testing.assert_allclose(np.sort(np.abs(whole.multipliers)), np.sort(np.abs(half.multipliers)), atol=1e-7)
    assert whole.power == pytest.approx(half.power, rel=1e-8)
    assert whole.load_angle == pytest.approx(half.load_angle, abs=1e-5)
    assert whole.error < 1e-8
    slow = [min(abs(mode.rate) for mode in find_modes(orbit)) for orbit in (whole, half)]
    assert slow[0] == pytest.approx(slow[1], rel=1e-6)


def test_moving_orbit_repeats_and_its_multipliers_are_those_of_the_flow() -> None:
    """Against finite differences of the whole flow, and the casadi text with its own steps."""
    plant = gy.zhang2017(position="moving", drag=0.5, bearing=0.01)
    orbit = gy.lock_orbit(plant, WAVE, 0.052, 1e-4)
    n, forcing, free = orbit.x.size, orbit.forcing, free_rows(plant)
    assert orbit.status == "stable"
    assert orbit.error < 1e-6
    end = flow(plant, orbit.x, 0.052, 1e-4, forcing, 1.0)[:n]
    end[2] -= 2.0 * np.pi
    assert np.max(np.abs((end - orbit.x)[free])) < 1e-8
    columns = []
    for row in free:
        h = 1e-6 * np.eye(n)[row]
        ends = [flow(plant, orbit.x + sign * h, 0.052, 1e-4, forcing, 1.0)[:n] for sign in (1.0, -1.0)]
        columns.append((ends[0] - ends[1])[free] / 2e-6)
    exact = monodromy(orbit)
    np.testing.assert_allclose(np.stack(columns, axis=1), exact, atol=2e-3 * np.max(np.abs(exact)))
    np.testing.assert_allclose(monodromy(orbit, "casadi"), exact, atol=2e-3 * np.max(np.abs(exact)))


def test_map_takes_the_whole_period_by_itself() -> None:
    plant = gy.zhang2017(position="moving", drag=0.5)
    orbit = gy.lock_orbit(plant, WAVE, 0.052, 1e-4)
    orbit_map = OrbitMap(plant, orbit.wave, 0.052, 1e-4, parameters=("cc", "height", "d1"))
    assert not orbit_map.symmetric
    x, at = orbit.x[free_rows(plant)], np.array([0.052, 0.2, 2.0])
    found = orbit_map.evaluate(x, at)
    np.testing.assert_allclose(found.image, x, atol=1e-7)
    for i, h in enumerate((1e-6, 1e-6, 1e-5)):
        step = h * np.eye(3)[i]
        ends = [orbit_map.evaluate(x, at + sign * step, derivative=False).image for sign in (1.0, -1.0)]
        difference = (ends[0] - ends[1]) / (2.0 * h)
        np.testing.assert_allclose(found.by_parameter[:, i], difference, atol=2e-3 * np.max(np.abs(difference)))


def test_held_additions_to_a_moment_act_at_every_position() -> None:
    """A constant moment on phi1 does the same whether it is told at rest or over all positions."""
    flows = [HeldFlow(p, Forcing.of(p, WAVE), 20, 0.1) for p in (gy.zhang2017(), gy.zhang2017(position="moving"))]
    x = np.zeros(len(flows[0].plant.labels))
    B = [f.jacobian(x, 0.05, 1e-4, 3)[1] for f in flows]
    np.testing.assert_allclose(B[1][:, 2:], B[0][:, 2:], rtol=2e-2, atol=1e-2 * np.max(np.abs(B[0][:, 2:])))
