"""The locked orbit and its multipliers: against balances, symmetry, plain simulation and the design's fold."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import gyroctl as gy
from gyroctl.harness.start import locked_start
from gyroctl.orbits.flow import Forcing, flow, flow_jacobian

WAVE = gy.Regular(height=0.2, wp=3.14)
CASES = [(0.02, 3.5e-4), (0.052, 3.5e-4), (0.052, 3e-3), (0.3, 4.5e-3), (0.104, 0.0)]


def forcing(plant: gy.Plant, wave: gy.Regular = WAVE) -> Forcing:
    he = plant.excitation(np.array([wave.wp]), wave.heading)[:, 0]
    return Forcing(0.5 * wave.height * he, wave.wp)


def over_a_period(orbit: gy.PeriodicOrbit, pieces: int = 64) -> NDArray[np.float64]:
    """States (pieces, n) at even instants of one period."""
    force = forcing(orbit.plant)
    states = [orbit.x]
    for i in range(1, pieces):
        states.append(flow(orbit.plant, orbit.x, orbit.cc, orbit.cg, force, i / pieces)[: orbit.x.size])
    return np.array(states)


@pytest.fixture(scope="module", params=CASES, ids=lambda case: f"cc={case[0]},cg={case[1]}")
def orbit(request: pytest.FixtureRequest, device: gy.Plant) -> gy.PeriodicOrbit:
    return gy.lock_orbit(device, WAVE, *request.param)


def test_orbit_closes_after_one_period(orbit: gy.PeriodicOrbit) -> None:
    """Turned by one turn, everything else as before: by the flow, not by Newton's own residual."""
    assert orbit.status in ("stable", "unstable")
    assert orbit.residual < 1e-10
    end = flow(orbit.plant, orbit.x, orbit.cc, orbit.cg, forcing(orbit.plant), 1.0)[:14]
    gap = end - orbit.x
    gap[2] -= 2 * math.pi
    gap[3] = 0.0  # omega is cyclic
    assert np.max(np.abs(gap) / np.maximum(np.abs(orbit.x), 1.0)) < 1e-9


def test_half_map_agrees_with_the_full_map(orbit: gy.PeriodicOrbit) -> None:
    assert orbit.error < 1e-8
    _, full = flow_jacobian(orbit.plant, orbit.x, orbit.cc, orbit.cg, forcing(orbit.plant), 1.0)
    keep = [i for i in range(14) if i != 3]
    multipliers = np.linalg.eigvals(full[np.ix_(keep, keep)])
    largest = np.sort(np.abs(multipliers))[::-1]
    np.testing.assert_allclose(np.abs(orbit.multipliers[:4]), largest[:4], rtol=1e-7)
    assert (orbit.status == "stable") == (largest[0] < 1.0)


def test_volume_shrinks_as_liouville_says(orbit: gy.PeriodicOrbit) -> None:
    """The determinant of the flow's Jacobian is exp of the integrated trace of the plant's: no shared derivative."""
    plant, force, pieces, span = orbit.plant, forcing(orbit.plant), 8, 1 / 16
    traces = []
    for i in range(pieces + 1):
        at = span * i / pieces
        x = flow(plant, orbit.x, orbit.cc, orbit.cg, force, at)[:14] if i else orbit.x
        moments = np.real(np.exp(2j * np.pi * at) * force.amplitude)
        traces.append(np.trace(plant.jacobians(x, (orbit.cc, orbit.cg), moments)[0]))
    simpson = (traces[0] + traces[-1] + 4 * sum(traces[1:-1:2]) + 2 * sum(traces[2:-1:2])) / (3 * pieces)
    _, jacobian = flow_jacobian(plant, orbit.x, orbit.cc, orbit.cg, force, span)
    sign, logarithm = np.linalg.slogdet(jacobian)
    assert sign > 0
    assert logarithm == pytest.approx(simpson * span * orbit.period, rel=1e-3)


def test_lock_balance(orbit: gy.PeriodicOrbit) -> None:
    """DESIGN: <u3> = -N cg/J4 within 2 %, and the flywheel at cc/(cc + cg) of the ring's gear."""
    p, x = orbit.plant.parameters, over_a_period(orbit)
    u3 = np.sin(x[:, 2]) * x[:, 4] + np.cos(x[:, 2]) * x[:, 5]
    load = p.N * orbit.cg / p.J4
    assert np.mean(u3) == pytest.approx(-load, rel=0.02, abs=1e-4)
    ratio = np.mean(x[:, 7]) / (p.N * WAVE.wp)
    assert ratio == pytest.approx(orbit.cc / (orbit.cc + orbit.cg), rel=0.005)
    assert np.mean(x[:, 6]) == pytest.approx(WAVE.wp, rel=1e-6)
    assert orbit.power == pytest.approx(orbit.cg * np.mean(x[:, 7] ** 2), rel=1e-5, abs=1e-12)


