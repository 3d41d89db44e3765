"""State and wave moments from the sensors, against dense filters, brute force and the truth of closed-loop runs."""

from __future__ import annotations

from typing import Any, NamedTuple

import control
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

import gyroctl as gy
from gyroctl.harness.run import Settings, run_law
from gyroctl.plant.equations import OMEGA_RATE, PSI, PSI_RATE
from gyroctl.plant.measurement import ROWS
from gyroctl.waves.estimation import SENSOR_NOISE, MomentEstimator, update
from gyroctl.waves.estimation.moment_model import float_model, gains_of, noise_covariance, stationary_gains, transfer
from gyroctl.waves.estimation.ring_filter import predict_ring

Array = NDArray[np.float64]
NOISE = np.array(SENSOR_NOISE)
SEED = 100040


class Record(NamedTuple):
    """A closed loop: true states (n, 14), controls (n, 2), true moments (2, n), measurements (n, 7)."""

    states: Array
    controls: Array
    moments: Array
    measured: Array


class Switching(NamedTuple):
    """A law that works as hard as it can: the coupling between 0 and its limit at every sample, blindly."""

    period: float = 0.1

    @property
    def information(self) -> str:
        return "sensors"

    def init(self) -> tuple[float]:
        return (0.3,)

    def step(self, t: float, y: Any, state: tuple[float]) -> tuple[tuple[float, float], tuple[float]]:
        chaos = 3.99 * state[0] * (1.0 - state[0])
        return (0.3 if chaos > 0.8 else (0.12 * chaos if y.psi_rate > 3.0 else 0.0), 3e-4), (chaos,)


def record(
    plant: gy.Plant, law: Any, sensors: gy.Sensors | None = None, duration: float = 160.0, **actuators: Any
) -> Record:
    sensors = sensors or gy.Sensors()
    settings = Settings(blend=20.0, sensors=sensors, actuators=gy.Actuators(**actuators))
    waves = gy.realise(plant, gy.SeaState(), SEED, duration).blended(20.0)
    run, _ = run_law(plant, law, waves, settings)
    n = run.controls.shape[0]
    errors = sensors.arrays(n, SEED)
    measured = run.states[:n, list(ROWS)] + errors.error
    for channel, quantum in enumerate(errors.quantum):
        if quantum > 0.0:
            measured[:, channel] = np.floor(measured[:, channel] / quantum + 0.5) * quantum
    return Record(run.states[:n, :14], run.commands, waves.moments[:, ::2][:, :n], measured)


def estimate(estimator: MomentEstimator, run: Record) -> tuple[Array, Array, Array]:
    """States (n, 14), moments (n, 2), innovations (n, 7)."""
    state = estimator.init()
    n = run.measured.shape[0]
    x, me, e = np.empty((n, 14)), np.empty((n, 2)), np.empty((n, 7))
    for i in range(n):
        held = run.controls[max(i - 1, 0)]
        update(estimator, state, run.measured[i], held[0], held[1])
        x[i], me[i], e[i] = state.x_hat, state.me_hat, state.innovation
    return x, me, e


def relative(me: Array, run: Record, first: int = 300) -> Array:
    """Mean square error of the moments over their variance."""
    truth = run.moments.T[first:]
    return np.asarray(np.mean((me[first:] - truth) ** 2, axis=0) / np.mean(truth**2, axis=0))


@pytest.fixture(scope="module")
def locked(device: gy.Plant) -> Record:
    return record(device, gy.law("coupling"))


# --- the gains -------------------------------------------------------------------------------------------------------


def test_gains_are_those_of_python_control(device: gy.Plant) -> None:
    model, gains = gains_of(device, gy.SeaState(), NOISE, 0.1, 0.2, 0.3)
    other, covariance, _ = control.dlqe(
        gains.transition, np.eye(len(gains.noise)), model.C, gains.noise, np.diag(NOISE[3:] ** 2)
    )
    scale = np.abs(gains.transition @ gains.gain).max(axis=1, keepdims=True)
    np.testing.assert_allclose(gains.transition @ gains.gain / scale, other / scale, atol=1e-6)
    after = covariance - gains.gain @ model.C @ covariance
    np.testing.assert_allclose(np.diag(gains.variance), np.diag(after), rtol=1e-6)


