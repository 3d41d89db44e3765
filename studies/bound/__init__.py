"""The upper bound: what perfect foresight could harvest from a window of waves, and what part of it the laws reach."""

from gyroctl.studies.bound.cap import momentum_cap
from gyroctl.studies.bound.cut import Cut, cut
from gyroctl.studies.bound.report import bound_report, table
from gyroctl.studies.bound.search import Effort, Found, best_found, loosened, quick

__all__ = ["Cut", "Effort", "Found", "best_found", "bound_report", "cut", "loosened", "momentum_cap", "quick", "table"]
