"""State and wave moments from the sensors: the nonlinear plant runs along, corrected at each sample.

Prediction is a Runge-Kutta pass of the design model through the one text of the equations, with the controls that were
held and with moments that swing on at the peak frequency. Correction has two parts that hardly know of one another:

- the float with its moments, by the stationary Kalman gain of the averaged model (`averaged`). Given the ring, the
  float is linear, and what is left of the ring's angle in its equations is small, so a constant gain loses nothing;
- ring and flywheel, by a Kalman filter of three states whose transition follows the coupling.

A sensor may be lost. A reading is not believed that is no number, or that repeats the last one to the bit or is exactly
zero while the model says that it has moved, see `doubt`. The ring's filter goes on without it; the float has a constant
gain for each set of sensors that are left, designed beforehand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.beyond import signal_rows
from gyroctl.plant.compiled import inlined, part, stamped
from gyroctl.plant.equations import (
    OMEGA_RATE,
    PHI1,
    PHI1_RATE,
    PHI3,
    PHI3_RATE,
    PSI,
    PSI_RATE,
    RADIATION,
    Coefficients,
    derivative,
    powers,
)
from gyroctl.plant.kernel import rows, slip_rate, steps_for
from gyroctl.plant.plant import Plant
from gyroctl.waves.estimation import lost_readings, ring_filter, wave_signals
from gyroctl.waves.estimation.lost_readings import doubt, known_or
from gyroctl.waves.estimation.moment_model import LEAST_NOISE, Array, gains_of, gains_of_the_rest, innovation_spread
from gyroctl.waves.estimation.ring_filter import correct_ring, predict_ring
from gyroctl.waves.estimation.wave_signals import (
    at_rest,
    phase_along,
    position_of,
    put_signals,
    seen_from,
    signal_table,
    unexplained,
)
from gyroctl.waves.spectrum import SeaState

SENSOR_NOISE = (1.1e-3, 0.02, 0.1, 1e-3, 1e-3, 4e-3, 4e-3)
"""Standard deviations of psi (with its resolution), psi', omega', phi1, phi3, phi1', phi3'. [rad, rad/s]"""

SOURCES = (*ring_filter.SOURCES, wave_signals.__file__, lost_readings.__file__, __file__)

COARSEST = 0.025
"""Longest Runge-Kutta step; where the coupling is strong, shorter ones follow the decay of the slip, see `steps_for`.
[s]"""


class MomentEstimator(NamedTuple):
    """Constants of the estimator; build it with `MomentEstimator.design`."""

    k: Coefficients  # of the design model
    signals: Array  # (places, signals, 4): what it asks of the waves, from the four moments; see `wave_signals` [-]
    turning: float  # phase that the waves lose along the reach of the lever, at wp [rad]
    unexplained: float  # what the guess of the signals misses of the moments [Nm]
    period: float  # sampling period [s]
    wp: float  # frequency at which the moments swing on [rad/s]
    spread: float  # and their damping ratio [-]
    gain: Array  # (f + 4, 4): float rows, Me1, Me1', Me3, Me3' from phi1, phi3, phi1', phi3' [SI]
    partial: Array  # (16, f + 4, 4): gains by the lost sensors, 1 phi1, 2 phi3, 4 phi1', 8 phi3', added up [SI]
    float_noise: Array  # (4,) variances of phi1, phi3, phi1', phi3' per sample [rad^2, rad^2/s^2]
    float_spread: Array  # (4,) variances of their innovations [rad^2, rad^2/s^2]
    ring_noise: Array  # (3,) variances of psi, psi', omega' per sample [rad^2, rad^2/s^2]
    ring_drift: Array  # (3,) variances that a period adds to them [rad^2, rad^2/s^2]
    delay: int  # age of a command when it acts, in samples
    lag: tuple[float, float]  # time constants with which cc and cg follow their commands [s]

    @classmethod
    def design(
        cls,
        plant: Plant,
        sea: SeaState | None = None,
        sensor_noise: tuple[float, ...] = SENSOR_NOISE,
        period: float = 0.1,
        delay: int = 0,
        spread: float = 0.2,
        unmodelled: float = 0.3,
        ring_drift: tuple[float, float, float] = (2e-4, 0.02, 0.05),
        lag: tuple[float, float] = (0.0, 0.0),
    ) -> MomentEstimator:
        """Design the estimator.

        Parameters
        ----------
        plant : Plant
            The design model, with the choices that a law may know of: what its float feels at its own position, of drag
            and of a wetted surface, is then no wave. A contact that slips is taken as rolling, a wetted surface that
            is followed as its polynomials.
        sea : SeaState, optional
            Gives the scale of the moments and the frequency at which they are taken to swing on; the default sea.
        sensor_noise : seven floats
            Standard deviations in the order of the measurements, 0 for an ideal sensor. [rad, rad/s]
        period : float
            Sampling period. [s]
        delay : int
            Age of a command when it acts. [samples]
        spread : float
            Damping ratio of the moments' model, broad so that it fits any sea. [-]
        unmodelled : float
            Intensity of moments on the float that no wave explains. [Nm s^0.5]
        ring_drift : three floats
            Standard deviations of what the model misses of psi, psi', omega' in one period. [rad, rad/s]
        lag : two floats
            Time constants with which cc and cg follow what is commanded, 0 where they jump. [s]

        Raises
        ------
        InputError
            For noise that is negative or not seven numbers, a period that is not positive, a delay that is no count,
            a lag that is negative or not two numbers.
        """
        noise = _checked(sensor_noise)
        if not (math.isfinite(period) and period > 0.0):
            raise InputError("estimator.period", period, "must be positive", "Give the sampling period in seconds")
        if isinstance(delay, bool) or delay != int(delay) or delay < 0:
            raise InputError("estimator.delay", delay, "must be whole samples, zero or more", "Give an integer")
        if len(lag) != 2 or not all(math.isfinite(each) and each >= 0.0 for each in lag):
            raise InputError("estimator.lag", lag, "must be two numbers, none negative", "Give seconds of cc and of cg")
        sea, plant = sea or SeaState(), seen_from(plant)
        model, gains = gains_of(plant, sea, noise, period, spread, unmodelled)
        floor = np.maximum(noise[3:], LEAST_NOISE)
        return cls(
            plant.coefficients,
            signal_table(plant, sea),
            phase_along(plant, sea),
            unexplained(plant, sea),
            float(period),
            sea.wp,
            float(spread),
            np.ascontiguousarray(gains.gain),
            gains_of_the_rest(model, gains, floor, period),
            noise[3:] ** 2,
            innovation_spread(model, gains, floor),
            noise[:3] ** 2,
            np.array(ring_drift, float) ** 2,
            int(delay),
            (float(lag[0]), float(lag[1])),
        )

    def init(self) -> EstimatorState:
        """Return a fresh state; the first sample fills it."""
        n = rows(self.k) - powers(self.k)
        return EstimatorState(
            x_hat=np.zeros(n),
            me_hat=np.zeros(2),
            wave=np.zeros(4),
            ring=np.diag(self.ring_noise),
            queue=np.zeros((self.delay + 1, 2)),
            held=np.zeros(2),
            innovation=np.zeros(7),
            last=np.zeros(7),
            missing=np.zeros(7),
            then=np.zeros(n),
            kept=np.zeros(n + 6),
            work=np.zeros((6, max(rows(self.k), signal_rows(self.k.beyond)))),
            begun=np.zeros(1),
        )


class EstimatorState(NamedTuple):
    """State of the estimator, changed in place by `update`."""

    x_hat: Array  # (n,) state of the plant at the sample, in its order [rad, rad/s]
    me_hat: Array  # (2,) Me1, Me3 at the sample [Nm]
    wave: Array  # (4,) Me1, Me1', Me3, Me3' [Nm, Nm/s]
    ring: Array  # (3, 3) variance of psi, psi', omega' [rad^2, rad^2/s^2]
    queue: Array  # (delay + 1, 2) commands that have not acted yet [Nms]
    held: Array  # (2,) controls at the sample, on their way to what was commanded [Nms]
    innovation: Array  # (7,) measurement less prediction, in their order; 0 where one is missing [rad, rad/s]
    last: Array  # (7,) last readings that were numbers [rad, rad/s]
    missing: Array  # (7,) 1 for readings that were not believed [-]
    then: Array  # (n,) state from which on the next command acts, see `look_to_then` [rad, rad/s]
    kept: Array  # (n + 6,) working space of it [rad, rad/s]
    work: Array  # (6, rows) working space [rad, rad/s]
    begun: Array  # (1,) samples so far [-]


def _checked(sensor_noise: tuple[float, ...]) -> Array:
    noise: Array = np.asarray(sensor_noise, np.float64)
    if noise.shape != (7,) or not np.all(np.isfinite(noise)) or np.any(noise < 0.0):
        mend = "Give standard deviations of psi, psi', omega', phi1, phi3, phi1', phi3'"
        raise InputError("estimator.sensor_noise", sensor_noise, "must be seven numbers, none negative", mend)
    return noise


@inlined
def arrived(begin: float, aim: float, lag: float, t: float) -> float:
    """Control after a time `t` [s] on its way from one value to another. [Nms]"""
    if lag <= 0.0:
        return aim
    return aim + (begin - aim) * math.exp(-t / lag)


@inlined
def on_the_way(begin: float, aim: float, lag: float, since: float, hold: float) -> float:
    """Mean of a control from `since` after its command on over `hold` [s]. [Nms]"""
    if lag <= 0.0:
        return aim
    return aim + (begin - aim) * lag / hold * (math.exp(-since / lag) - math.exp(-(since + hold) / lag))


@stamped(SOURCES)
def update(estimator: MomentEstimator, state: EstimatorState, y: NDArray[np.float64], cc: float, cg: float) -> None:
    """Take one sample, in place.

    Parameters
    ----------
    estimator : MomentEstimator
    state : EstimatorState
        Holds `x_hat` and `me_hat` of this sample afterwards.
    y : (7,) array
        psi, psi', omega', phi1, phi3, phi1', phi3' as measured; NaN where a sensor tells nothing. [rad, rad/s]
    cc, cg : float
        Command since the last sample; ignored at the first. [Nms]
    """
    x, wave, queue = state.x_hat, state.wave, state.queue
    if state.begun[0] == 0.0:
        x[PSI], x[PSI_RATE] = known_or(y[0], 0.0), known_or(y[1], estimator.wp)
        x[OMEGA_RATE] = known_or(y[2], estimator.k.N * x[PSI_RATE])
        x[PHI1], x[PHI3], x[PHI1_RATE] = known_or(y[3], 0.0), known_or(y[4], 0.0), known_or(y[5], 0.0)
        x[PHI3_RATE] = known_or(y[6], 0.0)
        for i in range(7):
            state.last[i] = known_or(y[i], 0.0)
        state.begun[0] = 1.0
        for i in range(queue.shape[0]):
            queue[i, 0], queue[i, 1] = cc, cg
        state.held[0], state.held[1] = cc, cg
        return
    state.begun[0] += 1.0
    last = queue.shape[0] - 1
    for i in range(last):
        queue[i, 0], queue[i, 1] = queue[i + 1, 0], queue[i + 1, 1]
    queue[last, 0], queue[last, 1] = cc, cg
    predict_state(estimator, state, queue[0, 0], queue[0, 1])
    lags, hold, held = estimator.lag, estimator.period, state.held
    mean_cc = on_the_way(held[0], queue[0, 0], lags[0], 0.0, hold)
    predict_ring(estimator, state, mean_cc, on_the_way(held[1], queue[0, 1], lags[1], 0.0, hold))
    for i in range(2):
        held[i] = arrived(held[i], queue[0, i], lags[i], hold)
    e = state.innovation
    e[0], e[1], e[2] = y[0] - x[PSI], y[1] - x[PSI_RATE], y[2] - x[OMEGA_RATE]
    e[3], e[4], e[5], e[6] = y[3] - x[PHI1], y[4] - x[PHI3], y[5] - x[PHI1_RATE], y[6] - x[PHI3_RATE]
    doubt(state.ring, estimator.ring_noise, estimator.float_spread, y, state.last, e, state.missing)
    correct_ring(estimator, state)
    correct_float(estimator, state)
    state.me_hat[0], state.me_hat[1] = wave[0], wave[2]


@stamped(SOURCES)
def look_to_then(estimator: MomentEstimator, state: EstimatorState) -> None:
    """Write the state from which on the next command acts into `state.then`: of now, run on under what is under way.

    Parameters
    ----------
    estimator : MomentEstimator
        The estimator, which knows the delay.
    state : EstimatorState
        Its state, of which ``then`` is written.
    """
    n, kept = state.x_hat.size, state.kept
    for i in range(n):
        kept[i] = state.x_hat[i]
    for i in range(4):
        kept[n + i] = state.wave[i]
    for i in range(2):
        kept[n + 4 + i] = state.held[i]
    for i in range(1, state.queue.shape[0]):
        predict_state(estimator, state, state.queue[i, 0], state.queue[i, 1])
        for j in range(2):
            state.held[j] = arrived(state.held[j], state.queue[i, j], estimator.lag[j], estimator.period)
    for i in range(n):
        state.then[i], state.x_hat[i] = state.x_hat[i], kept[i]
    for i in range(4):
        state.wave[i] = kept[n + i]
    for i in range(2):
        state.held[i] = kept[n + 4 + i]


@part(SOURCES)
def predict_state(estimator: MomentEstimator, state: EstimatorState, cc: float, cg: float) -> None:
    """Run plant and moments over one period, the controls on their way from `state.held` to what is commanded.

    Each step takes their mean over it: a lag may be as short as a step, and the ring feels its impulse alone.
    """
    lags, held = estimator.lag, state.held
    k, x_hat, wave, work = estimator.k, state.x_hat, state.wave, state.work
    n = x_hat.size
    hold = estimator.period
    steps = steps_for(hold, COARSEST, slip_rate(k, cc if lags[0] == 0.0 else max(cc, held[0])))
    h = hold / steps
    x, dx, total, signals = work[0], work[1], work[2], work[3]
    decay = estimator.spread * estimator.wp
    turn = estimator.wp * math.sqrt(1.0 - estimator.spread**2)
    one = (wave[1] + decay * wave[0]) / turn
    three = (wave[3] + decay * wave[2]) / turn
    for step in range(steps):
        for i in range(n):
            x[i] = x_hat[i]
            total[i] = 0.0
        mean_cc = on_the_way(held[0], cc, lags[0], step * h, h)
        mean_cg = on_the_way(held[1], cg, lags[1], step * h, h)
        for stage in range(4):
            ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
            s = step * h + ahead
            fade = math.exp(-decay * s)
            c, sn = fade * math.cos(turn * s), fade * math.sin(turn * s)
            me1, me3 = c * wave[0] + sn * one, c * wave[2] + sn * three
            rate1 = c * (turn * one - decay * wave[0]) - sn * (turn * wave[0] + decay * one)
            rate3 = c * (turn * three - decay * wave[2]) - sn * (turn * wave[2] + decay * three)
            put_signals(k.beyond, estimator.signals, x[PHI1], me1, rate1, me3, rate3, signals)
            derivative(x, dx, 1, 0, k, mean_cc, mean_cg, me1, me3, k.beyond, signals)
            share = h / 6.0 if stage == 0 or stage == 3 else h / 3.0
            to = h if stage == 2 else 0.5 * h
            for i in range(n):
                total[i] += share * dx[i]
                x[i] = x_hat[i] + to * dx[i]
        for i in range(n):
            x_hat[i] += total[i]
    fade = math.exp(-decay * hold)
    c, sn = fade * math.cos(turn * hold), fade * math.sin(turn * hold)
    for j in range(2):
        m, v = wave[2 * j], wave[2 * j + 1]
        b = (v + decay * m) / turn
        wave[2 * j] = c * m + sn * b
        wave[2 * j + 1] = c * (turn * b - decay * m) - sn * (turn * m + decay * b)


@part(SOURCES)
def correct_float(estimator: MomentEstimator, state: EstimatorState) -> None:
    """Correct float and moments by the constant gain of the sensors that tell something."""
    x, wave, e, lost, moved = state.x_hat, state.wave, state.innovation, state.missing, state.work[3]
    gain = estimator.partial[int(lost[3] + 2.0 * lost[4] + 4.0 * lost[5] + 8.0 * lost[6])]
    f = x.size - 4  # psi, omega and their rates are not of the float
    for i in range(f + 4):
        move = gain[i, 0] * e[3] + gain[i, 1] * e[4] + gain[i, 2] * e[5] + gain[i, 3] * e[6]
        if i >= f:
            moved[i - f] = move
        elif i < 2:
            x[PHI1 + i] += move
        elif i < 4:
            x[PHI1_RATE + i - 2] += move
        else:
            x[RADIATION + i - 4] += move
    at_rest(position_of(estimator.k.beyond), estimator.turning, estimator.wp, x[PHI1], moved)
    for i in range(4):
        wave[i] += moved[i]
