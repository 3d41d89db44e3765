"""What an import says of a database, and the database written for other programs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import Run
from foreign_files import CAL, omega, write_nemoh, write_wamit

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Hydrodynamics, Site, export_results, fit_radiation, import_report, load, save, shipped
from gyroctl.hydrodynamics.export import capytaine, wamit
from gyroctl.hydrodynamics.importers import import_results, read_capytaine, read_nemoh, read_wamit
from gyroctl.hydrodynamics.radiation import PAPER_FIT, assess

TABLES = ("omega", "headings", "added_mass", "damping", "added_mass_inf", "excitation")


def as_shipped(read: Hydrodynamics, digits: float = 1e-6) -> None:
    ours = shipped()
    for name in TABLES:
        a, b = getattr(read, name), getattr(ours, name)
        assert np.max(np.abs(a - b)) <= digits * np.max(np.abs(b)), name
    assert read.stiffness == pytest.approx(ours.stiffness, rel=digits)
    assert (read.depth, read.rho, read.g) == (ours.depth, ours.rho, ours.g)


def test_the_database_comes_back_from_wamit_and_from_capytaine(tmp_path: Path) -> None:
    files = export_results(shipped(), "wamit", tmp_path / "float.1")
    assert {path.name for path in files} == {"float.1", "float.3", "float.3fk", "float.hst", "float.out"}
    read = read_wamit(tmp_path / "float")
    as_shipped(read, 1e-8)
    assert read.froude_krylov is not None
    part = shipped().froude_krylov
    assert part is not None and np.allclose(read.froude_krylov, part, atol=1e-6 * np.max(np.abs(part)))
    (path,) = export_results(shipped(), "capytaine", tmp_path / "float.nc")
    as_shipped(read_capytaine(path), 1e-12)


def test_other_water_and_limits_come_back_as_well(tmp_path: Path) -> None:
    hydro = replace(shipped(), rho=1025.0, g=9.8, depth=np.inf, added_mass_zero=np.array([30.0, np.nan]))
    wamit(hydro, tmp_path / "deep")
    read = read_wamit(tmp_path / "deep")
    for name in TABLES:
        assert np.allclose(getattr(read, name), getattr(hydro, name), rtol=1e-7, atol=1e-6), name
    assert read.added_mass_zero is not None and read.added_mass_zero[0] == pytest.approx(30.0)
    assert np.isnan(read.added_mass_zero[1]) and read.depth == np.inf
    capytaine(hydro, tmp_path / "deep.nc")
    assert load(tmp_path / "deep.nc").depth == np.inf
    assert np.array_equal(load(save(hydro, tmp_path / "own.nc")).added_mass_zero, hydro.added_mass_zero, equal_nan=True)


@pytest.mark.slow
def test_capytaine_reads_what_is_written_for_it(tmp_path: Path) -> None:
    """Its own exporter makes WAMIT's files of the dataset, which are ours again."""
    import xarray as xr

    exporter = pytest.importorskip("capytaine.io.wamit")
    capytaine(shipped(), tmp_path / "float.nc")
    with xr.open_dataset(tmp_path / "float.nc") as data:
        finite = data.isel(omega=slice(0, -1))
        force = finite["excitation_force"]
        finite["excitation_force"] = force.sel(complex="re") + 1j * force.sel(complex="im")
        exporter.export_wamit_1(finite, str(tmp_path / "again.1"))
        exporter.export_wamit_3(finite, str(tmp_path / "again.3"))
    read = read_wamit(tmp_path / "again", Site(depth=0.7))
    size = np.max(np.abs(shipped().excitation))
    assert np.max(np.abs(read.excitation - shipped().excitation)) < 3e-6 * size
    assert read.damping == pytest.approx(shipped().damping, rel=1e-5, abs=1e-5)


def test_an_export_that_cannot_be_written_is_refused_first(tmp_path: Path) -> None:
    for format, out in (("aqwa", tmp_path / "a"), ("wamit", tmp_path), ("capytaine", tmp_path / "gone" / "a.nc")):
        with pytest.raises(InputError, match=r"hydro.format|out"):
            export_results(shipped(), format, out)
    with pytest.raises(InputError, match="is a folder"):
        import_results(tmp_path / "nothing", "wamit", tmp_path)
    assert list(tmp_path.iterdir()) == []


def numbers(hydro: Hydrodynamics) -> list[float]:
    report = import_report(hydro)
    found = [*report.band, *report.headings, report.stiffness, report.depth, report.coupling, report.slow_mode]
    for one in report.rotations:
        found += [one.added_mass_inf, one.kramers_kronig, one.relative_rms, one.damping, one.damping_table]
        assert one.passive and one.waves
    assert report.verdict == "usable" and report.ok
    return found


