"""The fair comparison: several laws on identical realisations, as one labelled dataset."""

from __future__ import annotations

import datetime
import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.comparison.execution import execute
from gyroctl.comparison.items import COUNTERS, Outcome, Realisations, check_different, work_items
from gyroctl.errors import InputError, check_kind
from gyroctl.harness.arguments import check_plant, laws_by_name
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, checked_settings, ticks_of
from gyroctl.harness.run_size import run_size
from gyroctl.plant import Plant
from gyroctl.provenance import provenance
from gyroctl.simulation.metrics import UNITS
from gyroctl.waves import WaveRealisation
from gyroctl.waves.checks import positive, whole, within

if TYPE_CHECKING:
    import xarray

__all__ = ["Realisations", "check_fair", "compare"]

Rows = Mapping[str, Sequence[Outcome]]
"""Outcomes of each law, in the order of the seeds."""

WORKERS_MAX = 1024
"""More threads or processes than any machine has that this is meant for."""

VARIABLES = {**UNITS, "saturations": "1", "step_ms_median": "ms", "step_ms_p99": "ms", **dict.fromkeys(COUNTERS, "1")}
EXAMPLES = {
    "power": "W",
    "ring_speed": "rad/s",
    "phi1": "rad",
    "phi3": "rad",
    "cc": "Nms",
    "cg": "Nms",
    "load_share": "1",
}


def compare(
    plant: Plant,
    laws: Mapping[str, Law | str] | Sequence[str],
    waves: Realisations | Sequence[WaveRealisation],
    settings: Settings | None = None,
    workers: int | None = None,
    results: Path | None = None,
    tuning_seeds: Sequence[int] = (),
    experiment: Mapping[str, Any] | None = None,
    motion_limit: float = 0.35,
    quiet: bool = False,
) -> xarray.Dataset:
    """Compare laws on identical realisations.

    Parameters
    ----------
    plant : Plant
        The device.
    laws : mapping of str to Law or str
        Laws by the names that they get in the result; instead of a law also its registered name, or a list of those.
    waves : Realisations, or realisations of one sea from `realise`
        The waves, the same for every law.
    settings : Settings, optional
        Steps, blend, sensors, actuators.
    workers : int, optional
        Threads (compiled laws) or processes (others); by default all cores. It changes no bit of the result.
    results : Path, optional
        Folder of stored results; finished runs found there are not computed again.
    tuning_seeds : sequence of int
        Seeds on which the laws were tuned. None may be evaluated on.
    experiment : mapping, optional
        The experiment as it was asked for, kept in the result.
    motion_limit : float
        Limit of the 98 % motion. [rad]
    quiet : bool
        Show no progress.

    Returns
    -------
    xarray.Dataset
        Dimensions law and realisation; the variables of `metrics.UNITS` and more, and the time series of the first
        realisation as ``example_...``.

    Raises
    ------
    InputError
        For no law, seeds that repeat or overlap the tuning seeds, waves that differ, and whatever a run refuses.
    LawError
        Where a law breaks the protocol.
    """
    check_plant(plant)
    settings, built = checked_settings(settings), laws_by_name(laws)
    if not isinstance(waves, Realisations):
        waves = _from_realisations(waves)
    if not built:
        raise InputError("laws", {}, "there is nothing to compare", "Give at least one law")
    check_workers(workers)
    check_motion_limit(motion_limit)
    run_size(waves.duration, settings.dt, settings.actuators.period)
    _check_seeds(waves.seeds, tuning_seeds)
    check_length(waves.duration, settings.score_from)
    for name, law in built.items():
        ticks_of(law, name, settings.actuators)
    items = work_items(plant, built, waves, settings)
    outcomes = execute(items, workers or os.cpu_count() or 1, results, quiet)
    rows = {name: [outcomes[name, seed] for seed in waves.seeds] for name in built}
    check_fair(rows)
    return _dataset(built, waves, rows).assign_attrs(
        experiment=json.dumps(experiment or _default_experiment(plant, waves, settings)),
        **_attributes(provenance()),
        created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        tuning_seeds=json.dumps(sorted(int(seed) for seed in tuning_seeds)),
        parameters=json.dumps({name: describe(law) for name, law in built.items()}),
        duration=waves.duration,
        blend=settings.score_from,
        start=settings.start,
        motion_limit=motion_limit,
        plant=plant.name,
        wp=waves.sea.wp,
        hs=waves.sea.hs,
        capture_width_m=plant.parameters.d + plant.parameters.c,
    )


def check_workers(workers: int | None) -> None:
    """Refuse a number of workers that no machine has."""
    if workers is not None:
        whole("workers", workers, 0, WORKERS_MAX, "Give a number of threads or processes; 0 or none for all cores")


