"""Reports of a comparison: statistics, figures, the self-contained HTML page, summary.json and the terminal table.

Reports see datasets only, never a plant or a law, so that every page can be rebuilt from its NetCDF file.
"""

from __future__ import annotations

from gyroctl.reports.evaluation import Evaluation, LawResult, evaluate
from gyroctl.reports.layout import check_layout, open_results
from gyroctl.reports.picture import write_picture
from gyroctl.reports.report import write_report
from gyroctl.reports.summary import summarise
from gyroctl.reports.table import print_table, results_table
from gyroctl.reports.verdict import Verdict, judge

__all__ = [
    "Evaluation",
    "LawResult",
    "Verdict",
    "check_layout",
    "evaluate",
    "judge",
    "open_results",
    "print_table",
    "results_table",
    "summarise",
    "write_picture",
    "write_report",
]
