"""Binary files and results of other solvers from outside give a sound result or a refusal. Findings, one each."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import pytest
import xarray as xr
from test_reports_synthetic import synthetic

import gyroctl as gy
from gyroctl import hdf5_child, netcdf
from gyroctl.comparison.execution import outcome_of
from gyroctl.comparison.items import Outcome
from gyroctl.engine import Store
from gyroctl.engine.record import MAGIC
from gyroctl.errors import InputError
from gyroctl.hydrodynamics import load, shipped
from gyroctl.hydrodynamics.capytaine_layout import to_dataset
from gyroctl.hydrodynamics.export import export_results
from gyroctl.hydrodynamics.importers import Site, read_nemoh, read_wamit
from gyroctl.netcdf import read_netcdf
from gyroctl.reports import evaluate, open_results, summarise

MEND = "Write it again"


def refused(read: Callable[[], object], *parts: str) -> InputError:
    with pytest.raises(InputError) as caught:
        read()
    assert str(caught.value).isprintable() and len(str(caught.value)) < 5000
    for part in parts:
        assert part in str(caught.value)
    return caught.value


# --- NetCDF classic and HDF5 ---------------------------------------------------------------------------------------


def small() -> xr.Dataset:
    data = {
        "a": (("x", "y"), np.arange(6.0).reshape(2, 3), {"units": "m", "sizes": [1, 2]}),
        "flag": ("x", np.array([True, False])),
        "whole": ("y", np.array([1, 2, 3], dtype=np.int32)),
        "alone": ((), 2.5),
    }
    return xr.Dataset(data, {"x": ["one", "zwei é"]}, {"title": "small", "number": 3.5})


@pytest.mark.parametrize(("engine", "form"), [("scipy", "NETCDF3_64BIT"), ("h5netcdf", "NETCDF4")])
def test_both_kinds_of_file_hand_over_the_same(tmp_path: Path, engine: Any, form: Any) -> None:
    path = tmp_path / "small.nc"
    small().to_netcdf(path, engine=engine, format=form)
    variables, attributes = read_netcdf("file", path, MEND)
    assert attributes["title"] == "small" and attributes["number"] == 3.5
    assert variables["a"].dimensions == ("x", "y") and np.array_equal(variables["a"].values, small()["a"].values)
    assert variables["a"].attributes["units"] == "m" and variables["alone"].values == 2.5
    assert variables["x"].values.tolist() == ["one", "zwei é"] and variables["whole"].values.dtype == np.int32
    assert variables["flag"].attributes["dtype"] == "bool"


def test_characters_in_hdf5_are_texts_as_in_the_classic_file(tmp_path: Path) -> None:
    """What xarray makes of a classic file that it saves again: arrays of characters, each text along the last axis."""
    classic, again = tmp_path / "classic.nc", tmp_path / "again.nc"
    data = small().assign(names=(("x", "z"), [["a", "bé"], ["", "long one"]]), title="alone")
    data.to_netcdf(classic, engine="scipy", format="NETCDF3_64BIT")
    xr.open_dataset(classic).load().to_netcdf(again, engine="h5netcdf")
    with h5netcdf.File(again) as file:
        assert file["names"].dtype == "S1" and len(file["names"].dimensions) == 3
    (before, _), (after, _) = read_netcdf("file", classic, MEND), read_netcdf("file", again, MEND)
    for name in ("x", "names", "title"):
        assert after[name].dimensions == before[name].dimensions
        assert after[name].values.tolist() == before[name].values.tolist() == data[name].values.tolist()


def h5(path: Path, write: Callable[[Any], object]) -> Path:
    with h5py.File(path, "w") as file:
        write(file)
    return path


def test_hdf5_that_swells_is_refused(tmp_path: Path) -> None:
    """A file of a few hundred bytes holds 800 GB of zeros."""
    path = tmp_path / "bomb.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"x": 10**11}
        file.create_variable("a", ("x",), "f8", chunks=(10**6,))
    assert path.stat().st_size < 100_000
    refused(lambda: read_netcdf("file", path, MEND), "256 MB")


def test_whole_time_series_are_read_whatever_their_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file may hold in proportion to its own size, and its numbers come piece by piece."""
    path, values = tmp_path / "long.nc", np.random.default_rng(1).normal(size=(3, 5, 700))
    data = xr.Dataset({"a": (("x", "y", "z"), values), "b": ("z", values[0, 0]), "c": ((), 1.5)})
    data.to_netcdf(path, engine="h5netcdf", encoding={"a": {"zlib": True}})
    monkeypatch.setattr(netcdf, "MOST", 1000)
    assert netcdf.room(path)[0] == netcdf.SWELL * path.stat().st_size
    for piece in (600, 5600, 30_000):
        with monkeypatch.context() as here:
            here.setattr(hdf5_child, "PIECE", piece)
            here.setenv(netcdf.TRUSTED, "1")
            found = read_netcdf("file", path, MEND).variables
        assert np.array_equal(found["a"].values, values) and np.array_equal(found["b"].values, values[0, 0])
        assert found["c"].values == 1.5
    assert np.array_equal(read_netcdf("file", path, MEND).variables["a"].values, values)
    monkeypatch.setattr(netcdf, "SWELL", 0)
    refused(lambda: read_netcdf("file", path, MEND), "holds more than")


