"""Interpolated wave moments: exact at the table, smooth between, periodic in heading."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import ExcitationTable, excitation_table, shipped


def test_tabulated_values_come_back() -> None:
    hydro = shipped()
    table = excitation_table(hydro)
    for k in (0, 3, len(hydro.headings) - 1):
        assert np.allclose(table(hydro.omega, float(hydro.headings[k])), hydro.excitation[:, k], rtol=1e-12)


def test_every_second_frequency_predicts_the_others() -> None:
    """Interpolating with half the table errs far more than with the whole one, and still little where the waves are."""
    hydro = shipped()
    keep = np.arange(0, len(hydro.omega), 2)
    sparse = ExcitationTable(hydro.omega[keep], hydro.headings, hydro.excitation[:, :, keep])
    left_out = np.arange(1, len(hydro.omega) - 1, 2)
    left_out = left_out[(hydro.omega[left_out] > 0.4) & (hydro.omega[left_out] < 10.0)]
    he = hydro.excitation[:, 0, left_out]
    gap = np.abs(sparse(hydro.omega[left_out]) - he) / np.max(np.abs(hydro.excitation[:, 0]), axis=1)[:, None]
    assert np.max(gap) < 2e-3


def test_every_second_heading_predicts_the_others() -> None:
    hydro = shipped()
    table = ExcitationTable(hydro.omega, hydro.headings[::2], hydro.excitation[:, ::2])
    band = hydro.omega < 6.0
    scale = np.max(np.abs(hydro.excitation), axis=(1, 2))[:, None]
    for k in (1, 5, 13):
        gap = np.abs(table(hydro.omega, float(hydro.headings[k])) - hydro.excitation[:, k])[:, band]
        assert np.max(gap / scale) < 5e-3


def test_no_moment_outside_the_table() -> None:
    table = excitation_table(shipped())
    assert np.all(table([0.1, 0.0, 17.0]) == 0.0)
    assert np.all(np.abs(table([0.2, 16.0])) > 0.0)


@pytest.mark.parametrize("heading", [-90.0, 270.0, 630.0, 12.0, 372.0])
def test_heading_is_periodic(heading: float) -> None:
    table = excitation_table(shipped())
    assert np.allclose(table([2.0, 3.14], heading), table([2.0, 3.14], heading % 360.0), rtol=1e-10)


def test_mirrored_waves_push_the_other_way_sideways_and_the_same_way_up() -> None:
    table = excitation_table(shipped())
    there, back = table([3.14], 20.0), table([3.14], 160.0)
    assert there[0] == pytest.approx(-back[0], rel=1e-3)
    assert there[1] == pytest.approx(back[1], rel=1e-3)
    assert abs(table([3.14], 90.0)[0, 0]) < 1e-3 * abs(there[0, 0])  # along the lever nothing pushes sideways


def test_the_two_moments_are_82_degrees_apart_at_the_peak() -> None:
    he = excitation_table(shipped())([3.14])[:, 0]
    assert np.rad2deg(np.angle(he[0] / he[1])) == pytest.approx(82.0, abs=1.0)


def test_magnitude_drops_the_phases_only() -> None:
    omega = np.linspace(0.5, 8.0, 20)
    full, bare = excitation_table(shipped()), excitation_table(shipped(), "magnitude")
    assert np.allclose(bare(omega), np.abs(full(omega)))
    assert np.all(bare(omega).imag == 0.0)
    assert bare.sha256 != full.sha256


def test_partial_circle_refuses_what_it_does_not_hold() -> None:
    hydro = shipped()
    half = hydro.headings <= 180.0
    table = ExcitationTable(hydro.omega, hydro.headings[half], hydro.excitation[:, half])
    assert np.allclose(table([3.0], 180.0), excitation_table(hydro)([3.0], 180.0), rtol=1e-9)
    with pytest.raises(InputError, match=r"sea\.heading"):
        table([3.0], 200.0)


def test_one_heading_serves_itself_alone() -> None:
    hydro = shipped()
    table = ExcitationTable(hydro.omega, hydro.headings[:1], hydro.excitation[:, :1])
    assert np.allclose(table([3.05], 0.0), hydro.excitation[:, 0, np.isclose(hydro.omega, 3.05)])
    with pytest.raises(InputError, match=r"sea\.heading"):
        table([3.0], 5.0)


def test_bad_arguments() -> None:
    with pytest.raises(InputError, match=r"excitation\.phase"):
        dataclasses.replace(excitation_table(shipped()), phase="angle")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"sea\.heading"):
        excitation_table(shipped())([3.0], float("nan"))
