"""The upper bound: exact gradient, honest replay, never below a law, and a cap that holds."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers.nmpc.problem import weights
from gyroctl.harness.run import run_law
from gyroctl.plant.kernel import hold_one, rows
from gyroctl.studies.bound import Cut, Effort, bound_report, cut, loosened, momentum_cap
from gyroctl.studies.bound.cap import absorbed, float_alone, float_states, momentum
from gyroctl.studies.bound.cut import WITHIN
from gyroctl.studies.bound.search import best_found, closer, problem_of, verify
from gyroctl.studies.bound.shooting import Joints, Slopes, optimise, shoot
from gyroctl.studies.bound.starts import receding
from gyroctl.studies.bound.window import SUBSTEPS, acting, follow, model_of, reduced, window

QUICK = Effort(rounds=2, iterations=100, beams=1, width=2, each=1, finalists=1, repairs=1)


@pytest.fixture(scope="module")
def short(device: gy.Plant) -> Cut:
    """Thirty seconds of a sea."""
    return cut(device, gy.SeaState(gamma=5.0), 100001, 30.0)


def _problem(cut: Cut, substeps: int, intervals: int):
    w = weights(cut.plant, 2000.0, 0.1, 0.1, 5.0, 3.0, 0.0, 0.3)  # tight: every term of the cost acts
    return window(cut, w, intervals, substeps, closing=0.01)


def acted(w, cc):
    """Coupling that acts in each model step. [Nms]"""
    out = np.empty(cc.size * w.substeps)
    acting(w, w.before, cc, out)
    return out


def test_gradient_is_exact(short: Cut) -> None:
    """Against the fourth-order central difference of the augmented Lagrangian, in cc, power and the joints."""
    check_gradient(short)


def check_gradient(cut: Cut) -> None:
    """Compare the slopes of `shoot` with differences, on two seconds and a half to a piece."""
    w, piece, n = _problem(cut, 2, 60), 25, 60
    rng = np.random.default_rng(3)
    m = w.start.size
    step, pullback = model_of(cut.plant)
    cc, power = rng.uniform(0.02, 0.2, n), rng.uniform(2.0, 20.0, n)
    path = np.empty((n * 2 + 1, m))
    follow(step, w, 0, w.start, acted(w, cc), power, path)
    scale = np.std(path, axis=0)
    nodes = path[: n * 2 : piece * 2] + 0.1 * scale * rng.normal(size=(3, m))
    nodes[0] = w.start
    joints = Joints(piece, scale, rng.normal(size=(3, m)) * 5.0, 40.0)
    states = np.empty((piece * 2 + 1, m))

    def value(cc, power, nodes):
        slopes = Slopes(np.empty(n), np.empty(n), np.empty((3, m)))
        return shoot(step, pullback, w, cc, power, nodes, joints, slopes, states), slopes

    _, slopes = value(cc, power, nodes)
    sizes = (np.full(n, 0.05), np.full(n, 5.0), np.broadcast_to(scale, (3, m)) * (np.arange(3) > 0)[:, None])
    for part in range(3):
        way = rng.normal(size=slopes[part].shape) * sizes[part]

        def along(h: float, part: int = part, way=way) -> float:
            at = [cc, power, nodes]
            at[part] = at[part] + h * way
            return value(*at)[0]

        h = 1e-4
        slope = (8.0 * (along(h) - along(-h)) - along(2 * h) + along(-2 * h)) / (12.0 * h)
        assert float(np.sum(slopes[part] * way)) == pytest.approx(slope, rel=1e-6)


def test_window_starts_where_the_laws_do(short: Cut) -> None:
    """The moments of a window are those of the realisation 100 s on, bit for bit."""
    sea = short.waves.sea
    whole = gy.realise(short.plant, sea, 100001, 150.0)
    np.testing.assert_array_equal(short.waves.moments, whole.moments[:, 2000:])
    assert short.waves.duration == pytest.approx(50.0)
    assert short.run(gy.law("coupling"), "coupling").states[0, : short.start.size] == pytest.approx(short.start)


def test_model_follows_the_plant(short: Cut) -> None:
    """Two seconds of switching coupling without feedback: the fine model against the truth kernel at dt 0.0025."""
    w = problem_of(short, 4, WITHIN)
    rng = np.random.default_rng(0)
    cc, power = rng.choice([0.0, 0.3], 20), np.full(20, 12.0)
    path = np.empty((81, w.start.size))
    follow(model_of(short.plant)[0], w, 0, w.start, acted(w, cc), power, path)
    k = short.plant.coefficients
    y = np.zeros(rows(k))
    y[: short.start.size] = short.start
    flat = np.ascontiguousarray(short.waves.moments.T).ravel()
    for i in range(20):
        y = hold_one(y, k, cc[i], power[i] / y[7] ** 2, 0.1 * i, 0.1, 40, flat, short.waves.dt)
    size = np.std(path, axis=0)
    assert np.all(np.abs(path[-1] - reduced(short.plant, y)) < 0.02 * size + 0.002)


@pytest.mark.slow
def test_optimiser_improves_and_the_replay_agrees(short: Cut) -> None:
    """The plan gains on its start by the true plant's own account, at constant power, and keeps its promise to 2 %."""
    w = problem_of(short, SUBSTEPS, closer(WITHIN, 0.02))
    start = receding(short.plant, w, 12.0)
    before = verify(short, w, start, "receding")
    plan = optimise(short.plant, w, start, True, 4, 150, rho=300.0)
    after = verify(short, w, plan, "optimised")
    assert before.planned_w == pytest.approx(before.values["harvest_w"], rel=0.02)
    assert after.planned_w == pytest.approx(after.values["harvest_w"], rel=0.02)
    assert after.values["harvest_w"] > before.values["harvest_w"]
    assert after.values["power_cv"] < 0.02
    assert after.values["ledger_residual"] < 1e-4
    assert np.ptp(plan.power) == 0.0
    assert plan.cc.min() >= 0.0 and plan.cc.max() <= w.cc_max


