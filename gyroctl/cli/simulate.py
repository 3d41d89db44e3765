"""`gyroctl simulate`: one law on one realisation, as a labelled NetCDF file."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyroctl.cli.first_time import say_first_time
from gyroctl.cli.options import (
    Device,
    Gamma,
    OwnHs,
    OwnPeak,
    OwnPeriod,
    Parameters,
    SeaFile,
    Variant,
    check_file,
    own,
    parse,
    plant_of,
    say_notes,
    say_remarks,
    sea_of,
    warn_foreign,
)

if TYPE_CHECKING:
    import xarray


def simulate(
    law: Annotated[str, typer.Option(help='Registered name, or "file.py:Name".')],
    out: Annotated[Path, typer.Option(help="NetCDF file to write.")],
    settings: Parameters = None,
    gamma: Gamma = 5.0,
    hs: OwnHs = None,
    wp: OwnPeak = None,
    tp: OwnPeriod = None,
    sea: SeaFile = None,
    seed: Annotated[int, typer.Option(help="Seed of the realisation.")] = 1,
    duration: Annotated[
        float | None, typer.Option(help="Length of the run [s].", show_default="2000 at the size of Table 1")
    ] = None,
    blend: Annotated[
        float | None,
        typer.Option(help="Blend from the regular wave at the start [s].", show_default="100 at the size of Table 1"),
    ] = None,
    dt: Annotated[
        float | None, typer.Option(help="Longest step [s].", show_default="0.01 at the size of Table 1")
    ] = None,
    start: Annotated[str, typer.Option(help="Start: locked, or rest for a law that starts the device.")] = "locked",
    motor: Annotated[float, typer.Option(help="Largest gain of the generator as a motor [Nms].")] = 0.0,
    variant: Variant = "corrected",
    device: Device = None,
) -> None:
    """Run one law on one realisation and write the trajectory."""
    import numpy as np

    import gyroctl as gy
    from gyroctl.harness.device_sets import own_choice
    from gyroctl.harness.plausibility import check_parts, remarks
    from gyroctl.harness.registry import build
    from gyroctl.harness.run import lead_in
    from gyroctl.provenance import command_line
    from gyroctl.reports.resting import in_words
    from gyroctl.simulation.metrics import evaluate
    from gyroctl.simulation.progress import Progress
    from gyroctl.simulation.trajectory import record_of
    from gyroctl.waves.checks import within
    from gyroctl.writing import written_as_hdf5

    plant = plant_of(device, variant)
    duration, blend = own(duration, 2000.0, "s", plant), own(blend, 100.0, "s", plant)
    dt = own(dt, 0.01, "s", plant)
    most = own(None, 10.0, "Nms", plant)
    within("motor", motor, 0.0, most, "Give the size of the gain in Nms, for example 0.02")
    given = parse(settings or [])
    check_parts(law, given)
    if device is not None:
        warn_foreign({law: law}, plant, device, {law: given.get("tuning")})
        given = own_choice(device, law, plant, given)
    built = build(law, given, device=None if device is None else plant)
    check_file(out)
    if start == "locked" and not duration > blend:
        problem, mend = f"is not longer than the blend of {blend:g} s", "Give a longer --duration, or a shorter --blend"
        raise gy.InputError("duration", duration, problem, mend)
    usual = gy.Settings(start=start).at(plant.parameters.length_scale)
    setup = replace(usual, dt=dt, blend=blend, actuators=replace(usual.actuators, cg_min=-motor))
    chosen = sea_of(sea, hs, wp, gamma, plant, tp)
    say_notes(chosen, plant)
    say_remarks(remarks(plant, chosen, {law: built}, setup.actuators))
    waves, peak = gy.realise(plant, chosen, seed, duration), chosen.wp
    acting = lead_in(waves, setup)
    say_first_time("plant and law", 4)
    with Progress("run", round(duration / built.period)) as progress:
        ds = gy.simulate(plant, built, acting, setup, law, progress=progress.advance)
    rest, scored = start == "rest", (setup.score_from, float("nan"))
    record = record_of(plant, ds)
    found = evaluate(plant, record, acting.moments[1], acting.dt, peak, *scored, from_rest=rest)
    if not math.isfinite(found["mean_power"]):
        still = np.isfinite(ds.psi_rate.values)
        last = float(ds.time[int(still.argmin())])
        problem = f"the run is no longer finite from t = {last:.1f} s on, so that it has no mean power"
        raise gy.InputError("law", law, problem, "Try smaller waves (--hs), a shorter step (--dt) or another law")
    with written_as_hdf5(out) as part:
        ds.assign_attrs(command=command_line()).to_netcdf(part, engine="h5netcdf")
    typer.echo(f"{law}: {_closing(ds, found, peak, rest)}. Trajectory: {out}")
    card = {name: math.nan if value is None else value for name, value in json.loads(ds.attrs["validity"]).items()}
    typer.echo(in_words(card))


def _closing(ds: xarray.Dataset, found: Mapping[str, float], wp: float, rest: bool) -> str:
    """What the run was worth, in a line: judged power with both parts, lock, turns, slips, motion."""
    from gyroctl.simulation.lock import WINDOW
    from gyroctl.simulation.metrics import production

    if found["locked"] != found["locked"]:
        lock = f"lock not judged: fewer than {WINDOW:g} s are scored"
    elif rest:
        period = float(ds.time[1] - ds.time[0])
        locked = production(ds.psi.values, ds.energy_generator.values, period, wp)
        began = f"locked from {float(locked.argmax()) * period:.0f} s on" if locked.any() else "never locked"
        lock = f"{began}, {100.0 * float(locked.mean()):.0f} % of the time in locked production"
    else:
        lost = found["loss_time"]
        lock = "kept lock" if lost != lost else f"lost lock after {lost:.0f} s"
    parts = f"{found['generated_w']:.2f} W generated, {found['stored_w']:+.2f} W stored"
    turns = f"{100.0 * found['turns_kept']:.1f} % of the turns kept, {found['cycle_slips']:.0f} slips per 1000 waves"
    motion = f"largest |phi| {max(found['phi1_max'], found['phi3_max']):.2f} rad"
    outside = f"beyond 0.3 rad for {100.0 * found['outside_share']:.1f} % of the time"
    return f"{found['mean_power']:.2f} W mean power, {lock} ({parts}; {turns}; {motion}, {outside})"
