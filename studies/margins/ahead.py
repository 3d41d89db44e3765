"""The steps of a margin report on the workers of a scheduler: those that wait for nothing, and then the basins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cloudpickle
import numpy as np
from numpy.typing import NDArray

from gyroctl.engine.ahead import Piece, do_ahead
from gyroctl.engine.steps import Steps
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.travelling import by_value, modules_of
from gyroctl.linearisation import PeriodicOrbit
from gyroctl.studies.margins import measures
from gyroctl.studies.margins.borders import Border, control_borders
from gyroctl.studies.margins.mapped import (
    BASIN_COLUMNS,
    BASIN_ROWS,
    BASIN_SAMPLES,
    BASIN_SIZE,
    MAPS,
    couplings,
    map_controls,
    map_waves,
    thinned,
)
from gyroctl.studies.margins.maps import OrbitMap, basin_map
from gyroctl.studies.margins.measures import Margins
from gyroctl.studies.margins.measuring import of_a_law, of_constant
from gyroctl.studies.margins.request import Request, find_orbit


def measure_ahead(client: Any, asked: Request, orbit: PeriodicOrbit, step: Steps, samples: int, maps: bool) -> None:
    """Let the workers do the steps of a report that are kept; what they make is found when it is asked for."""
    point = replace(asked, law=None, law_name="")  # a law travels by its content, and the maps know none
    lock, tongue, basins, borders = MAPS
    pieces = []
    if asked.law is not None and (known := law_fingerprint(asked.law)):
        given = (point, by_value(asked.law), asked.law_name, samples)
        pieces.append(Piece(step, of_a_law(known, samples), law_there, given, tuple(modules_of(asked.law))))
    if orbit.status == "stable":
        pieces.append(Piece(step, of_constant(samples), constant_there, (point, samples)))
    if maps:
        there = {lock: controls_there, borders: borders_there, tongue: waves_there}
        pieces += [Piece(step, name, do, (point,)) for name, do in there.items()]
    do_ahead(client, pieces)
    if maps and isinstance(controls := step.kept(lock), OrbitMap):
        grid = (thinned(controls.first, BASIN_COLUMNS), thinned(controls.second, BASIN_ROWS))
        do_ahead(client, [Piece(step, basins, basins_there, (point, *grid))])


def law_there(point: Request, law: bytes, name: str, samples: int) -> Margins:
    """Margins of a law, which is packed."""
    asked = replace(point, law=cloudpickle.loads(law), law_name=name)
    return measures.law_margins(measures.law_regime(find_orbit(asked), asked), samples, _quiet)


def constant_there(point: Request, samples: int) -> Margins:
    """Margins of the constant controls."""
    return measures.constant_margins(find_orbit(point), point, samples, _quiet)


def controls_there(point: Request) -> OrbitMap:
    """Lock map over the controls."""
    return map_controls(point, _quiet)


def waves_there(point: Request) -> OrbitMap:
    """Tongue over the waves."""
    return map_waves(point, _quiet)


def borders_there(point: Request) -> tuple[Border, ...]:
    """Borders of lock over the controls."""
    return control_borders(point, couplings(point), _quiet)


def basins_there(point: Request, cc: list[float], cg: list[float]) -> NDArray[np.float64]:
    """Share of disturbances after which lock returns, over the controls."""
    return basin_map(point, cc, cg, BASIN_SIZE, BASIN_SAMPLES, _quiet)


def _quiet() -> None:
    """Tell nobody."""
