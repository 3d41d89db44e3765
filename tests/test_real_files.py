"""Files as buoys and other codes wrote them, read beside a plain reckoning from their text."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Site, export_results, import_report, import_results
from gyroctl.hydrodynamics.nemoh import read_nemoh
from gyroctl.hydrodynamics.wamit import read_wamit
from gyroctl.waves import DirectionalSpectrum, TabulatedSpectrum, read_spectrum

REAL = Path(__file__).parent / "real_files"
RHO, G = 1000.0, 9.81


# --- spectra ---------------------------------------------------------------------------------------------------------


def numbers(line: str) -> list[float]:
    return [float(word) for word in line.replace("(", " ").replace(")", " ").replace(",", " ").split()]


def triaxys() -> tuple[np.ndarray, np.ndarray]:
    rows = np.array([numbers(line) for line in (REAL / "triaxys.NONDIRSPEC").read_text().splitlines()[9:]])
    return rows[:, 0], rows[:, 1]


def datawell_rows() -> tuple[list[float], np.ndarray]:
    lines = (REAL / "buoy}2024-09-09T01h15Z.spt").read_text().splitlines()
    return [float(line) for line in lines[:12]], np.array([numbers(line) for line in lines[12:]])


def datawell() -> tuple[np.ndarray, np.ndarray]:
    head, rows = datawell_rows()
    return rows[:, 0], head[3] * rows[:, 1]


def spotter_column(name: str) -> np.ndarray:
    head, row = (line.split(",") for line in (REAL / "spotter.csv").read_text().splitlines())
    found = [float(v) for k, v in zip(head, row, strict=True) if k.strip().startswith(f"{name}_")]
    return np.array(found)


def spotter_said(name: str) -> float:
    head, row = (line.split(",") for line in (REAL / "spotter.csv").read_text().splitlines())
    return next(float(v) for k, v in zip(head, row, strict=True) if k.strip().startswith(name))


def spotter() -> tuple[np.ndarray, np.ndarray]:
    return spotter_column("f"), spotter_column("varianceDensity")


def swan_table() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    lines = (REAL / "swan.spec").read_text().splitlines()
    at = {
        word: next(n for n, line in enumerate(lines) if line.startswith(word)) for word in ("AFREQ", "NDIR", "FACTOR")
    }
    f = np.array([float(line) for line in lines[at["AFREQ"] + 2 :][:24]])
    directions = np.array([float(line) for line in lines[at["NDIR"] + 2 :][:36]])
    table = float(lines[at["FACTOR"] + 1]) * np.array([numbers(line) for line in lines[at["FACTOR"] + 2 :]])
    return f, directions, table


def swan() -> tuple[np.ndarray, np.ndarray]:
    f, _, table = swan_table()
    return f, table.sum(axis=1) * 10.0


def ndbc_row(suffix: str) -> np.ndarray:
    """Pairs of value and frequency of the hour 02:50."""
    line = next(line for line in (REAL / f"41010.{suffix}").read_text().splitlines() if line[:16] == "2020 06 01 02 50")
    return np.array(numbers(line)[6 if suffix == "data_spec" else 5 :]).reshape(-1, 2)


def ndbc() -> tuple[np.ndarray, np.ndarray]:
    pairs = ndbc_row("data_spec")
    return pairs[:, 1], pairs[:, 0]


FILES = {
    "triaxys": ("triaxys.NONDIRSPEC", triaxys, None),
    "datawell": ("buoy}2024-09-09T01h15Z.spt", datawell, None),
    "spotter": ("spotter.csv", spotter, None),
    "swan": ("swan.spec", swan, None),
    "ndbc": ("41010.data_spec", ndbc, "2020-06-01T02"),
}


def by_trapezoid(f: np.ndarray, s: np.ndarray) -> dict[int, float]:
    """Moments over the frequency in Hz, of straight lines between the rows of the text."""
    fine = np.linspace(f[0], f[-1], 40001)
    density = np.interp(fine, f, s)
    return {n: float(np.trapezoid(density * fine**n, fine)) for n in (0, 1, 2)}


@pytest.mark.parametrize("form", FILES)
def test_spectrum_of_a_buoy_has_the_moments_of_its_text(form: str) -> None:
    pytest.importorskip("wavespectra")
    name, parse, time = FILES[form]
    f, s = parse()
    sea = read_spectrum(REAL / name, format=form, time=time)
    assert isinstance(sea, TabulatedSpectrum)
    m = by_trapezoid(f, s)
    for n, value in m.items():
        assert sea.moment(n) == pytest.approx(value * (2.0 * math.pi) ** n, rel=1e-5)
    assert sea.hs == pytest.approx(4.0 * math.sqrt(m[0]), rel=1e-5)
    assert sea.tp == pytest.approx(1.0 / f[np.argmax(s)], rel=1e-5)


def test_buoys_own_figures_are_met() -> None:
    pytest.importorskip("wavespectra")
    head, _ = datawell_rows()
    sea = read_spectrum(REAL / FILES["datawell"][0], format="datawell")
    assert sea.hs == pytest.approx(0.01 * head[1], rel=0.003)
    assert 2.0 * math.pi * math.sqrt(sea.moment(0) / sea.moment(2)) == pytest.approx(head[2], rel=0.01)
    spot = read_spectrum(REAL / "spotter.csv", format="spotter", directional=True, axis=0.0)
    assert isinstance(spot, DirectionalSpectrum)
    assert spot.hs == pytest.approx(spotter_said("Significant"), rel=0.001)
    assert spot.tp == pytest.approx(spotter_said("Peak Period"), rel=0.001)
    assert (-180.0 - spot.heading) % 360.0 == pytest.approx(spotter_said("Mean Direction "), abs=0.5)
    assert spot.spread == pytest.approx(spotter_said("Mean Directional"), abs=0.5)


def vector(f: np.ndarray, s: np.ndarray, east: np.ndarray) -> complex:
    """Mean of unit vectors over the energy, by the trapezoid rule."""
    return complex(np.trapezoid(s * east, f) / np.trapezoid(s, f))


def test_mean_direction_and_spread_are_those_of_the_first_moments() -> None:
    """Of Spotter by a1 and b1, of SWAN by its table, of NDBC by alpha1 and r1: where the waves come from."""
    pytest.importorskip("wavespectra")
    f, s = spotter()
    towards = spotter_column("b1") + 1j * spotter_column("a1")  # the part to the north, and to the east
    cases = [("spotter", None, f, s, -towards)]
    f, directions, table = swan_table()
    cases.append(("swan", None, f, *swan_moments(directions, table)))
    f, s = ndbc()
    alpha, r1 = ndbc_row("swdir")[:, 0], ndbc_row("swr1")[:, 0]
    known = alpha < 900.0
    bins = np.where(known, r1 * np.exp(1j * np.radians(np.where(known, alpha, 0.0))), 0.0)
    cases.append(("ndbc", "2020-06-01T02", f, s, bins))
    for form, time, f, s, first in cases:
        sea = read_spectrum(REAL / FILES[form][0], format=form, time=time, directional=True, axis=0.0)
        assert isinstance(sea, DirectionalSpectrum)
        mean = vector(f, s, first)
        come = math.degrees(np.angle(mean)) % 360.0
        assert (-180.0 - sea.heading) % 360.0 == pytest.approx(come, abs=1.0), form
        assert sea.spread == pytest.approx(math.degrees(math.sqrt(2.0 * (1.0 - abs(mean)))), abs=1.5), form


def swan_moments(directions: np.ndarray, table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    s = table.sum(axis=1) * 10.0
    return s, table @ np.exp(1j * np.radians(directions)) * 10.0 / np.where(s > 0.0, s, 1.0)


# --- results of boundary elements ------------------------------------------------------------------------------------


def wamit_rows() -> tuple[dict[tuple[float, int, int], tuple[float, ...]], dict[tuple[float, int], complex]]:
    """The two files by period and modes, as WAMIT's manual has them: over rho L^k and rho L^k omega, rho g A L^m."""
    first, third = {}, {}
    for line in (REAL / "wamit" / "sphere.1").read_text().splitlines()[1:]:
        period, i, j, *values = numbers(line)
        first[period, int(i), int(j)] = tuple(values)
    for line in (REAL / "wamit" / "sphere.3").read_text().splitlines()[1:]:
        period, _, i, _, _, real, imaginary = numbers(line)
        third[period, int(i)] = complex(real, imaginary)
    return first, third


