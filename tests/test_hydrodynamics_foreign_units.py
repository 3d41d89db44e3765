"""Units, limits and damaged rows of foreign files: read right, or refused by name; never guessed, never shifted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from foreign_files import CAL, capytaine, is_ours, omega, stored, truth, write_nemoh, write_wamit

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import load, shipped
from gyroctl.hydrodynamics.fortran_numbers import number
from gyroctl.hydrodynamics.frequency_unit import departure
from gyroctl.hydrodynamics.importers import Site, read_capytaine, read_nemoh, read_wamit

INF = shipped().added_mass_inf / 1000.0


@pytest.mark.parametrize(
    ("text", "value"),
    [("1D+02", 100.0), ("1.2-101", 1.2e-101), ("-.5d-3", -5e-4), ("0.1234568-100", 1.234568e-101), ("7", 7.0)],
)
def test_numbers_as_fortran_writes_them(text: str, value: float) -> None:
    assert number(text) == value


@pytest.mark.parametrize("text", ["*******", "NaN", "-Infinity", "1.0E+999", "2.5+400"])
def test_what_fortran_could_not_write_is_no_number(text: str) -> None:
    assert np.isnan(number(text) or 0.0)


@pytest.mark.parametrize("text", ["1_0", "1.2-1", "abc", "1.0e", "0x10", "٣", "1.0-2.0"])
def test_words_are_no_numbers(text: str) -> None:
    assert number(text) is None


# --- frequencies --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", ["rad/s", "Hz"])
def test_a_wamit_column_that_holds_no_periods_is_refused_without_the_unit_and_read_with_it(
    tmp_path: Path, unit: str
) -> None:
    path = write_wamit(tmp_path, unit)
    with pytest.raises(InputError, match=r"float\.1: frequency.*--frequency rad/s, Hz or period"):
        read_wamit(path)
    assert is_ours(read_wamit(path, Site(frequency=unit)))


def test_periods_of_wamit_need_no_option(tmp_path: Path) -> None:
    read = read_wamit(write_wamit(tmp_path))
    assert is_ours(read) and read.provenance["import"]["frequency"].startswith("period")


def test_kramers_kronig_tells_the_axis_from_its_reverse() -> None:
    hydro = shipped()
    for j in range(2):
        right = departure(hydro.omega, hydro.added_mass[j], hydro.damping[j])
        turned = 1.0 / hydro.omega
        wrong = departure(turned, hydro.added_mass[j], hydro.damping[j] / hydro.omega * turned)
        assert right < 0.01 and wrong > 1.5


@pytest.mark.parametrize(
    ("unit", "head", "kind"), [("Hz", "f (Hz)", 2), ("period", "T (s)", 3), ("rad/s", "w (rad/s)", 1)]
)
def test_nemoh_frequencies_are_what_head_or_cal_call_them(tmp_path: Path, unit: str, head: str, kind: int) -> None:
    told = f"{CAL}{kind} ! output freq type, 1,2,3=[rad/s,Hz,s]\n"
    assert is_ours(read_nemoh(write_nemoh(tmp_path / "head", unit, head)))
    assert is_ours(read_nemoh(write_nemoh(tmp_path / "cal", unit, "frequency", told)))
    assert is_ours(read_nemoh(write_nemoh(tmp_path / "both", unit, head, told)))


def test_nemoh_frequencies_that_nobody_names_or_two_names_contradict_are_refused(tmp_path: Path) -> None:
    silent = write_nemoh(tmp_path / "silent", "Hz", "frequency")
    with pytest.raises(InputError, match="told nowhere"):
        read_nemoh(silent)
    assert is_ours(read_nemoh(silent, Site(frequency="Hz")))
    torn = write_nemoh(tmp_path / "torn", "Hz", "w (rad/s)", f"{CAL}2 ! output freq type\n")
    with pytest.raises(InputError, match=r"rad/s by .* and Hz by Nemoh.cal.*two ways"):
        read_nemoh(torn)
    assert is_ours(read_nemoh(torn, Site(frequency="Hz")))


@pytest.mark.parametrize("main", ["omega", "freq", "period", "wavenumber", "wavelength"])
@pytest.mark.parametrize("beside", [True, False])
def test_any_main_dimension_of_capytaine_is_read(tmp_path: Path, main: str, beside: bool) -> None:
    w, k = omega(), np.linspace(0.01, 60.0, 600001)
    waves = np.interp(w, np.sqrt(9.81 * k * np.tanh(0.7 * k)), k)  # the dispersion turned round by a table
    axis = {"omega": w, "freq": w / 2 / np.pi, "period": 2 * np.pi / w, "wavenumber": waves}
    axis["wavelength"] = 2 * np.pi / waves
    data = capytaine().rename({"omega": "main"}).assign_coords({main: ("main", axis[main])})
    if beside and main != "omega":
        data = data.assign_coords(omega=("main", w))
    data = data.swap_dims({"main": main}).drop_vars("main", errors="ignore")
    read = load(stored(data, tmp_path / "main.nc"))
    assert read.omega == pytest.approx(w, rel=1e-4 if "wave" in main and not beside else 1e-12)
    assert np.allclose(read.damping, truth("damping"))


def test_axes_of_capytaine_that_contradict_each_other_are_refused(tmp_path: Path) -> None:
    hertz = capytaine().assign_coords(omega=omega() / (2 * np.pi), period=("omega", 2 * np.pi / omega()))
    with pytest.raises(InputError, match=r"period.*rad/s where omega is"):
        load(stored(hertz, tmp_path / "torn.nc"))
    assert is_ours(load(tmp_path / "torn.nc", Site(frequency="period")))
    hertz = capytaine().assign_coords(omega=("omega", omega() / (2 * np.pi), {"units": "Hz"}))
    assert is_ours(load(stored(hertz, tmp_path / "hertz.nc")))
    with pytest.raises(InputError, match=r"hydro\.frequency = 'period'"):
        load(stored(capytaine(), tmp_path / "plain.nc"), Site(frequency="period"))


# --- rows of the limits -------------------------------------------------------------------------------------------


def test_limits_of_wamit_are_kept_also_where_one_mode_lacks_them(tmp_path: Path) -> None:
    limits = [f" 0.0 4 4 {INF[1]:.7E}", " -1.0 6 6 2.5E-02"]
    read = read_wamit(write_wamit(tmp_path, limits=limits))
    assert read.added_mass_inf[1] == pytest.approx(1000.0 * INF[1], rel=1e-6)
    assert read.added_mass_inf[0] == pytest.approx(1000.0 * INF[0], rel=0.02)
    told = read.provenance["import"]
    assert told["added_mass_inf of phi3"].startswith("row") and told["added_mass_inf of phi1"].startswith("Kramers")
    assert read.added_mass_zero is not None and read.added_mass_zero[0] == 25.0 and np.isnan(read.added_mass_zero[1])


@pytest.mark.parametrize(("infinite", "zero"), [("0.0", None), ("-1.0", "0.0"), ("-1.0", None), (None, "0.0")])
def test_limits_among_frequencies_are_told_apart_by_the_added_mass(
    tmp_path: Path, infinite: str | None, zero: str | None
) -> None:
    low = truth("added_mass")[:, 0] / 1000.0
    limits = [] if infinite is None else [f"{infinite} {m} {m} {INF[j]:.7E}" for j, m in enumerate((6, 4))]
    limits += [] if zero is None else [f"{zero} {m} {m} {1.01 * low[j]:.7E}" for j, m in enumerate((6, 4))]
    read = read_wamit(write_wamit(tmp_path, "rad/s", limits=limits), Site(frequency="rad/s"))
    if infinite is not None:
        assert read.added_mass_inf == pytest.approx(1000.0 * INF, rel=1e-6)
    assert (read.added_mass_zero is not None) == (zero is not None)


def test_limits_of_capytaine_are_kept_also_where_one_mode_lacks_them(tmp_path: Path) -> None:
    data = capytaine()
    ends = data.isel(omega=[0, -1]).assign_coords(omega=[0.0, np.inf])
    ends = ends.assign(added_mass=(ends["added_mass"].dims, np.array([np.diag([1.0, 2.0]), np.diag([np.nan, 32.0])])))
    import xarray as xr

    read = load(stored(xr.concat([data, ends], "omega"), tmp_path / "ends.nc"))
    assert is_ours(read)
    assert read.added_mass_inf[1] == 32.0 and read.added_mass_inf[0] == pytest.approx(1000.0 * INF[0], rel=0.02)
    assert read.added_mass_zero == pytest.approx([1.0, 2.0])


# --- rows that cannot be read -------------------------------------------------------------------------------------


def damaged(path: Path, line: int, column: int, word: str) -> Path:
    """Replace a word of a file, lines from 1."""
    lines = path.read_text().splitlines()
    words = lines[line - 1].split()
    words[column] = word
    lines[line - 1] = " ".join(words)
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("word", ["*************", "NaN", "1.0E+999"])
@pytest.mark.parametrize(("suffix", "line", "column"), [(".1", 13, 3), (".1", 14, 4), (".3", 13, 6), (".3", 14, 5)])
def test_a_frequency_that_wamit_could_not_write_is_left_out_by_file_and_line(
    tmp_path: Path, suffix: str, line: int, column: int, word: str
) -> None:
    path = write_wamit(tmp_path)
    damaged(path.with_suffix(suffix), line, column, word)
    read = read_wamit(path)
    assert is_ours(read, left_out=[6])
    (note,) = read.provenance["import"]["notes"]
    assert f"float{suffix}, line {line}" in note and f"{omega()[6]:.4g}" in note


def test_size_and_phase_of_wamit_are_not_needed(tmp_path: Path) -> None:
    path = write_wamit(tmp_path)
    damaged(path.with_suffix(".3"), 5, 4, "********")
    assert is_ours(read_wamit(path))


@pytest.mark.parametrize(
    ("line", "column", "word"), [(1, 3, "x"), (9, 0, "***"), (9, 1, "NaN"), (9, 4, "1.0-2.0"), (9, 4, "")]
)
def test_a_row_of_wamit_that_is_none_is_refused_by_its_line(tmp_path: Path, line: int, column: int, word: str) -> None:
    path = write_wamit(tmp_path)
    damaged(path.with_suffix(".1"), line, column, word)
    with pytest.raises(InputError, match=rf"float\.1, line {line}\b"):
        read_wamit(path)


def test_a_row_that_stands_twice_with_other_values_is_refused(tmp_path: Path) -> None:
    path = write_wamit(tmp_path).with_suffix(".1")
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines, lines[4]]) + "\n")
    assert is_ours(read_wamit(path))
    path.write_text("\n".join([*lines, lines[4].replace("E-02", "E-01", 1)]) + "\n")
    with pytest.raises(InputError, match=rf"line {len(lines) + 1}.*once more"):
        read_wamit(path)


@pytest.mark.parametrize("word", ["0.1234568-100", "********", "NaN"])
@pytest.mark.parametrize("motion", [1, 2, 5])
def test_a_number_of_another_mode_shifts_none_of_nemoh(tmp_path: Path, motion: int, word: str) -> None:
    folder = write_nemoh(tmp_path / "n")
    first = 8 + (motion - 1) * (len(omega()) + 1)
    damaged(folder / "Results" / "RadiationCoefficients.tec", first + 5, 2, word)
    assert is_ours(read_nemoh(folder))


def test_an_own_number_that_nemoh_could_not_write_leaves_out_its_frequency(tmp_path: Path) -> None:
    folder = write_nemoh(tmp_path / "n")
    line = 9 + 3 * (len(omega()) + 1) + 5
    damaged(folder / "Results" / "RadiationCoefficients.tec", line, 8, "*****")
    read = read_nemoh(folder)
    assert is_ours(read, left_out=[5])
    assert f"RadiationCoefficients.tec, line {line}" in read.provenance["import"]["notes"][0]


def test_motions_of_nemoh_are_known_by_their_titles_and_must_be_whole(tmp_path: Path) -> None:
    assert is_ours(read_nemoh(write_nemoh(tmp_path / "order", order="645312")))
    assert is_ours(read_nemoh(write_nemoh(tmp_path / "two", order="46")))
    folder = write_nemoh(tmp_path / "short")
    path = folder / "Results" / "RadiationCoefficients.tec"
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:20] + lines[21:]) + "\n")
    with pytest.raises(InputError, match=rf"says {len(omega())} rows and has {len(omega()) - 1}"):
        read_nemoh(folder)
    damaged(path, 12, 3, "12..5")
    with pytest.raises(InputError, match=r"RadiationCoefficients\.tec, line 12"):
        read_nemoh(folder)


def test_frequencies_at_which_capytaine_has_nan_are_left_out_and_named(tmp_path: Path) -> None:
    data = capytaine()
    values = data["added_mass"].values.copy()
    values[:2] = np.nan
    read = load(stored(data.assign(added_mass=(data["added_mass"].dims, values)), tmp_path / "nan.nc"))
    assert is_ours(read, left_out=[0, 1])
    (note,) = read.provenance["import"]["notes"]
    assert "0.35, 0.8 rad/s" in note and "begins at 1.25 rad/s" in note
    values[7:] = np.nan
    with pytest.raises(InputError, match=r"not finite, at 0.35, 0.8"):
        load(stored(data.assign(added_mass=(data["added_mass"].dims, values)), tmp_path / "more.nc"))


# --- angles -------------------------------------------------------------------------------------------------------


def test_phases_of_a_whole_turn_are_asked_for(tmp_path: Path) -> None:
    folder = write_nemoh(tmp_path / "turn", turn=2 * np.pi)
    with pytest.raises(InputError, match="--phases deg or rad"):
        read_nemoh(folder)
    assert is_ours(read_nemoh(folder, Site(phases="rad")))
    assert not is_ours(read_nemoh(folder, Site(phases="deg")))


def test_headings_of_capytaine_go_by_their_unit(tmp_path: Path) -> None:
    turned = capytaine((0, 6)).assign_coords(wave_direction=("wave_direction", [0.0, 90.0], {"units": "deg"}))
    read = load(stored(turned, tmp_path / "deg.nc"))
    assert read.headings == pytest.approx([0.0, 90.0]) and is_ours(read, (0, 6))
    bare = capytaine((0, 6)).assign_coords(wave_direction=[0.0, 90.0])
    with pytest.raises(InputError, match=r"beyond 2 pi rad.*--headings"):
        load(stored(bare, tmp_path / "bare.nc"))
    assert is_ours(load(tmp_path / "bare.nc", Site(headings="deg")), (0, 6))
    with pytest.raises(InputError, match=r"hydro.headings"):
        load(tmp_path / "deg.nc", Site(headings="rad"))


def test_headings_of_wamit_that_could_be_radians_are_asked_for(tmp_path: Path) -> None:
    path = write_wamit(tmp_path, headings=(0, 2, 4))
    text = path.with_suffix(".3").read_text()
    for degrees in (30.0, 60.0):
        text = text.replace(f" {degrees:.6E} ", f" {np.deg2rad(degrees):.6E} ")
    path.with_suffix(".3").write_text(text)
    with pytest.raises(InputError, match="could be radians or degrees"):
        read_wamit(path)
    read = read_wamit(path, Site(headings="rad"))
    assert read.headings == pytest.approx([0.0, 30.0, 60.0], abs=1e-4)


def test_headings_that_repeat_a_direction_must_hold_the_same(tmp_path: Path) -> None:
    path = write_wamit(tmp_path, headings=(0, 12, 18))
    third = path.with_suffix(".3")
    text = third.read_text()
    again = [row.replace("1.800000E+02", "-1.80000E+02") for row in text.splitlines() if "1.800000E+02" in row]
    third.write_text(text + "\n".join(again) + "\n")
    read = read_wamit(path)
    assert len(read.headings) == 3 and np.ptp(read.headings) < 360.0
    third.write_text(text + "\n".join(row.replace("-1.80000E+02", "-9.00000E+01") for row in again) + "\n")
    with pytest.raises(InputError, match=r"is the direction of .* with other moments"):
        read_wamit(path)


def test_an_option_that_the_file_contradicts_or_cannot_use_is_refused(tmp_path: Path) -> None:
    path = stored(capytaine(), tmp_path / "base.nc")
    for name, value in (("rho", 1025.0), ("depth", 5.0), ("g", 9.0), ("length", 9.0), ("phases", "deg")):
        with pytest.raises(InputError, match=rf"hydro.{name}"):
            read_capytaine(path, Site(**{name: value}))
    for place in ({"about": (0.0, 0.0, 1.0)}, {"centre": (1.0, 0.0)}, {"modes": (3, 5)}):
        with pytest.raises(InputError):
            read_capytaine(path, Site(**place))
    assert read_capytaine(path, Site(rho=1000.0, depth=0.7, stiffness=2945.0)).stiffness == 2945.0
    folder = write_nemoh(tmp_path / "n", cal=CAL)
    for name, value in (("rho", 1025.0), ("depth", 5.0), ("length", 2.0)):
        with pytest.raises(InputError, match=rf"hydro.{name}"):
            read_nemoh(folder, Site(**{name: value}))
    for name in ("frequency", "headings", "phases"):
        with pytest.raises(InputError, match="is not one of"):
            Site(**{name: "turns"})
