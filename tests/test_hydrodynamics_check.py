"""The table of checks: it holds for the shipped data and notices each kind of fault."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gyroctl.hydrodynamics import shipped
from gyroctl.hydrodynamics.check import check
from gyroctl.hydrodynamics.database import SHIPPED
from gyroctl.hydrodynamics.haskind import haskind_damping, haskind_error
from gyroctl.hydrodynamics.table import Hydrodynamics


def failing(hydro: Hydrodynamics) -> set[str]:
    return {row.name for row in check(hydro).rows if not row.ok}


def test_shipped_database_holds_every_check() -> None:
    report = check()
    assert report.ok, str(report)
    names = {row.name for row in report.rows}
    assert {"k3", "Jh1", "Jh3", "Haskind phi1", "Haskind phi3", "fit accurate phi1 passive"} <= names
    assert str(report) == str(check(SHIPPED))
    assert all(row.name in str(report) for row in report.rows)


def test_haskind_holds_within_two_per_cent_of_the_damping_itself_where_the_device_works() -> None:
    hydro = shipped()
    band = hydro.omega <= 12.0
    other = haskind_damping(hydro)
    assert other is not None
    assert np.max(np.abs(other / hydro.damping - 1.0)[:, band]) < 0.02


def test_haskind_needs_the_whole_circle() -> None:
    hydro = shipped()
    half = hydro.headings <= 180.0
    whole = dataclasses.replace(hydro, froude_krylov=None, diffraction=None)
    part = dataclasses.replace(whole, headings=hydro.headings[half], excitation=hydro.excitation[:, half])
    assert haskind_error(part) is None
    assert not {row.name for row in check(part).rows if row.name.startswith("Haskind")}


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda h: {"stiffness": 1.02 * h.stiffness}, "k3"),
        (lambda h: {"added_mass_inf": h.added_mass_inf * np.array([1.02, 1.0])}, "Jh1"),
        (lambda h: {"added_mass_inf": h.added_mass_inf * np.array([1.0, 1.02])}, "Kramers-Kronig phi3"),
        (lambda h: {"excitation": 1.02 * h.excitation}, "Haskind phi1"),
        (lambda h: {"coupling": 0.01}, "coupling of phi1 and phi3"),
        (lambda h: {"added_mass": h.added_mass + 0.5 * (np.abs(h.omega - 4.0) < 0.3)}, "Kramers-Kronig constancy phi1"),
        (
            lambda h: {"fits": {"accurate": tuple((p - np.eye(3)[2] * 2.0 * p[2], q) for p, q in h.fits["accurate"])}},
            "fit accurate phi1 passive",
        ),
        (lambda h: {"fits": {"accurate": h.fits["paper"]}}, "fit accurate phi1 at 1.2 rad/s"),
    ],
)
def test_each_fault_is_noticed(change: object, name: str) -> None:
    hydro = shipped()
    broken = dataclasses.replace(hydro, **change(hydro))  # type: ignore[operator]
    assert name not in failing(hydro)
    assert name in failing(broken)


def test_turned_sign_of_one_heading_breaks_the_mirror() -> None:
    hydro = shipped()
    turned = hydro.excitation.copy()
    turned[0, 0] *= -1.0
    assert "mirrored headings" in failing(dataclasses.replace(hydro, excitation=turned))
