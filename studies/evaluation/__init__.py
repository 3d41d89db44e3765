"""Fair tables of all laws: the three seas, off the design, the price of information, robustness.

Every run is a work item of `gyroctl.comparison.compare.compare` with its own stored result, so that a table that was
stopped goes on where it was, and a larger one computes only what is new.
"""

from gyroctl.studies.evaluation.report import TABLES, evaluate_tables
from gyroctl.studies.evaluation.request import Request, request

__all__ = ["TABLES", "Request", "evaluate_tables", "request"]
