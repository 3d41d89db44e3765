"""`gyroctl margins`: margin report of constant controls or a law; `gyroctl lockmap`: where lock exists."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import Device, Parameters, Scheduler, Variant, answer, at_model_size, failures, parse, plant_of

CC = typer.Option(help="Magnetic coupling [Nms]; a law starts from it.")
CG = typer.Option(help="Generator gain [Nms]; a law starts from it.")
HEIGHT = typer.Option(help="Height of the regular wave [m]; a sea of Hs has equal energy at Hs/1.414.")
WP = typer.Option(help="Frequency of the wave [rad/s].")
Choices = Annotated[
    list[str] | None, typer.Option("--plant", help="Choice of the plant, key=value, e.g. drag=0.5; may repeat.")
]
WATER = typer.Option("--water", help="Also what each choice beyond the linear model moves.")
SENSE = typer.Option(help="Sense of rotation of the ring: 1 or -1.")


def margins(
    cc: Annotated[float, CC] = 0.052,
    cg: Annotated[float, CG] = 3.5e-4,
    height: Annotated[float, HEIGHT] = 0.2,
    wp: Annotated[float, WP] = 3.14,
    law: Annotated[str, typer.Option(help='A law: registered name, or "file.py:Name".')] = "",
    settings: Parameters = None,
    out: Annotated[Path, typer.Option(help="Folder for margins.json and the figures.")] = Path("results/margins"),
    samples: Annotated[int, typer.Option(help="Random disturbances per size.")] = 128,
    maps: Annotated[bool, typer.Option(help="Also the maps over controls and waves.")] = True,
    water: Annotated[
        bool, typer.Option("--water", help="Also what each choice beyond the linear model moves.")
    ] = False,
    choices: Choices = None,
    sense: Annotated[int, SENSE] = 1,
    variant: Variant = "corrected",
    scheduler: Scheduler = "",
    device: Device = None,
) -> None:
    """Measure how far a lock is from breaking; in a pipe the numbers come as JSON."""
    from gyroctl.studies.margins import margin_report, request

    plant = at_model_size(plant_of(device, variant, parse(choices or [], "--plant")), "the margin study")
    asked = request(plant, height, wp, cc, cg, sense, law, parse(settings or []), device is not None)
    content = margin_report(asked, out, samples, maps, water=water, scheduler=scheduler or None)
    said = [f"{name.replace('_', ' ')}: {text}" for name, text in content["meaning"].items()]
    answer(content, [*said, f"Numbers and figures: {out}"])
    failures(content["failed"])


def lockmap(
    axes: Annotated[str, typer.Option(help="cc,cg or wp,height.")] = "cc,cg",
    cc: Annotated[float, CC] = 0.052,
    cg: Annotated[float, CG] = 3.5e-4,
    height: Annotated[float, HEIGHT] = 0.2,
    wp: Annotated[float, WP] = 3.14,
    out: Annotated[Path, typer.Option(help="Folder for lockmap.json and lockmap.png.")] = Path("results/lockmap"),
    choices: Choices = None,
    sense: Annotated[int, SENSE] = 1,
    variant: Variant = "corrected",
    device: Device = None,
) -> None:
    """Map where lock exists and is stable; in a pipe the numbers come as JSON."""
    from gyroctl.errors import InputError
    from gyroctl.studies.margins import lock_map_report, request

    names = [name.strip() for name in axes.split(",")]
    if len(names) != 2:
        raise InputError("axes", axes, "must be two names with a comma between", "Give cc,cg or wp,height")
    plant = at_model_size(plant_of(device, variant, parse(choices or [], "--plant")), "the lock map")
    asked = request(plant, height, wp, cc, cg, sense)
    content = lock_map_report(asked, (names[0], names[1]), out)
    border = [value for value in content["map"]["border"] if value is not None]
    said = f"fold at {names[1]} = {min(border):.4g} to {max(border):.4g}" if border else "no fold within the map"
    answer(content, [said, f"Numbers and figures: {out}"])
