"""Start from rest and re-lock after a forced loss: how often, how fast, and when the energy is paid back.

``python -m gyroctl.studies.startup --seeds 100000:100100 --out DIR`` makes the table and the figure.
"""

from gyroctl.studies.startup.fault import Fault, StuckGenerator, stuck
from gyroctl.studies.startup.report import startup_report
from gyroctl.studies.startup.runs import Case, Ensemble, lost_runs, rest_runs

__all__ = ["Case", "Ensemble", "Fault", "StuckGenerator", "lost_runs", "rest_runs", "startup_report", "stuck"]
