"""The margin report: measure, draw, write. And the lock map by itself."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import gyroctl
from gyroctl.errors import InputError
from gyroctl.linearisation import PeriodicOrbit
from gyroctl.orbits.guess import estimated_share
from gyroctl.plant import Plant
from gyroctl.simulation.progress import Progress
from gyroctl.studies.margins.borders import control_borders
from gyroctl.studies.margins.maps import OrbitMap, basin_map, coupling_map, tongue_map
from gyroctl.studies.margins.measures import (
    DIRECTIONS,
    SIZES,
    LoopAnswer,
    Margins,
    constant_margins,
    law_margins,
    law_regime,
    linear_margins,
    orbit_record,
)
from gyroctl.studies.margins.request import Request, find_orbit
from gyroctl.studies.margins.words import meanings
from gyroctl.studies.style import save
from gyroctl.waves import Regular
from gyroctl.writing import plain, write_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CC_RANGE = (0.01, 0.3)
"""Of the lock map. [Nms]"""

ABOVE = 1.15
"""Top of the lock map over the capacity that harmonic balance gives."""

LINEAR = "gain, phase, delay and disk margins"

AXES = (("cc", "cg"), ("wp", "height"))
"""Pairs of axes that can be mapped."""


def margin_report(
    asked: Request, out: Path, samples: int = 128, maps: bool = True, quiet: bool = False
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

    Returns
    -------
    dict
        What margins.json holds.

    Raises
    ------
    InputError
        Where there is no orbit, or the law does not keep the lock; nothing is written then.
    """
    from gyroctl.studies.margins import draw_linear, draw_maps, draw_orbit, draw_robustness
    from gyroctl.studies.style import styled

    begin = time.monotonic()
    check_folder(out)
    if samples < 1:
        raise InputError("samples", samples, "must be at least 1", "Give the number of disturbances, for example 128")
    orbit = find_orbit(asked)
    point = _point(asked)
    measured = len(DIRECTIONS) + len(SIZES) + 1
    columns = (MAP_COLUMNS + 1) + (TONGUE_COLUMNS + 1) + BASIN_COLUMNS + BORDER_STAGES if maps else 0
    drawn: dict[str, Figure] = {}
    content: dict[str, Any] = {
        "gyroctl_version": gyroctl.__version__,
        "request": asked.record(),
        "orbit": orbit_record(orbit),
    }
    with Progress("margins", measured * (2 if asked.law else 1) + columns + 6, quiet) as progress, styled():

        def stage(_: str) -> None:
            progress.advance()

        cases: dict[str, Margins] = {}
        answer: LoopAnswer | None = None
        if asked.law is not None:
            regime = law_regime(orbit, asked)  # first: it refuses a law that does not keep the lock
        if orbit.status == "stable":
            cases["constant controls"] = constant_margins(orbit, asked, samples, stage)
            content["constant_controls"] = cases["constant controls"].record()
        if asked.law is not None:
            cases[f"law {asked.law_name}"] = law_margins(regime, samples, stage)
            answer = _linear(orbit, asked)
            progress.advance()
            content["law"] = {**cases[f"law {asked.law_name}"].record(), "linear": answer.record()}
        drawn["multipliers"] = draw_orbit.multipliers(orbit, answer.loop if answer else None, asked.law_name, point)
        drawn["linear_error"], content["linear_model_error"] = draw_linear.linear_error(orbit, point)
        if answer is not None and (picture := draw_orbit.nyquist(answer, asked.law_name, point)) is not None:
            drawn["nyquist"] = picture
        if cases:
            drawn["robustness"] = draw_robustness.robustness(cases, point)
        if maps:
            controls = map_controls(asked.plant, asked.wave, asked.sense, asked.cg, progress.advance)
            waves = map_waves(asked.plant, asked.cc, asked.cg, asked.wave, asked.sense, progress.advance)
            coarse = _coarse(controls)
            basin = basin_map(asked.plant, asked.wave, *coarse, 0.5, 24, asked.sense, progress.advance)
            on_grid = _spread(basin, coarse, controls)
            borders = control_borders(asked, CC_RANGE, progress.advance)
            drawn["lock_map"] = draw_maps.orbit_map(
                controls,
                "Lock map",
                f"{_wave(asked)}; contours: mean power",
                (asked.cc, asked.cg),
                asked.sense,
                borders,
            )
            drawn["tongue"] = draw_maps.orbit_map(
                waves,
                "Tongue of lock",
                f"cc = {asked.cc:g}, cg = {asked.cg:g} Nms; contours: mean power",
                (asked.wave.wp, asked.wave.height),
                asked.sense,
            )
            marks = ((asked.cc, asked.cg), (asked.wave.wp, asked.wave.height))
            drawn["heat_maps"] = draw_maps.heat_maps(
                controls,
                waves,
                on_grid,
                marks,
                orbit.period,
                f"above: {_wave(asked)}; below: cc = {asked.cc:g}, cg = {asked.cg:g} Nms; star: asked for; "
                "crosses: lock, but an oscillation grows; basin: 24 disturbances of half the largest size",
            )
            content["maps"] = {
                "controls": controls.record(),
                "borders": [border.record() for border in borders],
                "waves": waves.record(),
                "basin": {"cc": coarse[0], "cg": coarse[1], "share": basin},
            }
        content["meaning"] = meanings(asked, orbit, list(cases.values())[-1] if cases else None, answer)
        content["not_available"] = _missing(asked, orbit, answer)
        out.mkdir(parents=True, exist_ok=True)
        for name, figure in drawn.items():
            save(figure, out / f"{name}.png")
            progress.advance()
    content["figures"] = [f"{name}.png" for name in drawn]
    content["seconds"] = round(time.monotonic() - begin, 1)
    write_json(out / "margins.json", content)
    return dict(plain(content))


