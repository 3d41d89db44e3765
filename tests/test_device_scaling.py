"""Froude's law: a device and the same at another size are one run in their own units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.devices.file import device, new_device, scaled_device, write_device
from gyroctl.devices.scaling import scaled_plant
from gyroctl.froude import growth, power
from gyroctl.harness.for_device import InModelScale
from gyroctl.harness.run import run_law
from gyroctl.hydrodynamics import excitation_table, shipped
from gyroctl.hydrodynamics.scaling import scaled
from gyroctl.simulation.metrics import Record
from gyroctl.waves.grid import time_grid

HEIGHT, WP, CC, CG = 0.2, 3.14, 0.052, 3.5e-4
UNITS = ("rad", "rad", "rad", "rad", "rad/s", "rad/s", "rad/s", "rad/s")
PERIOD = 2.0 * np.pi / WP


def regular_run(plant: gy.Plant, length: float, periods: int, law: gy.Law | None = None) -> Record:
    """Run a constant pair, or a law, in the regular wave, all of it at a length."""
    time = growth("s", length)
    duration = round(periods * PERIOD / 0.1) * 0.1
    waves = gy.realise(plant, gy.Regular(HEIGHT * length, WP / time), 1, duration * time)
    settings = gy.Settings(blend=0.0, sensors=gy.Sensors.ideal()).at(length)
    pair = {"cc": CC * growth("Nms", length), "cg": CG * growth("Nms", length)}
    own = gy.law("constant", period=0.1 * time, **pair) if law is None else law
    return run_law(plant, own, waves, settings)[0]


def apart(small: Record, large: Record, length: float, labels: int) -> float:
    """Largest difference of the states in units of their largest value, and of the energies in that of the waves'."""
    worst = 0.0
    for row, unit in enumerate(UNITS):
        one, other = small.states[:, row], large.states[:, row] / growth(unit, length)
        worst = max(worst, float(np.abs(one - other).max() / np.abs(one).max()))
    one, other = small.states[:, labels:], large.states[:, labels:] / growth("J", length)
    return max(worst, float(np.abs(one - other).max() / np.abs(one[:, 0]).max()))


def test_powers_follow_from_units() -> None:
    expected = {"m": 1, "s": 0.5, "kg": 3, "kg m^2": 5, "Nm": 4, "Nms": 4.5, "Nms/rad": 4.5, "Nms^2": 5, "rad/s": -0.5}
    expected |= {"-": 0, "m^2": 2, "W": 3.5, "J": 4, "Nm/m": 3, "N^2 m^2": 8, "m^2/s^2": 1, "1/s": -0.5, "Nm/rad": 4}
    for unit, value in expected.items():
        assert power(unit) == value, unit
    assert growth("Nms", 4.0) == 4.0**4.5
    with pytest.raises(ValueError, match="no unit"):
        power("furlong")


def test_scaled_table_is_the_table_in_other_units() -> None:
    first, big = shipped(), scaled(shipped(), 20.0)
    np.testing.assert_allclose(big.omega * np.sqrt(20.0), first.omega, rtol=1e-14)
    for name, fits in first.fits.items():
        for (p, q), (large_p, large_q) in zip(fits, big.fits[name], strict=True):
            s = 1j * first.omega
            h = np.polyval(p, s) / np.polyval([1.0, *q], s)
            large = np.polyval(large_p, s / np.sqrt(20.0)) / np.polyval([1.0, *large_q], s / np.sqrt(20.0))
            np.testing.assert_allclose(large, h * 20.0**4.5, rtol=1e-12)
    he = excitation_table(first)(np.array([3.0]), 12.0)
    np.testing.assert_allclose(excitation_table(big)(np.array([3.0 / np.sqrt(20.0)]), 12.0), he * 20.0**3, rtol=1e-12)


def test_scaled_file_is_the_scaled_device(tmp_path: Path) -> None:
    mine = write_device(tmp_path / "mine.toml", new_device("mine"))
    big = device(write_device(tmp_path / "big.toml", scaled_device(mine, 20.0)))
    expected = scaled_plant(gy.zhang2017(), 20.0)
    assert big.coefficients == expected.coefficients and big.excitation.sha256 == expected.excitation.sha256
    assert big.geometry == expected.geometry and big.depth == expected.depth
    back = scaled_plant(expected, 0.05)
    np.testing.assert_allclose(back.coefficients[:18], gy.zhang2017().coefficients[:18], rtol=1e-12)


def test_widths_are_in_the_units_of_the_device() -> None:
    small = gy.zhang2017("realistic").coefficients.beyond
    large = scaled_plant(gy.zhang2017("realistic"), 16.0).coefficients.beyond
    for term, units in {
        "contact": {"side": "Nm", "creep": "rad/s", "soft": "N^2 m^2", "changing": "Nm", "change": "1/s"},
        "losses": {"bearing": "Nm", "windage": "Nms^2", "rolling": "-", "slow": "rad/s", "soft": "N^2 m^2"},
        "drag": {"factor1": "kg", "reach": "m", "still": "m^2/s^2"},
        "cap": {"torque": "Nm"},
    }.items():
        for name, unit in units.items():
            ratio = getattr(getattr(large, term), name) / getattr(getattr(small, term), name)
            assert ratio == pytest.approx(16.0 ** power(unit), rel=1e-12), (term, name)


