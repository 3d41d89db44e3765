"""Files of buoys and wave models that depart from the usual: read right, or refused by what is the matter."""

import json
import math
from pathlib import Path

import pytest

from gyroctl.errors import InputError
from gyroctl.waves import read_spectrum

pytest.importorskip("wavespectra")

REAL = Path(__file__).parent / "real_files"
F = (0.03, 0.05, 0.07, 0.08, 0.10, 0.15, 0.20, 0.30)
S = (0.0, 0.1, 1.2, 2.0, 1.1, 0.4, 0.2, 0.05)
M0 = sum(0.5 * (S[n] + S[n + 1]) * (F[n + 1] - F[n]) for n in range(7))


def ndbc(path: Path, years: str = "96", units: str = "", broken: str = "") -> Path:
    rows = [" ".join(map(str, S)), " ".join(map(str, S)).replace("2.0", broken or "2.0")]
    text = f"YY MM DD hh {' '.join(map(str, F))}\n{units}" + "".join(
        f"{years} 01 01 0{n} {r}\n" for n, r in enumerate(rows)
    )
    path.write_text(text)
    return path


@pytest.mark.parametrize(("years", "units"), [("96", ""), ("1999", "#yr mo dy hr Hz Hz\n"), ("96", "#yr mo dy hr\n")])
def test_years_of_two_digits_and_lines_of_units(tmp_path: Path, years: str, units: str) -> None:
    path = ndbc(tmp_path / "46042w.txt", years, units)
    full = years if len(years) == 4 else f"19{years}"
    sea = read_spectrum(path, format="ndbc", time=f"{full}-01-01T01")
    assert sea.hs == pytest.approx(4.0 * math.sqrt(M0), rel=1e-5) and sea.tp == pytest.approx(12.5, rel=1e-5)


@pytest.mark.parametrize("missing", ["999.00", "MM"])
def test_a_missing_density_is_refused_by_its_frequency_and_no_other_hour_is(tmp_path: Path, missing: str) -> None:
    path = ndbc(tmp_path / "46042w1996.txt", broken=missing)
    assert read_spectrum(path, format="ndbc", time="1996-01-01T00").hs == pytest.approx(4.0 * math.sqrt(M0), rel=1e-5)
    with pytest.raises(InputError, match=r"no sound density at 0\.08 Hz"):
        read_spectrum(path, format="ndbc", time="1996-01-01T01")


def test_stamps_within_the_hour_are_told_apart(tmp_path: Path) -> None:
    head, row = (REAL / "spotter.csv").read_text().splitlines()
    later = row.replace("1632834721", "1632836521").replace("4.54735872", "9.54735872")
    path = tmp_path / "two.csv"
    path.write_text("\n".join([head, row, later]) + "\n")
    with pytest.raises(InputError, match="fits 2 of the 2"):
        read_spectrum(path, format="spotter", time="2021-09-28T13")
    one, two = (read_spectrum(path, format="spotter", time=f"2021-09-28T13:{m}") for m in ("12", "42"))
    assert two.hs**2 - one.hs**2 == pytest.approx(16.0 * 5.0 * (0.07813 - 0.05859) / 2.0, rel=1e-4)


@pytest.mark.parametrize("heights", [["2018-02-14T01:27:19Z"], [], ["2018-02-14T01:27:19Z", "2018-02-14T04:27:19Z"]])
def test_spectra_of_a_spotter_have_their_own_stamps(tmp_path: Path, heights: list[str]) -> None:
    """Heights come at times of their own, and not always as many: an hour from the spectra in a real file."""
    spectrum = {"frequency": F, "varianceDensity": S, "timestamp": "2018-02-14T00:27:19Z"}
    spectrum |= {name: [0.0] * 8 for name in ("a1", "b1", "a2", "b2")} | {"direction": [200.0] * 8}
    spectrum |= {"directionalSpread": [30.0] * 8}
    bulk = [{"significantWaveHeight": 1.6, "peakPeriod": 10.2, "timestamp": stamp} for stamp in heights]
    path = tmp_path / "spotter.json"
    path.write_text(json.dumps({"data": {"waves": bulk, "frequencyData": [spectrum]}}))
    sea = read_spectrum(path, format="spotter", time="2018-02-14T00")
    assert sea.hs == pytest.approx(4.0 * math.sqrt(M0), rel=1e-6) and "00:27:19" in sea.notes[0]


def test_energy_densities_of_swan_are_over_rho_g(tmp_path: Path) -> None:
    text = (REAL / "swan.spec").read_text()
    swap = text.replace("VaDens  ", "EnDens  ").replace("variance densities in m2", "energy densities in J/m2")
    path = tmp_path / "energy.spec"
    path.write_text(swap.replace("m2/Hz/degr                              unit", "J/m2/Hz/degr        unit"))
    plain = read_spectrum(REAL / "swan.spec", format="swan")
    assert read_spectrum(path, format="swan").moment(0) * 1025.0 * 9.81 == pytest.approx(plain.moment(0), rel=1e-3)


def test_swan_over_frequency_alone_is_refused_with_what_to_do(tmp_path: Path) -> None:
    lines = [
        "SWAN   1",
        "LONLAT",
        " 1",
        " 1. 2.",
        "AFREQ",
        " 2",
        " 0.1",
        " 0.2",
        "QUANT",
        " 3",
        "VaDens",
        "m2/Hz",
        " -99",
    ]
    lines += [
        "NDIR average",
        "degr",
        " -999",
        "DSPRDEGR",
        "degr",
        " -9",
        "LOCATION 1",
        " 1.0 200. 30.",
        " 0.5 210. 30.",
    ]
    path = tmp_path / "one.spec"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=r"frequency alone.*SPEC2D"):
        read_spectrum(path, format="swan")


def test_decimal_commas_need_another_separator(tmp_path: Path) -> None:
    path = tmp_path / "komma.csv"
    path.write_text("f [Hz];S [m2/Hz]\n0,1;0,0\n0,5;0,02\n0,8;0,0\n")
    sea = read_spectrum(path)
    assert sea.hs == pytest.approx(4.0 * math.sqrt(0.02 * 0.7 / 2.0), rel=1e-9) and sea.tp == pytest.approx(2.0)
    for text in ("f [Hz] S [m2/Hz]\n0,1 0,0\n0,5 0,02\n", "f [Hz];S [m2/Hz]\n0.1;1.000,0\n0.5;0.02\n"):
        path.write_text(text)
        with pytest.raises(InputError) as caught:
            read_spectrum(path)
        assert caught.value.field == "sea.file"
