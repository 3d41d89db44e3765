"""Borders of lock as exact curves, by continuation: folds and Neimark-Sacker points where stability is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.bifurcation import BifurcationCurve, curve
from gyroctl.linearisation.continuation import continue_orbit
from gyroctl.linearisation.lockmap import OPTIONS, lock_map, tongue
from gyroctl.linearisation.orbit import PeriodicOrbit
from gyroctl.studies.margins.maps import OrbitMap
from gyroctl.studies.margins.request import Request


@dataclass(frozen=True)
class Border:
    """A curve over the axes of a map.

    Parameters
    ----------
    kind : str
        "fold", "Neimark-Sacker", ...
    x, y : (n,) arrays
        Along the axes of the map; NaN separates pieces.
    """

    kind: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {"kind": self.kind, "x": self.x, "y": self.y}


def control_borders(asked: Request, cc: tuple[float, float], tick: Callable[[], None]) -> tuple[Border, ...]:
    """Borders over (cc, cg); none where continuation finds no start."""
    try:
        found = lock_map(asked.plant, asked.wave, cc, asked.sense, progress=lambda _: tick())
    except InputError:
        return ()
    return tuple(_border(each, ("cc", "cg")) for each in (found.fold, *found.neimark_sacker))


def wave_borders(orbit: PeriodicOrbit, asked: Request, grid: OrbitMap, tick: Callable[[], None]) -> tuple[Border, ...]:
    """Borders over (wp, height) within a grid; none where continuation finds no start."""
    wp = float(grid.first[0]), float(grid.first[-1])
    height = float(grid.second[0]), float(grid.second[-1])
    curves: list[BifurcationCurve] = []
    try:
        curves.append(tongue(asked.plant, asked.wave, asked.cc, asked.cg, wp, height[1], asked.sense))
        tick()
        branch = continue_orbit(orbit, "wp", wp, OPTIONS)
        pairs = [point for point in branch.points if point.kind == "Neimark-Sacker"]
        curves += [curve(point, "height", height, OPTIONS, first_limits=wp) for point in pairs[:2]]
    except InputError:
        pass
    tick()
    return tuple(_border(each, ("wp", "height")) for each in curves)


def _border(found: BifurcationCurve, axes: tuple[str, str]) -> Border:
    """Where stability is lost: a part on which something else is unstable already is left out, but not of a fold."""
    values = dict(zip(found.parameters, (found.first, found.second), strict=True))
    x, y = (values[name].copy() for name in axes)
    if found.kind != "fold":
        hidden = found.others > 1.0 + 1e-9
        x[hidden], y[hidden] = np.nan, np.nan
    return Border(found.kind, x, y)
