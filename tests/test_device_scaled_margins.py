"""Margins and lock maps of a device at another size: those of its model in the device's own units, by Froude's law."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.devices.file import device as read
from gyroctl.devices.file import new_device, scaled_device, write_device
from gyroctl.devices.scaling import scaled_plant
from gyroctl.froude import at_length, growth
from gyroctl.harness.law_trials import BLEND, TURNING, Ground, seen
from gyroctl.harness.registry import describe
from gyroctl.orbits import critical_damping, lock_map, tongue
from gyroctl.orbits.sensitivity import state_units
from gyroctl.robustness import shocks
from gyroctl.robustness.headroom import headroom, ramp
from gyroctl.robustness.regime import Regime, settle
from gyroctl.studies.margins import request
from gyroctl.studies.margins.axes import gain_at, power_levels, ticks
from gyroctl.studies.margins.drag_lock import duration_of
from gyroctl.studies.margins.mapped import couplings
from gyroctl.studies.margins.maps import coupling_map, tongue_map
from gyroctl.studies.margins.water import CHOICES, choices_of, couplings_around, of_choice

LENGTHS = (0.1, 20.0)
HEIGHT, WP, CC, CG = 0.2, 3.14, 0.052, 3.5e-4
UNITS = {"cg": "Nms", "height": "m", "wp": "rad/s", "cc": "Nms", "d1": "Nms/rad"}


def wave(length: float) -> gy.Regular:
    return gy.Regular(HEIGHT * length, WP / growth("s", length))


def pair(length: float) -> tuple[float, float]:
    return at_length((CC, CG), "Nms", length)


def regime(plant: gy.Plant, length: float) -> Regime:
    return settle(gy.lock_orbit(plant, wave(length), *pair(length)), wave(length))


@pytest.fixture(scope="module")
def small(device: gy.Plant) -> Regime:
    return regime(device, 1.0)


@pytest.mark.parametrize("length", LENGTHS)
def test_regime_basin_and_shocks_are_those_of_the_model(
    device: gy.Plant, small: Regime, length: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    large = regime(scaled_plant(device, length), length)
    assert large.power == pytest.approx(small.power * growth("W", length), rel=1e-11)
    assert large.angle == pytest.approx(small.angle, abs=1e-11)
    assert large.phase == pytest.approx(small.phase, abs=1e-11)
    np.testing.assert_allclose(large.x / state_units(large.plant), small.x, atol=1e-11)  # steps and grid are the same
    most = shocks.largest_shocks
    monkeypatch.setattr(shocks, "largest_shocks", lambda of: {n: most(of)[n] for n in ("psi", "omega_rate")})
    one, other = (shocks.smallest_shocks(each, periods=30.0) for each in (small, large))
    assert any(np.isfinite(shock.size) for shock in one)
    for a, b in zip(one, other, strict=True):
        unit = growth("rad/s" if a.state == "omega_rate" else "rad", length)
        assert (b.size, b.largest) == pytest.approx((a.size * unit, a.largest * unit), rel=1e-6, nan_ok=True), a.state
    monkeypatch.undo()
    share = shocks.basin_stability(small, 1.0, 12, periods=30.0)
    assert shocks.basin_stability(large, 1.0, 12, periods=30.0) == share and 0.0 < share.value < 1.0


@pytest.mark.parametrize(("quantity", "upwards"), [("cg", True), ("height", False)])
def test_headroom_ends_in_the_same_decibels(device: gy.Plant, quantity: Any, upwards: bool) -> None:
    rooms = []
    for length in (1.0, *LENGTHS):
        orbit = gy.lock_orbit(scaled_plant(device, length), wave(length), *pair(length))
        rooms.append(headroom(orbit, wave(length), quantity, upwards))
    for room, length in zip(rooms[1:], LENGTHS, strict=True):
        assert room.ending == rooms[0].ending and room.decibel == pytest.approx(rooms[0].decibel, rel=1e-6)
        assert room.limit == pytest.approx(rooms[0].limit * growth(UNITS[quantity], length), rel=1e-6)


@pytest.mark.slow
def test_law_in_a_slow_ramp_is_lost_at_the_same_factor(device: gy.Plant) -> None:
    limits = []
    for length in (1.0, 16.0):
        plant, unit = scaled_plant(device, length), growth("Nms", length)
        law = gy.law("load_angle", device=plant)
        start = gy.lock_orbit(plant, wave(length), CC * unit, CG * unit)
        limits.append(ramp(settle(start, wave(length), law), "cg", 1.0, 10.0, periods=60))
    assert np.isfinite(limits[0]) and limits[1] == pytest.approx(limits[0], rel=1e-6)


def test_maps_on_a_grid_are_those_of_the_model(device: gy.Plant) -> None:
    """Steps and accuracy are the same in the device's time: codes alike, borders to the bisection's last bit."""
    length = 20.0
    plant, (cc, _) = scaled_plant(device, length), pair(length)
    unit, time = growth("Nms", length), growth("s", length)
    grids = [0.02, 0.1], [4e-3, 8e-3]
    one = coupling_map(device, wave(1.0), *grids)
    other = coupling_map(plant, wave(length), *([value * unit for value in grid] for grid in grids))
    heights = [0.02, 0.2]
    low = tongue_map(device, CC, 1e-3, [3.4], heights)
    high = tongue_map(plant, cc, 1e-3 * unit, [3.4 / time], [value * length for value in heights])
    for a, b, border in ((one, other, unit), (low, high, length)):
        np.testing.assert_array_equal(a.code, b.code)
        np.testing.assert_allclose(b.border, a.border * border, rtol=1e-9)
        np.testing.assert_allclose(b.power, a.power * growth("W", length), rtol=1e-7)
        np.testing.assert_allclose(b.growth, a.growth, atol=1e-7)
        np.testing.assert_allclose(b.angle, a.angle, atol=1e-7)
    assert np.isfinite(one.border).any() and np.isfinite(low.border).any()


@pytest.mark.slow
@pytest.mark.parametrize("length", LENGTHS)
def test_lock_map_is_that_of_the_model_by_default(device: gy.Plant, length: float) -> None:
    small, large = lock_map(device, wave(1.0)), lock_map(scaled_plant(device, length), wave(length))
    unit = growth("Nms", length)
    np.testing.assert_allclose(large.cc, small.cc * unit, rtol=1e-12)
    for one, other in zip((small.fold, *small.neimark_sacker), (large.fold, *large.neimark_sacker), strict=True):
        np.testing.assert_allclose(other.first, one.first * unit, rtol=1e-6)
        np.testing.assert_allclose(other.second, one.second * unit, rtol=1e-6)
        np.testing.assert_allclose(other.power, one.power * growth("W", length), rtol=1e-6)
        np.testing.assert_allclose(other.others, one.others, rtol=1e-6, atol=1e-9)
    for a, b in zip(small.slices, large.slices, strict=True):
        np.testing.assert_allclose(b.values, a.values * unit, rtol=1e-6, atol=1e-9 * unit)


@pytest.mark.slow
def test_tongue_and_critical_damping_by_default_are_those_of_the_model(device: gy.Plant) -> None:
    length = 20.0
    plant, unit = scaled_plant(device, length), growth("Nms", length)
    low, high = tongue(device, wave(1.0), CC, CG), tongue(plant, wave(length), *pair(length))
    np.testing.assert_allclose(high.first, low.first * length, rtol=1e-6)
    np.testing.assert_allclose(high.second, low.second * growth("rad/s", length), rtol=1e-6)
    low, high = critical_damping(device, wave(1.0), CG), critical_damping(plant, wave(length), CG * unit)
    np.testing.assert_allclose(high.first, low.first * growth("Nms/rad", length), rtol=1e-6)
    np.testing.assert_allclose(high.second, low.second * unit, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("length", LENGTHS)
def test_margins_of_a_law_by_name_are_those_of_the_model(device: gy.Plant, length: float) -> None:
    unit, time = growth("Nms", length), growth("s", length)
    small = gy.margins(device, wave(1.0), CC, CG, "load_angle", samples=8, quiet=True)
    large = gy.margins(scaled_plant(device, length), wave(length), CC * unit, CG * unit, "load_angle", samples=8)
    np.testing.assert_allclose(large.orbit.multipliers, small.orbit.multipliers, rtol=1e-6, atol=1e-9)
    assert large.lock_reserve == pytest.approx(small.lock_reserve, rel=1e-9)
    assert large.decay_time == pytest.approx(small.decay_time * time, rel=1e-6)
    assert large.power == pytest.approx(small.power * growth("W", length), rel=1e-6)
    for name, room in small.headroom.items():
        assert large.headroom[name].ending == room.ending
        assert large.headroom[name].decibel == pytest.approx(room.decibel, rel=1e-6)
    assert small.constant is not None and large.constant is not None
    for name, room in small.constant.headroom.items():
        assert large.constant.headroom[name].decibel == pytest.approx(room.decibel, rel=1e-6)
    assert large.basin == small.basin and large.constant.basin == small.constant.basin
    for a, b in zip(small.shocks, large.shocks, strict=True):
        assert b.size == pytest.approx(a.size / (time if a.state.endswith("rate") else 1.0), rel=1e-6, nan_ok=True)
    assert large.disk == pytest.approx(small.disk, rel=1e-6) and large.phase == pytest.approx(small.phase, rel=1e-6)
    assert large.delay == pytest.approx(small.delay * time, rel=1e-6, nan_ok=True)


def test_law_is_told_the_wave_and_the_pair_in_its_own_units(device: gy.Plant) -> None:
    big, unit = scaled_plant(device, 16.0), growth("Nms", 16.0)
    constant = request(big, 3.2, WP / 4.0, CC * unit, CG * unit, 1, "constant", own_device=True).law
    assert (constant.cc, constant.cg) == pytest.approx((CC * unit, CG * unit))  # type: ignore[union-attr]
    clocked = request(big, 3.2, 2.9 / 4.0, CC * unit, CG * unit, 1, "load_angle", own_device=True).law
    assert describe(clocked.law)["wp"] == pytest.approx(2.9)  # type: ignore[union-attr]


def test_ranges_of_maps_grow_with_the_device(device: gy.Plant) -> None:
    unit = growth("Nms", 20.0)
    asked = request(scaled_plant(device, 20.0), wave(20.0).height, wave(20.0).wp, *pair(20.0))
    assert couplings(asked) == pytest.approx((0.01 * unit, 0.3 * unit))
    assert couplings_around(asked) == pytest.approx((0.005 * unit, 0.3 * unit))
    assert duration_of(asked) == pytest.approx(600.0 * growth("s", 20.0))


def test_law_is_tried_by_what_its_device_would_measure(device: gy.Plant) -> None:
    ground = Ground(scaled_plant(device, 16.0))
    y = seen(TURNING, ground.time)
    assert (y.psi_rate, y.omega_rate, y.phi1) == (TURNING.psi_rate / 4.0, TURNING.omega_rate / 4.0, TURNING.phi1)
    settings = ground.settings(blend=BLEND)
    assert (settings.blend, settings.dt, settings.actuators.period) == (200.0, 0.04, 0.4)
    waves = ground.waves(1, 100.0, settings)
    assert waves.duration == pytest.approx(400.0) and (waves.sea.hs, waves.sea.wp) == (0.283 * 16.0, 3.14 / 4.0)


def test_limits_and_examples_grow_with_the_device(device: gy.Plant) -> None:
    big = scaled_plant(device, 20.0)
    usual = wave(20.0).height, wave(20.0).wp
    assert request(big, *usual, *pair(20.0)).cc == pair(20.0)[0]
    with pytest.raises(gy.InputError, match=r"cg = .*between 0 and 7\.1554.*for example 250"):
        request(big, *usual, CC * growth("Nms", 20.0), 1e8)
    with pytest.raises(gy.InputError, match=r"too fast for steps of 0\.0447 s.*at most .* Nms"):
        request(big, *usual, 100.0 * growth("Nms", 20.0), 250.0)
    with pytest.raises(gy.InputError, match=r"Give for example \(7\.16e\+03, 2\.15e\+05\)"):
        lock_map(big, wave(20.0), (1.0, -1.0))


def test_axes_are_round_numbers_near_those_of_table_1() -> None:
    assert gain_at(1.0) == (1e3, "$10^{-3}$ Nms", "$\\times 10^{-3}$ Nms")
    assert gain_at(20.0) == (1.0, "Nms", "Nms") and gain_at(0.1).scale == 1e9
    assert ticks("cc", 1.0, 0.01, 0.3)[0] == [0.01, 0.02, 0.05, 0.1, 0.2, 0.3]
    assert ticks("height", 20.0, 0.2, 12.0)[0] == [0.4, 1.0, 2.0, 4.0, 8.0]
    assert ticks("cc", 20.0, 7155.0, 50000.0) == ([10000.0, 40000.0], ["10k", "40k"])
    assert power_levels(1.0, 0.9, 11.0) == [1.0, 2.0, 3.0, 5.0, 7.0, 10.0]
    assert power_levels(20.0, 3e4, 2e5) == [36000.0, 72000.0, 110000.0, 180000.0]


def test_choices_grow_and_are_named_by_their_own_numbers(device: gy.Plant) -> None:
    assert choices_of(device) is CHOICES
    found = choices_of(scaled_plant(device, 16.0))
    assert found["coupling slip 5 rad/s"] == {"coupling_slip": 5.0} and found["drag 0.5"] == {"drag": 0.5}
    assert found["rolling 0.00016 m"] == {"rolling_resistance": pytest.approx(1.6e-4)}
    assert len(found) == len(CHOICES)


@pytest.mark.slow
def test_choice_beyond_the_linear_plant_moves_the_same(device: gy.Plant) -> None:
    length = 20.0
    small = of_choice(request(device, HEIGHT, WP, CC, CG), "coupling slip 20 rad/s")
    asked = request(scaled_plant(device, length), wave(length).height, wave(length).wp, *pair(length))
    large = of_choice(asked, "coupling slip 4.47 rad/s")
    assert (large.status, large.slowest, large.cg_ending) == (small.status, small.slowest, small.cg_ending)
    of_unit = {"fold": "Nms", "cg_end": "Nms", "cc_border": "Nms", "d1_border": "Nms/rad", "power": "W"}
    for name, unit in {**of_unit, "rate": "1/s", "wp_end": "rad/s", "damping_ratio": "-"}.items():
        wanted = getattr(small, name) * growth(unit, length)
        assert getattr(large, name) == pytest.approx(wanted, rel=1e-5, nan_ok=True), name


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[float, Path]:
    """A device of one's own, lighter in its wheel, and the same twenty times as long."""
    folder = tmp_path_factory.mktemp("devices")
    mine = write_device(folder / "mine.toml", new_device("mine"))
    return {1.0: mine, 20.0: write_device(folder / "big.toml", scaled_device(mine, 20.0))}


