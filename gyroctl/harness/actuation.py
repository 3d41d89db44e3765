"""Actuators: limits, delay, quantisation, rate limit and lag between the command and the plant."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.plant.compiled import inlined
from gyroctl.reading import is_finite

BOUNDS = {
    "cc_max": (1e-9, 10.0),
    "cg_max": (1e-9, 10.0),
    "cg_min": (1e-9, 10.0),
    "period": (1e-3, 10.0),
    "cc_lag": (1e-6, 1e4),
    "cg_lag": (1e-6, 1e4),
    "cc_rate": (1e-9, 1e6),
    "cg_rate": (1e-9, 1e6),
    "cc_quantum": (1e-9, 10.0),
    "cg_quantum": (1e-9, 10.0),
    "delay": (1, 10_000),
    "cc_gain": (1e-3, 2.0),
    "length": (1e-2, 1e3),
}
"""Least and largest size of each setting that is not zero, in its unit: beyond them it is a slip of the unit. Of a
device of the size of Table 1; those with a unit grow with the device, see `UNITS`."""

UNITS = {
    **dict.fromkeys(("cc_max", "cg_max", "cg_min", "cc_quantum", "cg_quantum"), "Nms"),
    **dict.fromkeys(("period", "cc_lag", "cg_lag"), "s"),
    **dict.fromkeys(("cc_rate", "cg_rate"), "Nm"),
}
"""Units of the settings that have one; Nms/s of the rates are Nm."""


@dataclass(frozen=True)
class Actuators:
    """Coupling and generator as they can be set. Both only dissipate, unless the generator may serve as a motor.

    With a lag or a limited rate a control moves continuously from its value at the sample to what is asked for: along
    the ramp while the lag alone would be faster, then along the lag's exponential, at every instant of the plant's
    integration. With neither it jumps at the sample. What the actuators themselves take, to switch or to hold, is left
    out: no energy of theirs is in any power.

    Parameters
    ----------
    cc_max, cg_max : float
        Upper limits. [Nms]
    period : float
        Sampling period; commands are held in between. [s]
    cc_lag, cg_lag : float
        Time constants of first-order lags; 0 for none. [s]
    cc_rate, cg_rate : float
        Largest rates of change; 0 for no limit. [Nms/s]
    cc_quantum, cg_quantum : float
        Resolution; 0 for none. [Nms]
    delay : int
        Age of the command when it acts, in samples; before the first one acts the controls stay as at the start.
    cg_min : float
        Lower limit of the generator, zero or negative: the gain down to which it may serve as a motor, for laws that
        start the device (those with a member ``motors`` that is true). For every other law the limit is 0. [Nms]
    cc_gain : float
        What the coupling gives as a part of what it is set to: 1 where its calibration is right. The limit stays. [-]
    length : float
        Length of the device over that of Table 1, by which the bounds of the other settings go, see `at`. [-]

    Raises
    ------
    InputError
        For a value out of range.
    """

    cc_max: float = 0.3
    cg_max: float = 0.02
    period: float = 0.1
    cc_lag: float = 0.0
    cg_lag: float = 0.0
    cc_rate: float = 0.0
    cg_rate: float = 0.0
    cc_quantum: float = 0.0
    cg_quantum: float = 0.0
    delay: int = 0
    cg_min: float = 0.0
    cc_gain: float = 1.0
    length: float = 1.0

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            number = is_finite(value)
            if f.name == "cg_min":
                if not number or value > 0:
                    raise InputError(
                        "actuators.cg_min",
                        value,
                        "must be a finite number, zero or negative",
                        "Give the gain of the generator as a motor, for example -0.02",
                    )
            elif not number or value < 0:
                raise InputError(
                    f"actuators.{f.name}",
                    value,
                    "must be a finite number, zero or positive",
                    f"The default is {f.default}",
                )
        self.fit(self.length if BOUNDS["length"][0] <= self.length <= BOUNDS["length"][1] else 1.0)
        for name in ("cc_max", "cg_max", "period", "cc_gain", "length"):
            if getattr(self, name) == 0:
                raise InputError(f"actuators.{name}", 0, "must be positive", "Leave it out for the default")
        if int(self.delay) != self.delay:
            raise InputError("actuators.delay", self.delay, "must be whole samples", "Give an integer")

    def fit(self, length: float) -> None:
        """Refuse a setting that is out of bounds for a device of a `length` over that of Table 1.

        Raises
        ------
        InputError
            Its field is that of the setting.
        """
        for name, (low, high) in BOUNDS.items():
            value, unit = getattr(self, name), UNITS.get(name, "-")
            least, most = low * growth(unit, min(length, 1.0)), high * growth(unit, max(length, 1.0))
            if value != 0 and not least <= abs(value) <= most:
                mend = f"Give it from {least:g} to {most:g}; the default is {getattr(type(self), name):g}"
                raise InputError(f"actuators.{name}", value, "is out of bounds", mend)

    def at(self, length: float) -> Actuators:
        """Return the actuators of a device that is `length` times as long: all settings by Froude's law."""
        own = {name: getattr(self, name) * growth(unit, length) for name, unit in UNITS.items()}
        return replace(self, length=self.length * length, **own)

    @property
    def moves(self) -> bool:
        """Whether a control takes its time, by a lag or a limited rate."""
        return max(self.cc_lag, self.cg_lag, self.cc_rate, self.cg_rate) > 0.0

    def room(self, samples: int) -> NDArray[np.float64] | None:
        """Room for what the loop notes of controls that move, see `Record.moved`; None where none does."""
        return np.zeros((samples, 3)) if self.moves else None

    def arrays(self, motors: bool = False) -> ActuatorArrays:
        """Return the numbers for the compiled loop; `motors`: the law starts the device and may use the motor."""
        return ActuatorArrays(
            np.array([self.cc_max, self.cg_max]),
            np.array([self.cc_quantum, self.cg_quantum]),
            np.array([self.cc_rate, self.cg_rate], float),
            np.array([self.cc_lag, self.cg_lag], float),
            int(self.delay),
            np.array([0.0, float(self.cg_min) if motors else 0.0]),
            np.array([float(self.cc_gain), 1.0]),
        )


class ActuatorArrays(NamedTuple):
    """Upper limit, resolution, rate, lag, lower limit, gain, each (2,); delay in samples. Of several runs stacked."""

    limit: NDArray[np.float64]
    quantum: NDArray[np.float64]
    rate: NDArray[np.float64]
    lag: NDArray[np.float64]
    delay: Any  # int, or (runs,)
    floor: NDArray[np.float64]
    gain: NDArray[np.float64]


@inlined
def actuate(actuators: ActuatorArrays, sample: int, commands: Any, aim: Any) -> int:
    """Turn the command that acts from `sample` on into the controls `aim` (2,); return how many channels saturated.

    `commands` (n, 2) holds the commands so far; `aim` is changed in place, and keeps what it was while a delay lasts.
    The controls are at once what `aim` says where nothing lags, or else on their way there, see `Course`.
    """
    saturated = 0
    if sample < actuators.delay:
        return saturated
    for channel in range(2):
        wanted = commands[sample - actuators.delay, channel]
        limit, floor = actuators.limit[channel], actuators.floor[channel]
        if wanted < floor or wanted > limit:
            saturated += 1
            wanted = min(max(wanted, floor), limit)
        quantum = actuators.quantum[channel]
        if quantum > 0.0:
            wanted = max(min(math.floor(wanted / quantum + 0.5) * quantum, limit), floor)
        aim[channel] = min(wanted * actuators.gain[channel], limit)
    return saturated
