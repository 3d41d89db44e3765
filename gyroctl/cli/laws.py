"""`gyroctl laws`: what is registered; `gyroctl laws check`: whether a law keeps the protocol."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import MARKUP

app = typer.Typer(help="List the registered laws; check a law.", invoke_without_command=True, rich_markup_mode=MARKUP)


@app.callback()
def laws(context: typer.Context) -> None:
    """List the registered laws with their shipped tuning."""
    if context.invoked_subcommand is not None:
        return
    from rich.console import Console
    from rich.table import Table

    from gyroctl.harness.registry import describe, law, registered

    table = Table("law", "looks at", "period [s]", "parameters (shipped tuning)", "what it does")
    for name in registered():
        built = law(name)
        parameters = ", ".join(f"{key} {_short(value)}" for key, value in describe(built).items() if key != "period")
        summary = (type(built).__doc__ or "").strip().splitlines()[0]
        table.add_row(name, built.information, f"{built.period:g}", parameters, summary)
    Console().print(table)


@app.command("check")
def check(
    name: Annotated[str, typer.Argument(help="FILE.py for all laws in it, FILE.py:NAME, or a registered name.")],
    runs: Annotated[int, typer.Option(min=2, max=1000, help="Realisations for the check of the integration step.")] = 8,
) -> None:
    """Check whether a law keeps the protocol; exit code 2 where it does not."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from gyroctl.devices import zhang2017
    from gyroctl.harness.law_check import LINES, check_law, laws_of
    from gyroctl.simulation.progress import Progress

    plant, failed = zhang2017(), 0
    for each in laws_of(Path(name)) if name.endswith(".py") else [name]:
        table = Table("check", "", "found", title=each, title_justify="left", box=SIMPLE_HEAD)
        with Progress(f"check of {each.rpartition(':')[2]}", LINES) as progress:
            checks = check_law(each, plant, runs, progress.advance)
        for line in checks:
            failed += not line.passed
            found = line.found if line.passed else f"{line.found}. {line.mend}."
            table.add_row(line.name, "[green]pass[/]" if line.passed else "[bold red]FAIL[/]", escape(found))
        Console().print(table)
    if failed:
        typer.echo(f"{failed} check{'s' if failed > 1 else ''} failed", err=True)
        raise typer.Exit(2)


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
