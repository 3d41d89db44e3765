"""`gyroctl evaluate`: fair tables of all laws."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import AllowCode, Device, Scheduler, Workers, failures


def evaluate(
    tables: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[TABLE ...]",
            help="seas, offdesign, information, information_real, robustness, physics, price, faults, gauge, real; "
            "all without any.",
        ),
    ] = None,
    laws: Annotated[
        str,
        typer.Option(
            help="Laws with commas between: load_angle,nmpc[information=oracle]. Without it all, "
            "in physics and faults nmpc, coupling and load_angle, in real those and the other rules."
        ),
    ] = "",
    seeds: Annotated[
        list[str] | None,
        typer.Option(
            help="Realisations, 1:64 by default, in physics 1:16 and nmpc=1:8, in price 1:16, in faults, gauge, "
            "information_real and real 1:8; nmpc=1:16 for one law, '@gamma 5=1:8' in one case. May repeat."
        ),
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option(
            help="Length of the runs [s], 2000 by default, in physics and gauge 600, in price "
            "and information_real 500, in faults 400, in real 1000."
        ),
    ] = None,
    workers: Workers = 0,
    scheduler: Scheduler = "",
    out: Annotated[Path, typer.Option(help="Folder for tables, figures and runs.")] = Path("results/evaluation"),
    budget: Annotated[
        float | None,
        typer.Option(help="Simulated time to find the best constant pair of a sea [s], 4e6 by default, in real 4e5."),
    ] = None,
    planner: Annotated[str, typer.Option(help="Law whose information is varied.")] = "nmpc",
    allow_tuning_seeds: Annotated[
        bool, typer.Option("--allow-tuning-seeds", help="To try things out: such a table judges nothing.")
    ] = False,
    only: Annotated[
        str, typer.Option(help="Cases of seas and real, with commas between: 'gamma 1,gamma 5'. Without it all.")
    ] = "",
    allow_code: AllowCode = None,
    device: Device = None,
) -> None:
    """Judge laws on spent or reserve realisations: seas, off the design, information, devices, real water."""
    from gyroctl.errors import InputError
    from gyroctl.studies.evaluation import evaluate_tables, request

    if device is not None:
        problem = (
            "judges the laws on the paper's device and on what differs from it: its cases, targets and pairs are so"
        )
        mend = f'Compare them on yours: [plant] device = "{device.name}" in an experiment file, gyroctl compare'
        raise InputError("--device", device.name, problem, mend)
    chosen, say = seeds or (), partial(typer.echo, err=True)
    allowed = allow_code or ()
    asked = request(
        out,
        laws,
        chosen,
        duration,
        workers,
        allow_tuning_seeds,
        budget,
        planner,
        say=say,
        allow_code=allowed,
        only=only,
    )
    asked = replace(asked, scheduler=scheduler or None)
    made = evaluate_tables(tables or (), asked)
    for name in made:
        typer.echo((out / f"{name}.md").read_text(encoding="utf-8"))
    typer.echo(f"Written to {out}", err=True)
    failures({f"{name}, {what}": why for name, table in made.items() for what, why in table["failed"].items()})
