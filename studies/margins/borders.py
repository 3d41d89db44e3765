"""Borders of lock as exact curves, by continuation: folds and Neimark-Sacker points where stability is lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.orbits.bifurcation import BifurcationCurve
from gyroctl.orbits.lock_map import lock_map
from gyroctl.studies.margins.request import Request


class Border(NamedTuple):
    """A curve over the axes of a map."""

    kind: str  # "fold", "Neimark-Sacker", ...
    x: NDArray[np.float64]  # (n,) along the axes of the map; NaN separates pieces
    y: NDArray[np.float64]


def control_borders(asked: Request, cc: tuple[float, float], tick: Callable[[], None]) -> tuple[Border, ...]:
    """Borders over (cc, cg); none where continuation finds no start."""
    try:
        found = lock_map(asked.plant, asked.wave, cc, asked.sense, progress=lambda _: tick())
    except InputError:
        return ()
    return tuple(_border(each) for each in (found.fold, *found.neimark_sacker))


def _border(found: BifurcationCurve) -> Border:
    """Where stability is lost: a part on which something else is unstable already is left out, but not of a fold."""
    values = dict(zip(found.parameters, (found.first, found.second), strict=True))
    x, y = values["cc"].copy(), values["cg"].copy()
    if found.kind != "fold":
        hidden = found.others > 1.0 + 1e-9
        x[hidden], y[hidden] = np.nan, np.nan
    return Border(found.kind, x, y)
