"""Devices that differ from the design: what the laws meet when the model, the calibration or the sensors are wrong.

The laws stay as they are and plan with the nominal model. Every truth is built anew, the nominal one too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from gyroctl.devices import zhang2017
from gyroctl.harness.run import Settings
from gyroctl.harness.sensing import Sensors
from gyroctl.hydrodynamics import ExcitationTable
from gyroctl.plant import Plant
from gyroctl.plant.measurement import CHANNELS
from gyroctl.waves import Sea

NOMINAL = "nominal"

OFF = 0.2
"""By which part a constant differs. [1]"""

NOISE = 0.05
"""Sensor noise as a part of the channel's rms. [1]"""

LAGS = (0.02, 0.05, 0.1)
"""Time constants of a coupling that lags. [s]"""

RATE = 1.0
"""Largest rate of change of a coupling that is slow: a third of its range in a sample. [Nms/s]"""

TYPICAL_RMS = {
    "psi": math.pi / math.sqrt(3.0),
    "psi_rate": 3.1,
    "omega_rate": 69.0,
    "phi1": 0.12,
    "phi3": 0.096,
    "phi1_rate": 0.27,
    "phi3_rate": 0.34,
}
"""Of each channel, in lock at gamma 5: means of the best constant pair, load_angle and coupling on seed 100000. The
angle of the ring is uniform within a turn. [rad, rad/s]"""


class Truth(NamedTuple):
    """A device as it is simulated."""

    name: str  # what differs
    plant: Plant
    settings: Settings  # sensors and actuators
    sea: Sea | None = None  # where it is not that of the table
    told: Mapping[str, Any] = {}  # parameters that a law is given which has them


def truths(settings: Settings | None = None) -> tuple[Truth, ...]:
    """Every truth, the nominal one first.

    Parameters
    ----------
    settings : Settings, optional
        Those of the nominal case.
    """
    given = settings or Settings()
    devices = {NOMINAL: zhang2017()}
    for name in ("k1", "d1", "J14"):
        for sign in (-1, 1):
            base = zhang2017()
            changed = {name: (1.0 + sign * OFF) * getattr(base.parameters, name)}
            devices[_named(name, sign)] = base.replace(**changed)
    for sign in (-1, 1):
        devices[_named("He", sign)] = scaled_excitation(zhang2017(), 1.0 + sign * OFF)
    equipped = {
        _named("cc given", sign): _actuated(given, cc_gain=(1.0 + sign * OFF) * given.actuators.cc_gain)
        for sign in (-1, 1)
    }
    equipped |= {f"cc lag {1e3 * lag:.0f} ms": _actuated(given, cc_lag=lag) for lag in LAGS}
    equipped[f"cc rate {RATE:g} Nms/s"] = _actuated(given, cc_rate=RATE)
    equipped["one sample late"] = _actuated(given, delay=given.actuators.delay + 1)
    equipped["two samples late"] = _actuated(given, delay=given.actuators.delay + 2)
    equipped["5 % sensor noise"] = replace(given, sensors=noisy_sensors(given.sensors))
    known = {"delay": given.actuators.delay + 1}
    return (
        *(Truth(name, plant, given) for name, plant in devices.items()),
        *(Truth(name, zhang2017(), changed) for name, changed in equipped.items()),
        Truth("one sample late, told", zhang2017(), equipped["one sample late"], told=known),
        Truth("finer radiation", zhang2017(radiation="fine"), given),
    )


def scaled_excitation(plant: Plant, factor: float) -> Plant:
    """Give the device waves that push `factor` times as hard, in the same phase."""
    table = plant.excitation
    if not isinstance(table, ExcitationTable):
        raise TypeError(f"no table of moments to scale: {type(table).__name__}")
    return plant.replace(excitation=replace(table, values=factor * table.values))


def noisy_sensors(sensors: Sensors, part: float = NOISE) -> Sensors:
    """White noise of that part of the typical rms on every channel, instead of what it has."""
    changes = {name: replace(getattr(sensors, name), noise=part * TYPICAL_RMS[name]) for name in CHANNELS}
    return replace(sensors, **changes)


def _actuated(settings: Settings, **changes: Any) -> Settings:
    return replace(settings, actuators=replace(settings.actuators, **changes))


def _named(quantity: str, sign: int) -> str:
    return f"{quantity} {'+' if sign > 0 else '-'}{100 * OFF:.0f} %"
