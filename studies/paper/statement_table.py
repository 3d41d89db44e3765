"""The statement table as Markdown, JSON and on the terminal: the paper beside ours, for each preset."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from gyroctl.harness.seed_ledger import ledger
from gyroctl.provenance import made
from gyroctl.reports.wording import number
from gyroctl.studies.paper.ensembles import Setup
from gyroctl.studies.paper.statements import Finding
from gyroctl.studies.paper.verdicts import Result
from gyroctl.writing import plain

if TYPE_CHECKING:
    from rich.table import Table

HEADINGS = {"corrected": "corrected", "paper": "as printed"}  # of the variants
_COLOURS = {"agree": "green", "differ": "red", "open": "yellow"}
SHARE = "share that kept lock"


def cell(finding: Finding, result: Result) -> str:
    """Number with interval and unit."""
    share = finding.statement.measure.startswith(SHARE)
    factor, unit = (100.0, " %") if share else (1.0, f" {result.unit}" if result.unit else "")
    if math.isnan(result.value):
        return "none"
    text = number(factor * result.value, 3 if math.isfinite(result.low) else 4)
    if math.isfinite(result.low):
        text += f" ({number(factor * result.low)} to {number(factor * result.high)})"
    return text + unit


def tally(findings: Sequence[Finding]) -> dict[str, dict[str, int]]:
    """Count the verdicts of each variant."""
    verdicts: dict[str, list[str]] = {v: [f.results[v].verdict for f in findings] for v in findings[0].results}
    return {v: {verdict: said.count(verdict) for verdict in _COLOURS} for v, said in verdicts.items()}


def summary_line(findings: Sequence[Finding]) -> str:
    """How many statements agree, in words."""
    parts = []
    for variant, row in tally(findings).items():
        parts.append(f"{HEADINGS[variant]}: {', '.join(f'{count} {verdict}' for verdict, count in row.items())}")
    return "; ".join(parts)


def markdown(findings: Sequence[Finding], setup: Setup) -> str:
    """Table for a reader."""
    variants = list(findings[0].results)
    lines = [
        "# Statements of the paper beside ours",
        "",
        f"{len(setup.seeds)} realisations of {setup.duration:g} s for each case, where the paper has one; intervals "
        "are 95 %. A statement on one realisation agrees where its outcome is the likelier one (the interval of the "
        "share lies on its side of one half) or its number lies within the central 95 % of our realisations; open "
        "means that the interval does not decide, or that too few runs kept lock.",
        "",
        summary_line(findings) + ".",
    ]
    heads = ["the paper", "ours", *(part for v in variants for part in (HEADINGS[v], ""))]
    for group, members in groupby(findings, lambda finding: finding.statement.group):
        lines += ["", f"## {group}", "", _row(heads), _row(["---"] * len(heads))]
        for finding in members:
            cells = [part for result in finding.results.values() for part in (cell(finding, result), result.verdict)]
            lines.append(_row([finding.statement.says, finding.statement.measure, *cells]))
    lines += ["", "## Notes", ""]
    for finding in findings:
        told = {HEADINGS[v]: result.note for v, result in finding.results.items() if result.note}
        if told:
            joined = "; ".join(f"{name}: {note}" for name, note in told.items())
            same = len(set(told.values())) == 1 and len(told) == len(variants)
            lines.append(f"- {finding.statement.says}: {next(iter(told.values())) if same else joined}.")
    return "\n".join(lines) + "\n"


def as_json(findings: Sequence[Finding], setup: Setup) -> str:
    """Table for a program; a number that does not exist is null."""
    rows: list[dict[str, Any]] = []
    for finding in findings:
        s = finding.statement
        results = plain(finding.results)
        rows.append({"key": s.key, "group": s.group, "paper": s.says, "measure": s.measure, "results": results})
    head = {
        **made(),
        "seeds": list(setup.seeds),
        "seed_states": ledger().states(setup.seeds),
        "duration_s": setup.duration,
        "tally": tally(findings),
        "statements": rows,
    }
    return json.dumps(head, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def terminal(findings: Sequence[Finding], setup: Setup) -> Table:
    """Table for the terminal."""
    from rich.table import Table

    title = f"Statements of the paper, {len(setup.seeds)} realisations of {setup.duration:g} s, 95 % intervals"
    table = Table(title=title, title_justify="left", caption=summary_line(findings), caption_justify="left")
    table.add_column("the paper", max_width=38)
    table.add_column("ours", max_width=30)
    for variant in findings[0].results:
        table.add_column(HEADINGS[variant], justify="right")
        table.add_column("")
    for group, members in groupby(findings, lambda finding: finding.statement.group):
        table.add_section()
        table.add_row(f"[bold]{group}[/bold]")
        for finding in members:
            cells = []
            for result in finding.results.values():
                cells += [cell(finding, result), f"[{_COLOURS[result.verdict]}]{result.verdict}[/]"]
            table.add_row(finding.statement.says, finding.statement.measure, *cells)
    return table


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(text.replace("|", "\\|") for text in cells) + " |"
