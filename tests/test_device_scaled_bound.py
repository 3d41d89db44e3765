"""The bound of a device at another length: that of its model at the size of Table 1, in the device's own units."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.cli.bound import _law
from gyroctl.devices.file import new_device, scaled_device, write_device
from gyroctl.devices.scaling import at_model_size, scaled_plant
from gyroctl.froude import growth
from gyroctl.studies.bound.model import in_own_units, model_cut

LENGTH = 16.0
"""All its powers are powers of two: the model of the model is the same to the bit."""


def sea(length: float) -> gy.SeaState:
    return gy.SeaState(gy.SeaState.hs * length, gy.SeaState.wp / growth("s", length))


def test_model_of_a_scaled_device_is_the_device(device: gy.Plant) -> None:
    model = at_model_size(scaled_plant(device, LENGTH))
    assert model.coefficients == device.coefficients and model.parameters == device.parameters
    assert at_model_size(device) is device
    assert at_model_size(scaled_plant(device, 3.0)).parameters.length_scale == 1.0


def test_window_begins_as_that_of_the_model(device: gy.Plant) -> None:
    small = model_cut(device, sea(1.0), 100001, 20.1, 0.02, None)
    large = model_cut(scaled_plant(device, LENGTH), sea(LENGTH), 100001, 80.2, 0.08, None)
    assert large.duration == 20.1 and large.settings.actuators.cc_lag == 0.02
    assert (large.start == small.start).all() and large.sha256 == small.sha256


def test_refusals_are_in_the_units_of_the_device(device: gy.Plant) -> None:
    big = scaled_plant(device, LENGTH)
    with pytest.raises(gy.InputError, match=r"duration = 20\.0: a window is from 80 to 4000 s long.*example 800"):
        model_cut(big, sea(LENGTH), 1, 20.0, None, None)
    with pytest.raises(gy.InputError, match=r"sea\.hs = 60.* m"):
        model_cut(big, gy.SeaState(60.0, 0.785), 1, 400.0, None, None)


def test_numbers_with_a_unit_grow_and_the_others_stay() -> None:
    told = {"harvest_w": 2.0, "phi1_p98": 0.3, "cap_w": None, "bounds": {"smooth": {"flywheel_max": 70.0, "seed": 3}}}
    grown = in_own_units(told, LENGTH)
    assert grown["harvest_w"] == 2.0 * LENGTH**3.5 and grown["phi1_p98"] == 0.3 and grown["cap_w"] is None
    assert grown["bounds"]["smooth"] == {"flywheel_max": 17.5, "seed": 3}


def test_pair_of_a_law_is_the_devices_and_a_planner_is_the_models(device: gy.Plant) -> None:
    big, unit = scaled_plant(device, LENGTH), LENGTH**4.5
    held = _law(f"constant cc={0.104 * unit!r}", big)
    assert held.cc == 0.104 and held.cg == gy.law("constant").cg  # type: ignore[attr-defined]
    assert _law("nmpc information=oracle", big).information == "oracle"


@pytest.mark.slow
def test_bound_command_takes_a_large_device(run: Run, tmp_path: Path) -> None:
    mine = write_device(tmp_path / "mine.toml", new_device("mine"))
    big = write_device(tmp_path / "big.toml", scaled_device(mine, LENGTH))
    found = []
    for file, length in ((mine, 1.0), (big, LENGTH)):
        pair = f"constant cc={0.104 * growth('Nms', length)!r} cg={1e-4 * growth('Nms', length)!r}"
        how = ("--seeds", 100001, "--duration", 20.0 * growth("s", length), "--quick", "--law", pair)
        code, told, said = run("bound", "--device", file, *how, "--out", tmp_path / file.stem)
        assert code == 0, said
        found.append(json.loads(told))
    small, large = found
    one, other = small["windows"][0], large["windows"][0]
    power = LENGTH**3.5
    assert other["cap_w"] == pytest.approx(one["cap_w"] * power, rel=1e-9)
    for name in ("harvest_w", "absorbed_w", "planned_w"):
        assert other["bounds"]["smooth"][name] == pytest.approx(one["bounds"]["smooth"][name] * power, rel=1e-9)
    (law,), (same,) = one["laws"].values(), other["laws"].values()
    assert same["harvest_w"] == pytest.approx(law["harvest_w"] * power, rel=1e-9)
    assert same["fraction"] == pytest.approx(law["fraction"], rel=1e-9)
    assert large["request"]["duration_s"] == 80.0 and large["request"]["device"].startswith("mine x16")
    assert large["summary"]["bounds"]["smooth"]["harvest_w"] == other["bounds"]["smooth"]["harvest_w"]
