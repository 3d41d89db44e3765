"""The shipped gain-scheduled laws: the table and its interpolation, what they measure, their loops."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers import gain_scheduled
from gyroctl.controllers.gain_scheduled.cell import Filters, frozen
from gyroctl.controllers.gain_scheduled.margins import CHANNELS, cell_loop
from gyroctl.controllers.gain_scheduled.scheduled import POINT, ROW, SIGNALS, Scheduled, ScheduledState, _locate, _mix
from gyroctl.controllers.gain_scheduled.table import law_of, read_table, row_of, table_file
from gyroctl.harness.for_device import InModelScale
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.loop_margins.closed_loop_orbit import close_loop
from gyroctl.plant.measurement import read
from gyroctl.plant.readings import unread
from gyroctl.robustness.regime import settle

NAMES = ("scheduled_lqr", "scheduled_lmi")


@pytest.fixture(scope="module", params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def content(name: str) -> dict[str, Any]:
    return read_table(table_file(name))


@pytest.fixture(scope="module")
def law(name: str) -> Scheduled:
    built: Scheduled = getattr(gain_scheduled, name)()
    return built


def measured(seed: int = 0) -> Measurement:
    rng = np.random.default_rng(seed)
    return Measurement(*(rng.normal([1.0, 3.1, 68.0, 0.0, 0.0, 0.0, 0.0], [1.0, 0.3, 3.0, 0.1, 0.1, 0.3, 0.3])))


def state_at(envelope: float, frequency: float, bandwidth: float) -> ScheduledState:
    """State with which a measurement of no motion leaves the schedule at the given place."""
    law = Scheduled((1.0,), (1.0,), (1.0,), (0.0,) * ROW)
    keep = math.exp(-law.period / law.slow)
    memory = math.exp(-law.period / law.memory)
    brisk = envelope / math.exp(-law.period / law.brisk)
    square = 1.0
    new_square = square * memory + (1.0 - memory) * envelope**2
    return ScheduledState(
        U1=envelope / keep,
        U3=0.0,
        V1=brisk,
        V3=0.0,
        W1=0.0,
        W3=0.0,
        speed=frequency,
        slow_square=((1.0 - bandwidth) * new_square - (1.0 - memory) * envelope**2) / memory,
        square=square,
        turning=frequency,
        weight=1.0,
        phi_c=0.0,
        phi_s=0.0,
        rate_c=0.0,
        rate_s=0.0,
        clamped=0.0,
        begun=1.0,
        seen=unread(),
    )


def still(frequency: float) -> Measurement:
    return Measurement(0.3, frequency, 68.0, 0.0, 0.0, 0.0, 0.0)


# --- the table and its interpolation -----------------------------------------------------------------------------


def test_interpolation_is_that_of_scipy(law: Scheduled) -> None:
    from scipy.interpolate import RegularGridInterpolator

    grid = (law.envelopes, law.frequencies, law.bandwidths)
    table = np.reshape(law.cells, (*(len(axis) for axis in grid), ROW))
    oracle = RegularGridInterpolator(grid, table)
    rng = np.random.default_rng(1)
    for _ in range(200):
        at = [rng.uniform(axis[0], axis[-1]) for axis in grid]
        (i, a, _), (j, b, _), (k, d, _) = (_locate(axis, value) for axis, value in zip(grid, at, strict=True))
        across = ROW * len(law.bandwidths)
        here = (across * (i * len(law.frequencies) + j) + ROW * k, across * len(law.frequencies), across, ROW)
        found = [_mix(law.cells, here, (a, b, d), entry) for entry in range(ROW)]
        np.testing.assert_allclose(found, oracle(at)[0], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_command_has_no_jump_at_the_border_of_a_cell(law: Scheduled, axis: int) -> None:
    """Across every inner node and both edges: the change is of the size of the step, not of the table."""
    wide = law._replace(cc_min=0.0, cc_max=1.0, cg_max=1.0)
    nodes = (law.envelopes, law.frequencies, law.bandwidths)
    centre = [0.5 * (axis_nodes[0] + axis_nodes[1]) for axis_nodes in nodes]
    for border in nodes[axis]:
        commands = []
        for off in (-1e-7, 1e-7):
            at = list(centre)
            at[axis] = border + off
            command, _ = wide.step(10.0, still(at[1]), state_at(*at))
            commands.append(command)
        np.testing.assert_allclose(commands[0], commands[1], atol=1e-5, rtol=0)


def test_command_follows_the_table_from_cell_to_cell(law: Scheduled) -> None:
    """The test of the jump would pass with a constant: the command does change with each of the three."""
    wide = law._replace(cc_min=0.0, cc_max=1.0, cg_max=1.0)
    nodes = (law.envelopes, law.frequencies, law.bandwidths)
    for axis in range(3):
        ends = []
        for end in (0, -1):
            at = [0.5 * (one[0] + one[1]) for one in nodes]
            at[axis] = nodes[axis][end]
            ends.append(wide.step(10.0, still(at[1]), state_at(*at))[0][1])
        assert abs(ends[0] - ends[1]) > 2e-5


def test_outside_the_table_the_edge_is_taken_and_counted(law: Scheduled) -> None:
    inside = [0.5 * (one[0] + one[1]) for one in (law.envelopes, law.frequencies, law.bandwidths)]
    state = state_at(*inside)
    _, after = law.step(10.0, still(inside[1]), state)
    assert law.clamped(after) == 0
    for axis, nodes in enumerate((law.envelopes, law.frequencies, law.bandwidths)):
        for value in (nodes[0] - 0.02, nodes[-1] + 0.02):
            at = list(inside)
            at[axis] = value
            count = state_at(*at)
            for expected in (1, 2):
                _, after = law.step(10.0, still(at[1]), count)
                assert law.clamped(after) == expected
                count = state_at(*at)._replace(clamped=after.clamped)
    assert law._replace(counting=0.0).step(0.0, still(9.0), state_at(0.1, 9.0, 0.5))[1].clamped == 0.0


def test_beyond_an_edge_the_gains_no_longer_change(law: Scheduled) -> None:
    wide = law._replace(cc_min=0.0, cc_max=1.0, cg_max=1.0)
    edge = law.bandwidths[-1]
    commands = [wide.step(10.0, still(3.1), state_at(0.1, 3.1, edge + more))[0] for more in (0.0, 0.05, 0.1)]
    np.testing.assert_allclose(commands[1], commands[0], rtol=1e-9)
    np.testing.assert_allclose(commands[2], commands[0], rtol=1e-9)


def test_a_table_of_one_cell_never_moves_nor_counts() -> None:
    law = frozen([0.06, 0.5, 0.9, -0.4, 0.0, 0.0, 0.97, *[0.0] * 20], Filters(), 3.14)
    state = law.init()
    for k in range(50):
        command, state = law.step(0.1 * k, measured(k), state)
        assert command[0] == 0.06 and law.clamped(state) == 0


def test_compiled_and_plain_law_agree_to_the_last_bit(device: gy.Plant, law: Scheduled) -> None:
    """With tables as tuples and as arrays."""
    assert compile_law(law) is not None
    waves = lead_in(gy.realise(device, gy.SeaState(gamma=5.0), 100000, 130.0), Settings())
    arrays = law._replace(cells=np.array(law.cells), envelopes=np.array(law.envelopes))  # type: ignore[arg-type]
    records = [
        run_law(device, one, waves, Settings(), compiled=compiled)[0]
        for one, compiled in ((law, True), (law, False), (arrays, True))
    ]
    for other in records[1:]:
        np.testing.assert_array_equal(records[0].states, other.states)
    assert np.ptp(records[0].commands[:, 0]) > 1e-3 and np.ptp(records[0].commands[:, 1]) > 1e-4


def test_compiler_refuses_what_is_no_table(law: Scheduled) -> None:
    for wrong in (np.ones((2, 2)), np.ones(3, int), ("a", "b"), None):
        assert compile_law(law._replace(cells=wrong)) is None  # type: ignore[arg-type]


def test_content_of_the_table_is_part_of_a_stored_result(law: Scheduled, name: str) -> None:
    again = law_of(read_table(table_file(name)), cc_min=law.cc_min, cc_max=law.cc_max)
    assert law_fingerprint(law) == law_fingerprint(again) != ""
    changed = (*law.cells[:-1], law.cells[-1] + 1e-9)
    assert law_fingerprint(law._replace(cells=changed)) != law_fingerprint(law)
    first = law._replace(cells=np.array(law.cells))  # type: ignore[arg-type]
    second = law._replace(cells=np.array(changed))  # type: ignore[arg-type]
    assert law_fingerprint(first) != law_fingerprint(second)


def test_table_says_what_it_is(content: dict[str, Any], law: Scheduled) -> None:
    assert len(content["cells"]) == len(law.envelopes) * len(law.frequencies) * len(law.bandwidths)
    assert {"law", "command", "plant", "method", "demand", "shares"} <= content["provenance"].keys()
    assert {"envelope", "point.cc", "margins.*.delay"} <= content["units"].keys()
    assert len(law.cells) == ROW * len(content["cells"]) and len(content["cells"][0]["cc"]) == len(SIGNALS)
    order = [(c["envelope"], c["frequency"], c["bandwidth"]) for c in content["cells"]]
    assert order == list(itertools.product(law.envelopes, law.frequencies, law.bandwidths))
    first = law.cells[:ROW]
    assert first[0] == content["cells"][0]["point"]["cc"]
    assert first[len(POINT) + 2] == content["cells"][0]["cc"]["speed"]


def test_every_cell_has_the_demanded_margins(content: dict[str, Any]) -> None:
    demand = content["provenance"]["demand"]
    for one in content["cells"]:
        assert set(one["margins"]) == set(CHANNELS)
        assert 0.0 < one["share_of_fold"] < 1.0
        for channel, found in one["margins"].items():
            low, high = found["gain"]
            assert high >= demand["gain"] and low <= 1.0 / demand["gain"]
            assert found["phase"] >= demand["phase"]
            if channel != "controls":
                assert found["delay"] >= demand["delay"] and found["disk"] >= demand["disk"]


def test_missing_or_broken_table_says_what_to_run(tmp_path: Any) -> None:
    with pytest.raises(gy.InputError, match=r"python -m gyroctl\.controllers\.gain_scheduled\.design"):
        read_table(tmp_path / "none.toml")
    short = tmp_path / "short.toml"
    short.write_text("[nodes]\nenvelope = [1.0]\nfrequency = [1.0]\nbandwidth = [0.1, 0.2]\n")
    with pytest.raises(gy.InputError, match="0 cells for 2 nodes"):
        read_table(short)


# --- what the law measures ---------------------------------------------------------------------------------------


def test_bandwidth_tells_the_seas_apart(device: gy.Plant, law: Scheduled) -> None:
    """Plain run of the law's filters over the course of each sea."""
    medians = []
    for gamma in (1.0, 5.0, 50.0):
        waves = lead_in(gy.realise(device, gy.SeaState(gamma=gamma), 100001, 700.0), Settings())
        record, _ = run_law(device, law, waves, Settings())
        state, found = law.init(), []
        for k, x in enumerate(record.states[:-1]):
            _, state = law.step(0.1 * k, Measurement(*read(x)), state)
            found.append(1.0 - state.slow_square / state.square)
        medians.append(float(np.median(found[2000:])))
    assert medians[0] > medians[1] + 0.04 > medians[2] + 0.12


