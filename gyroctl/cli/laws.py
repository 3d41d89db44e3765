"""`gyroctl laws`: what is registered, parameters of a law, whether it keeps the protocol."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyroctl.cli.options import MARKUP, Device, plant_of

if TYPE_CHECKING:
    from gyroctl.harness.law_trials import Check
    from gyroctl.harness.protocol import Law
    from gyroctl.plant import Plant

BLANK = "\n\n"
"""Between the summary of a docstring and what follows."""

LONGEST = 1800.0
"""What the check of one law may take. [s]"""

app = typer.Typer(
    help="List the registered laws; show or check a law.", invoke_without_command=True, rich_markup_mode=MARKUP
)


@app.callback()
def laws(context: typer.Context, device: Device = None) -> None:
    """List the registered laws; their parameters: `gyroctl laws show NAME`."""
    if context.invoked_subcommand is not None:
        return
    from gyroctl.harness.device_sets import foreign
    from gyroctl.harness.laws import law
    from gyroctl.harness.registry import registered

    rows = []
    for name in registered():
        built = law(name)
        rows.append((name, built.information, _clause(built)))
    _table(("law", "looks at", "what it does"), rows)
    typer.echo("Parameters with their units, sensors and tuned sets: gyroctl laws show NAME")
    if device is not None:
        strange = foreign({name: name for name in registered()}, plant_of(device, "corrected"), device)
        for name in strange:
            typer.echo(f"{name}: its tuned sets belong to another device than {device.name}")
        if strange:
            typer.echo(f"Sets for this one: gyroctl tune all --device {device.name}")


@app.command("show")
def show(
    name: Annotated[str, typer.Argument(help="A registered name, or FILE.py:NAME.")],
    tuning: Annotated[
        str | None,
        typer.Option(help="Values of this tuned set; else those that ship for all seas.", show_default=False),
    ] = None,
) -> None:
    """Tell a law: what it looks at and reads, its tuned sets, its parameters with values and units."""
    from gyroctl.harness.law_parameters import parameters_of
    from gyroctl.harness.laws import law
    from gyroctl.harness.protocol import Sensing
    from gyroctl.harness.registry import tuned_sets

    built = law(name, tuning)
    typer.echo(f"{name}: {' '.join((type(built).__doc__ or '').strip().partition(BLANK)[0].split())}")
    reads = "" if built.information == "none" or not isinstance(built, Sensing) else f": {', '.join(built.sensors)}"
    typer.echo(f"Looks at {built.information}{reads}; every {built.period:g} s")
    typer.echo(f"Tuned sets: {', '.join(tuned_sets(name)) or 'none'}")
    _table(("parameter", "value", "meaning [unit]"), parameters_of(name, built), shortened=False)


@app.command("check")
def check(
    name: Annotated[str, typer.Argument(help="FILE.py for all laws in it, FILE.py:NAME, or a registered name.")],
    runs: Annotated[int, typer.Option(min=2, max=1000, help="Realisations for the check of the integration step.")] = 8,
    device: Device = None,
) -> None:
    """Check whether a law keeps the protocol; exit code 2 where it does not."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from gyroctl.harness.law_check import laws_of

    plant, failed = plant_of(device, "corrected"), 0
    for each in laws_of(Path(name)) if name.endswith(".py") else [name]:
        table = Table("check", "", "found", title=each, title_justify="left", box=SIMPLE_HEAD)
        for line in _checked(each, plant, runs):
            failed += not line.passed
            found = line.found if line.passed else f"{line.found}. {line.mend}."
            table.add_row(line.name, "[green]pass[/]" if line.passed else "[bold red]FAIL[/]", escape(found))
        Console().print(table)
    if failed:
        typer.echo(f"{failed} check{'s' if failed > 1 else ''} failed", err=True)
        raise typer.Exit(2)


def _checked(name: str, plant: Plant, runs: int) -> list[Check]:
    """Check a law in a process of its own, which it may end or keep for ever."""
    from pebble import ProcessExpired, ProcessPool

    from gyroctl.comparison.processes import no_way_out
    from gyroctl.engine.apart import CONTEXT
    from gyroctl.engine.parent import end_with_parent
    from gyroctl.harness.law_trials import Check

    with ProcessPool(1, context=CONTEXT, initializer=end_with_parent) as pool:
        found = pool.schedule(no_way_out, args=(_check_shown, name, plant, runs), timeout=LONGEST)
        try:
            lines: list[Check] = found.result()
        except TimeoutError:
            lines = [Check("answers", False, f"has not ended within {LONGEST / 60.0:g} min", "Let step return at once")]
        except ProcessExpired as error:
            lines = [
                Check("stays", False, f"ends the process (exit code {error.exitcode})", "Return a command instead")
            ]
        except SystemExit:
            lines = [Check("stays", False, "ends the program", "A law must not exit: return a command instead")]
        except BaseException:
            pool.stop()
            raise
    return lines


def _check_shown(name: str, plant: Plant, runs: int) -> list[Check]:
    from gyroctl.harness.law_check import LINES, check_law
    from gyroctl.simulation.progress import Progress

    with Progress(f"check of {name.rpartition(':')[2]}", LINES) as progress:
        return check_law(name, plant, runs, progress.advance)


def _clause(built: Law) -> str:
    """First clause of what a law says of itself."""
    return re.split(r"[.;:](?:\s|$)", (type(built).__doc__ or "").strip(), maxsplit=1)[0]


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]], shortened: bool = True) -> None:
    """Print rows; of a last text too long for the window the end is left out, or goes on below."""
    from shutil import get_terminal_size
    from textwrap import shorten, wrap

    from gyroctl.errors import visible

    widths = [max(map(len, column)) for column in list(zip(head, *rows, strict=True))[:-1]]
    left = sum(widths) + 2 * len(widths)
    room = max(get_terminal_size().columns - left, 24)
    for row in (head, tuple("-" * width for width in (*widths, len(head[-1]))), *rows):
        last = [shorten(row[-1], room, placeholder="...")] if shortened else wrap(row[-1], room) or [""]
        first = "".join(f"{text:<{width}}  " for text, width in zip(row, widths, strict=False))
        for line in (first + last[0], *(" " * left + more for more in last[1:])):
            typer.echo(visible(line.rstrip()))
