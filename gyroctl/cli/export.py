"""`gyroctl export`: the tables of a folder of results as CSV for spreadsheets."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import Form, answer


def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder that --out named.")],
    out: Annotated[Path | None, typer.Option(help="Where to write; by default DIR/csv.", show_default=False)] = None,
    form: Annotated[str, typer.Option("--format", help="csv.")] = "csv",
    bom: Annotated[
        bool, typer.Option("--bom", help="Begin with a mark of byte order, as some spreadsheets ask.")
    ] = False,
    words: Form = None,
) -> None:
    """Write results as CSV: units in the headings, numbers to the last bit, no formulas."""
    from gyroctl.errors import InputError
    from gyroctl.reports.export import export as write

    if form != "csv":
        raise InputError("--format", form, "is not written", "Give csv")
    written = write(folder, out, bom)
    answer({"files": [str(path) for path in written]}, [str(path) for path in written], words)
