"""Files of other solvers, written here (WAMIT's by Capytaine's own exporter) and read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Hydrodynamics, load, shipped
from gyroctl.hydrodynamics.database import SHIPPED
from gyroctl.hydrodynamics.importers import READERS, Site, import_results, read_nemoh, read_wamit

#: Every third frequency keeps the files small; the tail stays for Kramers-Kronig.
ROWS = slice(None, None, 3)
HEADINGS = (0, 4, 12)
SITE = Site(depth=0.7, stiffness=shipped().stiffness)


def same(read: Hydrodynamics, digits: float) -> None:
    hydro = shipped()
    assert read.omega == pytest.approx(hydro.omega[ROWS], rel=digits)
    for name in ("added_mass", "damping"):
        ours, theirs = getattr(read, name), getattr(hydro, name)[:, ROWS]
        assert np.max(np.abs(ours - theirs)) < digits * np.max(np.abs(theirs))
    truth = hydro.excitation[:, list(HEADINGS)][:, :, ROWS]
    assert read.headings == pytest.approx(hydro.headings[list(HEADINGS)])
    assert np.max(np.abs(read.excitation - truth)) < digits * np.max(np.abs(truth))
    assert read.added_mass_inf == pytest.approx(hydro.added_mass_inf, rel=0.02)
    assert read.depth == 0.7 and read.rho == 1000.0


def six_dofs(part: str = "excitation") -> xr.Dataset:
    """Our table, all of its moments or a part, as Capytaine has yaw and roll about the hinge: phi1 is minus yaw."""
    hydro = shipped()
    omega = hydro.omega[ROWS]
    sign = np.array([-1.0, 1.0])
    square = np.zeros((2, len(omega), 2, 2))
    for k, values in enumerate((hydro.added_mass, hydro.damping)):
        square[k][:, [0, 1], [0, 1]] = values[:, ROWS].T
    force = np.conj(np.transpose(getattr(hydro, part)[:, list(HEADINGS)][:, :, ROWS], (2, 1, 0))) * sign
    names = ["Yaw", "Roll"]
    dims = ("omega", "influenced_dof", "radiating_dof")
    return xr.Dataset(
        {
            "added_mass": (dims, square[0]),
            "radiation_damping": (dims, square[1]),
            "excitation_force": (("omega", "wave_direction", "influenced_dof"), force),
        },
        coords={
            "omega": omega,
            "period": ("omega", 2.0 * np.pi / omega),
            "wave_direction": np.deg2rad(hydro.headings[list(HEADINGS)]),
            "influenced_dof": names,
            "radiating_dof": names,
            "rho": 1000.0,
            "g": 9.81,
            "forward_speed": 0.0,
        },
    )


@pytest.fixture
def wamit(tmp_path: Path) -> Path:
    exporter = pytest.importorskip("capytaine.io.wamit")
    exporter.export_wamit_1(six_dofs(), str(tmp_path / "float.1"))
    exporter.export_wamit_3(six_dofs(), str(tmp_path / "float.3"))
    return tmp_path / "float"


def write_forces(path: Path, header: list[str], moments: Any, unit: float) -> None:
    """One of NEMOH's files of sizes and angles."""
    hydro, sign, slot, lines = shipped(), (-1.0, 1.0), (5, 3), list(header)
    omega = hydro.omega[ROWS]
    for k in HEADINGS:
        lines.append(f'Zone t="Diffraction force - beta = {hydro.headings[k]:7.3f} deg",I={len(omega)},F=POINT')
        for n, w in enumerate(omega):
            pairs = np.zeros((6, 2))
            for j in range(2):
                moment = sign[j] * np.conj(moments[j, k, ROWS][n])
                pairs[slot[j]] = abs(moment), unit * np.angle(moment)
            lines.append(" ".join(f"{v:.9E}" for v in (w, *pairs.ravel())))
    path.write_text("\n".join(lines) + "\n")


def write_nemoh(folder: Path, unit: float, cal: bool = True) -> Path:
    """Files as NEMOH's postProc writes them: six forces and motions, exp(-i w t), phases in `unit` per radian."""
    hydro = shipped()
    results = folder / "Results"
    results.mkdir(parents=True)
    omega, slot = hydro.omega[ROWS], (5, 3)
    header = ['VARIABLES="w (rad/s)"', *(f'"A 1 {k}" "B 1 {k}"' for k in range(1, 7))]
    lines = list(header)
    for motion in range(6):
        lines.append(f'Zone t="Motion of body  1 in DoF  {motion + 1}",I={len(omega)},F=POINT')
        for n, w in enumerate(omega):
            pairs = np.zeros((6, 2))
            if motion in slot:
                j = slot.index(motion)
                pairs[motion] = hydro.added_mass[j, ROWS][n], hydro.damping[j, ROWS][n]
            lines.append(" ".join(f"{v:.9E}" for v in (w, *pairs.ravel())))
    (results / "RadiationCoefficients.tec").write_text("\n".join(lines) + "\n")
    write_forces(results / "ExcitationForce.tec", header, hydro.excitation, unit)
    if cal:
        (folder / "Nemoh.cal").write_text(
            "--- Environment ----\n1000.0 ! RHO ! KG/M**3\n9.81 ! G ! M/S**2\n0.7 ! DEPTH ! M\n0. 0. ! XEFF YEFF\n"
        )
    return folder


def test_wamit_files_of_capytaines_exporter(wamit: Path) -> None:
    same(read_wamit(wamit, SITE), 2e-6)
    same(read_wamit(wamit.with_suffix(".1"), SITE), 2e-6)


