"""Forecast from a gauge up-wave and the sensors together: one Gaussian estimate of the waves that both have seen.

The waves are complex amplitudes of the bins of a spectrum, Gaussian and independent before anything is measured. Two
kinds of measurements are linear in them: the elevation at the gauge, d up-wave, where the wave of a bin has the phase
w t + k d, and the moments at the float. The estimate of the amplitudes given both is the best one, and gives the
moments ahead: no delay is set anywhere, low waves that outrun and high ones that are late come out of k(w).

What of a reading is no wave stands in its covariance, and is thereby kept out of the estimate: white noise; drift, of
covariance ``drift^2 exp(-lag / T)``; waves too short to be told apart; and the doubt where the gauge stands. If that is
off by a normal deviation s, the wave of a bin is seen with its phase off by k s: on the mean exp(-k^2 s^2 / 2) of it is
left, and the rest is noise of its spectrum.

Where the gauge truly stands is learnt. If it is off by some way, waves at the float are turned by k times that against
what the gauge says; so every few seconds the likelihood of the moments is asked for a little nearer and a little
farther, and the place takes a Newton step (`find_place`). Waves that come at an angle are, to the gauge, a shorter way.

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
from gyroctl.waves.estimation.placed_values import HIGHEST, Placed, solve_in_place
from gyroctl.waves.estimation.predictor import Predictor
from gyroctl.waves.estimation.wave_signals import seen_from
from gyroctl.waves.gauge import Gauge

SOURCES = (*places.SOURCES, __file__)

SHORTEST, SLOWEST = 12.0, 5.0
"""Readings go back so far [s], or as long as waves of this frequency [rad/s] take from the gauge to the float."""

SLACK = 1.3
"""Factor on that time: a group is as long as its spectrum is narrow. [-]"""

APART, MOST = 0.02, 0.1
"""Distances at which the likelihood is compared, and longest step of the place. [m]"""

REMEMBERED, WIDEST = 0.96, 0.3
"""Part of what is known of the place that is left at the next step, and its greatest part of the distance. [-]"""

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
    k: Array  # (b,) wave numbers [rad/m]
    bound: float  # how far from where it is believed the gauge is looked for [m]
    trust: float  # precision of the believed place [1/m^2]
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
            k[few],
            WIDEST * gauge.distance,
            1.0 / max(gauge.placing, APART) ** 2,
            _ahead(plant, gauge.heading, learner.omega[few], step, predictor.horizon + rare),
        )

    def init(self) -> GaugeState:
        """Return a state in which nothing has been prepared."""
        n, twice = self.rows.shape
        place = np.array([0.0, self.trust])
        return GaugeState(np.zeros(1, np.int64), np.zeros((twice, n)), np.zeros((twice, twice)), np.zeros(twice), place)


class GaugeState(NamedTuple):
    """What follows from the gauge under the present spectrum, changed in place by `prepare`."""

    ready: NDArray[np.int64]  # (1,) whether it has been prepared
    follows: Array  # (2 b, n): relative amplitudes, given the readings [1/m]
    root: Array  # (2 b, 2 b), upper W: what they leave open has the precision W' W
    scale: Array  # (2 b,) deviations of the amplitudes under the spectrum alone [m]
    place: Array  # how much farther the gauge is than believed [m], and with what precision that is known [1/m^2]


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
    twice = c.rows.shape[1]
    bins, mean = twice // 2, np.zeros(twice)
    if steps + out.shape[1] >= c.ahead.shape[1]:  # the last reading is too old: none has come since
        return False
    if state.ready[0] == 0 or not told_by_gauge(c, state, values, last, mean):
        return False
    size = 2 * known_of(c.floating.ages, samples)
    X, v, U = np.empty((twice, size)), np.empty(size), np.empty((size, size))
    reckon(c, state, mean, state.place[0], steps, history, samples, X, v, U)
    solve_in_place(U, v)
    more = np.zeros((twice, 1))
    for b in range(twice):
        for s in range(size):
            more[b, 0] += X[b, s] * v[s]
    backward(state.root, more, np.empty(twice))
    for b in range(bins):  # from where the gauge is believed to where it is
        real, imaginary = cos_sin(-c.k[b] * state.place[0])
        one, other = mean[b] + more[b, 0], mean[bins + b] + more[bins + b, 0]
        mean[b] = state.scale[b] * (one * real - other * imaginary)
        mean[bins + b] = state.scale[b] * (one * imaginary + other * real)
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
def find_place(
    c: GaugeForecast, state: GaugeState, values: Array, last: int, steps: int, history: Array, samples: int
) -> None:
    """Take a step to where the moments at the float are most likely, given the readings; as `predict_from_gauge`."""
    twice = c.rows.shape[1]
    mean, cost = np.zeros(twice), np.zeros(3)
    if state.ready[0] == 0 or not told_by_gauge(c, state, values, last, mean):
        return
    size = 2 * known_of(c.floating.ages, samples)
    X, v, U, w = np.empty((twice, size)), np.empty(size), np.empty((size, size)), np.empty(size)
    for i in range(3):
        reckon(c, state, mean, state.place[0] + (i - 1) * APART, steps, history, samples, X, v, U)
        for r in range(size):
            w[r] = v[r]
        solve_in_place(U, v)
        for r in range(size):
            cost[i] += 0.5 * w[r] * v[r] + math.log(U[r, r])
    slope = (cost[2] - cost[0]) / (2.0 * APART)
    bend = (cost[2] - 2.0 * cost[1] + cost[0]) / APART**2
    state.place[1] = max(REMEMBERED * state.place[1] + max(bend, 0.0), c.trust)
    step = (slope + (1.0 - REMEMBERED) * c.trust * state.place[0]) / state.place[1]
    state.place[0] -= min(max(step, -MOST), MOST)
    state.place[0] = min(max(state.place[0], -c.bound), c.bound)


@stamped(SOURCES)
def told_by_gauge(c: GaugeForecast, state: GaugeState, values: Array, last: int, mean: Array) -> bool:
    """Relative amplitudes (2 b,) by the gauge alone, into `mean`; whether there are readings enough."""
    n, twice = c.rows.shape
    if last < n - 1:
        return False
    for age in range(n):
        if not math.isfinite(values[last - age]):
            return False
    for b in range(twice):
        follows = state.follows[b]
        for age in range(n):
            mean[b] += follows[age] * values[last - age]
    return True


@stamped(SOURCES)
def known_of(ages: NDArray[np.int64], samples: int) -> int:
    """How many of the ages have been observed."""
    known = 0
    while known < ages.size and ages[known] < samples:
        known += 1
    return known


@stamped(SOURCES)
def reckon(
    c: GaugeForecast,
    state: GaugeState,
    mean: Array,
    off: float,
    steps: int,
    history: Array,
    samples: int,
    X: Array,
    v: Array,
    U: Array,
) -> None:
    """Set the moments that the float felt against what the gauge says, were it `off` farther than believed. [m]

    `v` (size,) is what the gauge does not explain, the upper half of `U` (size, size) its covariance, `X` (2 b, size)
    the covariance of the amplitudes with it, up to the factor `root`.
    """
    at, bins, length, scale = c.floating, X.shape[0] // 2, history.shape[0], state.scale
    size, since = v.size, c.step * steps
    column, turn = np.empty(2 * bins), np.empty(bins)
    for b in range(bins):
        turn[b] = c.omega[b] * since - c.k[b] * off
    for a in range(size // 2):
        row = (samples - 1 - at.ages[a]) % length
        place, phase = at.reach * history[row, 2], at.phase[a]
        one, three = 0.0, 0.0
        for b in range(bins):
            real, imaginary = cos_sin(phase[b] + turn[b] - at.k[b] * place)
            X[b, 2 * a] = scale[b] * (at.seen[0, b] * real - at.seen[1, b] * imaginary)
            X[bins + b, 2 * a] = -scale[b] * (at.seen[0, b] * imaginary + at.seen[1, b] * real)
            X[b, 2 * a + 1] = scale[b] * (at.seen[2, b] * real - at.seen[3, b] * imaginary)
            X[bins + b, 2 * a + 1] = -scale[b] * (at.seen[2, b] * imaginary + at.seen[3, b] * real)
            one += X[b, 2 * a] * mean[b] + X[bins + b, 2 * a] * mean[bins + b]
            three += X[b, 2 * a + 1] * mean[b] + X[bins + b, 2 * a + 1] * mean[bins + b]
        v[2 * a], v[2 * a + 1] = history[row, 0] - one, history[row, 1] - three
    forward(state.root, X, column)
    for r in range(size):
        for s in range(r, size):
            lag = at.ages[s // 2] - at.ages[r // 2]
            U[r, s] = at.noise[2 * (r % 2) + s % 2, lag] if lag < at.noise.shape[1] else 0.0
        for b in range(2 * bins):
            column[b] = X[b, r]
        add_rows(column, X, 0, 2 * bins, U[r], r, size)


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
