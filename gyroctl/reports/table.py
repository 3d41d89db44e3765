"""The tables that the command line prints after a comparison: one row a law."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from gyroctl.errors import visible
from gyroctl.reports.evaluation import Evaluation, LawResult, evaluate
from gyroctl.reports.verdict import judge, shown
from gyroctl.reports.wording import NOTHING, interval, minutes, minutes_interval, number, percent, sees, watts

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Console
    from rich.table import Table

WIDE = 110
"""Terminal width from which intervals are shown beside the numbers. [columns]"""

ROOMY = 90
"""Terminal width from which two blanks part the columns. [columns]"""


def results_table(ds: xr.Dataset, evaluation: Evaluation | None = None, *, intervals: bool = True) -> Table:
    """Rich table of a comparison, most power first, the winner of the verdict in bold.

    Parameters
    ----------
    ds : xarray.Dataset
        Comparison in the layout of results.nc.
    evaluation : Evaluation, optional
        Its statistics, where they have been worked out already.
    intervals : bool
        Whether to give the 95 % intervals of power and ratio.

    Returns
    -------
    rich.table.Table
        Runs that failed, where any did; judged power [W] and the stored part of it [W], ratio to best_constant [1],
        power CV [1], runs locked, runs in step, turns kept [1], cycle slips per 1000 waves, what it sees and how far
        ahead [s].
    """
    from rich.markup import escape

    found = evaluate(ds) if evaluation is None else evaluation
    headings = (
        "power\nW",
        "stored\nW",
        "ratio\n1",
        "CV\n1",
        "locked\nruns",
        "in step\nruns",
        "turns\n1",
        "slips\n/1000",
    )
    winner = judge(found).winner
    any_failed = any(law.failures for law in found.laws)
    table = _table(("failed\nruns", *headings) if any_failed else headings)
    table.add_column("sees", no_wrap=True)
    for law in found.by_power:
        table.add_row(
            _name(law, winner),
            *([f"[red]{law.failed}/{law.runs}[/red]" if law.failures else f"0/{law.runs}"] if any_failed else []),
            _with(number(law.power.value), interval(law.power), intervals),
            watts(law.stored_w),
            _with(number(law.ratio.value), interval(law.ratio) if law.name != found.reference else "", intervals),
            number(law.power_cv.value, 2),
            _count(law.locked, law.runs),
            _count(law.in_step, law.runs),
            number(law.turns_kept),
            number(law.cycle_slips, 2),
            escape(sees(law.information, law.preview)),
            style="bold" if law.name == winner else None,
        )
    return table


def motion_table(ds: xr.Dataset, evaluation: Evaluation | None = None) -> Table:
    """Rich table of what else a comparison says of each law, in the same order.

    Parameters
    ----------
    ds : xarray.Dataset
        Comparison in the layout of results.nc.
    evaluation : Evaluation, optional
        Its statistics, where they have been worked out already.

    Returns
    -------
    rich.table.Table
        Generated power [W], mean time to lose lock [min], 98 % of |phi1| and |phi3| (red beyond the limit) and the
        largest of any run [rad], runs beyond the limit, share of the time beyond 0.3 rad.
    """
    found = evaluate(ds) if evaluation is None else evaluation
    winner = judge(found).winner
    table = _table(("generated\nW", "MTLL\nmin", "motion\nrad", "largest\nrad", "over limit\nruns", "> 0.3 rad\ntime"))
    for law in found.by_power:
        table.add_row(
            _name(law, winner),
            number(law.generated_w),
            minutes(law.mttl.value) if law.mttl.value == law.mttl.value else minutes_interval(law.mttl),
            _motion(law, found.motion_limit),
            f"{number(law.phi1_max, 2)}/{number(law.phi3_max, 2)}",
            f"{law.over_limit}/{law.runs}",
            percent(100.0 * law.outside_share) or NOTHING,
            style="bold" if law.name == winner else None,
        )
    return table


def print_table(ds: xr.Dataset, evaluation: Evaluation | None = None, console: Console | None = None) -> None:
    """Print the tables, the verdict and its caveats; intervals only where the terminal is wide enough.

    Parameters
    ----------
    ds : xarray.Dataset
        Comparison in the layout of results.nc.
    evaluation : Evaluation, optional
        Its statistics, where they have been worked out already.
    console : rich.console.Console, optional
        Where to print, standard output by default.
    """
    from rich.console import Console
    from rich.text import Text

    out = Console() if console is None else console
    found = evaluate(ds) if evaluation is None else evaluation
    verdict = judge(found)
    if found.plant:
        out.print(Text(visible(f"Device: {found.plant}")))
    few = replace(found, laws=shown(found))
    for table in (results_table(ds, few, intervals=out.width >= WIDE), motion_table(ds, few)):
        if out.width < ROOMY:  # a number that is cut is another number
            table.padding = (0, 0, 0, 0)
        out.print(table)
    if len(few.laws) < len(found.laws):
        out.print(Text(f"{len(few.laws)} of {len(found.laws)} laws; all of them in report.html and summary.json"))
    out.print(Text(visible(" ".join(verdict.sentences))))
    for caveat in verdict.caveats:
        out.print(Text(visible(f"! {caveat}"), style="yellow"))


def _table(headings: tuple[str, ...]) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("law", overflow="fold")  # of all columns a name alone may go over two lines
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def _name(law: LawResult, winner: str | None) -> str:
    from rich.markup import escape

    return f"{'*' if law.name == winner else ' '} {escape(law.name)}"


def _count(count: int | None, runs: int) -> str:
    if count is None:
        return NOTHING
    return f"[red]{count}/{runs}[/red]" if count == 0 else f"{count}/{runs}"


def _with(value: str, bounds: str, intervals: bool) -> str:
    return f"{value} [dim]{bounds.replace(' to ', '..')}[/dim]" if intervals and bounds else value


def _motion(law: LawResult, limit: float) -> str:
    parts = [f"[red]{number(v, 2)}[/red]" if v > limit else number(v, 2) for v in (law.phi1_p98, law.phi3_p98)]
    return "/".join(parts)
