"""`gyroctl bound`: what perfect foresight could harvest from windows of a sea, and what part of it the laws reach."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from gyroctl.cli.options import (
    Device,
    Gamma,
    Hs,
    PeakFrequency,
    Scheduler,
    Variant,
    answer,
    at_model_size,
    failures,
    parse,
    plant_of,
)

WINDOWS_MAX = 1000
"""Most windows of one search."""


def bound(
    gamma: Gamma = 5.0,
    hs: Hs = 0.283,
    wp: PeakFrequency = 3.14,
    seeds: Annotated[str, typer.Option(help="Realisations, one window each: 1,2,3 or 1-4.")] = "1",
    duration: Annotated[float, typer.Option(help="Length of a window [s], after a lead-in of 100 s.")] = 100.0,
    free: Annotated[
        bool, typer.Option("--free/--smooth", help="Also with a generator power that is free every 0.1 s.")
    ] = False,
    law: Annotated[
        list[str] | None,
        typer.Option(help='A law, with parameters after it: "nmpc information=oracle"; may be repeated.'),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for bound.json and bound.png.")] = Path("results/bound"),
    quick: Annotated[bool, typer.Option(help="Search with a tenth of the effort.")] = False,
    variant: Variant = "corrected",
    lag: Annotated[
        float | None,
        typer.Option(help="Lag of the coupling [s]. Default: none; 0.02 in a plant beyond the linear one."),
    ] = None,
    motion: Annotated[
        float | None,
        typer.Option(
            help="Limit of the 98 % motion [rad]. Default: 0.35; beyond the linear plant phi1 as much as a constant "
            "pair's, 0.35 at least, and phi3 0.25."
        ),
    ] = None,
    scheduler: Scheduler = "",
    device: Device = None,
) -> None:
    """Search for the best that perfect foresight could do; in a pipe the numbers come as JSON."""
    import gyroctl as gy
    from gyroctl.studies.bound import Effort, bound_report, table
    from gyroctl.studies.bound import quick as quick_effort

    plant = at_model_size(plant_of(device, variant), "the search of the bound")
    named = {text: _law(text, None if device is None else plant) for text in law or []}
    sea, windows = gy.SeaState(hs, wp, gamma), _seeds(seeds)
    effort = quick_effort(plant) if quick else Effort()
    how: dict[str, Any] = {"lag": lag, "motion": motion, "scheduler": scheduler or None}
    content = bound_report(plant, sea, windows, duration, named, out, free, effort, **how)
    answer(content, [*table(content), f"Numbers and figure: {out}"])
    failures(content["failed"])


def _law(text: str, device: Any = None) -> Any:
    """Build the law of "name key=value ...", or of "file.py:Name key=value ...", perhaps for a device."""
    import gyroctl as gy
    from gyroctl.harness.registry import build

    words = shlex.split(text)
    if not words:
        raise gy.InputError("law", text, "is empty", "Give a name, see gyroctl laws")
    return build(words[0], parse(words[1:]), device=device)


def _seeds(text: str) -> list[int]:
    """Turn "1,2,7-9" into [1, 2, 7, 8, 9]."""
    from gyroctl.errors import InputError

    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdigit() or (dash and not last.isdigit()):
            raise InputError("seeds", text, "is no list of seeds", "Write for example 1,2,3 or 1-4")
        if int(last or first) - int(first) + len(found) >= WINDOWS_MAX:
            raise InputError("seeds", text, f"are more than {WINDOWS_MAX} windows", "Give fewer; each takes minutes")
        found += range(int(first), int(last or first) + 1)
    return found
