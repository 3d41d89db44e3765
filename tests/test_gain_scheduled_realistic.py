"""The scheduled laws designed beyond the linear model: cells, multipliers and margins there, and what a lull does."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import gyroctl as gy
from gyroctl import nested
from gyroctl.controllers.gain_scheduled.cell import Cell, Filters, Node, modulation
from gyroctl.controllers.gain_scheduled.design import DESIGNS, Design, build
from gyroctl.controllers.gain_scheduled.margins import CHANNELS, cell_loop
from gyroctl.controllers.gain_scheduled.scheduled import ROW, Scheduled
from gyroctl.controllers.gain_scheduled.table import NODES, law_of, read_table, row_of, table_file
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.protocol import Measurement
from gyroctl.linearisation.held_flow import HeldFlow
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit
from gyroctl.loop_margins.trial import try_loop
from gyroctl.orbits.flow import Forcing
from gyroctl.plant.measurement import read

TABLES = ("scheduled_lqr_realistic", "scheduled_lmi_realistic")
LAG = 0.02
"""Of the coupling in real water. [s]"""


@pytest.fixture(scope="module")
def real() -> gy.Plant:
    return gy.zhang2017("realistic").smooth


@pytest.fixture(scope="module", params=TABLES)
def content(request: pytest.FixtureRequest) -> dict[str, Any]:
    return read_table(table_file(request.param))


@pytest.fixture(scope="module")
def entry(content: dict[str, Any]) -> dict[str, Any]:
    """A cell in the middle of the table."""
    one: dict[str, Any] = content["cells"][len(content["cells"]) // 2]
    return one


@pytest.fixture(scope="module")
def loop(real: gy.Plant, content: dict[str, Any], entry: dict[str, Any]) -> LoopOrbit:
    filters = Filters(**content["filters"])
    return cell_loop(real, entry["wave_height"], entry["frequency"], row_of(entry), filters)


def period_map(loop: LoopOrbit, z: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Plant's free rows and law's state after one wave, the law stepped as it is, the plant as it moves."""
    flow, n = loop.flow, loop.flow.free.size
    x = loop.states[0] + flow.embedding @ z[:n]
    state = displaced(loop.law_states[0], z[n:])
    for k in range(flow.samples):
        (cc, cg), state = loop.law.step(k * flow.period, read(x), state)
        x = flow.advance(x, cc, cg, k)
    gap = x - loop.states[-1]
    return np.concatenate([gap[flow.free], flat(state) - flat(loop.law_states[0])])


def flat(state: Any) -> np.ndarray[Any, Any]:
    return np.array([float(one) for one in nested.leaves(state)])


def displaced(state: Any, off: np.ndarray[Any, Any]) -> Any:
    return nested.like(state, (flat(state) + off).tolist())


def differences(loop: LoopOrbit) -> np.ndarray[Any, Any]:
    """Derivative of the period map by central differences, each direction with a step of its own size."""
    n, ns = loop.flow.free.size, flat(loop.law_states[0]).size
    columns = []
    for i in range(n + ns):
        h = np.zeros(n + ns)
        h[i] = 1e-6
        columns.append((period_map(loop, h) - period_map(loop, -h)) / 2e-6)
    return np.stack(columns, axis=1)


# --- against independent derivations -----------------------------------------------------------------------------


def test_multipliers_of_a_realistic_cell_are_those_of_the_period_map(loop: LoopOrbit, entry: dict[str, Any]) -> None:
    """Neither dual numbers nor complex steps: plain runs of plant and law over one wave."""
    assert loop.status == "stable"
    plain = np.linalg.eigvals(differences(loop))
    plain = plain[np.argsort(-np.abs(plain))]
    np.testing.assert_allclose(np.abs(plain[:8]), np.abs(loop.multipliers[:8]), atol=2e-5)
    slowest = -loop.flow.forcing.period / np.log(np.abs(plain[0]))
    assert slowest == pytest.approx(entry["notes"]["decay_time"], rel=1e-3)


def test_a_gain_that_is_wrong_is_seen_in_the_period_map(loop: LoopOrbit) -> None:
    """The comparison above can fail: with one gain of the law a tenth off the multipliers part."""
    cells = list(loop.law.cells)
    cells[7 + 10 + 2] *= 3.0  # from the ring speed to cg
    other = dataclasses.replace(loop, law=loop.law._replace(cells=tuple(cells)))
    plain = np.linalg.eigvals(differences(other))
    plain = plain[np.argsort(-np.abs(plain))]
    assert np.max(np.abs(np.abs(plain[:8]) - np.abs(loop.multipliers[:8]))) > 1e-3


