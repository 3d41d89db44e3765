"""`gyroctl site`: what a scatter table of sea states gives in a year, with each law and the best constant pairs."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import AllowCode, Device, Form, Scheduler, Variant, Workers, answer, failures, plant_of


def site(
    scatter: Annotated[
        Path, typer.Argument(help="Scatter table, CSV: heights by periods, or lines hs, tp, occurrence.")
    ],
    laws: Annotated[
        str, typer.Option(help="Laws with commas between: coupling,nmpc[horizon=8].")
    ] = "coupling,load_angle",
    scale: Annotated[
        float, typer.Option(help="Length of the device at the site over that of the plant, by Froude.")
    ] = 1.0,
    depth: Annotated[
        float | None, typer.Option(help="Depth of the water at the site [m]. Default: that of the plant, scaled.")
    ] = None,
    gamma: Annotated[float, typer.Option(help="Peak enhancement of every sea state; 1 is Pierson-Moskowitz.")] = 1.0,
    period: Annotated[str, typer.Option(help="Tp, Te, T1 or Tz, where the table does not say.")] = "",
    occurrence: Annotated[
        str, typer.Option(help="hours, counts, percent or fraction, where the table does not say.")
    ] = "",
    bins: Annotated[str, typer.Option(help="What a heading is of its bin: centres, lower or upper.")] = "",
    layout: Annotated[str, typer.Option(help="matrix, matrix-by-period or list, where the table does not say.")] = "",
    seeds: Annotated[list[str] | None, typer.Option(help="Realisations, 1:16 by default. May repeat.")] = None,
    duration: Annotated[float, typer.Option(help="Length of the runs [s], at the plant's scale.")] = 600.0,
    budget: Annotated[
        float | None,
        typer.Option(help="Simulated time to find the best constant pair of a sea state [s], 4.5e5 by default."),
    ] = None,
    rarest: Annotated[float, typer.Option(help="Part of the year below which a sea state is not run but named.")] = 0.0,
    variant: Variant = "corrected",
    workers: Workers = 0,
    scheduler: Scheduler = "",
    out: Annotated[Path, typer.Option(help="Folder for JSON, CSV, picture, page and runs.")] = Path("results/site"),
    allow_tuning_seeds: Annotated[
        bool, typer.Option("--allow-tuning-seeds", help="To try things out: such a year judges nothing.")
    ] = False,
    allow_code: AllowCode = None,
    device: Device = None,
    words: Form = None,
) -> None:
    """Run laws in every sea state of a site: power and lock matrices, annual energy; in a pipe JSON."""
    from gyroctl.cli.first_time import say_first_time
    from gyroctl.harness.device_sets import foreign_note
    from gyroctl.studies.evaluation.entrants import parse
    from gyroctl.studies.site import read_scatter, site_report, site_request
    from gyroctl.studies.site.words import remarks, sentences, table

    say = partial(typer.echo, err=True)
    found = read_scatter(scatter, period, occurrence, bins, layout)
    say(f"{scatter.name}: {found.layout}, {len(found.bins)} sea states that occur, {found.kind}, in {found.told}")
    plant = plant_of(device, variant)
    ask = site_request(
        found,
        out,
        laws,
        plant=plant,
        device=device,
        table=scatter.name,
        scale=scale,
        depth=depth,
        gamma=gamma,
        seeds=seeds or ("1:16",),
        duration=duration,
        budget=budget,
        rarest=rarest,
        workers=workers,
        allow_tuning_seeds=allow_tuning_seeds,
        allow_code=allow_code or (),
        scheduler=scheduler or None,
        say=say,
    )
    if device is not None and ask.foreign:
        say(foreign_note(ask.foreign, {entrant.label: entrant.name for entrant in parse(laws)}, plant, device))
    say_first_time("plant and laws", 30)
    content = site_report(ask)
    lines = [*table(content), *sentences(content, ("kWh", 1.0)), *(f"! {remark}" for remark in remarks(content))]
    answer(content, [*lines, f"Page: {out / 'site.html'}"], words)
    failures(content["failed"])
