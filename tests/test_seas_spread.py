"""Seas of many directions: the moments are those of the distribution, the elevation stays, and laws run in them."""

import math
from pathlib import Path

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment
from gyroctl.errors import InputError
from gyroctl.waves import DirectionalSpectrum, SpreadSea, TwoPeaks, prepare
from gyroctl.waves.directional import shares
from gyroctl.waves.gauge import elevation_up_wave

STILL = gy.SeaState(heading=20.0)
SPREADS = (("cos2s", 10.0), ("cos2s", 1.0), ("normal", 25.0), ("normal", 60.0))


@pytest.mark.parametrize(("spreading", "width"), SPREADS)
def test_distribution_has_area_one_and_the_first_moment_of_its_kind(spreading: str, width: float) -> None:
    """r1 is s / (s + 1) of cos^2s, and exp(-deviation^2 / 2) of the wrapped normal distribution."""
    angle = np.radians(np.arange(-180.0, 180.0, 0.05))
    density = SpreadSea(STILL, spreading, width).distribution(angle) * math.radians(0.05)
    assert density.sum() == pytest.approx(1.0, rel=1e-9)
    r1 = width / (width + 1.0) if spreading == "cos2s" else math.exp(-0.5 * math.radians(width) ** 2)
    assert density @ np.cos(angle) == pytest.approx(r1, rel=1e-9)
    assert density @ np.sin(angle) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("spreading", "width"), SPREADS)
def test_neighbours_have_the_shape_of_the_distribution(spreading: str, width: float) -> None:
    sea = SpreadSea(STILL, spreading, width)
    off = np.radians(sea.headings_at(np.linspace(1.0, 2.0, 4000)) - sea.heading)
    r1 = width / (width + 1.0) if spreading == "cos2s" else math.exp(-0.5 * math.radians(width) ** 2)
    for some in (off, off[1000:1050], off[-50:]):
        assert abs(np.mean(np.exp(1j * some)) - r1) < 0.06 / math.sqrt(some.size / 50.0)


def test_shares_of_neighbours_are_spread_evenly() -> None:
    for some in (shares(5000)[:30], shares(5000)[777:807]):
        assert np.max(np.abs(np.sort(some) - (np.arange(30) + 0.5) / 30.0)) < 0.06


@pytest.mark.parametrize(("spreading", "width"), [("cos2s", 4.0), ("normal", 35.0)])
def test_variance_of_the_moments_is_the_integral_over_all_directions(
    device: gy.Plant, spreading: str, width: float
) -> None:
    """Simpson's rule over the angle, at every harmonic, against the headings that the harmonics were given."""
    from scipy.integrate import simpson

    sea = SpreadSea(STILL, spreading, width)
    made = prepare(device, sea, 300.0)
    angle = np.arange(-180.0, 181.0, 5.0)
    he = np.array([np.abs(device.excitation(made.waves.omega, sea.heading + a)) ** 2 for a in angle])
    weight = sea.distribution(np.radians(angle))[:, None, None] * he
    mean = simpson(weight, x=np.radians(angle), axis=0)
    energy = np.abs(made.waves.amplitude) ** 2
    want, got = (mean * energy).sum(axis=1), (np.abs(made.response) ** 2).sum(axis=1)
    np.testing.assert_allclose(got, want, rtol=2e-3)
    alone = (np.abs(prepare(device, STILL, 300.0).response) ** 2).sum(axis=1)
    assert got[0] < 0.95 * alone[0]  # about x1 the device feels the sideways part, which spreading takes away


def test_elevation_stays_and_the_hash_tells(device: gy.Plant) -> None:
    one, other, still = (
        gy.realise(device, sea, 3, 100.0)
        for sea in (SpreadSea(STILL, "cos2s", 5.0), SpreadSea(STILL, "cos2s", 6.0), STILL)
    )
    assert np.array_equal(one.elevation, still.elevation) and not np.allclose(one.moments, still.moments)
    assert len({one.sha256, other.sha256, still.sha256}) == 3
    lower = gy.realise(device, SpreadSea(gy.SeaState(hs=0.2, heading=20.0), "cos2s", 5.0), 3, 100.0)
    assert lower.sha256 != one.sha256
    assert one.sha256 == gy.realise(device, SpreadSea(gy.SeaState(heading=20.0), "cos2s", 5.0), 3, 100.0).sha256


def test_a_narrow_spreading_is_the_sea_without(device: gy.Plant) -> None:
    narrow, still = (gy.realise(device, sea, 3, 100.0) for sea in (SpreadSea(STILL, "normal", 0.5), STILL))
    assert np.abs(narrow.moments - still.moments).max() < 0.03 * np.abs(still.moments).max()


