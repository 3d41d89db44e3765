"""A user's own elevation record, turned into harmonics."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import pictured
from gyroctl.faces.waters import sea_face
from gyroctl.waves.checks import HEIGHT_MAX, heading_angle, series, store, within
from gyroctl.waves.columns import digest
from gyroctl.waves.plausible import check_content

JOIN = 30.0
"""Length of the made-up stretch that joins the end of a record to its beginning [s]."""

SMOOTHING = 0.1
"""Width over which the periodogram is averaged before its peak is read off [rad/s]."""

STEP, TIME_MAX = (1e-4, 1e3), 1e10
"""Least and largest mean step of a record, and the latest time: seconds since 1970 are such. [s]"""

_TIME = "Give times in seconds, rising from line to line, at an even step without gaps"
_ELEVATION = "Give elevations in metres, one for each time, not all the same"


class RecordHarmonics(NamedTuple):
    """Fourier series of a record closed to a loop: ``eta(t) = Re sum_m c_m exp(2 pi i m t / period)``, m = 1..k."""

    period: float  # [s]
    coefficients: NDArray[np.complex128]  # (k,) [m]


@pictured(sea_face)
@dataclass(frozen=True)
class ElevationRecord:
    """A measured elevation at the float centre: one given realisation, the same for every seed.

    The seed is ignored on purpose. Shifting one record by a random time would make many realisations look
    independent that are not, and intervals drawn from them would be wrong; equal content hashes show the truth. For
    an ensemble of seas like the record, give its spectrum as a `TabulatedSpectrum`.

    Time counts from the first sample and the mean elevation is taken off. Times that deviate from an even step (up to
    half a step) are resampled linearly; the moments follow by Fourier series, with the end joined to the beginning
    by 30 s of mirrored record. The elevation is kept but for what lies above 12.566 rad/s and for the first and last
    second, where the kinks of the mirror are rounded off. Near either end the moments depend on waves the record does
    not have: they are off by some six percent of their standard deviation at 5 s, by more nearer to it.

    Parameters
    ----------
    time : array_like, shape (n,)
        Rising times. [s]
    eta : array_like, shape (n,)
        Elevation. [m]
    heading : float
        Direction the waves travel to. [deg]
    notes : tuple of str
        What was done to the numbers, and what is notable about them.

    Raises
    ------
    InputError
        Fields ``sea.time``, ``sea.eta``, ``sea.heading``.
    """

    time: NDArray[np.float64] = field(compare=False, repr=False)
    eta: NDArray[np.float64] = field(compare=False, repr=False)
    heading: float = 0.0
    sha256: str = field(init=False)
    notes: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        """Check the record and take its digest."""
        time, eta = series("sea.time", self.time, _TIME), series("sea.eta", self.eta, _ELEVATION)
        if time.size < 16 or eta.size != time.size:
            sizes = f"{time.size} times, {eta.size} elevations"
            raise InputError("sea.eta", sizes, "must be as many as the times, 16 or more", _ELEVATION)
        check_times(time)
        step = (time[-1] - time[0]) / (time.size - 1)
        within("sea.time", float(step), *STEP, _TIME)
        within("sea.time", float(np.max(np.abs(time))), 0.0, TIME_MAX, _TIME)
        within("sea.eta", float(np.max(np.abs(eta))), 0.0, HEIGHT_MAX, "Give elevations in metres, not in millimetres")
        if np.ptp(eta) <= 1e-12:
            raise InputError("sea.eta", float(np.ptp(eta)), "does not vary", _ELEVATION)
        store(self, time=time, eta=eta, heading=heading_angle(self.heading), sha256=digest(time, eta))
        if not self.notes:
            store(self, notes=self._seen())

    def _seen(self) -> tuple[str, ...]:
        """What is done to these numbers by this class itself."""
        said = []
        level = float(self.eta.mean())
        if abs(level) > 0.05 * self.hs:
            said.append(f"mean level of {level:.4g} m taken off")
        if not self.even:
            said.append(f"uneven times resampled linearly, every {self.step:.4g} s")
        return tuple(said)

    def noted(self, notes: tuple[str, ...]) -> ElevationRecord:
        """Return the same record with other notes."""
        return replace(self, notes=notes)

    def check(self) -> None:
        """Refuse a record that is mostly drift, or sampled too rarely for its waves; see `plausible`."""
        check_content(self.surface, self.step)

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return self.duration / (self.time.size - 1)

    @cached_property
    def even(self) -> bool:
        """Whether the times are even: rounded stamps of an even clock are no jitter, and moving them is an error."""
        clock = self.time - self.time[0]
        return bool(np.abs(clock - self.step * np.arange(clock.size, dtype=np.float64)).max() <= 0.02 * self.step)

    @cached_property
    def surface(self) -> NDArray[np.float64]:
        """Elevation above its mean at even steps from the first sample, shape (n,) [m]."""
        even = self.step * np.arange(self.time.size, dtype=np.float64)
        eta = self.eta if self.even else np.interp(even, self.time - self.time[0], self.eta)
        return np.asarray(eta - eta.mean(), dtype=np.float64)

    @property
    def hs(self) -> float:
        """Significant wave height, four times the standard deviation [m]."""
        return 4.0 * float(self.surface.std())

    @cached_property
    def wp(self) -> float:
        """Frequency of the peak of the smoothed periodogram [rad/s]."""
        power = np.abs(np.fft.rfft(self.surface)) ** 2
        step = 2.0 * math.pi / (self.step * self.eta.size)
        width = 2 * round(0.5 * SMOOTHING / step) + 1
        smooth = np.convolve(power, np.ones(width), mode="same")
        return step * max(1, int(np.argmax(smooth)))

    def harmonics(self, omega_max: float) -> RecordHarmonics:
        """Fourier series of the record closed to a loop, up to `omega_max` [rad/s]."""
        loop = _closed(self.surface, round(JOIN / self.step))
        period = self.step * loop.size
        count = min(int(omega_max * period / (2.0 * math.pi)), (loop.size - 1) // 2)
        return RecordHarmonics(period, np.fft.rfft(loop, norm="forward")[1 : count + 1] * 2.0)


def check_times(time: NDArray[np.float64], gaps: bool = False) -> None:
    """Refuse times that do not rise, and that leave a gap where no `gaps` are allowed."""
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        twice = "stands twice" if steps[back[0]] == 0.0 else "goes back"
        problem = f"must rise from line to line: sample {back[0] + 2} {twice}"
        raise InputError("sea.time", float(time[back[0] + 1]), problem, _TIME)
    gap, usual = int(np.argmax(steps)), float(np.median(steps))
    if steps[gap] > 1.5 * usual and not gaps:
        raise InputError("sea.time", float(time[gap]), f"a gap of {steps[gap]:g} s follows ({usual:g} s usual)", _TIME)


def _closed(eta: NDArray[np.float64], join: int) -> NDArray[np.float64]:
    """Record followed by a stretch that leads from its end, mirrored, over to its beginning, mirrored."""
    join = min(join, eta.size - 2)
    fade = 0.5 * (1.0 + np.cos(np.pi * np.arange(1, join + 1) / (join + 1)))
    after_end, before_start = eta[-2 : -join - 2 : -1], eta[join:0:-1]
    return np.concatenate((eta, fade * after_end + (1.0 - fade) * before_start))
