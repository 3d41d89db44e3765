"""Spectra of buoys and wave models: read right, one of several chosen by name, turned to the device."""

import builtins
import gzip
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison.sea_table import build_sea
from gyroctl.errors import InputError
from gyroctl.waves import DirectionalSpectrum, TabulatedSpectrum, prepare, read_spectrum
from gyroctl.waves.bands import outside_band

pytest.importorskip("wavespectra")

# The first two hours of 2000 at NDBC's station 44004, a work of the United States government, in the public domain.
FREQUENCIES = [round(0.03 + 0.01 * i, 2) for i in range(38)]
HOURS = {
    "2000 01 01 00": "0 0 0 0 0 .12 .33 .35 .31 .55 .73 .62 .37 .34 .25 .16 .18 .24 .50 .73 .64 .70 .71 .63 .37 .24 "
    ".21 .21 .17 .13 .11 .10 .10 .08 .07 .06 .04 .04",
    "2000 01 01 01": "0 0 0 0 0 0 .16 .24 .35 .32 .67 .61 .54 .67 .83 1.57 1.70 2.37 2.39 1.95 1.01 .65 .47 .54 .40 "
    ".20 .29 .29 .21 .14 .09 .10 .11 .10 .07 .07 .08 .06",
}
NDBC = (
    "YYYY MM DD hh "
    + " ".join(f"{f:.3f}" for f in FREQUENCIES)
    + "\n"
    + "".join(f"{k} {v}\n" for k, v in HOURS.items())
)

F = np.arange(0.02, 0.51, 0.01)
S = 20.0 * np.exp(-0.5 * ((F - 0.1) / 0.02) ** 2) + 4.0 * np.exp(-0.5 * ((F - 0.25) / 0.04) ** 2)
FROM, SPREAD = 250.0, 30.0


