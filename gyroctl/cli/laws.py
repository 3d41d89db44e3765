"""`gyroctl laws`: what is registered; `gyroctl laws check`: whether a law keeps the protocol."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyroctl.cli.options import MARKUP, Device, plant_of

if TYPE_CHECKING:
    from gyroctl.harness.law_trials import Check
    from gyroctl.plant import Plant

LONGEST = 1800.0
"""What the check of one law may take. [s]"""

app = typer.Typer(help="List the registered laws; check a law.", invoke_without_command=True, rich_markup_mode=MARKUP)


@app.callback()
def laws(context: typer.Context, device: Device = None) -> None:
    """List the registered laws with their shipped tuning."""
    if context.invoked_subcommand is not None:
        return
    from rich.console import Console
    from rich.table import Table

    from gyroctl.harness.device_sets import foreign
    from gyroctl.harness.protocol import Sensing
    from gyroctl.harness.registry import describe, law, registered

    table = Table("law", "looks at", "reads", "period [s]", "parameters (shipped tuning)", "what it does")
    for name in registered():
        built = law(name)
        parameters = ", ".join(f"{key} {_short(value)}" for key, value in describe(built).items() if key != "period")
        summary = (type(built).__doc__ or "").strip().splitlines()[0]
        reads = ", ".join(built.sensors) if isinstance(built, Sensing) else ""
        table.add_row(name, built.information, reads, f"{built.period:g}", parameters, summary)
    Console().print(table)
    if device is not None:
        strange = foreign({name: name for name in registered()}, plant_of(device, "corrected"), device)
        for name in strange:
            typer.echo(f"{name}: its tuned sets belong to another device than {device.name}")
        if strange:
            typer.echo(f"Sets for this one: gyroctl tune all --device {device.name}")


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
    from multiprocessing import get_context

    from pebble import ProcessExpired, ProcessPool

    from gyroctl.comparison.processes import no_way_out
    from gyroctl.engine.parent import end_with_parent
    from gyroctl.harness.law_trials import Check

    with ProcessPool(1, context=get_context("spawn"), initializer=end_with_parent) as pool:
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


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
