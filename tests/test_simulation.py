"""Lock, cycle slips, metrics and trajectories on records made by hand; the design's ensembles as slow tests."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.run import run_law
from gyroctl.simulation import Record, cycle_slips, evaluate, loss_time, trajectory, wave_phasor
from gyroctl.simulation.lock import load_share
from gyroctl.simulation.metrics import UNITS
from gyroctl.simulation.progress import Progress, track

Array = NDArray[np.float64]
WP, DT = 3.14, 0.1
TIME: Array = np.arange(4001, dtype=np.float64) * DT


# --- lock --------------------------------------------------------------------------------------------------------


def ring(speed: Callable[[Array], Array]) -> Array:
    """Angle of a ring with the given speed [rad/s], exact where the speed is constant over each sample."""
    return np.concatenate([[0.0], np.cumsum(speed(np.asarray(TIME[:-1] + DT / 2, np.float64)) * DT)])


def test_steady_ring_keeps_lock() -> None:
    assert np.isnan(loss_time(ring(lambda t: np.full_like(t, WP)), DT, WP))


def test_stall_is_lost_when_the_ten_second_mean_falls_below_half() -> None:
    """The ring stops at 100 s: half of the last ten seconds is still at full speed until 105 s."""
    assert loss_time(ring(lambda t: np.where(t < 100.0, WP, 0.0)), DT, WP) == pytest.approx(105.1, abs=0.11)


@pytest.mark.parametrize(("factor", "lost"), [(0.51, False), (0.49, True), (0.0, True), (-1.0, True)])
def test_slow_ring_is_lost_at_the_first_window(factor: float, lost: bool) -> None:
    found = loss_time(ring(lambda t: np.full_like(t, factor * WP)), DT, WP)
    assert np.isnan(found) != lost
    if lost:
        assert found == pytest.approx(10.0)


def test_relocking_does_not_undo_the_loss() -> None:
    found = loss_time(ring(lambda t: np.where((t > 200.0) & (t < 220.0), 0.0, WP)), DT, WP)
    assert found == pytest.approx(205.1, abs=0.11)


def test_swing_within_the_cycle_is_no_loss() -> None:
    """DESIGN: the ring speed may swing by .8 rad/s, and even stand still for four seconds, without losing lock."""
    assert np.isnan(loss_time(ring(lambda t: WP + 2.0 * np.sin(2 * WP * t)), DT, WP))
    assert np.isnan(loss_time(ring(lambda t: np.where((t > 50.0) & (t < 54.0), 0.0, WP)), DT, WP))


def test_run_that_is_not_finite_counts_as_lost_from_there() -> None:
    psi = ring(lambda t: np.full_like(t, WP))
    psi[500:] = np.nan
    assert loss_time(psi, DT, WP) == pytest.approx(50.0, abs=0.11)
    psi[500:] = np.inf
    assert np.isnan(loss_time(psi[:500], DT, WP))


def test_both_senses_of_rotation_and_several_runs_at_once() -> None:
    good, bad = ring(lambda t: np.full_like(t, WP)), ring(lambda t: np.where(t < 30.0, WP, 0.0))
    found = loss_time(np.stack([good, bad, -good], axis=1), DT, WP)
    assert found.shape == (3,)
    np.testing.assert_allclose(found, [np.nan, 35.1, 10.0], atol=0.11)
    assert np.isnan(loss_time(-good, DT, WP, sense=-1))
    assert loss_time(good, DT, WP, sense=-1) == pytest.approx(10.0)


def test_run_shorter_than_the_window_is_not_judged() -> None:
    assert np.isnan(loss_time(np.zeros(50), DT, WP))


@given(start=st.floats(20.0, 350.0), speed=st.floats(-5.0, 5.0))
@settings(max_examples=50, deadline=None)
def test_loss_is_that_of_the_plain_definition(start: float, speed: float) -> None:
    psi = ring(lambda t: np.where(t < start, WP, speed))
    slow = [t for t in range(100, psi.size) if (psi[t] - psi[t - 100]) / 10.0 < 0.5 * WP]
    expected = slow[0] * DT if slow else math.nan
    np.testing.assert_allclose(loss_time(psi, DT, WP), expected, atol=1e-9)


# --- cycle slips -------------------------------------------------------------------------------------------------

PHASOR = 100.0 * np.exp(1j * WP * TIME)


def step(at: float, turns: float, width: float = 8.0) -> Array:
    """A smooth change of the ring angle by whole or broken turns. [rad]"""
    return np.asarray(2 * np.pi * turns / (1.0 + np.exp(-(TIME - at) / width * 4.0)))


@pytest.mark.parametrize(
    ("offset", "expected"),
    [
        (0.0 * TIME, 0),
        (step(200.0, -1), 1),
        (step(200.0, 1), 1),
        (step(200.0, -3, 40.0), 3),
        (step(200.0, -1, 2.0), 1),  # within one wave, as after pull-out
        (step(200.0, -1, 40.0), 1),
        (step(100.0, -1, 3.0) + step(110.0, -1, 3.0) + step(120.0, -1, 3.0), 3),
        (step(100.0, -1) + step(300.0, 1), 2),
        (2 * np.pi * 0.45 * np.sin(0.05 * TIME), 0),  # swings by less than half a turn to each side
        (step(200.0, 0.5), 0),
        (0.8 * np.sin(2 * WP * TIME), 0),  # what a law does inside the cycle
    ],
)
@pytest.mark.parametrize("sense", [1, -1])
def test_slips_are_counted_by_whole_turns(offset: Array, expected: int, sense: int) -> None:
    psi = sense * (WP * TIME + 0.7 + offset)
    assert cycle_slips(psi, PHASOR, DT, sense) == expected


def test_phase_jump_of_the_sea_in_a_lull_is_no_slip() -> None:
    """The wave dies away and comes back one turn later; the ring turned on by itself and lost nothing to it."""
    height = np.where((TIME > 198) & (TIME < 202), 0.01, 1.0)
    waves = 100.0 * height * np.exp(1j * (WP * TIME + 2 * np.pi * np.clip((TIME - 198) / 4, 0, 1)))
    assert cycle_slips(WP * TIME, waves, DT) == 0


def test_slips_of_a_run_are_the_turns_that_the_ring_falls_behind(device: gy.Plant) -> None:
    """A load too large for a regular wave: the ring slips again and again, and every turn is missing in the end."""
    wave = gy.Regular(0.2, 3.14)
    start = gy.lock_orbit(device, wave, 0.3, 5e-3).x
    waves = gy.realise(device, wave, 1, 200.0)
    record, _ = run_law(device, gy.law("constant", cc=0.3, cg=5.6e-3), waves, gy.Settings(), start=start)
    psi = record.states[:, 2]
    phasor = np.exp(1j * WP * np.arange(psi.size) * DT)
    missing = (WP * 200.0 - (psi[-1] - psi[0])) / (2 * np.pi)
    assert missing > 3.0
    assert cycle_slips(psi, phasor, DT) == pytest.approx(missing, abs=1.0)


def test_slips_end_where_the_run_is_no_longer_finite() -> None:
    psi = WP * TIME + step(100.0, -1)
    psi[2000:] = np.nan
    assert cycle_slips(psi, PHASOR, DT) == 1
    assert cycle_slips(psi[:50], PHASOR[:50], DT) == 0


def test_phasor_turns_with_the_waves() -> None:
    """A cosine in the band becomes its exponential; what lies outside the band goes."""
    periods = 4000 * DT * WP / (2 * np.pi)
    w = 2 * np.pi * round(periods) / (4000 * DT)
    t = TIME[:-1]
    found = wave_phasor(5.0 * np.cos(w * t + 0.3) + 2.0 * np.cos(3 * w * t) + 1.0, DT, WP)
    np.testing.assert_allclose(found, 5.0 * np.exp(1j * (w * t + 0.3)), atol=1e-9)


# --- load share --------------------------------------------------------------------------------------------------


def test_load_share_of_a_steady_lock() -> None:
    """phi rates that turn against the ring: exp(i psi)(phi1' + i phi3') = V exp(i delta) all the time."""
    psi = 0.4 + WP * TIME
    rate = 0.3 * np.exp(1j * (-psi - 0.5))
    capacity = 0.3671 / 22.5556
    share = load_share(psi, rate.real, rate.imag, np.full(TIME.size, 1e-3), DT, WP, capacity)
    np.testing.assert_allclose(share, 1e-3 / (capacity * 0.3), rtol=1e-9)
    doubled = load_share(psi, 2 * rate.real, 2 * rate.imag, np.full(TIME.size, 1e-3), DT, WP, capacity)
    np.testing.assert_allclose(doubled, share / 2)


def test_load_share_averages_over_one_wave() -> None:
    """Motion along one axis is half with the ring and half against it: V is half the amplitude."""
    psi = WP * TIME
    share = load_share(psi, 0.0 * psi, 0.3 * np.cos(psi), np.full(TIME.size, 1e-3), DT, WP, 1.0)
    np.testing.assert_allclose(share[200:], 1e-3 / 0.15, rtol=2e-2)


def test_load_share_of_the_locked_orbit_is_that_of_the_orbit(device: gy.Plant) -> None:
    wave = gy.Regular(0.2, 3.14)
    orbit = gy.lock_orbit(device, wave, 0.052, 3.5e-4)
    waves = gy.realise(device, wave, 1, 100.0)
    record, _ = run_law(device, gy.law("constant"), waves, gy.Settings(blend=0.0))
    x, p = record.states[:-1], device.parameters
    share = load_share(x[:, 2], x[:, 4], x[:, 5], record.controls[:, 1], DT, WP, p.J4 / p.N)
    assert np.mean(share[300:]) == pytest.approx(orbit.lock_share, rel=0.02)


# --- metrics -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def synthetic(device: gy.Plant) -> Record:
    """A record with motions of plain sines and a ledger that closes but for 12 J."""
    rng = np.random.default_rng(0)
    n = TIME.size
    states = np.zeros((n, 19))
    states[:, 0] = 0.10 * np.sin(1.2 * TIME)
    states[:, 1] = 0.25 * np.sin(WP * TIME)
    states[:, 2] = WP * TIME + step(300.0, -1)
    states[:, 4] = 0.12 * np.cos(1.2 * TIME)
    states[:, 5] = 0.25 * WP * np.cos(WP * TIME)
    states[:, 6] = WP
    states[:, 7] = 70.0 + 3.0 * np.sin(0.3 * TIME)
    controls = np.stack([np.full(n - 1, 0.05), rng.uniform(2e-4, 6e-4, n - 1)], axis=1)
    for column, power in enumerate((0.0, 9.0, 1.0, 0.5), start=14):
        states[:, column] = power * TIME
    generated = controls[:, 1] * (states[:-1, 7] ** 2 + states[1:, 7] ** 2) / 2 * DT
    states[1:, 18] = np.cumsum(generated)
    stored = device.stored_energy(states[:, :14].T)
    states[:, 14] = states[:, 15:].sum(axis=1) + stored - stored[0]
    states[-1, 14] += 12.0
    return Record(states, controls.copy(), controls, DT, 7)


@pytest.fixture(scope="module")
def values(device: gy.Plant, synthetic: Record) -> dict[str, float]:
    moment = 300.0 * np.cos(WP * np.arange(8001) * 0.05)
    return evaluate(device, synthetic, moment, 0.05, WP, 100.0, 20.0)


def test_every_metric_has_a_unit_and_a_number(values: dict[str, float]) -> None:
    assert set(values) == set(UNITS)
    assert all(math.isfinite(v) for name, v in values.items() if name != "loss_time")


def test_power_metrics_are_plain_integrals_of_the_scored_time(synthetic: Record, values: dict[str, float]) -> None:
    """cg omega'^2 with cg held over each sample: first and second moment by both ends of every interval."""
    W, cg = synthetic.states[1000:, 7], synthetic.controls[1000:, 1]
    begin, end = cg * W[:-1] ** 2, cg * W[1:] ** 2
    mean = float(np.mean((begin + end) / 2))
    assert values["generated_w"] == pytest.approx(mean, rel=1e-9)
    assert values["mean_power"] == pytest.approx(mean + values["stored_w"], rel=1e-9)
    deviation = math.sqrt(float(np.mean(((begin - mean) ** 2 + (end - mean) ** 2) / 2)))
    assert values["power_cv"] == pytest.approx(deviation / mean, rel=1e-6)
    assert values["p98_over_mean"] == pytest.approx(np.quantile(begin, 0.98) / mean, rel=1e-9)
    seconds = ((begin + end) / 2).reshape(-1, 10).mean(axis=1)
    assert values["power_cv_1s"] == pytest.approx(np.std(seconds) / mean, rel=1e-9)
    assert values["capture_width_ratio"] == pytest.approx(values["mean_power"] / 20.0, rel=1e-9)


