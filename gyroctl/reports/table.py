"""The table that the command line prints after a comparison: one row a law."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gyroctl.reports.evaluation import Evaluation, LawResult, evaluate
from gyroctl.reports.verdict import judge
from gyroctl.reports.wording import interval, minutes, minutes_interval, number, sees

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Console
    from rich.table import Table

WIDE = 110
"""Terminal width from which intervals are shown beside the numbers. [columns]"""


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
        Power [W], ratio to best_constant [1], power CV [1], locked runs, mean time to lose lock [min], cycle slips per
        1000 waves, 98 % of |phi1| and |phi3| [rad] (red beyond the limit), what it sees
        and how far ahead [s].
    """
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    found = evaluate(ds) if evaluation is None else evaluation
    winner = judge(found).winner
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    table.add_column("law", no_wrap=True)
    for heading in ("power\nW", "ratio\n1", "CV\n1", "locked\nruns", "MTLL\nmin", "slips\n/1000", "motion\nrad"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("sees", no_wrap=True)
    for law in found.by_power:
        table.add_row(
            f"{'*' if law.name == winner else ' '} {escape(law.name)}",
            _with(number(law.power.value), interval(law.power), intervals),
            _with(number(law.ratio.value), interval(law.ratio) if law.name != found.reference else "", intervals),
            number(law.power_cv.value, 2),
            f"[red]{law.locked}/{law.runs}[/red]" if law.locked == 0 else f"{law.locked}/{law.runs}",
            minutes(law.mttl.value) if law.mttl.value == law.mttl.value else minutes_interval(law.mttl),
            number(law.cycle_slips, 2),
            _motion(law, found.motion_limit),
            escape(sees(law.information, law.preview)),
            style="bold" if law.name == winner else None,
        )
    return table


def print_table(ds: xr.Dataset, evaluation: Evaluation | None = None, console: Console | None = None) -> None:
    """Print the table, the verdict and its caveats; intervals only where the terminal is wide enough.

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
    out.print(results_table(ds, found, intervals=out.width >= WIDE))
    out.print(Text(" ".join(verdict.sentences)))
    for caveat in verdict.caveats:
        out.print(Text(f"! {caveat}", style="yellow"))


def _with(value: str, bounds: str, intervals: bool) -> str:
    return f"{value} [dim]{bounds.replace(' to ', '..')}[/dim]" if intervals and bounds else value


def _motion(law: LawResult, limit: float) -> str:
    parts = [f"[red]{number(v, 2)}[/red]" if v > limit else number(v, 2) for v in (law.phi1_p98, law.phi3_p98)]
    return "/".join(parts)