def test_wave_modulation_is_that_of_two_waves(real: gy.Plant, loop: LoopOrbit) -> None:
    """A higher wave, and one that comes later, against the derivative by the amplitude."""
    flow, x, controls = loop.flow, loop.states[3], loop.controls[3]
    found = modulation(flow, x, controls, 3)
    for column, turn in enumerate((1e-6, 1e-6j)):
        ends = []
        for sign in (1.0, -1.0):
            moved = Forcing((1.0 + sign * turn) * flow.forcing.amplitude, flow.forcing.wp)
            other = HeldFlow(real, moved, flow.samples, flow.cc_max)
            ends.append(other.advance(x, controls[0], controls[1], 3)[flow.free])
        difference = (ends[0] - ends[1]) / 2e-6
        np.testing.assert_allclose(found[:, column], difference, atol=1e-5 * np.max(np.abs(difference)))


def test_exact_modulation_is_near_the_held_one_where_both_are_known(device: gy.Plant) -> None:
    flow = HeldFlow(device, Forcing.of(device, gy.Regular(0.15, 3.15)), 20, 0.1)
    x = np.zeros(len(device.labels))
    x[6], x[7] = 3.15, 71.0
    exact, held = flow.by_amplitude(x, 0.06, 1e-3, 4), modulation(flow, x, np.array([0.06, 1e-3]), 4)
    np.testing.assert_allclose(exact, held, atol=0.03 * np.max(np.abs(held)))
    assert np.max(np.abs(held)) > 0.0


@pytest.mark.slow
def test_orbit_of_a_realistic_cell_has_its_envelope_and_pays_its_losses(real: gy.Plant) -> None:
    """From the states on the orbit: the pull of the float on one side, generator, bearing and windage on the other."""
    cell: Cell = build(real, DESIGNS[TABLES[0]], Node(0.15, 3.15, 0.5), 0.4)
    x = cell.orbit.states(256)
    p = real.parameters
    assert abs(np.mean(np.exp(1j * x[:, 2]) * (x[:, 4] + 1j * x[:, 5]))) == pytest.approx(0.15, rel=2e-3)
    speed = x[:, 7]
    torque = cell.orbit.cg * speed + p.bearing * np.tanh(speed) + p.windage * speed * np.sqrt(speed**2 + 1.0)
    share = p.N * np.mean(torque) / np.mean(speed) / (p.J4 * 0.15)
    assert share == pytest.approx(0.4, rel=5e-3)
    assert cell.orbit.cg < 0.9 * 0.4 * p.J4 * 0.15 / p.N


def test_share_that_the_losses_take_is_refused(real: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match="losses take"):
        build(real, Design(), Node(0.03, 3.15, 0.5), 0.3)


# --- the table that ships ----------------------------------------------------------------------------------------


def test_table_says_on_which_device_it_was_designed(content: dict[str, Any]) -> None:
    assert "realistic" in content["provenance"]["plant"]
    demand = content["provenance"]["demand"]
    for one in content["cells"]:
        assert set(one["margins"]) == set(CHANNELS)
        for channel, found in one["margins"].items():
            low, high = found["gain"]
            assert high >= demand["gain"] and low <= 1.0 / demand["gain"]
            assert found["phase"] >= demand["phase"]
            if channel != "controls":
                assert found["delay"] >= demand["delay"] and found["disk"] >= demand["disk"]


def test_lag_of_the_coupling_is_far_within_the_margins(loop: LoopOrbit, content: dict[str, Any]) -> None:
    """A lag delays no more than its time constant: a tenth of what every cell bears, and hardly seen in the loop."""
    assert all(one["margins"]["cc"]["delay"] >= 10.0 * LAG for one in content["cells"])
    trial = try_loop(loop, "cc", delay=LAG, size=1e-6)
    assert trial.stable
    assert abs(trial.growth - abs(loop.multipliers[0])) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["gain", "delay"])
def test_a_margin_holds_in_the_nonlinear_loop(loop: LoopOrbit, entry: dict[str, Any], kind: str) -> None:
    found = entry["margins"]["phi1_rate"]
    limit = found["gain"][1] if kind == "gain" else found["delay"]
    if not np.isfinite(limit) or (kind == "gain" and limit > 20.0):
        pytest.skip("this cell has no such limit")
    for factor in (0.95, 1.05):
        trial = try_loop(loop, "phi1_rate", size=1e-6, **{kind: limit * factor})
        assert trial.growth == pytest.approx(trial.predicted, rel=1e-3)
        assert trial.stable == (factor < 1.0)