def test_ledger_metrics(device: gy.Plant, synthetic: Record, values: dict[str, float]) -> None:
    assert values["radiated_w"] == pytest.approx(9.0)
    assert values["hinge_w"] == pytest.approx(1.0)
    assert values["slip_loss_w"] == pytest.approx(0.5)
    stored = device.stored_energy(synthetic.states[[1000, -1], :14].T)
    assert values["stored_w"] == pytest.approx((stored[1] - stored[0]) / 300.0, rel=1e-9)
    assert values["ledger_residual"] == pytest.approx(12.0 / synthetic.states[-1, 14], rel=1e-6)
    parts = sum(values[n] for n in ("radiated_w", "hinge_w", "slip_loss_w", "generated_w", "stored_w"))
    assert values["wave_input_w"] == pytest.approx(parts + 12.0 / 300.0, rel=1e-9)


def test_motion_metrics(values: dict[str, float]) -> None:
    """98 % of the modulus of a sine of amplitude A is A sin(0.98 pi/2)."""
    assert values["phi1_p98"] == pytest.approx(0.10 * math.sin(0.49 * math.pi), rel=2e-3)
    assert values["phi3_p98"] == pytest.approx(0.25 * math.sin(0.49 * math.pi), rel=2e-3)
    assert values["outside_model"] == 0.0


