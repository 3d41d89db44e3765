"""Swell and wind sea told apart by the hills of a directional spectrum, by watershed."""

import math
from pathlib import Path

import numpy as np
import pytest

from gyroctl.comparison.sea_table import build_sea
from gyroctl.errors import InputError
from gyroctl.waves import DirectionalSpectrum, TabulatedSpectrum, read_spectrum
from gyroctl.waves.watershed import part_of_hills

pytest.importorskip("wavespectra")

REAL = Path(__file__).parent / "real_files"
F = np.arange(0.04, 0.5, 0.01)
ANGLES = np.arange(5.0, 360.0, 10.0)
# A swell of 12.5 s from west-south-west, Hs 1.5 m; a wind sea of 4 s from north by east, Hs 1.2 m.
SWELL, WIND = (0.08, 0.01, 245.0, 12.0, 1.5), (0.25, 0.03, 5.0, 30.0, 1.2)


def hill(peak: float, width: float, come: float, spread: float, hs: float) -> np.ndarray:
    """A hill over frequency and direction of a known height. [m^2/Hz/deg]"""
    off = (ANGLES - come + 180.0) % 360.0 - 180.0
    shape = np.exp(-0.5 * ((F[:, None] - peak) / width) ** 2 - 0.5 * (off[None, :] / spread) ** 2)
    area = float(np.trapezoid(shape.sum(axis=1), F)) * 10.0
    return shape * (hs**2 / 16.0 / area)


def swan(folder: Path, density: np.ndarray) -> Path:
    lines = [
        "SWAN   1",
        "$ made for a test",
        "LONLAT",
        " 1 places",
        " 1. 2.",
        "AFREQ",
        f" {F.size}",
        *map(str, F.round(4)),
    ]
    lines += [
        "NDIR",
        f" {ANGLES.size}",
        *map(str, ANGLES),
        "QUANT",
        " 1",
        "VaDens",
        "m2/Hz/degr",
        "-99.",
        "FACTOR",
        "1e-8",
    ]
    lines += [" ".join(str(round(v / 1e-8)) for v in row) for row in density]
    path = folder / "two.spec"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("directional", [False, True])
def test_two_hills_are_parted_at_the_valley(tmp_path: Path, directional: bool) -> None:
    path = swan(tmp_path, hill(*SWELL) + hill(*WIND))
    kind = DirectionalSpectrum if directional else TabulatedSpectrum
    whole = read_spectrum(path, format="swan", directional=directional)
    parts = {
        name: read_spectrum(path, format="swan", directional=directional, partition=name, split_by="watershed")
        for name in ("swell", "wind sea")
    }
    assert sum(part.hs**2 for part in parts.values()) == pytest.approx(whole.hs**2, rel=1e-6)
    for name, (peak, _, _, _, hs) in (("swell", SWELL), ("wind sea", WIND)):
        assert isinstance(parts[name], kind)
        assert parts[name].tp == pytest.approx(1.0 / peak, rel=1e-6)
        assert parts[name].hs == pytest.approx(hs, rel=0.01)
        assert f"{name} alone, by watershed and steepness" in parts[name].notes


def test_hills_of_one_frequency_are_parted_by_their_direction() -> None:
    """What a frequency between the two could never do: a steep sea across a long, low one that has its frequencies."""
    low = hill(0.2, 0.02, 100.0, 15.0, 0.3)
    steep = hill(0.22, 0.03, 300.0, 20.0, 2.0)
    kept = part_of_hills(F, ANGLES, low + steep, "swell")
    mean = np.degrees(np.angle(np.sum(kept * np.exp(1j * np.radians(ANGLES))))) % 360.0
    assert mean == pytest.approx(100.0, abs=3.0)
    np.testing.assert_array_equal(kept + part_of_hills(F, ANGLES, low + steep, "wind sea"), low + steep)


def test_hills_do_not_depend_on_where_the_turn_begins() -> None:
    whole = hill(*SWELL) + hill(*WIND)
    usual = part_of_hills(F, ANGLES, whole, "wind sea")
    turned = part_of_hills(F, np.roll(ANGLES, 7) + 360.0 * (np.arange(36) >= 7), np.roll(whole, 7, axis=1), "wind sea")
    np.testing.assert_array_equal(np.roll(turned, -7, axis=1), usual)


def test_a_real_sea_has_the_energy_of_its_parts() -> None:
    parts = [
        read_spectrum(REAL / "spotter.csv", format="spotter", partition=name, split_by="watershed")
        for name in ("swell", "wind sea")
    ]
    whole = read_spectrum(REAL / "spotter.csv", format="spotter")
    assert math.hypot(*(part.hs for part in parts)) == pytest.approx(whole.hs, rel=1e-9)
    assert parts[0].tp == pytest.approx(14.63, abs=0.01) and parts[1].tp == pytest.approx(5.39, abs=0.01)


def refused(field: str, word: str, name: str = "swan.spec", **options: object) -> None:
    with pytest.raises(InputError) as caught:
        read_spectrum(REAL / name, **options)  # type: ignore[arg-type]
    assert caught.value.field == field and word in str(caught.value)


def test_parts_that_are_not_there_are_refused() -> None:
    watershed = {"split_by": "watershed"}
    refused("sea.partition", "Choose swell", format="swan", partition="wind sea", **watershed)
    refused("sea.split_by", "partition", format="swan", **watershed)
    refused("sea.split_by", "no split", format="swan", partition="swell", split=0.1, **watershed)
    refused("sea.split_by", "Choose one of frequency, watershed", format="swan", partition="swell", split_by="wind")
    flat = "triaxys.NONDIRSPEC"
    refused("sea.split_by", "holds none", flat, format="triaxys", partition="swell", **watershed)


def test_watershed_in_a_table() -> None:
    table = {
        "file": "spotter.csv",
        "format": "spotter",
        "partition": "wind sea",
        "split_by": "watershed",
        "scale": 20.0,
    }
    assert build_sea(table, REAL).hs == pytest.approx(0.895 / 20.0, rel=1e-3)
