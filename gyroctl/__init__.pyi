from .comparison.compare import compare
from .devices import device, zhang2017
from .errors import InputError
from .harness.actuation import Actuators
from .harness.constant_pairs import scan
from .harness.law_check import check_law
from .harness.law_from import law_from
from .harness.laws import law
from .harness.protocol import Law, LawError, Measurement
from .harness.run import Settings, simulate
from .harness.sensing import Channel, Sensors
from .harness.yardstick import Yardstick
from .linearisation import PeriodicOrbit, lock_orbit
from .plant import Parameters, Plant, Radiation
from .studies.margins import margins
from .tuning.yardstick import find_yardstick
from .waves import (
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

__version__: str

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
    "Yardstick",
    "check_law",
    "compare",
    "device",
    "find_yardstick",
    "law",
    "law_from",
    "lock_orbit",
    "margins",
    "read_record",
    "read_spectrum",
    "realise",
    "scan",
    "simulate",
    "zhang2017",
]
