"""Branches of locked orbits, their special points and the curves of these: against plain nonlinear simulation."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from test_orbit import DEEP_HE, DEEP_RADIATION, OneFrequency

import gyroctl as gy
from gyroctl.linearisation import PeriodicOrbit, lock_orbit
from gyroctl.orbits import Branch, Palc, SpecialPoint, continue_orbit, critical_damping, curve, lock_map, tongue
from gyroctl.orbits.flow import flow

WAVE = gy.Regular(height=0.2, wp=3.14)
SEED = 20240229
POINTS = 12


@lru_cache(maxsize=32)
def branch_of(parameter: str, low: float, high: float) -> Branch:
    return continue_orbit(lock_orbit(gy.zhang2017(), WAVE, 0.1, 1e-3), parameter, (low, high))


# --- branches ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameter", "low", "high"),
    [
        ("cg", 0.0, 8e-3),
        ("cc", 0.01, 0.3),
        ("height", 0.03, 0.3),
        ("wp", 2.6, 3.8),
        ("d1", 0.0, 4.0),
        ("k1", 100.0, 200.0),
        ("N", 18.0, 28.0),
        ("phase", 0.0, 3.0),
    ],
)
def test_points_of_a_branch_are_locked_orbits(device: gy.Plant, parameter: str, low: float, high: float) -> None:
    """Each is found again by `lock_orbit` on the device and wave that the point stands for."""
    branch = branch_of(parameter, low, high)
    assert np.all((branch.values >= low - 1e-12) & (branch.values <= high + 1e-12))
    for index in np.linspace(0, branch.values.size - 1, 5).round().astype(int):
        orbit = branch.orbit(int(index))
        again = lock_orbit(orbit.plant, orbit.wave, orbit.cc, orbit.cg, guess=orbit.x)
        np.testing.assert_allclose(again.x, orbit.x, rtol=1e-6, atol=1e-7)
        assert orbit.residual < 1e-8
        assert again.power == pytest.approx(branch.power[index], rel=1e-7, abs=1e-9)
        assert abs(again.multipliers[0]) == pytest.approx(abs(branch.multipliers[index, 0]), abs=1e-6)
        assert (again.status == "stable") == branch.stable[index]


def test_branch_goes_through_the_fold_and_back(device: gy.Plant) -> None:
    branch = branch_of("cg", 0.0, 8e-3)
    (fold,) = branch.folds
    assert np.max(branch.values) <= fold.value + 1e-12
    assert branch.values[0] == pytest.approx(0.0, abs=1e-12) == pytest.approx(branch.values[-1], abs=1e-12)
    before, after = np.argmax(branch.values), np.argmax(branch.values) + 1
    assert np.all(branch.stable[: before - 1]) and not np.any(branch.stable[after + 1 :])
    assert fold.error < 1e-6 and fold.orbit.lock_share == pytest.approx(1.0, abs=0.03)
    assert lock_orbit(device, WAVE, 0.1, 0.999 * fold.value, nearest=False).status == "stable"
    assert lock_orbit(device, WAVE, 0.1, 1.001 * fold.value, nearest=False).status == "no orbit"


def test_lock_balance_along_the_branch() -> None:
    """<u3> = -N cg/J4 within 2 %, on the stable and on the unstable side."""
    branch = branch_of("cg", 0.0, 8e-3)
    for index in range(0, branch.values.size, 9):
        orbit = branch.orbit(index)
        x, p = orbit.states(48), orbit.plant.parameters
        u3 = np.mean(np.sin(x[:, 2]) * x[:, 4] + np.cos(x[:, 2]) * x[:, 5])
        assert u3 == pytest.approx(-p.N * orbit.cg / p.J4, rel=0.02, abs=1e-4)
        assert np.mean(x[:, 7]) / (p.N * WAVE.wp) == pytest.approx(orbit.cc / (orbit.cc + orbit.cg), rel=0.005)


def test_whole_period_finds_the_same_points() -> None:
    """The half map is a short cut: without it the same fold and pair."""
    half = branch_of("cg", 0.0, 8e-3)
    orbit = lock_orbit(gy.zhang2017(), WAVE, 0.1, 1e-3)
    whole = continue_orbit(orbit, "cg", (0.0, 8e-3), Palc(symmetric=False))
    assert [p.kind for p in whole.points] == [p.kind for p in half.points] == ["fold"]
    assert whole.points[0].value == pytest.approx(half.points[0].value, rel=1e-9)


def test_other_sense_is_followed_too() -> None:
    he = gy.zhang2017().excitation(np.array([3.14]))[:, 0]
    mirrored = gy.zhang2017().replace(excitation=OneFrequency((-he[0], he[1])))
    branch = continue_orbit(lock_orbit(mirrored, WAVE, 0.1, 1e-3, sense=-1), "cg", (0.0, 8e-3))
    assert branch.folds[0].value == pytest.approx(branch_of("cg", 0.0, 8e-3).folds[0].value, rel=1e-8)


@pytest.mark.parametrize(("cc", "expected"), [(0.02, 4.53e-3), (0.3, 4.64e-3)])
def test_fold_in_deep_water_is_the_designs(device: gy.Plant, cc: float, expected: float) -> None:
    deep = device.replace(excitation=OneFrequency(tuple(DEEP_HE)), radiation=DEEP_RADIATION)
    branch = continue_orbit(lock_orbit(deep, WAVE, cc, 1e-3), "cg", (0.0, 8e-3))
    assert branch.folds[0].value == pytest.approx(expected, rel=0.02)


def test_pair_without_hinge_damping_is_the_designs(device: gy.Plant) -> None:
    """Trap 5: it turns at about 1.2 rad/s, and the damping that the lock needs is below d1 = 2 at cc = 0.052."""
    orbit = lock_orbit(device, WAVE, 0.052, 3.5e-4)
    (pair,) = continue_orbit(orbit, "d1", (0.0, 4.0)).points
    assert pair.kind == "Neimark-Sacker" and 0.0 < pair.value < 2.0
    assert pair.frequency == pytest.approx(1.2, abs=0.05)
    assert pair.error < 1e-8


# --- twelve points at random, against the nonlinear simulation ---------------------------------------------------


def random_points() -> list[tuple[float, float, float]]:
    """(cc, share of the fold, height)"""
    rng = np.random.default_rng(SEED)
    return [
        (float(rng.uniform(0.06, 0.28)), float(rng.uniform(0.05, 0.9)), float(rng.uniform(0.12, 0.3)))
        for _ in range(POINTS)
    ]


def last_locked(orbit: PeriodicOrbit, first: float, last: float, steps: int) -> tuple[float, float]:
    """Raise cg step by step in plain simulation; return the last value that kept lock and the first that did not."""
    x, force = orbit.x, orbit.forcing
    kept = orbit.cg
    for cg in np.linspace(first, last, steps):
        for _ in range(6):
            x = flow(orbit.plant, x, orbit.cc, float(cg), force, 25.0)[: x.size]
            x[2] -= 2 * math.pi * 25.0
            x[3] = 0.0
        if abs(x[2] - orbit.x[2]) > 2.5:
            return kept, float(cg)
        kept = float(cg)
    return kept, math.inf


@pytest.mark.slow
@pytest.mark.parametrize(("cc", "share", "height"), random_points())
def test_predicted_fold_is_where_the_simulation_loses_lock(
    device: gy.Plant, cc: float, share: float, height: float
) -> None:
    orbit = lock_orbit(device, gy.Regular(height, 3.14), cc, 1e-3 * height / 0.2)
    fold = continue_orbit(orbit, "cg", (0.0, 0.05 * height)).folds[0]
    start = lock_orbit(device, gy.Regular(height, 3.14), cc, 0.96 * fold.value)
    kept, lost = last_locked(start, 0.965 * fold.value, 1.02 * fold.value, 23)
    assert kept > 0.99 * fold.value
    assert lost < 1.01 * fold.value


def growth(orbit: PeriodicOrbit, periods: int = 160) -> float:
    """Growth rate [1/s] of phi1 in the nonlinear simulation after a kick of 1e-5 rad."""
    x, y = orbit.x.copy(), orbit.x + 1e-5 * np.real(orbit.mode("horizontal").shape / orbit.mode("horizontal").shape[0])
    series = []
    for i in range(periods):
        x, y = (flow(orbit.plant, z, orbit.cc, orbit.cg, orbit.forcing, 1.0)[: z.size] for z in (x, y))
        if i >= 20:
            series.append(y[0] - x[0])
    d = np.array(series)
    coefficients, *_ = np.linalg.lstsq(np.stack([d[1:-1], d[:-2]], axis=1), d[2:], rcond=None)
    return float(np.log(np.max(np.abs(np.roots([1.0, *-coefficients]))))) / orbit.period


@pytest.mark.slow
@pytest.mark.parametrize(("cc", "share", "height"), random_points())
def test_predicted_pair_is_where_the_simulation_begins_to_grow(
    device: gy.Plant, cc: float, share: float, height: float
) -> None:
    """Along d1: growth rates match the multipliers within 5 %, and their zero is the Neimark-Sacker point."""
    wave = gy.Regular(height, 3.14)
    fold = continue_orbit(lock_orbit(device, wave, cc, 1e-3 * height / 0.2), "cg", (0.0, 0.05 * height)).folds[0]
    orbit = lock_orbit(device, wave, cc, share * fold.value)
    (pair,) = (p for p in continue_orbit(orbit, "d1", (0.0, 4.0)).points if p.kind == "Neimark-Sacker")
    rates, dampings = [], [0.7 * pair.value, 1.3 * pair.value]
    for d1 in dampings:
        near = lock_orbit(device.replace(d1=d1), wave, cc, share * fold.value, guess=pair.orbit.x)
        rates.append(growth(near))
        assert rates[-1] == pytest.approx(near.mode("horizontal").rate, rel=0.05)
    assert rates[0] > 0.0 > rates[1]
    zero = dampings[0] + (dampings[1] - dampings[0]) * rates[0] / (rates[0] - rates[1])
    assert zero == pytest.approx(pair.value, rel=0.05)


# --- curves ------------------------------------------------------------------------------------------------------


def special(branch: Branch, kind: str) -> SpecialPoint:
    return next(point for point in branch.points if point.kind == kind)


def test_fold_curve_passes_through_folds_found_alone(device: gy.Plant) -> None:
    found = curve(special(branch_of("cg", 0.0, 8e-3), "fold"), "cc", (0.06, 0.15))
    assert found.ends == ("limit", "limit") and np.max(found.error) < 1e-6
    for index in (0, found.first.size // 3, -1):
        cc = float(found.second[index])
        alone = continue_orbit(lock_orbit(device, WAVE, cc, 1e-3), "cg", (0.0, 8e-3)).folds[0].value
        assert found.first[index] == pytest.approx(alone, rel=1e-8)
    orbit = found.orbit(2)
    assert orbit.cg == pytest.approx(found.first[2]) and orbit.cc == pytest.approx(found.second[2])
    assert orbit.power == pytest.approx(found.power[2], rel=1e-8)


def test_pair_curve_passes_through_pairs_found_alone(device: gy.Plant) -> None:
    found = curve(special(branch_of("cc", 0.01, 0.3), "Neimark-Sacker"), "cg", (0.0, 4e-3), first_limits=(0.02, 0.3))
    assert np.max(found.error) < 1e-8
    assert np.all(np.abs(found.frequency - 1.2) < 0.05)
    for cg in (5e-4, 3e-3):
        (cc,) = found.first_at(cg)
        alone = continue_orbit(lock_orbit(device, WAVE, 0.06, cg), "cc", (0.02, 0.3)).points
        assert cc == pytest.approx(next(p.value for p in alone if p.kind == "Neimark-Sacker"), rel=2e-3)


def test_critical_damping_falls_with_the_coupling(device: gy.Plant) -> None:
    found = critical_damping(device, WAVE, 1e-3, (0.02, 0.3))
    order = np.argsort(found.second)
    assert np.all(np.diff(found.first[order]) < 0.0)
    (needed,) = found.first_at(0.1)
    assert lock_orbit(device.replace(d1=1.05 * needed), WAVE, 0.1, 1e-3).status == "stable"
    assert lock_orbit(device.replace(d1=0.95 * needed), WAVE, 0.1, 1e-3).status == "unstable"


def test_tongue_is_the_least_height_with_an_orbit(device: gy.Plant) -> None:
    found = tongue(device, WAVE, 0.1, 1e-3, (2.8, 3.5))
    assert found.parameters == ("height", "wp")
    for wp in (2.9, 3.4):
        height = float(np.min(found.first_at(wp)))
        for factor, exists in ((0.98, False), (1.02, True)):
            orbit = lock_orbit(device, gy.Regular(factor * height, wp), 0.1, 1e-3, nearest=False)
            assert (orbit.status != "no orbit") == exists


@pytest.mark.slow
def test_lock_map_holds_against_orbits_found_alone(device: gy.Plant) -> None:
    found = lock_map(device, WAVE)
    np.testing.assert_allclose(np.sort(found.fold.second)[[0, -1]], [0.01, 0.3])
    (pairs,) = found.neimark_sacker
    assert np.min(pairs.first) >= 0.01 - 1e-12 and np.max(np.diff(np.sort(pairs.second))) < 1e-3
    rng = np.random.default_rng(SEED)
    for _ in range(10):
        cc, share = float(np.exp(rng.uniform(np.log(0.011), np.log(0.29)))), float(rng.uniform(0.05, 1.1))
        cg = share * found.largest_cg(cc)
        orbit = lock_orbit(device, WAVE, cc, cg, nearest=False)
        if abs(share - 1.0) > 5e-3:
            assert (orbit.status != "no orbit") == (share < 1.0)
        border = pairs.first_at(cg)
        if share < 0.9 and border.size and abs(cc / np.max(border) - 1.0) > 0.02:
            assert (orbit.status == "stable") == (cc > np.max(border))
        if share < 0.95:
            power = found.power(np.array([cc]), np.array([share]))[0, 0]
            assert power == pytest.approx(orbit.power, rel=0.1)


# --- bad requests ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameter", "limits", "field"),
    [
        ("J14", (0.1, 0.5), "parameter"),
        ("cg", (2e-3, 5e-3), "limits"),
        ("cg", (-1e-3, 5e-3), "limits"),
        ("height", (0.0, 0.3), "limits"),
        ("cc", (0.05, math.nan), "limits"),
        ("wp", (1e-3, 4.0), "limits"),
        ("N", (0.5, 30.0), "limits"),
    ],
)
def test_bad_request_is_named(device: gy.Plant, parameter: str, limits: tuple[float, float], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        continue_orbit(lock_orbit(device, WAVE, 0.1, 1e-3), parameter, limits)
    assert caught.value.field == field and caught.value.mend


def test_nothing_to_continue_without_an_orbit(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match="nothing to continue"):
        continue_orbit(lock_orbit(device, WAVE, 0.1, 0.02, nearest=False), "cg", (0.0, 0.05))
    with pytest.raises(gy.InputError, match=r"cc = \(0\.3, 0\.01\)"):
        lock_map(device, WAVE, cc=(0.3, 0.01))