def test_lock_metrics(values: dict[str, float]) -> None:
    assert values["locked"] == 1.0 and math.isnan(values["loss_time"])
    assert values["cycle_slips"] == pytest.approx(1000.0 * 1 / (300.0 * WP / (2 * np.pi)), rel=1e-9)


def test_motion_beyond_0_3_rad_is_outside_the_model(device: gy.Plant, synthetic: Record) -> None:
    """Trap 6: said once it happens in the scored time, not before."""
    for sample, expected in ((2500, 1.0), (500, 0.0)):
        states = synthetic.states.copy()
        states[sample, 1] = -0.31
        record = Record(states, synthetic.commands, synthetic.controls, DT, 0)
        found = evaluate(device, record, np.ones(8001), 0.05, WP, 100.0, 20.0)
        assert found["outside_model"] == expected


def test_run_without_power_has_no_ratio_of_it(device: gy.Plant, synthetic: Record) -> None:
    states, controls = synthetic.states.copy(), synthetic.controls.copy()
    states[:, 18], controls[:, 1] = 0.0, 0.0
    record = Record(states, controls, controls, DT, 0)
    found = evaluate(device, record, np.ones(8001), 0.05, WP, 100.0, 20.0)
    assert found["generated_w"] == 0.0
    assert all(math.isnan(found[name]) for name in ("power_cv", "p98_over_mean", "power_cv_1s"))