@pytest.mark.slow
def test_margins_command_takes_a_large_device(files: dict[float, Path], run: Run, tmp_path: Path) -> None:
    found = {}
    for length, file in files.items():
        out = tmp_path / file.stem
        code, told, said = run("margins", "--device", file, "--out", out, "--samples", 2, "--maps")
        assert code == 0, said
        found[length] = json.loads((out / "margins.json").read_text())
        assert json.loads(told)["request"]["device"].startswith("mine")
        assert {"lock_map.png", "tongue.png", "heat_maps.png", "robustness.png"} <= {p.name for p in out.iterdir()}
    small, large = found[1.0], found[20.0]
    unit = growth("Nms", 20.0)
    assert large["request"]["controls"]["cc_nms"] == pytest.approx(CC * unit)
    for name, room in small["constant_controls"]["headroom"].items():
        assert large["constant_controls"]["headroom"][name]["decibel"] == pytest.approx(room["decibel"], rel=1e-6)
    basins = [found[length]["constant_controls"]["basin_stability"] for length in (1.0, 20.0)]
    assert [point["share"] for point in basins[0]] == [point["share"] for point in basins[1]]
    assert large["maps"]["controls"]["code"] == small["maps"]["controls"]["code"]
    assert large["maps"]["waves"]["code"] == small["maps"]["waves"]["code"]
    border = [None if v is None else v * unit for v in small["maps"]["controls"]["border"]]
    assert large["maps"]["controls"]["border"] == pytest.approx(border, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["cc,cg", "wp,height"])
