"""`gyroctl compare`: the main job."""

from __future__ import annotations

import json
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyroctl.cli.first_time import say_first_time
from gyroctl.cli.options import AllowCode, Scheduler, Workers, say_notes, say_remarks, warn_doubtful

if TYPE_CHECKING:
    import xarray

WRITTEN = ("results.nc", "summary.json", "report.html")
"""What a comparison writes."""

DRAWN = ("scipy.stats", "scipy.signal", "matplotlib.figure", "matplotlib.backends.backend_svg", "plotly.offline")
WRITING = (*DRAWN, "xarray", "h5py", "h5netcdf.legacyapi", "rich.table", "gyroctl.reports")
"""What it writes them with."""


def compare(
    experiment: Annotated[
        Path | None, typer.Argument(help="TOML file; without it the default experiment.", show_default=False)
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for results.nc, summary.json and report.html.")] = Path("results"),
    workers: Workers = 0,
    scheduler: Scheduler = "",
    quick: Annotated[bool, typer.Option("--quick", help="Four realisations of 600 s.")] = False,
    search: Annotated[
        bool, typer.Option(help="Search the best constant pair of this sea and device where none is known yet.")
    ] = True,
    allow_code: AllowCode = None,
    full_series: Annotated[
        bool, typer.Option("--full-series", help="Keep time series of more than 20 000 samples whole.")
    ] = False,
) -> None:
    """Compare laws on identical wave realisations."""
    from gyroctl.comparison.compare import Realisations, check_length, check_seeds
    from gyroctl.comparison.compare import compare as run
    from gyroctl.comparison.experiment import read_experiment
    from gyroctl.errors import visible
    from gyroctl.harness.law_fingerprint import fetches_of
    from gyroctl.provenance import command_line
    from gyroctl.tuning.yardstick import find_yardstick

    check_folder(out)
    setup = read_experiment(experiment, quick, allow_code or ())
    waves, asked = Realisations(setup.sea, setup.run.seeds, setup.run.duration), setup.record()
    tuned, limit, runs = setup.tuning_seeds, setup.run.motion_limit, out / "runs"
    check_seeds(waves.seeds, tuned)
    check_length(waves.duration, setup.settings.score_from)
    for library in WRITING:  # where one cannot be loaded, for want of memory or since it is broken, no run is lost
        import_module(library)
    say_notes(setup.sea, setup.plant)
    odd = say_remarks(setup.remarks)
    say_first_time("plant and laws", 30)
    say, on = partial(typer.echo, err=True), workers or None
    doubtful = warn_doubtful(setup.plant, setup.device_file)
    for name, law in setup.laws.items():
        if fetched := fetches_of(law):
            what = "what comes from there while it runs does not make it another law"
            say(f"Note: {name} uses {', '.join(fetched)}: {what}")
    strange = setup.foreign
    if strange:
        say(setup.foreign_note)
    pair = find_yardstick(setup.plant, setup.sea, setup.settings, limit, workers=on, search=search, say=say)
    ds = run(
        setup.plant,
        setup.laws,
        waves,
        setup.settings,
        on,
        results=runs,
        tuning_seeds=tuned,
        experiment=asked,
        motion_limit=limit,
        yardstick=pair,
        time_limit=setup.run.time_limit or None,
        full_series=full_series,
        scheduler=scheduler or None,
    )
    odd += say_remarks(_cut(ds, waves.duration / setup.actuators.period, odd))
    beside = {"foreign_laws": strange, "doubts": doubtful, "remarks": odd}
    told = {name: json.dumps(words) for name, words in beside.items()}
    write(ds.assign_attrs(command=command_line(), **told), out)
    for name in ds.law.values:
        reasons = [str(reason) for reason in ds.failure.sel(law=name).values if reason]
        if reasons:
            many = f"{len(reasons)} of {ds.sizes['realisation']} runs"
            typer.echo(f"{name} failed in {many}: {visible(reasons[0])}", err=True)
    if ds.failed.any():
        raise typer.Exit(2 if ds.failed.all() else 1)


def _cut(ds: xarray.Dataset, samples: float, told: list[str]) -> list[str]:
    """Tell of laws whose commands were cut to the limits all the time, where it was not `told` before the runs."""
    from gyroctl.harness.plausibility import cut_all_the_time

    names = [str(name) for name in ds.law.values if not any(one.startswith(f"laws.{name}.") for one in told)]
    least = {name: float(ds.saturations.sel(law=name).min()) for name in names}
    return [remark for name, cut in least.items() for remark in cut_all_the_time(name, cut, samples)]


def check_folder(out: Path) -> None:
    """Refuse a folder that is a file, or in which a folder has the name of one, before an hour of runs."""
    from gyroctl.errors import InputError

    for part in (out, *out.parents):
        if part.exists() and not part.is_dir():
            raise InputError("out", str(out), f"{part} is a file, not a folder", "Give another folder")
    for part in (out / name for name in WRITTEN):
        if part.is_dir():
            raise InputError("out", str(out), f"{part} is a folder where a file belongs", "Remove it")


def write(ds: xarray.Dataset, out: Path, results: bool = True, source: Path | None = None) -> None:
    """Write the three files, each whole or not at all, and print the table; what lies in `source` is told as well."""
    from gyroctl.reports import evaluate, print_table, summarise, write_report
    from gyroctl.reports.layout import packing
    from gyroctl.writing import SEALED, seal, write_json, written_as_hdf5

    found = evaluate(ds)
    if results:
        with written_as_hdf5(out / "results.nc") as part:
            sealed = ds.assign_attrs({SEALED: "the file ends with the SHA-256 of its bytes"})
            sealed.to_netcdf(part, engine="h5netcdf", encoding=packing(ds))
            seal(part)
    write_json(out / "summary.json", summarise(ds, found))
    page = write_report(ds, out / "report.html", found, source)
    print_table(ds, found)
    typer.echo(f"Report: {page}")