def test_mean_power_of_a_run_is_the_trapezoid_of_its_power(device: gy.Plant) -> None:
    """DESIGN: electrical power by the trapezoid in time; the ledger's integral agrees to 1e-4."""
    waves = gy.realise(device, gy.SeaState(), 3, 600.0).blended(100.0)
    for name in ("constant", "load_angle"):
        record, _ = run_law(device, gy.law(name), waves, gy.Settings())
        found = evaluate(device, record, waves.moments[1], waves.dt, WP, 100.0, 1.0)
        W, cg = record.states[1000:, 7], record.controls[1000:, 1]
        trapezoid = np.mean(cg * (W[:-1] ** 2 + W[1:] ** 2) / 2)
        assert found["generated_w"] == pytest.approx(trapezoid, rel=1e-4)


# --- trajectory --------------------------------------------------------------------------------------------------


def test_trajectory_is_labelled_and_describes_itself(device: gy.Plant, synthetic: Record) -> None:
    signals = {"elevation": 0 * TIME, "Me1": 0 * TIME, "Me3": TIME}
    attributes = {"law": "constant", "parameters": {"cc": 0.05}, "seed": 3, "flag": True, "list": [1, 2]}
    ds = trajectory(device, synthetic, signals, attributes)
    assert ds.sizes == {"time": TIME.size}
    for label in (*device.labels, "cc", "cg", "cc_command", "power", "energy_slip", "elevation", "Me1", "Me3"):
        assert ds[label].attrs["units"] and ds[label].attrs["long_name"], label
    np.testing.assert_array_equal(ds.psi, synthetic.states[:, 2])
    np.testing.assert_array_equal(ds.power[:-1], synthetic.controls[:, 1] * synthetic.states[:-1, 7] ** 2)
    np.testing.assert_array_equal(ds.cg[-2:], synthetic.controls[-1, 1])
    assert ds.attrs["seed"] == 3 and json.loads(ds.attrs["parameters"]) == {"cc": 0.05}
    assert json.loads(ds.attrs["flag"]) is True


