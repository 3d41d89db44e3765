"""The hull in panels: exact volumes, stiffness, Froude-Krylov moments, a mesh of one's own, the parts of a database."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Hydrodynamics, load, save, shipped
from gyroctl.hydrodynamics.check import check
from gyroctl.hydrodynamics.geometry import Geometry, _submerged, statics
from gyroctl.hydrodynamics.importers import Site, import_results
from gyroctl.hydrodynamics.keeping import with_bits_of
from gyroctl.hydrodynamics.panels import Hull, capsule, read_hull
from gyroctl.hydrodynamics.undisturbed import completed, froude_krylov, panel_stiffness
from gyroctl.plant.wetted import ROWS, evaluate
from gyroctl.waves.pressure import wetted_surface

ANGLES = np.array([-0.35, -0.25, -0.2, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15, 0.2, 0.23])


def buoyancy_moment(hull: Hull, angles: np.ndarray) -> np.ndarray:
    """Moment of still water about x3 from the compiled evaluation. [Nm]"""
    bare = wetted_surface(hull, 0.7)._replace(still=0.0, stiffness=0.0)
    out = np.empty((2, len(angles)))
    evaluate(bare, np.full(len(angles), 0.3), angles, np.zeros((len(angles), ROWS)), out)
    assert np.max(np.abs(out[0])) < 1e-9  # still water does not turn the lever about the vertical
    return out[1]


@pytest.mark.parametrize("cylinder", [0.08, 0.0])
def test_buoyancy_at_any_immersion_is_that_of_the_exact_volume(cylinder: float) -> None:
    geometry = Geometry(cylinder=cylinder)
    rest = statics(geometry)
    exact = []
    for angle in ANGLES:
        turned = dataclasses.replace(geometry, inclination=geometry.inclination - np.rad2deg(angle))
        volume, centre, _ = _submerged(turned, rest.hinge_height + (turned.arm * turned.axis)[2])
        exact.append(9810.0 * volume * (centre[1] + turned.arm * turned.axis[1]))
    found = buoyancy_moment(capsule(geometry), ANGLES)
    assert np.max(np.abs(found - exact)) < 0.002 * exact[5]


def test_sphere_has_the_volume_of_a_spherical_cap() -> None:
    """Lever horizontal: the moment is the cap's weight of water times its exact arm."""
    geometry = Geometry(cylinder=0.0, inclination=0.0)
    height, radius, hull = statics(geometry).height, 0.275, capsule(geometry)
    angles = np.arcsin(np.array([-0.25, -0.1, 0.0, 0.1]) / geometry.arm)
    centre = height + np.array([-0.25, -0.1, 0.0, 0.1])
    depth = np.clip(radius - centre, 0.0, 2.0 * radius)
    exact = 9810.0 * np.pi * depth**2 * (3.0 * radius - depth) / 3.0 * geometry.arm * np.cos(angles)
    assert np.max(np.abs(buoyancy_moment(hull, angles) - exact)) < 0.002 * exact[2]


def test_volume_and_stiffness_converge_with_the_panels() -> None:
    geometry = Geometry()
    rest = statics(geometry)
    errors = [abs(panel_stiffness(capsule(geometry, rest, 16 * n, 8 * n)) / rest.k3 - 1.0) for n in (1, 2, 4)]
    assert errors[1] < 0.005
    assert errors[2] < 0.4 * errors[1] < 0.2 * errors[0]
    assert wetted_surface(capsule(geometry), 0.7).stiffness == pytest.approx(rest.k3, rel=0.005)
    weight = 9.81 * geometry.moment * geometry.axis[1]
    assert wetted_surface(capsule(geometry), 0.7).still == pytest.approx(weight, rel=2e-3)


def test_froude_krylov_of_the_panels_is_the_excitation_less_the_diffraction() -> None:
    hydro = shipped()
    assert hydro.hull is not None and hydro.diffraction is not None
    low = hydro.omega <= 8.0
    panels = froude_krylov(hydro.hull, hydro.omega[low], hydro.headings, 0.7)
    apart = (hydro.excitation - hydro.diffraction)[..., low]
    for j in range(2):
        assert np.max(np.abs(panels[j] - apart[j])) < 0.02 * np.max(np.abs(apart[j]))


def test_parts_of_the_shipped_excitation_at_the_peak() -> None:
    """Undisturbed waves alone would turn phi1 two thirds as much, and phi3 a sixth more."""
    hydro = shipped()
    assert hydro.froude_krylov is not None
    i = int(np.argmin(np.abs(hydro.omega - 3.1)))
    share = np.abs(hydro.froude_krylov[:, 0, i]) / np.abs(hydro.excitation[:, 0, i])
    assert share == pytest.approx([0.66, 1.16], abs=0.01)


