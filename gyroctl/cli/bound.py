"""`gyroctl bound`: what perfect foresight could harvest from windows of a sea, and what part of it the laws reach."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from gyroctl.cli.options import (
    Device,
    Form,
    Gamma,
    OwnHs,
    OwnPeak,
    OwnPeriod,
    Scheduler,
    Variant,
    answer,
    failures,
    own,
    parse,
    peak_of,
    plant_of,
)

WINDOWS_MAX = 1000
"""Most windows of one search."""


def bound(
    gamma: Gamma = 5.0,
    hs: OwnHs = None,
    wp: OwnPeak = None,
    tp: OwnPeriod = None,
    seeds: Annotated[str, typer.Option(help="Realisations, one window each: 1,2,3 or 1-4.")] = "1",
    duration: Annotated[
        float | None,
        typer.Option(
            help="Length of a window [s], after a lead-in of 100 s at the size of Table 1.",
            show_default="100 at the size of Table 1",
        ),
    ] = None,
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
    words: Form = None,
) -> None:
    """Search for the best that perfect foresight could do; in a pipe the numbers come as JSON."""
    from gyroctl.studies.bound import Effort, bound_report, table
    from gyroctl.studies.bound import quick as quick_effort
    from gyroctl.waves import SeaState

    plant = plant_of(device, variant)
    named = {text: _law(text, None if device is None else plant, device) for text in law or []}
    hs, wp = own(hs, SeaState.hs, "m", plant), own(peak_of(wp, tp), SeaState.wp, "rad/s", plant)
    sea, windows, duration = SeaState(hs, wp, gamma), _seeds(seeds), own(duration, 100.0, "s", plant)
    effort = quick_effort(plant) if quick else Effort()
    how: dict[str, Any] = {"lag": lag, "motion": motion, "scheduler": scheduler or None}
    content = bound_report(plant, sea, windows, duration, named, out, free, effort, **how)
    answer(content, [*table(content), f"Numbers and figure: {out}"], words)
    failures(content["failed"])


def _law(text: str, device: Any = None, file: Path | None = None) -> Any:
    """Build the law of "name key=value ...", or of "file.py:Name key=value ...", perhaps for a device.

    For one of another length that of its model, which may be told the waves; a pair that is given is the device's own.
    """
    import gyroctl as gy
    from gyroctl.devices.scaling import at_model_size
    from gyroctl.froude import growth
    from gyroctl.harness.device_sets import own_choice
    from gyroctl.harness.for_device import PAIR, holds_a_pair
    from gyroctl.harness.plausibility import check_parts
    from gyroctl.harness.registry import build

    words = shlex.split(text)
    if not words:
        raise gy.InputError("law", text, "is empty", "Give a name, see gyroctl laws")
    given = parse(words[1:])
    check_parts(words[0], given)
    if file is not None:
        given = own_choice(file, words[0], device, given)
    if device is None or device.parameters.length_scale == 1.0:
        return build(words[0], given, device=device)
    built: Any = build(words[0], given, device=at_model_size(device))
    unit = growth("Nms", device.parameters.length_scale)
    own_pair = {key: given[key] / unit for key in PAIR if key in given} if holds_a_pair(built) else {}
    return built._replace(**own_pair) if own_pair else built


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
