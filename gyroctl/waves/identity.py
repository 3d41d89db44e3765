"""Content hash of a realisation: what a comparison checks before it calls two runs comparable."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.waves.components import Sea
from gyroctl.waves.grid import TimeGrid

FORMAT = "gyroctl waves 1"
"""Goes into every hash; changes with the meaning of what is hashed."""


def content_hash(sea: Sea, phases: NDArray[np.float64], hydrodynamics: str, grid: TimeGrid, blend: float = 0.0) -> str:
    """SHA-256 of everything a realisation follows from.

    The inputs are hashed, not the moments: their last bits come from the processor's own sine and FFT and may differ
    between machines, while phases, parameters and tables are the same everywhere. The seed is left out: seeds that
    give the same waves have the same hash.

    Parameters
    ----------
    sea : any sea of this package
        Kind and parameters, heading included; a user's table or record enters by its own digest.
    phases : ndarray, shape (k,)
        Phases drawn from the seed. [rad]
    hydrodynamics : str
        Hash of the excitation.
    grid : TimeGrid
        Period, step and number of instants.
    blend : float
        Length of the blend from the regular wave. [s]

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    parameters = {item.name: _exact(getattr(sea, item.name)) for item in fields(sea) if item.compare}
    head = {
        "format": FORMAT,
        "sea": {"kind": type(sea).__name__, **parameters},
        "hydrodynamics": hydrodynamics,
        "grid": {"period": _exact(grid.period), "dt": _exact(grid.dt), "n": grid.n},
        "blend": _exact(blend),
        "phases": phases.size,
    }
    content = hashlib.sha256(json.dumps(head, sort_keys=True).encode())
    content.update(np.ascontiguousarray(phases, dtype="<f8").tobytes())
    return content.hexdigest()


def _exact(value: object) -> str:
    """Write a value without rounding: a number, a text, several numbers, or a sea within a sea."""
    if is_dataclass(value) and not isinstance(value, type):
        inner = {item.name: _exact(getattr(value, item.name)) for item in fields(value) if item.compare}
        return json.dumps({"kind": type(value).__name__, **inner}, sort_keys=True)
    if isinstance(value, tuple):
        return " ".join(_exact(entry) for entry in value)
    return value if isinstance(value, str) else float(value).hex()  # type: ignore[arg-type]
