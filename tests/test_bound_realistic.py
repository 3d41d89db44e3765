"""The bound beyond the linear plant: the waves of a part, honest replay, lag, what the model misses, limits, caps."""

from __future__ import annotations

import numpy as np
import pytest
from test_bound import acted, check_gradient

import gyroctl as gy
from gyroctl.harness.run import run_law
from gyroctl.plant.equations import OMEGA
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound import Cut, cut
from gyroctl.studies.bound.cap import INSIDE, absorbed, float_alone, float_states, momentum
from gyroctl.studies.bound.misfit import mended, missed
from gyroctl.studies.bound.outcome import Outcome, summary
from gyroctl.studies.bound.replay import replay
from gyroctl.studies.bound.search import (
    COSTLY,
    Effort,
    Found,
    _picked,
    _plan_of,
    best_found,
    closer,
    problem_of,
    quick,
    ticks,
    verify,
)
from gyroctl.studies.bound.window import asked, follow, model_of, rates, reduced

CONSTANT = {"cc": 0.104, "cg": 1.5e-4}


@pytest.fixture(scope="module")
def real() -> Cut:
    """Twenty seconds of a sea on the realistic plant, whose coupling lags."""
    return cut(gy.zhang2017("realistic"), gy.SeaState(gamma=5.0), 100001, 20.0)


def test_part_of_the_waves_is_that_part(real: Cut) -> None:
    """Every signal and every pressure from 100 s on, bit for bit; it is not blended again."""
    whole = real.waves.whole
    assert whole is not None
    signals, part = whole.signals(real.plant), real.waves.signals(real.plant)
    assert part.shape[0] == len(real.plant.channels) > 2
    np.testing.assert_array_equal(part, signals[:, 2000:])
    np.testing.assert_array_equal(part[:2], real.waves.moments)
    held, of_part = whole.held(real.plant), real.waves.held(real.plant)
    assert held is not None and of_part is not None
    np.testing.assert_array_equal(of_part.fields.rows, held.fields.rows[:, 2000:])
    with pytest.raises(gy.InputError, match="last part"):
        gy.realise(real.plant, gy.SeaState(gamma=5.0), 100001, 150.0).since(100.0).blended(10.0)


def test_a_run_goes_on_in_its_part() -> None:
    """Without a lag, a run that begins where another one passes goes on as that one did, pressure held anew or not."""
    made = cut(gy.zhang2017("realistic"), gy.SeaState(gamma=5.0), 100001, 20.0, lag=0.0)
    law = gy.law("constant", **CONSTANT)
    whole, _ = run_law(made.plant, law, made.waves.whole, made.settings)
    part, n = made.run(law, "constant"), made.start.size
    size = whole.states[1000:1200, :n].std(axis=0)
    away = np.abs(part.states[:100, :n] - whole.states[1000:1100, :n])
    assert np.all(np.delete(away, OMEGA, axis=1) < 0.01 * np.delete(size, OMEGA) + 1e-6)


