"""Sensors: noise, bias, quantisation, delay and dropout between the plant and the law."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError, check_kind
from gyroctl.plant.compiled import inlined
from gyroctl.plant.measurement import CHANNELS, ROWS

LONGEST = 20_000
"""Samples beyond which errors are not kept: 2000 s at the default period."""

STREAM = 0x5E45  # separates the sensors' random numbers from the waves' of the same seed


BOUNDS = {
    "noise": (1e-12, 1e6),
    "bias": (1e-12, 1e6),
    "quantum": (1e-12, 1e6),
    "delay": (1, 10_000),
    "dropout": (1e-12, 1.0),
}
"""Least and largest size of each setting of a channel that is not zero: beyond them it is a slip of the unit."""


@dataclass(frozen=True)
class Channel:
    """One sensor.

    Parameters
    ----------
    noise : float
        Standard deviation of white noise per sample. [unit of the channel]
    bias : float
        Constant error.
    quantum : float
        Resolution; 0 for none.
    delay : int
        Age of the measurement in samples of the actuators' period.
    dropout : float
        Probability that a sample is missing; the law then sees the last one that came.
    """

    noise: float = 0.0
    bias: float = 0.0
    quantum: float = 0.0
    delay: int = 0
    dropout: float = 0.0


@dataclass(frozen=True)
class Sensors:
    """The seven sensors. Defaults: encoders of 4096 lines, gyros and inclinometers of about 1 % noise.

    Raises
    ------
    InputError
        For a negative noise, resolution or delay, or a dropout outside [0, 1).
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
            for f in fields(Channel):
                value, path = getattr(channel, f.name), f"sensors.{name}.{f.name}"
                if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
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

    def arrays(self, samples: int, seed: int) -> SensorArrays:
        """Errors of one realisation: the same for every law that is run on it, and not to be written to.

        Those of the last realisations are kept, up to 40 MB: drawing them is a part of the time of a law in lanes, and
        a search runs one law after the other on the same ones.
        """
        return _kept(self, samples, seed) if samples <= LONGEST else drawn(self, samples, seed)


class SensorArrays(NamedTuple):
    """Errors of one realisation: error (n, 7), missing (n, 7), quantum (7,), delay (7,)."""

    error: NDArray[np.float64]
    missing: NDArray[np.bool_]
    quantum: NDArray[np.float64]
    delay: NDArray[np.int64]


def drawn(sensors: Sensors, samples: int, seed: int) -> SensorArrays:
    """Draw the errors of one realisation."""
    channels = [getattr(sensors, name) for name in CHANNELS]
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, STREAM])))
    error = rng.standard_normal((samples, len(CHANNELS)))
    error *= np.array([c.noise for c in channels])  # in place: fresh memory costs as much as the product
    error += np.array([c.bias for c in channels])
    missing = np.zeros((samples, len(CHANNELS)), bool)
    if any(c.dropout > 0.0 for c in channels):  # nothing is drawn after it
        missing[1:] = rng.random(missing.shape)[1:] < np.array([c.dropout for c in channels])
    return SensorArrays(
        error, missing, np.array([float(c.quantum) for c in channels]), np.array([int(c.delay) for c in channels])
    )


_kept = lru_cache(maxsize=32)(drawn)


@inlined
def measure(sensors: SensorArrays, sample: int, record: Any, y: Any) -> None:
    """Write the seven measurements at `sample` into `y`; `record` (n, rows) holds the states so far."""
    for channel in range(len(ROWS)):
        if sensors.missing[sample, channel]:
            continue
        value = record[max(sample - sensors.delay[channel], 0), ROWS[channel]] + sensors.error[sample, channel]
        quantum = sensors.quantum[channel]
        if quantum > 0.0:
            value = math.floor(value / quantum + 0.5) * quantum
        y[channel] = value
