"""`gyroctl margins`: margin report of constant controls or a law; `gyroctl lockmap`: where lock exists."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gyroctl.cli.options import (
    Device,
    Form,
    Parameters,
    Scheduler,
    SeaFile,
    Variant,
    answer,
    failures,
    own,
    parse,
    plant_of,
    sea_of,
)

if TYPE_CHECKING:
    from gyroctl.plant import Plant
    from gyroctl.waves import Regular, Sea

AT = "at the size of Table 1"
CC = typer.Option(help="Magnetic coupling [Nms]; a law starts from it.", show_default=f"0.052 {AT}")
CG = typer.Option(help="Generator gain [Nms]; a law starts from it.", show_default=f"0.00035 {AT}")
HEIGHT = typer.Option(
    help="Height of the regular wave [m]; a sea of Hs has equal energy at Hs/1.414.",
    show_default="0.2 times the length",
)
WP = typer.Option(help="Frequency of the wave [rad/s].", show_default=f"3.14 {AT}")
Choices = Annotated[
    list[str] | None, typer.Option("--plant", help="Choice of the plant, key=value, e.g. drag=0.5; may repeat.")
]
WATER = typer.Option("--water", help="Also what each choice beyond the linear model moves.")
SENSE = typer.Option(help="Sense of rotation of the ring: 1 or -1.")


def margins(
    cc: Annotated[float | None, CC] = None,
    cg: Annotated[float | None, CG] = None,
    height: Annotated[float | None, HEIGHT] = None,
    wp: Annotated[float | None, WP] = None,
    sea: SeaFile = None,
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
    words: Form = None,
) -> None:
    """Measure how far a lock is from breaking; in a pipe the numbers come as JSON."""
    from gyroctl.harness.device_sets import own_choice
    from gyroctl.harness.plausibility import check_parts
    from gyroctl.studies.margins import margin_report, request

    plant = plant_of(device, variant, parse(choices or [], "--plant"))
    wave, told = _wave(plant, sea, height, wp)
    controls, parameters, heading = _pair(plant, cc, cg), parse(settings or []), wave.heading
    check_parts(law, parameters)
    if device is not None and law:
        parameters = own_choice(device, law, plant, parameters)
    asked = request(plant, wave.height, wave.wp, *controls, sense, law, parameters, device is not None, heading)
    content = margin_report(asked, out, samples, maps, water=water, scheduler=scheduler or None, sea=told)
    said = [f"{name.replace('_', ' ')}: {text}" for name, text in content["meaning"].items()]
    answer(content, [*_of_sea(content), f"In a {asked.sea}:", *said, f"Numbers and figures: {out}"], words)
    failures(content["failed"])


def lockmap(
    axes: Annotated[str, typer.Option(help="cc,cg or wp,height.")] = "cc,cg",
    cc: Annotated[float | None, CC] = None,
    cg: Annotated[float | None, CG] = None,
    height: Annotated[float | None, HEIGHT] = None,
    wp: Annotated[float | None, WP] = None,
    sea: SeaFile = None,
    out: Annotated[Path, typer.Option(help="Folder for lockmap.json and lockmap.png.")] = Path("results/lockmap"),
    choices: Choices = None,
    sense: Annotated[int, SENSE] = 1,
    variant: Variant = "corrected",
    device: Device = None,
    words: Form = None,
) -> None:
    """Map where lock exists and is stable; in a pipe the numbers come as JSON."""
    from gyroctl.errors import InputError
    from gyroctl.studies.margins import lock_map_report, request

    names = [name.strip() for name in axes.split(",")]
    if len(names) != 2:
        raise InputError("axes", axes, "must be two names with a comma between", "Give cc,cg or wp,height")
    plant = plant_of(device, variant, parse(choices or [], "--plant"))
    wave, told = _wave(plant, sea, height, wp)
    asked = request(plant, wave.height, wave.wp, *_pair(plant, cc, cg), sense, heading=wave.heading)
    content = lock_map_report(asked, (names[0], names[1]), out, sea=told)
    border = [value for value in content["map"]["border"] if value is not None]
    said = f"fold at {names[1]} = {min(border):.4g} to {max(border):.4g}" if border else "no fold within the map"
    answer(content, [*_of_sea(content), said, f"Numbers and figures: {out}"], words)


def _wave(plant: Plant, sea: Path | None, height: float | None, wp: float | None) -> tuple[Regular, Sea | None]:
    """Regular wave of these numbers, or that of a sea with the sea: what is left out is of the device's length."""
    from gyroctl.errors import InputError
    from gyroctl.harness.start import equivalent
    from gyroctl.waves import Regular, SeaState

    if sea is None:
        return Regular(own(height, 0.2, "m", plant), own(wp, 3.14, "rad/s", plant)), None
    if height is not None or wp is not None:
        raise InputError("sea", str(sea), "stands beside --height or --wp", "Give the file, or the numbers")
    told = sea_of(sea, None, None, SeaState.gamma, plant)
    return equivalent(told), told


def _of_sea(content: Mapping[str, Any]) -> list[str]:
    """Lines on the sea that the wave stands for, where one was given."""
    sea = content.get("sea")
    return [f"Sea: {sea['words']}.", f"Its wave is {sea['wave']}."] if sea else []


def _pair(plant: Plant, cc: float | None, cg: float | None) -> tuple[float, float]:
    """Controls [Nms]: what is left out is of the device's length."""
    return own(cc, 0.052, "Nms", plant), own(cg, 3.5e-4, "Nms", plant)
