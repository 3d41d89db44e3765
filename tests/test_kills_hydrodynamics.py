"""Waves of any depth and the relation of damping and excitation, from their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from gyroctl.hydrodynamics import shipped
from gyroctl.hydrodynamics.dispersion import group_velocity, wavenumber
from gyroctl.hydrodynamics.haskind import haskind_damping
from gyroctl.hydrodynamics.passivity import certify
from gyroctl.hydrodynamics.table import Hydrodynamics

OMEGA = np.array([0.3, 1.0, 2.5, 5.0])


@pytest.mark.parametrize("depth", [0.5, 3.0, 50.0, np.inf])
def test_wavenumber_and_group_velocity_obey_the_dispersion_relation(depth: float) -> None:
    k = wavenumber(OMEGA, depth)
    np.testing.assert_allclose(OMEGA**2, 9.81 * k * np.tanh(k * depth), rtol=1e-12)
    step = 1e-6
    slope = 2.0 * step / (wavenumber(OMEGA + step, depth) - wavenumber(OMEGA - step, depth))
    np.testing.assert_allclose(group_velocity(OMEGA, depth), slope, rtol=1e-6)


@pytest.mark.parametrize(
    ("p", "q"),
    [([1.0, 0.0], [0.0, 1.0]), ([1.0, 1.0, 4.0], [1.0, 4.0, 4.0]), ([1.0, 0.0], [1.0, 0.0])],
    ids=["s^2 + 1", "(s + 1)(s^2 + 4)", "s (s + 1)"],
)
def test_pole_on_the_axis_is_not_stable(p: list[float], q: list[float]) -> None:
    """A wave that never dies away is no radiation."""
    found = certify(p, q)
    assert not found.stable and not found.passive


def test_damping_of_the_shipped_table_is_what_its_excitation_radiates() -> None:
    """Haskind's relation where the damping carries the table; both come from different problems."""
    hydro: Hydrodynamics = shipped()
    other = haskind_damping(hydro)
    assert other is not None
    carries = hydro.damping > 0.3 * hydro.damping.max(axis=1, keepdims=True)
    np.testing.assert_allclose(other[carries], hydro.damping[carries], rtol=0.1)
