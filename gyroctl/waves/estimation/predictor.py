"""Forecast of both moments: the conditional mean of two jointly Gaussian signals, given their past.

With G the covariance of the past values that are looked at and g that of a future value with them, the best forecast is
g^T G^-1 m (Wiener). Both follow from one spectrum of the sea (`gaussian`), which is learnt from the same moments
(`learning`) every few seconds. The values looked at stand recent first, so that a past that is still too short uses
the leading block of the same factor.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.compiled import stamped
from gyroctl.plant.plant import Plant
from gyroctl.waves.estimation import learning
from gyroctl.waves.estimation import placed as places
from gyroctl.waves.estimation.gaussian import Bins, bins, kernels, responses, steering
from gyroctl.waves.estimation.learning import Learner, LearnerState, correlate, learn
from gyroctl.waves.estimation.moment_model import Array, FloatModel, float_model, noise_covariance, transfer
from gyroctl.waves.estimation.observer import MomentEstimator
from gyroctl.waves.estimation.placed import Placed, PlacedState, begun, placed, predict_placed
from gyroctl.waves.estimation.sea_shape import shape_of
from gyroctl.waves.estimation.wave_signals import position_of, seen_from
from gyroctl.waves.spectrum import SeaState

SOURCES = (*learning.SOURCES, places.__file__, __file__)

GENERIC = SeaState(gamma=3.3)
"""The sea that is expected before anything has been seen."""

FLOOR = 0.3
"""Noise of the observed moments that is always reckoned with. [Nm]"""

DENSE, SPARSE = 3.0, 6.0
"""Every value is looked at up to the first age, every second up to the second, every fourth beyond. [s]"""


class Predictor(NamedTuple):
    """Constants of the forecast; build it with `Predictor.design`."""

    step: float  # sampling period [s]
    horizon: int  # [steps]
    learner: Learner  # how the spectrum is learnt
    placed: Placed | None = None  # where the float that saw the waves moves

    @classmethod
    def design(
        cls,
        plant: Plant,
        step: float = 0.1,
        past: float | None = None,
        horizon: float = 8.0,
        sea: SeaState | None = None,
        estimator: MomentEstimator | None = None,
        forgetting: float | None = 120.0,
        every: float = 5.0,
        floor: float | tuple[float, float] | None = None,
        doubt: float | None = None,
        grid: Bins | None = None,
    ) -> Predictor:
        """Design the forecast.

        Parameters
        ----------
        plant : Plant
            The design model: gives He_j and the float's response.
        step : float
            Time between observations and between leads. [s]
        past : float, optional
            How far the forecast looks back; by default 12, and 8 where the float moves: broad bins of the spectrum are
            out of step with the waves beyond. [s]
        horizon : float
            How far it looks ahead. [s]
        sea : SeaState, optional
            The sea to start from; by default a generic one.
        estimator : MomentEstimator, optional
            What the observed moments come from: its response and its noise are then known. Without, they are taken as
            true.
        forgetting : float, optional
            Time after which what was seen counts e times less; None learns nothing and stays with `sea`. [s]
        every : float
            Time between two fits of the spectrum. [s]
        floor : float or pair of float, optional
            Standard deviation of white noise added to the observed moments, or to each; by default 0.3, and with an
            estimator whose design model goes beyond the linear one also what its guess of the waves misses, see
            `wave_signals.unexplained`. [Nm]
        doubt : float
            The same for the fit of the spectrum alone, see `learning`; by default 6, and 20 where the float moves. [Nm]
        grid : Bins, optional
            Frequency bins of the spectrum.

        Raises
        ------
        InputError
            For a length that is not positive, a horizon or past shorter than a step, a step other than the estimator's.
        """
        moves = estimator is not None and position_of(plant.rolling.smooth.coefficients.beyond) is not None
        if past is None:
            past = 8.0 if moves else 12.0
        if doubt is None:
            doubt = 20.0 if moves else 6.0
        if floor is None:
            missed = 0.0 if estimator is None else estimator.unexplained
            floor = math.hypot(FLOOR, missed) if missed > 0.0 else FLOOR
        floors = floor if isinstance(floor, tuple) else (floor, floor)
        lengths = {"step": step, "past": past, "horizon": horizon, "every": every, "doubt": doubt}
        lengths.update({"floor": floors[0], "floor of Me3": floors[1]})
        lengths.update({} if forgetting is None else {"forgetting": forgetting})
        for name, value in lengths.items():
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
                raise InputError(f"predictor.{name}", value, "must be positive", f"Give {name} as a number")
        for name, value in (("past", past), ("horizon", horizon)):
            if round(value / step) < 1:
                problem = f"is shorter than the step of {step} s"
                raise InputError(f"predictor.{name}", value, problem, "Give some seconds")
        sea, grid = sea or GENERIC, grid or bins()
        ages = np.array([a for a in range(round(past / step) + 1) if _looked_at(a, step)], np.int64)
        count, leads = int(ages[-1]) + 1, round(horizon / step)
        noise: Array = np.zeros((2, 2, count))
        through = None
        if estimator is not None:
            if not math.isclose(estimator.period, step):
                problem = f"differs from the estimator's period {estimator.period}"
                raise InputError("predictor.step", step, problem, "Give both the same")
            through = seen_through(plant, estimator, grid.omega)
            model, transition = _closed(plant, estimator)
            noise = noise_covariance(model, transition, estimator.gain, estimator.float_noise, count)
        noise[0, 0, 0] += floors[0] ** 2
        noise[1, 1, 0] += floors[1] ** 2
        seen = responses(plant, sea.heading, grid, through)
        response = responses(plant, sea.heading, grid) if moves else seen  # what is learnt from stands at rest
        table = kernels(response, step, count, leads, noise)
        learner = Learner(
            ages=ages,
            **table._asdict(),
            steering=steering(response, step, ages),
            omega=grid.omega,
            width=grid.width,
            prior=sea.spectrum(grid.omega),
            shape=np.array(shape_of(sea)),
            every=0 if forgetting is None else max(round(every / step), 1),
            fade=0.0 if forgetting is None else math.exp(-step / forgetting),
            window=past / step,
            doubt=float(doubt) ** 2,
        )
        if not moves:
            return cls(float(step), leads, learner)
        noisy = np.array([noise[0, 0, 0], noise[1, 1, 0]])
        return cls(float(step), leads, learner, placed(plant, seen, sea.heading, step, past, leads, noisy))

    def init(self) -> PredictorState:
        """Return a fresh state that knows the prior only."""
        values, past = self.learner.steering.shape[0], self.learner.seen.shape[2]
        return PredictorState(
            history=np.zeros((past, 3)),
            rested=np.zeros((0 if self.placed is None else past, 2)),
            samples=np.zeros(1, np.int64),
            values=np.zeros(values),
            weights=np.zeros(values),
            coming=np.zeros((2, self.horizon)),
            now=np.zeros(2),
            memory=self.learner.init(),
            placed=begun(self.placed),
        )


class PredictorState(NamedTuple):
    """State of the forecast, changed in place by `observe` and `predict`."""

    history: Array  # (past, 3), round buffer of observed moments [Nm] and of the sine of phi1
    rested: Array  # (past, 2), where the float moves the moments at rest, as they were worked out; else (0, 2) [Nm]
    samples: NDArray[np.int64]  # (1,) observations so far [-]
    values: Array  # (2 m,), those looked at, whitened [-]
    weights: Array  # (2 m,), G^-1 m [-]
    coming: Array  # (2, horizon), working space for callers [Nm]
    now: Array  # (2,) moments at the last sample, noise smoothed [Nm]
    memory: LearnerState  # what the spectrum was learnt from
    placed: PlacedState  # where the float moves


def forecast(predictor: Predictor, state: PredictorState, seconds: float) -> Array:
    """Moments (2, n) at 1 .. n steps ahead of the last observation, up to `seconds`. [Nm]

    Parameters
    ----------
    predictor : Predictor
        The forecast.
    state : PredictorState
        Its state after `observe`.
    seconds : float
        How far ahead. [s]

    Returns
    -------
    (2, n) array
        Me1 and Me3. [Nm]

    Raises
    ------
    InputError
        Where `seconds` is beyond the horizon of the design.
    """
    out = np.empty((2, steps_ahead(predictor, "forecast.seconds", seconds)))
    predict(predictor, state, out)
    return out


def steps_ahead(predictor: Predictor, field: str, seconds: float) -> int:
    """Return the steps in `seconds`, or refuse what is outside the horizon as an `InputError` of `field`."""
    count = round(seconds / predictor.step) if math.isfinite(seconds) else -1
    if not 1 <= count <= predictor.horizon:
        problem = f"is outside the horizon, {predictor.step:g} to {predictor.horizon * predictor.step:g} s"
        raise InputError(field, seconds, problem, "Ask for less or design the predictor with a longer horizon")
    return count


def _looked_at(age: int, step: float) -> bool:
    stride = 1 if age * step <= DENSE else (2 if age * step <= SPARSE else 4)
    return age % stride == 0


def seen_through(plant: Plant, estimator: MomentEstimator, omega: Array) -> NDArray[np.complex128]:
    """Response (2, 2, b) of what an estimator makes of the moments to the true ones, at `omega` [rad/s]."""
    model, transition = _closed(plant, estimator)
    return transfer(model, transition, estimator.gain, omega, estimator.period)


def _closed(plant: Plant, estimator: MomentEstimator) -> tuple[FloatModel, Array]:
    """Averaged model of the estimator and its transition over a period."""
    from scipy.linalg import expm

    model = float_model(seen_from(plant), estimator.wp, estimator.spread, (1.0, 1.0), 0.0)
    return model, np.asarray(expm(model.A * estimator.period))


@stamped(SOURCES)
def take(predictor: Predictor, state: PredictorState, me1: float, me3: float, place: float) -> bool:
    """Take the moments of one sample [Nm], seen at a place (the sine of phi1), without learning from them, in place.

    Returns whether the spectrum is due to be learnt anew, as it is every few seconds: `learning.learn` costs as much as
    a hundred samples, and is long to compile.
    """
    learner = predictor.learner
    length = state.history.shape[0]
    at = state.samples[0] % length
    before = (state.samples[0] - 1) % length  # a value that is no number must not stay: the last one stands for it
    state.history[at, 0] = me1 if math.isfinite(me1) else state.history[before, 0]
    state.history[at, 1] = me3 if math.isfinite(me3) else state.history[before, 1]
    state.history[at, 2] = place if math.isfinite(place) else 0.0
    state.samples[0] += 1
    if state.rested.shape[0] > 0 and state.samples[0] > 1:
        state.rested[before, 0], state.rested[before, 1] = state.now[0], state.now[1]
    if learner.every == 0 or state.samples[0] < length:
        return False
    if state.rested.shape[0] > 0:  # the sample before: its moments at rest are known by now
        correlate(learner, state.memory, state.rested, before)
    else:
        correlate(learner, state.memory, state.history, at)
    return bool(state.samples[0] % learner.every == 0 and state.samples[0] >= length + learner.every)


@stamped(SOURCES)
def observe(predictor: Predictor, state: PredictorState, me1: float, me3: float, place: float = 0.0) -> None:
    """Take the moments of one sample [Nm], and learn the spectrum where that is due, in place.

    `place` is the sine of phi1 where the moments are those at a float that moves.

    Parameters
    ----------
    predictor : Predictor
        The forecast.
    state : PredictorState
        Its state, changed in place.
    me1, me3 : float
        The moments. [Nm]
    place : float
        Sine of phi1 where they were felt. [-]
    """
    if take(predictor, state, me1, me3, place):
        learn(predictor.learner, state.memory)


@stamped(SOURCES)
def predict(predictor: Predictor, state: PredictorState, out: NDArray[np.float64]) -> None:
    """Write the moments (2, n) at 1 .. n steps ahead of the last observation, n up to the horizon. [Nm]

    `state.now` holds the moments at the last observation afterwards. Beyond the horizon `out` is zero, the mean of
    what is not known; `forecast` refuses to be asked for it.

    Parameters
    ----------
    predictor : Predictor
        The forecast.
    state : PredictorState
        Its state after `observe`; working space is changed in place.
    out : (2, n) array
        Written: Me1 and Me3. [Nm]
    """
    look_ahead(predictor.placed, predictor, state, out)


@stamped(SOURCES)
def look_ahead(moving: Placed | None, predictor: Predictor, state: PredictorState, out: NDArray[np.float64]) -> None:
    """Predict from what a float at rest saw, or from the places where it was."""
    if moving is not None:
        spectrum, samples = state.memory.spectrum, state.samples[0]
        predict_placed(moving, state.placed, spectrum, state.history, samples, state.now, out)
    else:
        predict_at_rest(predictor, state, out)


@stamped(SOURCES)
def forecast_spread(predictor: Predictor, state: PredictorState, leads: NDArray[np.int64], out: Array) -> None:
    """Write the standard deviations (2, n) of the error of what was predicted last, at some leads. [Nm]

    Parameters
    ----------
    predictor : Predictor
    state : PredictorState
        After `predict`.
    leads : (n,) array
        0 for the moments now, up to the horizon. [steps]
    out : (2, n) array
        Filled [Nm]. Where the float moves they are `state.placed.spread`, and cost nothing; else they follow from the
        spectrum alone, change where that is learnt, and cost more than a forecast.
    """
    if predictor.placed is not None:
        for i in range(2):
            for at in range(leads.size):
                out[i, at] = state.placed.spread[i, leads[at]]
    else:
        spread_at_rest(predictor, state, leads, out)


@stamped(SOURCES)
def spread_at_rest(predictor: Predictor, state: PredictorState, leads: NDArray[np.int64], out: Array) -> None:
    """See `forecast_spread`: what is left of the variance, g0 - g' G^-1 g."""
    ages, ahead, V = predictor.learner.ages, state.memory.ahead, state.memory.whitener
    known = 0
    while known < ages.size and ages[known] < state.samples[0]:
        known += 1
    g = np.empty(2 * known)
    for i in range(2):
        for at in range(leads.size):
            for a in range(known):
                g[2 * a], g[2 * a + 1] = ahead[2 * i, ages[a] + leads[at]], ahead[2 * i + 1, ages[a] + leads[at]]
            left = ahead[3 * i, 0]
            for r in range(2 * known):
                total = 0.0
                for c in range(r + 1):
                    total += V[r, c] * g[c]
                left -= total * total
            out[i, at] = math.sqrt(max(left, 0.0))


