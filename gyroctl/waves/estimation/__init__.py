"""State and wave moments from the sensors, and their forecast.

Constants and state are different values; the functions are compiled, callable from Python and from compiled code alike,
and change nothing but the arrays of the state that they are given::

    estimator = MomentEstimator.design(plant)            # constants; `plant` is the design model
    state = estimator.init()
    update(estimator, state, y, cc, cg)                  # every period: y (7,), the command since the last sample
    state.x_hat, state.me_hat                            # (14,) in the plant's order, (2,) [Nm]

    predictor = Predictor.design(plant, estimator=estimator, step=0.1, past=12.0, horizon=8.0)
    memory = predictor.init()
    observe(predictor, memory, state.me_hat[0], state.me_hat[1])
    predict(predictor, memory, out)                      # out (2, n): Me1, Me3 at 0.1, 0.2, .. s ahead [Nm]
    memory.now                                           # (2,) the moments at the sample with less noise than me_hat

Left out of the design, `estimator` means that the observed moments are the true ones. A compiled function that calls
these should carry `source_stamp(SOURCES)`, see `gyroctl.plant.compiled`.
"""

from __future__ import annotations

from gyroctl.waves.estimation import observer, predictor
from gyroctl.waves.estimation.observer import SENSOR_NOISE, EstimatorState, MomentEstimator, update
from gyroctl.waves.estimation.predictor import Predictor, PredictorState, observe, predict

SOURCES = (*observer.SOURCES, *predictor.SOURCES)
"""Files that are compiled into `update`, `observe` and `predict`."""

__all__ = [
    "SENSOR_NOISE",
    "SOURCES",
    "EstimatorState",
    "MomentEstimator",
    "Predictor",
    "PredictorState",
    "observe",
    "predict",
    "update",
]