def test_check_tells_the_parts_from_the_whole() -> None:
    rows = {row.name: row for row in check(shipped()).rows}
    names = (
        "FK + diffraction phi1",
        "FK + diffraction phi3",
        "Froude-Krylov phi1",
        "Froude-Krylov phi3",
        "k3 of the hull",
    )
    assert all(rows[name].ok for name in names)
    hydro = shipped()
    assert hydro.diffraction is not None
    wrong = dataclasses.replace(hydro, diffraction=1.05 * hydro.diffraction)
    failed = {row.name for row in check(wrong).rows if not row.ok}
    assert {"FK + diffraction phi1", "FK + diffraction phi3", "Froude-Krylov phi1"} <= failed


def test_database_keeps_hull_parts_and_fit_bit_by_bit(tmp_path: Path) -> None:
    hydro = shipped()
    again = load(save(hydro, tmp_path / "again.nc"))
    assert hydro.hull is not None and again.hull is not None
    for name in ("vertices", "faces", "hinge"):
        np.testing.assert_array_equal(getattr(again.hull, name), getattr(hydro.hull, name))
    assert (again.hull.inclination, again.wetted) == (hydro.hull.inclination, hydro.wetted)
    for part in ("froude_krylov", "diffraction", "excitation"):
        np.testing.assert_array_equal(getattr(again, part), getattr(hydro, part))


def test_geometry_of_the_shipped_hull() -> None:
    hull = shipped().hull
    assert hull is not None
    assert hull.reach == pytest.approx(1.0652 * np.cos(np.deg2rad(10.0)))
    assert hull.inclination == 10.0
    assert hull.volume == pytest.approx(np.pi * 0.275**2 * (0.08 + 4.0 / 3.0 * 0.275), rel=1e-12)


def bare() -> Hydrodynamics:
    return dataclasses.replace(shipped(), froude_krylov=None, diffraction=None, hull=None, wetted=None)


@pytest.mark.slow
def test_import_of_results_without_parts_takes_them_from_a_mesh(tmp_path: Path) -> None:
    whole = import_results(save(bare(), tmp_path / "bare.nc"), "capytaine", tmp_path / "out.nc", Site(), shipped().hull)
    found, hydro = load(whole), shipped()
    assert found.froude_krylov is not None and found.diffraction is not None and hydro.froude_krylov is not None
    low = hydro.omega <= 8.0
    gap = np.abs(found.froude_krylov - hydro.froude_krylov)[..., low].max(axis=(1, 2))
    assert np.all(gap < 0.02 * np.abs(hydro.froude_krylov[..., low]).max(axis=(1, 2)))
    np.testing.assert_allclose(found.froude_krylov + found.diffraction, hydro.excitation, rtol=1e-12)
    without = completed(bare())
    assert without.hull is None and without.froude_krylov is None


def test_a_mesh_that_capytaine_reads_gives_the_same_hull(tmp_path: Path) -> None:
    pytest.importorskip("capytaine")
    hull = shipped().hull
    assert hull is not None
    corners = hull.vertices[hull.faces].reshape(-1, 3)
    lines = ["float", "1.0 9.81", "0 0", str(len(hull.faces)), *(" ".join(map(repr, map(float, c))) for c in corners)]
    (tmp_path / "float.gdf").write_text("\n".join(lines))
    read = read_hull(tmp_path / "float.gdf", (hull.hinge[1], hull.hinge[2]), 10.0)
    assert read.volume == pytest.approx(hull.volume, rel=1e-6)
    assert panel_stiffness(read) == pytest.approx(panel_stiffness(hull), rel=1e-6)
    turned = dataclasses.replace(read, faces=np.ascontiguousarray(read.faces[:, ::-1]))
    assert turned.volume == pytest.approx(hull.volume, rel=1e-6)  # panels that face inwards are turned
    with pytest.raises(InputError, match="there is no such file"):
        read_hull(tmp_path / "none.gdf", (-1.0, 0.2))


def test_open_or_displaced_hulls_are_refused() -> None:
    hull = shipped().hull
    assert hull is not None
    with pytest.raises(InputError, match="not closed"):
        dataclasses.replace(hull, faces=hull.faces[: len(hull.faces) // 2])
    with pytest.raises(InputError, match="y < 0"):
        dataclasses.replace(hull, hinge=np.array([0.0, 1.0, 0.2]))


def test_rebuilt_table_keeps_bits_where_it_agrees_and_is_refused_where_not() -> None:
    hydro = shipped()
    rebuilt = dataclasses.replace(hydro, excitation=hydro.excitation * (1.0 + 1e-14))
    np.testing.assert_array_equal(with_bits_of(hydro, rebuilt).excitation, hydro.excitation)
    with pytest.raises(InputError, match="another excitation"):
        with_bits_of(hydro, dataclasses.replace(hydro, excitation=hydro.excitation * 1.001))
