"""The moments over the horizon, by level of information: looked up, told by a probe and predicted from there, or
predicted from what the sensors let one estimate.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.prediction import STEPS
from gyroctl.controllers.nmpc.preview import Preview, between
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.waves.estimation import EstimatorState, MomentEstimator, Predictor, PredictorState, observe, predict

ForesightState = PredictorState | None
"""Memory of the prediction; none where everything is looked up."""


class Foresight(NamedTuple):
    """How a law sees the moments ahead; build it with `Foresight.design`."""

    seen: Preview | None  # the true moments, for a law that may see them
    predictor: Predictor | None  # for what is not seen
    lead: int  # control intervals ahead that are seen
    intervals: int  # of the horizon

    @classmethod
    def design(
        cls, plant: Plant, information: str, estimator: MomentEstimator, seen: Preview | None, period: float,
        horizon: float, lead: float,
    ) -> Foresight:  # fmt: skip
        """Choose what is looked up and what is predicted.

        Raises
        ------
        InputError
            Where a law that may look ahead was not told the waves, or a lead is no multiple of the period.
        """
        intervals = round(horizon / period)
        if information == "sensors":
            predictor = Predictor.design(plant, period, horizon=horizon, estimator=estimator)
            return cls(None, predictor, 0, intervals)
        if seen is None:
            raise InputError("nmpc.seen", None, f"a law with information {information!r} was told no waves",
                             "Call law.informed(waves) first; comparison and simulation do")  # fmt: skip
        if information == "oracle":
            return cls(seen, None, intervals, intervals)
        told = round(lead / period)
        if not math.isclose(told * period, lead, abs_tol=1e-9):
            raise InputError("nmpc.lead", lead, f"is no multiple of the period of {period:g} s",
                             f"Give for example {told * period:g} s")  # fmt: skip
        if told >= intervals:
            return cls(seen, None, intervals, intervals)
        return cls(seen, Predictor.design(plant, period, horizon=horizon), told, intervals)

    def init(self) -> ForesightState:
        """Return the memory before the first sample."""
        return None if self.predictor is None else self.predictor.init()


def foresee(
    foresight: Foresight, t: float, estimate: EstimatorState, memory: ForesightState
) -> tuple[NDArray[np.float64], ForesightState]:
    """Return the moments at each model step from `t` [s] to the horizon, flat (2 (n STEPS + 1),) [Nm], and the memory."""
    seen, told, n = foresight.seen, foresight.lead, foresight.intervals
    if foresight.predictor is None or memory is None:
        assert seen is not None
        return seen.window(t, STEPS * n + 1), memory
    memory = copied(memory)
    ahead = np.empty((2, n - told))
    if seen is None:
        observe(foresight.predictor, memory, estimate.me_hat[0], estimate.me_hat[1])
        predict(foresight.predictor, memory, ahead)
        return between(np.vstack((memory.now, ahead.T))), memory
    known = seen.window(t, STEPS * told + 1).reshape(-1, 2)[::STEPS]
    observe(foresight.predictor, memory, known[-1, 0], known[-1, 1])
    predict(foresight.predictor, memory, ahead)
    return between(np.vstack((known, ahead.T))), memory


def copied(state: Any) -> Any:
    """Copy a NamedTuple of arrays, nested or not: the estimators change theirs in place, a law must not."""
    if isinstance(state, tuple):
        return type(state)(*(copied(part) for part in state))
    return state.copy()
