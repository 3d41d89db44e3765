"""Moments of the pressure over the wetted surface, against plain sums of components over finer panels."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.hydrodynamics import shipped
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.geometry import Geometry
from gyroctl.hydrodynamics.panels import Hull, capsule
from gyroctl.plant.wetted import ALONG, DOWN, PRESSURE, ROWS, beyond_linear, evaluate, surface_moments
from gyroctl.waves.pressure import SHORTEST, powers_along, powers_down, pressure_rows, wetted_surface

DEPTH, RHO, G = 0.7, 1000.0, 9.81
OMEGA = np.linspace(0.4, 7.6, 73)


def instants(seed: int, count: int, heading: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Complex amplitudes (k, count) of a random sea at random instants, and rows of the polynomials (count, ROWS)."""
    rng = np.random.default_rng(seed)
    amplitude = np.sqrt(2.0 * gy.SeaState().spectrum(OMEGA) * 0.1) * np.exp(2j * np.pi * rng.uniform(size=OMEGA.size))
    turned = amplitude[:, None] * np.exp(1j * OMEGA[:, None] * rng.uniform(0.0, 60.0, count))
    hull = shipped().hull
    assert hull is not None
    rows = (pressure_rows(wetted_surface(hull, DEPTH, heading), OMEGA) @ turned).real.T
    return turned, np.ascontiguousarray(rows)


def plain(hull: Hull, waves: np.ndarray, phi1: float, phi3: float, heading: float = 0.0) -> np.ndarray:
    """M1, M3: rotation matrices, components summed at every panel, and only panels with their middle in the water."""
    down = np.array([[np.cos(phi1), np.sin(phi1), 0.0], [-np.sin(phi1), np.cos(phi1), 0.0], [0.0, 0.0, 1.0]])
    up = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(phi3), -np.sin(phi3)], [0.0, np.sin(phi3), np.cos(phi3)]])
    arms, areas = hull.patches.centres @ (down @ up).T, hull.patches.normals @ (down @ up).T
    x, y, z = (arms + hull.hinge).T
    xi = x * np.cos(np.deg2rad(heading)) + y * np.sin(np.deg2rad(heading))
    k = wavenumber(OMEGA, DEPTH)[:, None]
    field = waves[:, None] * np.exp(-1j * k * xi)
    eta = field.real.sum(axis=0)
    stretched = np.minimum(DEPTH * (DEPTH + z) / (DEPTH + eta) - DEPTH, 0.0)
    wave = (field.real * np.cosh(k * (DEPTH + stretched)) / np.cosh(k * DEPTH)).sum(axis=0)
    pressure = np.where(z < eta, RHO * G * (wave - z), 0.0)
    moment = -np.sum(pressure[:, None] * np.cross(arms, areas), axis=0)
    return np.array([-moment[2], moment @ down[:, 0]])


@pytest.mark.parametrize("heading", [0.0, 90.0, 210.0])
def test_moments_are_those_of_plain_sums_over_finer_panels(heading: float) -> None:
    coarse, fine = shipped().hull, capsule(Geometry(), None, 96, 48)
    assert coarse is not None
    surface, work = wetted_surface(coarse, DEPTH, heading), np.empty((7, 1120))
    waves, rows = instants(3, 12, heading)
    rng = np.random.default_rng(4)
    phi1, phi3 = 0.25 * rng.standard_normal(12), 0.1 * rng.standard_normal(12)
    found = np.array([surface_moments(surface, phi1[i], phi3[i], rows[i], work) for i in range(12)])
    truth = np.array([plain(fine, waves[:, i], phi1[i], phi3[i], heading) for i in range(12)])
    # deviations of M1 and M3 at heading 0 are 60 and 300 Nm
    assert np.max(np.abs(found - truth), axis=0) == pytest.approx([0.0, 0.0], abs=2.5)


def test_instants_have_the_same_bits_alone_and_together_and_the_same_numbers_in_python() -> None:
    hull = shipped().hull
    assert hull is not None
    surface, work = wetted_surface(hull, DEPTH), np.empty((7, 1120))
    _, rows = instants(5, 2)
    out = np.empty((2, 2))
    evaluate(surface, np.array([0.1, -0.3]), np.array([-0.1, 0.2]), rows, out)
    alone = np.empty((2, 1))
    evaluate(surface, np.array([-0.3]), np.array([0.2]), rows[1:], alone)
    np.testing.assert_array_equal(alone[:, 0], out[:, 1])
    # the compiled sine is a polynomial, that of Python the library's
    assert beyond_linear(surface, -0.3, 0.2, rows[1], work) == pytest.approx(tuple(out[:, 1]), abs=1e-9)


