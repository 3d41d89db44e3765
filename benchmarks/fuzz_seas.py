"""Sound files of waves, of buoys and wave models, and what must hold of a sea that was read from one."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.waves import DirectionalSpectrum, TabulatedSpectrum, read_record, read_spectrum
from gyroctl.writing import write_text

F = np.arange(0.05, 0.5, 0.05)
DENSITY = 3.0 * np.exp(-0.5 * ((F - 0.2) / 0.05) ** 2)


def records(folder: Path) -> list[Path]:
    """Records with what they may have: stamps, units, gaps, decimal commas."""
    time = np.arange(0.0, 40.0, 0.25)
    level = [0.1 * math.sin(3.14 * t) + 0.02 * math.sin(2.0 * t) for t in time]
    stamps = [f"2024-05-01T12:00:{t:06.3f}" for t in time]
    texts = (
        "\n".join(f"{s}\t{1000.0 * e:.2f}" for s, e in zip(stamps, level, strict=True)),
        "\n".join(f"{t:.2f};{e:.4f}".replace(".", ",") for t, e in zip(time, level, strict=True)),
        "\n".join(
            f"{t:.2f},{'' if 60 < i < 63 else f'{e:.4f}'}" for i, (t, e) in enumerate(zip(time, level, strict=True))
        ),
    )
    heads = ("stamp\teta [mm]\n", "t [s];eta [m]\n", "t,eta\n")
    return [
        write_text(folder / str(n) / "waves.csv", head + text + "\n")
        for n, (head, text) in enumerate(zip(heads, texts, strict=True), 1)
    ]


def record(path: Path) -> object:
    """Read with every rule at once."""
    found = read_record(path, gaps="linear", longest=2.0, detrend="high-pass")
    assert 0.0 < found.hs < 100.0 and 0.0 < found.wp < 1e5 and found.duration > 0.0
    assert np.all(np.isfinite(found.surface)) and all(note.isprintable() for note in found.notes)
    return found


def spectra(folder: Path) -> list[Path]:
    """One file of each format, called by its name."""
    pairs = list(zip(F.tolist(), DENSITY.tolist(), strict=True))
    ndbc = "YYYY MM DD hh mm " + " ".join(f"{f:.3f}" for f in F) + "\n"
    ndbc += "".join(f"2000 01 01 0{k} 00 " + " ".join(f"{s:.2f}" for s in DENSITY) + "\n" for k in range(3))
    datawell = "10\n85.0\n4.5\n3.0\n25.0\n19.0\n7\n-0.1\n0.3\n0.2\n213.8\n68.2\n"
    datawell += "".join(f"{f:.3f},{s / 3.0:.4E},220.5,35.0,0.1,2.3\n" for f, s in pairs)
    triaxys = (
        "TRIAXYS BUOY DATA REPORT\nTYPE    =  DIRECTIONAL SPECTRUM\nDATE    = 2018-01-31 21:00(UTC)\n"
        f"NUMBER OF FREQUENCIES = {F.size}\nINITIAL FREQUENCY (Hz) = 0.05\nFREQUENCY SPACING (Hz) = 0.05\n"
        "DIRECTION SPACING (DEG) = 45.0\nROWS = FREQUENCIES\n"
    )
    triaxys += "".join(" ".join([f"{s / 360.0:.4E}"] * 9) + "\n" for _, s in pairs)
    swan = [
        "SWAN   1",
        "$ made",
        "TIME",
        "  1 code",
        "LONLAT",
        "  1 places",
        "  171.0 -40.5",
        "AFREQ",
        f"  {F.size} numbers",
    ]
    swan += [*(f"  {f:.4f}" for f in F), "NDIR", "  4 numbers", *(f"  {d}" for d in (0, 90, 180, 270)), "QUANT", "  1"]
    swan += ["VaDens", "m2/Hz/degr", "-0.99E+02", "20240101.000000", "FACTOR", "1.0e-05"]
    swan += [" ".join([f"{s / 360.0 / 1e-5:.0f}"] * 4) for _, s in pairs]
    same = {name: [30.0] * F.size for name in ("direction", "directionalSpread", "a1", "b1", "a2", "b2")}
    spot = {"frequency": F.tolist(), "varianceDensity": DENSITY.tolist(), "timestamp": "2021-09-29T00:00:00Z", **same}
    waves = [{"significantWaveHeight": 1.0, "timestamp": "2021-09-29T00:00:00Z"}]
    texts = {
        "1/ndbc.txt": ndbc,
        "2/datawell.spt": datawell,
        "3/triaxys.spec": triaxys,
        "4/swan.spec": "\n".join(swan) + "\n",
        "5/spotter.json": json.dumps({"data": {"waves": waves, "frequencyData": [spot]}}),
        "6/csv.csv": "f [Hz];S [m2/Hz]\n" + "".join(f"{f:.3f};{s:.5f}\n" for f, s in pairs).replace(".", ","),
    }
    return [write_text(folder / name, text) for name, text in texts.items()]


def spectral(path: Path) -> object:
    """Read as what its name says, without and with directions."""
    form = path.stem
    found = None
    for directional in (False, True) if form in ("datawell", "triaxys", "swan", "spotter") else (False,):
        time = "2000-01-01T01" if form == "ndbc" else None
        try:
            found = read_spectrum(path, format=form, time=time, directional=directional, scale=10.0)
        except InputError as error:
            found = error
            continue
        sound(found)
    if isinstance(found, InputError):
        raise found
    return found


def sound(sea: TabulatedSpectrum | DirectionalSpectrum) -> None:
    assert 0.0 < sea.hs <= 100.0 and 0.0 < sea.wp <= 1e4 and abs(sea.heading) <= 180.0
    assert sea.te > 0.0 and sea.moment(0) > 0.0 and not math.isnan(sea.moment(4))
    assert all(note.isprintable() for note in sea.notes)
    assert np.all(np.isfinite(sea.spectrum(np.linspace(0.0, 12.0, 50))))
    if isinstance(sea, DirectionalSpectrum):
        assert np.all(np.abs(sea.headings_at(np.linspace(0.01, 12.0, 400))) <= 180.0)
