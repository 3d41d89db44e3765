"""Tables as markdown and as JSON."""

from __future__ import annotations

from collections.abc import Sequence

from gyroctl.reports.wording import interval, number
from gyroctl.statistics import Estimate


def markdown_table(headings: Sequence[str], lines: Sequence[Sequence[str]], text: int = 1) -> str:
    """Write a table; the first `text` columns and the last one are aligned to the left."""
    marks = ["---" if i < text or i == len(headings) - 1 else "---:" for i in range(len(headings))]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (headings, marks, *lines))


def with_interval(estimate: Estimate, digits: int = 3) -> str:
    """Write a number with its interval in brackets."""
    bounds = interval(estimate, digits)
    return f"{number(estimate.value, digits)} ({bounds})" if bounds else number(estimate.value, digits)
