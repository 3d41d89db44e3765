"""Hydrodynamics of the float: database, excitation and passive radiation fits."""

from __future__ import annotations

from gyroctl.hydrodynamics.database import load, save, shipped
from gyroctl.hydrodynamics.excitation import ExcitationTable, excitation_table
from gyroctl.hydrodynamics.export import export_results
from gyroctl.hydrodynamics.import_report import ImportReport, import_report
from gyroctl.hydrodynamics.importers import Site, import_results
from gyroctl.hydrodynamics.radiation import RadiationFit, fit_radiation, shipped_fit
from gyroctl.hydrodynamics.table import Hydrodynamics

__all__ = [
    "ExcitationTable",
    "Hydrodynamics",
    "ImportReport",
    "RadiationFit",
    "Site",
    "excitation_table",
    "export_results",
    "fit_radiation",
    "import_report",
    "import_results",
    "load",
    "save",
    "shipped",
    "shipped_fit",
]
