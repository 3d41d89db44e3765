"""The moments over the horizon, by level of information.

`sensors`: predicted from what the sensors let one estimate. `gauge`: from that and the elevation up-wave. `forecast`: a
probe tells them some seconds ahead, and the prediction goes on from there. `oracle`: the probe sees the whole horizon.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point
from gyroctl.waves.estimation import MomentEstimator, Predictor, PredictorState, predict, probe
from gyroctl.waves.estimation.gauge_forecast import find_place, predict_from_gauge
from gyroctl.waves.estimation.gauge_readings import GaugeForecast, GaugeState, prepare
from gyroctl.waves.estimation.predictor import GENERIC
from gyroctl.waves.estimation.probe import Probe, error_of, floor_of
from gyroctl.waves.gauge import Gauge, Readings
from gyroctl.waves.window import Window


class Waves(Protocol):
    """A realisation as `gyroctl.waves.WaveRealisation`, or a window on one."""

    @property
    def moments(self) -> NDArray[np.float64]: ...  # noqa: D102

    @property
    def dt(self) -> float: ...  # noqa: D102

    @property
    def duration(self) -> float: ...  # noqa: D102

    @property
    def seed(self) -> int: ...  # noqa: D102


class Foresight(NamedTuple):
    """How a law sees the moments ahead; build it with `Foresight.design`."""

    predictor: Predictor
    probe: Probe | None  # none where the sensors are all there is
    window: Window | None  # through which the probe sees; none where it was told the whole realisation
    intervals: int  # of the horizon
    period: float  # [s]
    gauge: GaugeForecast | None = None  # none where no gauge is read
    readings: Readings | None = None  # of the gauge; none before a run

    @classmethod
    def design(
        cls,
        plant: Plant,
        estimator: MomentEstimator,
        horizon: float,
        lead: float | None = None,
        noise: float = 0.0,
        waves: Waves | None = None,
    ) -> Foresight:
        """Choose where the moments come from.

        Parameters
        ----------
        plant : Plant
            The design model.
        estimator : MomentEstimator
            What the moments of now come from without a probe.
        horizon : float
            [s]
        lead : float, optional
            How far ahead the probe tells, infinite for the whole horizon; without it there is no probe. [s]
        noise : float
            Error of the probe, as a part of the moments' deviation. [-]
        waves : realisation or window on one, optional
            What the probe sees.

        Raises
        ------
        InputError
            For a probe without waves, or waves shorter than the horizon.
        """
        intervals, period = round(horizon / estimator.period), estimator.period
        if lead is None:
            predictor = Predictor.design(plant, period, horizon=horizon, estimator=estimator)
            return cls(predictor, None, None, intervals, period)
        if waves is None:
            raise InputError(
                "nmpc.seen",
                None,
                "a law that may look ahead was told no waves",
                "Call law.informed(waves) first; comparison and simulation do",
            )
        if waves.duration < horizon:
            raise InputError(
                "nmpc.horizon",
                horizon,
                f"is longer than the waves that were told, {waves.duration:g} s",
                "Give a shorter horizon or longer waves",
            )
        window = waves if isinstance(waves, Window) else None
        deviation = np.std(waves.moments, axis=1) if window is None else window.deviation
        predictor = Predictor.design(plant, period, horizon=horizon, floor=floor_of(deviation, noise))
        if window is None:
            whole = Probe.design(predictor, waves.moments, waves.dt, lead, noise, waves.seed)
            return cls(predictor, whole, None, intervals, period)
        blank = Probe.design(predictor, np.zeros(window.moments.shape), window.dt, lead, noise)
        error = error_of(window.deviation, noise, blank.told.shape, window.seed)
        return cls(predictor, blank._replace(told=error), window, intervals, period)

    @classmethod
    def gauged(
        cls, plant: Plant, estimator: MomentEstimator, horizon: float, gauge: Gauge, readings: Readings | None = None
    ) -> Foresight:
        """Let the moments come from a gauge up-wave and the sensors together.

        Parameters
        ----------
        plant, estimator, horizon
            As of `design`.
        gauge : Gauge
            What is believed of the gauge.
        readings : Readings, optional
            What is read of it.

        Raises
        ------
        InputError
            For a gauge whose readings do not fit the period.
        """
        period, sea = estimator.period, replace(GENERIC, heading=gauge.heading)
        predictor = Predictor.design(plant, period, horizon=horizon, sea=sea, estimator=estimator)
        told = GaugeForecast.design(plant, predictor, estimator, gauge)
        return cls(predictor, None, None, round(horizon / period), period, told, readings)

    def read(
        self, t: float, learnt: bool, memory: PredictorState, gauge: GaugeState, ahead: NDArray[np.float64]
    ) -> bool:
        """Write the moments at the end of each interval from `t` [s] on into `ahead` (2, n), as gauge and sensors tell.

        Where a reading is missing or none has been made for long enough, by the sensors alone, and then it returns
        False: what the gauge's state says of the errors is of before. `learnt` says that the spectrum has just changed.
        """
        c, readings = self.gauge, self.readings
        if c is None or readings is None:
            raise InputError(
                "nmpc.seen",
                None,
                "a law that reads a gauge was given no readings",
                "Let comparison or simulation inform it, or call law.informed(readings) first",
            )
        last = min(math.floor(t / c.sampling + 1e-6), readings.values.size - 1)
        steps = round((t - last * c.sampling) / self.period)
        given = readings.values, last, steps, memory.history, memory.samples[0]
        if learnt:
            find_place(c, gauge, *given)
        if learnt or gauge.ready[0] == 0:
            prepare(c, memory.memory.spectrum, gauge)
        told = predict_from_gauge(c, gauge, *given, memory.now, ahead)
        if not told:
            predict(self.predictor, memory, ahead)
        return told

    def foresee(self, t: float, known: Probe, memory: PredictorState, ahead: NDArray[np.float64]) -> None:
        """Write the moments at the end of each interval from `t` [s] on into `ahead` (2, n), as a probe tells them."""
        sample = math.floor(t / self.period + 0.5)
        probe.foresee(self.predictor, self._told(known), memory, sample, ahead)

    def _told(self, known: Probe) -> Probe:
        """Return the probe with what it tells by now: through a window its own error alone is known beforehand."""
        if self.window is None:
            return known
        every = round(self.predictor.step / self.window.dt)
        return known._replace(told=self.window.moments[:, ::every] + known.told)


@entry_point
def between(now: NDArray[np.float64], ahead: NDArray[np.float64], period: float, out: NDArray[np.float64]) -> None:
    """Moments at twice as many instants as control intervals, by cubic interpolation.

    A straight line would be off by 3 % of the shortest waves' moments; four points are off by 0.2 %.

    Parameters
    ----------
    now : (2,) array
        Moments of now. [Nm]
    ahead : (2, n) array
        And at the end of each interval. [Nm]
    period : float
        Length of an interval. [s]
    out : (2 (2 n + 1),) or (4 (2 n + 1),) array
        Filled with Me1, Me3 [Nm] at each half interval, and with their rates [Nm/s] behind them where there is room.
    """
    n = ahead.shape[1] + 1
    last = 2 * n - 2
    w = out.size // (last + 1)
    for j in range(2):
        out[j] = now[j]
        for i in range(1, n):
            out[2 * w * i + j] = ahead[j, i - 1]
        for i in range(n - 1):
            middle = 0.5 * (out[2 * w * i + j] + out[2 * w * (i + 1) + j])
            if 0 < i < n - 2:
                middle += 0.125 * (middle - 0.5 * (out[2 * w * (i - 1) + j] + out[2 * w * (i + 2) + j]))
            out[w * (2 * i + 1) + j] = middle
        if w > 2:  # central differences, at the ends those of a parabola
            for i in range(1, last):
                out[w * i + 2 + j] = (out[w * (i + 1) + j] - out[w * (i - 1) + j]) / period
            out[2 + j] = (4.0 * out[w + j] - out[2 * w + j] - 3.0 * out[j]) / period
            back = w * (last - 1)
            out[w * last + 2 + j] = (3.0 * out[w * last + j] - 4.0 * out[back + j] + out[back - w + j]) / period
