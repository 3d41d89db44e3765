"""Forecast of both moments: the conditional mean of two jointly Gaussian signals, given their past.

With G the covariance of the past values that are looked at and g that of a future value with them, the best forecast is
g^T G^-1 m (Wiener). G is factorised when the spectrum is learnt anew, every few seconds; a sample costs two triangular
solves and a table of products. The values looked at stand recent first, so that a past that is still too short uses
the leading block of the same factor.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant import compiled
from gyroctl.plant.compiled import entry_point, source_stamp
from gyroctl.plant.plant import Plant
from gyroctl.waves.estimation.averaged import Array, float_model, noise_covariance, transfer
from gyroctl.waves.estimation.gaussian import Bins, bins, kernels
from gyroctl.waves.estimation.observer import MomentEstimator
from gyroctl.waves.spectrum import SeaState

SOURCES = (compiled.__file__, __file__)

DENSE, SPARSE = 2.0, 6.0
"""Every value is looked at up to the first age, every second up to the second, every fourth beyond. [s]"""


class Predictor(NamedTuple):
    """Constants of the forecast; build it with `Predictor.design`."""

    step: float  # sampling period [s]
    ages: NDArray[np.int64]  # (m,) of the values looked at, recent first [steps]
    horizon: int  # [steps]
    seen: Array  # (4, past, b), see `Kernels`
    ahead: Array  # (4, past + horizon, b)
    noise: Array  # (4, past) [Nm^2]
    prior: Array  # (b,) spectrum to start from [m^2 s]

    @classmethod
    def design(
        cls, plant: Plant, step: float = 0.1, past: float = 12.0, horizon: float = 8.0, sea: SeaState | None = None,
        estimator: MomentEstimator | None = None, floor: float = 0.5, grid: Bins | None = None,
    ) -> Predictor:  # fmt: skip
        """Design the forecast.

        Parameters
        ----------
        plant : Plant
            The design model: gives He_j and the float's response.
        step : float
            Time between observations and between leads. [s]
        past, horizon : float
            How far the forecast looks back and ahead. [s]
        sea : SeaState, optional
            The sea to start from; the default sea.
        estimator : MomentEstimator, optional
            What the observed moments come from: its response and its noise are then known. Without, they are taken as
            true.
        floor : float
            Standard deviation of white noise added to the observed moments. [Nm]
        grid : Bins, optional
            Frequency bins of the spectrum.
        """
        for name, value in (("step", step), ("past", past), ("horizon", horizon), ("floor", floor)):
            if isinstance(value, bool) or not isinstance(value, int | float) or not (0.0 < value < math.inf):
                raise InputError(f"predictor.{name}", value, "must be positive", f"Give {name} as a number")
        if past < step or horizon < step:
            raise InputError("predictor.horizon", horizon, "is shorter than a step", f"Give at least {step} s")
        sea, grid = sea or SeaState(), grid or bins()
        ages = np.array([a for a in range(round(past / step) + 1) if _looked_at(a, step)], np.int64)
        count, leads = int(ages[-1]) + 1, round(horizon / step)
        noise = np.zeros((2, 2, count))
        response = None
        if estimator is not None:
            if not math.isclose(estimator.period, step):
                raise InputError("predictor.step", step, f"differs from the estimator's period {estimator.period}",
                                 "Give both the same")  # fmt: skip
            model, transition = _closed(plant, estimator)
            response = transfer(model, transition, estimator.gain, grid.omega, step)
            noise = noise_covariance(model, transition, estimator.gain, estimator.float_noise, count)
        noise[0, 0, 0] += floor**2
        noise[1, 1, 0] += floor**2
        table = kernels(plant, sea.heading, grid, step, count, leads, response, noise)
        return cls(float(step), ages, leads, table.seen, table.ahead, table.noise, sea.spectrum(grid.omega))

    def init(self) -> PredictorState:
        """Return a fresh state that knows the prior only."""
        values, count = 2 * self.ages.size, self.seen.shape[1]
        state = PredictorState(self.prior.copy(), np.zeros((count, 2)), np.zeros(1, np.int64),
                               np.zeros((values, values)), np.zeros(values), np.zeros((4, count)),
                               np.zeros((4, count + self.horizon)), np.zeros(2))  # fmt: skip
        factorise(self, state)
        return state


class PredictorState(NamedTuple):
    """State of the forecast, changed in place by `observe` and `predict`."""

    spectrum: Array  # (b,) as learnt [m^2 s]
    history: Array  # (past, 2), round buffer of observed moments [Nm]
    count: NDArray[np.int64]  # (1,) observations so far
    factor: Array  # (2 m, 2 m), lower triangle
    weights: Array  # (2 m,), G^-1 m
    seen: Array  # (4, past) covariances at the learnt spectrum
    ahead: Array  # (4, past + horizon)
    now: Array  # (2,) moments at the last sample, noise smoothed [Nm]


def _looked_at(age: int, step: float) -> bool:
    stride = 1 if age * step <= DENSE else (2 if age * step <= SPARSE else 4)
    return age % stride == 0


def _closed(plant: Plant, estimator: MomentEstimator) -> tuple[Any, Array]:
    """Averaged model of the estimator and its transition over a period."""
    from scipy.linalg import expm

    model = float_model(plant, estimator.wp, estimator.spread, (1.0, 1.0), 0.0)
    return model, expm(model.A * estimator.period)


def _factorise(stamp: str) -> Any:
    def factorise(predictor: Predictor, state: PredictorState) -> None:
        """Covariances at the present spectrum and the factor of those looked at."""
        assert stamp
        S, ages, G = state.spectrum, predictor.ages, state.factor
        for p in range(4):
            for lag in range(predictor.seen.shape[1]):
                state.seen[p, lag] = predictor.noise[p, lag] + np.dot(predictor.seen[p, lag], S)
            for lag in range(predictor.ahead.shape[1]):
                state.ahead[p, lag] = np.dot(predictor.ahead[p, lag], S)
        for a in range(ages.size):
            for b in range(a + 1):
                lag = ages[a] - ages[b]  # value b is the younger: E o_j(t - b) o_i(t - a)
                for i in range(2):
                    for j in range(2):
                        G[2 * a + i, 2 * b + j] = state.seen[2 * j + i, lag]
        size = G.shape[0]
        for r in range(size):
            for c in range(r + 1):
                total = G[r, c]
                for i in range(c):
                    total -= G[r, i] * G[c, i]
                G[r, c] = math.sqrt(total) if r == c else total / G[c, c]

    return entry_point(factorise)


def _observe(stamp: str) -> Any:
    def observe(predictor: Predictor, state: PredictorState, me1: float, me3: float) -> None:
        """Take the moments of one sample, in place. [Nm]"""
        assert stamp
        at = state.count[0] % state.history.shape[0]
        state.history[at, 0], state.history[at, 1] = me1, me3
        state.count[0] += 1

    return entry_point(observe)


def _predict(stamp: str) -> Any:
    def predict(predictor: Predictor, state: PredictorState, out: NDArray[np.float64]) -> None:
        """Write the moments (2, n) at 1 .. n steps ahead of the last observation, n up to the horizon. [Nm]

        `state.now` holds the moments at the last observation afterwards.
        """
        assert stamp
        ages, G, w = predictor.ages, state.factor, state.weights
        length, count = state.history.shape[0], state.count[0]
        size = 0
        for a in range(ages.size):
            if ages[a] >= count:
                break
            at = (count - 1 - ages[a]) % length
            w[2 * a], w[2 * a + 1] = state.history[at, 0], state.history[at, 1]
            size += 2
        for r in range(size):
            total = w[r]
            for i in range(r):
                total -= G[r, i] * w[i]
            w[r] = total / G[r, r]
        for r in range(size - 1, -1, -1):
            w[r] /= G[r, r]
            for i in range(r):
                w[i] -= G[r, i] * w[r]
        for i in range(2):
            first, second = state.ahead[2 * i], state.ahead[2 * i + 1]
            for lead in range(min(out.shape[1], predictor.horizon) + 1):
                total = 0.0
                for a in range(size // 2):
                    total += first[lead + ages[a]] * w[2 * a] + second[lead + ages[a]] * w[2 * a + 1]
                if lead == 0:
                    state.now[i] = total
                else:
                    out[i, lead - 1] = total
            for lead in range(predictor.horizon, out.shape[1]):
                out[i, lead] = 0.0  # beyond the horizon nothing is known; the Python layer refuses it

    return entry_point(predict)


factorise = _factorise(source_stamp(SOURCES))
observe = _observe(source_stamp(SOURCES))
predict = _predict(source_stamp(SOURCES))
