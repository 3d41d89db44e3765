from .blending import blend_signals, check_blend
from .components import Sea
from .drifting import DriftingSea
from .estimation import MomentEstimator, Predictor, Probe
from .excitation import Excited, equivalent_amplitude, regular_amplitude
from .grid import BASE_PERIOD, OMEGA_MAX, TimeGrid, time_grid
from .phases import random_phases
from .realisation import WaveRealisation, realise
from .record import ElevationRecord, read_record
from .regular import Bichromatic, Regular
from .spectrum import SeaState
from .synthesis import Synthesis, prepare
from .tabulated import TabulatedSpectrum, read_spectrum
from .turning import TurningSea
from .two_peaks import TwoPeaks

__all__ = [
    "BASE_PERIOD",
    "OMEGA_MAX",
    "Bichromatic",
    "DriftingSea",
    "ElevationRecord",
    "Excited",
    "MomentEstimator",
    "Predictor",
    "Probe",
    "Regular",
    "Sea",
    "SeaState",
    "Synthesis",
    "TabulatedSpectrum",
    "TimeGrid",
    "TurningSea",
    "TwoPeaks",
    "WaveRealisation",
    "blend_signals",
    "check_blend",
    "equivalent_amplitude",
    "prepare",
    "random_phases",
    "read_record",
    "read_spectrum",
    "realise",
    "regular_amplitude",
    "time_grid",
]
