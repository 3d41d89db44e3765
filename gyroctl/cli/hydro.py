"""`gyroctl hydro`: build, check, import, report on and export hydrodynamic databases."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyroctl.cli.options import MARKUP, Device, check_file
from gyroctl.errors import InputError, visible

app = typer.Typer(
    help="Hydrodynamic databases: build, check, import, report, export.", no_args_is_help=True, rich_markup_mode=MARKUP
)


@app.command()
def build(
    out: Annotated[Path, typer.Argument(help="NetCDF file to write.")] = Path("hydrodynamics.nc"),
    variant: Annotated[str, typer.Option(help="Reading of the geometry: inclined, horizontal or deep.")] = "inclined",
    keep: Annotated[Path | None, typer.Option(help="Former database whose bits stay where it agrees.")] = None,
) -> None:
    """Compute the database from the geometry with Capytaine (extra `bem`), and fit its wetted surface."""
    from gyroctl.hydrodynamics import load, save
    from gyroctl.hydrodynamics.bem import build as run
    from gyroctl.simulation.progress import Progress
    from gyroctl.waves.wetted_fit import fit_wetted

    check_file(out)
    with Progress("frequencies", 1) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.advance(done - bar.done)

        path = run(out, variant, show, keep=keep)
    save(fit_wetted(load(path)), path)
    typer.echo(f"Database: {path}")


@app.command("fit-wetted")
def fit_wetted_(
    database: Annotated[Path, typer.Argument(help="NetCDF file with the float's geometry; it is written anew.")],
    out: Annotated[Path | None, typer.Option(help="NetCDF file to write instead.")] = None,
    hs: Annotated[float | None, typer.Option(help="Middle of three wave heights [m]; else from the hull.")] = None,
    wp: Annotated[float | None, typer.Option(help="Peak frequency [rad/s]; else from the hull.")] = None,
) -> None:
    """Fit the reduced wetted surface to the panels of the float, and keep it with the database."""
    from gyroctl.hydrodynamics import load, save
    from gyroctl.hydrodynamics.undisturbed import completed
    from gyroctl.waves.wetted_fit import fit_wetted

    check_file(out or database)
    hydro = fit_wetted(completed(load(database)), hs, wp)
    fit = hydro.wetted
    path = save(hydro, out or database)
    if fit is not None:
        typer.echo(f"moment1: {', '.join(f'{v:.4g}' for v in fit.moment1)}; misses {100 * fit.error1:.1f} % of R1")
        typer.echo(f"moment3: {', '.join(f'{v:.4g}' for v in fit.moment3)}; misses {100 * fit.error3:.1f} % of R3")
        typer.echo(f"under at {fit.low:.3f} rad, dry at {fit.high:.3f} rad")
    typer.echo(f"Database: {path}")


@app.command()
def check(
    database: Annotated[Path | None, typer.Argument(help="NetCDF file; without it the shipped one.")] = None,
    out: Annotated[Path | None, typer.Option(help="JSON file for the rows.", show_default=False)] = None,
    device: Device = None,
) -> None:
    """Check a database against Table 1, Haskind, Kramers-Kronig, symmetry and the passivity of its fits."""
    from gyroctl.devices.file import database_of
    from gyroctl.errors import InputError
    from gyroctl.hydrodynamics.check import check as run
    from gyroctl.provenance import made
    from gyroctl.writing import write_json

    if out is not None:
        check_file(out)
    if device is not None and database is not None:
        problem, mend = "is a database beside that of the device", "Give one of the two"
        raise InputError("database", str(database), problem, mend)
    found = run(database if device is None else database_of(device))
    if out is not None:
        write_json(out, {**made(), "ok": found.ok, "rows": found.rows})
    typer.echo(str(found))
    if not found.ok:
        raise typer.Exit(1)


@app.command("import")
def import_(
    source: Annotated[Path, typer.Argument(help="Results: a NetCDF file, the stem of .1 and .3, or a NEMOH folder.")],
    out: Annotated[Path, typer.Argument(help="NetCDF file to write.")],
    format: Annotated[str, typer.Option(help="capytaine, wamit or nemoh.")] = "capytaine",
    rho: Annotated[float | None, typer.Option(help="Density of the water [kg/m^3]; usual: 1000.")] = None,
    g: Annotated[float | None, typer.Option(help="Gravity [m/s^2]; usual: 9.81.")] = None,
    depth: Annotated[float | None, typer.Option(help="Water depth [m]; inf for deep water, which is usual.")] = None,
    length: Annotated[float | None, typer.Option(help="WAMIT's ULEN [m]; usual: 1.")] = None,
    stiffness: Annotated[float | None, typer.Option(help="Buoyancy stiffness k3 [Nm/rad], for the file's.")] = None,
    modes: Annotated[
        tuple[str, str] | None,
        typer.Option(help="Modes of phi1 and phi3, by number or name, -yaw roll if not given; minus: turned."),
    ] = None,
    frequency: Annotated[str | None, typer.Option(help="What frequencies are given as: rad/s, Hz or period.")] = None,
    headings: Annotated[str | None, typer.Option(help="Unit of the headings: deg or rad.")] = None,
    phases: Annotated[str | None, typer.Option(help="Unit of NEMOH's phases: deg or rad.")] = None,
    about: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="Point that moments are about [m], where the file does not tell it."),
    ] = None,
    centre: Annotated[
        tuple[float, float] | None, typer.Option(help="x and y of the float's centre in the run [m]; usual: 0 0.")
    ] = None,
    mesh: Annotated[Path | None, typer.Option(help="Mesh of the whole float at rest, as Capytaine reads it.")] = None,
    hinge: Annotated[
        tuple[float, float] | None, typer.Option(help="y (negative) and z of the hinge from the float's centre [m].")
    ] = None,
    inclination: Annotated[
        float | None, typer.Option(help="Lever below the horizontal, with --mesh [deg]; usual: 0.")
    ] = None,
) -> None:
    """Read results of another solver, fit the radiation passively, write a database and report what was read."""
    from gyroctl.hydrodynamics.import_report import import_report
    from gyroctl.hydrodynamics.importers import Site, import_results
    from gyroctl.hydrodynamics.panels import read_hull

    check_file(out)
    site = Site(
        rho, g, depth, length, stiffness, modes, frequency, headings, phases, about=about, centre=centre, hinge=hinge
    )
    if mesh is None and inclination is not None:
        raise InputError(
            "inclination", inclination, "turns the lever of a mesh, and there is none", "Give --mesh as well"
        )
    hull = None if mesh is None else read_hull(mesh, hinge or (0.0, 0.0), inclination or 0.0)
    path = import_results(source, format, out, site, hull)
    typer.echo(visible(str(import_report(path))))
    typer.echo(f"Database: {path}")


@app.command()
def report(
    database: Annotated[Path | None, typer.Argument(help="NetCDF file; without it the shipped one.")] = None,
    out: Annotated[Path | None, typer.Option(help="JSON file for the report.", show_default=False)] = None,
) -> None:
    """Say what a database holds, where it comes from, how good its fits are, and whether it can be used."""
    from gyroctl.hydrodynamics.import_report import import_report
    from gyroctl.provenance import made
    from gyroctl.writing import write_json

    if out is not None:
        check_file(out)
    found = import_report(database)
    if out is not None:
        write_json(out, {**made(), "ok": found.ok, "verdict": found.verdict, "report": found})
    typer.echo(visible(str(found)))
    if not found.ok:
        raise typer.Exit(1)


@app.command()
def export(
    out: Annotated[Path, typer.Option(help="NAME of WAMIT's files, or the NetCDF file.")],
    database: Annotated[Path | None, typer.Argument(help="NetCDF file; without it the shipped one.")] = None,
    format: Annotated[str, typer.Option(help="wamit or capytaine.")] = "wamit",
) -> None:
    """Write a database as WAMIT's .1, .3, .hst and .out (the water), or as Capytaine's NetCDF with Roll and Yaw."""
    from gyroctl.hydrodynamics import export_results, shipped

    for path in export_results(database or shipped(), format, out):
        typer.echo(f"Written: {path}")
