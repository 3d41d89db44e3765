"""Statics and panels of the float, against closed forms of the sphere and against each other."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import group_velocity, wavenumber
from gyroctl.hydrodynamics.geometry import VARIANTS, Geometry, _submerged, statics
from gyroctl.hydrodynamics.mesh import Panels, hull, lid


def volume(panels: Panels) -> float:
    """Divergence theorem over the half hull, field (0, 0, z): the plane x = 0 and the water level add nothing."""
    a, b, c, d = (panels.vertices[panels.faces[:, k]] for k in range(4))
    total = 0.0
    for p, q, r in ((a, b, c), (a, c, d)):
        normal = 0.5 * np.cross(q - p, r - p)
        total += np.sum(normal[:, 2] * (p + q + r)[:, 2] / 3.0)
    return 2.0 * float(total)


def test_sphere_cut_by_the_water_level_has_the_closed_form_volume_and_centre() -> None:
    radius, height = 0.3, 0.07
    ball = Geometry(diameter=2 * radius, cylinder=0.0, inclination=25.0)
    found, centre, waterplane = _submerged(ball, height)
    depth = radius - height  # height of the cap below the water
    assert found == pytest.approx(np.pi * depth**2 * (3 * radius - depth) / 3, rel=1e-6)
    # centroid of a spherical cap, measured from the centre of the ball
    assert centre[2] == pytest.approx(height - 3 * (2 * radius - depth) ** 2 / (4 * (3 * radius - depth)), rel=1e-5)
    assert centre[1] == pytest.approx(0.0, abs=1e-6)
    area = np.pi * (radius**2 - height**2)
    arm = ball.arm * ball.axis[1]
    own = np.pi * (radius**2 - height**2) ** 2 / 4.0
    assert waterplane == pytest.approx(area * arm**2 + own, rel=1e-4)


def test_rest_position_and_stiffness_are_those_of_the_paper() -> None:
    rest = statics(Geometry())
    assert rest.k3 == pytest.approx(2945.0, rel=1e-3)
    assert rest.volume == pytest.approx(0.04656, rel=1e-3)
    assert rest.height == pytest.approx(0.0231, abs=2e-4)
    assert rest.hinge_height == pytest.approx(0.208, abs=5e-4)


def test_moments_about_the_hinge_balance() -> None:
    geometry = Geometry()
    rest = statics(geometry)
    arm = rest.centre[1] - geometry.hinge(rest.height)[1]
    assert geometry.rho * rest.volume * arm == pytest.approx(geometry.moment * geometry.axis[1], rel=1e-9)


def test_stiffness_is_the_derivative_of_the_buoyancy_moment() -> None:
    """Turn the lever by a small angle about the fixed hinge and difference the moment of the buoyancy."""
    geometry = Geometry()
    rest = statics(geometry)

    def moment(angle: float) -> float:
        turned = dataclasses.replace(geometry, inclination=geometry.inclination - np.rad2deg(angle))
        height = rest.hinge_height + (turned.arm * turned.axis)[2]
        found, centre, _ = _submerged(turned, height)
        return geometry.rho * geometry.g * found * float(centre[1] + turned.arm * turned.axis[1])

    step = 1e-3
    assert -(moment(step) - moment(-step)) / (2 * step) == pytest.approx(rest.k3, rel=1e-4)


def test_horizontal_lever_misses_the_stiffness_by_six_per_cent() -> None:
    assert statics(VARIANTS["horizontal"]).k3 / 2945.0 == pytest.approx(1.06, abs=0.01)


def test_panels_enclose_the_displaced_volume_with_normals_into_the_water() -> None:
    geometry = Geometry()
    rest = statics(geometry)
    errors = [rest.volume - volume(hull(geometry, rest.height, 14 * k, 9 * k)) for k in (1, 2)]
    assert 0.0 < errors[1] < 0.3 * errors[0]  # inscribed, second order
    assert volume(hull(geometry, rest.height)) == pytest.approx(rest.volume, rel=0.01)


def test_hull_and_lid_share_the_waterline() -> None:
    geometry = Geometry()
    rest = statics(geometry)
    wetted, cover = hull(geometry, rest.height, 12, 6), lid(geometry, rest.height, 12, 4)
    on_level = wetted.vertices[np.abs(wetted.vertices[:, 2]) < 1e-12]
    assert np.allclose(on_level, cover.vertices[:13], atol=1e-12)
    assert np.all(wetted.vertices[:, 0] >= -1e-12)
    assert np.all(cover.vertices[:, 2] == 0.0)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"diameter": -0.5}, "geometry.diameter"),
        ({"cylinder": -0.1}, "geometry.cylinder"),
        ({"inclination": 80.0}, "geometry.inclination"),
        ({"depth": float("nan")}, "geometry.depth"),
    ],
)
def test_impossible_geometry_is_refused(change: dict[str, float], field: str) -> None:
    with pytest.raises(InputError, match=field):
        Geometry(**change)


def test_masses_too_heavy_for_the_float_are_refused() -> None:
    with pytest.raises(InputError, match="no draft"):
        statics(Geometry(moment=500.0))


@pytest.mark.parametrize("depth", [0.7, 5.0, float("inf")])
def test_dispersion_relation(depth: float) -> None:
    omega = np.geomspace(0.05, 20.0, 40)
    k = wavenumber(omega, depth)
    assert np.allclose(9.81 * k * np.tanh(k * depth), omega**2, rtol=1e-12)
    step = 1e-6
    slope = 2 * step * omega / (wavenumber(omega * (1 + step), depth) - wavenumber(omega * (1 - step), depth))
    assert np.allclose(group_velocity(omega, depth), slope, rtol=1e-6)
