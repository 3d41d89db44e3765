"""Tables as markdown: what is written of a law in a case, and in which form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gyroctl.names import in_table
from gyroctl.reports.wording import interval, number, percent, sees, watts
from gyroctl.statistics import Estimate
from gyroctl.statistics.means import SCATTERED, UNTOLD
from gyroctl.studies.evaluation.rows import Row

LOCK = ("locked", "P(lock)", "in step", "turns kept", "slips /1000")
PHI = "φ1, φ3 98 % [rad]"
OUTSIDE = ("largest [rad]", "beyond 0.3 rad")
PARTS = ("generated, stored [W]",)
MEASURED = (*PARTS, "CV", *LOCK, PHI, "runs over it", *OUTSIDE)
COST = ("slip loss [W]", "saturated", "step [ms]", "fallbacks", "late")
"""Headings of columns, see `cells`."""

MARKS = {"†": SCATTERED, "‡": UNTOLD}
"""What would make a column too wide to be read: a mark in the cell, and once below the table."""


def cells(row: Row) -> dict[str, str]:
    """Write a row, each number under the heading of its column."""
    return {
        "law": row.law,
        "sees": sees(row.information, row.preview),
        "power [W]": with_interval(row.power),
        "of best constant": with_interval(row.ratio),
        "less best constant [W]": with_interval(row.difference),
        "generated, stored [W]": f"{number(row.generated_w)}, {watts(row.stored_w)}",
        "CV": number(row.cv.value, 2),
        "locked": f"{row.locked}/{row.runs}",
        "P(lock)": f"{row.lock.low:.3f}–{row.lock.high:.3f}{f' ({row.lock.note})' if row.lock.note else ''}",
        "in step": f"{row.in_step}/{row.runs}",
        "turns kept": number(row.turns_kept),
        PHI: f"{number(row.phi1_p98, 2)}, {number(row.phi3_p98, 2)}",
        "runs over it": str(row.over_limit),
        "largest [rad]": f"{number(row.phi1_max, 2)}, {number(row.phi3_max, 2)}",
        "beyond 0.3 rad": percent(100.0 * row.outside_share),
        "slips /1000": number(row.cycle_slips, 2),
        "slip loss [W]": number(row.slip_loss_w, 2),
        "saturated": number(row.saturations, 2),
        "step [ms]": f"{_time(row.step_ms_median)}, {_time(row.step_ms_p99)}",
        "fallbacks": str(row.fallbacks),
        "late": str(row.deadline_misses),
    }


def row_table(headings: Sequence[str], lines: Sequence[Mapping[str, str]], text: int = 1) -> str:
    """Write the cells under these headings, see `markdown_table`."""
    return markdown_table(headings, [[line[heading] for heading in headings] for line in lines], text)


def markdown_table(headings: Sequence[str], lines: Sequence[Sequence[str]], text: int = 1) -> str:
    """Write a table; the first `text` columns and the last one are aligned to the left. Marks are told below it."""
    marks = ["---" if i < text or i == len(headings) - 1 else "---:" for i in range(len(headings))]
    table = "\n".join("| " + " | ".join(map(in_table, cells)) + " |" for cells in (headings, marks, *lines))
    told = (f"{mark} {words}." for mark, words in MARKS.items() if any(mark in cell for line in lines for cell in line))
    return "\n\n".join((table, *told))


def with_interval(estimate: Estimate, digits: int = 3) -> str:
    """Write a number with its interval in brackets, and what that leaves out: in the brackets, or by a mark."""
    missing = _missing(estimate)
    words = [part for part in missing if part not in MARKS.values()]
    marks = "".join(mark for mark, note in MARKS.items() if note in missing)
    inside = "; ".join(part for part in (interval(estimate, digits), *words) if part)
    return number(estimate.value, digits) + (f" ({inside})" if inside else "") + marks


def _missing(estimate: Estimate) -> list[str]:
    """What of the note a table must not be without: runs that the mean leaves out, scatter that it may not hold."""
    words = ("not finite", "scatter", "told from zero")
    return [part for part in estimate.note.split("; ") if any(word in part for word in words)]


def _time(milliseconds: float) -> str:
    return "< 0.01" if milliseconds < 0.01 else number(milliseconds, 2)
