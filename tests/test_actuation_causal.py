"""Actuators that take their time: causal, continuous, integrated with the plant; those that do not, as before.

Oracles: closed forms, SciPy's integration of u' = clip((aim - u)/T) alone, and a closed loop by DOP853 in which the
actuators are states of their own (`oracles.slow_actuators`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from oracles.slow_actuators import SlowActuator, run_slow
from scipy.integrate import quad, solve_ivp

import gyroctl as gy
from gyroctl.harness.run import Settings, run_law, simulate
from gyroctl.plant.course import Course, control_at, effective, set_out
from gyroctl.plant.equations import LEDGER, OMEGA_RATE
from gyroctl.plant.kernel import move_into, rows
from gyroctl.plant.measurement import read
from gyroctl.robustness import regime
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.studies.evaluation.perturbed_devices import truths

Array = NDArray[np.float64]
PERIOD = 0.1
CC, CG = 0, 1
SLOW = {
    "lag 5 ms": {"cc_lag": 0.005, "cg_lag": 0.005},
    "lag 20 ms": {"cc_lag": 0.02, "cg_lag": 0.02},
    "lag 50 ms": {"cc_lag": 0.05, "cg_lag": 0.05},
    "lag 200 ms": {"cc_lag": 0.2, "cg_lag": 0.2},
    "coupling alone": {"cc_lag": 0.05},
    "generator alone": {"cg_lag": 0.05},
    "rate": {"cc_rate": 1.0, "cg_rate": 0.02},
    "rate and lag": {"cc_rate": 2.5, "cc_lag": 0.03, "cg_rate": 0.05, "cg_lag": 0.02},
    "rate and delay": {"cc_rate": 2.5, "cg_rate": 0.05, "delay": 2},
}


class Chaos(NamedTuple):
    """A number that wanders."""

    x: float


class Switching(NamedTuple):
    """Commands that switch over their whole range and listen to nothing."""

    first: float = 0.37
    period: float = PERIOD

    @property
    def information(self) -> str:
        """What the law looks at."""
        return "none"

    def init(self) -> Chaos:
        """Begin."""
        return Chaos(self.first)

    def step(self, t: float, y: Any, state: Chaos) -> tuple[tuple[float, float], Chaos]:
        """Switch the coupling; the generator takes three values."""
        x = 3.99 * state.x * (1.0 - state.x)
        return (0.3 if x > 0.5 else 0.0, 3e-3 if x < 0.2 else 3.5e-4 * x), Chaos(x)


class Step(NamedTuple):
    """One step of both commands at a time."""

    at: float = 5.0
    cc: float = 0.052
    cg: float = 3.5e-4
    more: float = 2.0  # factor on both after the step
    period: float = PERIOD

    @property
    def information(self) -> str:
        """What the law looks at."""
        return "none"

    def init(self) -> Chaos:
        """Begin."""
        return Chaos(0.0)

    def step(self, t: float, y: Any, state: Chaos) -> tuple[tuple[float, float], Chaos]:
        """Hold, then hold another value."""
        part = self.more if t > self.at - 1e-9 else 1.0
        return (self.cc * part, self.cg * part), state


@pytest.fixture(scope="module")
def waves(device: gy.Plant) -> gy.WaveRealisation:
    return gy.realise(device, gy.SeaState(), 100000, 120.0).blended(20.0)


def course_of(begin: float, aim: float, lag: float, rate: float) -> Course:
    """Course of one control; that of the other is the same."""
    course = Course(*np.zeros((6, 2)))
    set_out(course, np.full(2, lag), np.full(2, rate), np.full(2, begin), np.full(2, aim))
    return course


def run(plant: gy.Plant, law: Any, waves: gy.WaveRealisation, compiled: bool = True, **actuators: Any) -> Record:
    chosen = Settings(blend=20.0, sensors=gy.Sensors.ideal(), actuators=gy.Actuators(**actuators))
    return run_law(plant, law, waves, chosen, compiled=compiled)[0]


# --- the course within an interval -------------------------------------------------------------------------------


values = st.floats(0.0, 0.3)
lags = st.one_of(st.just(0.0), st.floats(1e-4, 2.0))
rates = st.one_of(st.just(0.0), st.floats(1e-2, 50.0))


@settings(deadline=None, max_examples=300)
@given(begin=values, aim=values, lag=lags, rate=rates)
def test_response_to_a_step_moves_from_the_old_value_and_is_short_of_its_end_inside(
    begin: float, aim: float, lag: float, rate: float
) -> None:
    """It never turns back, never passes the aim, and inside the interval has not got where it is at the end."""
    course = course_of(begin, aim, lag, rate)
    time = np.linspace(0.0, PERIOD, 41)
    way = np.array([control_at(course, CC, float(t)) for t in time])
    if lag == 0.0 and rate == 0.0:
        assert np.all(way == aim)
        return
    assert way[0] == pytest.approx(begin, abs=1e-300)
    gone = (way - begin) * np.sign(aim - begin)
    assert np.all(np.diff(gone) >= -1e-15)
    assert np.all((min(begin, aim) <= way) & (way <= max(begin, aim)))
    on_its_way = (gone > 0.0) & (np.abs(way[-1] - aim) > 1e-9)
    if np.any(on_its_way):
        assert np.all(gone[1:-1] < gone[-1])
    if rate > 0.0:
        assert np.all(np.abs(np.diff(way)) <= rate * (time[1] - time[0]) * (1 + 1e-9) + 1e-15)


@pytest.mark.parametrize("lag", [0.003, 0.02, 0.1, 0.7])
@pytest.mark.parametrize("rate", [0.0, 0.4, 3.0])
@pytest.mark.parametrize(("begin", "aim"), [(0.0, 0.3), (0.21, 0.0), (0.1, 0.12)])
def test_course_obeys_its_differential_equation(lag: float, rate: float, begin: float, aim: float) -> None:
    course, limit = course_of(begin, aim, lag, rate), rate or math.inf

    def speed(t: float, u: Array) -> Array:
        return np.clip((aim - u) / lag, -limit, limit)

    found = solve_ivp(speed, (0.0, PERIOD), [begin], "DOP853", rtol=1e-10, atol=1e-12, max_step=1e-3, dense_output=True)
    for t in np.linspace(0.0, PERIOD, 23):
        assert control_at(course, CG, float(t)) == pytest.approx(float(found.sol(t)[0]), abs=1e-7)


@pytest.mark.parametrize(("lag", "rate"), [(0.0, 0.0), (0.004, 0.0), (0.05, 0.0), (0.0, 1.3), (0.03, 2.0), (0.5, 0.1)])
@pytest.mark.parametrize(("begin", "aim"), [(0.0, 0.3), (0.21, 0.02), (0.1, 0.1)])
def test_mean_square_of_a_course(lag: float, rate: float, begin: float, aim: float) -> None:
    course = course_of(begin, aim, lag, rate)
    bends = [float(bend) for bend in (course.turn[CG], 5.0 * lag) if 0.0 < bend < PERIOD]
    square = quad(lambda t: control_at(course, CG, t) ** 2, 0.0, PERIOD, points=bends or None, epsabs=1e-13)[0]
    assert effective(course, CG, PERIOD) ** 2 * PERIOD == pytest.approx(square, rel=1e-8)


# --- causality in the loop ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("slow", [{}, {"cc_lag": 0.05, "cg_lag": 0.2}, {"cc_rate": 0.1, "cg_rate": 1e-3}], ids=str)
def test_a_step_acts_from_its_instant_on_and_not_before(
    device: gy.Plant, waves: gy.WaveRealisation, delay: int, slow: dict[str, float]
) -> None:
    """State and controls up to the step are those of a run without it, to the bit; lagged controls begin there."""
    at = 50 + delay
    plain, stepped = (run(device, Step(more=more), waves, delay=delay, **slow) for more in (1.0, 2.0))
    assert np.all(stepped.commands[50:] == 2.0 * plain.commands[50:])
    np.testing.assert_array_equal(stepped.states[: at + 1], plain.states[: at + 1])
    np.testing.assert_array_equal(stepped.controls[:at], plain.controls[:at])
    assert np.all(stepped.states[at + 1] != plain.states[at + 1], where=[True] * 8 + [False] * 11).all()
    if slow:
        np.testing.assert_array_equal(stepped.controls[at], plain.controls[at])
        assert np.all((stepped.controls[at] < stepped.ends[at]) & (stepped.ends[at] < stepped.commands[at]))
        np.testing.assert_array_equal(stepped.controls[at + 1], stepped.ends[at])
    else:
        np.testing.assert_array_equal(stepped.controls[at], stepped.commands[at])
        assert stepped.moved is None and stepped.ends is stepped.controls


@pytest.mark.parametrize("name", ["coupling", "load_angle", "threshold"])
@pytest.mark.parametrize("slow", [{}, SLOW["rate and lag"], SLOW["rate and delay"]], ids=["plain", "lag", "delay"])
def test_nothing_before_an_instant_depends_on_the_waves_after_it(
    device: gy.Plant, waves: gy.WaveRealisation, name: str, slow: dict[str, float]
) -> None:
    """Waves that differ from 60 s on; the interpolation looks four of its samples, 0.2 s, ahead."""
    moments = waves.moments.copy()
    moments[:, 1200:] *= -0.7
    one, other = (run(device, gy.law(name), each, **slow) for each in (waves, replace(waves, moments=moments)))
    until = 598
    np.testing.assert_array_equal(one.states[: until + 1], other.states[: until + 1])
    np.testing.assert_array_equal(one.commands[: until + 1], other.commands[: until + 1])
    np.testing.assert_array_equal(one.controls[: until + 1], other.controls[: until + 1])
    assert not np.array_equal(one.states[610], other.states[610])
    assert not np.array_equal(one.commands, other.commands)


def test_command_acts_as_late_as_its_delay_from_the_first_on(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """Until the first one acts the controls stay as on the orbit of the start."""
    record = run(device, Switching(), waves, delay=3)
    np.testing.assert_array_equal(record.controls[3:], record.commands[:-3])
    np.testing.assert_array_equal(record.controls[:3], [[0.052, 3.5e-4]] * 3)


# --- with the plant ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lag 5 ms", "lag 50 ms", "generator alone", "rate", "rate and lag", "rate and delay"])
def test_loop_is_that_of_an_actuator_with_a_state_of_its_own(
    device: gy.Plant, waves: gy.WaveRealisation, name: str
) -> None:
    """Eight seconds of a switching coupling by DOP853: states, controls, and three energies."""
    slow, law, samples = SLOW[name], Switching(), 80
    record = run(device, law, waves, **slow)
    delay = int(slow.get("delay", 0))
    actuators = [
        SlowActuator(*(slow.get(f"{which}_{what}", 0.0) for what in ("lag", "rate"))) for which in ("cc", "cg")
    ]
    before = (0.052, 3.5e-4)
    asked: list[tuple[float, float]] = []
    state = law.init()

    def command(sample: int, x: Array) -> tuple[float, float]:
        nonlocal state
        u, state = law.step(PERIOD * sample, read(x), state)
        asked.append(u)
        return asked[sample - delay] if sample >= delay else before

    start = record.states[0, :14]
    found = run_slow(device, actuators, command, start, before, waves.moments, waves.dt, samples)
    np.testing.assert_array_equal(asked, record.commands[:samples])
    np.testing.assert_allclose(record.ends[:samples], found.controls[1:], rtol=1e-7, atol=1e-9)
    scale = np.abs(found.states).max(axis=0)
    np.testing.assert_allclose(record.states[: samples + 1, :14] / scale, found.states / scale, atol=2e-5)
    energy = record.states[samples, 14:]
    assert energy[LEDGER.index("generator")] == pytest.approx(found.integrals[-1, 0], rel=2e-6)
    assert energy[LEDGER.index("slip")] == pytest.approx(found.integrals[-1, 2], rel=1e-5)
    second = float(np.sum(record.cg_rms[:samples] ** 2 * 0.5 * np.sum(speeds(record, samples) ** 4, axis=0)) * PERIOD)
    assert second == pytest.approx(found.integrals[-1, 1], rel=2e-3)


def speeds(record: Record, samples: int) -> Array:
    """Flywheel speed at both ends of each interval, (2, samples)."""
    speed = record.states[: samples + 1, OMEGA_RATE]
    return np.array([speed[:-1], speed[1:]])


def test_law_that_listens_sees_the_lagged_plant(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """Feedback through the lag: `coupling` with ideal sensors, ten seconds by DOP853."""
    law, slow = gy.law("coupling"), {"cc_lag": 0.05, "cg_lag": 0.2}
    record = run(device, law, waves, **slow)
    state = law.init()

    def command(sample: int, x: Array) -> tuple[float, float]:
        nonlocal state
        u, state = law.step(PERIOD * sample, read(x), state)
        return u

    actuators = [SlowActuator(0.05), SlowActuator(0.2)]
    start = record.states[0, :14]
    found = run_slow(device, actuators, command, start, (0.052, 3.5e-4), waves.moments, waves.dt, 100)
    assert np.ptp(record.commands[:100, 0]) > 0.1, "the law has to switch for this to tell"
    np.testing.assert_allclose(record.states[100, :14], found.states[100], rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(record.ends[99], found.controls[100], rtol=1e-3)


@pytest.mark.parametrize("slow", SLOW.values(), ids=SLOW)
@pytest.mark.parametrize("law", [Switching(), gy.law("coupling")], ids=["switching", "coupling"])
def test_ledger_closes_while_controls_move(
    device: gy.Plant, waves: gy.WaveRealisation, slow: dict[str, Any], law: Any
) -> None:
    record = run(device, law, waves, **slow)
    found = evaluate(device, record, waves.moments[1], waves.dt, 3.14, 20.0, 1.0)
    assert found["ledger_residual"] < 1e-6


@pytest.mark.parametrize("lag", [0.005, 0.05, 0.4])
@pytest.mark.parametrize("rate", [0.0, 1e-8])
def test_energy_of_a_lagged_generator_on_a_flywheel_at_constant_speed(
    device: gy.Plant, lag: float, rate: float
) -> None:
    """No waves, a ring at rest, a generator too weak to slow the flywheel: its energy is omega'^2 times the course."""
    k, speed, aim, intervals = device.coefficients, 70.0, 1e-9, 12
    y = np.zeros(rows(k))
    y[OMEGA_RATE] = speed
    work, moments, weight, now = np.empty((5, y.size)), np.empty(6), np.empty(8), np.empty((2, 1))
    held, moved, still = np.zeros(2), np.zeros(3), np.zeros(2 * 40)
    course = Course(*np.zeros((6, 2)))
    for i in range(intervals):
        set_out(course, np.array([0.0, lag]), np.array([0.0, rate]), held, np.array([0.0, aim]))
        move_into(y, work, moments, weight, k, now, course, PERIOD * i, PERIOD, 0.01, 1.0, 1.0, still, 0.05, moved)
        held = moved[:2].copy()
    time = PERIOD * intervals
    ramp = max(aim / rate - lag, 0.0) if rate > 0.0 else 0.0
    begin = aim - rate * lag if ramp > 0.0 else 0.0
    short = (aim - begin) * lag * (1.0 - math.exp(-(time - ramp) / lag))
    energy = speed**2 * (0.5 * ramp * begin + aim * (time - ramp) - short)
    assert y[OMEGA_RATE] == pytest.approx(speed, rel=1e-6)
    assert y[-5 + LEDGER.index("generator")] == pytest.approx(energy, rel=1e-5)
    assert y[-5 + LEDGER.index("generator")] < 0.999 * speed**2 * aim * time, "at once it would have been more"


