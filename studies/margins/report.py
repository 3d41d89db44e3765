"""The margin report: measure, draw, write. And the lock map by itself."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.engine.cluster import connected
from gyroctl.engine.state import RUNS
from gyroctl.engine.steps import Asked, Steps, planned
from gyroctl.errors import InputError
from gyroctl.harness.law_fingerprint import law_fingerprint, value_fingerprint
from gyroctl.linearisation import PeriodicOrbit
from gyroctl.provenance import made
from gyroctl.robustness.headroom import Headroom
from gyroctl.robustness.shocks import Shock
from gyroctl.simulation.progress import Progress
from gyroctl.statistics.estimate import Share
from gyroctl.studies.margins import draw_linear, draw_maps, draw_orbit, draw_robustness, measures
from gyroctl.studies.margins.ahead import measure_ahead
from gyroctl.studies.margins.beside import beside
from gyroctl.studies.margins.borders import Border, control_borders
from gyroctl.studies.margins.cells import DesignMargins, design_margins
from gyroctl.studies.margins.mapped import (
    BASIN_COLUMNS,
    BORDER_STAGES,
    MAP_COLUMNS,
    MAPS,
    TONGUE_COLUMNS,
    couplings,
    map_all,
    map_controls,
    map_waves,
)
from gyroctl.studies.margins.maps import STABLE, OrbitMap
from gyroctl.studies.margins.measures import LoopAnswer, Margins
from gyroctl.studies.margins.measuring import check_samples, measured, of_a_law, of_constant, steps_of
from gyroctl.studies.margins.page import write_page
from gyroctl.studies.margins.real_water import WATER_STAGES, real_water
from gyroctl.studies.margins.request import Request, find_orbit
from gyroctl.studies.margins.words import INSTEAD, meanings
from gyroctl.studies.style import save, styled
from gyroctl.waves.telling import in_a_line
from gyroctl.writing import Kept, plain, write_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gyroctl.waves import Sea

STANDS_FOR = "the regular wave of its energy: of height Hs/sqrt 2, at the frequency of its peak, in its heading"
"""What the wave of a report is of a sea."""

LINEAR = "gain, phase, delay and disk margins"

MODULES = (__name__, "gyroctl.studies.margins.measures")
"""What computes a report."""

KINDS = (Margins, Headroom, Share, Shock, OrbitMap, Border)
"""What it is made of."""

AXES = (("cc", "cg"), ("wp", "height"))
"""Pairs of axes that can be mapped."""


def margin_report(
    asked: Request,
    out: Path,
    samples: int = 128,
    maps: bool = True,
    quiet: bool = False,
    water: bool = False,
    scheduler: Any = None,
    sea: Sea | None = None,
) -> dict[str, Any]:
    """Make the report.

    Parameters
    ----------
    asked : Request
        Operating point and law, from `request`.
    out : Path
        Folder for margins.json and the pictures; made where it is missing.
    samples : int
        Random disturbances per size.
    maps : bool
        Also the maps over controls and waves.
    quiet : bool
        No progress bar.
    water : bool
        Also what each choice beyond the linear model moves, see `real_water`.
    scheduler : str or dask.distributed.Client, optional
        Address of a Dask scheduler whose workers do the steps that are kept; the same bits.
    sea : Sea, optional
        The sea that the wave stands for, which is told with it.

    Returns
    -------
    dict
        What margins.json holds.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost; steps that had ended are kept.
    InputError
        Where there is no orbit, or the law does not keep the lock; nothing is written then. Whatever fails later is
        named under ``failed``, and margins.json holds what was finished before and after it.
    """
    begin = time.monotonic()
    check_folder(out)
    check_samples(samples)
    orbit = find_orbit(asked)
    point, law = f"{asked.sea}; {asked.controls}", f"law {asked.law_name}"
    stages = steps_of(asked) + 6
    stages += (MAP_COLUMNS + 1) + (TONGUE_COLUMNS + 1) + BASIN_COLUMNS + BORDER_STAGES if maps else 0
    stages += WATER_STAGES if water else 0
    content: dict[str, Any] = {**made(), "request": asked.record(), "orbit": measures.orbit_record(orbit)}
    content |= sea_record(sea)
    kept = Kept(content, out / "margins.json")
    drawn: list[str] = []
    step = steps_kept(asked, out)

    def draw(name: str, figure: Figure) -> None:
        save(figure, out / f"{name}.png")
        drawn.append(f"{name}.png")
        progress.advance()

    with (
        connected(scheduler) if scheduler is not None else nullcontext() as client,
        planned(out / RUNS, step.case, wanted_steps(asked, orbit, step, samples, maps)),
        Progress("margins", stages, quiet) as progress,
        styled(),
        beside(partial(map_all, asked, step), progress.advance) as mapped,
    ):
        if client is not None:
            measure_ahead(client, asked, orbit, step, samples, maps)
        alone_done = mapped.begin if maps else lambda: None
        constant, of_law, answer = measured(asked, orbit, samples, kept, progress.advance, alone_done, step)
        with kept.stage("multipliers"):
            named_law = law if asked.law is not None else ""
            draw("multipliers", draw_orbit.multipliers(orbit, answer.loop if answer else None, named_law, point))
        with kept.stage("linear_model_error"):
            figure, content["linear_model_error"] = draw_linear.linear_error(orbit, point)
            draw("linear_error", figure)
        with kept.stage("nyquist"):
            if answer is not None and (picture := draw_orbit.nyquist(answer, law, point)) is not None:
                draw("nyquist", picture)
        named = {"constant controls": constant, law: of_law}
        if cases := {name: case for name, case in named.items() if case is not None}:
            with kept.stage("robustness"):
                draw("robustness", draw_robustness.robustness(cases, point, asked.plant.parameters.length_scale))
        if maps:
            with kept.stage("maps"):
                pictures, content["maps"] = _drawn(asked, orbit.period, *mapped.result())
                for name, figure in pictures.items():
                    draw(name, figure)
        if water:
            with kept.stage("water"):
                draw("water", real_water(asked, point, kept, progress.advance))
    cells: DesignMargins | None = None
    with kept.stage("law.cells"):
        if (cells := design_margins(asked)) is not None:
            content["law"] = {**content.get("law", {}), "cells": cells.record()}
    with kept.stage("meaning"):
        content["meaning"] = meanings(asked, orbit, constant if asked.law is None else of_law, answer, cells)
        if words := content.get("water", {}).get("words"):
            content["meaning"]["real_water"] = words
    content["not_available"] = _missing(asked, orbit, answer, cells, kept.failed)
    content["figures"] = drawn
    content["seconds"] = round(time.monotonic() - begin, 1)
    kept.write()
    found = dict(plain(content))
    write_page(found, out)
    return found


def lock_map_report(
    asked: Request, axes: tuple[str, str], out: Path, quiet: bool = False, sea: Sea | None = None
) -> dict[str, Any]:
    """Map where lock exists over (cc, cg) or (wp, height); writes lockmap.json and lockmap.png into `out`.

    Parameters
    ----------
    asked : Request
        Device, wave and controls.
    axes : (str, str)
        ("cc", "cg") or ("wp", "height").
    out : Path
        Folder, made where it is missing.
    quiet : bool
        No progress.
    sea : Sea, optional
        The sea that the wave stands for.

    Returns
    -------
    dict
        What lockmap.json holds.

    Raises
    ------
    InputError
        For other axes, or an `out` that is no folder.
    """
    if axes not in AXES:
        mend = f"Choose {' or '.join(','.join(pair) for pair in AXES)}"
        raise InputError("axes", ",".join(axes), "these axes cannot be mapped", mend)
    check_folder(out)
    over_controls = axes == AXES[0]
    stages = (MAP_COLUMNS + BORDER_STAGES if over_controls else TONGUE_COLUMNS) + 1
    with Progress("lock map", stages, quiet) as progress, styled():
        with beside(partial(control_borders, asked, couplings(asked)), progress.advance) as bordered:
            if over_controls:
                bordered.begin()
            found = map_controls(asked, progress.advance) if over_controls else map_waves(asked, progress.advance)
            borders = bordered.result() if over_controls else ()
        save(draw_maps.orbit_map(asked, found, borders), out / "lockmap.png")
    content = {
        **made(),
        "request": asked.record(),
        **sea_record(sea),
        "map": found.record(),
        "borders": borders,
        "codes": {"0": "no orbit", "1": "an oscillation grows", "2": "stable"},
        "figures": ["lockmap.png"],
    }
    write_json(out / "lockmap.json", content)
    return dict(plain(content))


def sea_record(sea: Sea | None) -> dict[str, Any]:
    """What is told of the sea that a wave stands for; nothing where there is none."""
    if sea is None:
        return {}
    numbers = {"hs_m": sea.hs, "wp_rad_s": sea.wp, "heading_deg": sea.heading}
    return {"sea": {"words": in_a_line(sea), "wave": STANDS_FOR, **numbers}}


def check_folder(out: Path) -> None:
    """Refuse a path that is a file, before anything is computed."""
    if out.exists() and not out.is_dir():
        raise InputError("out", str(out), "is not a folder", "Give the name of a folder")


def steps_kept(asked: Request, out: Path) -> Steps:
    """Keep what is finished of a report: the maps know no law and no samples, and serve any report of the point."""
    point = (asked.plant, asked.wave, asked.cc, asked.cg, asked.sense)
    given = value_fingerprint(*point)
    return Steps(out / RUNS, given, MODULES, KINDS, f"{asked.sea}; {asked.controls}")


def wanted_steps(asked: Request, orbit: PeriodicOrbit, step: Steps, samples: int, maps: bool) -> list[Asked]:
    """Steps of a report that are kept, as far as its point allows them."""
    names = {name: name for name in MAPS} if maps else {}
    if orbit.status == "stable":
        names[of_constant(samples)] = "constant controls"
    if asked.law is not None and (known := law_fingerprint(asked.law)):
        names[of_a_law(known, samples)] = f"law {asked.law_name}"
    return [Asked(step, name, told) for name, told in names.items()]


def _drawn(
    asked: Request,
    period: float,
    controls: OrbitMap,
    waves: OrbitMap,
    cc: list[float],
    cg: list[float],
    basin: NDArray[np.float64],
    borders: tuple[Border, ...],
) -> tuple[dict[str, Figure], dict[str, Any]]:
    """Pictures and numbers over controls and waves."""
    pictures = {
        "lock_map": draw_maps.orbit_map(asked, controls, borders),
        "tongue": draw_maps.orbit_map(asked, waves),
        "heat_maps": draw_maps.heat_maps(asked, controls, waves, _spread(basin, cc, cg, controls), period),
    }
    numbers = {"controls": controls.record(), "borders": borders, "waves": waves.record()}
    return pictures, {**numbers, "basin": {"cc": cc, "cg": cg, "share": basin}}


def _missing(
    asked: Request,
    orbit: PeriodicOrbit,
    answer: LoopAnswer | None,
    cells: DesignMargins | None,
    failed: Mapping[str, str],
) -> list[dict[str, str]]:
    missing = dict(failed)
    if orbit.status == "unstable":
        missing["every margin of the constant controls"] = f"the locked orbit is unstable. {orbit.advice}"
    if asked.law is None:
        missing[LINEAR] = "no law was named"
    elif answer is None:
        missing[LINEAR] = "they failed"
    elif answer.margins is None:
        missing[LINEAR] = answer.unavailable if cells is None else f"{answer.unavailable}. {INSTEAD}"
    return [{"margin": name, "reason": reason} for name, reason in missing.items()]


def _spread(basin: NDArray[np.float64], cc: list[float], cg: list[float], grid: OrbitMap) -> NDArray[np.float64]:
    """Values of the nearest coarse point with an orbit, where the fine grid is stable."""
    i = np.argmin(np.abs(np.log(grid.first)[:, None] - np.log(cc)[None, :]), axis=1)
    j = np.argmin(np.abs(grid.second[:, None] - np.array(cg)[None, :]), axis=1)
    return np.where(grid.code == STABLE, basin[np.ix_(j, i)], np.nan)
