"""`gyroctl device`: a device of one's own as a file: new, check, at another size."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from gyroctl.cli.options import MARKUP, parse

app = typer.Typer(help="A device of your own as a file.", no_args_is_help=True, rich_markup_mode=MARKUP)

File = Annotated[Path, typer.Argument(help="Device file, TOML.", show_default=False)]


@app.command()
def new(
    file: File,
    name: Annotated[str, typer.Option(help="Name of the device; else that of the file.")] = "",
    variant: Annotated[str, typer.Option(help="Choices to begin with: corrected, paper or realistic.")] = "corrected",
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="Entry of the file, key=value; may repeat.")
    ] = None,
) -> None:
    """Write a device file: Table 1, every entry with its unit and meaning."""
    from gyroctl.devices.file import new_device, write_device

    changes = {key: _value(value) for key, value in parse(settings or []).items()}
    name, variant = str(changes.pop("name", name)), str(changes.pop("variant", variant))
    above = ("A device. What is left out is that of Table 1 in this variant, at this length_scale.",)
    path = write_device(file, new_device(name or file.stem, variant, **changes), above)
    typer.echo(f"Device: {path}")


@app.command()
def check(
    file: File,
    out: Annotated[
        Path | None, typer.Option(help="Folder for device.json and a picture of the geometry.", show_default=False)
    ] = None,
    height: Annotated[
        float | None,
        typer.Option(help="Height of the regular wave of the lock [m]; else 0.2 m at the size of Table 1."),
    ] = None,
    wp: Annotated[
        float | None, typer.Option(help="Its frequency [rad/s]; else 3.14 rad/s at the size of Table 1.")
    ] = None,
) -> None:
    """Check a device: inertias, natural frequencies, lock capacity, slip, what is assumed of depth and lever."""
    from gyroctl.studies.device import device_report

    report = device_report(file, out, height, wp)
    for line in report.lines:
        typer.echo(line)
    if out is not None:
        typer.echo(f"Numbers and picture: {out}")
    if not report.plausible:
        raise typer.Exit(1)


@app.command()
def scale(
    file: File,
    length: Annotated[float, typer.Option(help="How many times as long the device is to be.")],
    out: Annotated[
        Path | None, typer.Option(help="Device file to write; else mine-x20.toml beside mine.toml.", show_default=False)
    ] = None,
) -> None:
    """Write the same device at another size, by Froude's law, in water that is as much deeper."""
    from gyroctl.devices.file import scaled_device, write_device

    entries = scaled_device(file, length)
    out = file.with_name(f"{file.stem}-x{length:g}.toml") if out is None else out
    source = entries["hydrodynamics"]
    if source != "shipped":  # paths are relative to the file that names them
        import os

        there = (file.parent / source).resolve()
        entries["hydrodynamics"] = Path(os.path.relpath(there, out.resolve().parent)).as_posix()
    path = write_device(out, entries, (f"{file.name} with all lengths times {length:g}, by Froude's law.",))
    typer.echo(f"Device: {path}")


def _value(value: Any) -> Any:
    """Texts of --set that stand for true, false or a pair of numbers."""
    if not isinstance(value, str):
        return value
    if value in ("true", "false"):
        return value == "true"
    if value.startswith("[") and value.endswith("]"):
        try:
            return [float(part) for part in value[1:-1].split(",")]
        except ValueError:
            return value
    return value