def check_motion_limit(limit: float) -> None:
    """Refuse a limit of the motion that is no angle."""
    positive("run.motion_limit", limit, "Give an angle in rad, for example 0.35")
    within("run.motion_limit", limit, 0.0, 0.5 * math.pi, "Give an angle in rad, for example 0.35")


def check_length(duration: float, blend: float) -> None:
    """Refuse runs that end before their scoring begins."""
    if not duration > blend:
        mend = "Give a longer duration, or a shorter run.blend"
        raise InputError("run.duration", duration, f"is not longer than the blend of {blend:g} s", mend)


def check_fair(rows: Rows) -> None:
    """Refuse a comparison of runs on different waves, or of waves that are the same for several seeds."""
    first, *others = rows
    hashes = [outcome.sha256 for outcome in rows[first]]
    for name in others:
        for number, (outcome, expected) in enumerate(zip(rows[name], hashes, strict=True), 1):
            if outcome.sha256 != expected:
                problem = f"realisation {number} differs from that of {first} ({expected[:12]})"
                mend = "Compare runs on identical waves only: run all laws together, or empty the folder of results"
                raise InputError(f"laws.{name}", outcome.sha256[:12], problem, mend)
    check_different(hashes)


def _from_realisations(waves: Sequence[WaveRealisation]) -> Realisations:
    mend = "Give [gyroctl.realise(plant, sea, seed), ...], or Realisations(sea, seeds)"
    if isinstance(waves, WaveRealisation):
        waves = [waves]
    check_kind("waves", waves, Sequence, "a list of realisations", mend)
    for each in waves:
        check_kind("waves", each, WaveRealisation, "a realisation", mend)
    if not waves:
        raise InputError("waves", [], "there are no realisations", "Give at least one, see gyroctl.realise")
    first = waves[0]
    for other in waves:
        if (other.sea, other.duration, other.dt) != (first.sea, first.duration, first.dt):
            problem = "realisations of different seas, lengths or grids"
            raise InputError("waves", other.sha256[:12], problem, "Compare on one sea at a time")
    return Realisations(first.sea, tuple(w.seed for w in waves), first.duration, first.dt)


def _check_seeds(seeds: Sequence[int], tuning_seeds: Sequence[int]) -> None:
    if not seeds:
        raise InputError("run.seeds", list(seeds), "there are no realisations", "Give at least one seed")
    if len(set(seeds)) < len(seeds):
        raise InputError("run.seeds", list(seeds), "a seed repeats", "Give each seed once")
    overlap = sorted(set(seeds) & set(tuning_seeds))
    if overlap:
        problem = "these seeds were used for tuning and cannot judge the result"
        raise InputError("run.seeds", overlap, problem, "Choose others, for example 1 to 64")


def _dataset(laws: Mapping[str, Law], waves: Realisations, rows: Rows) -> xarray.Dataset:
    import xarray as xr

    names = list(laws)
    data: dict[str, Any] = {}
    for variable, unit in VARIABLES.items():
        values = np.array([[outcome.values[variable] for outcome in rows[name]] for name in names])
        if variable in ("locked", "outside_model"):
            values = values.astype(bool)
        attrs = {"units": unit, "long_name": variable.replace("_", " ")}
        data[variable] = (("law", "realisation"), values, attrs)
    examples = [rows[name][0].series for name in names]
    for variable, unit in EXAMPLES.items():
        series = np.stack([example[variable] for example in examples])
        attrs = {"units": unit, "long_name": f"{variable.replace('_', ' ')}, first realisation"}
        data[f"example_{variable}"] = (("law", "time"), series, attrs)
    elevation = examples[0]["elevation"]
    data["example_elevation"] = ("time", elevation, {"units": "m", "long_name": "elevation at the float"})
    coords = {
        "law": ("law", names),
        "realisation": ("realisation", np.array(waves.seeds)),
        "sha256": ("realisation", [outcome.sha256 for outcome in rows[names[0]]]),
        "information": ("law", [law.information for law in laws.values()]),
        "label": ("law", [name.replace("_", " ") for name in names]),
        "time": ("time", examples[0]["time"], {"units": "s", "long_name": "time"}),
    }
    return xr.Dataset(data, coords)


def _attributes(values: Mapping[str, Any]) -> dict[str, str]:
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in values.items()}


def _default_experiment(plant: Plant, waves: Realisations, settings: Settings) -> dict[str, Any]:
    run = {"duration": waves.duration, "dt": settings.dt, "blend": settings.blend, "start": settings.start}
    return {"sea": repr(waves.sea), "run": {**run, "seeds": list(waves.seeds)}, "plant": {"name": plant.name}}
