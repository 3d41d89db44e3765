"""Friction in the rolling contact: equations against a rigid-body engine, energy, and dry friction event by event."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from oracles import Engine, Forcing, random_states
from oracles.stick_slip import run as stick_slip

import gyroctl as gy
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.harness.arguments import law_of
from gyroctl.harness.run import run_law
from gyroctl.harness.start import locked_start
from gyroctl.plant.friction import CREEP
from gyroctl.plant.kernel import hold_one, rows
from gyroctl.simulation.ensemble import run_ensemble
from gyroctl.simulation.metrics import evaluate

SEA = gy.SeaState(0.283, 3.14, 5.0)


@pytest.fixture(scope="module")
def rolling() -> Any:
    return gy.zhang2017()


@pytest.fixture(scope="module")
def plant(rolling: Any) -> Any:
    return rolling.replace(contact="friction", traction=0.6)


def slipping_states(plant: Any, count: int, seed: int) -> Any:
    """Random states whose spin axis slips by tens of rad/s, (n, count)."""
    states = np.array(random_states(count, seed=seed)).T
    rng = np.random.default_rng(seed)
    return np.concatenate([states, plant.parameters.N * states[6:7] + rng.normal(0.0, 20.0, (1, count))])


def run(plant: Any, law: str, seed: int, duration: float = 600.0) -> Any:
    """Record, waves and metrics of a run that is scored from the beginning."""
    waves = gy.realise(plant, SEA, seed, duration)
    record, _ = run_law(plant, law_of(law), waves, gy.Settings(blend=0.0), law)
    return record, waves, evaluate(plant, record, waves.moments[1], waves.dt, SEA.wp, 0.0, 1.0)


def reversals(backwards: Any) -> int:
    """How often a state is entered."""
    return int(np.count_nonzero(backwards[1:] & ~backwards[:-1]))


# --- equations ------------------------------------------------------------------------------------------------------


def test_accelerations_are_those_of_five_free_bodies_in_the_engine(plant: Any) -> None:
    """Ring, axis and flywheel each on a hinge of its own: the friction enters as a torque pair on axis and ring."""
    p, k = plant.parameters, plant.coefficients
    engine = Engine(p)
    free = np.zeros((engine.model.nv, 5))
    free[0, 0] = free[2, 1] = free[3, 2] = free[5, 3] = free[4, 4] = 1.0  # w1, w3, psi', omega', theta'
    engine.speeds, gear = free, p.N
    rng = np.random.default_rng(41)
    for x in slipping_states(plant, 50, seed=41).T:
        u, waves = (rng.uniform(0.0, 0.3), rng.uniform(0.0, 0.02)), rng.normal(0.0, 100.0, 2)
        attitude = rng.normal(size=4)
        engine.gear = 0.0
        engine.place(attitude / np.linalg.norm(attitude), x[2], np.array([*x[4:8], x[-1]]))
        memory = [np.dot(r.p[::-1], z[: len(r.p)]) for r, z in zip(plant.radiation, (x[8:11], x[11:14]), strict=True)]
        passive = -np.array([p.k1, p.k3]) * x[:2] - np.array([p.d1, p.d3]) * x[4:6] - np.array(memory)
        # the engine's coupling acts between flywheel and ring: take it off, and put on that between flywheel and axis
        engine._load((0.0, u[1]), Forcing(waves + passive))
        model, data = engine.model, engine.data
        spin = data.xmat[engine.body["ring"]].reshape(3, 3)[:, 0]
        about = data.xmat[engine.body["ring"]].reshape(3, 3)[:, 1]
        c, s = np.cos(x[2]), np.sin(x[2])
        u1 = c * x[4] - s * x[5]
        M3 = 2.0 * k.K * u1 * x[6] - x[6] * (p.J13 * (u1 + x[-1]) + p.J14 * (u1 + x[7]))
        side = -np.tanh(M3)
        slip = x[-1] - side * gear * x[6]
        friction = -p.traction * np.sqrt(M3**2 + 0.01) / gear * np.tanh(slip / CREEP)
        coupling = u[0] * (x[7] - x[-1])
        torque = data.xfrc_applied[:, 3:]
        torque[engine.body["axis"]] += (coupling + friction) * spin
        torque[engine.body["flywheel"]] -= coupling * spin
        torque[engine.body["ring"]] -= (friction * spin) + side * gear * friction * about
        torque[engine.body["float"]] += side * gear * friction * about
        mujoco.mj_forward(model, data)
        columns = np.zeros((5, model.nv))
        for column, direction in zip(columns, free.T, strict=True):
            mujoco.mj_mulM(model, data, column, np.ascontiguousarray(direction))
        found = np.linalg.solve(columns @ free, free.T @ data.qfrc_smooth)
        rates = plant.derivative(x, u, tuple(waves))
        np.testing.assert_allclose(np.array([*rates[4:8], rates[-1]]), found, rtol=1e-9, atol=1e-9)


def test_energy_changes_by_the_powers_with_friction(plant: Any) -> None:
    """Rate of the stored energy by complex step; the contact only takes."""
    x = slipping_states(plant, 200, seed=42)
    u, waves = (0.1, 5e-4), (40.0, -70.0)
    rate = plant.derivative(x, u, waves)
    stored = np.imag(plant.stored_energy(x + 1e-30j * rate)) / 1e-30
    power = plant.powers(x, u, waves)
    taken = sum(power[name] for name in plant.ledger if name not in ("wave_input", "second_order"))
    np.testing.assert_allclose(stored, power["wave_input"] - taken, rtol=1e-9, atol=1e-7)
    assert np.all(power["contact"] >= 0.0) and np.max(power["contact"]) > 10.0


def test_state_of_the_axis_is_the_last_and_off_it_is_not_there(rolling: Any, plant: Any) -> None:
    """Labels, start on the orbit of rolling, and the way back."""
    assert plant.labels == (*rolling.labels, "theta_rate") and plant.ledger[-1] == "contact"
    start, controls = locked_start(plant, SEA)
    before, same = locked_start(rolling, SEA)
    np.testing.assert_array_equal(start[:-1], before)
    assert start[-1] == plant.parameters.N * start[6] and controls == same
    assert plant.rolling.coefficients == rolling.coefficients and rolling.rolling is rolling


def test_one_text_serves_casadi_and_the_complex_step(plant: Any) -> None:
    """The derivative as casadi expression, and its Jacobian against central differences."""
    x = slipping_states(plant, 3, seed=43)[:, 1]
    u, waves = (0.1, 5e-4), (40.0, -70.0)
    symbolic = np.array(plant.casadi()(x, u, waves)).ravel()
    np.testing.assert_allclose(symbolic, plant.derivative(x, u, waves), rtol=1e-12, atol=1e-12)
    A, _ = plant.jacobians(x, u, waves)
    for column in (6, 7, 14):
        step = np.zeros(x.size)
        step[column] = 1e-6
        slope = plant.derivative(x + step, u, waves) - plant.derivative(x - step, u, waves)
        np.testing.assert_allclose(A[:, column], slope / 2e-6, rtol=1e-5, atol=1e-3)


# --- runs -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("law", "mu"), [("constant", 0.3), ("load_angle", 0.3), ("coupling", 0.6), ("constant", 0.6)])
def test_ledger_closes_over_600_s(rolling: Any, law: str, mu: float) -> None:
    """To 5e-6 of the wave input, through hundreds of slides and changes of side, and with switching."""
    _, _, found = run(rolling.replace(contact="friction", traction=mu), law, 2)
    assert found["ledger_residual"] < 5e-6


def test_much_friction_and_little_creep_is_rolling(rolling: Any) -> None:
    """With a large traction the axis rolls: power, ring and float follow the rolling plant for the first waves."""
    slip, _, _ = run(rolling.replace(contact="friction", traction=6.0), "constant", 1, 20.0)
    roll, _, _ = run(rolling, "constant", 1, 20.0)
    np.testing.assert_allclose(slip.states[:, 6], roll.states[:, 6], atol=0.05)
    np.testing.assert_allclose(slip.states[:, 14], rolling.parameters.N * slip.states[:, 6], atol=0.3)


@pytest.mark.slow
def test_verdict_on_reversals_is_that_of_dry_friction_event_by_event(rolling: Any) -> None:
    """Ten runs at 0.4 and 0.6: the same verdict in nine; the creep of the smoothed friction costs less than 0.3 W."""
    agreed, crept = 0, []
    for mu in (0.4, 0.6):
        device = rolling.replace(contact="friction", traction=mu)
        for seed in range(1, 6):
            record, waves, _ = run(device, "constant", seed, 300.0)
            cc, cg = record.controls[1]
            start, _ = locked_start(device, SEA)
            dry = stick_slip(device, start, waves, lambda t, x, cc=cc, cg=cg: (cc, cg))
            states = record.states
            turned = reversals(states[:, 6] * states[:, 14] < 0.0)
            agreed += (turned > 0) == (reversals(dry.side < 0.0) > 0)
            if turned == 0:
                crept.append((states[-1, -1] - dry.rubbed) / waves.duration)
    assert agreed >= 9
    assert len(crept) >= 4 and 0.0 < max(crept) < 0.3


@pytest.mark.slow
def test_a_reversal_follows_from_the_same_state(rolling: Any) -> None:
    """From where dry friction is two seconds before it, the smoothed one reverses at the same time to 0.3 s."""
    device = rolling.replace(contact="friction", traction=0.3)
    k, n = device.coefficients, len(device.labels)
    waves = gy.realise(device, SEA, 2, 240.0)
    start, (cc, cg) = locked_start(device, SEA)
    dry = stick_slip(device, start, waves, lambda t, x: (cc, cg)).states
    backwards = dry[:, 5] * dry[:, 6] < 0.0
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    entered = [i for i in np.flatnonzero(backwards[1:] & ~backwards[:-1]) + 1 if not backwards[i - 30 : i].any()][:4]
    assert len(entered) >= 2
    for i in entered:
        x = dry[i - 20]
        state = np.concatenate([x[:3], [0.0], x[3:6], x[7:], x[6:7], np.zeros(rows(k) - n)])
        turned = []
        for j in range(i - 20, i + 10):
            state = hold_one(state, k, cc, cg, 0.1 * j, 0.1, 10, flat, waves.dt)
            turned.append(state[6] * state[n - 1] < 0.0)
        assert abs(int(np.argmax(turned)) - 19) <= 3 and any(turned)


def test_comparison_takes_it_and_tells_its_card(plant: Any) -> None:
    """Two laws on one realisation: finite power, ledger closed, traction within what there is."""
    waves = Realisations(SEA, (1,), 60.0)
    laws = {"constant": law_of("constant"), "load_angle": law_of("load_angle")}
    ds = compare(plant, laws, waves, gy.Settings(blend=20.0), 1, tuning_seeds=(), quiet=True)
    assert not ds.failed.any() and float(ds.ledger_residual.max()) < 5e-6
    assert float(ds.traction_p999.max()) < 0.65 and float(ds.reversals.max()) == 0.0
    assert 0.0 < float(ds.coupling_torque_max.min()) and float(ds.slip_max.max()) < 100.0


def test_ensemble_is_served_by_single_runs(rolling: Any) -> None:
    """The same numbers as runs of their own."""
    device = rolling.replace(contact="friction", traction=0.6)
    start, _ = locked_start(device, SEA)
    pairs = [(0.052, 3.5e-4), (0.104, 2e-4)]
    found = run_ensemble(device, SEA, pairs, [1, 2], start, 60.0, 20.0, quiet=True)
    for i, (cc, cg) in enumerate(pairs):
        waves = gy.realise(device, SEA, 2, 60.0).blended(20.0)
        record, _ = run_law(device, gy.law("constant", cc=cc, cg=cg), waves, gy.Settings(blend=20.0), "constant")
        alone = evaluate(device, record, waves.moments[1], waves.dt, SEA.wp, 20.0, 1.0)
        assert found.mean_power[i, 1] == pytest.approx(alone["generated_w"], rel=1e-6)
        assert found.power_cv[i, 1] == pytest.approx(alone["power_cv"], rel=1e-6)
        assert found.ledger_residual[i, 1] < 5e-6


# --- refusals -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("choices", [{"connection": "rigid"}, {"traction": 0.0}, {"traction": "much"}])
def test_contradictions_are_refused(rolling: Any, choices: Any) -> None:
    """In one line, by name."""
    with pytest.raises(gy.InputError, match="plant"):
        rolling.replace(contact="friction", **choices)


def test_orbits_are_refused_with_the_way_out(plant: Any) -> None:
    """An axis that sticks and slips has no orbit to differentiate; the rolling device has."""
    from gyroctl.orbits.search import search_orbit

    with pytest.raises(gy.InputError, match=r"plant\.rolling"):
        search_orbit(plant, gy.Regular(0.2, 3.14), 0.052, 3.5e-4)
