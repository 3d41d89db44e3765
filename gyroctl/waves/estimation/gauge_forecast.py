"""Forecast from a gauge up-wave and the sensors together: one Gaussian estimate of the waves that both have seen.

The waves are complex amplitudes of the bins of a spectrum, Gaussian and independent before anything is measured. Two
kinds of measurements are linear in them: the elevation at the gauge, d up-wave, where the wave of a bin has the phase
w t + k d, and the moments at the float. The estimate of the amplitudes given both is the best one, and gives the
moments ahead: no delay is set anywhere, low waves that outrun and high ones that are late come out of k(w).

What of a reading is no wave stands in its covariance, and is thereby kept out of the estimate: white noise; drift, of
covariance ``drift^2 exp(-lag / T)``; waves too short to be told apart; and the doubt where the gauge stands. If that is
off by a normal deviation s, the wave of a bin is seen with its phase off by k s: on the mean exp(-k^2 s^2 / 2) of it is
left, and the rest is noise of its spectrum.

The gauge does not move, so what it tells changes only with the spectrum that is learnt: `prepare` works out, every few
seconds, how the amplitudes follow from the last readings, and what is left open. That is what the moments at the float
are then reckoned against at each sample, as `placed` does it against the spectrum alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import group_velocity, wavenumber
from gyroctl.plant.compiled import stamped
from gyroctl.plant.plant import Plant
from gyroctl.plant.row_sums import add_rows
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation import placed as places
from gyroctl.waves.estimation.moment_model import Array, float_model, transfer
from gyroctl.waves.estimation.observer import MomentEstimator
from gyroctl.waves.estimation.placed import HIGHEST, Placed, solve_in_place
from gyroctl.waves.estimation.predictor import Predictor
from gyroctl.waves.estimation.wave_signals import seen_from
from gyroctl.waves.gauge import Gauge

SOURCES = (*places.SOURCES, __file__)

SHORTEST, SLOWEST = 12.0, 5.0
"""Readings go back so far [s], or as long as waves of this frequency [rad/s] take from the gauge to the float."""

SLACK = 1.3
"""Factor on that time: a group is as long as its spectrum is narrow. [-]"""

LEAST = 1e-4
"""White noise of a reading that is always reckoned with. [m]"""


class GaugeForecast(NamedTuple):
    """Constants of the forecast; build it with `GaugeForecast.design`."""

    sampling: float  # time between two readings [s]
    step: float  # between two samples of the law [s]
    rows: Array  # (n, 2 b): readings by age, recent first, of the parts of the amplitudes [-]
    own: Array  # (n,) covariance of noise and drift over the lag between readings [m^2]
    doubtful: Array  # (all bins, n): noise of the readings per spectrum of a bin, over the lag [rad/s]
    floating: Placed  # how the float saw the waves; where it does not move its reach is none
    omega: Array  # (b,) [rad/s]
    ahead: Array  # (2, leads, 2 b): moments at rest at each step from the last reading on, of the parts [Nm/m]

    @classmethod
    def design(cls, plant: Plant, predictor: Predictor, estimator: MomentEstimator, gauge: Gauge) -> GaugeForecast:
        """Design the forecast.

        Parameters
        ----------
        plant : Plant
            The design model: gives He_j and the depth.
        predictor : Predictor
            The forecast from the sensors alone, by the same estimator: gives what is looked at, and learns the sea.
        estimator : MomentEstimator
            Where the moments come from.
        gauge : Gauge
            What is believed of the gauge.

        Raises
        ------
        InputError
            Field ``gauge.sampling``: neither a multiple nor a whole part of the step.
        """
        step, sampling, learner = predictor.step, gauge.sampling, predictor.learner
        rare = steps_between(sampling, step)
        few = learner.omega <= HIGHEST
        k = wavenumber(learner.omega, plant.depth)
        lag = sampling * np.arange(count_of(gauge, plant.depth))
        left = np.exp(-0.5 * (k * gauge.placing) ** 2)
        angle = k[few] * gauge.distance - np.outer(lag, learner.omega[few])
        own = gauge.drift**2 * np.exp(-lag / gauge.drift_time)
        own[0] += gauge.gauge_noise**2 + LEAST**2
        lost = learner.width * np.where(few, 1.0 - left**2, 1.0)
        swing = np.cos(np.outer(learner.omega, lag)) * np.sinc(0.5 / np.pi * learner.width * lag)
        return cls(
            float(sampling),
            float(step),
            np.ascontiguousarray(np.hstack([left[few] * np.cos(angle), -left[few] * np.sin(angle)])),
            own,
            np.ascontiguousarray(lost[:, None] * swing),
            predictor.placed or _at_rest(plant, predictor, estimator, gauge.heading),
            learner.omega[few],
            _ahead(plant, gauge.heading, learner.omega[few], step, predictor.horizon + rare),
        )

    def init(self) -> GaugeState:
        """Return a state in which nothing has been prepared."""
        n, twice = self.rows.shape
        return GaugeState(np.zeros(1, np.int64), np.zeros((twice, n)), np.zeros((twice, twice)), np.zeros(twice))


class GaugeState(NamedTuple):
    """What follows from the gauge under the present spectrum, changed in place by `prepare`."""

    ready: NDArray[np.int64]  # (1,) whether it has been prepared
    follows: Array  # (2 b, n): relative amplitudes, given the readings [1/m]
    root: Array  # (2 b, 2 b), upper W: what they leave open has the precision W' W
    scale: Array  # (2 b,) deviations of the amplitudes under the spectrum alone [m]


def steps_between(sampling: float, step: float) -> int:
    """Samples of the law from one reading to the next, 1 where readings are as frequent or more.

    Raises
    ------
    InputError
        Field ``gauge.sampling``: neither a multiple nor a whole part of the step.
    """
    for long, short, steps in ((step, sampling, 1), (sampling, step, round(sampling / step))):
        ratio = round(long / short)
        if ratio >= 1 and math.isclose(long, ratio * short, rel_tol=1e-9):
            return steps
    problem = f"is neither a multiple nor a whole part of the law's period of {step:g} s"
    raise InputError("gauge.sampling", sampling, problem, f"Give for example {step:g} s")


def count_of(gauge: Gauge, depth: float) -> int:
    """Readings that are looked at."""
    way = gauge.distance / float(group_velocity(np.array([SLOWEST]), depth)[0])
    return round(max(SHORTEST, SLACK * way) / gauge.sampling)


def _at_rest(plant: Plant, predictor: Predictor, estimator: MomentEstimator, heading: float) -> Placed:
    """How a float that does not move sees the waves; those that are not told apart are noise of the moments."""
    from scipy.linalg import expm

    learner, step = predictor.learner, predictor.step
    few = learner.omega <= HIGHEST
    omega = learner.omega[few]
    model = float_model(seen_from(plant), estimator.wp, estimator.spread, (1.0, 1.0), 0.0)
    through = transfer(model, np.asarray(expm(model.A * estimator.period)), estimator.gain, omega, step)
    moments = np.einsum("ijb,jb->ib", through, plant.excitation(omega, heading))
    noise = learner.noise + np.einsum("b,pbk->pk", np.where(few, 0.0, learner.prior), learner.seen)
    return Placed(
        0.0,
        learner.ages,
        np.ascontiguousarray(-step * np.outer(learner.ages, omega)),
        np.zeros(omega.size),
        np.stack([part for moment in moments for part in (moment.real, moment.imag)]),
        np.zeros((2, 1, 2 * omega.size)),
        noise,
        learner.width,
    )


def _ahead(plant: Plant, heading: float, omega: Array, step: float, leads: int) -> Array:
    turn = np.exp(1j * step * np.outer(np.arange(leads), omega))
    turned = plant.excitation(omega, heading)[:, None, :] * turn
    return np.ascontiguousarray(np.concatenate([turned.real, -turned.imag], axis=2))


@stamped(SOURCES)
def prepare(c: GaugeForecast, spectrum: Array, state: GaugeState) -> None:
    """Work out what the readings tell of the amplitudes under a spectrum (all bins,) [m^2 s]."""
    n, twice = c.rows.shape
    bins = twice // 2
    for b in range(bins):
        state.scale[b] = math.sqrt(spectrum[b] * c.floating.width)
        state.scale[bins + b] = state.scale[b]
    lags, column = c.own.copy(), np.empty(max(n, twice))
    add_rows(spectrum, c.doubtful, 0, spectrum.size, lags, 0, n)
    U = np.empty((n, n))
    for r in range(n):
        for s in range(r, n):
            U[r, s] = lags[s - r]
    factorise(U, column)
    Z = np.empty((n, twice))  # the rows, whitened
    for r in range(n):
        for b in range(twice):
            Z[r, b] = c.rows[r, b] * state.scale[b]
    forward(U, Z, column)
    W = state.root
    W[:, :] = 0.0
    for r in range(twice):
        for i in range(n):
            column[i] = Z[i, r]
        W[r, r] = 1.0
        add_rows(column, Z, 0, n, W[r], r, twice)
    factorise(W, column)
    backward(U, Z, column)
    for r in range(twice):
        for i in range(n):
            state.follows[r, i] = Z[i, r]
    forward(W, state.follows, column)
    backward(W, state.follows, column)
    state.ready[0] = 1


@stamped(SOURCES)
def predict_from_gauge(
    c: GaugeForecast,
    state: GaugeState,
    values: Array,
    last: int,
    steps: int,
    history: Array,
    samples: int,
    now: Array,
    out: NDArray[np.float64],
) -> bool:
    """Write the moments at rest (2, n) at 1 .. n steps ahead, and those of now into `now` (2,). [Nm]

    Parameters
    ----------
    c, state
        Constants, and what was prepared.
    values : (any,) array
        Readings. [m]
    last : int
        The last of them that was read.
    steps : int
        Samples of the law since then.
    history : (past, 3) array
        Round buffer of the moments at the float [Nm] and of its place, see `predict_placed`.
    samples : int
        Moments observed so far.

    Returns
    -------
    bool
        False where nothing was written: too few readings, or one that is no number.
    """
    n, twice = c.rows.shape
    if last < n - 1 or state.ready[0] == 0:
        return False
    for age in range(n):
        if not math.isfinite(values[last - age]):
            return False
    at, bins, length = c.floating, twice // 2, history.shape[0]
    W, scale = state.root, state.scale
    mean, column = np.zeros(twice), np.empty(twice)
    for b in range(twice):
        follows = state.follows[b]
        for age in range(n):
            mean[b] += follows[age] * values[last - age]
    known = 0
    while known < at.ages.size and at.ages[known] < samples:
        known += 1
    size = 2 * known
    X, v = np.empty((twice, size)), np.empty(size)
    since = c.step * steps
    for a in range(known):
        row = (samples - 1 - at.ages[a]) % length
        place, phase = at.reach * history[row, 2], at.phase[a]
        one, three = 0.0, 0.0
        for b in range(bins):
            real, imaginary = cos_sin(phase[b] + c.omega[b] * since - at.k[b] * place)
            X[b, 2 * a] = scale[b] * (at.seen[0, b] * real - at.seen[1, b] * imaginary)
            X[bins + b, 2 * a] = -scale[b] * (at.seen[0, b] * imaginary + at.seen[1, b] * real)
            X[b, 2 * a + 1] = scale[b] * (at.seen[2, b] * real - at.seen[3, b] * imaginary)
            X[bins + b, 2 * a + 1] = -scale[b] * (at.seen[2, b] * imaginary + at.seen[3, b] * real)
            one += X[b, 2 * a] * mean[b] + X[bins + b, 2 * a] * mean[bins + b]
            three += X[b, 2 * a + 1] * mean[b] + X[bins + b, 2 * a + 1] * mean[bins + b]
        v[2 * a], v[2 * a + 1] = history[row, 0] - one, history[row, 1] - three
    forward(W, X, column)
    U = np.empty((size, size))
    for r in range(size):
        for s in range(r, size):
            lag = at.ages[s // 2] - at.ages[r // 2]
            U[r, s] = at.noise[2 * (r % 2) + s % 2, lag] if lag < at.noise.shape[1] else 0.0
        for b in range(twice):
            column[b] = X[b, r]
        add_rows(column, X, 0, twice, U[r], r, size)
    solve_in_place(U, v)
    open_ = np.zeros((twice, 1))
    for b in range(twice):
        for s in range(size):
            open_[b, 0] += X[b, s] * v[s]
    backward(W, open_, column)
    for b in range(twice):
        mean[b] = scale[b] * (mean[b] + open_[b, 0])
    for j in range(2):
        now[j] = 0.0
        for b in range(twice):
            now[j] += c.ahead[j, steps, b] * mean[b]
        for lead in range(out.shape[1]):
            total, wave = 0.0, c.ahead[j, steps + 1 + lead]
            for b in range(twice):
                total += wave[b] * mean[b]
            out[j, lead] = total
    return True


@stamped(SOURCES)
def factorise(U: Array, column: Array) -> None:
    """Cholesky factor U of U' U = G, in place of the upper half of G; `column` is working space."""
    size = U.shape[0]
    for r in range(size):
        for i in range(r):
            column[i] = -U[i, r]
        add_rows(column, U, 0, r, U[r], r, size)
        pivot = math.sqrt(U[r, r])
        for s in range(r, size):
            U[r, s] /= pivot


@stamped(SOURCES)
def forward(U: Array, B: Array, column: Array) -> None:
    """Solve U' X = B in place of B, for an upper U; `column` is working space."""
    size, wide = B.shape
    for r in range(size):
        for i in range(r):
            column[i] = -U[i, r]
        add_rows(column, B, 0, r, B[r], 0, wide)
        for s in range(wide):
            B[r, s] /= U[r, r]


@stamped(SOURCES)
def backward(U: Array, B: Array, column: Array) -> None:
    """Solve U X = B in place of B, for an upper U; `column` is working space."""
    size, wide = B.shape
    for r in range(size - 1, -1, -1):
        for i in range(r + 1, size):
            column[i] = -U[r, i]
        add_rows(column, B, r + 1, size, B[r], 0, wide)
        for s in range(wide):
            B[r, s] /= U[r, r]