def test_noise_of_one_period_is_its_integral(device: gy.Plant) -> None:
    model, gains = gains_of(device, gy.SeaState(), NOISE, 0.1, 0.2, 0.3)
    grid = (np.arange(400) + 0.5) * 0.1 / 400
    total = sum(expm(model.A * s) @ model.Q @ expm(model.A * s).T for s in grid) * (0.1 / 400)
    scale = np.sqrt(np.outer(np.diag(total), np.diag(total)))
    np.testing.assert_allclose(gains.noise / scale, total / scale, atol=5e-5)  # of the midpoint rule
    np.testing.assert_allclose(gains.transition, expm(0.1 * model.A), rtol=1e-9, atol=1e-12)


def test_moments_of_the_model_have_the_variance_of_the_sea(device: gy.Plant) -> None:
    model, _ = gains_of(device, gy.SeaState(), NOISE, 0.1, 0.2, 0.3)
    sample = gy.realise(device, gy.SeaState(), SEED).moments
    f = model.rows.size
    for j in range(2):
        block = slice(f + 2 * j, f + 2 * j + 2)
        stationary = control.lyap(model.A[block, block], model.Q[block, block])
        assert np.sqrt(stationary[0, 0]) == pytest.approx(np.std(sample[j]), rel=0.03)


def test_innovations_are_white_where_the_design_is_the_truth(device: gy.Plant) -> None:
    model, gains = gains_of(device, gy.SeaState(), NOISE, 0.1, 0.2, 0.3)
    rng = np.random.default_rng(1)
    n, s = 6000, model.A.shape[0]
    drive = np.linalg.cholesky(gains.noise + 1e-18 * np.eye(s))
    x, guess = np.zeros(s), np.zeros(s)
    e = np.empty((n, 4))
    for i in range(n):
        x = gains.transition @ x + drive @ rng.standard_normal(s)
        guess = gains.transition @ guess
        e[i] = model.C @ x + NOISE[3:] * rng.standard_normal(4) - model.C @ guess
        guess = guess + gains.gain @ e[i]
    e = e[500:]
    before = gains.transition @ gains.variance @ gains.transition.T + gains.noise
    expected = model.C @ before @ model.C.T + np.diag(NOISE[3:] ** 2)
    np.testing.assert_allclose(np.var(e, axis=0), np.diag(expected), rtol=0.08)
    normal = e / e.std(axis=0)
    for lag in range(1, 21):
        correlation = normal[lag:].T @ normal[:-lag] / len(normal)
        assert np.abs(correlation).max() < 4.5 / np.sqrt(len(normal))


# --- the compiled filter against dense ones --------------------------------------------------------------------------


@pytest.mark.slow
def test_filter_is_the_dense_one_where_the_ring_stands(device: gy.Plant) -> None:
    """With ring and flywheel at rest and small motion the plant is linear: matrices do the same as the kernel."""
    estimator = MomentEstimator.design(device)
    model = float_model(device, estimator.wp, estimator.spread, (1.0, 1.0), 0.0)
    f = model.rows.size
    a, b = device.jacobians(np.zeros(14), (0.0, 0.0), (0.0, 0.0))
    whole = model.A.copy()
    whole[:f, :f] = a[np.ix_(model.rows, model.rows)]
    whole[:f, f], whole[:f, f + 2] = b[model.rows, 2], b[model.rows, 3]
    transition = expm(0.1 * whole)
    state, dense = estimator.init(), np.zeros(f + 4)
    rng = np.random.default_rng(2)
    for i in range(200):
        # angles as small as 1e-7 rad keep the ring where it is, so that nothing but the float is at work
        y = np.concatenate([np.zeros(3), 1e-7 * rng.standard_normal(4)])
        update(estimator, state, y, 0.0, 0.0)
        if i == 0:
            dense[:4] = y[3:]
        else:
            dense = transition @ dense
            dense = dense + estimator.gain @ (y[3:] - model.C @ dense)
    np.testing.assert_allclose(state.me_hat, dense[[f, f + 2]], rtol=2e-3)
    np.testing.assert_allclose(state.x_hat[model.rows], dense[:f], rtol=1e-3, atol=1e-10)