def test_load_angle_and_share_are_those_of_the_synchronous_machine(orbit: gy.PeriodicOrbit) -> None:
    """Im U = V sin(delta) is what the load takes; its share of V is the used lock capacity."""
    p, x = orbit.plant.parameters, over_a_period(orbit)
    U = np.mean(np.exp(1j * x[:, 2]) * (x[:, 4] + 1j * x[:, 5]))
    assert orbit.load_angle == pytest.approx(np.angle(U), abs=1e-3)
    assert orbit.lock_share == pytest.approx(p.N * orbit.cg / (p.J4 * abs(U)), rel=1e-3, abs=1e-12)
    assert math.sin(orbit.load_angle) == pytest.approx(-orbit.lock_share, rel=0.03, abs=2e-3)


def test_energy_of_a_closed_orbit_balances(device: gy.Plant) -> None:
    """Nothing is stored over a period: what the wave gives is radiated, lost in hinge and slip, or generated."""
    orbit = gy.lock_orbit(device, WAVE, 0.052, 3e-3)
    energy = flow(device, orbit.x, 0.052, 3e-3, forcing(device), 1.0)[14:]
    assert energy[0] == pytest.approx(np.sum(energy[1:]), rel=1e-6)
    assert orbit.power == pytest.approx(energy[4] / orbit.period, rel=1e-9)
    x = over_a_period(orbit)
    slip = x[:, 7] - device.parameters.N * x[:, 6]
    assert energy[3] / orbit.period == pytest.approx(0.052 * np.mean(slip**2), rel=1e-3)
    assert np.mean(slip) == pytest.approx(-device.parameters.N * WAVE.wp * 3e-3 / 0.055, rel=0.01)


# --- stability against plain simulation -------------------------------------------------------------------------


@pytest.mark.parametrize(("cc", "status"), [(0.02, "unstable"), (0.052, "stable"), (0.3, "stable")])
def test_disturbance_grows_as_the_largest_multiplier_says(device: gy.Plant, cc: float, status: str) -> None:
    orbit = gy.lock_orbit(device, WAVE, cc, 3.5e-4)
    assert orbit.status == status
    rate = abs(orbit.multipliers[0])
    disturbed = orbit.x.copy()
    disturbed[0] += 1e-6
    force, states = forcing(device), []
    x = disturbed
    for _ in range(14):
        for _ in range(10):
            x = flow(device, x, cc, 3.5e-4, force, 1.0)[:14]
            x[2] -= 2 * math.pi
        states.append(np.linalg.norm((x - orbit.x)[[0, 4, 6]]))
    # the envelope over the second hundred periods, where the fastest modes are gone
    growth = (max(states[9:14]) / max(states[4:9])) ** (1 / 50)
    assert growth == pytest.approx(rate, abs=3e-3)


def test_paper_plant_without_hinge_damping_is_unstable_in_lock_at_small_coupling() -> None:
    """Trap 5: without d1 a Neimark-Sacker pair near 1.2 rad/s grows; d1 = 2 holds it."""
    bare = gy.lock_orbit(gy.zhang2017(d1=0.0), WAVE, 0.104, 3.5e-4)
    assert bare.status == "unstable"
    assert "Neimark-Sacker" in bare.advice and "d1" in bare.advice
    pair = bare.multipliers[0]
    assert 1.0 < abs(pair) < 1.03
    # the multiplier of a mode at 1.2 rad/s turns by 1.2 T = 2.40 rad
    angle = abs(np.angle(pair)) / bare.period
    assert min(abs(angle - 1.2), abs(2 * np.pi / bare.period - angle - 1.2)) < 0.15
    assert gy.lock_orbit(gy.zhang2017(), WAVE, 0.104, 3.5e-4).status == "stable"


# --- the fold ----------------------------------------------------------------------------------------------------

# Deep water, lever inclined: computed once with Capytaine 3.0.0 (`solve` of gyroctl.hydrodynamics.bem, variant deep)
DEEP_HE = np.array([8.3728 + 656.6713j, 1977.9584 + 195.7797j])  # [Nm/m] at 3.14 rad/s
DEEP_RADIATION = (
    gy.Radiation((1424.10130, 4655.46392, 503.36763), (15.1277291, 98.5251284, 398.474171)),
    gy.Radiation((568.250190, 12775.0, 8.2e-5), (22.4827063, 147.106952, 485.998964)),
)


