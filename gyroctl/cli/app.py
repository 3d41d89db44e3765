"""Commands and how errors reach the user: one line on stderr, exit code 2, nothing half-written."""

from __future__ import annotations

import sys

import typer

from gyroctl.cli import bound, compare, evaluate, hydro, laws, margins, reproduce, simulate, tune

app = typer.Typer(
    help="Semi-active control, lock and stability margins of a gyroscopic wave energy converter.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("compare")(compare.compare)
app.command("report")(compare.report)
app.command("simulate")(simulate.simulate)
app.command("tune")(tune.tune)
app.command("evaluate")(evaluate.evaluate)
app.command("reproduce")(reproduce.reproduce)
app.command("margins")(margins.margins)
app.command("lockmap")(margins.lockmap)
app.command("bound")(bound.bound)
app.add_typer(laws.app, name="laws")
app.add_typer(hydro.app, name="hydro")


def main() -> None:
    """Run the command line; bad input ends with exit code 2 and a message that says what to do."""
    from gyroctl.errors import InputError

    try:
        app()
    except InputError as error:
        sys.exit(_refuse(str(error)))
    except ValueError as error:
        if type(error).__name__ != "LawError":  # a bug: let it be seen
            raise
        sys.exit(_refuse(str(error)))
    except (KeyboardInterrupt, SystemExit) as end:  # typer turns Ctrl-C into an exit with code 130
        if isinstance(end, SystemExit) and end.code != 130:
            raise
        print("Stopped. Finished runs are kept and will not be computed again.", file=sys.stderr)
        sys.exit(130)


def _refuse(message: str) -> int:
    print(f"Error: {message}", file=sys.stderr)
    return 2