def test_nothing_is_added_in_small_waves() -> None:
    """The rest is of second order: at a tenth of the waves and the motion it is a hundredth."""
    hull = shipped().hull
    assert hull is not None
    surface = wetted_surface(hull, DEPTH)
    _, rows = instants(6, 400)
    rng = np.random.default_rng(7)
    phi1, phi3 = 0.2 * rng.standard_normal(400), 0.08 * rng.standard_normal(400)
    sizes = []
    for scale in (1e-1, 1e-2):
        out = np.empty((2, 400))
        evaluate(surface, scale * phi1, scale * phi3, scale * rows, out)
        sizes.append(np.sqrt(np.mean(out**2, axis=1)))
    assert np.all(sizes[1] < 0.03 * sizes[0])


def test_polynomials_converge_with_their_degrees() -> None:
    k = wavenumber(OMEGA, DEPTH)
    span, below, s, z = 0.82, 0.565, np.linspace(-1.0, 1.0, 41), np.linspace(-1.0, 0.0, 21)
    wave = np.exp(-1j * k[:, None] * span * s)
    decay = np.cosh(k[:, None] * (DEPTH + below * z)) / np.cosh(k[:, None] * DEPTH)

    def along(count: int) -> float:
        return float(
            np.max(np.abs(np.einsum("pk,ps->ks", powers_along(k * span, count), s ** np.arange(count)[:, None]) - wave))
        )

    def down(count: int) -> float:
        powers = z ** np.arange(count)[:, None]
        return float(np.max(np.abs(np.einsum("pk,pz->kz", powers_down(k * below, k * DEPTH, count), powers) - decay)))

    assert along(ALONG) < 0.01 and down(DOWN) < 0.005
    assert along(7) > 10.0 * along(9) > 10.0 * along(11) > 50.0 * along(13)
    assert down(3) > 5.0 * down(4) > 20.0 * down(5)


def test_rows_are_linear_moments_at_a_displaced_place() -> None:
    """Both from panels: over all headings and frequencies, and turned by exp(-i k X) where the float is displaced."""
    from gyroctl.hydrodynamics.undisturbed import froude_krylov

    hull = shipped().hull
    assert hull is not None
    for heading in (0.0, 60.0):
        surface = wetted_surface(hull, DEPTH, heading)
        rows = pressure_rows(surface, OMEGA)
        truth = froude_krylov(hull, OMEGA, np.array([heading]), DEPTH)[:, 0]
        at_rest = rows[[PRESSURE, PRESSURE + ALONG]]
        assert np.all(np.max(np.abs(at_rest - truth), axis=1) < 2e-3 * np.max(np.abs(truth), axis=1))
        place = hull.reach * np.sin(0.4) * np.cos(np.deg2rad(heading))
        turned = truth * np.exp(-1j * wavenumber(OMEGA, DEPTH) * place)
        powers = (place / surface.span) ** np.arange(ALONG)
        found = np.einsum("jpk,p->jk", rows[PRESSURE:].reshape(2, ALONG, -1), powers)
        assert np.all(np.max(np.abs(found - turned), axis=1) < 5e-3 * np.max(np.abs(truth), axis=1))


def test_short_waves_are_left_out_and_deep_water_has_none_of_the_bottom() -> None:
    hull = shipped().hull
    assert hull is not None
    surface = wetted_surface(hull, np.inf)
    omega = np.array([3.0, 12.0])
    rows = pressure_rows(surface, omega)
    assert wavenumber(omega, np.inf)[1] * surface.span > SHORTEST
    assert np.all(rows[:, 1] == 0.0) and rows.shape == (ROWS, 2)
    z = -0.3 / surface.below
    head = sum(rows[n * ALONG, 0] * z**n for n in range(DOWN))
    assert head == pytest.approx(np.exp(-0.3 * 9.0 / 9.81), abs=2e-3)
