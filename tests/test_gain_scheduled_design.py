"""Design of the gain-scheduled laws: cells and their linear models, the regulator, the Lyapunov function, demands."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers.gain_scheduled import design as designing
from gyroctl.controllers.gain_scheduled.cell import Cell, Filters, Node, frozen
from gyroctl.controllers.gain_scheduled.design import Design, between_nodes, build, design_lmi, design_lqr
from gyroctl.controllers.gain_scheduled.lyapunov import Wishes, cell_model, proven_decay, solve
from gyroctl.controllers.gain_scheduled.margins import Demand, cell_loop, loop_of
from gyroctl.controllers.gain_scheduled.periodic_regulator import Weights, regulate
from gyroctl.controllers.gain_scheduled.scheduled import POINT, SIGNALS
from gyroctl.controllers.gain_scheduled.table import read_table, table_file
from gyroctl.linearisation.riccati import periodic_lyapunov
from gyroctl.loop_margins.closed_loop_orbit import close_loop
from gyroctl.nested import leaves
from gyroctl.plant.measurement import read

MIDDLE = Node(0.15, 3.15, 0.5)


@pytest.fixture(scope="module")
def cell(device: gy.Plant) -> Cell:
    return build(device, Design(), MIDDLE, 0.55)


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
    n, ns = flow.free.size, len(leaves(loop.law_states[0]))
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
    np.testing.assert_allclose(np.array(leaves(state)) - np.array(leaves(loop.law_states[k])), z[n : n + ns], atol=1e-9)
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


def test_schedule_of_a_regular_wave_is_its_envelope_and_frequency(device: gy.Plant, cell: Cell) -> None:
    loop = close_loop(device, gy.Regular(cell.height, 3.15), cell.loop.law, start=cell.orbit)
    s = loop.law_states[0]
    mean = np.mean([complex(one.U1, one.U3) for one in loop.law_states])  # the filter leaves a ripple of 3 %
    assert abs(mean) == pytest.approx(MIDDLE.envelope, rel=5e-3)
    assert s.turning / s.weight == pytest.approx(3.15, rel=5e-3)
    assert abs(1.0 - s.slow_square / s.square) < 0.06  # its ripple, again


def test_cell_begun_elsewhere_settles_on_the_same_loop(device: gy.Plant, cell: Cell) -> None:
    gains = regulate(cell, Weights()).gains
    row = [*cell.point, *gains[0], *gains[1]]
    one = loop_of(cell, row, Filters())
    other = cell_loop(device, cell.height, 3.15, row, Filters())
    np.testing.assert_allclose(one.multipliers[:4], other.multipliers[:4], atol=1e-7)


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


@pytest.mark.slow
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


@pytest.mark.slow
def test_demand_is_a_constraint_of_the_design(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """A demand that the first gains miss is met by dearer controls, and by a smaller load where those do not help."""
    free = design_lqr(device, single(demand=Demand(1.0, 0.0, 0.0, 0.0)), quiet=True)[0]
    least = min(found.disk for name, found in free.margins.items() if name != "controls")
    strict = design_lqr(device, single(demand=Demand(1.0, 0.0, 0.0, 1.1 * least)), quiet=True)[0]
    assert free.detuning == 1.0 and (strict.detuning > 1.0 or strict.row[1] < free.row[1])
    assert min(found.disk for name, found in strict.margins.items() if name != "controls") >= 1.1 * least


@pytest.mark.slow
def test_lmi_proves_its_decay_between_the_nodes(device: gy.Plant) -> None:
    small = dataclasses.replace(Design(), envelopes=(0.15, 0.3), frequencies=(3.15,), bandwidths=(0.5,), shares=(0.55,))
    found, certificate = design_lmi(device, small, quiet=True)
    assert len(found) == 2
    assert 0.0 < between_nodes(device, small, found, certificate) < 1.0


def test_command_line_refuses_an_unknown_table(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        designing.main(["scheduled_h2"])
    assert "scheduled_h2" in capsys.readouterr().err
