"""Waves: from a sea and a seed to the excitation moments of the float.

A sea is a frozen value (`SeaState`, `DriftingSea`, `TabulatedSpectrum`, `Regular`, `Bichromatic`, `ElevationRecord`).
`realise` turns it and a seed into one `WaveRealisation`; `prepare` does once what is common to all seeds, and its
`Synthesis` gives the moments of many.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gyroctl.waves.blending import blend_signals, check_blend
from gyroctl.waves.components import Sea
from gyroctl.waves.drifting import DriftingSea
from gyroctl.waves.excitation import Excited, equivalent_amplitude, regular_amplitude
from gyroctl.waves.grid import BASE_PERIOD, OMEGA_MAX, TimeGrid, time_grid
from gyroctl.waves.phases import random_phases
from gyroctl.waves.realisation import WaveRealisation, moments_batch, realise
from gyroctl.waves.record import ElevationRecord, read_record
from gyroctl.waves.regular import Bichromatic, Regular
from gyroctl.waves.spectrum import SeaState
from gyroctl.waves.synthesis import Synthesis, prepare
from gyroctl.waves.tabulated import TabulatedSpectrum, read_spectrum

if TYPE_CHECKING:
    from gyroctl.waves.estimation import MomentEstimator, Predictor, Probe

_LAZY = ("MomentEstimator", "Predictor", "Probe")
"""These bring compiled code along, and are loaded when they are first used."""

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
    "WaveRealisation",
    "blend_signals",
    "check_blend",
    "equivalent_amplitude",
    "moments_batch",
    "prepare",
    "random_phases",
    "read_record",
    "read_spectrum",
    "realise",
    "regular_amplitude",
    "time_grid",
]


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'gyroctl.waves' has no attribute {name!r}")
    value = getattr(import_module("gyroctl.waves.estimation"), name)
    globals()[name] = value
    return value
