"""Sensors: noise, bias, quantisation, delay, dropout and loss between the plant and the law."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError, check_kind
from gyroctl.faces.settings import settings_face
from gyroctl.faces.show import shown
from gyroctl.froude import growth
from gyroctl.plant.compiled import inlined
from gyroctl.plant.measurement import CHANNELS, ROWS
from gyroctl.reading import is_finite

LONGEST = 20_000
"""Samples beyond which errors are not kept: 2000 s at the default period."""

STREAM = 0x5E45  # separates the sensors' random numbers from the waves' of the same seed


BOUNDS = {
    "noise": (1e-12, 1e6),
    "bias": (1e-12, 1e6),
    "quantum": (1e-12, 1e6),
    "delay": (1, 10_000),
    "dropout": (1e-12, 1.0),
    "lost_from": (1e-3, 1e7),
    "lost_for": (1e-3, 1e7),
}
"""Least and largest size of each setting of a channel that is not zero: beyond them it is a slip of the unit."""

Reads = Literal["nothing", "last", "zero"]

CAME, LAST, NOTHING, ZERO = range(4)
"""What becomes of a sample: it comes, or the law reads the last one that came, no number, or zero."""

FATES = {"nothing": NOTHING, "last": LAST, "zero": ZERO}


@dataclass(frozen=True)
class Channel:
    """One sensor.

    Parameters
    ----------
    noise : float
        Standard deviation of white noise per sample. [unit of the channel]
    bias : float
        Constant error. [unit of the reading]
    quantum : float
        Resolution; 0 for none. [unit of the reading]
    delay : int
        Age of the measurement in samples of the actuators' period.
    dropout : float
        Probability that a sample is missing; the law then sees the last one that came. [-]
    lost_from, lost_for : float
        When the sensor is lost, and for how long; 0 s is never. With "last" for one period it is one sample that comes
        a period late. [s]
    lost_reads : {"nothing", "last", "zero"}
        What the law reads then: NaN, the last value that came, or 0.
    """

    noise: float = 0.0
    bias: float = 0.0
    quantum: float = 0.0
    delay: int = 0
    dropout: float = 0.0
    lost_from: float = 0.0
    lost_for: float = 0.0
    lost_reads: Reads = "nothing"


@shown(settings_face)
@dataclass(frozen=True)
class Sensors:
    """The seven sensors. Defaults: encoders of 4096 lines, gyros and inclinometers of about 1 % noise.

    Raises
    ------
    InputError
        For a negative noise, resolution, delay or time, a dropout outside [0, 1), or an unknown reading.
    """

    psi: Channel = Channel(noise=1e-3, quantum=2.0 * math.pi / 4096)
    psi_rate: Channel = Channel(noise=0.02)
    omega_rate: Channel = Channel(noise=0.1)
    phi1: Channel = Channel(noise=1e-3)
    phi3: Channel = Channel(noise=1e-3)
    phi1_rate: Channel = Channel(noise=4e-3)
    phi3_rate: Channel = Channel(noise=4e-3)

    def __post_init__(self) -> None:
        for name in CHANNELS:
            channel = getattr(self, name)
            check_kind(f"sensors.{name}", channel, Channel, "a channel", "Give gyroctl.Channel(noise=...)")
            if not isinstance(channel.lost_reads, str) or channel.lost_reads not in FATES:
                path, mend = f"sensors.{name}.lost_reads", f"Choose one of {', '.join(FATES)}"
                raise InputError(path, channel.lost_reads, "no such reading", mend)
            for f in fields(Channel):
                if f.name == "lost_reads":
                    continue
                value, path = getattr(channel, f.name), f"sensors.{name}.{f.name}"
                if not is_finite(value):
                    raise InputError(path, value, "must be a finite number", f"Give {f.name} as a number")
                low, high = BOUNDS[f.name]
                if value != 0 and not low <= abs(value) <= high:
                    mend = f"Give {f.name} as 0, or from {low:g} to {high:g}"
                    raise InputError(path, value, "is out of bounds", mend)
                if f.name != "bias" and value < 0:
                    raise InputError(path, value, "must not be negative", f"Give {f.name} >= 0")
            if channel.dropout >= 1.0:
                raise InputError(f"sensors.{name}.dropout", channel.dropout, "must be below 1", "Give a probability")
            if int(channel.delay) != channel.delay:
                raise InputError(f"sensors.{name}.delay", channel.delay, "must be whole samples", "Give an integer")

    @classmethod
    def ideal(cls) -> Sensors:
        """Sensors without any error."""
        return cls(*(Channel() for _ in CHANNELS))

    def at(self, length: float) -> Sensors:
        """Return the sensors of a device that is `length` times as long: rates and times by Froude's law."""
        rate, time = growth("rad/s", length), growth("s", length)
        changed: dict[str, Channel] = {}
        for name in CHANNELS:
            channel = getattr(self, name)
            by = rate if name.endswith("_rate") else 1.0
            errors = {part: getattr(channel, part) * by for part in ("noise", "bias", "quantum")}
            times = {part: getattr(channel, part) * time for part in ("lost_from", "lost_for")}
            changed[name] = replace(channel, **errors, **times)
        return Sensors(**changed)

    def arrays(self, samples: int, seed: int, period: float = 0.1) -> SensorArrays:
        """Errors of one realisation, a sample each `period` [s]: the same for every law that is run on it.

        They are not to be written to.

        Those of the last realisations are kept, up to 40 MB: drawing them is a part of the time of a law in lanes, and
        a search runs one law after the other on the same ones.
        """
        return _kept(self, samples, seed, period) if samples <= LONGEST else drawn(self, samples, seed, period)


