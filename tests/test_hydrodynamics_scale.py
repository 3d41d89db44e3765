"""Radiation fits know no size: a float enlarged by Froude's law has the same fit in its own units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Hydrodynamics, fit_radiation, shipped
from gyroctl.hydrodynamics.check import check
from gyroctl.hydrodynamics.radiation import assess, radiation_function
from gyroctl.hydrodynamics.scale import damping_ratio, frequency_ratio, length


def enlarged(hydro: Hydrodynamics, factor: float, rho: float = 1000.0, g: float = 9.81) -> Hydrodynamics:
    """Froude's law written out: lengths by `factor`, times by its root, forces by density, gravity and volume."""
    heavier, time = rho / hydro.rho, np.sqrt(factor * hydro.g / g)
    inertia, moment = heavier * factor**5, heavier * g / hydro.g * factor**4
    return replace(
        hydro,
        omega=hydro.omega / time,
        added_mass=inertia * hydro.added_mass,
        added_mass_inf=inertia * hydro.added_mass_inf,
        damping=inertia / time * hydro.damping,
        excitation=moment / factor * hydro.excitation,
        stiffness=moment * hydro.stiffness,
        depth=factor * hydro.depth,
        rho=rho,
        g=g,
        fits={
            name: tuple(
                (p * inertia / time ** np.arange(2, len(p) + 2), q / time ** np.arange(1, len(q) + 1)) for p, q in pair
            )
            for name, pair in hydro.fits.items()
        },
        froude_krylov=None,
        diffraction=None,
        hull=None,
        wetted=None,
    )


@pytest.mark.parametrize(("factor", "rho", "g"), [(2.0, 1000.0, 9.81), (50.0, 1025.0, 9.8), (0.1, 1000.0, 1.62)])
def test_an_enlarged_float_has_the_same_fit(factor: float, rho: float, g: float) -> None:
    model, full = fit_radiation(shipped(), 0), fit_radiation(enlarged(shipped(), factor, rho, g), 0)
    assert full.relative_rms == pytest.approx(model.relative_rms, rel=1e-6)
    assert full.damping_low / full.damping_low_table == pytest.approx(
        model.damping_low / model.damping_low_table, rel=1e-6
    )
    assert full.low_frequency == pytest.approx(1.2 * np.sqrt(g / 9.81 / factor), rel=1e-12)
    assert full.passivity.passive


def test_the_shipped_float_is_the_unit_to_the_bit() -> None:
    assert frequency_ratio(shipped()) == 1.0 and damping_ratio(shipped()) == 1.0
    assert length(shipped()) == pytest.approx((46.566e-3) ** 0.2, rel=1e-4)


@pytest.mark.parametrize("factor", [10.0, 20.0, 50.0])
def test_checks_of_the_fit_look_at_the_slow_mode_of_the_float(factor: float) -> None:
    """Coefficients that are right at one scale are judged alike at every other."""
    hydro = enlarged(shipped(), factor)
    ours, theirs = (assess(one, 0, *one.fits["paper"][0]) for one in (shipped(), hydro))
    assert theirs.damping_low / theirs.damping_low_table == pytest.approx(
        ours.damping_low / ours.damping_low_table, rel=1e-9
    )
    rows = {row.name: row for row in check(hydro).rows}
    slow = f"{1.2 / np.sqrt(factor):.4g} rad/s"
    assert rows[f"fit accurate phi1 at {slow}"].ok and rows[f"fit accurate phi3 at {slow}"].ok
    short = {row.name: row for row in check().rows}["fit accurate phi1 at 1.2 rad/s"].tolerance
    assert rows[f"fit accurate phi1 at {slow}"].tolerance == pytest.approx(short * factor**4.5)


def test_the_grid_of_the_fit_has_as_many_points_at_every_scale() -> None:
    few = len(radiation_function(shipped(), 0)[0])
    assert {len(radiation_function(enlarged(shipped(), s), 0)[0]) for s in (0.03, 3.0, 7.0, 20.0, 33.0)} == {few}


def test_a_rotation_that_makes_no_waves_has_a_passive_fit_of_zero() -> None:
    hydro = shipped()
    still = replace(
        hydro,
        added_mass=hydro.added_mass * np.array([[0.0], [1.0]]),
        damping=hydro.damping * np.array([[0.0], [1.0]]),
        added_mass_inf=hydro.added_mass_inf * np.array([0.0, 1.0]),
    )
    fit = fit_radiation(still, 0)
    assert not np.any(fit.p) and fit.passivity.stable and fit.passivity.passive and fit.relative_rms == 0.0
    assert np.all(np.roots([1.0, *fit.q]).real < 0.0)


def test_a_float_without_added_inertia_is_refused() -> None:
    with pytest.raises(InputError, match="added inertia of a body"):
        fit_radiation(replace(shipped(), added_mass_inf=np.array([-60.0, 38.0])), 0)
