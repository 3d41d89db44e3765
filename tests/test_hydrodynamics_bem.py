"""The Capytaine script on a coarse mesh, and what it says without Capytaine."""

from __future__ import annotations

import builtins
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import bem, load, shipped
from gyroctl.hydrodynamics import mesh as panels
from gyroctl.hydrodynamics.geometry import VARIANTS, Geometry, statics
from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf

COARSE = ((12, 8, 4), (12, 8, 4))
FEW = np.array([0.3, 0.65, 1.0, 1.5, 2.0, 2.6, 3.1, 4.0, 5.0, 5.6, 6.3, 7.0, 8.0, 9.5, 11.0, 12.0, 14.0, 16.0])


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("capytaine")
    calls: list[tuple[int, int]] = []
    out = tmp_path_factory.mktemp("bem") / "coarse.nc"
    bem.build(out, "inclined", lambda done, total: calls.append((done, total)), FEW, np.array([0.0, 90.0]), COARSE)
    assert calls[-1] == (len(FEW) + 1, len(FEW) + 1)  # the joint is solved at both depths
    assert [done for done, _ in calls] == list(range(1, len(FEW) + 2))
    return out


@pytest.mark.slow
def test_coarse_rebuild_is_close_to_the_shipped_database(coarse: Path) -> None:
    found, hydro = load(coarse), shipped()
    for name in ("added_mass", "damping"):
        truth = spline(hydro.omega, getattr(hydro, name), found.omega)
        scale = np.max(truth, axis=1, keepdims=True)
        assert np.max(np.abs(getattr(found, name) - truth) / scale) < 0.04
    assert found.added_mass_inf == pytest.approx(hydro.added_mass_inf, rel=0.03)
    assert found.stiffness == hydro.stiffness
    assert found.coupling < 1e-5
    assert set(found.fits) == {"accurate", "fine", "paper"}
    assert found.provenance["wetted_panels"] == "[192, 192]"


@pytest.mark.slow
def test_kramers_kronig_gives_the_added_mass_that_deep_water_has_by_direct_solution() -> None:
    """Independent of any fit: solved at infinite frequency against integrated from the damping."""
    pytest.importorskip("capytaine")
    omega = np.concatenate([np.arange(0.3, 7.9, 0.35), np.arange(8.0, 18.1, 0.8)])
    hydro = bem.solve(VARIANTS["deep"], None, omega, np.array([0.0]), ((4, 3, 2), (20, 12, 5)))
    direct = hydro.provenance["deep_water_added_mass_inf"]
    for j in range(2):
        value, _ = added_mass_inf(hydro.omega, hydro.added_mass[j], hydro.damping[j])
        assert value == pytest.approx(direct[j], rel=0.012)
    assert np.isinf(hydro.depth)


@pytest.mark.slow
def test_horizontal_lever_misses_table_1() -> None:
    pytest.importorskip("capytaine")
    flat = bem.solve(VARIANTS["horizontal"], None, FEW, np.array([0.0]), COARSE)
    tilted = bem.solve(VARIANTS["inclined"], None, FEW, np.array([0.0]), COARSE)
    assert flat.stiffness / tilted.stiffness == pytest.approx(1.06, abs=0.01)
    assert flat.added_mass_inf / tilted.added_mass_inf == pytest.approx([1.024, 1.016], abs=0.006)


@pytest.mark.parametrize("engine", ["scipy", "h5netcdf"])
def test_a_file_that_capytaine_wrote_itself_is_read(engine: str, tmp_path: Path) -> None:
    """Deep water, a mesh of 48 panels, degrees of freedom in another order, a row of infinite frequency."""
    cpt = pytest.importorskip("capytaine")
    if engine == "h5netcdf":
        pytest.importorskip("h5py")
    import xarray as xr

    geometry = Geometry()
    rest = statics(geometry)
    half = panels.hull(geometry, rest.height, 6, 4)
    hull = cpt.ReflectionSymmetricMesh(cpt.Mesh(half.vertices, half.faces), plane="yOz")
    arm = hull.faces_centers - geometry.hinge(rest.height)
    body = cpt.FloatingBody(hull, {"phi3": np.cross([1.0, 0, 0], arm), "phi1": np.cross([0, 0, -1.0], arm)})
    omega = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
    matrix = xr.Dataset(
        coords={
            "omega": np.append(omega, np.inf),
            "wave_direction": [np.pi / 2, 0.0],
            "radiating_dof": ["phi3", "phi1"],
            "rho": 1000.0,
        }
    )
    raw = cpt.BEMSolver(method="direct").fill_dataset(matrix, body, hydrostatics=False, progress_bar=False)
    written = cpt.io.xarray.separate_complex_values(raw)
    for name in ("radiating_dof", "influenced_dof"):
        written[name] = written[name].astype("U")
    written = written.drop_vars([n for n in written.variables if written[n].dtype == object])
    written.to_netcdf(tmp_path / "own.nc", engine=engine)
    found = load(tmp_path / "own.nc")
    assert found.omega == pytest.approx(omega)
    assert found.headings == pytest.approx([0.0, 90.0])
    for j, dof in enumerate(("phi1", "phi3")):
        own = raw.sel(omega=omega, influenced_dof=dof)
        assert found.added_mass[j] == pytest.approx(own.added_mass.sel(radiating_dof=dof).values)
        assert found.damping[j] == pytest.approx(own.radiation_damping.sel(radiating_dof=dof).values)
        force = own.excitation_force.sel(wave_direction=[0.0, np.pi / 2]).transpose("wave_direction", "omega")
        assert np.allclose(found.excitation[j], np.conj(force.values))
    assert np.isinf(found.depth)
    assert found.coupling < 1e-4


def test_without_capytaine_the_error_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    real = builtins.__import__

    def absent(name: str, *rest: Any, **more: Any) -> Any:
        if name.split(".")[0] == "capytaine":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", absent)
    with pytest.raises(InputError, match=r"gyroctl\[bem\]"):
        bem.build(tmp_path / "x.nc")
    assert list(tmp_path.iterdir()) == []


def test_capytaine_2_is_too_old(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("capytaine")
    monkeypatch.setattr(bem, "version", lambda name: "2.3.1")
    with pytest.raises(InputError, match="too old"):
        bem.build(tmp_path / "x.nc")


def test_unknown_variant_names_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="horizontal"):
        bem.build(tmp_path / "x.nc", "vertical")


def test_table_without_the_joint_is_refused() -> None:
    pytest.importorskip("capytaine")
    with pytest.raises(InputError, match="joint"):
        bem.solve(VARIANTS["inclined"], None, np.array([1.0, 2.0, 14.0, 16.0]), np.array([0.0]), COARSE)
