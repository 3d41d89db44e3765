"""`gyroctl waves`: a sea read and told, its waves written for spreadsheets or for WEC-Sim."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyroctl.cli.options import (
    Device,
    Gamma,
    OwnHs,
    OwnPeak,
    OwnPeriod,
    SeaFile,
    Variant,
    check_file,
    own,
    plant_of,
    say_notes,
    say_remarks,
    sea_of,
)

if TYPE_CHECKING:
    from gyroctl.plant import Plant
    from gyroctl.waves import Sea


def waves(
    out: Annotated[
        Path | None,
        typer.Argument(help="waves.csv for a table; waves.mat or waves.txt for WEC-Sim.", show_default=False),
    ] = None,
    sea: SeaFile = None,
    gamma: Gamma = 5.0,
    hs: OwnHs = None,
    wp: OwnPeak = None,
    tp: OwnPeriod = None,
    seed: Annotated[int, typer.Option(help="Seed of the realisation.")] = 1,
    duration: Annotated[
        float | None, typer.Option(help="Length [s].", show_default="2000 at the size of Table 1")
    ] = None,
    dt: Annotated[float | None, typer.Option(help="Time step [s].", show_default="0.05 at the size of Table 1")] = None,
    blend: Annotated[float, typer.Option(help="Blend from the regular wave at the start [s].")] = 0.0,
    variant: Variant = "corrected",
    device: Device = None,
) -> None:
    """Tell a sea; with OUT, write elevation and moments of one realisation."""
    import gyroctl as gy
    from gyroctl.harness.plausibility import remarks
    from gyroctl.waves import SpreadSea
    from gyroctl.waves.directional import DirectionalSpectrum
    from gyroctl.waves.export import form_of, write_waves
    from gyroctl.waves.telling import in_a_line

    form = None
    if out is not None:
        form = form_of(out)
        check_file(out)
    plant = plant_of(device, variant)
    duration, dt = own(duration, 2000.0, "s", plant), own(dt, 0.05, "s", plant)
    chosen = sea_of(sea, hs, wp, gamma, plant, tp)
    say_notes(chosen, plant)
    say_remarks(remarks(plant, chosen))
    typer.echo(in_a_line(chosen))
    if out is None:
        _say_refused(plant, chosen, duration, dt)
        return
    made = gy.realise(plant, chosen, seed, duration, dt)
    if blend:
        made = made.blended(blend)
    if form == "WEC-Sim" and isinstance(chosen, SpreadSea | DirectionalSpectrum):
        typer.echo("sea: WEC-Sim takes an elevation as waves of one direction: the spreading is lost", err=True)
    write_waves(out, made)
    typer.echo(f"Waves: {out} ({form}), realisation {made.sha256[:12]}")


def _say_refused(plant: Plant, sea: Sea, duration: float, dt: float) -> None:
    """Say on stderr where no run of this device takes the sea, and why."""
    import math

    from gyroctl.errors import InputError
    from gyroctl.waves import ElevationRecord
    from gyroctl.waves.synthesis import prepare

    if isinstance(sea, ElevationRecord):
        duration = min(duration, math.floor(sea.duration / dt) * dt)
    try:
        prepare(plant, sea, duration, dt)
    except InputError as error:
        typer.echo(f"sea: a run of this device refuses it as it stands: {error}", err=True)