@pytest.mark.slow
def test_bound_is_never_below_a_law(short: Cut) -> None:
    """And never above the cap; freeing the power loses nothing."""
    runs = {name: short.run(gy.law(name), name) for name in ("coupling", "constant")}
    smooth = best_found(short, runs, QUICK)
    free = loosened(short, smooth, runs, QUICK)
    best_law = max(short.worth(short.counted(run))["harvest_w"] for run in runs.values())
    assert best_law < smooth.values["harvest_w"] <= free.values["harvest_w"]
    assert max(smooth.values["phi1_p98"], smooth.values["phi3_p98"]) <= 0.35
    assert smooth.values["locked"]
    assert set(smooth.starts) >= set(runs)
    most = float(np.linalg.norm(momentum(short.plant, free.record.states), axis=0).max())
    cap = momentum_cap(short.plant, short.waves, short.start, short.duration, most)
    assert 0.0 < absorbed(short.plant, free.record) < cap < 2.0 * absorbed(short.plant, free.record)


@pytest.mark.slow
def test_a_law_that_beats_the_search_is_the_bound(short: Cut) -> None:
    """With no effort the search ends below a good run, which then stands in the bound's place."""
    w = problem_of(short, SUBSTEPS, closer(WITHIN, 0.02))
    good = verify(short, w, receding(short.plant, w, 12.0), "good")
    none = Effort(rounds=1, iterations=1, beams=0, finalists=0)
    steady = loosened(short, good, {"law": short.run(gy.law("constant"), "law")}, none)
    assert steady.values["harvest_w"] >= good.values["harvest_w"]


