"""From a seed to moments: spectra of the moments, same bits, hashes, blend, records, and refused runs."""

from __future__ import annotations

import dataclasses
import math
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.waves import (
    Bichromatic,
    ElevationRecord,
    Regular,
    Sea,
    SeaState,
    TabulatedSpectrum,
    WaveRealisation,
    prepare,
    realise,
    regular_amplitude,
)


@dataclass(frozen=True)
class Table:
    """Stand-in excitation with a known formula and a band."""

    sha256: str = "0" * 64
    omega: NDArray[np.float64] = field(default_factory=lambda: np.linspace(0.2, 12.0, 60))

    def __call__(self, omega: ArrayLike, heading: float = 0.0) -> NDArray[np.complex128]:
        """Moments about x1 and x3 per metre of amplitude."""
        w = np.asarray(omega, dtype=np.float64)
        turn = math.cos(math.radians(heading))
        he = np.stack((900.0 * turn * np.exp(1.5j - 0.05 * w), 2700.0 * np.exp(0.03j * w) / (1.0 + (w / 5.0) ** 2)))
        return np.where((w >= 0.2) & (w <= 12.0), he, 0.0)


@dataclass(frozen=True)
class Device:
    """Stand-in plant."""

    excitation: Table = Table()


PLANT = Device()
SEA = SeaState(0.283, 3.14, 5.0)
DW = 2.0 * math.pi / 2000.0
OMEGA = DW * np.arange(1, 4001, dtype=np.float64)