def test_hdf5_of_other_kinds_is_refused(tmp_path: Path) -> None:
    kind = np.dtype([("p", "f8"), ("q", "i4")])
    path = h5(tmp_path / "compound.nc", lambda f: f.create_dataset("a", data=np.zeros(2, kind)))
    refused(lambda: read_netcdf("file", path, MEND), "NetCDF 4")


def test_variable_shorter_than_its_unlimited_dimension_is_filled(tmp_path: Path) -> None:
    path = tmp_path / "growing.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions["t"] = None
        file.create_variable("long", ("t",), float, fillvalue=-7.0)
        file.create_variable("short", ("t",), float, fillvalue=-7.0)
        file.create_variable("scalar", (), float, data=2.0)
        file.resize_dimension("t", 3)
        file["long"][:] = [1.0, 2.0, 3.0]
        file["short"]._h5ds.resize((2,))
        file["short"]._h5ds[:] = [4.0, 5.0]
    variables, _ = read_netcdf("file", path, MEND)
    assert variables["long"].values.tolist() == [1.0, 2.0, 3.0] and variables["scalar"].values == 2.0
    assert variables["short"].values.tolist() == [4.0, 5.0, -7.0]


def test_damaged_hdf5_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "small.nc"
    small().to_netcdf(path, engine="h5netcdf")
    path.write_bytes(path.read_bytes()[:3000])
    refused(lambda: read_netcdf("file", path, MEND), "file = ", "NetCDF 4")


def test_end_of_the_reading_process_is_a_refusal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = h5(tmp_path / "a.nc", lambda f: f.create_dataset("a", data=[1.0]))
    for body, why in (
        ("import os; os.kill(os.getpid(), 11)", "came to an end"),
        ("import resource as r; r.setrlimit(r.RLIMIT_CPU, (1, 1))\nwhile True: pass", "came to an end"),
        (f"import sys; sys.exit({hdf5_child.NO_LIMITS})", netcdf.TRUSTED),
        ("print('{}')", "cannot be read"),
        ("print('[')", "cannot be read"),
    ):
        script = tmp_path / "child.py"
        script.write_text(body)
        monkeypatch.setattr(hdf5_child, "__file__", str(script))
        assert str(refused(lambda: read_netcdf("file", path, MEND), why)).count("file = ") == 1


