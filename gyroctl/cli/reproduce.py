"""`gyroctl reproduce`: the paper's numerical example, figure by figure, and the table of its statements."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import Scheduler


def reproduce(
    figures: Annotated[
        list[str] | None, typer.Argument(help="fig8 ... fig15, hinge_damping, choices, statements, or all.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for pictures and data.")] = Path("results/paper"),
    scheduler: Scheduler = "",
) -> None:
    """Reproduce the paper's figures and set its statements beside ours."""
    from gyroctl.studies.paper import reproduce as run

    for path in run(figures or ["all"], out, scheduler=scheduler or None):
        typer.echo(str(path))
