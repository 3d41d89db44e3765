"""gyroctl: semi-active control, lock and stability margins of a gyroscopic wave energy converter.

The flow: sea -> waves -> plant -> law -> trajectory -> metrics -> report. Names are loaded when they are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from gyroctl.devices import zhang2017
    from gyroctl.errors import InputError
    from gyroctl.harness.actuation import Actuators
    from gyroctl.harness.comparison import compare
    from gyroctl.harness.controller import Law, LawError, Measurement
    from gyroctl.harness.laws import law
    from gyroctl.harness.run import Settings, simulate
    from gyroctl.harness.scan import scan
    from gyroctl.harness.sensing import Channel, Sensors
    from gyroctl.linearisation.orbit import PeriodicOrbit, lock_orbit
    from gyroctl.plant import Parameters, Plant, Radiation
    from gyroctl.waves import (
        Bichromatic,
        ElevationRecord,
        Regular,
        SeaState,
        TabulatedSpectrum,
        WaveRealisation,
        read_record,
        read_spectrum,
        realise,
    )

_HOME = {
    "InputError": "errors",
    "Actuators": "harness.actuation",
    "compare": "harness.comparison",
    "Law": "harness.controller",
    "LawError": "harness.controller",
    "Measurement": "harness.controller",
    "law": "harness.laws",
    "Settings": "harness.run",
    "simulate": "harness.run",
    "scan": "harness.scan",
    "Channel": "harness.sensing",
    "Sensors": "harness.sensing",
    "PeriodicOrbit": "linearisation.orbit",
    "lock_orbit": "linearisation.orbit",
    "Parameters": "plant",
    "Plant": "plant",
    "Radiation": "plant",
    "Bichromatic": "waves",
    "ElevationRecord": "waves",
    "Regular": "waves",
    "SeaState": "waves",
    "TabulatedSpectrum": "waves",
    "WaveRealisation": "waves",
    "read_record": "waves",
    "read_spectrum": "waves",
    "realise": "waves",
    "zhang2017": "devices",
}

__all__ = [
    "Actuators",
    "Bichromatic",
    "Channel",
    "ElevationRecord",
    "InputError",
    "Law",
    "LawError",
    "Measurement",
    "Parameters",
    "PeriodicOrbit",
    "Plant",
    "Radiation",
    "Regular",
    "SeaState",
    "Sensors",
    "Settings",
    "TabulatedSpectrum",
    "WaveRealisation",
    "__version__",
    "compare",
    "law",
    "lock_orbit",
    "read_record",
    "read_spectrum",
    "realise",
    "scan",
    "simulate",
    "zhang2017",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'gyroctl' has no attribute {name!r}")
    value = getattr(import_module(f"gyroctl.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