@dataclass(frozen=True)
class OneFrequency:
    """Excitation that is the same at all frequencies: enough for a regular wave."""

    he: tuple[complex, complex]
    sha256: str = "one frequency"
    omega: Any = field(default_factory=lambda: np.array([0.5, 8.0]), compare=False)

    def __call__(self, omega: ArrayLike, heading: float = 0.0) -> NDArray[np.complex128]:
        return np.outer(self.he, np.ones(np.size(omega)))


def last_with_orbit(plant: gy.Plant, cc: float, low: float, high: float, tolerance: float) -> float:
    """The fold by bisection over cg. [Nms]"""
    assert gy.lock_orbit(plant, WAVE, cc, low).status != "no orbit"
    assert gy.lock_orbit(plant, WAVE, cc, high).status == "no orbit"
    while high - low > tolerance:
        middle = 0.5 * (low + high)
        if gy.lock_orbit(plant, WAVE, cc, middle).status == "no orbit":
            high = middle
        else:
            low = middle
    return low


@pytest.mark.parametrize(("cc", "expected", "power"), [(0.02, 4.53e-3, 15.0), (0.3, 4.64e-3, 22.0)])
def test_fold_in_deep_water_is_the_designs(device: gy.Plant, cc: float, expected: float, power: float) -> None:
    """DESIGN section 3: 4.53e-3 (cc .02) ... 4.64e-3 (cc .3), 15-22 W there, with another mesh and another fit."""
    deep = device.replace(excitation=OneFrequency(tuple(DEEP_HE)), radiation=DEEP_RADIATION)
    fold = last_with_orbit(deep, cc, 4e-3, 5.2e-3, 1e-5)
    assert fold == pytest.approx(expected, rel=0.02)
    assert gy.lock_orbit(deep, WAVE, cc, fold).power == pytest.approx(power, rel=0.05)


def test_fold_is_where_the_lock_capacity_is_used_up(device: gy.Plant) -> None:
    """At the shipped 0.7 m of water: a multiplier reaches +1 and the whole of V is taken."""
    fold = last_with_orbit(device, 0.3, 4e-3, 6e-3, 2e-6)
    assert 4.9e-3 < fold < 5.4e-3
    orbit = gy.lock_orbit(device, WAVE, 0.3, fold)
    assert orbit.lock_share == pytest.approx(1.0, abs=0.02)
    assert orbit.load_angle == pytest.approx(-np.pi / 2, abs=0.25)
    nearest = orbit.multipliers[np.argmin(np.abs(orbit.multipliers - 1.0))]
    below = gy.lock_orbit(device, WAVE, 0.3, 0.9 * fold).multipliers
    assert abs(nearest - 1.0) < 0.5 * np.min(np.abs(below - 1.0))


@pytest.mark.parametrize(("factor", "keeps"), [(0.95, True), (1.05, False)])
def test_plain_simulation_keeps_lock_below_the_fold_and_loses_it_above(
    device: gy.Plant, factor: float, keeps: bool
) -> None:
    fold, x = 5.2e-3, gy.lock_orbit(device, WAVE, 0.3, 0.95 * 5.2e-3).x
    force = forcing(device)
    for _ in range(6):
        x = flow(device, x, 0.3, factor * fold, force, 25.0)[:14]
    turns = x[2] / (2 * np.pi)
    assert (abs(turns - 150) < 1.0) == keeps


@pytest.mark.parametrize(
    ("wave", "cc", "cg"), [(WAVE, 0.3, 8e-3), (WAVE, 0.052, 0.02), (gy.Regular(0.01, 3.14), 0.052, 1e-3)]
)
def test_without_an_orbit_the_status_says_so_and_what_to_do(
    device: gy.Plant, wave: gy.Regular, cc: float, cg: float
) -> None:
    orbit = gy.lock_orbit(device, wave, cc, cg)
    assert orbit.status == "no orbit"
    assert "cg" in orbit.advice and "wave height" in orbit.advice
    assert np.all(np.isnan(orbit.x)) and np.isnan(orbit.power)
    assert orbit.period == pytest.approx(2 * np.pi / wave.wp)


# --- senses and plants -------------------------------------------------------------------------------------------


