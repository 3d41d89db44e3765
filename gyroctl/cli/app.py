"""Commands and how errors reach the user: one line on stderr, exit code 2, nothing half-written."""

from __future__ import annotations

import sys
import warnings
from typing import Annotated

import typer

from gyroctl.cli import (
    bound,
    compare,
    device,
    evaluate,
    export,
    hydro,
    laws,
    margins,
    report,
    reproduce,
    simulate,
    site,
    stored,
    tune,
    waves,
)
from gyroctl.cli.options import MARKUP
from gyroctl.cli.stopping import CODE, end_soon_at_interrupt, stopped

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=MARKUP)
COMPARING = (compare.compare, report.report, simulate.simulate, waves.waves, tune.tune, evaluate.evaluate)
STUDYING = (reproduce.reproduce, margins.margins, margins.lockmap, bound.bound, site.site)
KEEPING = (stored.status, stored.verify, stored.clean, export.export)
for command in (*COMPARING, *STUDYING, *KEEPING):
    app.command(command.__name__)(command)
app.add_typer(laws.app, name="laws")
app.add_typer(hydro.app, name="hydro")
app.add_typer(device.app, name="device")

NO_THREAD = "can't start new thread"
"""How Python says that the system refused a thread, as it does where there is no memory for one."""


def _version(wanted: bool) -> None:
    if wanted:
        from gyroctl.provenance import commit
        from gyroctl.version import VERSION

        at = commit()
        typer.echo(f"gyroctl {VERSION}" + (f" ({at})" if at else ""))
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Semi-active control, lock and stability margins of a gyroscopic wave energy converter."""


def main() -> None:
    """Run the command line; bad input ends with exit code 2 and a message that says what to do."""
    from concurrent.futures import BrokenExecutor

    from gyroctl.errors import InputError, went_wrong

    warnings.filterwarnings("ignore", "every run of", UserWarning)  # commands say themselves what failed
    end_soon_at_interrupt()
    try:
        app()
    except ValueError as error:
        if not isinstance(error, InputError) and type(error).__name__ != "LawError":  # a bug: let it be seen
            raise
        print(f"Error: {error}", file=sys.stderr)
        sys.exit(2)
    except (OSError, MemoryError, BrokenExecutor, ImportError, RuntimeError) as error:
        if isinstance(error, RuntimeError) and not isinstance(error, BrokenExecutor) and NO_THREAD not in str(error):
            raise
        print(f"Error: {went_wrong(error)}", file=sys.stderr)
        sys.exit(1)
    except (KeyboardInterrupt, SystemExit) as end:  # typer turns Ctrl-C into an exit with code 130
        if isinstance(end, SystemExit) and end.code != CODE:
            raise
        stopped()
