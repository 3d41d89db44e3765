"""Constant pairs over many realisations from the common start: the compiled ensemble with the default start."""

from __future__ import annotations

import os
from collections.abc import Sequence

from gyroctl.harness.start import locked_start
from gyroctl.plant import Plant
from gyroctl.simulation.ensemble import EnsembleRun, run_ensemble
from gyroctl.waves import Sea


def scan(
    plant: Plant,
    sea: Sea,
    pairs: Sequence[tuple[float, float]],
    seeds: Sequence[int],
    duration: float = 2000.0,
    blend: float = 100.0,
    dt: float = 0.01,
    workers: int | None = None,
    title: str = "scan",
    quiet: bool = False,
) -> EnsembleRun:
    """Simulate every constant pair (cc, cg) [Nms] on every realisation, started on the locked orbit.

    Parameters, results and errors are those of `gyroctl.simulation.run_ensemble`; `workers` defaults to all cores.
    """
    start, _ = locked_start(plant, sea)
    return run_ensemble(
        plant,
        sea,
        pairs,
        seeds,
        start,
        duration,
        blend,
        dt,
        workers=workers or os.cpu_count() or 1,
        title=title,
        quiet=quiet,
    )