def test_other_sense_locks_where_the_excitation_is_mirrored(device: gy.Plant) -> None:
    """phi1 -> -phi1 with psi -> -psi: the same power and multipliers."""
    he = device.excitation(np.array([WAVE.wp]))[:, 0]
    mirrored = device.replace(excitation=OneFrequency((-he[0], he[1])))
    one = gy.lock_orbit(device, WAVE, 0.052, 1e-3)
    other = gy.lock_orbit(mirrored, WAVE, 0.052, 1e-3, sense=-1)
    assert other.status == one.status == "stable"
    assert other.power == pytest.approx(one.power, rel=1e-9)
    np.testing.assert_allclose(np.abs(other.multipliers), np.abs(one.multipliers), rtol=1e-5, atol=1e-9)
    assert other.x[6] == pytest.approx(-one.x[6], rel=1e-8)
    assert other.x[0] == pytest.approx(-one.x[0], rel=1e-8)
    assert other.x[1] == pytest.approx(one.x[1], rel=1e-8)


def test_the_phase_of_the_excitation_picks_the_sense(device: gy.Plant, printed: gy.Plant) -> None:
    """Trap 4: with the true phases only psi' > 0 locks; with one phase common to both moments either does."""
    assert gy.lock_orbit(device, WAVE, 0.052, 3.5e-4, sense=1).status == "stable"
    assert gy.lock_orbit(device, WAVE, 0.052, 3.5e-4, sense=-1).status == "no orbit"
    flat = gy.zhang2017(excitation_phase="magnitude")
    assert all(gy.lock_orbit(flat, WAVE, 0.052, 3.5e-4, sense=s).status != "no orbit" for s in (1, -1))


def test_rigid_connection_locks_too_and_is_the_limit_of_a_stiff_coupling(device: gy.Plant) -> None:
    rigid = gy.lock_orbit(device.replace(connection="rigid"), WAVE, 0.0, 1e-3)
    assert rigid.status == "stable" and rigid.residual < 1e-10 and rigid.error < 1e-8
    p = device.parameters
    assert rigid.x[7] == pytest.approx(p.N * rigid.x[6], rel=1e-9)
    stiff = gy.lock_orbit(device, WAVE, 2.0, 1e-3)
    assert stiff.power == pytest.approx(rigid.power, rel=2e-3)
    assert rigid.multipliers.size == 12  # neither omega nor its rate is free


def test_orbit_does_not_depend_on_the_step_or_the_guess(device: gy.Plant) -> None:
    one = gy.lock_orbit(device, WAVE, 0.052, 1e-3)
    fine = gy.lock_orbit(device, WAVE, 0.052, 1e-3, dt=0.005)
    again = gy.lock_orbit(device, WAVE, 0.052, 1e-3, guess=one.x * 1.01)
    assert fine.power == pytest.approx(one.power, rel=1e-6)
    np.testing.assert_allclose(again.x[:2], one.x[:2], rtol=1e-8)


def test_locked_start_is_the_orbit_of_the_equivalent_regular_wave(device: gy.Plant) -> None:
    """Amplitude Hs/(2 sqrt 2): the start of every run, common to all laws."""
    x, controls = locked_start(device, gy.SeaState())
    orbit = gy.lock_orbit(device, gy.Regular(0.283 / math.sqrt(2.0), 3.14), *controls)
    np.testing.assert_allclose(x, orbit.x, rtol=1e-12, atol=1e-14)  # it ships as another processor may have found it
    assert orbit.status == "stable"


def test_locked_start_names_the_sea_where_there_is_no_lock(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match=r"sea\.hs = 0\.01.*locked orbit.*Raise Hs"):
        locked_start(device, gy.SeaState(hs=0.01))


@dataclass(frozen=True)
class AnyWave:
    """A regular wave without the checks of `gyroctl.Regular`."""

    height: float = 0.2
    wp: float = 3.14
    heading: float = 0.0


@pytest.mark.parametrize(
    ("field", "wave", "controls", "sense"),
    [
        ("height", AnyWave(height=0.0), (0.05, 1e-3), 1),
        ("height", AnyWave(height=math.nan), (0.05, 1e-3), 1),
        ("wp", AnyWave(wp=-3.14), (0.05, 1e-3), 1),
        ("cc", AnyWave(), (-0.05, 1e-3), 1),
        ("cg", AnyWave(), (0.05, math.nan), 1),
        ("cg", AnyWave(), (0.05, math.inf), 1),
        ("sense", AnyWave(), (0.05, 1e-3), 0),
    ],
)
def test_bad_request_is_named(
    device: gy.Plant, field: str, wave: AnyWave, controls: tuple[float, float], sense: int
) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.lock_orbit(device, wave, *controls, sense=sense)
    assert caught.value.field == field
    assert caught.value.mend


def test_wave_outside_the_excitation_table_is_no_still_water(device: gy.Plant) -> None:
    """The table is zero beyond its band: an orbit search there must not look like a weak wave."""
    with pytest.raises(gy.InputError, match="wp"):
        gy.lock_orbit(device, gy.Regular(0.2, 40.0), 0.05, 1e-4)
