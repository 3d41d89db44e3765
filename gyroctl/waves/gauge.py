"""A wave gauge up-wave of the float: what it measures, and what a law may have read of it by now.

The elevation at the gauge is that of the same waves: each component is turned by k d on its way over the distance d,
with k from the dispersion at the depth of the water. Measured are samples of it with white noise and a slow drift.

As with a `Window` two objects keep the future apart: the law has the `Readings`, in which nothing is written that was
not measured yet, and the loop has the `GaugeShutter`, which knows the whole record and hands it out as time goes on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.waves.blending import blend_signals
from gyroctl.waves.checks import positive, seed_number, within
from gyroctl.waves.excitation import equivalent_amplitude
from gyroctl.waves.realisation import WaveRealisation

Array = NDArray[np.float64]

GAUGE_DOMAIN = 0x67617567
"""Spawn key ("gaug" in ASCII): the error of the gauge is no other random number of the same seed."""


FARTHEST = 100.0
"""Greatest distance: waves of the peak take a minute over it, and remember little of one another by then. [m]"""

RAREST = 1.0
"""Longest time between two readings. [s]"""


class Gauge(NamedTuple):
    """A gauge as it stands, and what a law believes of it."""

    distance: float = 10.0  # up-wave of the float, as the law believes [m]
    sampling: float = 0.1  # time between two readings [s]
    gauge_noise: float = 0.003  # standard deviation of the white noise of a reading [m]
    drift: float = 0.01  # standard deviation of the slow drift of the mean level [m]
    drift_time: float = 100.0  # time in which the drift forgets itself [s]
    misplaced: float = 0.05  # how much farther than `distance` it truly stands [m]
    heading: float = 0.0  # direction that the waves are believed to travel to, up-wave of which it stands [deg]
    placing: float = 0.05  # standard deviation of the distance that the law reckons with [m]


def check(gauge: Gauge) -> None:
    """Refuse a gauge that cannot stand or measure.

    Raises
    ------
    InputError
        Field ``gauge.NAME``: a number out of range.
    """
    least = "Leave it out for the default"
    for name in ("distance", "sampling", "drift_time"):
        positive(f"gauge.{name}", getattr(gauge, name), least)
    for name in ("gauge_noise", "drift", "placing"):
        within(f"gauge.{name}", getattr(gauge, name), 0.0, 1.0, "Give metres, none negative, or leave it out")
    within("gauge.distance", gauge.distance, 0.0, FARTHEST, f"Give metres, up to {FARTHEST:g}")
    within(
        "gauge.sampling", gauge.sampling, 0.0, RAREST, f"Give seconds, up to {RAREST:g}: waves pass in a second or two"
    )
    within("gauge.heading", gauge.heading, -180.0, 180.0, "Give degrees, 0 for waves along +x3")
    mend = "Give less than the distance, positive where it stands farther away"
    within("gauge.misplaced", gauge.misplaced, -gauge.distance, FARTHEST, mend)


class Water(Protocol):
    """A plant, as far as the way of the waves to it is concerned."""

    @property
    def depth(self) -> float:
        """Depth of the water. [m]"""


@dataclass(frozen=True)
class Readings:
    """What was read of a gauge; ask for `values` anew at each sample.

    Parameters
    ----------
    values : (n,) array
        Elevation as measured at 0, `sampling`, .. up to now, NaN beyond. [m]
    sampling : float
        Time between two readings. [s]
    duration : float
        Length of the run. [s]
    """

    values: Array = field(repr=False)
    sampling: float
    duration: float


class GaugeShutter:
    """Hands out the record of a gauge as time goes on.

    Parameters
    ----------
    record : (n,) array
        The whole record. [m]
    sampling, duration : float
        Time between two readings, length of the run. [s]
    """

    def __init__(self, record: Array, sampling: float, duration: float) -> None:
        self._all, self._sampling, self._count = record, sampling, 0
        self._read = np.full(record.shape, np.nan)
        shown = self._read.view()
        shown.flags.writeable = False
        self.readings = Readings(shown, sampling, duration)
        self.open(0.0)

    def open(self, t: float) -> None:
        """Hand out what has been measured up to `t` [s]; what has been read stays."""
        count = min(math.floor(t / self._sampling + 1e-6) + 1, self._all.size)
        if count > self._count:
            self._read[self._count : count] = self._all[self._count : count]
            self._count = count


def elevation_up_wave(waves: WaveRealisation, water: Water, distance: float, heading: float = 0.0) -> Array:
    """Elevation at a place up-wave of the float, on the grid of a realisation.

    Parameters
    ----------
    waves : WaveRealisation
        The waves, as they act: led in from the regular wave where they are.
    water : Plant
        Gives the depth.
    distance : float
        From the float to the place. [m]
    heading : float
        Direction from the place to the float, 0 towards +x3. [deg]

    Returns
    -------
    (n,) array
        [m]

    Raises
    ------
    InputError
        Field ``waves``: these waves know no components.
    """
    synthesis = waves.synthesis
    if synthesis is None:
        mend = "Realise the sea with gyroctl.realise"
        raise InputError("waves", waves.seed, "a gauge needs the waves, these are their moments alone", mend)
    mean = distance * math.cos(math.radians(waves.sea.heading - heading))
    along: float | Array = mean
    if synthesis.waves.bearings is not None:
        along = distance * np.cos(np.radians(synthesis.waves.bearings - heading))
    out: Array = np.empty((1, waves.grid.n))
    synthesis.superposed(np.exp(1j * along * wavenumber(synthesis.waves.omega, water.depth))[None, :], waves.seed, out)
    peak = wavenumber(np.array([waves.sea.wp]), water.depth)
    blend_signals(out, equivalent_amplitude(waves.sea) * np.exp(1j * mean * peak), waves.sea.wp, waves.dt, waves.blend)
    level: Array = out[0]
    return level


def measured(gauge: Gauge, waves: WaveRealisation, water: Water) -> Array:
    """Record of a gauge over a realisation, (n,) at 0, `sampling`, .. [m].

    Raises
    ------
    InputError
        Field ``gauge.sampling``: no multiple of the waves' step; else as `elevation_up_wave`.
    """
    every = round(gauge.sampling / waves.dt)
    if every < 1 or not math.isclose(every * waves.dt, gauge.sampling, rel_tol=1e-9):
        problem = f"is no multiple of the waves' step of {waves.dt:g} s"
        raise InputError("gauge.sampling", gauge.sampling, problem, "Give a multiple of it, for example 0.1")
    level = elevation_up_wave(waves, water, gauge.distance + gauge.misplaced, gauge.heading)[::every]
    return level + error(gauge, level.size, waves.seed)


def error(gauge: Gauge, count: int, seed: int) -> Array:
    """White noise and drift of so many readings. (n,) [m]

    The drift is the stationary process whose covariance over the lag s is ``drift^2 exp(-s / drift_time)``.
    """
    from scipy.signal import lfilter

    source = np.random.SeedSequence(seed_number(seed), spawn_key=(GAUGE_DOMAIN,))
    white, pushes = np.random.Generator(np.random.PCG64(source)).standard_normal((count, 2)).T.copy()  # by reading
    keep = math.exp(-gauge.sampling / gauge.drift_time)
    pushes[1:] *= math.sqrt(1.0 - keep * keep)
    slow = lfilter([1.0], [1.0, -keep], pushes)
    return np.asarray(gauge.gauge_noise * white + gauge.drift * slow, np.float64)