@stamped(SOURCES)
def predict_at_rest(predictor: Predictor, state: PredictorState, out: NDArray[np.float64]) -> None:
    """See `predict`."""
    ages, ahead, V = predictor.learner.ages, state.memory.ahead, state.memory.whitener
    v, w = state.values, state.weights
    length, count = state.history.shape[0], state.samples[0]
    known = 0
    while known < ages.size and ages[known] < count:
        known += 1
    for i in range(2 * known):  # the values looked at
        w[i] = 0.0
        v[i] = state.history[(count - 1 - ages[i // 2]) % length, i % 2]
    for i in range(2 * known):  # G^-1 = V^T V
        first, second = 0.0, 0.0
        for j in range(0, i, 2):
            first += V[i, j] * v[j]
            second += V[i, j + 1] * v[j + 1]
        if i % 2 == 0:
            first += V[i, i] * v[i]
        total = first + second
        for j in range(i + 1):
            w[j] += V[i, j] * total
    leads = min(out.shape[1], predictor.horizon)
    for i in range(2):
        state.now[i] = 0.0
        for lead in range(out.shape[1]):
            out[i, lead] = 0.0
        for a in range(known):
            of1, of3, age = w[2 * a], w[2 * a + 1], ages[a]
            state.now[i] += ahead[2 * i, age] * of1 + ahead[2 * i + 1, age] * of3
            for lead in range(leads):
                out[i, lead] += ahead[2 * i, age + 1 + lead] * of1 + ahead[2 * i + 1, age + 1 + lead] * of3
