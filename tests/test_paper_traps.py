"""Traps of the paper that show only in lock: the phase of the moments, hinge damping, the start."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.orbits.flow import Forcing, flow

EQUIVALENT = gy.Regular(height=0.283 / math.sqrt(2.0), wp=3.14)


@pytest.mark.parametrize("cg", [3.5e-4, 1e-3])
def test_phase_of_the_moments_picks_the_sense_of_rotation(device: gy.Plant, cg: float) -> None:
    """Trap 4: with true phases one sense locks; with |He| alone, as in (42)-(43), both do."""
    assert gy.lock_orbit(device, EQUIVALENT, 0.052, cg, sense=1).status == "stable"
    assert gy.lock_orbit(device, EQUIVALENT, 0.052, cg, sense=-1).status == "no orbit"
    magnitude = gy.zhang2017(excitation_phase="magnitude")
    for sense in (1, -1):
        assert gy.lock_orbit(magnitude, EQUIVALENT, 0.052, cg, sense=sense).status == "stable"


@pytest.mark.parametrize(("cc", "cg"), [(0.052, 3.5e-4), (0.104, 1.5e-4)])
def test_locked_orbit_needs_hinge_damping(device: gy.Plant, cc: float, cg: float) -> None:
    """Trap 5: without it a Neimark-Sacker pair near 1.2 rad/s grows; the smaller cc is the worse."""
    bare = gy.lock_orbit(gy.zhang2017(d1=0.0), EQUIVALENT, cc, cg)
    assert bare.status == "unstable"
    pair = bare.multipliers[0]
    assert abs(pair) > 1.005
    assert abs(np.angle(pair)) / bare.period == pytest.approx(1.2, abs=0.05)
    assert gy.lock_orbit(device, EQUIVALENT, cc, cg).status == "stable"


def test_smaller_coupling_needs_more_hinge_damping() -> None:
    sizes = [abs(gy.lock_orbit(gy.zhang2017(d1=1.0), EQUIVALENT, cc, 3.5e-4).multipliers[0]) for cc in (0.052, 0.104)]
    assert sizes[0] > 1.0 > sizes[1]


def _locked_angles(plant: gy.Plant, flywheel: float) -> int:
    """Number out of 8 initial ring angles, float and ring at rest, from which the ring turns with the wave."""
    forcing = Forcing(0.1 * plant.excitation(np.array([3.14]))[:, 0], 3.14)
    count = 0
    for angle in np.arange(8) * np.pi / 4.0:
        x = np.zeros(14)
        x[2], x[7] = angle, flywheel
        ends = [float(np.real(flow(plant, x, 0.052, 3.5e-4, forcing, periods)[2])) for periods in (150, 170)]
        count += (ends[1] - ends[0]) / (40.0 * np.pi) > 0.5
    return count


def test_start_decides_over_lock(device: gy.Plant) -> None:
    """Trap 7: from rest nothing locks in a regular wave; with the flywheel at speed the damped device does."""
    speed = device.parameters.N * 3.14
    assert _locked_angles(device, 0.0) == 0
    assert _locked_angles(device, speed) == 8
    assert 0 < _locked_angles(gy.zhang2017(d1=0.0), speed) < 8
