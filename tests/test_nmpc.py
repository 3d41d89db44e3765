"""Nonlinear MPC: the model against the kernel, exact gradients, plans, fallbacks."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from numba import njit

import gyroctl as gy
from gyroctl.controllers.nmpc import Nmpc, prediction, problem
from gyroctl.controllers.nmpc.foresight import between
from gyroctl.controllers.nmpc.power_command import PowerCommand
from gyroctl.controllers.nmpc.sample import SAMPLE
from gyroctl.controllers.nmpc.settings import Effort
from gyroctl.controllers.nmpc.solvers import descent
from gyroctl.errors import InputError
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.plant.kernel import hold_one, rows
from gyroctl.simulation.metrics import evaluate

NO_OMEGA = [0, 1, 2, 4, 5, 6, 7, *range(8, 14)]
SEED = 100000


@pytest.fixture(scope="module")
def plant() -> gy.Plant:
    return gy.zhang2017()


@pytest.fixture(scope="module")
def horizon(plant: gy.Plant) -> problem.Problem:
    """4 s from a locked state into irregular waves."""
    sea = gy.SeaState()
    waves = gy.realise(plant, sea, SEED, 20.0)
    start = locked_start(plant, sea)[0][NO_OMEGA]
    cost = problem.weights(plant, 2000.0, 0.05, 0.05, 50.0, 3.2, 40.0, 0.3)  # limits so low that every term acts
    cost = cost._replace(turns=5.0, reach=start[2] + 20.0)
    flat = np.ascontiguousarray(waves.moments.T).ravel()[: 2 * 81]
    return problem.Problem(start, flat, 10.0, 0.05, 0.12, 0.1, np.array([0.05]), prediction.constants(plant), cost)


def tools(plant: gy.Plant):
    kind = prediction.linear_kind(plant)
    return prediction.step_of(kind), prediction.pullback_of(kind), prediction.tangent_of(kind)


@njit
def call(function, a, b, first, second):
    function(a, b, first, second)


@pytest.mark.parametrize("cc_max", [0.06, 0.12, 0.3])
def test_model_follows_the_kernel(plant, cc_max):
    """Four seconds of switching: within a hundredth of the kernel at dt = 0.0025 s."""
    step, _, _ = tools(plant)
    sea, k = gy.SeaState(), prediction.constants(plant)
    waves = lead_in(gy.realise(plant, sea, SEED, 200.0), Settings())
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    y = np.zeros(rows(plant.coefficients))
    y[:14] = locked_start(plant, sea)[0]
    cc = np.random.default_rng(1).choice([0.0, cc_max], 40)
    x, u, h, after = y[NO_OMEGA].copy(), np.array([0.0, 5.0]), np.array([0.05]), np.zeros(13)
    for i in range(40):
        u[0] = cc[i]
        for q in (2 * i, 2 * i + 1):
            step(x, u, flat[2 * q : 2 * q + 4], h, k, after)
            x[:] = after
        y = hold_one(y, plant.coefficients, cc[i], 5.0 / y[7] ** 2, 0.1 * i, 0.1, 40, flat, waves.dt)
    np.testing.assert_allclose(x[[0, 1]], y[[0, 1]], atol=4e-3)  # phi [rad]
    assert abs(x[2] - y[2]) < 0.02  # psi [rad]
    assert abs(x[6] - y[7]) < 0.03  # flywheel [rad/s]


@pytest.mark.slow
def test_model_converges_with_second_order(plant):
    step, _, _ = tools(plant)
    k = prediction.constants(plant)
    rng = np.random.default_rng(3)
    start = np.array([0.1, 0.05, 0.3, 0.1, 0.1, 3.0, 68.0, *rng.standard_normal(6) * 1e-3])
    m0, slope, u = np.array([100.0, 250.0]), np.array([30.0, -80.0]), np.array([0.05, 8.0])

    def at(parts: int):
        x, after, h = start.copy(), np.zeros(13), np.array([0.1 / parts])
        for i in range(parts):
            a, b = m0 + slope * 0.1 * i / parts, m0 + slope * 0.1 * (i + 1) / parts
            step(x, u, np.array([*a, *b]), h, k, after)
            x[:] = after
        return x

    exact = at(2048)
    coarse, fine = np.abs(at(16) - exact).max(), np.abs(at(32) - exact).max()
    assert 3.4 < coarse / fine < 4.6


def test_adjoint_is_the_transposed_tangent_and_both_are_exact(plant):
    """Over the two steps of an interval, of which the tangent takes four side by side."""
    step, pullback, tangent = tools(plant)
    rng, k, h = np.random.default_rng(2), prediction.constants(plant), np.array([0.05])
    for _ in range(5):
        x = np.array([0.1, 0.05, 0.3, 0.1, 0.1, 3.0, 68.0, *np.zeros(6)]) * (1 + 0.2 * rng.standard_normal(13))
        u, m, w = np.array([rng.uniform(0, 0.3), 8.0]), 100 * rng.standard_normal(4), rng.standard_normal(13)
        columns, by_x, by_u = np.zeros((4, 14, 16)), np.zeros(13), np.zeros(2)
        columns[:, :, :14] = np.eye(14)
        after = np.zeros(13)
        step(x, u, m, h, k, after)  # the second steps of the intervals go on from there
        points = [np.concatenate([x, u, m]), np.concatenate([after, u, m])] * 4
        room = np.concatenate([np.stack(points, axis=1).ravel(), np.empty(prediction.tangent_room(13, 2))])
        call(tangent, h, k, room, columns.ravel())
        pullback(after, u, m, h, k, w, by_x, by_u)
        between, by_power = by_x.copy(), by_u[0]
        pullback(x, u, m, h, k, between, by_x, by_u)
        for J in columns:
            np.testing.assert_array_equal(J[13], np.eye(14, 16)[13])  # the coupling's own derivative stays
            np.testing.assert_allclose(w @ J[:13, :14], [*by_x, by_u[0] + by_power], rtol=1e-11, atol=1e-11)
        J = columns[0, :13, :14]
        for i in range(14):  # central differences confirm the exact derivative to their own accuracy
            e = 1e-5 * max(1.0, abs(float([*x, *u][i])))
            ahead, behind = np.zeros(13), np.zeros(13)
            for sign, out in ((1, ahead), (-1, behind)):
                z = np.array([*x, *u])
                z[i] += sign * e
                step(z[:13].copy(), z[13:].copy(), m, h, k, after)
                step(after, z[13:].copy(), m, h, k, out)
            np.testing.assert_allclose((ahead - behind) / (2 * e), J[:, i], rtol=1e-5, atol=1e-6 * np.abs(J).max())


def test_gradient_of_the_cost(plant, horizon):
    step, pullback, _ = tools(plant)
    cc = np.random.default_rng(4).uniform(0.01, 0.1, 40)
    states, slope = np.empty((81, 13)), np.empty(40)
    problem.predict(step, horizon, cc, states)
    problem.gradient(pullback, horizon, cc, states, slope)
    for i in range(0, 40, 3):
        e = 1e-6
        values = []
        for sign in (1, -1):
            moved = cc.copy()
            moved[i] += sign * e
            values.append(problem.predict(step, horizon, moved, states))
        assert (values[0] - values[1]) / (2 * e) == pytest.approx(slope[i], rel=1e-4, abs=1e-3)


def test_descent_never_rises_and_ends_where_no_coupling_alone_can_improve(plant, horizon):
    step, pullback, _ = tools(plant)
    mild = horizon._replace(weights=horizon.weights._replace(limit1=0.2, limit3=0.2, floor=1.5, travel=4.0))
    plan, length, costs = np.full(40, 0.05), 1e-3, []
    for _ in range(150):
        before, after, length = descent.descend(step, pullback, mild, plan, length, 10)
        assert after <= before + 1e-9
        costs.append(after)
    assert plan.min() >= 0.0 and plan.max() <= mild.cc_max
    gain = costs[0] - costs[-1]
    assert gain > 5.0 and costs[-10] - costs[-1] < 0.05 * gain  # J
    states = np.empty((81, 13))
    for i in range(40):  # brute force, one interval at a time
        for sign in (-1, 1):
            moved = plan.copy()
            moved[i] = min(max(moved[i] + sign * 0.002, 0.0), mild.cc_max)
            assert problem.predict(step, mild, moved, states) > costs[-1] - 0.05 * gain


def test_a_plan_beats_every_constant_coupling(plant, horizon):
    step, pullback, _ = tools(plant)
    plan, states = np.full(40, 0.05), np.empty((81, 13))
    _, after, _ = descent.descend(step, pullback, horizon, plan, 1e-3, 60)
    constant = [problem.predict(step, horizon, np.full(40, c), states) for c in np.linspace(0.0, 0.12, 25)]
    assert after < min(constant) - 1.0  # J


def test_missing_turns_are_made_up_for(plant, horizon):
    step, pullback, _ = tools(plant)
    angles = []
    for turns in (0.0, 50.0):
        plan, states = np.full(40, 0.05), np.empty((81, 13))
        wanted = horizon._replace(weights=horizon.weights._replace(turns=turns))
        descent.descend(step, pullback, wanted, plan, 1e-3, 60)
        problem.predict(step, wanted, plan, states)
        angles.append(states[-1, 2])
    assert angles[1] > angles[0] + 0.2  # rad


def test_moments_between_the_intervals():
    t = 0.1 * np.arange(41)
    rows_at = np.stack([np.sin(4.0 * t), np.cos(4.0 * t)], axis=1)
    fine = np.empty((81, 2))
    between(rows_at[0].copy(), np.ascontiguousarray(rows_at[1:].T), 0.1, fine.ravel())
    exact = np.stack([np.sin(4.0 * 0.05 * np.arange(81)), np.cos(4.0 * 0.05 * np.arange(81))], axis=1)
    np.testing.assert_array_equal(fine[::2], rows_at)
    assert np.abs(fine - exact)[2:-2].max() < 2e-3
    assert np.abs(fine - exact).max() < 0.03


COMMAND = PowerCommand(flywheel=60.0, proportional=1.5, integral=0.01, settling=0.0, low=0.9, guard=6.0)
CG_MAX = 0.02


def test_power_command_holds_its_bounds():
    assert COMMAND.step(30.0, 5.0, 0.1, 0.1, CG_MAX)[0] == 0.0  # the flywheel is drained: no load
    assert COMMAND.step(60.0, 1e6, 0.1, 0.1, CG_MAX) == (pytest.approx(0.02 * 3600.0), pytest.approx(0.02 * 3600.0))
    power, mean = COMMAND.step(66.0, 5.0, 0.1, 0.1, CG_MAX)
    assert (power, mean) == (pytest.approx(1.15 * 5.0005), pytest.approx(5.0005))
    for speed in np.linspace(20.0, 90.0, 71):  # the same course in a sea of any height
        assert COMMAND.step(speed, 4.0, 0.1, 0.1, CG_MAX)[0] == pytest.approx(
            2.0 * COMMAND.step(speed, 2.0, 0.1, 0.1, CG_MAX)[0]
        )


def test_power_command_keeps_the_flywheel_through_a_lull():
    """The waves give nothing for two minutes: the guard leaves the flywheel the energy that drags the ring."""

    def least(command):
        energy, mean, lowest = 0.5 * 0.3671 * 66.0**2, 14.0, math.inf
        for sample in range(4000):
            speed = math.sqrt(2.0 * energy / 0.3671)
            power, mean = command.step(speed, mean, 0.1, 0.1 * sample, CG_MAX)
            energy += 0.1 * ((0.0 if 1000 <= sample < 2200 else 14.0) - power)
            lowest = min(lowest, speed)
        return lowest

    guarded = least(COMMAND._replace(flywheel=66.0))
    assert guarded > 44.0 > least(COMMAND._replace(flywheel=66.0, guard=0.0)) + 5.0


def run(plant, law, duration=200.0, gamma=5.0, settings=None, seed=SEED):
    settings = settings or Settings()
    waves = lead_in(gy.realise(plant, gy.SeaState(gamma=gamma), seed, duration), settings)
    record, timing = run_law(plant, law, waves, settings)
    return evaluate(plant, record, waves.moments[1], waves.dt, 3.14, 60.0, math.nan), record, timing


@pytest.mark.slow
@pytest.mark.parametrize("information", ["oracle", "forecast", "sensors"])
def test_gives_several_times_the_best_constant_pair(plant, information):
    found, _, _ = run(plant, Nmpc(information=information))
    pair, _, _ = run(plant, gy.law("best_constant"))
    assert found["locked"] == 1.0 and found["mean_power"] > 3.0 * pair["mean_power"]
    assert found["ledger_residual"] < 1e-6


def test_repeats_to_the_last_bit_and_leaves_its_state_alone(plant):
    law = Nmpc()
    first, second = run(plant, law, 120.0)[1], run(plant, law, 120.0)[1]
    np.testing.assert_array_equal(first.states, second.states)
    state = law.init()
    before = pickle.dumps(state)
    y = Measurement(0.1, 3.0, 68.0, 0.05, 0.02, 0.1, 0.1)
    one, two = law.step(0.0, y, state), law.step(0.0, y, state)
    assert one[0] == two[0] and pickle.dumps(state) == before


def test_travels_between_processes(plant):
    law = Nmpc(information="sensors")
    law.init()
    copy = pickle.loads(pickle.dumps(law))
    y = Measurement(0.1, 3.0, 68.0, 0.05, 0.02, 0.1, 0.1)
    assert copy.step(0.0, y, copy.init())[0] == law.step(0.0, y, law.init())[0]


class Stalling:
    """A clock that jumps by a second at each look, from one count of looks to another."""

    def __init__(self, begin: int, end: int) -> None:
        self.now, self.looks, self.begin, self.end = 0.0, 0, begin, end

    def __call__(self) -> float:
        self.looks += 1
        self.now += 1.0 if self.begin <= self.looks < self.end else 0.0
        return self.now


@pytest.mark.slow
def test_missed_deadlines_fall_back_and_keep_lock(plant):
    # two looks at a sample that plans: with a plan at every sample, samples 1000 to 1299 come too late
    law = Nmpc(deadline=0.05, effort=Effort(replan=1), clock=Stalling(2001, 2601))
    found, record, timing = run(plant, law, 260.0)
    assert found["locked"] == 1.0
    assert timing.counters["deadline_misses"] == 300
    assert timing.counters["kept_plans"] == 10 and timing.counters["fallbacks"] == 290
    during = record.commands[1015:1295]
    np.testing.assert_array_equal(during, np.tile([0.052, 2e-4], (280, 1)))


def test_between_plans_the_last_one_is_followed(plant):
    law = Nmpc(effort=Effort(replan=4))
    state = law.init()
    y = Measurement(0.1, 3.0, 68.0, 0.05, 0.02, 0.1, 0.1)
    for sample in range(9):
        before = law.memory(state)
        (cc, _), state = law.step(0.1 * sample, y, state)
        after = law.memory(state)
        followed = bool(np.array_equal(after.work.plan[:-1], before.work.plan[1:]))
        assert followed is bool(after.work.counts[SAMPLE] % 4 != 0)
        assert cc == after.work.plan[0]


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["riccati", "osqp", "descent"])
def test_other_solvers_serve_as_well(plant, solver):
    iterations = 10 if solver == "descent" else 1
    default = run(plant, Nmpc(information="oracle"))[0]
    found = run(plant, Nmpc(information="oracle", effort=Effort(solver, iterations)))[0]
    assert found["locked"] == 1.0 and found["mean_power"] > 0.8 * default["mean_power"]


@pytest.mark.slow
def test_failed_plans_fall_back_and_keep_lock(plant):
    settings = Settings()
    waves = lead_in(gy.realise(plant, gy.SeaState(), SEED, 260.0), settings)
    moments = waves.moments.copy()
    moments[:, 2000:2600] = np.nan  # 100 s to 130 s, and so every horizon from 96 s on
    broken_run = _NotInformed(Nmpc(information="oracle").informed(replace(waves, moments=moments)))
    record, timing = run_law(plant, broken_run, waves, settings)
    found = evaluate(plant, record, waves.moments[1], waves.dt, 3.14, 60.0, math.nan)
    assert found["locked"] == 1.0 and np.isfinite(record.commands).all()
    counts = timing.counters
    assert counts["failed_plans"] == pytest.approx(340, abs=3)
    assert counts["fallbacks"] == counts["failed_plans"] - 10


class _NotInformed:
    """The law as it is: the harness is not asked to tell it the waves."""

    def __init__(self, law: Nmpc) -> None:
        self.law, self.period, self.information = law, law.period, "sensors"

    def init(self):
        return self.law.init()

    def step(self, t, y, state):
        return self.law.step(t, y, state)

    def counters(self, state):
        return self.law.counters(state)


@pytest.mark.parametrize(
    ("field", "value", "part"),
    [
        ("information", "none", "oracle, forecast, gauge, sensors"),
        ("horizon", 4.05, "multiple"),
        ("horizon", -1.0, "positive"),
        ("iterations", 0, "positive"),
        ("cc_max", 0.0, "positive"),
        ("motion", -1.0, "negative"),
        ("flywheel", math.nan, "finite"),
        ("lead", math.inf, "finite"),
    ],
)
def test_bad_parameters(field, value, part):
    with pytest.raises(InputError, match=f"nmpc.{field}.*{part}"):
        gy.law("nmpc", **{field: value})


def test_a_law_that_was_told_nothing_says_so():
    with pytest.raises(InputError, match="informed"):
        Nmpc(information="oracle").init()


def test_waves_shorter_than_the_horizon(plant):
    waves = gy.realise(plant, gy.SeaState(), SEED, 3.0)
    with pytest.raises(InputError, match=r"nmpc.horizon.*longer than the waves"):
        Nmpc(information="oracle").informed(waves)


def test_waves_on_another_grid(plant):
    waves = gy.realise(plant, gy.SeaState(), SEED, 20.0, dt=0.08)
    with pytest.raises(InputError, match=r"probe\.dt"):
        Nmpc(information="oracle").informed(waves)
