"""The shipped database, its reader, and the refusal of files of another layout."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Hydrodynamics, load, save, shipped
from gyroctl.hydrodynamics.capytaine_layout import to_dataset
from gyroctl.hydrodynamics.database import SHIPPED
from gyroctl.hydrodynamics.geometry import Geometry, statics
from gyroctl.hydrodynamics.mesh import lid
from gyroctl.netcdf import read_netcdf

#: DESIGN values (direct method, about 500 panels): w, A1, B1, A3, B3, |He1|, arg, |He3|, arg.
REFERENCE = [
    (1.0, 27.64, 0.152, 65.52, 29.60, 279.5, 89.9, 2756.9, 0.6),
    (3.1, 30.80, 7.150, 41.89, 81.09, 880.0, 88.5, 2096.1, 6.6),
    (5.0, 33.65, 57.19, 30.96, 105.9, 1364.0, 84.2, 1307.0, 23.2),
    (8.0, 15.47, 151.9, 24.38, 79.05, 1084.0, 100.9, 572.0, 81.9),
]


def at(values: np.ndarray, omega: float) -> np.ndarray:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(shipped().omega, values, axis=-1)(omega))


@pytest.mark.parametrize("row", REFERENCE)
def test_reference_table(row: tuple[float, ...]) -> None:
    hydro = shipped()
    omega, a1, b1, a3, b3, he1, arg1, he3, arg3 = row
    assert at(hydro.added_mass, omega) == pytest.approx([a1, a3], rel=0.01)
    assert at(hydro.damping, omega) == pytest.approx([b1, b3], rel=0.02)
    he = at(hydro.excitation[:, int(np.argmin(np.abs(hydro.headings)))], omega)
    assert np.abs(he) == pytest.approx([he1, he3], rel=0.01)
    assert np.rad2deg(np.angle(he)) == pytest.approx([arg1, arg3], abs=0.6)


def test_shipped_data_match_table_1_of_the_paper() -> None:
    hydro = shipped()
    assert hydro.stiffness == pytest.approx(2945.0, rel=0.01)
    assert hydro.added_mass_inf == pytest.approx([14.39, 32.16], rel=0.01)
    assert (hydro.depth, hydro.rho) == (0.7, 1000.0)
    assert hydro.headings[0] == 0.0 and np.any(np.isclose(hydro.headings, 180.0))
    assert "capytaine 3" in hydro.provenance["bem_solver"]


def test_long_waves_lift_the_float_like_a_rising_water_level() -> None:
    """He3 -> rho g times the first moment of the waterplane about the hinge, He1 -> 0."""
    hydro, geometry = shipped(), Geometry()
    panels = lid(geometry, statics(geometry).height, 80, 40)
    a, b, c, d = (panels.vertices[panels.faces[:, k]] for k in range(4))
    first = 0.0
    for p, q, r in ((a, b, c), (a, c, d)):
        area = 0.5 * np.abs(np.cross(q - p, r - p)[:, 2])
        first += 2.0 * np.sum(area * ((p + q + r)[:, 1] / 3.0 + geometry.arm * geometry.axis[1]))
    he = hydro.excitation[:, 0, 0]
    assert he[1].real == pytest.approx(hydro.rho * hydro.g * first, rel=0.015)
    assert abs(he[0]) < 0.03 * abs(he[1])


def test_moments_are_joined_continuously_at_12_rad_s() -> None:
    """The join to infinite depth shows in no second difference larger than those of its neighbourhood."""
    hydro = shipped()
    zone = (hydro.omega > 10.0) & (hydro.omega < 14.5)
    x = hydro.omega[zone]
    for values in (*hydro.added_mass, *hydro.damping):
        y = values[zone]
        slope = np.diff(y) / np.diff(x)
        assert np.max(np.abs(np.diff(slope))) < 0.25 * np.max(np.abs(slope)) + 0.15


def test_reader_agrees_with_xarray_on_every_variable() -> None:
    variables, attributes = read_netcdf("path", SHIPPED, "Write it again")
    with xr.open_dataset(SHIPPED, engine="scipy") as dataset:
        assert set(variables) == set(map(str, dataset.variables))
        for name, variable in dataset.variables.items():
            ours = variables[str(name)]
            assert ours.dimensions == variable.dims
            theirs = variable.values
            assert np.array_equal(ours.values, theirs.astype(str) if theirs.dtype.kind in "SO" else theirs)
        assert attributes.keys() == dataset.attrs.keys()
        assert attributes == dataset.attrs


def test_saving_and_loading_keeps_every_bit(tmp_path: Path) -> None:
    hydro = shipped()
    again = load(save(hydro, tmp_path / "again.nc"))
    assert again.sha256 == hydro.sha256
    assert again.coupling == hydro.coupling
    for name, pair in hydro.fits.items():
        for mine, theirs in zip(pair, again.fits[name], strict=True):
            assert np.array_equal(mine[0], theirs[0]) and np.array_equal(mine[1], theirs[1])
    assert [p.name for p in tmp_path.iterdir()] == ["again.nc"]


def test_netcdf4_is_read_too(tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    to_dataset(shipped()).to_netcdf(tmp_path / "four.nc", engine="h5netcdf")
    assert load(tmp_path / "four.nc").sha256 == shipped().sha256


def test_hash_changes_with_any_number_and_not_with_the_provenance() -> None:
    hydro = shipped()
    nudged = hydro.excitation.copy()
    nudged[0, 0, 0] += 1e-9
    assert dataclasses.replace(hydro, excitation=nudged).sha256 != hydro.sha256
    assert dataclasses.replace(hydro, stiffness=hydro.stiffness + 1e-9).sha256 != hydro.sha256
    assert dataclasses.replace(hydro, provenance={}).sha256 == hydro.sha256


def test_shipped_data_and_fits_load_without_heavy_libraries() -> None:
    code = (
        "import sys; from gyroctl.hydrodynamics import shipped, shipped_fit, excitation_table; "
        "shipped_fit(); excitation_table(shipped())([3.0]); "
        "print(sorted({m.split('.')[0] for m in sys.modules}))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    for heavy in ("xarray", "h5netcdf", "h5py", "capytaine", "cvxpy", "pandas"):
        assert f"'{heavy}'" not in shown


def layout(hydro: Hydrodynamics) -> xr.Dataset:
    return to_dataset(hydro)


def written(dataset: xr.Dataset, path: Path) -> Path:
    dataset.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")
    return path


def test_missing_file_is_named() -> None:
    with pytest.raises(InputError, match=r"nowhere\.nc.*no such file"):
        load("nowhere.nc")


def test_text_file_is_no_netcdf(tmp_path: Path) -> None:
    path = tmp_path / "data.nc"
    path.write_text("omega, added mass")
    with pytest.raises(InputError, match="not a NetCDF file"):
        load(path)


def test_truncated_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "short.nc"
    path.write_bytes(SHIPPED.read_bytes()[:3000])
    with pytest.raises(InputError, match="not a readable"):
        load(path)


@pytest.mark.parametrize("at", range(4, 2004, 50))
def test_damaged_header_is_refused_or_harmless(tmp_path: Path, at: int) -> None:
    path = tmp_path / "damaged.nc"
    content = bytearray(SHIPPED.read_bytes())
    content[at : at + 4] = b"\xff\xff\xff\xff"
    path.write_bytes(content)
    try:
        load(path)
    except InputError as refusal:
        assert "damaged.nc" in str(refusal)


def test_unlimited_dimension_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "records.nc"
    xr.Dataset({"values": ("omega", [1.0, 2.0])}).to_netcdf(path, engine="scipy", unlimited_dims=["omega"])
    with pytest.raises(InputError, match="unlimited dimension"):
        load(path)


def test_fit_without_its_denominator_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="fit_fine_q"):
        load(written(layout(shipped()).drop_vars("fit_fine_q"), tmp_path / "x.nc"))


@pytest.mark.parametrize("name", ["added_mass", "radiation_damping", "excitation_force"])
def test_missing_variable_is_named(tmp_path: Path, name: str) -> None:
    parts = ["diffraction_force"] if name == "excitation_force" else []  # with both parts it would be their sum
    path = written(layout(shipped()).drop_vars([name, *parts]), tmp_path / "x.nc")
    with pytest.raises(InputError, match=name):
        load(path)


def test_excitation_that_the_file_lacks_is_the_sum_of_its_parts(tmp_path: Path) -> None:
    found = load(written(layout(shipped()).drop_vars("excitation_force"), tmp_path / "x.nc"))
    np.testing.assert_allclose(found.excitation, shipped().excitation, rtol=1e-10, atol=1e-8)


def test_another_device_without_our_rotations_is_refused(tmp_path: Path) -> None:
    other = layout(shipped()).assign_coords(influenced_dof=["Heave", "Pitch"])
    with pytest.raises(InputError, match="lacks phi1 and phi3"):
        load(written(other, tmp_path / "x.nc"))


def test_several_water_depths_are_refused(tmp_path: Path) -> None:
    data = layout(shipped())
    deeper = data["added_mass"].drop_vars("water_depth").expand_dims(water_depth=[0.7, 1.0])
    with pytest.raises(InputError, match="water_depth"):
        load(written(data.drop_vars(["added_mass", "water_depth"]).assign(added_mass=deeper), tmp_path / "x.nc"))


def test_values_that_are_not_numbers_are_refused() -> None:
    broken = shipped().added_mass.copy()
    broken[0, 3] = np.nan
    with pytest.raises(InputError, match="added_mass"):
        dataclasses.replace(shipped(), added_mass=broken)


def test_missing_added_mass_at_infinity_is_derived(tmp_path: Path) -> None:
    bare = layout(shipped()).drop_vars("added_mass_inf")
    assert load(written(bare, tmp_path / "x.nc")).added_mass_inf == pytest.approx(shipped().added_mass_inf, rel=5e-3)
