"""What coincides: curves that are one line, and laws that are another law with nothing done to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports import layout

if TYPE_CHECKING:
    import xarray as xr

ACTS = ("starts", "pulls", "catches", "unloads")
"""What a supervisor counts of what it did."""

WITHIN = "law_"
"""Beginning of the parameters of a law within another, as a supervisor lists them."""


def groups(curves: Sequence[NDArray[np.float64]]) -> list[list[int]]:
    """Indices of curves that are equal, number for number, in the order of the first of each."""
    found: dict[bytes, list[int]] = {}
    for k, curve in enumerate(curves):
        found.setdefault(np.asarray(curve, dtype=np.float64).tobytes(), []).append(k)
    return list(found.values())


def idle_wrappers(ds: xr.Dataset) -> dict[str, str]:
    """Laws that wrap another one and never did anything, with the law whose runs theirs are.

    A law is one if its parameters hold those of another law within (``law_...``), if it counted no act of its own, and
    if every result of every run is that of another law which wraps none.
    """
    parameters = layout.read_json(ds, "parameters", {})
    names = layout.names(ds)
    acted = sum(np.nan_to_num(layout.values(ds, act)).sum(axis=1) for act in ACTS)
    results = np.stack([layout.values(ds, variable) for variable in layout.REQUIRED], axis=1)
    wraps = {name for name in names if isinstance(parameters, dict) and _wraps(parameters.get(name))}
    found = {}
    for name in sorted(wraps, key=names.index):
        k = names.index(name)
        if np.any(np.asarray(acted)[k]) or not np.any(np.isfinite(results[k])):
            continue
        same = (
            other
            for other, row in zip(names, results, strict=True)
            if other not in wraps and np.array_equal(row, results[k], equal_nan=True)
        )
        within = next(same, None)
        if within is not None:
            found[name] = within
    return found


def _wraps(parameters: object) -> bool:
    return isinstance(parameters, dict) and any(str(name).startswith(WITHIN) for name in parameters)