def test_a_table_of_one_direction_is_the_sea_of_that_heading(device: gy.Plant) -> None:
    omega = np.linspace(1.5, 9.0, 300)
    headings = np.arange(-180.0, 180.0, 2.0)
    density = np.zeros((omega.size, headings.size))
    density[:, 100] = STILL.spectrum(omega) / math.radians(2.0)  # 20 deg
    sea = DirectionalSpectrum(omega, headings, density)
    assert sea.heading == pytest.approx(20.0) and sea.spread < 1e-5 and sea.hs == pytest.approx(0.283, rel=5e-3)
    table = gy.waves.TabulatedSpectrum(omega, STILL.spectrum(omega), 20.0)
    one, other = (prepare(device, made, 100.0) for made in (sea, table))
    assert np.abs(one.response - other.response).max() < 0.03 * np.abs(other.response).max()
    for wrong in (density[:, :-1], -density, density * math.nan):
        with pytest.raises(InputError, match=r"sea\.density"):
            DirectionalSpectrum(omega, headings, wrong)
    with pytest.raises(InputError, match=r"sea\.headings"):
        DirectionalSpectrum(omega, headings**3, density)


def test_a_gauge_up_wave_sees_each_wave_on_its_own_way(device: gy.Plant) -> None:
    waves = gy.realise(device, SpreadSea(STILL, "cos2s", 3.0), 3, 20.0)
    made = waves.synthesis
    assert made is not None and made.waves.bearings is not None
    from gyroctl.hydrodynamics.dispersion import wavenumber

    k = wavenumber(made.waves.omega, device.depth)
    phase = waves.phases + 4.0 * k * np.cos(np.radians(made.waves.bearings - 10.0))
    rows = elevation_up_wave(waves, device, 4.0, 10.0)
    for at in (0, 137, 400):
        by_hand = np.real(made.waves.amplitude) @ np.cos(made.waves.omega * at * waves.dt + phase)
        assert rows[at] == pytest.approx(by_hand, abs=1e-9)


def test_laws_run_in_a_spread_sea(device: gy.Plant) -> None:
    waves = [gy.realise(device, SpreadSea(gy.SeaState(), "cos2s", 20.0), seed, 90.0) for seed in (1, 2)]
    ds = gy.compare(device, {"load_angle": gy.law("load_angle")}, waves, gy.Settings(blend=30.0), 1, quiet=True)
    assert np.all(np.isfinite(ds.mean_power)) and not ds.failed.any()


@pytest.mark.slow
def test_the_planner_forecasts_in_a_spread_sea(device: gy.Plant) -> None:
    waves = [gy.realise(device, SpreadSea(gy.SeaState(), "cos2s", 20.0), 1, 120.0)]
    ds = gy.compare(device, {"nmpc": gy.law("nmpc")}, waves, gy.Settings(blend=30.0), 1, quiet=True)
    assert float(ds.mean_power.squeeze()) > 0.0 and not ds.failed.any()


def test_the_followed_surface_is_refused_by_name() -> None:
    realistic = gy.zhang2017("realistic")
    with pytest.raises(InputError, match=r"plant\.wetted.*reduced"):
        prepare(realistic, SpreadSea(gy.SeaState()), 60.0)
    table = {"sea": {"spreading": "cos2s", "width": 9.0}, "plant": {"variant": "realistic"}, "laws": {"constant": {}}}
    with pytest.raises(InputError, match=r"plant\.wetted"):
        build_experiment(table)
    prepare(gy.zhang2017("realistic", wetted="reduced"), SpreadSea(gy.SeaState(), "normal", 5.0), 60.0)


def test_spreading_in_an_experiment() -> None:
    setup = build_experiment({"sea": {"hs": 0.2, "spreading": "normal", "width": 15.0}, "laws": {"constant": {}}})
    assert setup.sea == SpreadSea(gy.SeaState(hs=0.2), "normal", 15.0)
    told = setup.record()["sea"]
    assert (told["kind"], told["hs"], told["spreading"], told["width"]) == ("jonswap", 0.2, "normal", 15.0)
    both = build_experiment({"sea": {"kind": "two peaks", "spreading": "cos2s", "width": 8}, "laws": {"constant": {}}})
    assert both.sea == SpreadSea(TwoPeaks(), "cos2s", 8.0)
    wrong = (
        ({"spreading": "cos2s"}, "sea.width"),
        ({"width": 8.0}, "sea.spreading"),
        ({"spreading": "fan", "width": 8.0}, "sea.spreading"),
        ({"spreading": "normal", "width": 200.0}, "sea.width"),
        ({"spreading": 3, "width": 8.0}, "sea.spreading"),
        ({"kind": "regular", "height": 0.1, "wp": 3.0, "spreading": "cos2s", "width": 8.0}, "sea.spreading"),
    )
    for table, field in wrong:
        with pytest.raises(InputError) as caught:
            build_experiment({"sea": table, "laws": {"constant": {}}})
        assert caught.value.field == field


def test_a_sea_that_turns_has_no_spreading(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="sea = "):
        SpreadSea(gy.waves.TurningSea())  # type: ignore[arg-type]