def refused(field: str, make: Callable[[], object], *words: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == field, str(caught.value)
    for word in words:
        assert word in str(caught.value)


def by_hand(f: np.ndarray, s: np.ndarray) -> dict[str, float]:
    """Height and periods by plain sums over the bins."""
    some = f > 0.0
    m = {n: float(np.sum(s[some] * f[some] ** n) * (f[1] - f[0])) for n in (-1, 0, 1, 2)}
    return {
        "hs": 4.0 * math.sqrt(m[0]),
        "tp": 1.0 / f[np.argmax(s)],
        "te": m[-1] / m[0],
        "tm02": math.sqrt(m[0] / m[2]),
    }


def agrees(sea: TabulatedSpectrum | DirectionalSpectrum, f: np.ndarray, s: np.ndarray, rel: float = 0.01) -> None:
    hand = by_hand(f, s)
    assert sea.hs == pytest.approx(hand["hs"], rel=rel) and sea.tp == pytest.approx(hand["tp"], rel=1e-6)
    assert sea.te == pytest.approx(hand["te"], rel=rel)
    assert 2.0 * math.pi * math.sqrt(sea.moment(0) / sea.moment(2)) == pytest.approx(hand["tm02"], rel=rel)


def ndbc(folder: Path, name: str = "44004w2000.txt") -> Path:
    path = folder / name
    path.write_text(NDBC)
    return path


def triaxys(folder: Path, directional: bool = False) -> Path:
    path = folder / "buoy [1].spec"  # brackets mean more than one file to the library
    head = (
        "TRIAXYS BUOY DATA REPORT - TAS01970\r\nVERSION = WV\r\nTYPE    = {}DIRECTIONAL SPECTRUM\r\n"
        "DATE    = 2018-01-31 21:00(UTC)\r\nNUMBER OF FREQUENCIES = {}\r\nINITIAL FREQUENCY (Hz) = 0.020\r\n"
        "FREQUENCY SPACING (Hz) = 0.010\r\n"
    ).format(" " if directional else "NON-", F.size)
    if directional:
        angles = np.arange(0.0, 361.0, 10.0)
        rows = S[:, None] * shape(angles)
        head += "DIRECTION SPACING (DEG) = 10.0\r\nROWS = FREQUENCIES\r\n"
        body = "\r\n".join(" ".join(f"{v:.7E}" for v in row) for row in rows)
    else:
        head += "COLUMN 1 = FREQUENCY (Hz)\r\nCOLUMN 2 = SPECTRAL DENSITY (M^2/Hz)\r\n"
        body = "\r\n".join(f"{f:.3f}  {s:.7E}" for f, s in zip(F, S, strict=True))
    path.write_text(head + body + "\r\n", newline="")
    return path


def shape(angles: np.ndarray) -> np.ndarray:
    """Distribution over the directions, cos^2s about `FROM` with the circular deviation `SPREAD` [1/deg]."""
    s = 2.0 / math.radians(SPREAD) ** 2 - 1.0
    fine = np.arange(0.0, 360.0, 0.1)
    area = np.sum(np.abs(np.cos(np.radians(fine - FROM) / 2.0)) ** (2.0 * s)) * 0.1
    return np.abs(np.cos(np.radians(angles - FROM) / 2.0)) ** (2.0 * s) / area


def datawell(folder: Path, name: str = "bay}2024-09-09T01h15Z.spt") -> Path:
    path = folder / name
    rows = [f"{f:.3f},{s / S.max():.6E},{FROM},{SPREAD},0.1,2.3" for f, s in zip(F, S, strict=True)]
    head = [10, 100.0 * by_hand(F, S)["hs"], 4.5, S.max(), 25.0, 19.0, 7, -0.1, 0.3, 0.2, 213.8, 68.2]
    path.write_text("\n".join([*map(str, head), *rows]) + "\n")
    return path


def spotter(folder: Path) -> Path:
    path = folder / "spotter.json"
    same = [FROM] * F.size
    one = {
        "frequency": F.tolist(),
        "varianceDensity": S.tolist(),
        "direction": same,
        "timestamp": "2021-09-29T00:00:00Z",
    }
    one |= {"directionalSpread": [SPREAD] * F.size, **{k: [0.0] * F.size for k in ("a1", "b1", "a2", "b2")}}
    bulk = {"significantWaveHeight": 1.0, "peakPeriod": 10.0, "timestamp": "2021-09-29T00:00:00Z"}
    path.write_text(json.dumps({"data": {"waves": [bulk], "frequencyData": [one]}}))
    return path


def swan(folder: Path, cartesian: bool = False, places: int = 1, stamp: bool = True) -> Path:
    path = folder / "point.spec"
    angles = np.arange(5.0, 360.0, 10.0)
    written = np.mod(270.0 - angles, 360.0) if cartesian else angles  # where the waves go to, anticlockwise from east
    lines = ["SWAN   1  Swan standard spectral file", "$ made for a test"]
    lines += ["TIME  time-dependent data", "     1  time coding option"] if stamp else []
    lines += ["LONLAT  locations", f"  {places}  number of locations", *["  171.0  -40.5"] * places]
    lines += ["AFREQ  absolute frequencies in Hz", f"  {F.size}  number", *(f"  {f:.4f}" for f in F)]
    lines += ["CDIR" if cartesian else "NDIR", f"  {angles.size}  number", *(f"  {a:.2f}" for a in written)]
    lines += [
        "QUANT",
        "     1  number of quantities",
        "VaDens  variance densities",
        "m2/Hz/degr  unit",
        "-0.99E+02  exception",
    ]
    for hour in (0, 6) if stamp else (0,):
        lines += [f"20240101.{hour:02d}0000"] if stamp else []
        for place in range(places):
            rows = np.round(S[:, None] * shape(angles) * (1.0 + place) / 1e-6)
            lines += ["FACTOR", "  1.0e-06", *(" ".join(f"{v:.0f}" for v in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


# --- what the numbers are ------------------------------------------------------------------------------------------


def test_ndbc_hours_are_read_right_and_chosen_by_name(tmp_path: Path) -> None:
    path = ndbc(tmp_path)
    for hour, (_, row) in enumerate(HOURS.items()):
        sea = read_spectrum(path, format="ndbc", time=f"2000-01-01T{hour:02d}")
        agrees(sea, np.array(FREQUENCIES), np.array(row.split(), float))
    refused(
        "sea.time", lambda: read_spectrum(path, format="ndbc"), "not given", "holds 2 spectra", "2000-01-01T00:00:00"
    )
    refused("sea.time", lambda: read_spectrum(path, format="ndbc", time="1999"), "none of the 2")
    packed = tmp_path / "44004w2000.txt.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert read_spectrum(packed, format="ndbc", time="2000-01-01T01") == sea


def test_ndbc_in_real_time_with_its_own_split(tmp_path: Path) -> None:
    pairs = " ".join(f"{s:.3f} ({f:.3f})" for f, s in zip(F, S, strict=True))
    path = tmp_path / "44004.data_spec"
    path.write_text("#YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) ... >\n" + f"2024 01 01 00 00 0.165 {pairs}\n" * 1)
    agrees(read_spectrum(path, format="ndbc"), F, S)
    swell = read_spectrum(path, format="ndbc", partition="swell")
    assert swell.omega[-1] == pytest.approx(2.0 * math.pi * 0.165)


@pytest.mark.parametrize(
    ("form", "make"), [("triaxys", triaxys), ("datawell", datawell), ("spotter", spotter), ("swan", swan)]
)
def test_other_formats_without_directions(tmp_path: Path, form: str, make: Callable[[Path], Path]) -> None:
    time = "2024-01-01T06" if form == "swan" else None
    sea = read_spectrum(make(tmp_path), 12.0, format=form, time=time)
    assert isinstance(sea, TabulatedSpectrum) and sea.heading == 12.0
    agrees(sea, F, S, 0.02)


DIRECTED = {
    "triaxys": lambda folder: triaxys(folder, True),
    "datawell": datawell,
    "spotter": spotter,
    "swan": lambda folder: swan(folder, stamp=False),
    "swan, cartesian": lambda folder: swan(folder, True, stamp=False),
}


@pytest.mark.parametrize("name", DIRECTED)
def test_directions_are_those_the_waves_come_from(tmp_path: Path, name: str) -> None:
    """From 250 deg they travel to 70: on a device whose x3 has the bearing 100, 30 deg to the left of it."""
    path, form = DIRECTED[name](tmp_path), name.split(",")[0]
    sea = read_spectrum(path, format=form, directional=True, axis=100.0)
    assert isinstance(sea, DirectionalSpectrum)
    agrees(sea, F, S, 0.02)
    assert sea.heading == pytest.approx(30.0, abs=0.5) and sea.spread == pytest.approx(SPREAD, abs=1.0)
    facing = read_spectrum(path, -15.0, format=form, directional=True)
    assert facing.heading == pytest.approx(-15.0, abs=0.5) and "250 deg" in facing.notes[-1]
    behind = read_spectrum(path, format=form, directional=True, axis=100.0, direction="to")
    assert abs(behind.heading) == pytest.approx(150.0, abs=0.5)


def test_ndbc_directions_from_the_files_beside(tmp_path: Path) -> None:
    path = ndbc(tmp_path)
    head = NDBC.split("\n")[0]
    first = 1.0 - 0.5 * math.radians(SPREAD) ** 2
    for letter, value in (("d", FROM), ("j", 100.0 * first)):  # archived first moments are a hundredfold
        row = " ".join(["999.0", *[f"{value:.2f}"] * (len(FREQUENCIES) - 1)])
        (tmp_path / f"44004{letter}2000.txt").write_text(f"{head}\n" + "".join(f"{k} {row}\n" for k in HOURS))
    sea = read_spectrum(path, format="ndbc", time="2000-01-01T01", directional=True, axis=100.0)
    assert sea.heading == pytest.approx(30.0, abs=0.5) and sea.spread == pytest.approx(SPREAD, abs=1.0)
    agrees(sea, np.array(FREQUENCIES), np.array(HOURS["2000 01 01 01"].split(), float))
    (tmp_path / "44004j2000.txt").unlink()
    refused(
        "sea.file", lambda: read_spectrum(path, format="ndbc", time="2000-01-01T01", directional=True), "44004j2000"
    )
    lone = ndbc(tmp_path, "mine.txt")
    refused("sea.file", lambda: read_spectrum(lone, format="ndbc", time="2000-01-01T01", directional=True), "name")


# --- what is chosen ------------------------------------------------------------------------------------------------


def test_swell_and_wind_sea_share_the_energy(tmp_path: Path) -> None:
    path = datawell(tmp_path)
    for directional in (False, True):
        parts = [
            read_spectrum(path, format="datawell", partition=part, split=0.163, directional=directional)
            for part in ("swell", "wind sea")
        ]
        whole = read_spectrum(path, format="datawell", directional=directional)
        assert parts[0].hs ** 2 + parts[1].hs ** 2 == pytest.approx(whole.hs**2, rel=1e-9)
        assert parts[0].tp == pytest.approx(10.0) and parts[1].tp == pytest.approx(4.0)
    refused("sea.split", lambda: read_spectrum(path, format="datawell", partition="swell"), "[Hz]")
    refused("sea.split", lambda: read_spectrum(path, format="datawell", partition="swell", split=2.0), "outside")
    refused("sea.split", lambda: read_spectrum(path, format="datawell", split=0.1), "partition")
    refused("sea.partition", lambda: read_spectrum(path, format="datawell", partition="tide"), "swell")


def test_places_of_a_model_are_chosen_by_number(tmp_path: Path) -> None:
    path = swan(tmp_path, places=2, stamp=False)
    one, two = (read_spectrum(path, format="swan", site=site) for site in (1, 2))
    assert two.hs == pytest.approx(math.sqrt(2.0) * one.hs, rel=1e-6)
    refused("sea.site", lambda: read_spectrum(path, format="swan"), "2 places")
    refused("sea.site", lambda: read_spectrum(path, format="swan", site=3), "2 places")
    refused("sea.time", lambda: read_spectrum(path, format="swan", site=1, time="2024"), "no time stamps")


def test_options_that_do_nothing_are_refused(tmp_path: Path) -> None:
    path = datawell(tmp_path)
    refused("sea.unit", lambda: read_spectrum(path, format="datawell", unit="Hz"), "no use")
    refused("sea.axis", lambda: read_spectrum(path, format="datawell", axis=10.0), "directional")
    refused("sea.time", lambda: read_spectrum(path, time="2024"), "no use")
    refused("sea.format", lambda: read_spectrum(path, format="era5"), "swan")
    refused("sea.direction", lambda: read_spectrum(path, format="datawell", direction="west"), "from")
    refused(
        "sea.directional", lambda: read_spectrum(triaxys(tmp_path), format="triaxys", directional=True), "no directions"
    )
    refused("sea.heading", lambda: read_spectrum(path, 5.0, format="datawell", directional=True, axis=10.0), "axis")


def test_without_the_library_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *args: object, **kwargs: object) -> object:
        if name.startswith("wavespectra"):
            raise ImportError(name)
        return real(name, *args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    refused("sea.format", lambda: read_spectrum(datawell(tmp_path), format="datawell"), "gyroctl[seas]", "'datawell'")


DAMAGED = {
    "another format": ("ndbc", "TRIAXYS BUOY DATA REPORT\n1 2 3\n"),
    "cut short": ("ndbc", NDBC.split("2000 01 01 01")[0][:-60]),
    "missing value": ("ndbc", NDBC.replace(".12", "999.00").replace("2000 01 01 01", "#")),
    "not a number": ("ndbc", NDBC.replace(".12", "nan").split("2000 01 01 01")[0]),
    "negative": ("ndbc", NDBC.replace(".12", "-.12").split("2000 01 01 01")[0]),
    "endless rows": (
        "triaxys",
        "TRIAXYS BUOY DATA REPORT\nDATE = 2018-01-31 21:00\nNUMBER OF FREQUENCIES = 999999999\n",
    ),
    "no spacing": ("triaxys", "TRIAXYS BUOY DATA REPORT\nNUMBER OF FREQUENCIES = 2\nFREQUENCY SPACING (Hz) = 0.000\n"),
    "endless places": ("swan", "SWAN   1\n$\nLONLAT\n 99999999999 places\n 1 2\n"),
    "binary": ("swan", "\x00\x01\x02"),
    "empty": ("datawell", ""),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_files_are_refused_by_name(tmp_path: Path, name: str) -> None:
    form, text = DAMAGED[name]
    path = tmp_path / "a.txt"
    path.write_text(text)
    refused("sea.file", lambda: read_spectrum(path, format=form), "a.txt")


# --- on the device -------------------------------------------------------------------------------------------------


def test_a_sea_of_the_ocean_is_scaled_to_the_device_from_a_table(tmp_path: Path, device: gy.Plant) -> None:
    datawell(tmp_path)
    table = {"file": "bay}2024-09-09T01h15Z.spt", "format": "datawell", "directional": True, "scale": 25.0}
    sea = build_sea(table, tmp_path)
    assert sea.hs == pytest.approx(by_hand(F, S)["hs"] / 25.0, rel=0.01)
    assert sea.wp == pytest.approx(2.0 * math.pi * 0.1 * 5.0, rel=1e-6)
    waves = prepare(device, sea, 300.0)
    assert 4.0 * math.sqrt(0.5 * float(np.sum(np.abs(waves.waves.amplitude) ** 2))) == pytest.approx(sea.hs, rel=1e-9)
    whole = build_sea({**table, "scale": 1.0}, tmp_path)
    with pytest.raises(InputError, match="scale"):
        prepare(device, whole, 300.0)
    assert not outside_band(device, sea)
    tiny = build_sea({**table, "scale": 300.0}, tmp_path)
    assert "of the wave energy lies above 12.6 rad/s" in outside_band(device, tiny)[0]


def test_moments_of_a_directional_sea_are_the_integral_over_all_directions(tmp_path: Path, device: gy.Plant) -> None:
    sea = read_spectrum(datawell(tmp_path), format="datawell", directional=True, axis=60.0, scale=25.0)
    made = prepare(device, sea, 600.0)
    want = np.zeros(2)
    step = math.radians(2.0)
    for k, heading in enumerate(sea.headings):
        density = np.interp(made.waves.omega, sea.omega, sea.density[:, k])
        he = np.abs(device.excitation(made.waves.omega, float(heading))) ** 2
        want += (he * density).sum(axis=1) * step * (made.waves.omega[1] - made.waves.omega[0])
    got = 0.5 * np.sum(np.abs(made.response) ** 2, axis=1)
    np.testing.assert_allclose(got, want, rtol=0.01)