class SensorArrays(NamedTuple):
    """Errors of one realisation: error (n, 7), fate (n, 7) from CAME to ZERO, quantum (7,), delay (7,)."""

    error: NDArray[np.float64]
    fate: NDArray[np.int8]
    quantum: NDArray[np.float64]
    delay: NDArray[np.int64]


def drawn(sensors: Sensors, samples: int, seed: int, period: float = 0.1) -> SensorArrays:
    """Draw the errors of one realisation, a sample each `period` [s]."""
    channels = [getattr(sensors, name) for name in CHANNELS]
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, STREAM])))
    error = rng.standard_normal((samples, len(CHANNELS)))
    error *= np.array([c.noise for c in channels])  # in place: fresh memory costs as much as the product
    error += np.array([c.bias for c in channels])
    fate = np.full((samples, len(CHANNELS)), CAME, np.int8)
    if any(c.dropout > 0.0 for c in channels):  # nothing is drawn after it
        missing = rng.random(fate.shape)[1:] < np.array([c.dropout for c in channels])
        fate[1:][missing] = LAST
    for i, channel in enumerate(channels):
        first, end = (math.ceil(t / period - 1e-9) for t in (channel.lost_from, channel.lost_from + channel.lost_for))
        fate[first:end, i] = FATES[channel.lost_reads]
    return SensorArrays(
        error, fate, np.array([float(c.quantum) for c in channels]), np.array([int(c.delay) for c in channels])
    )


_kept = lru_cache(maxsize=32)(drawn)


@inlined
def measure(sensors: SensorArrays, sample: int, record: Any, y: Any) -> None:
    """Write the seven measurements at `sample` into `y`; `record` (n, rows) holds the states so far."""
    for channel in range(len(ROWS)):
        fate = sensors.fate[sample, channel]
        if fate != CAME:
            if fate != LAST:
                y[channel] = math.nan if fate == NOTHING else 0.0
            continue
        value = record[max(sample - sensors.delay[channel], 0), ROWS[channel]] + sensors.error[sample, channel]
        quantum = sensors.quantum[channel]
        if quantum > 0.0:
            value = math.floor(value / quantum + 0.5) * quantum
        y[channel] = value