# --- which table a law takes, and what it does outside -----------------------------------------------------------


@pytest.mark.parametrize("table", TABLES)
def test_design_model_chooses_the_table(table: str) -> None:
    name = table.removesuffix("_realistic")
    linear: Any = gy.law(name)
    real: Any = gy.law(name, plant="realistic")
    assert linear.bandwidths != real.bandwidths and linear.bearing == 0.0
    assert real.cells == law_of(read_table(table_file(table))).cells
    assert real.bearing == 0.01 and real.windage == 9.1e-7
    plain: Any = gy.law(name, plant="corrected")
    assert plain.cells == linear.cells and plain.bearing == 0.0


@pytest.mark.slow
def test_one_lyapunov_function_proves_the_realistic_cells(real: gy.Plant) -> None:
    """The function in the file against the averaged model of a cell, and the gains that the file gives it."""
    content = read_table(table_file("scheduled_lmi_realistic"))
    design, told = DESIGNS["scheduled_lmi_realistic"], content["provenance"]
    entry = content["cells"][-1]
    cell = build(real, design, Node(*(entry[name] for name in NODES)), design.shares[0])
    model, Q = design.slow_model(cell), np.array(told["Q0"])
    K = slow_gains(entry)
    assert np.all(np.linalg.eigvalsh(Q) > 0.0) and not np.any(told["Q1"])
    closed = (model.A + model.B @ K) @ Q
    worst = -0.5 * np.max(scipy.linalg.eigh(closed + closed.T, Q, eigvals_only=True))
    assert worst == pytest.approx(entry["notes"]["proven_decay"], rel=1e-3)
    assert told["proven_decay"] <= worst + 1e-9
    closed = (model.A - 10.0 * model.B @ K) @ Q
    assert -0.5 * np.max(scipy.linalg.eigh(closed + closed.T, Q, eigvals_only=True)) < 0.0


def slow_gains(entry: dict[str, Any]) -> np.ndarray[Any, Any]:
    """Gains (6, 4) of a cell on the states of the slow model, from its entry in the table."""
    K = np.zeros((6, 4))
    for control, part in enumerate(("cc", "cg")):
        gains = entry[part]
        K[control, :2] = gains["angle"], gains["speed"]
        for j, name in enumerate(("cos", "sin")):
            K[2 + 2 * control + j, 2:] = gains[f"swing_{name}"], gains[f"swing_rate_{name}"]
    return K


def test_generator_lets_go_in_a_lull() -> None:
    """Below the envelope at which the losses alone take the share; above, it brakes. Without losses it always does."""
    row = [0.06, 0.3, 0.9, -0.4, 0.0, 0.0, 0.97, *[0.0] * (ROW - 7)]
    base = Scheduled((1.0,), (1.0,), (1.0,), tuple(row), wp=3.14, bearing=0.01, windage=9.1e-7)
    speed = base.N * 3.14
    least = base.N / (0.3 * base.J4) * (0.01 / speed + 9.1e-7 * speed)
    for factor, brakes in ((0.9, False), (1.1, True)):
        state = base.init()._replace(
            U1=factor * least / np.exp(-0.1 / base.slow), turning=3.14, weight=1.0, square=1.0, speed=3.14, begun=1.0
        )
        still = resting(3.14)
        assert (base.step(10.0, still, state)[0][1] > 0.0) == brakes
        assert base._replace(bearing=0.0, windage=0.0).step(10.0, still, state)[0][1] > 0.0


def resting(speed: float) -> Any:
    return Measurement(0.3, speed, 68.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["scheduled_lqr", "scheduled_lmi"])
def test_realistic_table_runs_in_real_water(name: str) -> None:
    """On one tuning seed: the realistic table keeps more turns than the linear one."""
    plant = gy.zhang2017("realistic", wetted="reduced")
    settings = gy.Settings(actuators=Actuators(cc_lag=LAG))
    waves = gy.realise(plant, gy.SeaState(), 100000, 400.0)
    turns = []
    for law in (gy.law(name, plant="realistic"), gy.law(name)):
        run = gy.simulate(plant, law, waves, settings)
        psi = np.asarray(run.psi.sel(time=slice(100.0, None)))
        turns.append(float(psi[-1] - psi[0]))
    assert turns[0] > turns[1] > 0.0