def test_ring_filter_is_the_dense_one(device: gy.Plant) -> None:
    """Variance of psi, psi', omega' against matrix exponentials and Joseph's form."""
    estimator = MomentEstimator.design(device)
    k, R = device.coefficients, np.diag(NOISE[:3] ** 2)
    for cc, tolerance in ((0.0, 1e-9), (0.02, 0.02)):
        state, P = estimator.init(), R.copy()
        a = np.zeros((3, 3))
        a[0, 1] = 1.0
        a[1, 1:] = -k.N * k.N * cc * k.Gpp, k.N * cc * k.Gpp
        a[2, 1:] = k.N * cc * k.Goo, -cc * k.Goo
        F = expm(0.1 * a)
        F[0] = 1.0, 0.05 * (1.0 + F[1, 1]), 0.05 * F[1, 2]  # the angle by the trapezoid, as it is documented
        for _ in range(30):
            update(estimator, state, np.zeros(7), cc, 0.0)
            if state.begun[0] > 1:
                P = F @ P @ F.T + np.diag(estimator.ring_drift)
                gain = P @ np.linalg.inv(P + R)
                P = (np.eye(3) - gain) @ P @ (np.eye(3) - gain).T + gain @ R @ gain.T
        scale = np.sqrt(np.outer(np.diag(P), np.diag(P)))
        np.testing.assert_allclose(state.ring / scale, P / scale, atol=tolerance)


def test_ring_variance_stays_bounded_under_a_stiff_coupling(device: gy.Plant) -> None:
    estimator = MomentEstimator.design(device)
    state = estimator.init()
    state.ring[:] = np.diag([1e-6, 4e-4, 1e-2])
    difference = np.array([0.0, device.coefficients.N, -1.0])
    before = difference @ state.ring @ difference
    predict_ring(estimator, state, 0.3, 0.02)  # the slip decays by exp(-20): hardly any of its variance may be left
    added = difference**2 @ estimator.ring_drift
    assert difference @ state.ring @ difference - added < 0.02 * before
    assert np.all(np.linalg.eigvalsh(0.5 * (state.ring + state.ring.T)) > 0.0)


@pytest.mark.parametrize("frequency", [1.5, 3.14, 6.0])
def test_transfer_is_what_the_filter_does_to_a_regular_moment(device: gy.Plant, frequency: float) -> None:
    estimator = MomentEstimator.design(device)
    model = float_model(device, estimator.wp, estimator.spread, (1.0, 1.0), 0.0)
    f, s = model.rows.size, model.A.shape[0]
    transition = expm(0.1 * model.A)
    # the float driven by cos(w t) in Me1, with the moment as two more states: an independent way to its response
    driven = np.zeros((f + 2, f + 2))
    driven[:f, :f], driven[:f, f] = model.A[:f, :f], model.B[:, 0]
    driven[f, f + 1], driven[f + 1, f] = frequency, -frequency
    step = expm(0.1 * driven)
    x, guess = np.zeros(f + 2), np.zeros(s)
    x[f] = 1.0
    seen = []
    for _ in range(6000):
        x = step @ x
        guess = transition @ guess
        guess = guess + estimator.gain @ (x[:4] - model.C @ guess)
        seen.append(guess[[f, f + 2]])
    t = 0.1 * np.arange(1, 6001)[5000:]
    basis = np.column_stack([np.cos(frequency * t), -np.sin(frequency * t)])
    fitted = np.linalg.lstsq(basis, np.array(seen)[5000:], rcond=None)[0]
    expected = transfer(model, transition, estimator.gain, np.array([frequency]), 0.1)[:, 0, 0]
    np.testing.assert_allclose(fitted[0] + 1j * fitted[1], expected, atol=2e-3)


def test_noise_left_in_the_moments_is_as_predicted(device: gy.Plant) -> None:
    estimator = MomentEstimator.design(device)
    model = float_model(device, estimator.wp, estimator.spread, (1.0, 1.0), 0.0)
    f, transition = model.rows.size, expm(0.1 * model.A)
    rng = np.random.default_rng(3)
    guess, seen = np.zeros(model.A.shape[0]), np.empty((40000, 2))
    for i in range(len(seen)):
        guess = transition @ guess
        guess = guess + estimator.gain @ (NOISE[3:] * rng.standard_normal(4) - model.C @ guess)
        seen[i] = guess[[f, f + 2]]
    expected = noise_covariance(model, transition, estimator.gain, estimator.float_noise, 6)
    for lag in range(6):
        sample = seen[lag:].T @ seen[: len(seen) - lag] / (len(seen) - lag)
        np.testing.assert_allclose(sample, expected[:, :, lag], atol=0.04 * expected[1, 1, 0])


