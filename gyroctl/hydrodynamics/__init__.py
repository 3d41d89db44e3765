"""Hydrodynamics of the float: database, excitation and passive radiation fits."""

from __future__ import annotations

from gyroctl.hydrodynamics.database import load, save, shipped
from gyroctl.hydrodynamics.excitation import ExcitationTable, excitation_table
from gyroctl.hydrodynamics.radiation import RadiationFit, fit_radiation, shipped_fit
from gyroctl.hydrodynamics.table import Hydrodynamics

__all__ = [
    "ExcitationTable",
    "Hydrodynamics",
    "RadiationFit",
    "excitation_table",
    "fit_radiation",
    "load",
    "save",
    "shipped",
    "shipped_fit",
]
