"""`gyroctl simulate`: one law on one realisation, as a labelled NetCDF file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import Gamma, Hs, Parameters, PeakFrequency, Variant, check_file, parse


def simulate(
    law: Annotated[str, typer.Option(help='Registered name, or "file.py:Name".')],
    out: Annotated[Path, typer.Option(help="NetCDF file to write.")],
    settings: Parameters = None,
    gamma: Gamma = 5.0,
    hs: Hs = 0.283,
    wp: PeakFrequency = 3.14,
    seed: Annotated[int, typer.Option(help="Seed of the realisation.")] = 1,
    duration: Annotated[float, typer.Option(help="Length of the run [s].")] = 2000.0,
    blend: Annotated[float, typer.Option(help="Blend from the regular wave at the start [s].")] = 100.0,
    dt: Annotated[float, typer.Option(help="Longest step [s].")] = 0.01,
    start: Annotated[str, typer.Option(help="Start: locked, or rest for a law that starts the device.")] = "locked",
    motor: Annotated[float, typer.Option(help="Largest gain of the generator as a motor [Nms].")] = 0.0,
    variant: Variant = "corrected",
) -> None:
    """Run one law on one realisation and write the trajectory."""
    import gyroctl as gy
    from gyroctl.provenance import command_line
    from gyroctl.simulation.lock import loss_time
    from gyroctl.simulation.metrics import production
    from gyroctl.simulation.progress import Progress
    from gyroctl.waves.checks import within
    from gyroctl.writing import written_whole

    within("motor", motor, 0.0, 10.0, "Give the size of the gain in Nms, for example 0.02")
    built = gy.law(law, **parse(settings or []))
    check_file(out)
    if start == "locked" and not duration > blend:
        problem, mend = f"is not longer than the blend of {blend:g} s", "Give a longer --duration, or a shorter --blend"
        raise gy.InputError("duration", duration, problem, mend)
    setup = gy.Settings(dt=dt, blend=blend, actuators=gy.Actuators(cg_min=-motor), start=start)
    plant = gy.zhang2017(variant)
    waves = gy.realise(plant, gy.SeaState(hs, wp, gamma), seed, duration)
    with Progress("run", round(duration / built.period)) as progress:
        ds = gy.simulate(plant, built, waves, setup, law, progress=progress.advance)
    period = float(ds.time[1] - ds.time[0])
    lost = float(loss_time(ds.psi.values, period, wp))
    lock = "kept lock" if lost != lost else f"lost lock after {lost:.0f} s"
    if start == "rest":
        locked = production(ds.psi.values, ds.energy_generator.values, period, wp)
        began = f"locked from {float(locked.argmax()) * period:.0f} s on" if locked.any() else "never locked"
        lock = f"{began}, {100.0 * float(locked.mean()):.0f} % of the time in locked production"
    scored = ds.sel(time=slice(setup.score_from, None))
    mean = float(scored.energy_generator[-1] - scored.energy_generator[0]) / float(scored.time[-1] - scored.time[0])
    if not math.isfinite(mean):
        moving = ds.psi_rate.values
        last = period * float((moving == moving).argmin())
        problem = f"the run is no longer finite from t = {last:.1f} s on, so that it has no mean power"
        raise gy.InputError("law", law, problem, "Try smaller waves (--hs), a shorter step (--dt) or another law")
    with written_whole(out) as part:
        ds.assign_attrs(command=command_line()).to_netcdf(part, engine="h5netcdf")
    typer.echo(f"{law}: {mean:.2f} W mean power, {lock}. Trajectory: {out}")
