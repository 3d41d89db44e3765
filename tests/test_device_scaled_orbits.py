"""Orbits and margins of a device at another size: the same numbers in its own units, by Froude's law."""

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.devices.scaling import scaled_plant
from gyroctl.froude import growth
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.margins import loop_margins

HEIGHT, WP, CC, CG = 0.2, 3.14, 0.052, 3.5e-4
LENGTH = 20.0


def wave(length: float) -> gy.Regular:
    return gy.Regular(HEIGHT * length, WP / growth("s", length))


def orbit(plant: gy.Plant, length: float) -> gy.PeriodicOrbit:
    unit = growth("Nms", length)
    return gy.lock_orbit(plant, wave(length), CC * unit, CG * unit, nearest=False)


@pytest.mark.parametrize("length", [0.05, 20.0])
def test_locked_orbit_has_the_same_multipliers(device: gy.Plant, length: float) -> None:
    changed = device.replace(J14=0.25)
    small, large = orbit(changed, 1.0), orbit(scaled_plant(changed, length), length)
    assert small.status == large.status == "stable"
    np.testing.assert_allclose(large.multipliers, small.multipliers, rtol=1e-6, atol=1e-9)
    assert large.power == pytest.approx(small.power * growth("W", length), rel=1e-9)
    assert large.load_angle == pytest.approx(small.load_angle, abs=1e-9)
    assert large.lock_share == pytest.approx(small.lock_share, rel=1e-9)
    assert abs(small.load_angle - orbit(device, 1.0).load_angle) > 0.01  # the change is no scaling


def closed(plant: gy.Plant, length: float) -> LoopOrbit:
    return close_loop(plant, wave(length), gy.law("load_angle", device=plant))


def test_margins_of_a_law_are_those_on_its_model(device: gy.Plant) -> None:
    """The law holds its own clock and filter in the time of the model, also where the sample is fitted to the wave."""
    small, large = closed(device, 1.0), closed(scaled_plant(device, LENGTH), LENGTH)
    assert small.status == large.status == "stable"
    np.testing.assert_allclose(np.sort(np.abs(large.multipliers)), np.sort(np.abs(small.multipliers)), atol=1e-6)
    channels = ("cg", "psi_rate", "controls")
    one, other = loop_margins(small, channels).channels, loop_margins(large, channels).channels
    for name in channels:
        assert other[name].gain == pytest.approx(one[name].gain, rel=1e-6), name
        assert other[name].phase == pytest.approx(one[name].phase, rel=1e-6), name
        assert other[name].disk == pytest.approx(one[name].disk, rel=1e-6), name
    assert large.power == pytest.approx(small.power * growth("W", LENGTH), rel=1e-6)