def lock_map_report(asked: Request, axes: tuple[str, str], out: Path, quiet: bool = False) -> dict[str, Any]:
    """Map where lock exists over (cc, cg) or (wp, height); writes lockmap.json and lockmap.png into `out`.

    Raises
    ------
    InputError
        For other axes, or an `out` that is no folder.
    """
    from gyroctl.studies.margins import draw_maps
    from gyroctl.studies.style import styled

    if axes not in AXES:
        raise InputError(
            "axes",
            ",".join(axes),
            "these axes cannot be mapped",
            f"Choose {' or '.join(','.join(pair) for pair in AXES)}",
        )
    check_folder(out)
    over_controls = axes == AXES[0]
    stages = (MAP_COLUMNS + BORDER_STAGES if over_controls else TONGUE_COLUMNS) + 1
    with Progress("lock map", stages, quiet) as progress, styled():
        if over_controls:
            found = map_controls(asked.plant, asked.wave, asked.sense, asked.cg, progress.advance)
            borders = control_borders(asked, CC_RANGE, progress.advance)
            title, note, mark = "Lock map", _wave(asked), (asked.cc, asked.cg)
        else:
            found = map_waves(asked.plant, asked.cc, asked.cg, asked.wave, asked.sense, progress.advance)
            borders = ()
            title, note = "Tongue of lock", f"cc = {asked.cc:g}, cg = {asked.cg:g} Nms"
            mark = asked.wave.wp, asked.wave.height
        figure = draw_maps.orbit_map(found, title, f"{note}; contours: mean power", mark, asked.sense, borders)
        out.mkdir(parents=True, exist_ok=True)
        save(figure, out / "lockmap.png")
    content = {
        "gyroctl_version": gyroctl.__version__,
        "request": asked.record(),
        "map": found.record(),
        "borders": [border.record() for border in borders],
        "codes": {"0": "no orbit", "1": "an oscillation grows", "2": "stable"},
        "figures": ["lockmap.png"],
    }
    write_json(out / "lockmap.json", content)
    return dict(plain(content))


