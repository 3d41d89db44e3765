"""Seas without a plant: spectra, tables and records from files, and how bad ones are refused."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyroctl.errors import InputError
from gyroctl.waves import (
    Bichromatic,
    ElevationRecord,
    Regular,
    SeaState,
    TabulatedSpectrum,
    random_phases,
    read_record,
    read_spectrum,
)


def area(sea: SeaState) -> float:
    """Integral of the density by another rule than the one in the package: trapezoids in log(omega)."""
    u = np.linspace(math.log(sea.wp / 8.0), math.log(sea.wp * 200.0), 40_001)
    omega = np.exp(u)
    return float(np.trapezoid(sea.spectrum(omega) * omega, u))


@pytest.mark.parametrize("gamma", [1.0, 5.0, 50.0])
def test_spectrum_has_the_area_of_its_height(gamma: float) -> None:
    sea = SeaState(0.283, 3.14, gamma)
    assert area(sea) == pytest.approx(sea.hs**2 / 16.0, rel=1e-7)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.01, 20.0), st.floats(0.2, 6.0), st.floats(1.0, 200.0))
def test_area_for_any_sea(hs: float, wp: float, gamma: float) -> None:
    assert area(SeaState(hs, wp, gamma)) == pytest.approx(hs**2 / 16.0, rel=1e-6)


def test_gamma_one_is_pierson_moskowitz() -> None:
    hs, wp = 0.4, 2.5
    omega = np.linspace(0.3, 12.0, 50)
    closed = 5.0 / 16.0 * hs**2 * wp**4 / omega**5 * np.exp(-1.25 * (wp / omega) ** 4)
    np.testing.assert_allclose(SeaState(hs, wp, 1.0).spectrum(omega), closed, rtol=1e-12)


def test_peak_enhancement_and_width() -> None:
    """At the peak the density is gamma times that without enhancement; one width off, gamma^exp(-1/2) times."""
    sharp, plain = SeaState(1.0, 2.0, 5.0), SeaState(1.0, 2.0, 1.0)
    at = np.array([2.0, 2.0 * 0.93, 2.0 * 1.09, 0.8])
    ratio = sharp.spectrum(at) / plain.spectrum(at)
    far = ratio[3]
    np.testing.assert_allclose(ratio[:3] / far, [5.0, 5.0 ** math.exp(-0.5), 5.0 ** math.exp(-0.5)], rtol=1e-12)
    assert sharp.wp == 2.0 and np.argmax(sharp.spectrum(np.linspace(1, 3, 2001))) == 1000


def test_density_is_zero_and_silent_at_and_below_zero_frequency() -> None:
    with np.errstate(all="raise", under="ignore"):
        values = SeaState().spectrum(np.array([-1.0, 0.0, 1e-200, 1e-3]))
    assert np.array_equal(values, np.zeros(4))


def test_equivalent_heights_keep_the_energy() -> None:
    """Hs^2/16 is the variance: that of a wave of amplitude a is a^2/2."""
    assert Regular(0.2, 3.0).hs ** 2 / 16.0 == pytest.approx(0.1**2 / 2.0)
    pair = Bichromatic((0.2, 0.3), (3.0, 3.3))
    assert pair.hs**2 / 16.0 == pytest.approx((0.1**2 + 0.15**2) / 2.0)
    assert pair.wp == 3.3


def test_whole_numbers_and_floats_are_the_same_sea() -> None:
    assert SeaState(1, 3, 5) == SeaState(1.0, 3.0, 5.0)
    assert SeaState(heading=-0.0) == SeaState(heading=0.0)


@pytest.mark.parametrize(
    ("text", "unit"), [("omega,S\n1.0,0.0\n2.0,0.01\n4.0,0.0\n", None), ("# Hz? no\n1 0\n\n2\t.01\n4;0\n", "rad/s")]
)
def test_spectrum_from_a_file(tmp_path: Path, text: str, unit: str | None) -> None:
    path = tmp_path / "sea.csv"
    path.write_text(text, encoding="utf-8-sig")
    sea = read_spectrum(path, heading=20.0, unit=unit)
    assert sea.hs == pytest.approx(4.0 * math.sqrt(0.5 * 3.0 * 0.01))
    assert sea.wp == 2.0 and sea.heading == 20.0
    np.testing.assert_allclose(sea.spectrum([0.5, 1.5, 3.0, 5.0]), [0.0, 0.005, 0.005, 0.0])


def test_tables_are_equal_by_content_and_cannot_be_written() -> None:
    one = TabulatedSpectrum(np.array([1.0, 2.0]), np.array([0.0, 1.0]))
    same = TabulatedSpectrum(np.array([1.0, 2.0]), np.array([0.0, 1.0]))
    other = TabulatedSpectrum(np.array([1.0, 2.0]), np.array([0.0, 1.1]))
    assert one == same and hash(one) == hash(same) and one != other
    assert pickle.loads(pickle.dumps(one)) == one
    with pytest.raises(ValueError, match="read-only"):
        one.density[0] = 3.0


def test_record_gives_height_and_peak(tmp_path: Path) -> None:
    time = 0.1 * np.arange(6000, dtype=np.float64)
    eta = 0.07 * np.cos(2.9 * time + 0.3) + 0.02 * np.cos(4.1 * time) + 0.5
    path = tmp_path / "probe.csv"
    np.savetxt(path, np.column_stack((time + 77.0, eta)), delimiter=",", header="time,eta", comments="")
    record = read_record(path)
    assert record.hs == pytest.approx(4.0 * math.sqrt((0.07**2 + 0.02**2) / 2.0), rel=1e-3)
    assert record.wp == pytest.approx(2.9, abs=0.06)
    assert record.duration == pytest.approx(599.9) and record.step == pytest.approx(0.1)
    assert abs(record.surface.mean()) < 1e-15


def test_uneven_times_are_resampled_and_rounded_stamps_are_not() -> None:
    rng = np.random.default_rng(3)
    even = 0.05 * np.arange(4000, dtype=np.float64)
    jitter = even + np.concatenate(([0.0], rng.uniform(-0.01, 0.01, 3998), [0.0]))
    wave = np.cos(2.0 * even)
    resampled = ElevationRecord(jitter, np.cos(2.0 * jitter)).surface
    assert np.abs(resampled - (wave - wave.mean())).max() < 2e-3
    rounded = ElevationRecord(np.round(even / 3.0, 4), wave).surface
    assert np.array_equal(rounded, wave - wave.mean())
    assert not np.array_equal(resampled, np.cos(2.0 * jitter) - np.cos(2.0 * jitter).mean())


def test_phases_are_uniform_reproducible_and_nested() -> None:
    from scipy.stats import kstest  # here: only this test needs it

    # One seed in a hundred fails a test at 1 %, so the p-values of many seeds are tested: they are uniform themselves.
    chances = [kstest(random_phases(seed, 4000) / (2.0 * np.pi), "uniform").pvalue for seed in range(300)]
    assert kstest(chances, "uniform").pvalue > 0.001 and min(chances) > 1e-5
    phases = random_phases(2017, 100_000)
    assert phases.min() >= 0.0 and phases.max() < 2.0 * np.pi
    assert abs(np.corrcoef(phases[1:], phases[:-1])[0, 1]) < 0.01
    assert abs(np.exp(1j * (phases - random_phases(2018, 100_000))).mean()) < 0.01
    assert np.array_equal(phases[:4000], random_phases(2017, 4000))


def test_phases_do_not_share_the_stream_of_the_plain_seed() -> None:
    plain = np.random.default_rng(5).random(100) * 2.0 * np.pi
    assert not np.any(np.isclose(random_phases(5, 100), plain))


N = np.arange(20.0)
BAD_SEAS: list[tuple[str, Callable[[], object]]] = [
    ("sea.hs", lambda: SeaState(hs=0.0)),
    ("sea.hs", lambda: SeaState(hs=-1.0)),
    ("sea.hs", lambda: SeaState(hs=math.nan)),
    ("sea.hs", lambda: SeaState(hs="high")),  # type: ignore[arg-type]
    ("sea.hs", lambda: SeaState(hs=True)),
    ("sea.wp", lambda: SeaState(wp=0.0)),
    ("sea.wp", lambda: SeaState(wp=math.inf)),
    ("sea.gamma", lambda: SeaState(gamma=0.99)),
    ("sea.gamma", lambda: SeaState(gamma=math.nan)),
    ("sea.heading", lambda: SeaState(heading=181.0)),
    ("sea.heading", lambda: SeaState(heading=None)),  # type: ignore[arg-type]
    ("sea.height", lambda: Regular(0.0, 3.0)),
    ("sea.wp", lambda: Regular(0.1, -3.0)),
    ("sea.heights", lambda: Bichromatic((0.1, -0.1), (2.0, 3.0))),
    ("sea.heights", lambda: Bichromatic(0.1, (2.0, 3.0))),  # type: ignore[arg-type]
    ("sea.frequencies", lambda: Bichromatic((0.1, 0.1), (2.0, 2.0))),
    ("sea.frequencies", lambda: Bichromatic((0.1, 0.1), "23")),  # type: ignore[arg-type]
    ("sea.omega", lambda: TabulatedSpectrum(np.array([1.0, 3.0, 2.0]), np.ones(3))),
    ("sea.omega", lambda: TabulatedSpectrum(np.array([-1.0, 3.0]), np.ones(2))),
    ("sea.omega", lambda: TabulatedSpectrum(np.ones((2, 2)), np.ones(2))),
    ("sea.omega", lambda: TabulatedSpectrum("many", np.ones(2))),  # type: ignore[arg-type]
    ("sea.density", lambda: TabulatedSpectrum(np.array([1.0, 2.0]), np.ones(3))),
    ("sea.density", lambda: TabulatedSpectrum(np.array([1.0, 2.0]), np.array([1.0, -1.0]))),
    ("sea.density", lambda: TabulatedSpectrum(np.array([1.0, 2.0]), np.zeros(2))),
    ("sea.density", lambda: TabulatedSpectrum(np.array([1.0, 2.0]), np.array([1.0, math.nan]))),
    ("sea.time", lambda: ElevationRecord(N[::-1], np.cos(N))),
    ("sea.time", lambda: ElevationRecord(np.where(N > 9, N + 5.0, N), np.cos(N))),
    ("sea.eta", lambda: ElevationRecord(N, np.ones(20))),
    ("sea.eta", lambda: ElevationRecord(N[:4], np.cos(N[:4]))),
    ("sea.eta", lambda: ElevationRecord(N, np.cos(N[:-1]))),
    ("run.seeds", lambda: random_phases(-1, 3)),
    ("run.seeds", lambda: random_phases(1.0, 3)),  # type: ignore[arg-type]
    ("run.seeds", lambda: random_phases(True, 3)),
]


def assert_refused(field: str, make: Callable[[], object]) -> None:
    """Check that the error names the field, the value, the problem and the mend."""
    with pytest.raises(InputError) as caught:
        make()
    error = caught.value
    assert error.field == field
    assert error.problem and error.mend.startswith("Give")
    assert field in str(error) and repr(error.value) in str(error) and error.mend in str(error)


@pytest.mark.parametrize(("field", "make"), BAD_SEAS)
def test_bad_sea_is_refused(field: str, make: Callable[[], object]) -> None:
    assert_refused(field, make)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "0 lines"),
        (b"omega,S\n1,2\n", "1 lines"),
        (b"1,2\n2,three\n", "line 2"),
        (b"omega,S\nunits,units\n1,2\n", "line 2"),
        (b"1,2\n2,3,4\n", "line 2"),
        (b"1,2,3\n2,3,4\n", "3 columns"),
        (b"1,2\n2,nan\n", "line 2"),
        (b"\xff\xfe\x00\x01", "UTF-16"),
    ],
)
def test_bad_file_is_refused(tmp_path: Path, content: bytes, problem: str) -> None:
    path = tmp_path / "sea.csv"
    path.write_bytes(content)
    assert_refused("sea.file", lambda: read_spectrum(path, unit="rad/s"))
    with pytest.raises(InputError, match=problem):
        read_record(path)


def test_missing_file_and_folder_are_refused(tmp_path: Path) -> None:
    assert_refused("sea.file", lambda: read_record(tmp_path / "none.csv"))
    assert_refused("sea.file", lambda: read_spectrum(tmp_path))