@pytest.mark.slow
def test_reports_of_the_shipped_table_and_of_its_foreign_versions_agree(tmp_path: Path) -> None:
    ours = numbers(shipped())
    wamit(shipped(), tmp_path / "float")
    assert numbers(read_wamit(tmp_path / "float", Site(depth=0.7))) == pytest.approx(ours, rel=1e-6, abs=1e-5)
    (path,) = capytaine(shipped(), tmp_path / "float.nc")
    assert numbers(read_capytaine(path)) == pytest.approx(ours, rel=1e-6, abs=1e-5)


def test_the_report_says_what_speaks_against_a_table() -> None:
    hydro = shipped()
    sound = replace(hydro, fits={"accurate": hydro.fits["accurate"]})
    assert import_report(sound).verdict == "usable"
    damped = import_report(replace(hydro, fits={"accurate": PAPER_FIT}))
    ratio = assess(hydro, 0, *PAPER_FIT[0])
    assert damped.ok and f"phi1 {ratio.damping_low / ratio.damping_low_table:.3g} times" in damped.verdict
    hertz = import_report(replace(sound, omega=hydro.omega / (2.0 * np.pi)))
    assert not hertz.ok and "unit of frequency" in hertz.verdict and hertz.verdict.startswith("not usable")
    active = ((np.array([1.0, 0.0, -900.0]), PAPER_FIT[0][1]), PAPER_FIT[1])
    assert "the fit of phi1 is not passive" in import_report(replace(hydro, fits={"accurate": active})).verdict
    sound = replace(sound, froude_krylov=None, diffraction=None)
    poor = replace(sound, stiffness=0.0, coupling=0.2, headings=np.array([0.0]), excitation=hydro.excitation[:, :1])
    verdict = import_report(poor).verdict
    assert all(text in verdict for text in ("k3 is unknown", "coupling of 20 %", "heading 0 deg alone"))
    late = slice(8, None)
    short = {name: getattr(hydro, name)[..., late] for name in ("omega", "added_mass", "damping", "excitation")}
    cut = import_report(replace(sound, **short))
    assert "begins above the slow mode" in cut.verdict


def test_yaw_of_a_body_of_revolution_is_imported_as_what_makes_no_waves(tmp_path: Path) -> None:
    path = write_wamit(tmp_path, yaw=0.0, limits=[" 0.0 4 4 3.215273E-02", " 0.0 6 6 0.0"])
    hydro = read_wamit(path, Site(depth=0.7, stiffness=2944.9))
    fits = [fit_radiation(hydro, j) for j in range(2)]
    assert not np.any(fits[0].p) and fits[1].passivity.passive
    report = import_report(replace(hydro, fits={"accurate": tuple((fit.p, fit.q) for fit in fits)}))
    assert not report.rotations[0].waves and report.rotations[0].passive and "phi1 makes no waves" in report.verdict


@pytest.mark.slow
def test_the_import_ends_with_its_report_and_the_database_keeps_it(tmp_path: Path, run: Run) -> None:
    path = write_wamit(tmp_path, "rad/s", limits=[" 0.0 4 4 3.215273E-02", " 0.0 6 6 1.441365E-02"])
    base = ("hydro", "import", path, tmp_path / "out.nc", "--format", "wamit", "--depth", "0.7")
    code, out, err = run(*base)
    assert code == 2 and "--frequency" in err and not (tmp_path / "out.nc").exists()
    code, out, err = run(*base, "--frequency", "rad/s", "--inclination", "10")
    assert code == 2 and "--mesh" in err and not (tmp_path / "out.nc").exists()
    code, out, err = run(*base, "--frequency", "rad/s", "--stiffness", "2944.9", "--modes", "-yaw", "roll")
    assert code == 0, err
    for text in (f"0.35 to {omega()[-1]:.4g} rad/s", "by --frequency", "row of infinite frequency", "verdict"):
        assert text in out
    kept = str(import_report(tmp_path / "out.nc"))
    assert kept in out
    code, out, err = run("hydro", "report", tmp_path / "out.nc", "--out", tmp_path / "report.json")
    assert code == 0 and kept in out
    found = json.loads((tmp_path / "report.json").read_text())
    assert found["verdict"].startswith("usable with care") and found["report"]["frequencies"] == len(omega())
    code, out, err = run("hydro", "export", tmp_path / "out.nc", "--format", "capytaine", "--out", tmp_path / "x.nc")
    assert code == 0 and (tmp_path / "x.nc").is_file()
    code, out, err = run("hydro", "export", tmp_path / "out.nc", "--out", tmp_path)
    assert code == 2 and "is a folder" in err


def test_the_report_names_what_nemoh_and_its_cal_told(tmp_path: Path) -> None:
    hydro = read_nemoh(write_nemoh(tmp_path / "n", "Hz", "f (Hz)", f"{CAL}2 ! output freq type\n"))
    report = import_report(replace(hydro, fits={"accurate": shipped().fits["accurate"]}))
    text = str(report)
    for part in ("Hz, by head of", "Nemoh.cal", "Kramers-Kronig; its estimates", "k3", "rad, by the largest"):
        assert part in text
