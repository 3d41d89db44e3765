"""What several commands share: options with their meaning, the file to write, the two forms of an answer."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from gyroctl.plant import Plant
    from gyroctl.waves import Sea

MARKUP: Literal["markdown"] = "markdown"
"""Of help texts. Brackets in them are units, [m]: the default markup takes them for its own and drops them."""

Gamma = Annotated[float, typer.Option(help="Peak enhancement of the JONSWAP spectrum.")]
SeaFile = Annotated[
    Path | None, typer.Option("--sea", help="TOML file with a table [sea], as of an experiment.", show_default=False)
]
Variant = Annotated[str, typer.Option(help="Form of the plant: corrected, paper or realistic.")]
Workers = Annotated[int, typer.Option(min=0, max=1024, help="Workers; 0 for all cores. Changes no result.")]
Scheduler = Annotated[
    str,
    typer.Option(
        help="Run on the machines of this Dask scheduler, tcp://HOST:PORT, in a network of yours. Changes no result.",
        show_default=False,
    ),
]
AllowCode = Annotated[
    list[Path] | None,
    typer.Option(
        "--allow-code",
        help="File of Python that may run where an experiment, a task or a tuned set outside its folder names a law in "
        "it; may repeat. Read it first.",
    ),
]
Parameters = Annotated[list[str] | None, typer.Option("--set", help="Parameter of the law, key=value; may repeat.")]


Device = Annotated[
    Path | None, typer.Option("--device", help="A device of your own, see gyroctl device.", show_default=False)
]
OwnHs = Annotated[
    float | None, typer.Option("--hs", help="Significant wave height [m].", show_default="0.283 times the length")
]
OwnPeak = Annotated[
    float | None, typer.Option("--wp", help="Peak frequency [rad/s].", show_default="3.14 at the size of Table 1")
]
OwnPeriod = Annotated[float | None, typer.Option("--tp", help="Peak period [s], in place of --wp.", show_default=False)]


def plant_of(device: Path | None, variant: str, choices: Mapping[str, Any] | None = None) -> Plant:
    """Return the plant that a command is asked for: of a device file, or the paper's in a variant, with some choices.

    Raises
    ------
    InputError
        For a variant beside a device file, which says its own, and whatever the device refuses.
    """
    from gyroctl.devices import device as read
    from gyroctl.devices import zhang2017
    from gyroctl.errors import InputError

    if device is None:
        return zhang2017(variant, **(choices or {}))
    if variant != "corrected":
        raise InputError("--variant", variant, "is said by the device file", f"Write it into {device.name}")
    plant = read(device)
    plant = plant.replace(**choices) if choices else plant
    warn_doubtful(plant, device)
    return plant


def warn_doubtful(plant: Plant, device: Path | None) -> list[str]:
    """Say on stderr what the check of a device doubts, and return it."""
    from gyroctl.studies.device.assumed import doubts

    found = doubts(plant)
    for doubt in found:
        typer.echo(f"Doubtful device: {doubt}", err=True)
    if found:
        typer.echo(f"What to do: gyroctl device check {device.name if device else 'FILE'}", err=True)
    return found


def own(value: float | None, usual: float, unit: str, plant: Plant) -> float:
    """Return an option, or its usual value at the length of the device."""
    from gyroctl.froude import growth

    return usual * growth(unit, plant.parameters.length_scale) if value is None else value


def warn_foreign(
    names: Mapping[str, str], plant: Plant, device: Path | None, tunings: Mapping[str, str | None] | None = None
) -> None:
    """Say on stderr which laws run with a set of another device; `tunings` are the sets that were asked for."""
    from gyroctl.harness.device_sets import foreign, foreign_note

    strange = foreign(names, plant, device, tunings)
    if strange:
        typer.echo(foreign_note(strange, names, plant, device), err=True)


def parse(pairs: list[str], option: str = "--set") -> dict[str, Any]:
    """Turn ["cc=0.1"] into {"cc": 0.1}; what is no number stays text. `option` is how they were given."""
    from gyroctl.errors import InputError

    values: dict[str, Any] = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals or not key:
            raise InputError(option, pair, "is not of the form key=value", f"Write for example {option} cc=0.1")
        try:
            values[key.strip()] = float(text)
        except ValueError:
            values[key.strip()] = text.strip()
    return values


def check_file(out: Path) -> None:
    """Refuse to write a file where there can be none, before what goes into it is computed."""
    from gyroctl.errors import InputError

    if not out.resolve().parent.is_dir():
        raise InputError("out", str(out), "its folder does not exist", f"Make the folder {out.parent} first")
    if out.is_dir():
        raise InputError("out", str(out), "is a folder", "Give the name of a file, for example run.nc")


Form = Annotated[
    bool | None,
    typer.Option(
        "--words/--json", help="Answer in words, or as JSON.", show_default="words on a terminal, JSON in a pipe"
    ),
]


def answer(content: Mapping[str, Any], lines: Iterable[str], words: bool | None = None) -> None:
    """Print words or JSON as `Form` asks for it; unasked, words on a terminal and JSON in a pipe."""
    from gyroctl.errors import visible

    told = sys.stdout.isatty() if words is None else words
    for line in lines if told else [json.dumps(content, allow_nan=False)]:
        typer.echo(visible(line))


def say_notes(sea: object, plant: Any = None) -> None:
    """Say on stderr what was done to the numbers of a sea from a file, and what of it a device does not know."""
    from gyroctl.errors import visible

    notes = [*getattr(sea, "notes", ())]
    if plant is not None and notes:
        from gyroctl.waves.bands import outside_band

        notes += outside_band(plant, sea)  # type: ignore[arg-type]
    for note in notes:
        typer.echo(visible(f"sea: {note}"), err=True)


def say_remarks(found: Iterable[str]) -> list[str]:
    """Say on stderr what of the numbers is odd, see `gyroctl.harness.plausibility`, and return it."""
    from gyroctl.errors import visible

    told = list(found)
    for remark in told:
        typer.echo(visible(f"Note: {remark}."), err=True)
    return told


def peak_of(wp: float | None, tp: float | None) -> float | None:
    """Return the peak frequency of --wp or --tp [rad/s]; None where neither is given.

    Raises
    ------
    InputError
        For both, or no period.
    """
    from gyroctl.waves.peak_periods import in_frequencies

    given = {key: value for key, value in (("wp", wp), ("tp", tp)) if value is not None}
    return in_frequencies("sea", given).get("wp")


def sea_of(
    path: Path | None, hs: float | None, wp: float | None, gamma: float, plant: Plant, tp: float | None = None
) -> Sea:
    """Sea of a TOML file with a table [sea], or by its numbers; those that are not given are of the plant's length."""
    from gyroctl.waves import SeaState

    if path is None:
        wp = peak_of(wp, tp)
        return SeaState(own(hs, SeaState.hs, "m", plant), own(wp, SeaState.wp, "rad/s", plant), gamma)
    from gyroctl.comparison.sea_table import build_sea
    from gyroctl.errors import InputError
    from gyroctl.tables import read_tables, table_of

    if any(given is not None for given in (hs, wp, tp)) or gamma != SeaState.gamma:
        raise InputError("sea", str(path), "stands beside --hs, --wp, --tp or --gamma", "Give the file, or the numbers")
    tables = read_tables(path, "sea")
    if "sea" not in tables:
        raise InputError("sea", str(path), "has no table [sea]", "Write [sea] and its entries, as in an experiment")
    return build_sea(table_of(tables, "sea"), path.parent, plant.parameters.length_scale)


def failures(failed: Mapping[str, str]) -> None:
    """Name what failed, and end with exit code 1 where something did: the rest is written."""
    from gyroctl.errors import visible

    for name, why in failed.items():
        typer.echo(visible(f"Failed: {name}: {why}"), err=True)
    if failed:
        raise typer.Exit(1)
