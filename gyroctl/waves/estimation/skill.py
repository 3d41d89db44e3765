"""Skill of estimator and forecast on recorded runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.equations import PHI1
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation.moment_model import Array
from gyroctl.waves.estimation.observer import MomentEstimator, update
from gyroctl.waves.estimation.predictor import Predictor, forecast_spread, observe, predict, steps_ahead


class Replay(NamedTuple):
    """What estimator and predictor said, sample by sample."""

    x_hat: Array  # (n, states) of the estimator [rad, rad/s]
    me_hat: Array  # (n, 2), of the estimator [Nm]
    now: Array  # (n, 2), of the predictor at the same instants [Nm]
    ahead: Array  # (n, 2, leads) [Nm]
    spread: Array  # (n, 2, leads) standard deviation of their errors, as the predictor says [Nm]
    innovation: Array  # (n, 7) of the estimator [rad, rad/s]


def replay(
    predictor: Predictor, leads: Sequence[float], estimator: MomentEstimator, measured: Array, controls: Array
) -> Replay:
    """Run estimator and predictor over the record of a run.

    Parameters
    ----------
    predictor : Predictor
    leads : sequence of float
        How far ahead. [s]
    estimator : MomentEstimator
    measured : (n, 7) array
        Measurements. [rad], [rad/s]
    controls : (n, 2) array
        Commands from each sample on. [Nms]

    Raises
    ------
    InputError
        For a lead beyond the horizon.
    """
    steps = _steps(predictor, leads)
    n = min(measured.shape[0], controls.shape[0])
    measured = np.ascontiguousarray(measured)
    state, memory = estimator.init(), predictor.init()
    shapes = (state.x_hat.shape, (2,), (2,), (2, steps.size), (2, steps.size), (7,))
    out = Replay(*(np.zeros((n, *shape)) for shape in shapes))
    for i in range(n):
        held = controls[max(i - 1, 0)]
        update(estimator, state, measured[i], held[0], held[1])
        observe(predictor, memory, state.me_hat[0], state.me_hat[1], cos_sin(state.x_hat[PHI1])[1])
        predict(predictor, memory, memory.coming)
        forecast_spread(predictor, memory, steps, out.spread[i])
        out.x_hat[i], out.me_hat[i], out.innovation[i] = state.x_hat, state.me_hat, state.innovation
        out.now[i], out.ahead[i] = memory.now, memory.coming[:, steps - 1]
    return out


def replay_moments(predictor: Predictor, leads: Sequence[float], moments: Array) -> Array:
    """Forecasts (n, 2, leads) from moments (2, n) that are observed as they are. [Nm]

    Parameters
    ----------
    predictor : Predictor
        The forecast.
    leads : sequence of float
        How far ahead. [s]
    moments : (2, n) array
        Moments that are observed. [Nm]

    Returns
    -------
    (n, 2, leads) array
        Forecasts made at each sample. [Nm]

    Raises
    ------
    InputError
        For a lead beyond the horizon.
    """
    steps = _steps(predictor, leads)
    memory = predictor.init()
    ahead = np.zeros((moments.shape[1], 2, steps.size))
    for i in range(moments.shape[1]):
        observe(predictor, memory, moments[0, i], moments[1, i])
        predict(predictor, memory, memory.coming)
        ahead[i] = memory.coming[:, steps - 1]
    return ahead


def relative_error(
    predictor: Predictor, leads: Sequence[float], ahead: Array, truth: Array, first: float = 100.0
) -> Array:
    """Mean square error (2, leads) of forecasts, as a part of the variance of the moments. [-]

    Parameters
    ----------
    predictor : Predictor
    leads : sequence of float
        How far ahead. [s]
    ahead : (n, 2, leads) array
        Forecasts made at each sample. [Nm]
    truth : (2, n or more) array
        True moments at the samples. [Nm]
    first : float
        What is made before this instant does not count: the sea is blended in and nothing is learnt yet. [s]

    Returns
    -------
    (2, leads) array
        For Me1 and Me3. [-]

    Raises
    ------
    InputError
        For a lead beyond the horizon.
    """
    steps, n, begin = _steps(predictor, leads), ahead.shape[0], round(first / predictor.step)
    out = np.empty((2, steps.size))
    for a, lead in enumerate(steps):
        made = np.arange(begin, min(n, truth.shape[1] - lead))
        if made.size == 0:
            raise InputError("forecast.first", first, "leaves nothing to judge", "Give a longer record")
        error = ahead[made, :, a].T - truth[:, made + lead]
        out[:, a] = np.mean(error**2, axis=1) / np.mean(truth[:, begin:n] ** 2, axis=1)
    return out


def coverage(predictor: Predictor, leads: Sequence[float], said: Replay, truth: Array, first: float = 100.0) -> Array:
    """Share (2, 2, leads) of errors within one and two of the standard deviations that the forecast says. [-]

    0.683 and 0.954 where the forecast knows its own error. Arguments as of `relative_error`.

    Parameters
    ----------
    predictor : Predictor
        The forecast, whose own errors are judged.
    leads : sequence of float
        How far ahead. [s]
    said : Replay
        What it forecast at each sample, with its spread. [Nm]
    truth : (2, n or more) array
        True moments at the samples. [Nm]
    first : float
        What is made before this instant does not count. [s]

    Returns
    -------
    (2, 2, leads) array
        Shares within one and within two standard deviations, for Me1 and Me3. [-]

    Raises
    ------
    InputError
        For a lead beyond the horizon.
    """
    steps, n, begin = _steps(predictor, leads), said.ahead.shape[0], round(first / predictor.step)
    out = np.empty((2, 2, steps.size))
    for a, lead in enumerate(steps):
        made = np.arange(begin, min(n, truth.shape[1] - lead))
        if made.size == 0:
            raise InputError("forecast.first", first, "leaves nothing to judge", "Give a longer record")
        error = np.abs(said.ahead[made, :, a] - truth[:, made + lead].T)
        for deviations in (1, 2):
            out[deviations - 1, :, a] = np.mean(error <= deviations * said.spread[made, :, a], axis=0)
    return out


def _steps(predictor: Predictor, leads: Sequence[float]) -> NDArray[np.int64]:
    return np.array([steps_ahead(predictor, "forecast.leads", lead) for lead in leads], np.int64)
