"""A year at a site by hand: sea states with known power, hours and scale."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.studies.site import Bin, Scatter, site_request
from gyroctl.studies.site.annual import Scale, Still, annual, in_cell, standing_still
from gyroctl.studies.site.cells import Scaled, cell_of
from gyroctl.studies.site.report import remarks, resource
from gyroctl.studies.site.runs import LawRuns
from gyroctl.studies.site.scatter import YEAR
from gyroctl.waves.energy import energy_flux, wave_power

HOURS, FLUX = np.array([2000.0, 500.0]), np.array([10.0, 40.0])


def runs(power: list[list[float]], **other) -> LawRuns:
    values = np.array(power)
    fields = {
        "locked": np.ones(values.shape, bool),
        "in_step": np.ones(values.shape, bool),
        "reversals": np.zeros(values.shape),
        "motion": np.full(values.shape, 0.2),
        "failed": np.zeros(values.shape, bool),
    }
    return LawRuns(values, **(fields | {name: np.array(value) for name, value in other.items()}))


LAW = runs(
    [[1.0, 2.0, 3.0, 2.0], [8.0, 8.0, 0.0, 8.0]],
    locked=[[True] * 4, [True, True, False, True]],
    in_step=[[True, False, True, True], [False] * 4],
    reversals=[[0.0, 0.0, 4.0, 0.0], [0.0] * 4],
    motion=[[0.2] * 4, [0.2, 0.2, 0.2, 0.5]],
)
PAIR = runs([[1.0, 1.0, 1.0, 1.0], [2.0, 2.0, 2.0, 2.0]])
LAWS = {"law": LAW, "site": PAIR, "seas": PAIR}


def test_energy_and_hours_of_a_year_by_hand():
    found = annual(LAWS, HOURS, FLUX, Scale(1.0, 0.5, 500.0, 0.35), "site", "seas")["law"]
    assert found.energy.value == pytest.approx((2000.0 * 2.0 + 500.0 * 6.0) / 1e3)  # kWh
    assert found.energy_of_plant == found.energy
    assert found.energy_if_lost == pytest.approx(7.0)
    assert found.mean_power == pytest.approx(7000.0 / 8766.0)
    assert found.capture_ratio == pytest.approx(7000.0 / (0.5 * (2000.0 * 10.0 + 500.0 * 40.0)))
    assert found.ratio_to_site.value == pytest.approx(7000.0 / 3000.0)
    assert found.out_of_step.value == pytest.approx(2000.0 / 4.0 + 500.0)
    assert found.out_of_lock.value == pytest.approx(500.0 / 4.0)
    assert found.reversing.value == pytest.approx(2000.0 / 4.0)
    assert found.reversals == pytest.approx(2000.0 * 1.0 * 3600.0 / 500.0)  # one in 500 s in the mean
    assert found.over_motion == pytest.approx(500.0 / 4.0)
    sums = np.array([2000.0 + 4000.0, 4000.0 + 4000.0, 6000.0, 4000.0 + 4000.0]) / 1e3
    half = 3.182446 * sums.std(ddof=1) / 2.0  # Student's t of 4 realisations
    assert found.energy.low <= found.energy.value - half and found.energy.high >= found.energy.value + half


def test_time_in_which_the_device_stands_still_is_out_of_step_for_sure_and_its_waves_are_counted():
    scale, args = Scale(1.0, 0.5, 500.0, 0.35), ("site", "seas")
    without = annual(LAWS, HOURS, FLUX, scale, *args)["law"]
    found = annual(LAWS, HOURS, FLUX, scale, *args, Still(700.0, 5000.0))["law"]
    assert found.energy == without.energy and found.reversing == without.reversing
    assert found.out_of_step[:3] == pytest.approx([end + 700.0 for end in without.out_of_step[:3]])
    assert found.out_of_lock[:3] == pytest.approx([end + 700.0 for end in without.out_of_lock[:3]])
    assert found.capture_ratio == pytest.approx(7000.0 / (0.5 * (20000.0 + 20000.0 + 5000.0)))
    still = standing_still()
    assert still.lock[:3] == (0.0, 0.0, 0.0) and still.power.value == 0.0 and still.capture_ratio == 0.0


def test_a_run_that_loses_lock_may_be_worth_nothing():
    half = runs([[1.0, 1.0], [4.0, 2.0]], locked=[[True, True], [True, False]])
    found = annual({"law": half, "site": half, "seas": half}, HOURS, FLUX, Scale(1.0, 0.5, 500.0, 0.35), "site", "seas")
    assert found["law"].energy_if_lost == pytest.approx((2000.0 + 500.0 * 2.0) / 1e3)


def test_froude_scale_turns_power_by_three_and_a_half_and_time_by_the_root():
    one, twenty = (
        annual(LAWS, HOURS, FLUX * length**2.5, Scale(length, 0.5, 500.0, 0.35), "site", "seas")["law"]
        for length in (1.0, 20.0)
    )
    assert twenty.energy.value == pytest.approx(one.energy.value * 20.0**3.5)
    assert twenty.energy_of_plant.value == pytest.approx(one.energy.value)
    assert twenty.capture_ratio == pytest.approx(one.capture_ratio)
    assert twenty.ratio_to_site == pytest.approx(one.ratio_to_site)
    assert twenty.out_of_step == one.out_of_step
    assert twenty.reversals == pytest.approx(one.reversals / math.sqrt(20.0))


def test_a_cell_by_hand():
    found = in_cell(LAW, 1, 40.0, Scale(2.0, 0.5, 500.0, 0.35))
    assert found.power.value == 6.0 and found.power_at_site.value == pytest.approx(6.0 * 2.0**3.5)
    assert found.capture_width.value == pytest.approx(6.0 * 2.0**3.5 / 40.0)
    assert found.capture_ratio == pytest.approx(found.capture_width.value / (0.5 * 2.0))
    assert found.lock.value == 0.75 and found.in_step.value == 0.0 and found.over_motion == 0.25
    assert found.lock.low == pytest.approx(0.3006, abs=1e-3)  # Wilson, 3 of 4


def test_a_failed_run_leaves_its_realisation_out_of_the_sums_and_out_of_no_share():
    broken = runs(
        [[1.0, np.nan, 3.0, 2.0, 2.0], [8.0] * 5],
        failed=[[False, True, False, False, False], [False] * 5],
        locked=[[True, False, True, True, True], [True] * 5],
        in_step=[[True, False, True, True, True], [True] * 5],
        reversals=[[0.0, np.nan, 0.0, 0.0, 0.0], [0.0] * 5],
    )
    laws = {"law": broken, "site": broken, "seas": broken}
    found = annual(laws, HOURS, FLUX, Scale(1.0, 0.5, 500.0, 0.35), "site", "seas")["law"]
    assert found.energy.value == pytest.approx((2000.0 * 2.0 + 500.0 * 8.0) / 1e3) and "1 of 5" in found.energy.note
    assert found.out_of_step.value == pytest.approx(400.0) and found.failed == 1
    assert in_cell(broken, 0, 10.0, Scale(1.0, 0.5, 500.0, 0.35)).failed == 1


def test_energy_flux_has_its_limits_in_deep_and_in_shallow_water():
    sea = gy.SeaState(2.0, 2.0 * math.pi / 8.0, 1.0)
    te = 8.0 * 1.25**-0.25 * math.gamma(1.25)
    deep = 1000.0 * 9.81**2 * 2.0**2 * te / (64.0 * math.pi)
    assert energy_flux(sea) == pytest.approx(deep, rel=1e-5)
    assert energy_flux(sea, 1000.0) == pytest.approx(deep, rel=1e-4)
    slow = gy.SeaState(0.01, 0.02, 5.0)
    assert energy_flux(slow, 0.5) == pytest.approx(1000.0 * 9.81 * 0.01**2 / 16.0 * math.sqrt(9.81 * 0.5), rel=1e-3)


def test_energy_flux_is_that_of_the_realised_waves(device: gy.Plant):
    sea = gy.SeaState(0.2, 3.0, 3.3)
    of_waves = wave_power(gy.waves.prepare(device, sea), device.depth)
    assert energy_flux(sea, device.depth) == pytest.approx(of_waves, rel=5e-3)


def scaled(**other) -> Scaled:
    return Scaled(
        **({"kind": "Tp", "gamma": 1.0, "scale": 20.0, "depth": 14.0, "duration": 600.0, "rarest": 0.0} | other)
    )


def test_a_sea_state_is_scaled_by_froude(device: gy.Plant):
    cell = cell_of(device, Bin(3.0, 8.4, 0.1), scaled())
    assert cell.state == "run" and cell.sea is not None
    assert cell.sea.hs == pytest.approx(0.15) and cell.sea.wp == pytest.approx(2.0 * math.pi / 8.4 * math.sqrt(20.0))
    assert cell.hours == pytest.approx(876.6)
    assert cell.flux == pytest.approx(energy_flux(cell.sea, 0.7) * 20.0**2.5, rel=1e-9)
    by_te = cell_of(device, Bin(3.0, 8.4, 0.1), scaled(kind="Te"))
    assert by_te.tp == pytest.approx(8.4 / 0.8572225)


@pytest.mark.parametrize(
    ("bin_", "other", "state", "word"),
    [
        (Bin(12.0, 6.0, 0.1), {}, "left out", "breaks"),
        (Bin(14.0, 8.0, 0.1), {"depth": 500.0}, "left out", "at the plant's scale"),
        (Bin(5.0, 8.0, 0.1), {"depth": 3.0}, "left out", "breaks"),
        (Bin(1.0, 1.0, 0.1), {}, "left out", ""),
        (Bin(0.05, 40.0, 0.1), {"scale": 1.0}, "left out", "not known at this frequency"),
        (Bin(0.0, 0.0, 0.1), {}, "calm", "no waves"),
        (Bin(3.0, 8.4, 1e-4), {"rarest": 1e-3}, "rare", "rarer"),
        (Bin(0.2, 5.0, 0.1), {}, "no lock", "locked orbit"),
    ],
)
def test_what_is_not_run_is_named(device: gy.Plant, bin_: Bin, other, state, word):
    cell = cell_of(device, bin_, scaled(**other))
    assert cell.state == state and word in cell.why
    assert cell.counted == (state in ("calm", "no lock"))


def test_shares_of_what_is_left_out_add_up(device: gy.Plant, tmp_path):
    bins = (Bin(0.0, 0.0, 0.1), Bin(3.0, 8.4, 0.5), Bin(12.0, 6.0, 0.3))
    ask = site_request(Scatter(bins, "Tp", missing=0.1), tmp_path, plant=device, scale=20.0)
    cells = [cell_of(device, one, scaled()) for one in bins]
    found = resource(ask, cells)
    assert sum(part["share"] for part in found["parts"].values()) == pytest.approx(0.9)
    assert sum(part["hours"] for part in found["parts"].values()) == pytest.approx(0.9 * YEAR)
    assert sum(part["energy_share"] for part in found["parts"].values()) == pytest.approx(1.0)
    out = found["parts"]["left out"]
    assert out["sea_states"] == 1 and out["energy_share"] == pytest.approx(
        0.3 * cells[2].flux / (0.3 * cells[2].flux + 0.5 * cells[1].flux)
    )


def test_named_laws_are_built_for_the_device_of_the_site(device: gy.Plant, tmp_path):
    scatter, mine = Scatter((Bin(3.0, 8.4, 1.0),), "Tp"), device.replace(J14=0.5 * device.parameters.J14)
    usual, own = gy.law("coupling"), gy.law("coupling", device=mine)
    assert usual != own
    for laws in ("coupling", ["coupling"], {"coupling": "coupling"}):
        assert site_request(scatter, tmp_path, laws, plant=mine).laws["coupling"] == own
        assert site_request(scatter, tmp_path, laws, plant=device).laws["coupling"] == usual
    assert (
        site_request(scatter, tmp_path, {"coupling": usual}, plant=mine).laws["coupling"] == usual
    )  # built by the user
    assert site_request(scatter, tmp_path, {"a": "coupling", "b": usual}, plant=mine).foreign == ("a",)
    assert site_request(scatter, tmp_path, "coupling", plant=mine).foreign == ("coupling",)
    for known in (device, gy.zhang2017("realistic")):
        assert site_request(scatter, tmp_path, "coupling", plant=known).foreign == ()
    told = remarks(site_request(scatter, tmp_path, {"a": "coupling"}, plant=mine), [], {})
    assert "tuned for another device: a" in told
    with pytest.raises(gy.InputError, match=r"3 times as long as Table 1.*model"):
        site_request(scatter, tmp_path, plant=device.replace(length_scale=3.0))


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"scale": 0.0}, "scale"),
        ({"scale": math.nan}, "scale"),
        ({"depth": -1.0}, "depth"),
        ({"depth": math.nan}, "depth"),
        ({"gamma": 0.5}, "gamma"),
        ({"duration": 105.0}, "run.duration"),
        ({"seeds": ("100001",)}, "seeds"),
        ({"seeds": ("coupling=1:3",)}, "seeds"),
        ({"laws": "nosuch"}, "law"),
        ({"laws": "coupling,coupling"}, "laws"),
        ({"laws": {"best_constant": "coupling"}}, "laws"),
        ({"laws": {"site_constant": "coupling"}}, "laws"),
        ({"rarest": 2.0}, "rarest"),
        ({"workers": -1}, "workers"),
        ({"budget": math.inf}, "budget"),
    ],
)
def test_what_cannot_be_asked_is_refused_before_any_run(device: gy.Plant, tmp_path, given, field):
    scatter = Scatter((Bin(3.0, 8.4, 1.0),), "Tp")
    with pytest.raises(gy.InputError) as caught:
        site_request(scatter, tmp_path / "out", plant=device, **given)
    assert caught.value.field == field and not (tmp_path / "out").exists()