# --- in the loop -----------------------------------------------------------------------------------------------------


def test_without_noise_the_moments_are_recovered(device: gy.Plant) -> None:
    quiet = record(device, gy.law("coupling"), gy.Sensors.ideal(), duration=80.0)
    estimator = MomentEstimator.design(device, sensor_noise=(1e-6, 1e-6, 1e-6, 1e-9, 1e-9, 1e-7, 1e-7))
    x, me, _ = estimate(estimator, quiet)
    assert np.all(relative(me, quiet) < [5e-4, 1e-4])
    error = np.sqrt(np.mean((x - quiet.states)[300:] ** 2, axis=0))
    assert np.all(error[[0, 1, PSI, 4, 5]] < 2e-4) and error[PSI_RATE] < 5e-3 and error[OMEGA_RATE] < 0.02


def test_estimate_is_better_than_the_sensors(device: gy.Plant, locked: Record) -> None:
    x, me, _ = estimate(MomentEstimator.design(device), locked)
    error = np.sqrt(np.mean((x - locked.states)[300:] ** 2, axis=0))
    assert np.all(error[list(ROWS)] < NOISE)
    assert error[OMEGA_RATE] < 0.6 * NOISE[2] and error[0] < 0.7 * NOISE[3]
    assert np.all(relative(me, locked) < [0.02, 0.006])


@pytest.mark.parametrize("law", ["switching", "load_angle"])
def test_estimate_survives_a_law_that_works_hard(device: gy.Plant, locked: Record, law: str) -> None:
    run = record(device, Switching() if law == "switching" else gy.law(law))
    assert law != "switching" or np.ptp(run.states[:, PSI_RATE]) > 3.0, "the ring is thrown about"
    estimator = MomentEstimator.design(device)
    x, me, _ = estimate(estimator, run)
    _, calm, _ = estimate(estimator, locked)
    assert np.all(relative(me, run) < 1.1 * relative(calm, locked))
    error = np.sqrt(np.mean((x - run.states)[300:] ** 2, axis=0))
    assert np.all(error[list(ROWS)] < NOISE)


def test_estimate_survives_a_finer_truth(device: gy.Plant, locked: Record) -> None:
    fine = gy.zhang2017(radiation="fine")
    truth = record(fine, gy.law("coupling"))
    assert len(fine.labels) > 14
    estimator = MomentEstimator.design(device)
    _, me, _ = estimate(estimator, truth)
    _, same, _ = estimate(estimator, locked)
    assert np.all(relative(me, truth) < 1.1 * relative(same, locked))


def test_a_known_delay_is_made_up_for(device: gy.Plant) -> None:
    late = record(device, gy.law("coupling"), delay=1, duration=100.0)
    spread = []
    for delay in (0, 1):
        _, _, e = estimate(MomentEstimator.design(device, delay=delay), late)
        spread.append(np.std(e[300:, 1]))
    assert spread[1] < 0.6 * spread[0]


def test_the_same_samples_give_the_same_bits(device: gy.Plant, locked: Record) -> None:
    estimator = MomentEstimator.design(device)
    part = Record(*(values[:, :200] if values.shape[0] == 2 else values[:200] for values in locked))
    for one, other in zip(estimate(estimator, part), estimate(estimator, part), strict=True):
        np.testing.assert_array_equal(one, other)


# --- bad input -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"sensor_noise": (1.0,) * 6}, "estimator.sensor_noise"),
        ({"sensor_noise": (1.0,) * 6 + (-1.0,)}, "estimator.sensor_noise"),
        ({"period": 0.0}, "estimator.period"),
        ({"delay": 0.5}, "estimator.delay"),
        ({"delay": -1}, "estimator.delay"),
        ({"lag": (0.02, -0.01)}, "estimator.lag"),
    ],
)
def test_bad_input_names_field_and_mend(device: gy.Plant, change: dict[str, Any], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        MomentEstimator.design(device, **change)
    assert caught.value.field == field and caught.value.mend


def test_stationary_gains_accept_ideal_sensors(device: gy.Plant) -> None:
    model = float_model(device, 3.14, 0.2, (60.0, 140.0), 0.3)
    gains = stationary_gains(model, np.full(4, 1e-6), 0.1)
    assert np.all(np.isfinite(gains.gain))
    assert np.abs(np.linalg.eigvals((np.eye(14) - gains.gain @ model.C) @ gains.transition)).max() < 1.0