def test_wave_grid_is_in_the_time_of_the_device() -> None:
    time = float(np.sqrt(50.0))
    grid = time_grid(200 * PERIOD * time, None, time)
    assert grid.dt == pytest.approx(0.05 * time) and grid.period == pytest.approx(2000.0 * time)
    assert grid.duration >= 200 * PERIOD * time > grid.duration - grid.dt
    assert grid.harmonics[-1] == pytest.approx(grid.omega_max) == pytest.approx(time_grid(1.0, 0.05).omega_max / time)
    with pytest.raises(gy.InputError, match="coarse"):
        time_grid(2000.0, 0.25 * time, time)


def test_the_same_seed_is_the_same_sea_at_any_size(device: gy.Plant) -> None:
    small = gy.realise(device, gy.SeaState(), 3, 100.0)
    large = gy.realise(scaled_plant(device, 20.0), gy.SeaState(0.283 * 20.0, 3.14 / 20.0**0.5), 3, 100.0 * 20.0**0.5)
    np.testing.assert_allclose(large.elevation / 20.0, small.elevation, atol=1e-9 * small.elevation.std())
    np.testing.assert_allclose(large.moments / 20.0**4, small.moments, atol=1e-8 * small.moments.std())


def same_at(variant: str, periods: int, lengths: tuple[float, ...]) -> None:
    plant = gy.zhang2017("corrected", d1=1.0) if variant == "linear" else gy.zhang2017(variant)
    small = regular_run(plant, 1.0, periods)
    for length in lengths:
        large = regular_run(scaled_plant(plant, length), length, periods)
        assert apart(small, large, length, len(plant.labels)) < 1e-9, (variant, length)


@pytest.mark.parametrize("variant", ["linear", "corrected"])
def test_regular_wave_of_two_hundred_periods_is_the_same_run(variant: str) -> None:
    same_at(variant, 200, (10.0, 20.0, 50.0))


@pytest.mark.slow
def test_regular_wave_of_two_hundred_periods_is_the_same_run_in_real_water() -> None:
    same_at("realistic", 200, (10.0, 20.0, 50.0))


def test_contact_that_slips_is_the_same_run(device: gy.Plant) -> None:
    plant = device.replace(contact="friction", traction=0.25, bearing=0.01, rolling_resistance=1e-5, coupling_cap=2.0)
    small, large = regular_run(plant, 1.0, 20), regular_run(scaled_plant(plant, 20.0), 20.0, 20)
    assert apart(small, large, 20.0, len(plant.labels)) < 1e-9


def test_law_on_a_large_device_is_that_on_its_model(device: gy.Plant) -> None:
    big = scaled_plant(device, 16.0)
    law = gy.law("load_angle", device=big)
    assert isinstance(law, InModelScale) and law.period == pytest.approx(0.4)
    small, large = regular_run(device, 1.0, 30, gy.law("load_angle")), regular_run(big, 16.0, 30, law)
    ratio = large.commands / small.commands
    np.testing.assert_allclose(ratio[small.commands > 0.0], 16.0**4.5, rtol=1e-6)
    assert apart(small, large, 16.0, len(device.labels)) < 1e-6


def test_metrics_are_in_the_units_of_the_device(device: gy.Plant) -> None:
    from gyroctl.simulation.metrics import evaluate

    def metrics(plant: gy.Plant, length: float) -> dict[str, float]:
        record, time = regular_run(plant, length, 20), growth("s", length)
        waves = gy.realise(plant, gy.Regular(HEIGHT * length, WP / time), 1, record.states.shape[0] * 0.1 * time)
        return evaluate(plant, record, waves.moments[1], waves.dt, WP / time, 10.0 * time, np.nan)

    small, large = metrics(device, 1.0), metrics(scaled_plant(device, 16.0), 16.0)
    assert large["mean_power"] == pytest.approx(small["mean_power"] * 16.0**3.5, rel=1e-9)
    for name in ("locked", "turns_kept", "cycle_slips", "availability", "phi1_p98", "power_cv", "power_cv_1s"):
        assert large[name] == pytest.approx(small[name], rel=1e-6, abs=1e-9), name


def test_law_that_is_told_the_waves_is_refused_on_another_length(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match="device scale"):
        gy.law("nmpc", device=scaled_plant(device, 16.0), information="oracle")


def test_pair_of_a_constant_law_is_in_the_devices_own_units(device: gy.Plant) -> None:
    big, unit = scaled_plant(device, 16.0), 16.0**4.5
    usual, given = gy.law("constant", device=big), gy.law("constant", device=big, cc=1000.0)
    assert usual.cc == pytest.approx(gy.law("constant").cc * unit)  # type: ignore[attr-defined]
    assert given.cc == 1000.0 and given.cg == pytest.approx(unit * gy.law("constant").cg)  # type: ignore[attr-defined]