def test_replay_of_a_laws_own_commands_is_its_run(real: Cut) -> None:
    """To rounding: panels, friction, lag, ledger; and half the coupling is another run."""
    own = real.run(gy.law("coupling"), "coupling")
    n = real.intervals
    again = replay(real, lambda i, y, acts: (own.commands[i, 0], own.commands[i, 1]), n)
    np.testing.assert_allclose(again.states, own.states[: n + 1], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(again.controls, own.controls[:n], rtol=1e-12, atol=1e-15)
    assert again.moved is not None and own.moved is not None and again.lag == own.lag == 0.02
    np.testing.assert_allclose(again.moved, own.moved[:n], rtol=1e-12, atol=1e-15)
    assert real.worth(again)["ledger_residual"] < 1e-6
    other = replay(real, lambda i, y, acts: (0.5 * own.commands[i, 0], own.commands[i, 1]), n)
    assert np.abs(other.states - again.states).max() > 0.1


def test_control_of_a_replay_sees_state_and_coupling_of_now(real: Cut) -> None:
    """What it is handed is the record's own row, and the coupling on its way along the exponential of the lag."""
    seen = []
    rng = np.random.default_rng(1)
    cc = rng.choice([0.0, 0.2], 12)

    def control(i, y, acts):
        seen.append((i, y.copy(), acts))
        return cc[i], 1e-4

    run = replay(real, control, 12)
    assert [i for i, _, _ in seen] == list(range(12))
    np.testing.assert_array_equal(np.array([y for _, y, _ in seen]), run.states[:-1])
    acts = seen[0][2]
    for i in range(12):
        assert seen[i][2] == pytest.approx(acts, abs=1e-12)
        acts = cc[i] + (acts - cc[i]) * np.exp(-0.1 / 0.02)


def test_gradient_is_exact_with_rates_and_lag(real: Cut) -> None:
    """Four numbers an instant, all terms of the smooth plant, and a coupling that is late."""
    assert problem_of(real, 2, real.motion).width == 4
    check_gradient(real)


def test_coupling_acts_as_it_lags(real: Cut) -> None:
    """Means of the exponential over each model step, by quadrature; and the adjoint of that map, by its definition."""
    w, lag = problem_of(real, 4, real.motion), 0.02
    rng = np.random.default_rng(2)
    cc, by = rng.uniform(0.0, 0.3, 7), rng.normal(size=28)
    now, means = w.before, []
    for aim in cc:
        for q in range(4):
            t = 0.025 * q + 0.025 * (np.arange(2000) + 0.5) / 2000
            means.append(np.mean(aim + (now - aim) * np.exp(-t / lag)))
        now = aim + (now - aim) * np.exp(-0.1 / lag)
    np.testing.assert_allclose(acted(w, cc), means, rtol=1e-6)
    slope = np.zeros(7)
    asked(w, by, slope)
    moved = [by @ (acted(w, cc + way) - acted(w, cc)) for way in np.eye(7)]
    np.testing.assert_allclose(slope, moved, rtol=1e-9)


def test_rates_of_the_moments_are_their_slopes(real: Cut) -> None:
    """Of a sum of waves as short as 8 rad/s, to a thousandth."""
    time = np.arange(400) * 0.05
    moments = np.array([np.sin(3.0 * time), np.cos(8.0 * time + 1.0)])
    slopes = np.array([3.0 * np.cos(3.0 * time), -8.0 * np.sin(8.0 * time + 1.0)])
    assert np.abs(rates(time, moments) - slopes)[:, 5:-5].max() < 8e-3
    known = problem_of(real, 2, real.motion).moments.reshape(-1, 4)  # the spacing is the waves' own
    np.testing.assert_allclose(known[:200, :2], real.waves.moments[:, :200].T, atol=1e-6)
    middle = (known[2:200, :2] - known[:198, :2]) / 0.1
    assert np.abs(known[1:199, 2:] - middle).max() < 0.05 * np.abs(middle).max()


def test_what_the_model_misses_is_found(real: Cut) -> None:
    """Of a run by the model itself under two more moments in each interval these are found, and a window mended."""
    w, n = problem_of(real, 2, real.motion), 12
    rng = np.random.default_rng(4)
    more, cc, power = rng.normal(size=(n, 2)) * 10.0, rng.uniform(0.0, 0.2, n), 8.0
    step, _ = model_of(real.plant)
    path, states = [w.start], np.empty((3, w.start.size))
    known, acts = w.moments.reshape(-1, 4), acted(w, cc)
    for i in range(n):
        held = known[2 * i : 2 * i + 3].copy()
        held[:, :2] += more[i]
        follow(step, w._replace(moments=held.ravel()), 0, path[-1], acts[2 * i : 2 * i + 2], np.array([power]), states)
        path.append(states[2].copy())
    rows = [row for row in range(len(real.plant.rolling.labels)) if row != OMEGA]
    whole = np.zeros((n + 1, real.start.size))
    whole[:, rows] = path
    np.testing.assert_array_equal(reduced(real.plant, whole), path)
    controls = np.stack([cc, power / whole[:-1, OMEGA + 4] ** 2], axis=1)
    record = Record(whole, controls, controls, 0.1, 0)
    np.testing.assert_allclose(missed(real.plant, w, record), more, atol=0.02)
    again = mended(real.plant, w, record).moments.reshape(-1, 4)
    np.testing.assert_allclose((again - known)[1 : 2 * n : 2, :2], more, atol=0.02)  # middles of intervals
    np.testing.assert_array_equal(again[2 * n + 1 :], known[2 * n + 1 :])


def test_limits_of_motion_are_those_of_a_constant_pair(real: Cut) -> None:
    """Or 0.35 where that is more; one that is asked for holds for both; a run beyond one of them has no score."""
    values = real.worth(real.counted(real.run(gy.law("constant", **CONSTANT), "constant")))
    assert real.motion.phi1 == pytest.approx(max(values["phi1_p98"], 0.35), abs=0.02)
    assert real.motion.phi3 == 0.25
    assert real.motion.room({"phi1_p98": 0.1, "phi3_p98": 0.26}) == pytest.approx(-0.01)
    assert closer(real.motion, 0.05).room({"phi1_p98": 0.1, "phi3_p98": 0.15}) == pytest.approx(0.05)
    own = cut(real.plant, real.waves.sea, 100001, 20.0, lag=0.05, motion=0.4)
    assert tuple(own.motion) == (0.4, 0.4)
    assert own.settings.actuators.cc_lag == 0.05


def test_momentum_is_all_that_a_slipping_axis_gives_to_the_float(real: Cut) -> None:
    """Integrate I v' = Me - H' - d v - k phi - Mr along a run whose contact slips: it ends where the run ended."""
    plant = gy.zhang2017(contact="friction", traction=0.3, lever_gyroscopic=False)
    start = cut(plant, gy.SeaState(gamma=5.0), 100001, 20.0, lag=0.0)
    run = start.run(gy.law("coupling"), "coupling")
    alone, x, H = float_alone(plant), float_states(plant, run.states), momentum(plant, run.states)
    ends = start.waves.moments[:, :: round(run.period / start.waves.dt)][:, : x.shape[1]]
    flow = run.period * (alone.A @ x[:, 1:-1] + alone.B @ ends[:, 1:-1]).sum(axis=1)
    flow += 0.5 * run.period * (alone.A @ (x[:, 0] + x[:, -1]) + alone.B @ (ends[:, 0] + ends[:, -1]))
    moved = flow - alone.B @ (H[:, -1] - H[:, 0])
    rows = list(alone.rates)
    assert moved[rows] == pytest.approx((x[:, -1] - x[:, 0])[rows], abs=0.02 * float(np.ptp(x[rows])))


def test_what_is_taken_inside_and_outside_is_all(real: Cut) -> None:
    """Taken inside, and lost or stored outside, make up what the waves brought in, second order and all."""
    run = real.counted(real.run(gy.law("coupling"), "coupling"))
    n, plant = real.start.size, real.plant
    energy = dict(zip(plant.ledger, run.states[-1, n:] - run.states[0, n:], strict=True))
    x = float_states(plant, run.states[[0, -1]])
    outside = 0.5 * np.einsum("is,ij,js->s", x, float_alone(plant).energy, x)
    brought = energy["wave_input"] + energy["second_order"]
    left = brought - sum(energy[name] for name in ("radiated", "hinge", "drag")) - (outside[1] - outside[0])
    assert set(plant.ledger) - set(INSIDE) == {"wave_input", "second_order", "radiated", "hinge", "drag"}
    assert absorbed(plant, run) * real.duration == pytest.approx(left, rel=1e-6)


def test_no_cap_is_claimed_beyond_the_linear_plant(real: Cut) -> None:
    """The linear float's stands beside it by a name of its own, in window and summary."""
    run = real.counted(real.run(gy.law("constant", **CONSTANT), "constant"))
    found = Found(real.worth(run), run, "constant itself", float("nan"), {})
    written = Outcome(real, {"smooth": found}, {"constant": run}, 30.0, 12.5).record()
    assert written["cap_w"] is None and written["linear_cap_w"] == 12.5
    assert written["motion_limits_rad"] == {"phi1": real.motion.phi1, "phi3": 0.25}
    whole = summary([written])
    assert whole["cap_w"] is None and whole["linear_cap_w"] == 12.5
    assert whole["motion_limits_rad"]["phi3"] == [0.25, 0.25]


def test_plans_begin_with_the_best_runs(real: Cut) -> None:
    """The best that keep lock and limits, twins once; with an effort of one the best alone."""
    names = {"a": 1.2e-4, "b": 1.5e-4, "twin of b": 1.5e-4}
    runs = {name: real.run(gy.law("constant", cc=0.104, cg=cg), name) for name, cg in names.items()}
    worth = {name: real.worth(real.counted(run)) for name, run in runs.items()}
    value = {name: v["harvest_w"] + COSTLY * min(real.motion.room(v), 0.0) for name, v in worth.items()}
    best = max(value, key=lambda name: value[name])
    (picked,) = _picked(real, runs, Effort(picked=1))
    assert value[picked] == value[best]
    assert len(_picked(real, runs, Effort(picked=4))) == 2


@pytest.mark.slow
def test_search_ends_above_the_law_that_it_began_with(real: Cut) -> None:
    """Its plan, followed by the plant, keeps its promise to a twentieth, limits and lock; every stage is told."""
    effort, told = quick(real.plant), []
    found = best_found(real, {}, effort, lambda: told.append(1))
    assert len(told) == ticks(real.plant, 0, effort)
    (name,) = found.starts
    begun, _ = found.starts[name]
    assert found.values["harvest_w"] > begun
    assert found.values["locked"] and real.motion.room(found.values) >= 0.0
    if found.plan is not None:
        assert found.planned_w == pytest.approx(found.values["harvest_w"], rel=0.05)
        w = problem_of(real, 4, real.motion)
        again = verify(real, w, _plan_of(real, w, _long(real, found)), "again")
        assert again.values["harvest_w"] > 0.9 * found.values["harvest_w"]


def _long(real: Cut, found: Found) -> Record:
    """A run through window and tail that begins with the one found."""
    record = found.record
    n = real.intervals
    end = lambda i, y, acts: tuple(record.commands[min(i, n - 1)])  # noqa: E731
    return replay(real, end, n + 100)
