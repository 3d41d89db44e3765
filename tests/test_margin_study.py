"""Margins beyond the linear: against continuation, plain simulation, exact intervals and what cannot be otherwise."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.orbits.continuation import continue_orbit
from gyroctl.plant.equations import OMEGA_RATE, PSI
from gyroctl.robustness.headroom import headroom, ramp
from gyroctl.robustness.regime import Regime, judge, remembered, settle, simulate, steady
from gyroctl.robustness.shocks import basin_stability, disturbances, largest_shocks, smallest_shocks
from gyroctl.statistics import wilson
from gyroctl.studies.margins import find_orbit, lock_map_report, margin_report, request
from gyroctl.studies.margins.maps import GROWS, STABLE, coupling_map, plain, tongue_map
from gyroctl.studies.margins.measures import law_regime, linear_margins
from gyroctl.studies.margins.words import meanings

WAVE = gy.Regular(height=0.2, wp=3.14)


@pytest.fixture(scope="module")
def regime(device: gy.Plant) -> Regime:
    return settle(gy.lock_orbit(device, WAVE, 0.052, 3.5e-4), WAVE)


def test_regime_of_constant_controls_is_the_orbit(device: gy.Plant, regime: Regime) -> None:
    """The loop's own simulation, 200 waves on: same power and speed as the orbit found by Newton's method."""
    orbit = gy.lock_orbit(device, WAVE, 0.052, 3.5e-4)
    assert regime.power == pytest.approx(orbit.power, rel=1e-4)
    later = simulate(regime, regime.x, 1.0)
    turned = later.record[-1, PSI] - later.record[0, PSI]
    assert turned == pytest.approx(WAVE.wp * (later.record.shape[0] - 1) * 0.1, abs=0.05)


def test_compiled_and_plain_law_are_judged_alike(device: gy.Plant, regime: Regime) -> None:
    """The same starts, once through the compiled loop and once through Python: the same record to the last bit."""
    start = disturbances(regime, 0.5, 1, 7)[0]
    compiled = simulate(regime, start, 20.0)
    python = simulate(regime, start, 20.0, law=gy.law("constant", cc=0.052, cg=3.5e-4))
    np.testing.assert_array_equal(compiled.record, python.record)


def test_remembered_signals_are_those_of_the_wave_at_any_length(regime: Regime) -> None:
    asked: list[int] = []
    wave = steady(regime)
    again = remembered(lambda time: (asked.append(time.size), wave(time))[1])
    for count in (30, 70, 30, 70):
        time = 0.05 * np.arange(count)
        for found, meant in zip(again(time), wave(time), strict=True):
            np.testing.assert_array_equal(found, meant)
    assert asked == [30, 70]


def test_no_disturbance_is_no_loss_and_a_standing_flywheel_is(regime: Regime) -> None:
    undisturbed = judge(regime, regime.x[None, :])
    assert undisturbed.holds.all() and undisturbed.returns.all()
    stopped = regime.x.copy()
    stopped[OMEGA_RATE] = 0.0
    assert not judge(regime, stopped[None, :]).holds.any()


def test_turned_ring_returns_but_does_not_hold(regime: Regime) -> None:
    """A whole turn ahead is the same state of the device, but a turn was gained."""
    ahead = regime.x.copy()
    ahead[PSI] += 2.0 * math.pi
    outcome = judge(regime, ahead[None, :])
    assert outcome.returns.all() and not outcome.holds.any()


def test_smallest_shock_breaks_and_a_smaller_one_does_not(regime: Regime) -> None:
    shocks = smallest_shocks(regime, periods=60.0)
    assert {s.state for s in shocks} == set(largest_shocks(regime))
    breaking = [s for s in shocks if not math.isnan(s.size)]
    assert breaking, "a flywheel at half speed cannot be held by the wave"
    for shock in breaking:
        row = regime.plant.labels.index(shock.state)
        starts = np.repeat(regime.x[None, :], 2, axis=0)
        starts[0, row] += shock.sign * shock.size
        starts[1, row] += shock.sign * 0.97 * shock.size
        assert judge(regime, starts, 60.0).holds.tolist() == [False, True]


def test_heavier_load_leaves_a_smaller_basin(device: gy.Plant, regime: Regime) -> None:
    """Near the fold the saddle is close: fewer of the same disturbances return, beyond the intervals."""
    heavy = settle(gy.lock_orbit(device, WAVE, 0.052, 5e-3), WAVE)
    light = basin_stability(regime, 0.5, 64, seed=3, periods=60.0)
    loaded = basin_stability(heavy, 0.5, 64, seed=3, periods=60.0)
    assert loaded.high < light.low
    again = basin_stability(regime, 0.5, 64, seed=3, periods=60.0)
    assert again == light


@pytest.mark.parametrize(("successes", "runs", "low", "high"), [(0, 10, 0.0, 0.2775), (5, 10, 0.2366, 0.7634)])
def test_wilson_interval_against_published_values(successes: int, runs: int, low: float, high: float) -> None:
    """Wilson (1927); values of the table in Brown, Cai and DasGupta (2001)."""
    share = wilson(successes, runs)
    assert share.low == pytest.approx(low, abs=2e-4)
    assert share.high == pytest.approx(high, abs=2e-4)


@pytest.mark.parametrize(("quantity", "upwards", "limits"), [("cg", True, (0.0, 8e-3)), ("height", False, (0.05, 0.3))])
def test_headroom_is_the_fold_of_the_continuation(
    device: gy.Plant, quantity: Any, upwards: bool, limits: tuple[float, float]
) -> None:
    orbit = gy.lock_orbit(device, WAVE, 0.052, 2e-3)
    found = headroom(orbit, WAVE, quantity, upwards)
    folds = continue_orbit(orbit, quantity, limits).folds
    assert found.ending == "fold"
    assert found.limit == pytest.approx(folds[0].value, rel=3e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("height", "cc"), [(0.1, 0.06), (0.2, 0.1), (0.3, 0.05)])
def test_fold_is_confirmed_by_a_slow_ramp_of_the_nonlinear_loop(device: gy.Plant, height: float, cc: float) -> None:
    """Within one per cent, by plain simulation: no orbit, no multiplier."""
    wave = gy.Regular(height, 3.14)
    orbit = gy.lock_orbit(device, wave, cc, 4e-4)
    fold = headroom(orbit, wave, "cg", True).limit
    near = settle(gy.lock_orbit(device, wave, cc, 0.97 * fold), wave)
    lost = 0.97 * fold * ramp(near, "cg", 1.0, 1.06, periods=1200)
    assert lost == pytest.approx(fold, rel=0.01)


def test_height_headroom_is_confirmed_by_a_sinking_wave(device: gy.Plant) -> None:
    orbit = gy.lock_orbit(device, WAVE, 0.052, 2e-3)
    least = headroom(orbit, WAVE, "height", False).limit
    wave = gy.Regular(1.03 * least, 3.14)
    near = settle(gy.lock_orbit(device, wave, 0.052, 2e-3), wave)
    assert ramp(near, "height", 1.03 * least, 0.97 * least, periods=1200) == pytest.approx(least, rel=0.01)


def test_unstable_orbit_has_no_headroom(device: gy.Plant) -> None:
    orbit = gy.lock_orbit(device, WAVE, 0.02, 3.5e-4)
    assert orbit.status == "unstable"
    with pytest.raises(gy.InputError, match=r"unstable.*no headroom.*hinge damping"):
        headroom(orbit, WAVE, "cg", True)


def test_maps_agree_with_single_orbits(device: gy.Plant) -> None:
    found = coupling_map(device, WAVE, [0.02, 0.06, 0.2], [5e-4, 2e-3, 4e-3, 6e-3])
    assert found.code[0].tolist() == [GROWS, STABLE, STABLE]
    assert found.code[-1].tolist() == [0, 0, 0]
    orbit = gy.lock_orbit(device, WAVE, 0.06, 2e-3)
    assert found.power[1, 1] == pytest.approx(orbit.power, rel=1e-4)
    assert found.growth[1, 1] == pytest.approx(math.log(abs(orbit.multipliers[0])), rel=1e-3)
    assert np.all((found.border > 4e-3) & (found.border < 6e-3))
    assert found.border[1] == pytest.approx(headroom(orbit, WAVE, "cg", True).limit, rel=1e-3)


def test_tongue_needs_more_height_for_faster_waves(device: gy.Plant) -> None:
    found = tongue_map(device, 0.052, 3.5e-4, [3.14, 3.8, 4.4], [0.015, 0.05, 0.15, 0.4])
    assert np.all(np.diff(found.border) > 0.0)
    for wp, least in zip(found.first, found.border, strict=True):
        assert gy.lock_orbit(device, gy.Regular(1.01 * least, wp), 0.052, 3.5e-4).status == "stable"
        below = gy.lock_orbit(device, gy.Regular(0.99 * least, wp), 0.052, 3.5e-4, nearest=False)
        assert below.status != "stable"


def test_plain_numbers_for_json() -> None:
    values = {"a": np.array([1.0, np.nan]), "b": 1 + 2j, "c": (np.float64(np.inf), np.bool_(True)), "d": np.int64(3)}
    assert plain(values) == {"a": [1.0, None], "b": [1.0, 2.0], "c": [None, True], "d": 3}


@pytest.mark.parametrize(
    ("field", "arguments"),
    [
        ("height", (0.0, 3.14, 0.052, 3.5e-4)),
        ("height", (math.nan, 3.14, 0.052, 3.5e-4)),
        ("wp", (0.2, -1.0, 0.052, 3.5e-4)),
        ("wp", (0.2, 90.0, 0.052, 3.5e-4)),
        ("cc", (0.2, 3.14, 0.0, 3.5e-4)),
        ("cg", (0.2, 3.14, 0.052, -1e-4)),
        ("cg", (0.2, 3.14, 0.052, 0.0)),
    ],
)
def test_bad_request_names_field_value_and_mend(
    device: gy.Plant, field: str, arguments: tuple[float, float, float, float]
) -> None:
    with pytest.raises(gy.InputError) as caught:
        request(device, *arguments)
    assert caught.value.field == field and caught.value.mend


def test_no_orbit_says_the_nearest_height_that_has_one(device: gy.Plant, tmp_path: Path) -> None:
    asked = request(device, 0.01, 3.14, 0.052, 3.5e-4)
    with pytest.raises(gy.InputError, match=r"height = 0\.01: no locked orbit") as caught:
        margin_report(asked, tmp_path / "none", maps=False, quiet=True)
    assert not (tmp_path / "none").exists()
    nearest = gy.lock_orbit(device, asked.wave, asked.cc, asked.cg).nearest_height
    assert f"{nearest:.4g} m" in caught.value.mend
    assert find_orbit(request(device, 1.01 * nearest, 3.14, 0.052, 3.5e-4)).status == "stable"


def test_law_that_does_not_hold_lock_has_no_report(device: gy.Plant, tmp_path: Path) -> None:
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4, law_name="constant", parameters={"cg": 0.01})
    with pytest.raises(gy.InputError, match=r"law = 'constant'.*does not keep the lock"):
        margin_report(asked, tmp_path / "none", samples=4, maps=False, quiet=True)
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
def test_unstable_orbit_is_reported_and_never_as_a_margin(device: gy.Plant, tmp_path: Path) -> None:
    content = margin_report(request(device, 0.2, 3.14, 0.02, 3.5e-4), tmp_path, maps=False, quiet=True)
    assert content["orbit"]["status"] == "unstable"
    assert content["orbit"]["lock_reserve"] is None
    assert "constant_controls" not in content
    assert set(content["meaning"]) == {"stability"} and "UNSTABLE" in content["meaning"]["stability"]
    assert any("unstable" in missing["reason"] for missing in content["not_available"])


def test_law_that_cannot_be_differentiated_says_which_margins_are_missing(device: gy.Plant) -> None:
    asked = dataclasses.replace(request(device, 0.2, 3.14, 0.052, 3.5e-4), law_name="opaque", law=_Opaque())
    orbit = find_orbit(asked)
    answer = linear_margins(orbit, asked)
    assert answer.margins is None
    assert answer.record()["status"] == "not available"
    assert "derivative" in answer.unavailable
    assert "Gain, phase, delay and disk margins" in meanings(asked, orbit, None, answer)["loop_margins"]
    regime = law_regime(orbit, asked)  # what needs no derivative remains
    assert judge(regime, regime.x[None, :], 30.0).holds.all()


class _Opaque:
    """A law whose step leaves the numbers: it looks its gain up by text."""

    period = 0.1
    information = "sensors"

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
        return (0.06, float(f"{3e-4 + 1e-6 * float(y.psi_rate):.6e}")), state


@pytest.mark.slow
def test_report_of_a_law_with_maps(device: gy.Plant, tmp_path: Path) -> None:
    """Everything that the study promises, in JSON that other programs can read, and every picture."""
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4, law_name="load_angle")
    content = margin_report(asked, tmp_path, samples=16, quiet=True)
    written = json.loads((tmp_path / "margins.json").read_text(encoding="utf-8"))
    assert written == content
    assert set(content["figures"]) == {
        "multipliers.png",
        "linear_error.png",
        "nyquist.png",
        "robustness.png",
        "lock_map.png",
        "tongue.png",
        "heat_maps.png",
    }
    for name in content["figures"]:
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert content["not_available"] == []
    channel = content["law"]["linear"]["channels"]["cg"]
    low, high = channel["guaranteed_gain"]
    alpha = channel["disk_alpha"]
    assert high == pytest.approx((2.0 + alpha) / (2.0 - alpha)) and low == pytest.approx(1.0 / high)
    assert channel["gain"][1] is None or channel["gain"][1] >= high  # the disk is on the safe side
    kinds = {border["kind"] for border in content["maps"]["borders"]}
    assert kinds == {"fold", "Neimark-Sacker"}
    fold = next(border for border in content["maps"]["borders"] if border["kind"] == "fold")
    grid = content["maps"]["controls"]
    order = np.argsort(fold["x"])
    at = np.interp(grid["first"], np.array(fold["x"])[order], np.array(fold["y"])[order])
    np.testing.assert_allclose(np.array(grid["border"], float), at, rtol=2e-3)


@pytest.mark.parametrize("axes", [("cc", "cg"), ("wp", "height")])
@pytest.mark.slow
def test_lock_map_files(device: gy.Plant, tmp_path: Path, axes: tuple[str, str]) -> None:
    content = lock_map_report(request(device, 0.2, 3.14, 0.052, 3.5e-4), axes, tmp_path, quiet=True)
    assert content == json.loads((tmp_path / "lockmap.json").read_text(encoding="utf-8"))
    assert (tmp_path / "lockmap.png").read_bytes().startswith(b"\x89PNG")
    assert content["map"]["axes"] == list(axes)
    codes = np.array(content["map"]["code"])
    assert {0, 1, 2} == set(codes.ravel().tolist())


def test_unknown_axes_are_refused_before_anything_is_computed(device: gy.Plant, tmp_path: Path) -> None:
    with pytest.raises(gy.InputError, match=r"axes = 'cc,wp'.*cc,cg or wp,height"):
        lock_map_report(request(device, 0.2, 3.14, 0.052, 3.5e-4), ("cc", "wp"), tmp_path / "x", quiet=True)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["margins", "--height", "0.01"], "no locked orbit"),
        (["margins", "--height", "-1"], "height = -1.0"),
        (["margins", "--law", "nothing"], "unknown law"),
        (["lockmap", "--axes", "cc"], "axes = 'cc'"),
    ],
)
def test_command_line_refuses_with_exit_code_two(
    arguments: list[str], words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from gyroctl.cli import main

    monkeypatch.setattr("sys.argv", ["gyroctl", *arguments])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert words in capsys.readouterr().err


@pytest.mark.slow
def test_command_line_gives_json_in_a_pipe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from gyroctl.cli import main

    monkeypatch.setattr("sys.argv", ["gyroctl", "margins", "--no-maps", "--samples", "4", "--out", str(tmp_path)])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code in (None, 0)
    content = json.loads(capsys.readouterr().out)
    assert content["orbit"]["status"] == "stable"
    assert content["constant_controls"]["headroom"]["cg"]["ending"] == "fold"