def test_lag_that_vanishes_is_none(device: gy.Plant) -> None:
    """From 1 ms to 1 us the run comes near that of an actuator that jumps, in proportion to the lag."""
    law, short = Switching(), gy.realise(device, gy.SeaState(), 100000, 20.0).blended(10.0)
    jumping = run(device, law, short)
    gaps = []
    for lag in (1e-3, 1e-4, 1e-5, 1e-6):
        record = run(device, law, short, cc_lag=lag, cg_lag=lag)
        gaps.append(float(np.abs(record.states[-1] - jumping.states[-1]).max()))
    assert gaps[0] > 5.0 * gaps[1] > 25.0 * gaps[2]
    assert gaps[3] < 1e-3 * np.abs(jumping.states[-1]).max()


# --- every path that uses the loop -------------------------------------------------------------------------------


@pytest.mark.parametrize("slow", SLOW.values(), ids=SLOW)
def test_compiled_and_plain_loop_have_the_same_bits(
    device: gy.Plant, waves: gy.WaveRealisation, slow: dict[str, Any]
) -> None:
    one, other = (run(device, gy.law("load_angle"), waves, compiled, **slow) for compiled in (True, False))
    for name in ("states", "commands", "controls", "ends", "cg_rms"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_controls_are_continuous_and_each_channel_has_its_own_lag(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    both = run(device, Switching(), waves, cc_lag=0.05, cg_rate=0.01)
    np.testing.assert_array_equal(both.controls[1:], both.ends[:-1])
    one = run(device, Switching(), waves, cc_lag=0.05)
    np.testing.assert_array_equal(one.controls[:, CG], one.commands[:, CG])
    np.testing.assert_array_equal(one.ends[:, CG], one.commands[:, CG])
    np.testing.assert_array_equal(one.cg_rms, one.commands[:, CG])
    np.testing.assert_array_equal(one.controls[:, CC], both.controls[:, CC])


def test_trajectory_ends_with_what_acts_at_its_end(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    chosen = Settings(blend=20.0, actuators=gy.Actuators(cc_lag=0.05, cg_lag=0.05))
    ds = simulate(device, Switching(), waves, chosen)
    record, _ = run_law(device, Switching(), waves, chosen)
    assert (float(ds.cc[-1]), float(ds.cg[-1])) == tuple(record.ends[-1])
    np.testing.assert_array_equal(ds.cc[:-1], record.controls[:, CC])
    assert float(ds.power[-1]) == record.ends[-1, CG] * record.states[-1, OMEGA_RATE] ** 2


def test_smoothness_of_the_power_is_that_between_the_samples(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """A lag much shorter than the period changes the CV little, a long one much."""
    cv = {}
    for lag in (0.0, 0.002, 0.2):
        record = run(device, Switching(), waves, cg_lag=lag)
        cv[lag] = evaluate(device, record, waves.moments[1], waves.dt, 3.14, 20.0, 1.0)["power_cv"]
    assert cv[0.002] == pytest.approx(cv[0.0], rel=0.03) and cv[0.002] < cv[0.0]
    assert cv[0.2] < 0.6 * cv[0.0]


def test_regime_is_found_and_left_with_slow_actuators(device: gy.Plant) -> None:
    """A disturbed run goes on from the actuators' own values, as plain Python too."""
    wave = gy.Regular(0.2, 3.14)
    orbit = gy.lock_orbit(device, wave, 0.052, 3.5e-4)
    found = regime.settle(orbit, wave, gy.law("load_angle"), gy.Actuators(cc_lag=0.05, cg_lag=0.2))
    assert found.held[CG] != found.actuators.cg_max
    on = regime.simulate(found, found.x, 3)
    plain = regime.simulate(found, found.x, 3, law=found.law)
    np.testing.assert_array_equal(on.record, plain.record)
    quick = regime.settle(orbit, wave, gy.law("load_angle"), gy.Actuators())
    assert found.power == pytest.approx(quick.power, rel=0.2) and found.power != quick.power


def test_step_too_long_for_the_coupling_of_the_start_is_refused(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """The law's own coupling would allow it, but the lag begins at that of the orbit."""
    law = gy.law("constant", cc=0.01)
    coarse = Settings(dt=0.1, blend=20.0)
    run_law(device, law, waves, coarse)
    for slow in ({"cc_lag": 0.2}, {"delay": 1}):
        with pytest.raises(gy.InputError, match="unstable"):
            run_law(device, law, waves, replace(coarse, actuators=gy.Actuators(**slow)))


def test_slow_actuators_are_cases_of_the_robustness_study(device: gy.Plant) -> None:
    """Each differs from what is given in one number, and its name says in which."""
    given = Settings(actuators=gy.Actuators(cg_max=0.01, delay=1))
    found = {truth.name: truth for truth in truths(given)}
    wanted: dict[str, dict[str, float]] = {f"cc lag {ms} ms": {"cc_lag": ms / 1000} for ms in (20, 50, 100)}
    wanted |= {"cc rate 1 Nms/s": {"cc_rate": 1.0}, "one sample late": {"delay": 2}, "two samples late": {"delay": 3}}
    for name, changes in wanted.items():
        assert found[name].settings == replace(given, actuators=replace(given.actuators, **changes)), name
        assert found[name].plant.coefficients == device.coefficients