def test_reading_process_has_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limits that the script sets hold: it can neither take 2 GB nor write a file."""
    source = Path(hdf5_child.__file__).read_text()
    path = h5(tmp_path / "a.nc", lambda f: f.create_dataset("a", data=[1.0]))
    for body, why in (
        ("b = bytearray(2 << 30)", "MemoryError"),
        (f"open({str(tmp_path / 'x')!r}, 'w').write('x')", ""),
    ):
        script = tmp_path / "child.py"
        script.write_text(source.replace("    try:\n        for part", f"    try:\n        {body}\n        for part"))
        monkeypatch.setattr(hdf5_child, "__file__", str(script))
        refused(lambda: read_netcdf("file", path, MEND), why)
    assert not (tmp_path / "x").exists() or not (tmp_path / "x").stat().st_size


def test_classic_file_whose_variables_overlap_is_refused(tmp_path: Path) -> None:
    """Each of many variables says that it is the whole file: together they would fill the memory."""
    names = [f"v{i:02d}" for i in range(40)]
    path = tmp_path / "overlap.nc"
    values = np.zeros(5000)
    xr.Dataset({name: ("x", values) for name in names}).to_netcdf(path, engine="scipy", format="NETCDF3_CLASSIC")
    content = bytearray(path.read_bytes())
    first = None
    for name in names:  # the offset ends the entry of a variable: name, dimensions, attributes, type, size, offset
        at = content.index(name.encode())
        size = content.index((8 * values.size).to_bytes(4, "big"), at)
        first = first or bytes(content[size + 4 : size + 8])
        content[size + 4 : size + 8] = first
    del content[-8 * values.size * 38 :]
    path.write_bytes(content)
    refused(lambda: read_netcdf("file", path, MEND), "overlap")


def test_pipe_and_folder_are_no_netcdf(tmp_path: Path) -> None:
    for path in (tmp_path, Path("/dev/zero"), tmp_path / "none.nc", tmp_path / ("y" * 5000)):
        refused(lambda path=path: read_netcdf("file", path, MEND))


# --- hydrodynamics -------------------------------------------------------------------------------------------------


def twice(values: xr.DataArray, instead: str) -> tuple[list[str], np.ndarray]:
    """Values whose dimension `instead` bears the name of another one of theirs."""
    return ["influenced_dof" if name == instead else str(name) for name in values.dims], values.values


def changed(change: Callable[[xr.Dataset], xr.Dataset], tmp_path: Path) -> Path:
    path = tmp_path / "float.nc"
    change(to_dataset(shipped())).to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")
    return path


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda ds: ds.assign_coords(rho=0.0), "rho"),
        (lambda ds: ds.assign_coords(g=np.nan), "g"),
        (lambda ds: ds.assign_coords(water_depth=-1.0), "depth"),
        (lambda ds: ds.assign_coords(rho=("r", [1000.0, 1025.0])), "rho"),
        (lambda ds: ds.assign(radiation_damping=-ds.radiation_damping), "damping"),
        (lambda ds: ds.assign(added_mass=1e300 * ds.added_mass), "added_mass"),
        (lambda ds: ds.assign(added_mass=ds.added_mass * np.nan), "added_mass"),
        (lambda ds: ds.assign(added_mass=ds.added_mass.astype(str)), "added_mass"),
        (lambda ds: ds.assign_coords(omega=0.0 * ds.omega), "omega"),
        (lambda ds: ds.assign_coords(omega=1e6 * ds.omega), "omega"),
        (lambda ds: ds.assign_coords(wave_direction=ds.wave_direction * np.nan), "headings"),
        (lambda ds: ds.assign(hydrostatic_stiffness=-ds.hydrostatic_stiffness), "stiffness"),
        (lambda ds: ds.isel(omega=slice(3)), "omega"),
        (lambda ds: ds.assign(hull_faces=10 * ds.hull_faces), "hull"),
        (lambda ds: ds.assign(hull_faces=-ds.hull_faces), "hull"),
        (lambda ds: ds.assign(hull_vertices=1e9 * ds.hull_vertices), "hull"),
        (lambda ds: ds.assign(hull_inclination=np.nan), "hull"),
        (lambda ds: ds.assign(fit_accurate_q=ds.fit_accurate_q * np.nan), "fits"),
        (lambda ds: ds.isel(wave_direction=slice(0)), ""),
        (lambda ds: ds.isel(wetted_number=slice(3)), "wetted"),
        (lambda ds: ds.assign(diffraction_force=twice(ds.diffraction_force, "complex")), "diffraction_force"),
        (lambda ds: ds.assign(added_mass=twice(ds.added_mass, "radiating_dof")), "added_mass"),
    ],
)
@pytest.mark.filterwarnings("ignore:Duplicate dimension names")
def test_hydrodynamics_of_no_float_are_refused(tmp_path: Path, change: Any, field: str) -> None:
    error = refused(lambda: load(changed(change, tmp_path)), "float.nc")
    assert field in error.field


def test_hydrodynamics_as_hdf5_are_those_of_the_classic_file(tmp_path: Path) -> None:
    path = tmp_path / "float.nc"
    to_dataset(shipped()).to_netcdf(path, engine="h5netcdf")
    assert load(path).sha256 == shipped().sha256


@pytest.mark.parametrize("engine", ["scipy", "h5netcdf"])
def test_exported_hydrodynamics_that_were_edited_are_read(tmp_path: Path, engine: Any) -> None:
    exported, edited = tmp_path / "exported.nc", tmp_path / "edited.nc"
    export_results(shipped(), "capytaine", exported)
    xr.open_dataset(exported).load().to_netcdf(edited, engine=engine)
    assert load(edited).sha256 == load(exported).sha256


def test_results_that_were_saved_again_are_read(tmp_path: Path) -> None:
    classic, again = tmp_path / "classic.nc", tmp_path / "again.nc"
    synthetic().to_netcdf(classic, engine="scipy", format="NETCDF3_64BIT")
    xr.open_dataset(classic).load().to_netcdf(again, engine="h5netcdf")
    assert open_results(again).law.values.tolist() == open_results(classic).law.values.tolist()
    assert open_results(again).information.identical(open_results(classic).information)


def wamit(folder: Path, mode: str = "4", heading: str = "0.0", value: str = "1.0") -> Path:
    periods = [1.0 + 0.1 * i for i in range(12)]
    first = [f"{p} {m} {m} 0.5 0.1" for p in periods for m in (6, 4)]
    third = [f"{p} {heading} {m} 1 1 {value} 1" for p in periods for m in (6, 4)]
    (folder / "a.1").write_text("\n".join([*first, f"1.0 {mode} {mode} 0.5 0.1"]))
    (folder / "a.3").write_text("\n".join(third))
    return folder / "a.1"


@pytest.mark.parametrize("change", [{"mode": "inf"}, {"mode": "nan"}, {"heading": "1e308"}, {"value": "1e308"}])
def test_wamit_with_strange_numbers_is_refused(tmp_path: Path, change: dict[str, str]) -> None:
    assert read_wamit(wamit(tmp_path)).omega.size == 12
    refused(lambda: read_wamit(wamit(tmp_path, **change)))


@pytest.mark.parametrize("change", [{"rho": 0.0}, {"g": float("nan")}, {"length": 1e308}, {"modes": (4, 4)}])
def test_site_of_no_water_is_refused(change: dict[str, Any]) -> None:
    refused(lambda: Site(**change), "hydro.")


@pytest.mark.parametrize("beta", ["e", "--", "1e999", "."])
def test_nemoh_with_a_strange_heading_is_refused(tmp_path: Path, beta: str) -> None:
    rows = "\n".join(" ".join(["%g" % (1.0 + 0.1 * i), *["0.5 0.1"] * 6]) for i in range(12))
    zones = "\n".join(f"Zone {i}\n{rows}" for i in range(6))
    (tmp_path / "RadiationCoefficients.tec").write_text(zones)
    (tmp_path / "ExcitationForce.tec").write_text(f"Zone beta = {beta} deg\n{rows}")
    refused(lambda: read_nemoh(tmp_path))


# --- stored runs ---------------------------------------------------------------------------------------------------


def outcome(folder: Path) -> Outcome | None:
    return outcome_of(Store(folder).load("key"))


def packed(folder: Path, content: Any, **series: Any) -> None:
    Store(folder).save("key", content, series)


def test_stored_run_of_another_kind_is_computed_again(tmp_path: Path) -> None:
    sound = {"sha256": "a", "values": {"power": 1.0}}
    packed(tmp_path, sound, time=np.arange(3.0))
    assert outcome(tmp_path) is not None
    for head in ({**sound, "sha256": 1}, {**sound, "values": {"power": "167000"}}, {**sound, "values": []}, [], 5):
        packed(tmp_path, head)
        assert outcome(tmp_path) is None
    packed(tmp_path, sound, time=np.array(["a"]))
    assert outcome(tmp_path) is None


@pytest.mark.parametrize("told", ["by the array", "by the archive"])
def test_stored_run_that_swells_is_computed_again(tmp_path: Path, told: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Under a checksum that fits: whoever made it could compute one."""
    head, arrays = io.BytesIO(), io.BytesIO()
    shape = 10**9 if told == "by the array" else 100_000
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (shape,)})
    with zipfile.ZipFile(arrays, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("time.npy", head.getvalue() + bytes(800_000))
    body = json.dumps({"key": "key", "about": {}, "content": {"sha256": "a", "values": {}}}).encode() + b"\n"
    body += arrays.getvalue()
    Store(tmp_path).path("key").write_bytes(MAGIC + hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
    assert (outcome(tmp_path) is None) == (told == "by the array")
    monkeypatch.setattr("gyroctl.engine.record.LARGEST", 500_000)
    assert outcome(tmp_path) is None


# --- results of a comparison ---------------------------------------------------------------------------------------


def with_attribute(name: str, value: object) -> Callable[[xr.Dataset], xr.Dataset]:
    return lambda ds: ds.assign_attrs({name: value})


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda ds: ds.assign_coords(realisation=ds.realisation + 0.5), "realisation"),
        (lambda ds: ds.assign_coords(realisation=0 * ds.realisation), "realisation"),
        (lambda ds: ds.assign_coords(realisation=-ds.realisation), "realisation"),
        (lambda ds: ds.assign_coords(law=["a"] * ds.sizes["law"]), "law"),
        (lambda ds: ds.assign_coords(law=list(range(ds.sizes["law"]))), "law"),
        (lambda ds: ds.assign_coords(label=("law", ["\x1b[31m"] * ds.sizes["law"])), "label"),
        (lambda ds: ds.assign(mean_power=1e308 + 0.0 * ds.mean_power), "mean_power"),
        (lambda ds: ds.assign(mean_power=ds.mean_power.astype(str)), "mean_power"),
        (lambda ds: ds.assign(locked=7.0 + 0.0 * ds.mean_power), "locked"),
        (lambda ds: ds.assign(loss_time=-1.0 + 0.0 * ds.mean_power), "loss_time"),
        (lambda ds: ds.assign(failed=ds.mean_power > 1e9), "failed"),
        (lambda ds: ds.assign_coords(time=ds.time[::-1].values), "time"),
        (with_attribute("experiment", 5), "experiment"),
        (with_attribute("motion_limit", "x"), "motion_limit"),
        (with_attribute("motion_limit", float("nan")), "motion_limit"),
        (with_attribute("duration", "x"), "results"),
        (with_attribute("duration", 1e308), "results"),
        (with_attribute("tuning_seeds", '["a"]'), "tuning_seeds"),
        (with_attribute("tuning_seeds", "{}"), "tuning_seeds"),
        (with_attribute("seed_states", '{"spent": 5}'), "seed_states"),
        (with_attribute("yardstick", '{"searched": false}'), "yardstick"),
        (with_attribute("created", "\x1b[2J"), "created"),
    ],
)
def test_results_of_no_comparison_are_refused(change: Any, field: str) -> None:
    assert field in refused(lambda: open_results(change(synthetic()))).field


def test_odd_but_harmless_attributes_stay_readable() -> None:
    ds = synthetic().assign_attrs(experiment="not json", tuning_seeds="[" * 10_000, parameters="9" * 5000, versions="x")
    ds.attrs["duration"] = 600.0
    assert summarise(open_results(ds))["experiment"] == {"text": "not json"}
    assert evaluate(ds).tuning_seeds == ()


def test_device_takes_no_number_for_a_file() -> None:
    refused(lambda: gy.zhang2017(hydrodynamics=[]), "path")  # type: ignore[arg-type]