MAP_COLUMNS, MAP_ROWS = 14, 22
TONGUE_COLUMNS, TONGUE_ROWS = 15, 18
BASIN_COLUMNS = 5
BORDER_STAGES = 8
"""Stages of the continuation, about."""


def map_controls(plant: Plant, wave: Regular, sense: int, cg: float, tick: Any) -> OrbitMap:
    """Lock map from cg near zero to above the fold."""
    from gyroctl.orbits.flow import Forcing

    amplitude = 0.5 * wave.height * plant.excitation(np.array([wave.wp]), wave.heading)[:, 0]
    top = ABOVE * cg / estimated_share(plant, Forcing(amplitude, wave.wp), cg, sense)
    cc = np.geomspace(*CC_RANGE, MAP_COLUMNS)
    return coupling_map(plant, wave, list(cc), list(np.linspace(0.02 * top, top, MAP_ROWS)), sense, tick)


def map_waves(plant: Plant, cc: float, cg: float, wave: Regular, sense: int, tick: Any) -> OrbitMap:
    """Tongue about the wave: 0.65 to 1.6 times its frequency, 0.05 to 3 times its height."""
    low, high = plant.excitation.omega[[0, -1]]
    wp = np.linspace(max(0.65 * wave.wp, 1.01 * low), min(1.6 * wave.wp, 0.99 * high), TONGUE_COLUMNS)
    height = np.geomspace(0.05, 3.0, TONGUE_ROWS) * wave.height
    return tongue_map(plant, cc, cg, list(wp), list(height), sense, wave.heading, tick)


def check_folder(out: Path) -> None:
    """Refuse a path that is a file, before anything is computed."""
    if out.exists() and not out.is_dir():
        raise InputError("out", str(out), "is not a folder", "Give the name of a folder")


def _linear(orbit: PeriodicOrbit, asked: Request) -> LoopAnswer:
    assert asked.law is not None
    if asked.law.information == "none":
        return LoopAnswer(None, None, "the law feeds nothing back: no gain or delay of it can break the lock")
    return linear_margins(orbit, asked)


def _missing(asked: Request, orbit: PeriodicOrbit, answer: LoopAnswer | None) -> list[dict[str, str]]:
    missing = []
    if orbit.status == "unstable":
        missing.append(
            {
                "margin": "every margin of the constant controls",
                "reason": f"the locked orbit is unstable. {orbit.advice}",
            }
        )
    if answer is not None and answer.margins is None:
        missing.append({"margin": LINEAR, "reason": answer.unavailable})
    if asked.law is None:
        missing.append({"margin": LINEAR, "reason": "no law was named"})
    return missing


def _coarse(grid: OrbitMap) -> tuple[list[float], list[float]]:
    """Coarser grid, for what is costly."""
    columns = np.linspace(0, grid.first.size - 1, BASIN_COLUMNS).round().astype(int)
    rows = np.linspace(0, grid.second.size - 1, 6).round().astype(int)
    return [float(v) for v in grid.first[columns]], [float(v) for v in grid.second[rows]]


def _spread(basin: Any, coarse: tuple[list[float], list[float]], grid: OrbitMap) -> Any:
    """Values of the nearest coarse point with an orbit, where the fine grid is stable."""
    cc, cg = (np.array(values) for values in coarse)
    i = np.argmin(np.abs(np.log(grid.first)[:, None] - np.log(cc)[None, :]), axis=1)
    j = np.argmin(np.abs(grid.second[:, None] - cg[None, :]), axis=1)
    return np.where(grid.code == 2, basin[np.ix_(j, i)], np.nan)


def _wave(asked: Request) -> str:
    return f"wave of {asked.wave.height:g} m at {asked.wave.wp:g} rad/s"


def _point(asked: Request) -> str:
    return f"{_wave(asked)}; cc = {asked.cc:g}, cg = {asked.cg:g} Nms"