# Moments about a hinge 2 m behind the centre and 1 m above: (r x F) with r = (0, 2, -1) from the hinge to the centre.
PHI1 = {1: 2.0, 6: -1.0}  # minus yaw: -(M6 - 2 F1)
PHI3 = {2: 1.0, 3: 2.0, 4: 1.0}  # roll: M4 + 2 F3 + F2


def about_hinge(first: dict, period: float, arm: dict[int, float], which: int) -> float:
    return sum(p * q * first.get((period, i, j), (0.0, 0.0))[which] for i, p in arm.items() for j, q in arm.items())


def test_wamit_sphere_is_moved_to_its_hinge() -> None:
    first, third = wamit_rows()
    read = read_wamit(REAL / "wamit" / "sphere", Site(hinge=(-2.0, 1.0)))
    periods = sorted({period for period, _, _ in first if period > 0.0}, reverse=True)
    np.testing.assert_allclose(read.omega, 2.0 * np.pi / np.array(periods), rtol=1e-9)
    for n, period in enumerate(periods):
        omega = 2.0 * math.pi / period
        for j, arm in enumerate((PHI1, PHI3)):
            assert read.added_mass[j, n] == pytest.approx(RHO * about_hinge(first, period, arm, 0), rel=1e-6)
            assert read.damping[j, n] == pytest.approx(RHO * omega * about_hinge(first, period, arm, 1), rel=1e-6)
            force = RHO * G * sum(p * third.get((period, i), 0.0) for i, p in arm.items())
            assert abs(read.excitation[j, 0, n] - force) < 1e-6 * abs(force)
    for j, arm in enumerate((PHI1, PHI3)):
        assert read.added_mass_inf[j] == pytest.approx(RHO * about_hinge(first, 0.0, arm, 0), rel=1e-6)
    assert math.isinf(read.depth)


