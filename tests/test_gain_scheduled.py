"""Gain-scheduled laws: the table and its interpolation, the linear models, both designs, and the cells' margins."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers import gain_scheduled
from gyroctl.controllers.gain_scheduled import design as designing
from gyroctl.controllers.gain_scheduled.cell import Cell, Filters, Node, frozen
from gyroctl.controllers.gain_scheduled.design import Design, between_nodes, build, design_lmi, design_lqr
from gyroctl.controllers.gain_scheduled.lyapunov import Wishes, cell_model, proven_decay, solve
from gyroctl.controllers.gain_scheduled.margins import CHANNELS, Demand, cell_loop, loop_of
from gyroctl.controllers.gain_scheduled.periodic_regulator import Weights, regulate
from gyroctl.controllers.gain_scheduled.scheduled import POINT, ROW, SIGNALS, Scheduled, ScheduledState, _locate, _mix
from gyroctl.controllers.gain_scheduled.table import law_of, read_table, row_of, table_file
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.linearisation.riccati import periodic_lyapunov
from gyroctl.loop_margins.closed_loop_orbit import close_loop
from gyroctl.plant.measurement import read

NAMES = ("scheduled_lqr", "scheduled_lmi")
MIDDLE = Node(0.15, 3.15, 0.5)


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


@pytest.fixture(scope="module")
def cell(device: gy.Plant) -> Cell:
    return build(device, Design(), MIDDLE, 0.55)


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


def test_schedule_of_a_regular_wave_is_its_envelope_and_frequency(device: gy.Plant, cell: Cell) -> None:
    loop = close_loop(device, gy.Regular(cell.height, 3.15), cell.loop.law, start=cell.orbit)
    s = loop.law_states[0]
    mean = np.mean([complex(one.U1, one.U3) for one in loop.law_states])  # the filter leaves a ripple of 3 %
    assert abs(mean) == pytest.approx(MIDDLE.envelope, rel=5e-3)
    assert s.turning / s.weight == pytest.approx(3.15, rel=5e-3)
    assert abs(1.0 - s.slow_square / s.square) < 0.06  # its ripple, again


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


# --- cells --------------------------------------------------------------------------------------------------------


def test_orbit_of_a_cell_has_its_envelope_and_share(device: gy.Plant, cell: Cell) -> None:
    """The envelope from the states on the orbit, not from the lock balance that found it."""
    x = cell.orbit.states(256)
    mean = abs(np.mean(np.exp(1j * x[:, 2]) * (x[:, 4] + 1j * x[:, 5])))
    assert mean == pytest.approx(MIDDLE.envelope, rel=1e-3)
    p = device.parameters
    assert cell.orbit.cg == pytest.approx(0.55 * p.J4 * MIDDLE.envelope / p.N)
    assert cell.orbit.cg < cell.fold and -0.5 * math.pi < cell.orbit.load_angle < 0.0


def test_linear_model_of_a_cell_is_that_of_plant_and_filters(cell: Cell) -> None:
    """Signals after a small disturbance of the nonlinear loop, over half a wave."""
    loop, flow = cell.loop, cell.loop.flow
    n, ns = flow.free.size, len(loop.law_states[0])
    rng = np.random.default_rng(2)
    kick = 1e-6 * rng.standard_normal(n)
    push = np.array([1e-6, 2e-8])
    x, state = loop.states[0] + flow.embedding @ kick, loop.law_states[0]
    z = np.concatenate([kick, np.zeros(ns + 2)])
    for k in range(flow.samples // 2):
        (cc, cg), new = loop.law.step(0.0, read(x), state)
        x = flow.advance(x, cc + push[0], cg + push[1], k)
        state = new
        z = cell.A[k] @ z + cell.B[k] @ push
    k = flow.samples // 2
    np.testing.assert_allclose((x - loop.states[k])[flow.free], z[:n], atol=1e-9)
    np.testing.assert_allclose(np.array(state) - np.array(loop.law_states[k]), z[n : n + ns], atol=1e-9)
    row = [*cell.point, *[0.0] * 20]
    for i in range(len(SIGNALS)):
        row[0], row[len(POINT) + i] = 100.0, 1.0
        probe = frozen(row, Filters(), 3.15, cc_max=1e3)._replace(period=flow.period)
        row[len(POINT) + i] = 0.0
        there = probe.step(0.0, read(x), state)[0][0]
        usual = probe.step(0.0, read(loop.states[k]), loop.law_states[k])[0][0]
        assert there - usual == pytest.approx(float(cell.C[k, i] @ z), rel=1e-3, abs=1e-9)


def test_no_orbit_no_cell(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match=r"V = 0\.15 rad/s.*Lower the share"):
        build(device, Design(), MIDDLE, 1.2)
    with pytest.raises(gy.InputError, match="Raise cc"):
        build(device, dataclasses.replace(Design(), cc=0.02), MIDDLE, 0.4)
    with pytest.raises(gy.InputError, match="bandwidths"):
        Design().decorrelation(0.8)


# --- the two designs ---------------------------------------------------------------------------------------------


def test_regulator_lies_between_open_loop_and_full_information(cell: Cell) -> None:
    found = regulate(cell, Weights())
    assert found.bound < found.cost < found.open_cost
    assert found.cost - found.bound < 0.5 * (found.open_cost - found.bound)


def test_regulator_is_a_minimum_of_its_cost(cell: Cell) -> None:
    """The cost anew, as a stationary variance; any other gains cost more, and the optimum is reached in the small."""
    from gyroctl.controllers.gain_scheduled.periodic_regulator import _costs

    weights = Weights()
    found = regulate(cell, weights)
    Q, R = _costs(cell, weights, 1.0)

    def cost(K: Any) -> float:
        closed = cell.A + cell.B @ K @ cell.C
        X = periodic_lyapunov(closed, cell.G @ cell.G.transpose(0, 2, 1))
        u = K @ cell.C
        return float(np.mean([np.trace((q + v.T @ R @ v) @ x) for q, v, x in zip(Q, u, X, strict=True)]))

    assert cost(found.gains) == pytest.approx(found.cost, rel=1e-9)
    assert cost(0.0 * found.gains) == pytest.approx(found.open_cost, rel=1e-9)
    rng = np.random.default_rng(3)
    for _ in range(12):
        other = found.gains * (1.0 + 0.3 * rng.standard_normal(found.gains.shape))
        assert cost(other) > found.cost * (1.0 - 1e-3)


def test_dearer_controls_give_smaller_gains(cell: Cell) -> None:
    gains = [np.linalg.norm(regulate(cell, Weights(), detuning).gains[1, :3]) for detuning in (1.0, 16.0)]
    assert gains[1] < 0.6 * gains[0]


@pytest.fixture(scope="module")
def cells(device: gy.Plant, cell: Cell) -> list[Cell]:
    others = ((Node(0.3, 3.15, 0.5), 0.55), (Node(0.15, 3.6, 0.3), 0.5))
    return [cell, *(build(device, Design(), node, share) for node, share in others)]


@pytest.mark.parametrize("rate", [math.inf, 0.05], ids=["one function", "bounded rate"])
def test_lyapunov_function_decreases_however_the_schedule_jumps(cells: list[Cell], rate: float) -> None:
    """Random jumps from cell to cell (slow ramps where the rate is bounded), integrated exactly."""
    from scipy.linalg import expm

    wishes = Wishes(rate=rate)
    beta = Design().decorrelation
    models = [cell_model(one, beta(one.node.bandwidth)) for one in cells]
    certificate = solve(models, wishes, [1.0] * 3, 0.3671 / 22.5556)
    bounded = rate if math.isfinite(rate) else 0.0
    for model, K in zip(models, certificate.gains, strict=True):
        closed = np.linalg.eigvals(model.A + model.B @ K)
        proven = proven_decay(model, K, certificate.Q0, certificate.Q1, bounded)
        assert proven >= 0.9 * wishes.swing_decay and np.max(closed.real) <= -proven + 1e-9
        assert abs(K[2:, :2]).max() < 1e-6 and abs(K[:2, 2:]).max() < 1e-6  # symmetry: no gains across the modes
    if bounded:
        assert np.abs(certificate.Q1).max() > 0.0
        return
    rng = np.random.default_rng(4)
    back = np.linalg.inv(certificate.Q0)
    x = rng.standard_normal(4)
    for _ in range(200):
        i = int(rng.integers(3))
        after = expm((models[i].A + models[i].B @ certificate.gains[i]) * rng.uniform(0.01, 2.0)) @ x
        assert after @ back @ after < x @ back @ x
        x = after / np.linalg.norm(after)


def test_too_fast_a_decay_has_no_lyapunov_function(cells: list[Cell]) -> None:
    model = cell_model(cells[0], 0.3)
    helpless = dataclasses.replace(model, B=0.0 * model.B)
    with pytest.raises(gy.InputError, match="slower decay"):
        solve([helpless], Wishes(decay=0.5), [1.0], 0.016)


def test_shipped_certificate_holds_at_a_node_built_anew(device: gy.Plant) -> None:
    """The function in the file against a model of today and the gains in the file."""
    content = read_table(table_file("scheduled_lmi"))
    Q0 = np.array(content["provenance"]["Q0"])
    assert content["provenance"]["proven_decay"] > 0.0 and content["provenance"]["proven_decay_between_nodes"] > 0.0
    for one in content["cells"][13:15]:
        node = Node(one["envelope"], one["frequency"], one["bandwidth"])
        built = build(device, Design(), node, one["point"]["share"])
        K = np.zeros((6, 4))
        for control, gains in enumerate((one["cc"], one["cg"])):
            K[control, :2] = gains["angle"], gains["speed"]
            for j, turned in enumerate(("cos", "sin")):
                K[2 + 2 * control + j, 2:] = gains[f"swing_{turned}"], gains[f"swing_rate_{turned}"]
        model = cell_model(built, Design().decorrelation(node.bandwidth))
        assert proven_decay(model, K, Q0, 0.0 * Q0, 0.0) == pytest.approx(one["notes"]["proven_decay"], abs=1e-3)


def single(**changes: Any) -> Design:
    node = {"envelopes": (0.15,), "frequencies": (3.15,), "bandwidths": (0.5,), "shares": (0.55,)}
    return dataclasses.replace(Design(), **{**node, **changes})


def test_infeasible_demand_names_the_cell_its_best_margin_and_the_mend(
    device: gy.Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(designing, "DETUNINGS", (1.0, 16.0))
    monkeypatch.setattr(designing, "EASINGS", (1.0,))
    wanted = Demand(disk=1.999)
    for method in (design_lqr, design_lmi):
        with pytest.raises(gy.InputError) as caught:
            method(device, single(demand=wanted), quiet=True)
        text = str(caught.value)
        assert "V = 0.15 rad/s, w = 3.15 rad/s, bandwidth 0.5" in text
        assert "at best disk" in text and "1.999 is demanded" in text and "Demand less" in text


def test_demand_is_a_constraint_of_the_design(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """A demand that the first gains miss is met by dearer controls, and by a smaller load where those do not help."""
    free = design_lqr(device, single(demand=Demand(1.0, 0.0, 0.0, 0.0)), quiet=True)[0]
    least = min(found.disk for name, found in free.margins.items() if name != "controls")
    strict = design_lqr(device, single(demand=Demand(1.0, 0.0, 0.0, 1.1 * least)), quiet=True)[0]
    assert free.detuning == 1.0 and (strict.detuning > 1.0 or strict.row[1] < free.row[1])
    assert min(found.disk for name, found in strict.margins.items() if name != "controls") >= 1.1 * least


def test_lmi_proves_its_decay_between_the_nodes(device: gy.Plant) -> None:
    small = dataclasses.replace(Design(), envelopes=(0.15, 0.3), frequencies=(3.15,), bandwidths=(0.5,), shares=(0.55,))
    found, certificate = design_lmi(device, small, quiet=True)
    assert len(found) == 2
    assert 0.0 < between_nodes(device, small, found, certificate) < 1.0


def test_command_line_refuses_an_unknown_table(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        designing.main(["scheduled_h2"])
    assert "scheduled_h2" in capsys.readouterr().err


# --- the loops ----------------------------------------------------------------------------------------------------


def test_live_schedule_is_stable_as_the_frozen_one(device: gy.Plant, law: Scheduled, content: dict[str, Any]) -> None:
    """Frozen, the derivative of the table is left out; here it is in the loop. A regular wave has no bandwidth."""
    for one in (content["cells"][12], content["cells"][21]):
        loop = close_loop(device, gy.Regular(one["wave_height"], one["frequency"]), law._replace(counting=0.0))
        assert loop.status == "stable"
        assert abs(loop.multipliers[0]) < 0.995


def test_margins_of_the_table_are_those_of_the_loop(device: gy.Plant, content: dict[str, Any]) -> None:
    from gyroctl.loop_margins.margins import channel_margins

    one = content["cells"][13]
    loop = cell_loop(device, one["wave_height"], one["frequency"], row_of(one), Filters(**content["filters"]))
    for channel in ("cg", "psi"):
        found, told = channel_margins(loop, channel), one["margins"][channel]
        np.testing.assert_allclose(found.gain, told["gain"], rtol=1e-3)
        assert found.phase == pytest.approx(told["phase"], rel=1e-3)
        assert found.disk == pytest.approx(told["disk"], rel=1e-2)


def test_cell_begun_elsewhere_settles_on_the_same_loop(device: gy.Plant, cell: Cell) -> None:
    gains = regulate(cell, Weights()).gains
    row = [*cell.point, *gains[0], *gains[1]]
    one = loop_of(cell, row, Filters())
    other = cell_loop(device, cell.height, 3.15, row, Filters())
    np.testing.assert_allclose(one.multipliers[:4], other.multipliers[:4], atol=1e-7)


def test_both_laws_beat_the_best_constant_pair(device: gy.Plant, law: Scheduled) -> None:
    """On two tuning seeds of gamma 5: a smoke test, no claim."""
    best = gy.law("best_constant")
    powers = []
    for one in (law, best):
        runs = [gy.simulate(device, one, gy.realise(device, gy.SeaState(), seed, 400.0)) for seed in (100000, 100001)]
        late = [run.power.sel(time=slice(100.0, None)).mean() for run in runs]
        powers.append(float(np.mean(late)))
    assert powers[0] > 1.3 * powers[1]