def test_lockmap_command_takes_a_large_device(files: dict[float, Path], run: Run, tmp_path: Path, axes: str) -> None:
    found = {}
    for length, file in files.items():
        code, _, said = run("lockmap", "--device", file, "--axes", axes, "--out", tmp_path / file.stem)
        assert code == 0, said
        found[length] = json.loads((tmp_path / file.stem / "lockmap.json").read_text())
    small, large = found[1.0], found[20.0]
    one, two = (growth(UNITS[name], 20.0) for name in axes.split(","))
    assert large["map"]["code"] == small["map"]["code"] and len(large["borders"]) == len(small["borders"])
    np.testing.assert_allclose(large["map"]["first"], one * np.array(small["map"]["first"]), rtol=1e-9)
    for a, b in zip(small["map"]["border"], large["map"]["border"], strict=True):
        assert (a is None and b is None) or b == pytest.approx(a * two, rel=1e-6)
    for a, b in zip(small["borders"], large["borders"], strict=True):
        known = [(y, z) for y, z in zip(a["y"], b["y"], strict=True) if y is not None and z is not None]
        assert all(z == pytest.approx(y * two, rel=1e-6) for y, z in known)


@pytest.mark.slow
def test_check_of_a_law_finds_the_same_on_a_large_device(files: dict[float, Path]) -> None:
    small, large = (gy.check_law("load_angle", read(file), 2) for file in files.values())
    assert [(line.name, line.passed) for line in small] == [(line.name, line.passed) for line in large]
    assert all(line.passed for line in large)