def test_heave_of_a_hemisphere_at_infinite_frequency_is_half_the_displaced_water() -> None:
    read = read_wamit(REAL / "wamit" / "sphere", Site(modes=("heave", "pitch")))
    assert read.added_mass_inf[0] == pytest.approx(0.5 * RHO * 2.0 / 3.0 * math.pi, rel=0.01)


def test_point_in_the_control_file_counts_where_no_word_stands_beside_it(tmp_path: Path) -> None:
    """The fourth line from the end of this file is XBODY by its place alone."""
    for name in ("sphere.1", "sphere.3", "sphere.pot"):
        shutil.copy(REAL / "wamit" / name, tmp_path / name)
    assert "origin of the run" in read_wamit(tmp_path / "sphere").provenance["import"]["point"]
    pot = tmp_path / "sphere.pot"
    text = pot.read_text()
    pot.write_text(text.replace("0.0  0.0  0.0 0.0", "0.0  0.0 -2.0 0.0"))
    with pytest.raises(InputError, match=r"\(0.0, 0.0, -2.0\)"):
        read_wamit(tmp_path / "sphere")
    pot.write_text(text.replace("0.0  0.0  0.0 0.0", "0.0  0.0  0.0 90.0"))
    with pytest.raises(InputError, match="angle"):
        read_wamit(tmp_path / "sphere")


def nemoh_rows(name: str) -> list[np.ndarray]:
    lines = (REAL / "nemoh" / "Results" / name).read_text().splitlines()
    rows = [np.array(numbers(line)) for line in lines if line.startswith("  0.")]
    return [np.array(rows[n : n + 10]) for n in range(0, len(rows), 10)]


SPHERE = Site(modes=("heave", "pitch"), hinge=(0.0, -2.0))


def test_nemoh_sphere_is_its_own_text() -> None:
    read = read_nemoh(REAL / "nemoh", SPHERE)
    heave, pitch = nemoh_rows("RadiationCoefficients.tec")
    (force,) = nemoh_rows("ExcitationForce.tec")
    np.testing.assert_allclose(read.omega, heave[:, 0], rtol=1e-9)
    for j, (rows, mode) in enumerate(((heave, 3), (pitch, 5))):
        np.testing.assert_allclose(read.added_mass[j], rows[:, 2 * mode - 1], rtol=1e-9)
        np.testing.assert_allclose(read.damping[j], rows[:, 2 * mode], rtol=1e-9)
        size, angle = force[:, 2 * mode - 1], force[:, 2 * mode]
        np.testing.assert_allclose(read.excitation[j, 0], size * np.exp(-1j * angle), rtol=1e-9)
    assert read.stiffness == pytest.approx(0.5124872e7) and read.depth == 50.0
    with pytest.raises(InputError, match=r"-2\.0.*--hinge"):
        read_nemoh(REAL / "nemoh", Site(modes=("heave", "pitch")))


def test_two_codes_agree_on_a_hemisphere() -> None:
    """WAMIT's of 1 m, NEMOH's of 5 m, by Froude: sizes and phases, so also the sign of time in either."""
    small = read_wamit(REAL / "wamit" / "sphere", Site(modes=("surge", "heave")))
    large = read_nemoh(REAL / "nemoh", Site(modes=("pitch", "heave"), hinge=(0.0, -2.0)))
    root = math.sqrt(5.0)
    some = large.omega * root < 3.4
    assert some.sum() == 4
    at = large.omega[some] * root
    for j, arm in ((0, 2.0), (1, 1.0)):  # pitch about a point 2 m below the centre: twice the surge, there squared
        for name, power in (("added_mass", 3.0), ("damping", 2.5)):
            have = getattr(large, name)[j, some] / arm**2 / 5.0**power
            want = np.interp(at, small.omega, getattr(small, name)[j])
            np.testing.assert_allclose(have, want, rtol=0.04, err_msg=f"{name} {j}")
        have = large.excitation[j, 0, some] / arm / 25.0
        want = np.interp(at, small.omega, small.excitation[j, 0])
        assert np.max(np.abs(have - want) / np.abs(want)) < 0.03


@pytest.mark.slow
def test_real_results_come_back_from_the_database(tmp_path: Path) -> None:
    path = import_results(REAL / "wamit" / "sphere", "wamit", tmp_path / "one.nc", Site(hinge=(-2.0, 1.0)))
    assert "row of infinite frequency" in str(import_report(path))
    export_results(path, "wamit", tmp_path / "again")
    one = read_wamit(REAL / "wamit" / "sphere", Site(hinge=(-2.0, 1.0)))
    two = read_wamit(tmp_path / "again")
    for name in ("omega", "added_mass", "damping", "excitation", "added_mass_inf"):
        np.testing.assert_allclose(getattr(two, name), getattr(one, name), rtol=1e-6)
