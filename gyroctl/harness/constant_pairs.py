"""Constant pairs over many realisations from the common start: the compiled ensemble with the default start."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import get_args

from gyroctl.errors import check_kind
from gyroctl.harness.arguments import check_plant
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
    dt: float | None = None,
    workers: int | None = None,
    title: str = "scan",
    quiet: bool = False,
    ledger: bool = True,
) -> EnsembleRun:
    """Simulate every constant pair (cc, cg) [Nms] on every realisation, started on the locked orbit.

    Parameters, results and errors are those of `gyroctl.simulation.run_ensemble`; `workers` defaults to all cores.

    Parameters
    ----------
    plant : Plant
        The device.
    sea : Sea
        The sea.
    pairs : sequence of (cc, cg)
        Constant controls. [Nms]
    seeds : sequence of int
        Realisations.
    duration : float
        Length of the runs. [s]
    blend : float
        Blend from the regular wave; scoring starts after it. [s]
    dt : float, optional
        Longest integration step. [s]
    workers : int, optional
        Threads; all cores by default. They change no result.
    title : str
        Of the progress line.
    quiet : bool
        No progress.
    ledger : bool
        Whether the energy ledger is kept.

    Returns
    -------
    EnsembleRun
        Arrays (pairs, seeds).

    Raises
    ------
    InputError
        As `gyroctl.simulation.run_ensemble`.
    """
    check_plant(plant)
    check_kind("sea", sea, get_args(Sea), "a sea", "Give a sea, for example gyroctl.SeaState()")
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
        ledger=ledger,
    )