def fourier(signal: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Complex amplitudes of the 4000 harmonics of one full period, and proof that there is nothing else."""
    whole: NDArray[np.complex128] = np.fft.rfft(signal[..., :-1]) / (0.5 * (signal.shape[-1] - 1))
    rest = np.concatenate((whole[..., :1], whole[..., 4001:]), axis=-1)
    assert np.abs(rest).max() < 1e-10 * np.abs(whole).max()
    return whole[..., 1:4001]


@pytest.fixture(scope="module")
def waves() -> WaveRealisation:
    return realise(PLANT, SEA, seed=7)


def test_grid_of_the_default_run(waves: WaveRealisation) -> None:
    assert waves.moments.shape == (2, 40001) and waves.elevation.shape == waves.time.shape == (40001,)
    assert waves.moments.dtype == np.float64 and waves.moments.flags.c_contiguous
    assert waves.time[0] == 0.0 and waves.time[-1] == 2000.0 == waves.duration and waves.dt == 0.05
    np.testing.assert_allclose(waves.moments[:, -1], waves.moments[:, 0], atol=1e-9)


@pytest.mark.parametrize("gamma", [1.0, 5.0, 50.0])
def test_spectra_of_the_moments(gamma: float) -> None:
    """Line by line |M_j|^2 / (2 dw) = |He_j|^2 S, but for one factor of the tail beyond the last harmonic."""
    sea = SeaState(0.283, 3.14, gamma)
    run = realise(PLANT, sea, seed=11)
    kept = float(sea.spectrum(OMEGA).sum() * DW) / (sea.hs**2 / 16.0)
    assert 0.994 < kept <= 1.0001
    measured = np.abs(fourier(run.moments)) ** 2 / (2.0 * DW)
    expected = np.abs(PLANT.excitation(OMEGA, 0.0)) ** 2 * sea.spectrum(OMEGA) / kept
    np.testing.assert_allclose(measured, expected, rtol=1e-6, atol=1e-10 * expected.max())


def test_elevation_has_the_variance_and_the_spectrum_of_the_sea(waves: WaveRealisation) -> None:
    assert waves.elevation[:-1].var() == pytest.approx(SEA.hs**2 / 16.0, rel=1e-12)
    assert abs(waves.elevation[:-1].mean()) < 1e-15


def test_moments_follow_the_elevation_through_the_complex_excitation(waves: WaveRealisation) -> None:
    """Amplitude and phase with time sign exp(+i w t), and the drawn phases are those of the elevation."""
    eta = fourier(waves.elevation)
    big = np.abs(eta) > 1e-6 * np.abs(eta).max()
    transfer = fourier(waves.moments)[:, big] / eta[big]
    np.testing.assert_allclose(transfer, PLANT.excitation(OMEGA[big], 0.0), rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(np.angle(eta[big] * np.exp(-1j * waves.phases[big])), 0.0, atol=1e-7)


def test_fft_equals_the_plain_sum_of_cosines(waves: WaveRealisation) -> None:
    kept = SEA.spectrum(OMEGA).sum() * DW / (SEA.hs**2 / 16.0)
    amplitude = np.sqrt(2.0 * SEA.spectrum(OMEGA) * DW / kept)
    at = np.array([0, 1, 777, 20000, 39999])
    angle = OMEGA * waves.time[at][:, None] + waves.phases
    np.testing.assert_allclose(waves.elevation[at], np.cos(angle) @ amplitude, atol=1e-12)
    he = PLANT.excitation(OMEGA, 0.0)[1]
    plain = np.cos(angle + np.angle(he)) @ (amplitude * np.abs(he))
    np.testing.assert_allclose(waves.moments[1, at], plain, atol=1e-9)


def test_heading_changes_moments_but_not_the_elevation(waves: WaveRealisation) -> None:
    oblique = realise(PLANT, dataclasses.replace(SEA, heading=60.0), seed=7)
    assert np.array_equal(oblique.elevation, waves.elevation)
    np.testing.assert_allclose(oblique.moments[0], 0.5 * waves.moments[0], atol=1e-10)
    np.testing.assert_allclose(oblique.moments[1], waves.moments[1], atol=1e-10)


def test_shorter_run_is_a_prefix_with_the_same_bits(waves: WaveRealisation) -> None:
    short = realise(PLANT, SEA, seed=7, duration=600.0)
    assert short.moments.shape == (2, 12001)
    assert np.array_equal(short.moments, waves.moments[:, :12001])
    assert np.array_equal(short.elevation, waves.elevation[:12001])


@pytest.mark.parametrize(("dt", "stride"), [(0.1, 2), (0.025, None), (1.0 / 30.0, None)])
def test_same_sea_at_any_step(waves: WaveRealisation, dt: float, stride: int | None) -> None:
    other = realise(PLANT, SEA, seed=7, duration=100.0, dt=dt)
    if stride:
        np.testing.assert_allclose(other.moments, waves.moments[:, :2001:stride], atol=1e-8)
    common = np.isclose(other.time[:, None], waves.time[None, :200], atol=1e-9)
    mine, theirs = np.nonzero(common)
    assert mine.size >= 50
    np.testing.assert_allclose(other.moments[:, mine], waves.moments[:, theirs], atol=1e-8)


def test_beyond_the_base_period_the_sea_does_not_repeat() -> None:
    long = realise(PLANT, SEA, seed=7, duration=2500.0, dt=0.2)
    assert long.phases.size == 8000 and long.moments.shape == (2, 12501)
    assert np.abs(long.moments[:, 10000:] - long.moments[:, :2501]).max() > 50.0
    assert realise(PLANT, SEA, 7, 4000.0, 0.2).elevation[:-1].var() == pytest.approx(SEA.hs**2 / 16.0, rel=1e-12)


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(0, 2**63 - 1), min_size=1, max_size=5), st.sampled_from([20.0, 2000.0]))
def test_batch_has_the_bits_of_single_runs(seeds: list[int], duration: float) -> None:
    batch = prepare(PLANT, SEA, duration).moments_batch(seeds)
    for row, seed in zip(batch, seeds, strict=True):
        assert row.tobytes() == realise(PLANT, SEA, seed, duration).moments.tobytes()


def test_bits_do_not_depend_on_order_workers_or_reused_memory() -> None:
    seeds = list(range(12))
    synthesis = prepare(PLANT, SEA)
    batch = synthesis.moments_batch(seeds)
    used = np.full_like(batch, np.nan)
    assert synthesis.moments_batch(seeds[::-1], out=used) is used
    assert np.array_equal(used[::-1], batch)
    with ThreadPoolExecutor(3) as pool:
        threaded = list(pool.map(synthesis.moments, seeds))
    assert np.array_equal(np.array(threaded), batch)
    assert not np.array_equal(batch[0], batch[1])


@pytest.mark.parametrize("blend", [0.0, 33.33, 100.0])
def test_blended_batch_has_the_bits_of_a_blended_run(blend: float) -> None:
    batch = prepare(PLANT, SEA, 200.0).moments_batch([3, 4], blend)
    assert np.array_equal(batch[1], realise(PLANT, SEA, 4, 200.0).blended(blend).moments)


PROCESS = """
import sys; sys.path.insert(0, {tests!r})
from test_waves import PLANT, SEA, realise
import hashlib
run = realise(PLANT, SEA, 7)
print(run.sha256, hashlib.sha256(run.moments.tobytes()).hexdigest(), run.blended().sha256)
"""


def test_hash_and_bits_are_the_same_in_another_process(waves: WaveRealisation) -> None:
    import hashlib

    code = PROCESS.format(tests=str(Path(__file__).parent))
    root = str(Path(__file__).parents[1])
    environment = os.environ | {"PYTHONPATH": root, "PYTHONHASHSEED": "77", "OMP_NUM_THREADS": "1"}
    answer = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    bits = hashlib.sha256(waves.moments.tobytes()).hexdigest()
    assert answer.stdout.split() == [waves.sha256, bits, waves.blended().sha256]


def test_hash_differs_when_anything_differs(waves: WaveRealisation) -> None:
    others = [
        realise(PLANT, SEA, 8),
        realise(PLANT, dataclasses.replace(SEA, hs=math.nextafter(SEA.hs, 1.0)), 7),
        realise(PLANT, dataclasses.replace(SEA, wp=3.1400001), 7),
        realise(PLANT, dataclasses.replace(SEA, gamma=5.0001), 7),
        realise(PLANT, dataclasses.replace(SEA, heading=1e-9), 7),
        realise(Device(Table(sha256="1" * 64)), SEA, 7),
        realise(PLANT, SEA, 7, duration=1999.95),
        realise(PLANT, SEA, 7, dt=0.1),
        waves.blended(100.0),
        waves.blended(99.0),
        realise(PLANT, Regular(0.2, 3.14), 7),
        realise(PLANT, Regular(0.2, 3.14, 1.0), 7),
        realise(PLANT, Bichromatic((0.1, 0.2), (3.0, 3.14)), 7),
        realise(PLANT, Bichromatic((0.2, 0.1), (3.0, 3.14)), 7),
        realise(PLANT, TabulatedSpectrum(OMEGA, SEA.spectrum(OMEGA)), 7),
        realise(PLANT, ElevationRecord(waves.time, waves.elevation), 7, 1900.0),
        realise(PLANT, ElevationRecord(waves.time, 1.001 * waves.elevation), 7, 1900.0),
    ]
    hashes = {waves.sha256, *(other.sha256 for other in others)}
    assert len(hashes) == len(others) + 1
    assert all(len(text) == 64 and int(text, 16) >= 0 for text in hashes)


def test_hash_is_the_same_by_every_way_to_it(waves: WaveRealisation) -> None:
    synthesis = prepare(PLANT, SEA)
    assert synthesis.sha256(7) == waves.sha256 == realise(PLANT, SEA, 7, 2000, 0.05).sha256
    assert synthesis.sha256(7, blend=100.0) == waves.blended().sha256
    assert waves.blended(0.0).sha256 == waves.sha256
    copy = pickle.loads(pickle.dumps(waves))
    assert copy.sha256 == waves.sha256 and np.array_equal(copy.moments, waves.moments)


def test_blend_leads_from_the_regular_wave_to_the_sea(waves: WaveRealisation) -> None:
    blended = waves.blended(100.0)
    he = PLANT.excitation(np.array([SEA.wp]), 0.0)[:, 0]
    amplitude = SEA.hs / (2.0 * math.sqrt(2.0))
    np.testing.assert_allclose(regular_amplitude(PLANT, SEA), he * amplitude)
    regular = amplitude * np.abs(he)[:, None] * np.cos(SEA.wp * waves.time + np.angle(he)[:, None])
    weight = np.where(waves.time < 100.0, 0.5 - 0.5 * np.cos(0.01 * np.pi * waves.time), 1.0)
    np.testing.assert_allclose(blended.moments, weight * waves.moments + (1 - weight) * regular, atol=1e-9)
    crest = amplitude * np.cos(SEA.wp * waves.time)
    np.testing.assert_allclose(blended.elevation, weight * waves.elevation + (1 - weight) * crest, atol=1e-12)
    assert np.array_equal(blended.moments[:, 2000:], waves.moments[:, 2000:])
    assert blended.blend == 100.0 and waves.blend == 0.0
    assert np.array_equal(waves.moments, realise(PLANT, SEA, 7).moments)


def test_regular_moments_take_the_heading_of_the_sea() -> None:
    ahead, oblique = regular_amplitude(PLANT, SEA), regular_amplitude(PLANT, dataclasses.replace(SEA, heading=60.0))
    np.testing.assert_allclose(oblique, [0.5 * ahead[0], ahead[1]], rtol=1e-12)


def test_regular_wave_is_its_own_equivalent_for_any_seed() -> None:
    sea = Regular(0.2, 3.14)
    run = realise(PLANT, sea, 1, 60.0)
    np.testing.assert_allclose(run.elevation, 0.1 * np.cos(3.14 * run.time), atol=1e-15)
    he = PLANT.excitation(np.array([3.14]), 0.0)[:, 0]
    np.testing.assert_allclose(run.moments, (0.1 * he[:, None] * np.exp(3.14j * run.time)).real, atol=1e-10)
    np.testing.assert_allclose(run.blended(50.0).moments, run.moments, atol=1e-10)
    other = realise(PLANT, sea, 2, 60.0)
    assert other.sha256 == run.sha256 and np.array_equal(other.moments, run.moments)


def test_bichromatic_sums_two_waves_with_phases_of_the_seed() -> None:
    sea = Bichromatic((0.2, 0.1), (2.5, 3.1))
    run = realise(PLANT, sea, 9, 500.0)
    first, second = run.phases
    expected = 0.1 * np.cos(2.5 * run.time + first) + 0.05 * np.cos(3.1 * run.time + second)
    np.testing.assert_allclose(run.elevation, expected, atol=1e-14)
    assert not np.array_equal(realise(PLANT, sea, 10, 500.0).elevation, run.elevation)


def test_tabulated_spectrum_gives_the_sea_it_was_taken_from(waves: WaveRealisation) -> None:
    sea = TabulatedSpectrum(OMEGA, SEA.spectrum(OMEGA))
    run = realise(PLANT, sea, 7)
    assert run.elevation[:-1].var() == pytest.approx(sea.hs**2 / 16.0, rel=1e-12)
    scale = sea.hs / SEA.hs
    np.testing.assert_allclose(run.moments, scale * waves.moments, atol=1e-6)


@pytest.mark.parametrize("dt", [0.05, 0.1, 0.02])
def test_record_round_trip(waves: WaveRealisation, dt: float) -> None:
    """A record of a synthetic sea, sampled by another clock, gives back its elevation and, off the ends, moments."""
    dense = realise(PLANT, SEA, 7, 600.0, dt)
    record = ElevationRecord(waves.time[:16001:2] + 5.0, waves.elevation[:16001:2] + 0.3)
    run = realise(PLANT, record, 0, 600.0, dt)
    inner = (run.time > 20.0) & (run.time < 580.0)
    error = run.elevation - dense.elevation
    assert error[inner].std() < 2e-3 * dense.elevation.std()
    assert np.abs(run.moments - dense.moments)[:, inner].max() < 0.02 * dense.moments.std()
    assert run.sha256 == realise(PLANT, record, 99, 600.0, dt).sha256


def test_record_of_one_wave_gives_its_moments() -> None:
    time = 0.04 * np.arange(20000, dtype=np.float64)
    run = realise(PLANT, ElevationRecord(time, 0.1 * np.cos(3.0 * time)), 0, 700.0)
    he = PLANT.excitation(np.array([3.0]), 0.0)[:, 0]
    expected = (0.1 * he[:, None] * np.exp(3.0j * run.time)).real
    inner = (run.time > 30.0) & (run.time < 670.0)
    assert np.abs(run.moments - expected)[:, inner].max() < 0.01 * np.abs(expected).max()


def test_ends_of_a_record_do_not_ring() -> None:
    """From a trough back to a crest: closing the loop by a jump of 0.2 m would overshoot by 9 % of it."""
    time = 0.05 * np.arange(4001, dtype=np.float64)
    record = ElevationRecord(time, 0.1 * np.cos(np.pi * 201.0 / 200.0 * time))
    assert record.surface[0] > 0.099 and record.surface[-1] < -0.099
    run = realise(PLANT, record, 0, 200.0)
    assert np.abs(run.elevation - record.surface).max() < 2e-3


def test_real_plant() -> None:
    """The shipped device takes the same road, and the paper's form of the excitation has another hash."""
    from gyroctl.devices import zhang2017

    corrected, paper = zhang2017(), zhang2017("paper")
    run = realise(corrected, SEA, 7)
    expected = np.abs(corrected.excitation(OMEGA, 0.0)) * np.abs(fourier(run.elevation))
    np.testing.assert_allclose(np.abs(fourier(run.moments)), expected, rtol=1e-6, atol=1e-7)
    printed = realise(paper, SEA, 7)
    assert np.array_equal(printed.elevation, run.elevation) and printed.sha256 != run.sha256
    eta = fourier(printed.elevation)
    big = np.abs(eta) > 1e-6 * np.abs(eta).max()
    transfer = fourier(printed.moments)[:, big] / eta[big]
    np.testing.assert_allclose(transfer, np.abs(corrected.excitation(OMEGA[big], 0.0)), rtol=1e-6, atol=1e-4)


TIME = 0.05 * np.arange(20001, dtype=np.float64)
RECORD = ElevationRecord(TIME, np.cos(3.0 * TIME))
BAD_RUNS: list[tuple[str, Callable[[], object]]] = [
    ("run.dt", lambda: realise(PLANT, SEA, 1, dt=0.03)),
    ("run.dt", lambda: realise(PLANT, SEA, 1, dt=0.25)),
    ("run.dt", lambda: realise(PLANT, SEA, 1, dt=0.0)),
    ("run.dt", lambda: realise(PLANT, SEA, 1, dt=math.nan)),
    ("run.duration", lambda: realise(PLANT, SEA, 1, duration=0.0)),
    ("run.duration", lambda: realise(PLANT, SEA, 1, duration=-5.0)),
    ("run.duration", lambda: realise(PLANT, SEA, 1, duration=100.02)),
    ("run.duration", lambda: realise(PLANT, SEA, 1, duration=50.0).blended(100.0)),
    ("run.duration", lambda: prepare(PLANT, SEA, 50.0).moments_batch([1], 100.0)),
    ("run.duration", lambda: realise(PLANT, RECORD, 1, duration=1000.05)),
    ("run.blend", lambda: realise(PLANT, SEA, 1, duration=50.0).blended(-1.0)),
    ("run.blend", lambda: realise(PLANT, SEA, 1, duration=50.0).blended(math.nan)),
    ("run.seeds", lambda: realise(PLANT, SEA, -1)),
    ("run.seeds", lambda: prepare(PLANT, SEA, 50.0).moments_batch([1, 2.5])),  # type: ignore[list-item]
    ("sea", lambda: realise(PLANT, "sea", 1)),  # type: ignore[arg-type]
    ("sea.wp", lambda: realise(PLANT, SeaState(wp=0.1), 1)),
    ("sea.wp", lambda: realise(PLANT, SeaState(wp=9.0, gamma=1.0), 1)),
    ("sea.wp", lambda: realise(PLANT, Regular(0.2, 13.0), 1)),
    ("sea.wp", lambda: realise(PLANT, Bichromatic((0.2, 0.19), (3.0, 13.0)), 1)),
    ("sea.wp", lambda: realise(PLANT, TabulatedSpectrum(np.array([3.0, 3.001]), np.ones(2)), 1)),
]


@pytest.mark.parametrize(("bad", "make"), BAD_RUNS)
def test_bad_run_is_refused(bad: str, make: Callable[[], object]) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.field == bad
    assert caught.value.problem and caught.value.mend.startswith("Give")


def test_blending_twice_is_refused(waves: WaveRealisation) -> None:
    with pytest.raises(InputError, match="blended already"):
        waves.blended(100.0).blended(50.0)


def test_wrong_output_array_is_refused() -> None:
    with pytest.raises(ValueError, match="shape"):
        prepare(PLANT, SEA, 50.0).moments_batch([1], out=np.empty((2, 2, 1001)))


@pytest.mark.parametrize("sea", [SEA, Regular(0.2, 3.0), Bichromatic((0.2, 0.1), (3.0, 3.3)), RECORD])
def test_every_sea_fills_the_same_shapes(sea: Sea) -> None:
    run = realise(PLANT, sea, 1, 100.0, 0.1)
    assert run.moments.shape == (2, 1001) and run.elevation.shape == (1001,)
    assert run.sea == sea and run.seed == 1


def test_realisations_asked_for_in_turn_are_those_asked_for_first() -> None:
    """What a sea, a plant or a length has in common with the call before is kept, and no more than that."""
    one, other = gy.zhang2017(), gy.zhang2017(excitation_phase="magnitude")
    mild, tall = gy.SeaState(hs=0.1), gy.SeaState(hs=0.3)
    asked = [(one, mild, 100.0, 0.05), (one, tall, 100.0, 0.05), (other, tall, 100.0, 0.05), (other, tall, 50.0, 0.05)]
    asked += [(other, tall, 50.0, 0.1), (one, mild, 100.0, 0.05)]
    for plant, sea, duration, dt in asked:
        found, alone = realise(plant, sea, 3, duration, dt), prepare(plant, sea, duration, dt)
        np.testing.assert_array_equal(found.moments, alone.moments(3))
        np.testing.assert_array_equal(found.elevation, alone.elevation(3))
