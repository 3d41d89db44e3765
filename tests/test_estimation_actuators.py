"""The estimator follows actuators that take their time: the course of a lag, the state, and what it gains in a loop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from test_estimation import Switching, estimate, record

import gyroctl as gy
from gyroctl.plant.equations import OMEGA_RATE, PSI, PSI_RATE
from gyroctl.waves.estimation import MomentEstimator, update
from gyroctl.waves.estimation.observer import arrived, on_the_way, predict_state

Array = NDArray[np.float64]


def test_mean_of_a_control_on_its_way_is_its_integral() -> None:
    def course(t: float) -> float:
        return 0.05 + (0.3 - 0.05) * math.exp(-t / 0.02)

    for since, hold in ((0.0, 0.1), (0.025, 0.025), (0.0, 0.001)):
        exact = quad(course, since, since + hold, epsabs=1e-14)[0] / hold
        assert on_the_way(0.3, 0.05, 0.02, since, hold) == pytest.approx(exact, rel=1e-10)
    assert arrived(0.3, 0.05, 0.02, 0.03) == pytest.approx(course(0.03), rel=1e-12)
    assert on_the_way(0.3, 0.05, 0.0, 0.0, 0.1) == arrived(0.3, 0.05, 0.0, 0.1) == 0.05


@pytest.mark.parametrize(("lag", "begin", "aim"), [(0.02, 0.15, 0.0), (0.02, 0.0, 0.15), (0.1, 0.1, 0.02)])
def test_a_period_with_a_lag_is_that_of_the_plant(device: gy.Plant, lag: float, begin: float, aim: float) -> None:
    """Against an adaptive integration of `Plant.derivative` with the course of the coupling."""
    estimator = MomentEstimator.design(device, lag=(lag, 0.0))
    plain = MomentEstimator.design(device)
    start = np.zeros(len(device.labels))
    start[PSI], start[PSI_RATE], start[OMEGA_RATE] = 0.7, 3.0, 80.0

    def rate(t: float, x: Array) -> Array:
        return device.derivative(x, (aim + (begin - aim) * math.exp(-t / lag), 4e-4), (0.0, 0.0))

    exact = solve_ivp(rate, (0.0, 0.1), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    errors = []
    for each in (estimator, plain):
        state = each.init()
        state.x_hat[:], state.held[:] = start, (begin, 4e-4)
        predict_state(each, state, aim, 4e-4)
        errors.append(np.abs(state.x_hat - exact)[[PSI_RATE, OMEGA_RATE]])
    assert errors[0][1] < 0.05 * errors[1][1] and errors[0][0] < 4e-4, errors


def test_control_at_the_sample_is_carried_on(device: gy.Plant) -> None:
    estimator = MomentEstimator.design(device, lag=(0.05, 0.2), delay=1)
    state, y = estimator.init(), np.array([0.0, 3.0, 70.0, 0.0, 0.0, 0.0, 0.0])
    held = np.array([0.05, 1e-3])
    commands = ((0.05, 1e-3), (0.05, 1e-3), (0.2, 3e-3), (0.1, 0.0), (0.0, 0.0))
    update(estimator, state, y, *commands[0])
    for sample in range(1, 5):
        update(estimator, state, y, *commands[sample])
        for channel, lag in enumerate((0.05, 0.2)):  # a command acts a sample later
            aim = commands[sample - 1][channel]
            held[channel] = aim + (held[channel] - aim) * math.exp(-0.1 / lag)
        np.testing.assert_allclose(state.held, held, rtol=1e-12)


def test_a_known_lag_is_made_up_for(device: gy.Plant) -> None:
    """The true state of a loop whose coupling switches as hard as it can, and follows slowly."""
    late = record(device, Switching(), duration=100.0, cc_lag=0.05, delay=1)
    errors: dict[Any, Array] = {}
    for lag, delay in ((0.05, 1), (0.0, 1), (0.05, 0)):
        x, _, e = estimate(MomentEstimator.design(device, lag=(lag, 0.0), delay=delay), late)
        errors[lag, delay] = np.array([np.std(e[300:, 1]), np.std((x - late.states)[300:, OMEGA_RATE])])
    assert np.all(errors[0.05, 1] < 0.7 * errors[0.0, 1]), errors
    assert np.all(errors[0.05, 1] < 0.7 * errors[0.05, 0]), errors
