"""The maps of a report: how far they reach, how fine they are, and the steps in which they are made."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.engine.steps import Steps
from gyroctl.froude import at_length
from gyroctl.orbits.flow import Forcing
from gyroctl.orbits.guess import estimated_share
from gyroctl.studies.margins.borders import Border, control_borders
from gyroctl.studies.margins.maps import OrbitMap, basin_map, coupling_map, tongue_map
from gyroctl.studies.margins.request import Request

CC_RANGE = (0.01, 0.3)
"""Of the lock map, at the size of Table 1. [Nms]"""

ABOVE = 1.15
"""Top of the lock map over the capacity that harmonic balance gives."""

MAPS = ("lock map", "tongue", "basin map", "borders")
"""Names of its steps that know no law."""

MAP_COLUMNS, MAP_ROWS = 14, 22
TONGUE_COLUMNS, TONGUE_ROWS = 15, 18
BASIN_COLUMNS, BASIN_ROWS = 5, 6
BASIN_SIZE, BASIN_SAMPLES = 0.5, 24
"""Size of the disturbances, as a part of the largest, and their number, at each place of the basin map."""

BORDER_STAGES = 8
"""Stages of the continuation, about."""


def couplings(asked: Request) -> tuple[float, float]:
    """Range of the lock map. [Nms]"""
    return at_length(CC_RANGE, "Nms", asked.plant.parameters.length_scale)


def map_controls(asked: Request, tick: Callable[[], None]) -> OrbitMap:
    """Lock map from cg near zero to above the fold."""
    plant, wave = asked.plant, asked.wave
    amplitude = 0.5 * wave.height * plant.excitation(np.array([wave.wp]), wave.heading)[:, 0]
    top = ABOVE * asked.cg / estimated_share(plant, Forcing(amplitude, wave.wp), asked.cg, asked.sense)
    cc = np.geomspace(*couplings(asked), MAP_COLUMNS)
    return coupling_map(plant, wave, list(cc), list(np.linspace(0.02 * top, top, MAP_ROWS)), asked.sense, tick)


def map_waves(asked: Request, tick: Callable[[], None]) -> OrbitMap:
    """Tongue about the wave: 0.65 to 1.6 times its frequency, 0.05 to 3 times its height."""
    plant, wave = asked.plant, asked.wave
    low, high = plant.excitation.omega[[0, -1]]
    wp = np.linspace(max(0.65 * wave.wp, 1.01 * low), min(1.6 * wave.wp, 0.99 * high), TONGUE_COLUMNS)
    height = np.geomspace(0.05, 3.0, TONGUE_ROWS) * wave.height
    return tongue_map(plant, asked.cc, asked.cg, list(wp), list(height), asked.sense, wave.heading, tick)


class Mapped(NamedTuple):
    """Maps over controls and waves."""

    controls: OrbitMap
    waves: OrbitMap
    cc: list[float]  # (n,) of the basin map [Nms]
    cg: list[float]  # (m,)
    basin: NDArray[np.float64]  # (m, n)
    borders: tuple[Border, ...]


def map_all(asked: Request, step: Steps, tick: Callable[[], None]) -> Mapped:
    """Make all maps, or find those that are kept."""
    lock, tongue, basins, borders = MAPS
    controls = step(lock, lambda: map_controls(asked, tick))
    waves = step(tongue, lambda: map_waves(asked, tick))
    cc, cg = thinned(controls.first, BASIN_COLUMNS), thinned(controls.second, BASIN_ROWS)
    basin = step(basins, lambda: basin_map(asked, cc, cg, BASIN_SIZE, BASIN_SAMPLES, tick))
    return Mapped(controls, waves, cc, cg, basin, step(borders, lambda: control_borders(asked, couplings(asked), tick)))


def thinned(values: NDArray[np.float64], count: int) -> list[float]:
    """Coarser grid, for what is costly."""
    return [float(v) for v in values[np.linspace(0, values.size - 1, count).round().astype(int)]]