def test_exchange_of_momentum_is_all_that_acts_on_the_float(short: Cut) -> None:
    """Integrate I v' = Me - H' - d v - k phi - Mr along a run by a law: it ends where the run ended."""
    plant = short.plant.replace(lever_gyroscopic=False)
    run, _ = run_law(plant, gy.law("coupling"), short.waves, short.settings, start=short.start)
    alone = float_alone(plant)
    x = float_states(plant, run.states)
    H = momentum(plant, run.states)
    ends = short.waves.moments[:, :: round(run.period / short.waves.dt)][:, : x.shape[1]]
    # over one step by the trapezoid, summed over the run: what is left is of the order of the sampling
    flow = run.period * (alone.A @ x[:, 1:-1] + alone.B @ ends[:, 1:-1]).sum(axis=1)
    flow += 0.5 * run.period * (alone.A @ (x[:, 0] + x[:, -1]) + alone.B @ (ends[:, 0] + ends[:, -1]))
    moved = flow - alone.B @ (H[:, -1] - H[:, 0])
    rates = list(alone.rates)
    assert moved[rates] == pytest.approx((x[:, -1] - x[:, 0])[rates], abs=0.02 * float(np.ptp(x[rates])))


def test_cap_of_a_still_device_is_nothing_to_take(short: Cut) -> None:
    """With next to no momentum next to nothing can be taken; and more momentum never takes less."""
    taken = [momentum_cap(short.plant, short.waves, short.start, 10.0, most, every=2) for most in (26.5, 30.0)]
    assert 0.0 < taken[0] < taken[1]


@pytest.mark.slow
def test_cap_in_a_regular_wave_is_that_of_linear_theory(device: gy.Plant) -> None:
    """Long after the start, in a small wave with ample momentum: |Me|^2/(8 B) in each direction."""
    w, eta = 3.14, 0.002
    waves = gy.realise(device, gy.Regular(2.0 * eta, w), 1, 160.0)
    start = np.zeros(14)
    start[7] = 70.85
    whole, first = (momentum_cap(device, waves, start, T, 1e3) * T for T in (160.0, 80.0))
    k = device.coefficients
    expected = 0.0
    for row, d, p, q in ((0, k.d1, k.p1, k.q1), (1, k.d3, k.p3, k.q3)):
        moment = abs(device.excitation(np.array([w]), 0.0)[row, 0]) * eta
        resistance = d + (np.polyval(p, 1j * w) / np.polyval([1.0, *q], 1j * w)).real
        expected += moment**2 / (8.0 * resistance)
    assert (whole - first) / 80.0 == pytest.approx(expected, rel=0.01)


def test_bad_input_is_refused(device: gy.Plant, tmp_path) -> None:
    """Each error names its field, and nothing is written."""
    sea = gy.SeaState()
    file = tmp_path / "file"
    file.write_text("")
    cases = [
        ("duration", lambda: cut(device, sea, 100000, 5.0)),
        ("duration", lambda: cut(device, sea, 100000, 1e5)),
        ("motion", lambda: cut(device, sea, 100000, 30.0, motion=0.01)),
        ("seeds", lambda: bound_report(device, sea, [], 30.0, {}, tmp_path / "out")),
        ("seeds", lambda: bound_report(device, sea, [1, 1], 30.0, {}, tmp_path / "out")),
        ("out", lambda: bound_report(device, sea, [1], 30.0, {}, file)),
        ("plant", lambda: float_alone(gy.zhang2017("paper"))),
    ]
    for field, call in cases:
        with pytest.raises(gy.InputError) as error:
            call()
        assert error.value.field == field
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_report_and_command(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    """One quick window from the command line: the files, the table, the fractions."""
    import json

    from gyroctl.cli.bound import _seeds, bound
    from gyroctl.studies.bound import table

    bound(seeds="100001", duration=20.0, law=["constant cc=0.104 cg=1e-4"], out=tmp_path / "b", quick=True)
    content = json.loads(capsys.readouterr().out)
    assert content == json.loads((tmp_path / "b" / "bound.json").read_text())
    assert (tmp_path / "b" / "bound.png").stat().st_size > 10_000
    window = content["windows"][0]
    law = window["laws"]["constant cc=0.104 cg=1e-4"]
    assert law["fraction"]["smooth"] == pytest.approx(law["harvest_w"] / window["bounds"]["smooth"]["harvest_w"])
    assert window["bounds"]["smooth"]["absorbed_w"] < window["cap_w"]
    assert any("constant" in line for line in table(content))
    assert _seeds("1,4-6") == [1, 4, 5, 6]
    for bad in ("", "a", "1-", "-3"):
        with pytest.raises(gy.InputError):
            _seeds(bad)
