"""The moments of a sea, and predictors that are fed with them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.waves.estimation import Predictor, observe
from gyroctl.waves.estimation.predictor import PredictorState

Array = NDArray[np.float64]
SEED = 100050
LEADS = (0.5, 1.0, 2.0, 4.0, 8.0)


def moments(plant: gy.Plant, sea: Any, duration: float = 400.0, seed: int = SEED) -> Array:
    return gy.realise(plant, sea, seed, duration, 0.1).moments


def known(plant: gy.Plant, **changes: Any) -> Predictor:
    """A predictor that knows the sea and learns nothing."""
    return Predictor.design(plant, **{"sea": gy.SeaState(), "forgetting": None, **changes})


def fed(predictor: Predictor, values: Array) -> PredictorState:
    state = predictor.init()
    for one, three in values.T:
        observe(predictor, state, one, three)
    return state