def test_trajectory_survives_a_file(device: gy.Plant, tmp_path: Any) -> None:
    import xarray as xr

    waves = gy.realise(device, gy.SeaState(), 3, 40.0)
    ds = gy.simulate(device, gy.law("load_angle"), waves, gy.Settings(blend=10.0))
    ds.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as again:
        assert again.equals(ds)
        assert again.attrs["sha256"] == waves.blended(10.0).sha256
        assert json.loads(again.attrs["parameters"])["cc"] == gy.law("load_angle").cc  # type: ignore[attr-defined]


def test_wave_signals_of_a_trajectory_are_those_that_acted(device: gy.Plant) -> None:
    """At the samples the moments are on the 0.05 s grid: no interpolation, and the blend is in them."""
    waves = gy.realise(device, gy.SeaState(), 3, 40.0)
    ds = gy.simulate(device, gy.law("constant"), waves, gy.Settings(blend=20.0))
    acting = waves.blended(20.0)
    np.testing.assert_allclose(ds.Me3, acting.moments[1, ::2], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(ds.elevation, acting.elevation[::2], rtol=1e-9, atol=1e-12)
    power = (ds.Me1 * ds.phi1_rate + ds.Me3 * ds.phi3_rate).values
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * 0.1)])
    np.testing.assert_allclose(ds.energy_wave_input, work, atol=0.02 * np.max(work))


# --- progress ----------------------------------------------------------------------------------------------------


def test_progress_is_silent_on_short_work_and_counts(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(track(range(5), "items", 5)) == [0, 1, 2, 3, 4]
    with Progress("runs", 3) as progress:
        progress.advance()
        progress.advance(2)
        assert progress.done == 3
    assert capsys.readouterr() == ("", "")


def test_progress_tells_the_time_left_once_the_work_takes_long(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a clock of its own: 10 items in 12 s leave 24 s for 20; what compiled before counts not."""
    now = [0.0]
    monkeypatch.setattr("gyroctl.simulation.progress.time.monotonic", lambda: now[0])
    with Progress("runs", 40) as progress, Progress("quiet", 40, quiet=True) as quiet:
        now[0] = 100.0
        progress.advance(10)
        quiet.advance(10)
        now[0] = 112.0
        progress.advance(10)
        quiet.advance(10)
    assert capsys.readouterr().err == "runs: 10 of 40, time left not known yet\nruns: 20 of 40, about 24 s left\n"


# --- the design's ensembles --------------------------------------------------------------------------------------

BARS = [
    # gamma, cc, cg, least share locked, most share locked, mean power of the locked [W]
    (5.0, 0.052, 3.5e-4, 0.85, 1.0, (1.6, 1.8)),
    (5.0, 0.052, 1.0e-3, 0.0, 0.2, None),
    (50.0, 0.052, 7.5e-4, 0.85, 1.0, (3.4, 3.7)),
    (1.0, 0.104, 1.5e-4, 0.9, 1.0, (0.6, 0.8)),
    (1.0, 0.104, 5.0e-4, 0.0, 0.25, None),
]


@pytest.mark.slow
@pytest.mark.parametrize(("gamma", "cc", "cg", "least", "most", "power"), BARS)
def test_reference_ensembles(
    device: gy.Plant, gamma: float, cc: float, cg: float, least: float, most: float, power: tuple[float, float] | None
) -> None:
    """DESIGN section 3: constant controls on the corrected plant, 64 realisations of 2000 s each."""
    run = gy.scan(device, gy.SeaState(gamma=gamma), [(cc, cg)], range(1, 65), workers=1, quiet=True)
    assert least <= run.locked.mean() <= most
    assert np.all(run.ledger_residual < 1e-6)
    if power is not None:
        assert power[0] <= run.mean_power[run.locked].mean() <= power[1]


@pytest.mark.slow
def test_larger_coupling_loses_lock_earlier(device: gy.Plant) -> None:
    """The paper's observation at gamma 5, here on 64 realisations: cc .052 against .156 at cg 3.5e-4."""
    run = gy.scan(device, gy.SeaState(), [(0.052, 3.5e-4), (0.156, 3.5e-4)], range(1, 65), workers=1, quiet=True)
    kept = run.locked.mean(axis=1)
    assert kept[0] > kept[1] + 0.2
    assert np.mean(run.wave_input_w[0]) == pytest.approx(16.7, rel=0.1)
