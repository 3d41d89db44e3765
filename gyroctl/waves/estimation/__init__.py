"""State and wave moments from the sensors, and their forecast.

Constants and state are different values; the functions are compiled, callable from Python and from compiled code alike,
and change nothing but the arrays of the state that they are given::

    estimator = MomentEstimator.design(plant)            # constants; `plant` is the design model
    state = estimator.init()
    update(estimator, state, y, cc, cg)                  # every period: y (7,), the command since the last sample
    state.x_hat, state.me_hat                            # (14,) in the plant's order, (2,) [Nm]
    look_to_then(estimator, state)                       # state.then: where a command of now begins to act

    predictor = Predictor.design(plant, estimator=estimator, step=0.1, horizon=8.0)
    memory = predictor.init()
    observe(predictor, memory, state.me_hat[0], state.me_hat[1], math.sin(state.x_hat[0]))
    predict(predictor, memory, out)                      # out (2, n): Me1, Me3 at 0.1, 0.2, .. s ahead [Nm]
    forecast_spread(predictor, memory, leads, deviations)  # and how far it trusts itself at some leads [Nm]
    memory.now                                           # (2,) the moments at the sample with less noise than me_hat

    probe = Probe.design(predictor, waves.moments, waves.dt, lead=2.0)      # a predictor without `estimator`
    foresee(predictor, probe, memory, sample, out)       # as told up to 2 s ahead, forecast beyond

Left out of the design, `estimator` means that the observed moments are the true ones. `forecast` is `predict` for
Python, with a check of the horizon. A compiled function that calls these should be ``stamped(SOURCES)``, see
`gyroctl.plant.compiled`.
"""

from __future__ import annotations

from gyroctl.waves.estimation import observer, probe
from gyroctl.waves.estimation.observer import SENSOR_NOISE, EstimatorState, MomentEstimator, look_to_then, update
from gyroctl.waves.estimation.predictor import Predictor, PredictorState, forecast, forecast_spread, observe, predict
from gyroctl.waves.estimation.probe import Probe, foresee
from gyroctl.waves.estimation.skill import Replay, coverage, relative_error, replay, replay_moments

SOURCES = (*observer.SOURCES, *probe.SOURCES)
"""Files that are compiled into `update`, `observe`, `predict`, `forecast_spread` and `foresee`."""

__all__ = [
    "SENSOR_NOISE",
    "SOURCES",
    "EstimatorState",
    "MomentEstimator",
    "Predictor",
    "PredictorState",
    "Probe",
    "Replay",
    "coverage",
    "forecast",
    "forecast_spread",
    "foresee",
    "look_to_then",
    "observe",
    "predict",
    "relative_error",
    "replay",
    "replay_moments",
    "update",
]