# --- the loops ----------------------------------------------------------------------------------------------------


def test_live_schedule_is_stable_as_the_frozen_one(device: gy.Plant, law: Scheduled, content: dict[str, Any]) -> None:
    """Frozen, the derivative of the table is left out; here it is in the loop. A regular wave has no bandwidth."""
    for one in (content["cells"][12], content["cells"][21]):
        loop = close_loop(device, gy.Regular(one["wave_height"], one["frequency"]), law._replace(counting=0.0))
        assert loop.status == "stable"
        assert abs(loop.multipliers[0]) < 0.995


def test_count_of_samples_outside_leaves_the_loop_its_margins(device: gy.Plant, law: Scheduled) -> None:
    """A regular wave has no bandwidth, so that every sample is outside the table: the law runs on the same orbit."""
    wave = gy.Regular(0.2, 3.14)
    counted, wrapped = (close_loop(device, wave, one) for one in (law, InModelScale(law, law.init(), 1.0, 1.0, 0.1)))
    assert counted.status == wrapped.status == "stable"
    without = close_loop(device, wave, law._replace(counting=0.0))
    np.testing.assert_array_equal(counted.multipliers, without.multipliers)
    regime = settle(gy.lock_orbit(device, wave, 0.052, 3.5e-4), wave, law)
    assert counted.power == pytest.approx(regime.power, rel=1e-3), "where the law goes by itself"


def test_margins_of_the_table_are_those_of_the_loop(device: gy.Plant, content: dict[str, Any]) -> None:
    from gyroctl.loop_margins.margins import channel_margins

    one = content["cells"][13]
    loop = cell_loop(device, one["wave_height"], one["frequency"], row_of(one), Filters(**content["filters"]))
    for channel in ("cg", "psi"):
        found, told = channel_margins(loop, channel), one["margins"][channel]
        np.testing.assert_allclose(found.gain, told["gain"], rtol=1e-3)
        assert found.phase == pytest.approx(told["phase"], rel=1e-3)
        assert found.disk == pytest.approx(told["disk"], rel=1e-2)


def test_both_laws_beat_the_best_constant_pair(device: gy.Plant, law: Scheduled) -> None:
    """On two tuning seeds of gamma 5: a smoke test, no claim."""
    best = gy.law("best_constant")
    powers = []
    for one in (law, best):
        runs = [gy.simulate(device, one, gy.realise(device, gy.SeaState(), seed, 400.0)) for seed in (100000, 100001)]
        late = [run.power.sel(time=slice(100.0, None)).mean() for run in runs]
        powers.append(float(np.mean(late)))
    assert powers[0] > 1.3 * powers[1]
