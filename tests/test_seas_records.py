"""Elevation records and spectra as people have them: units, stamps, gaps, drift, samples that cut the waves."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.reading import read_toml
from gyroctl.waves import ElevationRecord, TabulatedSpectrum, read_record, read_spectrum

DENSE = 0.05 * np.arange(12000)


def elevation(time: np.ndarray, seed: int = 7) -> np.ndarray:
    """A JONSWAP sea of Hs 0.283 m at 3.14 rad/s, as a plain sum of waves."""
    omega = np.linspace(1.5, 9.0, 400)
    height = np.sqrt(2.0 * gy.SeaState().spectrum(omega) * (omega[1] - omega[0]))
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, omega.size)
    return np.array([height @ np.cos(omega * t + phase) for t in time])


ETA = elevation(DENSE)
HS = 4.0 * ETA.std()


def table(path: Path, time: np.ndarray, eta: np.ndarray, head: str = "time,elevation") -> Path:
    rows = "\n".join(f"{t:.6f},{e:.6f}" for t, e in zip(time, eta, strict=True))
    path.write_text((head + "\n" if head else "") + rows + "\n", encoding="utf-8")
    return path


def refused(field: str, make: Callable[[], object], *words: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == field, str(caught.value)
    for word in words:
        assert word in str(caught.value)


# --- drift ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", ["ramp", "swing"])
def test_a_record_that_drifts_is_refused_and_read_without_its_drift(tmp_path: Path, shape: str) -> None:
    drift = 0.2 * (DENSE / 600.0 if shape == "ramp" else np.sin(2.0 * np.pi * DENSE / 400.0))
    path = table(tmp_path / "drift.csv", DENSE, ETA + drift)
    refused("sea.eta", lambda: read_record(path), "drifts", "detrend")
    rule = "linear" if shape == "ramp" else "high-pass"
    record = read_record(path, detrend=rule)
    assert record.hs == pytest.approx(HS, rel=0.01) and record.wp == pytest.approx(3.14, abs=0.1)
    assert np.abs(record.surface - (ETA - ETA.mean()))[200:-200].max() < 0.02
    assert any("taken off" in note for note in record.notes)


def test_a_swing_is_left_over_by_a_straight_line(tmp_path: Path) -> None:
    path = table(tmp_path / "drift.csv", DENSE, ETA + 0.2 * np.sin(2.0 * np.pi * DENSE / 300.0))
    refused("sea.eta", lambda: read_record(path, detrend="linear"), "high-pass")


def test_a_little_drift_and_an_offset_are_told(tmp_path: Path) -> None:
    record = read_record(table(tmp_path / "a.csv", DENSE, ETA + 0.5 + 0.04 * DENSE / 600.0))
    assert any("mean level of 0.5" in note for note in record.notes)
    assert any("drift of 0.0" in note for note in record.notes)
    assert not read_record(table(tmp_path / "b.csv", DENSE, ETA)).notes


def test_a_drifting_array_is_refused_where_it_is_realised(device: gy.Plant) -> None:
    record = ElevationRecord(DENSE, ETA + 0.3 * DENSE / 600.0)
    refused("sea.eta", lambda: gy.realise(device, record, 1, 300.0), "drifts")


def test_swell_under_a_wind_sea_is_no_drift(tmp_path: Path) -> None:
    swell = 0.05 * np.cos(0.6 * DENSE)  # a fifth of the frequency, half the energy
    assert read_record(table(tmp_path / "swell.csv", DENSE, ETA + swell)).hs == pytest.approx(
        4.0 * math.sqrt(ETA.var() + 0.05**2 / 2.0), rel=0.02
    )


# --- sampling ------------------------------------------------------------------------------------------------------


def test_samples_that_cut_the_waves_are_refused_and_a_cut_tail_is_told(tmp_path: Path) -> None:
    path = tmp_path / "wave.csv"
    for every, word in ((20, "beyond"), (16, "beyond")):
        table(path, DENSE[::every], ETA[::every])
        refused("sea.time", lambda: read_record(path), word, "Give a record sampled every 0.")
    notes = read_record(table(path, DENSE[::10], ETA[::10])).notes
    assert len(notes) == 1 and "of the energy lies beyond 6.28 rad/s" in notes[0]
    assert not read_record(table(path, DENSE[::4], ETA[::4])).notes


def test_uneven_samples_are_resampled_and_it_is_told(tmp_path: Path) -> None:
    jitter = DENSE + np.random.default_rng(1).uniform(-0.01, 0.01, DENSE.size)
    record = read_record(table(tmp_path / "uneven.csv", jitter, np.interp(jitter, DENSE, ETA)))
    assert any("resampled linearly" in note for note in record.notes)
    assert record.hs == pytest.approx(HS, rel=0.01)


def test_a_spike_is_pointed_at_and_a_probe_that_is_stuck_is_told(tmp_path: Path) -> None:
    spike = ETA.copy()
    spike[500] = 9.9
    refused("sea.eta", lambda: read_record(table(tmp_path / "a.csv", DENSE, spike)), "stands out", "25 s after")
    spike[500] = 1.1 * ETA[500]
    assert not read_record(table(tmp_path / "a.csv", DENSE, spike)).notes
    stuck = ETA.copy()
    stuck[500:540] = stuck[500]
    record = read_record(table(tmp_path / "b.csv", DENSE, stuck))
    assert record.notes == ("the elevation stands still for 1.95 s from 25 s on",)


# --- gaps ----------------------------------------------------------------------------------------------------------


def holed(path: Path, cell: str | None) -> Path:
    rows = [[f"{t:.3f}", f"{e:.6f}"] for t, e in zip(DENSE, ETA, strict=True)]
    for i in (50, 51, 52, 400):
        rows[i][1] = "gone" if cell is None else cell
    kept = [",".join(row) for row in rows if row[1] != "gone"]
    path.write_text("time,elevation\n" + "\n".join(kept) + "\n")
    return path


@pytest.mark.parametrize("cell", ["", "nan", "NaN", "NA", None])
def test_gaps_are_refused_or_filled_by_a_rule_up_to_a_length(tmp_path: Path, cell: str | None) -> None:
    path = holed(tmp_path / "gaps.csv", cell)
    field = "sea.time" if cell is None else "sea.file"
    refused(field, lambda: read_record(path), "gap" if cell is None else "line 52")
    refused("sea.time", lambda: read_record(path, gaps="linear", longest=0.15), "2.45", "0.2 s")
    for rule, most in (("linear", 0.02), ("spline", 0.004)):
        record = read_record(path, gaps=rule, longest=0.2)
        assert record.time == pytest.approx(DENSE, abs=1e-6)
        assert np.abs(record.eta - ETA).max() < most
        assert "2 gaps of up to 0.2 s filled" in record.notes[0] and "4 samples of 12000" in record.notes[0]


def test_a_rule_for_gaps_needs_its_length_and_a_name(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", DENSE, ETA)
    refused("sea.longest", lambda: read_record(path, gaps="linear"), "longest")
    refused("sea.gaps", lambda: read_record(path, longest=1.0), "rule")
    refused("sea.gaps", lambda: read_record(path, gaps="guess", longest=1.0), "linear")
    refused("sea.detrend", lambda: read_record(path, detrend="parabola"), "high-pass")
    refused("sea.cutoff", lambda: read_record(path, cutoff=1.0), "high-pass")
    refused("sea.cutoff", lambda: read_record(path, detrend="high-pass", cutoff=4.0), "waves")


def test_a_time_that_stands_twice_is_named(tmp_path: Path) -> None:
    time = DENSE.copy()
    time[30] = time[29]
    refused("sea.time", lambda: read_record(table(tmp_path / "a.csv", time, ETA)), "sample 31 stands twice")


def test_words_among_the_numbers_are_refused_by_line(tmp_path: Path) -> None:
    path = holed(tmp_path / "a.csv", "broken")
    refused("sea.file", lambda: read_record(path, gaps="linear", longest=1.0), "line 52", "broken")


# --- units, stamps, columns ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("head", ["time [s],eta [mm]", "t (s),eta (mm)", "time_s,eta_mm", "# time [s],eta [mm]"])
def test_millimetres_by_the_heading(tmp_path: Path, head: str) -> None:
    record = read_record(table(tmp_path / "a.csv", DENSE, 1000.0 * ETA, head))
    assert record.hs == pytest.approx(HS, rel=1e-4) and "mm" in record.notes[0]


def test_units_by_option_and_times_by_the_heading(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", 1000.0 * DENSE, 100.0 * ETA, "time [ms],eta")
    record = read_record(path, unit="cm")
    assert record.hs == pytest.approx(HS, rel=1e-3) and record.step == pytest.approx(0.05)
    refused("sea.unit", lambda: read_record(path, unit="parsec"), "mm")
    volts = table(tmp_path / "v.csv", DENSE, ETA, "time [s],probe [V]")
    refused("sea.unit", lambda: read_record(volts), "'V'")
    metres = table(tmp_path / "m.csv", DENSE, ETA, "time [s],probe [m]")
    refused("sea.unit", lambda: read_record(metres, unit="mm"), "heading")


def test_what_is_steeper_than_water_is_refused(tmp_path: Path, device: gy.Plant) -> None:
    centimetres = read_record(table(tmp_path / "a.csv", DENSE, 100.0 * ETA))
    refused("sea.eta", lambda: gy.realise(device, centimetres, 1, 300.0), "breaks", "millimetres")
    refused("sea.hs", lambda: gy.realise(device, gy.SeaState(hs=2.83), 1, 300.0), "breaks")
    refused("sea.hs", lambda: gy.SeaState(hs=283.0), "100")


@pytest.mark.parametrize("form", ["%Y-%m-%dT%H:%M:%S.%f", "%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f+02:00"])
def test_time_stamps(tmp_path: Path, form: str) -> None:
    import datetime

    start = datetime.datetime(2024, 2, 28, 23, 55)
    stamps = [(start + datetime.timedelta(seconds=float(t))).strftime(form) for t in DENSE[:2000]]
    for mark in (",", "\t", " "):
        path = tmp_path / "a.csv"
        path.write_text("\n".join(f"{s}{mark}{e:.6f}" for s, e in zip(stamps, ETA[:2000], strict=True)))
        record = read_record(path)
        np.testing.assert_allclose(record.time, DENSE[:2000], atol=1e-5)
        np.testing.assert_allclose(record.eta, ETA[:2000], atol=1e-6)
    path.write_text(path.read_text().replace(stamps[3], "2024-02-30T00:00:00"))
    refused("sea.file", lambda: read_record(path), "line 4", "2024-02-30")


def test_columns_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{i},{t:.3f},{e:.6f},{2 * e:.6f}" for i, (t, e) in enumerate(zip(DENSE, ETA, strict=True)))
    path.write_text("sample,t [s],probe 1 [m],probe 2 [m]\n" + rows)
    assert read_record(path, clock="t", column="probe 2").hs == pytest.approx(2.0 * HS, rel=1e-4)
    refused("sea.file", lambda: read_record(path), "4 columns", "probe 1")
    refused("sea.column", lambda: read_record(path, clock="t", column="probe"), "probe 1")
    refused("sea.column", lambda: read_record(path, clock="t", column="t"), "different")


def test_quotes_and_counted_samples(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = "".join(f'"{t:.3f}","{1000.0 * e:.3f}"\n' for t, e in zip(DENSE, ETA, strict=True))
    path.write_text('"t [s]","eta [mm]"\n' + rows)
    assert read_record(path).hs == pytest.approx(HS, rel=1e-3)
    counted = table(tmp_path / "b.csv", np.arange(DENSE.size), ETA, "sample,eta")
    refused("sea.clock", lambda: read_record(counted), "counts")


def test_decimal_commas_between_semicolons_and_nowhere_else(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    pairs = [(f"{t:.3f}".replace(".", ","), f"{e:.6f}".replace(".", ",")) for t, e in zip(DENSE, ETA, strict=True)]
    for mark in (";", "\t"):
        path.write_text(f"Zeit [s]{mark}Höhe [m]\r\n" + "\r\n".join(mark.join(pair) for pair in pairs), "utf-8-sig")
        assert read_record(path).hs == pytest.approx(HS, rel=1e-4)
    path.write_text("\n".join(" ".join(pair) for pair in pairs))
    with pytest.raises(InputError, match=r"marks of decimals|columns"):
        read_record(path)
    path.write_text("1.000,5;2,0\n2.000,5;3,0\n")
    refused("sea.file", lambda: read_record(path), "line 1")


def test_marks_of_byte_order(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbf[run]\r\nduration = 150.0\r\n")
    assert read_toml("experiment", path) == {"run": {"duration": 150.0}}
    for encoding in ("utf-16", "utf-16-le", "utf-16-be"):
        path.write_text("[run]\nduration = 150.0\n", encoding)
        refused("experiment", lambda: read_toml("experiment", path), "UTF-16", "in UTF-8")
        path.write_text("time,eta\n0,1\n", encoding)
        refused("sea.file", lambda: read_record(path), "UTF-16")


def test_a_record_by_froude(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", DENSE * math.sqrt(20.0), ETA * 20.0)
    record = read_record(path, scale=20.0)
    assert record.hs == pytest.approx(HS, rel=1e-4) and record.step == pytest.approx(0.05)
    for wrong in (0.0, -1.0, math.nan, 1e9):
        refused("sea.scale", lambda wrong=wrong: read_record(path, scale=wrong))


# --- spectra -------------------------------------------------------------------------------------------------------

W = np.linspace(0.5, 12.0, 400)
S = gy.SeaState().spectrum(W)
HZ = 2.0 * math.pi

SAME = [
    ("omega [rad/s],S [m2 s/rad]", 1.0, 1.0),
    ("omega [rad/s],S [m^2 s]", 1.0, 1.0),
    ("w,S", 1.0, 1.0),
    ("omega (rad/s),S (m2/(rad/s))", 1.0, 1.0),
    ("omega [rad/s],S [m²/Hz]", 1.0, HZ),
    ("f [Hz],S [m2/Hz]", 1.0 / HZ, HZ),
    ("f [Hz],S [m2 s]", 1.0 / HZ, HZ),
    ("f [Hz],S", 1.0 / HZ, HZ),
    ("freq_Hz,S [cm^2/Hz]", 1.0 / HZ, 1e4 * HZ),
    ("omega_rad_s,S(omega)", 1.0, 1.0),
    ("f [Hz],S(f) [m2.s]", 1.0 / HZ, HZ),
    ("f [mHz],S [m2*s/rad]", 1000.0 / HZ, 1.0),
]


@pytest.mark.parametrize(("head", "turn", "factor"), SAME)
def test_spectra_by_their_heading(tmp_path: Path, head: str, turn: float, factor: float) -> None:
    path = tmp_path / "s.csv"
    rows = "\n".join(f"{w * turn:.9g},{s * factor:.9g}" for w, s in zip(W, S, strict=True))
    path.write_text(head + "\n" + rows)
    sea = read_spectrum(path)
    assert isinstance(sea, TabulatedSpectrum)
    assert sea.omega == pytest.approx(W, rel=1e-8) and sea.density == pytest.approx(S, rel=1e-7, abs=1e-12)
    assert sea.hs == pytest.approx(0.283, rel=0.01) and sea.wp == pytest.approx(3.14, abs=0.02)
    assert bool(sea.notes) == (turn != 1.0 or factor != 1.0 or head in ("w,S", "omega_rad_s,S(omega)"))


@pytest.mark.parametrize(
    ("head", "value"),
    [
        ("", "no heading"),
        ("f,S", "'f'"),
        ("T [s],S [m2 s]", "'s'"),
        ("f [1/s],S [m2 s]", "1/s"),
        ("f [Hz],S [m]", "'m'"),
    ],
)
def test_spectra_without_a_unit_are_refused(tmp_path: Path, head: str, value: str) -> None:
    path = table(tmp_path / "s.csv", W, S, head)
    refused("sea.unit", lambda: read_spectrum(path), value)


def test_the_option_says_the_unit_of_both_columns(tmp_path: Path) -> None:
    path = table(tmp_path / "s.csv", W / HZ, S * HZ, "")
    assert read_spectrum(path, unit="Hz").wp == pytest.approx(3.14, abs=0.02)
    assert read_spectrum(path, unit="Hz").hs == pytest.approx(0.283, rel=0.01)
    assert read_spectrum(path, unit="rad/s").wp == pytest.approx(3.14 / HZ, abs=0.01)
    refused("sea.unit", lambda: read_spectrum(path, unit="turns"), "'turns'")
    named = table(tmp_path / "n.csv", W / HZ, S * HZ, "f [Hz],S [m2/Hz]")
    refused("sea.unit", lambda: read_spectrum(named, unit="rad/s"), "Hz")


def test_moments_of_a_triangle_by_hand() -> None:
    """S = w - 1 on (1, 2): m_n is the integral of w^(n+1) - w^n; and from zero frequency, S = w: m_-1 = 1."""
    sea = TabulatedSpectrum(np.array([1.0, 2.0]), np.array([0.0, 1.0]))
    for n in (0, 1, 2, 3, 4):
        hand = (2.0 ** (n + 2) - 1.0) / (n + 2) - (2.0 ** (n + 1) - 1.0) / (n + 1)
        assert sea.moment(n) == pytest.approx(hand, rel=1e-12)
    assert sea.moment(-1) == pytest.approx(1.0 - math.log(2.0), rel=1e-12)
    assert sea.te == pytest.approx(2.0 * math.pi * (1.0 - math.log(2.0)) / 0.5, rel=1e-12) and sea.tp == math.pi
    assert TabulatedSpectrum(np.array([0.0, 1.0]), np.array([0.0, 1.0])).moment(-1) == 1.0
    refused("order", lambda: sea.moment(5))


def test_a_spectrum_by_froude_keeps_its_steepness(tmp_path: Path) -> None:
    path = table(tmp_path / "s.csv", W / math.sqrt(20.0), S * 20.0**2.5, "omega [rad/s],S [m2 s]")
    sea = read_spectrum(path, scale=20.0)
    assert sea.hs == pytest.approx(0.283, rel=0.01) and sea.wp == pytest.approx(3.14, abs=0.02)
    assert sea.omega == pytest.approx(W, rel=1e-5)


def test_a_file_that_is_cut_in_its_last_number_is_told(tmp_path: Path) -> None:
    """Its last line has no end then, and fewer digits than all others; a whole file without a last line end is none."""
    record, spectrum = tmp_path / "record.csv", tmp_path / "spectrum.csv"
    time = 0.1 * np.arange(2000)
    eta = [f"{t:.2f},{e:.5f}" for t, e in zip(time, 0.1 * np.cos(3.0 * time), strict=True)]
    density = [f"{w:.2f} {s:.4e}" for w, s in zip(np.arange(2.0, 4.0, 0.1), np.linspace(1e-3, 5e-3, 20), strict=True)]
    for end, said in (("\n", 0), ("", 0)):
        record.write_text("time,elevation\n" + "\n".join(eta) + end)
        spectrum.write_text("omega [rad/s] S [m2 s/rad]\n" + "\n".join(density) + end)
        for sea in (read_record(record), read_spectrum(spectrum)):
            assert sum("is it cut?" in note for note in sea.notes) == said
    record.write_text(record.read_text()[:-2])
    spectrum.write_text(spectrum.read_text()[:-1])  # of the exponent
    for sea in (read_record(record), read_spectrum(spectrum)):
        assert sum("is it cut?" in note for note in sea.notes) == 1
    record.write_text(record.read_text() + "\n")
    assert not any("is it cut?" in note for note in read_record(record).notes)


def test_a_mark_between_names_is_no_name_of_a_column(tmp_path: Path) -> None:
    path = tmp_path / "three.csv"
    path.write_text("omega [rad/s], S [m2 s/rad]\n" + "\n".join(f"{w},1e-3,{w}" for w in (2.0, 2.5, 3.0)) + "\n")
    refused("sea.file", lambda: read_spectrum(path), "3 columns", "2 names of columns")
    for head in ("omega, S", "omega , S", "omega [rad/s] , S [m2 s/rad]"):
        path.write_text(path.read_text().replace(path.read_text().split("\n")[0], head))
        with pytest.raises(InputError) as caught:
            read_spectrum(path)
        assert ", ," not in str(caught.value) and ",," not in str(caught.value)
