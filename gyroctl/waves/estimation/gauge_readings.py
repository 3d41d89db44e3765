"""What the readings of a gauge tell of the waves: amplitudes of bins, before the float has felt anything.

The waves are complex amplitudes of the bins of a spectrum, Gaussian and independent before anything is measured. The
elevation at the gauge, d up-wave, is linear in them: there the wave of a bin has the phase w t + k d. No delay is set
anywhere, low waves that outrun and high ones that are late come out of k(w).

What of a reading is no wave stands in its covariance, and is thereby kept out of the estimate: white noise; drift, of
covariance ``drift^2 exp(-lag / T)``; waves too short to be told apart; and the doubt where the gauge stands. If that is
off by a normal deviation s, the wave of a bin is seen with its phase off by k s: on the mean exp(-k^2 s^2 / 2) of it is
left, and the rest is noise of its spectrum.

With Z the readings of amplitudes of unit variance and e the readings, both over the root of that covariance, they add
Z' Z and Z' e to the normal equations of `placed`. The gauge does not move, so these change only with the spectrum that
is learnt and the place that is found: `prepare` works them out every few seconds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import group_velocity, wavenumber
from gyroctl.plant.compiled import lent, stamped
from gyroctl.plant.plant import Plant
from gyroctl.plant.row_sums import add_rows
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.estimation import placed as places
from gyroctl.waves.estimation.gaussian import Bins, responses
from gyroctl.waves.estimation.moment_model import Array
from gyroctl.waves.estimation.observer import MomentEstimator
from gyroctl.waves.estimation.placed import (
    Placed,
    PlacedState,
    add_normal_equations,
    begun,
    factorise_upper,
    placed,
    scale_waves,
)
from gyroctl.waves.estimation.predictor import Predictor, seen_through
from gyroctl.waves.gauge import Gauge

SOURCES = (*places.SOURCES, __file__)

FINE = (0.1, 0.1)
"""Widths of the bins, see `placed.BROAD`: the way from the gauge is longer than what is looked at. [rad/s]"""

SHORTEST, SLOWEST = 12.0, 5.0
"""Readings go back so far [s], or as long as waves of this frequency [rad/s] take from the gauge to the float."""

SLACK = 1.3
"""Factor on that time: a group is as long as its spectrum is narrow. [-]"""

APART = 0.02
"""Least deviation of the believed place. [m]"""

WIDEST = 0.3
"""Greatest part of the distance by which the gauge is looked for elsewhere. [-]"""

LEAST = 1e-4
"""White noise of a reading that is always reckoned with. [m]"""


class GaugeForecast(NamedTuple):
    """Constants of the forecast; build it with `GaugeForecast.design`."""

    sampling: float  # time between two readings [s]
    step: float  # between two samples of the law [s]
    distance: float  # of the gauge, as it is believed [m]
    own: Array  # (n,) covariance of noise and drift over the lag between readings [m^2]
    doubtful: Array  # (all bins, n): noise of the readings per spectrum of a bin, over the lag [rad/s]
    left: Array  # (b,) part of a wave that the doubt about the place leaves [-]
    omega: Array  # (b,) of the waves that are told apart [rad/s]
    k: Array  # (b,) their wave numbers [rad/m]
    waves: Placed  # how the float saw them, and the moments ahead from the last reading on
    bound: float  # how far from where it is believed the gauge is looked for [m]
    trust: float  # precision of the believed place [1/m^2]

    @classmethod
    def design(cls, plant: Plant, predictor: Predictor, estimator: MomentEstimator, gauge: Gauge) -> GaugeForecast:
        """Design the forecast.

        Parameters
        ----------
        plant : Plant
            The design model: gives He_j and the depth.
        predictor : Predictor
            The forecast from the sensors alone, by the same estimator: gives how far to look ahead, and learns the sea.
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
        leads = predictor.horizon + steps_between(sampling, step) - 1
        response = responses(
            plant, gauge.heading, Bins(learner.omega, learner.width), seen_through(plant, estimator, learner.omega)
        )
        past, noise = float(step * learner.ages[-1]), learner.noise[[0, 3], 0]
        moves = predictor.placed is not None
        waves = placed(plant, response, gauge.heading, step, past, leads, noise, moves, FINE)
        waves = waves._replace(far=min(waves.far, predictor.horizon))
        few = waves.edges[-1]
        omega = np.add.reduceat(learner.omega[:few], waves.edges[:-1]) / np.diff(waves.edges)
        lag, k = sampling * np.arange(count_of(gauge, plant.depth)), wavenumber(learner.omega, plant.depth)
        own = gauge.drift**2 * np.exp(-lag / gauge.drift_time)
        own[0] += gauge.gauge_noise**2 + LEAST**2
        lost = learner.width * np.where(np.arange(k.size) < few, 1.0 - np.exp(-((k * gauge.placing) ** 2)), 1.0)
        swing = np.cos(np.outer(learner.omega, lag)) * np.sinc(0.5 / np.pi * learner.width * lag)
        told_apart = wavenumber(omega, plant.depth)
        return cls(
            float(sampling),
            float(step),
            float(gauge.distance),
            own,
            np.ascontiguousarray(lost[:, None] * swing),
            np.exp(-0.5 * (told_apart * gauge.placing) ** 2),
            omega,
            told_apart,
            waves,
            WIDEST * gauge.distance,
            1.0 / max(gauge.placing, APART) ** 2,
        )

    def init(self) -> GaugeState:
        """Return a state in which nothing has been prepared."""
        n, twice = self.own.size, 2 * self.omega.size
        told, place = np.zeros((twice, n)), np.array([0.0, self.trust])
        return GaugeState(
            np.zeros(1, np.int64), told, np.zeros((twice, twice)), np.zeros(twice), place, begun(self.waves)
        )


