"""Solvers of the planning problem: Riccati recursions, projected gradients, OSQP as the baseline."""

from __future__ import annotations

from pathlib import Path

from gyroctl.controllers.nmpc import problem
from gyroctl.plant import fused, row_sums

SOURCES = (
    *problem.SOURCES,
    fused.__file__,
    row_sums.__file__,
    *sorted(str(file) for file in Path(__file__).parent.glob("*.py")),
)
"""Files that are compiled into the solvers: their text makes the stamp of what numba keeps."""