def test_wamit_length_scales_moments(wamit: Path) -> None:
    plain, doubled = read_wamit(wamit, SITE), read_wamit(wamit, Site(depth=0.7, length=2.0))
    assert doubled.added_mass == pytest.approx(32.0 * plain.added_mass)
    assert np.allclose(doubled.excitation, 8.0 * plain.excitation)


def test_wamit_row_of_infinite_frequency_is_taken(wamit: Path) -> None:
    path = wamit.with_suffix(".1")
    path.write_text("0.0 4 4 0.0333\n0.0 6 6 0.0144\n-1.0 6 6 0.5\n" + path.read_text())
    assert read_wamit(wamit, SITE).added_mass_inf == pytest.approx([14.4, 33.3])


@pytest.mark.parametrize("unit", [1.0, 180.0 / np.pi])
def test_nemoh_files_in_radians_and_in_degrees(tmp_path: Path, unit: float) -> None:
    folder = write_nemoh(tmp_path / "project", unit)
    same(read_nemoh(folder), 1e-6)
    same(read_nemoh(folder / "Results"), 1e-6)


def parts_are_ours(read: Hydrodynamics, digits: float) -> None:
    """Froude-Krylov as it was written, and the rest of the excitation as diffraction."""
    hydro = shipped()
    for name in ("froude_krylov", "diffraction"):
        ours, theirs = getattr(read, name), getattr(hydro, name)
        assert ours is not None and theirs is not None
        truth = theirs[:, list(HEADINGS)][:, :, ROWS]
        assert np.max(np.abs(ours - truth)) < digits * np.max(np.abs(truth))


def test_wamit_keeps_froude_krylov_apart(wamit: Path) -> None:
    assert read_wamit(wamit, SITE).froude_krylov is None
    exporter = pytest.importorskip("capytaine.io.wamit")
    exporter.export_wamit_3(six_dofs("froude_krylov"), str(wamit.with_name("part.3")))
    wamit.with_name("part.3").rename(wamit.with_name("float.3fk"))
    parts_are_ours(read_wamit(wamit, SITE), 1e-5)


@pytest.mark.parametrize("unit", [1.0, 180.0 / np.pi])
@pytest.mark.parametrize("turn", [1.0, 1e-3])
def test_nemoh_keeps_froude_krylov_apart(tmp_path: Path, unit: float, turn: float) -> None:
    """Also where all angles of the part are so small that they could be either degrees or radians."""
    folder = write_nemoh(tmp_path, unit)
    assert read_nemoh(folder).froude_krylov is None
    header, part = ['VARIABLES="w (rad/s)"'], shipped().froude_krylov
    assert part is not None
    if turn < 1.0:  # the file has the moment about -phi1
        part = np.abs(part) * np.exp(1j * turn * np.angle(part)) * np.array([-1.0, 1.0])[:, None, None]
    write_forces(folder / "Results" / "FKForce.tec", header, part, unit)
    found = read_nemoh(folder).froude_krylov
    truth = part[:, list(HEADINGS)][:, :, ROWS]
    assert found is not None and np.max(np.abs(found - truth)) < 1e-5 * np.max(np.abs(truth))
    if turn == 1.0:
        parts_are_ours(read_nemoh(folder), 1e-5)


def test_nemoh_without_cal_uses_the_site(tmp_path: Path) -> None:
    assert read_nemoh(write_nemoh(tmp_path, 1.0, cal=False), Site(depth=3.0)).depth == 3.0


@pytest.mark.slow
@pytest.mark.parametrize("format", ["wamit", "nemoh", "capytaine"])
def test_import_writes_a_database_with_certified_fits(format: str, wamit: Path, tmp_path: Path) -> None:
    source = {"wamit": wamit, "nemoh": tmp_path / "nemoh", "capytaine": SHIPPED}[format]
    write_nemoh(tmp_path / "nemoh", 1.0)
    hydro = load(import_results(source, format, tmp_path / "out.nc", SITE))
    from gyroctl.hydrodynamics.passivity import certify

    assert set(hydro.fits) == {"accurate", "fine"}
    assert all(certify(*pair[j]).passive for pair in hydro.fits.values() for j in range(2))
    assert hydro.stiffness == (0.0 if format == "nemoh" else pytest.approx(shipped().stiffness)) or format == "nemoh"


def test_unknown_format_names_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="wamit"):
        import_results(tmp_path, "aqwa", tmp_path / "out.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("format", sorted(READERS))
def test_missing_results_are_named_and_nothing_is_written(format: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        import_results(tmp_path / "nowhere", format, tmp_path / "out.nc")
    assert list(tmp_path.iterdir()) == []


def test_wamit_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.1").write_text("some words\nand more\n")
    (tmp_path / "x.3").write_text("some words\n")
    with pytest.raises(InputError, match="no row of"):
        read_wamit(tmp_path / "x")


def test_damaged_wamit_row_is_named_by_its_line(wamit: Path) -> None:
    path = wamit.with_suffix(".3")
    lines = path.read_text().splitlines()
    lines[4] = "1.0 0.0 6 12.0"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"float\.3, line 5"):
        read_wamit(wamit)


def test_absent_modes_are_refused(wamit: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="lacks values"):
        read_wamit(wamit, Site(modes=(-6, 5)))
    with pytest.raises(InputError, match="needs mode 9"):
        read_nemoh(write_nemoh(tmp_path / "n", 1.0), Site(modes=(9, 4)))


def test_nemoh_of_another_layout_is_refused(tmp_path: Path) -> None:
    folder = write_nemoh(tmp_path, 1.0)
    (folder / "Results" / "RadiationCoefficients.tec").write_text("1 2 3\n1 2\n")
    with pytest.raises(InputError, match="not made of zones"):
        read_nemoh(folder)