class GaugeState(NamedTuple):
    """What follows from the gauge under the present spectrum, changed in place by `prepare`."""

    ready: NDArray[np.int64]  # (1,) whether it has been prepared
    told: Array  # (2 b, n): what a reading adds to the right of the normal equations [1/m]
    precision: Array  # (2 b, 2 b), upper half: what the readings and the spectrum add to their matrix [-]
    root: Array  # (2 b,) deviations of the amplitudes under the spectrum alone [m]
    place: Array  # how much farther the gauge is than believed [m], and with what precision that is known [1/m^2]
    waves: PlacedState


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


@stamped(SOURCES)
def prepare(c: GaugeForecast, spectrum: Array, state: GaugeState) -> None:
    """Work out what the readings tell of the amplitudes under a spectrum (all bins,) [m^2 s]."""
    n, twice = c.own.size, state.root.size
    scale_waves(c.waves, spectrum, state.root)
    lags, column = c.own.copy(), np.empty(n)
    add_rows(spectrum, c.doubtful, 0, spectrum.size, lags, 0, n)
    U, Z, none = np.empty((n, n)), np.empty((n, twice)), np.zeros(n)
    for r in range(n):
        for s in range(r, n):
            U[r, s] = lags[s - r]
    factorise_upper(U)
    place_readings(c, state, Z)
    for r in range(n):  # U' Z = the readings of amplitudes of unit variance
        for i in range(r):
            column[i] = -U[i, r]
        add_rows(column, lent(Z), 0, r, Z[r], 0, twice)
        for b in range(twice):
            Z[r, b] /= U[r, r]
    state.precision[:, :] = 0.0
    add_normal_equations(Z, none, state.precision, np.empty(twice))
    for r in range(twice):
        state.precision[r, r] += 1.0
    for r in range(n - 1, -1, -1):  # and U T' = Z
        for i in range(r + 1, n):
            column[i] = -U[r, i]
        add_rows(column, lent(Z), r + 1, n, Z[r], 0, twice)
        for b in range(twice):
            Z[r, b] /= U[r, r]
            state.told[b, r] = Z[r, b]
    state.ready[0] = 1


@stamped(SOURCES)
def place_readings(c: GaugeForecast, state: GaugeState, rows: Array) -> None:
    """Write the readings (n, 2 b), recent first, of amplitudes of unit variance, from where the gauge was found. [m]"""
    bins, way = c.omega.size, c.distance + state.place[0]
    for age in range(rows.shape[0]):
        for b in range(bins):
            real, imaginary = cos_sin(c.k[b] * way - c.sampling * age * c.omega[b])
            rows[age, b] = state.root[b] * c.left[b] * real
            rows[age, bins + b] = -state.root[b] * c.left[b] * imaginary
