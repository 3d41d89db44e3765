from .blending import blend_signals, check_blend
from .components import Sea
from .directional import DirectionalSpectrum, SpreadSea
from .drifting import DriftingSea
from .estimation import MomentEstimator, Predictor, Probe
from .excitation import Excited, equivalent_amplitude, regular_amplitude
from .grid import BASE_PERIOD, OMEGA_MAX, TimeGrid, time_grid
from .phases import random_phases
from .realisation import WaveRealisation, realise
from .record import ElevationRecord
from .record_files import read_record
from .regular import Bichromatic, Regular
from .spectrum import SeaState
from .spectrum_files import read_spectrum
from .synthesis import Synthesis, prepare
from .tabulated import TabulatedSpectrum
from .turning import TurningSea
from .two_peaks import TwoPeaks

__all__ = [
    "BASE_PERIOD",
    "OMEGA_MAX",
    "Bichromatic",
    "DirectionalSpectrum",
    "DriftingSea",
    "ElevationRecord",
    "Excited",
    "MomentEstimator",
    "Predictor",
    "Probe",
    "Regular",
    "Sea",
    "SeaState",
    "SpreadSea",
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
