"""The fair comparison: several laws on identical realisations, as one labelled dataset."""

from __future__ import annotations

import datetime
import json
import math
import os
import warnings
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.comparison.cluster import connected, run_far
from gyroctl.comparison.execution import execute
from gyroctl.comparison.items import COUNTERS, Outcome, Realisations, check_different, work_items
from gyroctl.devices.identity import device_record
from gyroctl.errors import InputError, check_kind
from gyroctl.harness.arguments import check_plant, laws_by_name
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, checked_settings, ticks_of
from gyroctl.harness.run_size import run_size
from gyroctl.harness.seed_ledger import ledger, refused_for
from gyroctl.harness.sight import sight
from gyroctl.harness.yardstick import BASELINE, Yardstick, with_yardstick
from gyroctl.plant import Plant
from gyroctl.provenance import provenance
from gyroctl.simulation import effort, validity
from gyroctl.simulation.lock import WINDOW, in_step
from gyroctl.simulation.metrics import UNITS, can_judge
from gyroctl.waves import WaveRealisation
from gyroctl.waves.checks import positive, whole, within

if TYPE_CHECKING:
    from gyroctl.comparison.labelled import Comparison

__all__ = ["Realisations", "check_fair", "compare"]

Rows = Mapping[str, Sequence[Outcome]]
"""Outcomes of each law, in the order of the seeds."""

WORKERS_MAX = 1024
"""More threads or processes than any machine has that this is meant for."""

VARIABLES = {**UNITS, **validity.UNITS, **effort.UNITS, "saturations": "1", "step_ms_median": "ms", "step_ms_p99": "ms"}
VARIABLES |= dict.fromkeys(COUNTERS, "1")
VERDICTS = ("locked", "in_step", "outside_model", "over_limit")
"""Variables that are true or false."""

EXAMPLES = {
    "power": "W",
    "ring_speed": "rad/s",
    "phi1": "rad",
    "phi3": "rad",
    "cc": "Nms",
    "cg": "Nms",
    "load_share": "1",
    "load_angle": "rad",
}


def compare(
    plant: Plant,
    laws: Mapping[str, Law | str] | Sequence[str],
    waves: Realisations | Sequence[WaveRealisation],
    settings: Settings | None = None,
    workers: int | None = None,
    results: Path | None = None,
    tuning_seeds: Sequence[int] | None = None,
    experiment: Mapping[str, Any] | None = None,
    motion_limit: float = 0.35,
    quiet: bool = False,
    time_limit: float | None = None,
    yardstick: Yardstick | None = None,
    full_series: bool = False,
    case: str = "",
    scheduler: Any = None,
) -> Comparison:
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
    tuning_seeds : sequence of int, optional
        Seeds that may not judge these laws; by default those that the ledger keeps for tuning and trying, and those of
        the tuned sets of every registered law and beside the file of each of these.
    experiment : mapping, optional
        The experiment as it was asked for, kept in the result.
    motion_limit : float
        Limit of the 98 % motion. [rad]
    quiet : bool
        Show no progress.
    time_limit : float, optional
        Time that one run of a law which is not of this package may take; by default as long as what it simulates, and
        a minute at least. [s]
    yardstick : Yardstick, optional
        From `gyroctl.find_yardstick`, for this sea, plant and actuators. It takes part as ``best_constant``, under
        which name no other law may stand. Without it a pair that ships may, and the verdict says that none was
        searched.
    full_series : bool
        Keep the time series of the first realisation sample by sample. Otherwise one of more than `items.SERIES` points
        keeps its peaks: every sample of 120 s in the middle, and the least and the greatest value of each bucket
        beside it. No metric depends on it.
    case : str
        What these runs are of, for ``gyroctl status``.
    scheduler : str or dask.distributed.Client, optional
        Of other machines that run it, "tcp://HOST:PORT"; it changes no bit of the result. `workers` does not count
        there.

    Returns
    -------
    Comparison
        An `xarray.Dataset` with a short repr and ``.plot()``: dimensions law and realisation; the variables of
        `metrics.UNITS` and more, among them ``in_step`` (see
        `lock.in_step`) and ``over_limit``, which need all runs; and the time series of the first realisation as
        ``example_...``.
        A run that failed has ``failed`` = 1, its reason in ``failure``, and no number elsewhere; it ends no other run.
        A law of which every run failed is warned of.

    Raises
    ------
    InputError
        For no law, another law under the name of the yardstick, seeds that repeat or overlap the tuning seeds, waves
        that differ, runs too short to judge lock, and whatever a run refuses.
    """
    check_plant(plant)
    settings, built = checked_settings(settings, plant), laws_by_name(laws)
    if not isinstance(waves, Realisations):
        waves = _from_realisations(waves)
    if not built:
        raise InputError("laws", {}, "there is nothing to compare", "Give at least one law")
    check_workers(workers)
    check_motion_limit(motion_limit)
    run_size(waves.duration, settings.dt, settings.actuators.period, plant.parameters.time_scale)
    built, yardstick = with_yardstick(built, yardstick, plant.parameters.length_scale)
    refused = refused_for(built.values()) if tuning_seeds is None else sorted(int(seed) for seed in tuning_seeds)
    check_seeds(waves.seeds, refused)
    check_length(waves.duration, settings.score_from, plant.parameters.time_scale)
    for name, law in built.items():
        ticks_of(law, name, settings.actuators)
    limit = max(60.0, waves.duration) if time_limit is None else time_limit
    items = work_items(plant, built, waves, settings, limit, full_series)
    with connected(scheduler) if scheduler is not None else nullcontext() as client:
        run = partial(run_far, client) if client is not None else None
        outcomes = execute(items, workers or os.cpu_count() or 1, results, quiet, case, run)
    rows = {name: [outcomes[name, seed] for seed in waves.seeds] for name in built}
    check_fair(rows)
    _warn_of_failed(rows)
    return _judged(_dataset(built, waves, rows), motion_limit).assign_attrs(
        experiment=json.dumps(experiment or _default_experiment(plant, waves, settings)),
        **_attributes(provenance()),
        created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        tuning_seeds=json.dumps(refused),
        seed_states=json.dumps(ledger().states(waves.seeds)),
        yardstick=yardstick.record() if yardstick else "",
        parameters=json.dumps({name: describe(law) for name, law in built.items()}),
        duration=waves.duration,
        blend=settings.score_from,
        start=settings.start,
        motion_limit=motion_limit,
        plant=plant.name,
        device=json.dumps(device_record(plant)),
        contact=plant.parameters.contact,
        wp=waves.sea.wp,
        hs=waves.sea.hs,
        capture_width_m=plant.parameters.d + plant.parameters.c,
    )


def _warn_of_failed(rows: Rows) -> None:
    """Warn of laws that have not a single number to show."""
    for name, outcomes in rows.items():
        if all(outcome.failure for outcome in outcomes):
            warnings.warn(f"every run of {name} failed: {outcomes[0].failure}", stacklevel=3)


def check_workers(workers: int | None) -> None:
    """Refuse a number of workers that no machine has."""
    if workers is not None:
        whole("workers", workers, 0, WORKERS_MAX, "Give a number of threads or processes; 0 or none for all cores")


def check_motion_limit(limit: float) -> None:
    """Refuse a limit of the motion that is no angle."""
    positive("run.motion_limit", limit, "Give an angle in rad, for example 0.35")
    within("run.motion_limit", limit, 0.0, 0.5 * math.pi, "Give an angle in rad, for example 0.35")


def check_length(duration: float, blend: float, pace: float = 1.0) -> None:
    """Refuse runs that end before their scoring begins, or so soon after that their lock cannot be judged.

    `pace` is the unit of time of the device over that of Table 1.
    """
    mend = "Give a longer duration, or a shorter run.blend"
    if not duration > blend:
        raise InputError("run.duration", duration, f"is not longer than the blend of {blend:g} s", mend)
    if not can_judge((duration - blend) / pace):
        problem = f"leaves {duration - blend:g} s to score, and lock is judged by means over {WINDOW * pace:g} s"
        raise InputError("run.duration", duration, problem, mend)


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


def check_seeds(seeds: Sequence[int], tuning_seeds: Sequence[int]) -> None:
    """Refuse no seeds, seeds that repeat, and seeds that may not judge."""
    if not seeds:
        raise InputError("run.seeds", list(seeds), "there are no realisations", "Give at least one seed")
    if len(set(seeds)) < len(seeds):
        raise InputError("run.seeds", list(seeds), "a seed repeats", "Give each seed once")
    overlap = sorted(set(seeds) & set(tuning_seeds))
    if overlap:
        problem = "these seeds were used for tuning or for trials and cannot judge the result"
        raise InputError("run.seeds", overlap, problem, "Choose others, for example 1 to 64")


def _dataset(laws: Mapping[str, Law], waves: Realisations, rows: Rows) -> Comparison:
    from gyroctl.comparison.labelled import Comparison

    names = list(laws)
    data: dict[str, Any] = {}
    for variable, unit in VARIABLES.items():
        values = np.array([[outcome.values.get(variable, np.nan) for outcome in rows[name]] for name in names])
        if variable in VERDICTS:
            values = values == 1.0  # what is no number is no yes
        attrs = {"units": unit, "long_name": variable.replace("_", " ")}
        data[variable] = (("law", "realisation"), values, attrs)
    runs = [outcome for name in names for outcome in rows[name]]
    shape = (len(names), len(waves.seeds))
    failed = np.array([bool(outcome.failure) for outcome in runs]).reshape(shape)
    data["failed"] = (("law", "realisation"), failed, {"units": "1", "long_name": "failed"})
    failure = np.array([outcome.failure for outcome in runs], dtype=object).reshape(shape)
    data["failure"] = (("law", "realisation"), failure, {"units": "", "long_name": "why the run failed"})
    examples = [rows[name][0].series for name in names]
    known = next((example for example in examples if example), dict.fromkeys(("time", "elevation"), np.zeros(0)))
    nothing = np.full(known["time"].size, np.nan)
    for variable, unit in EXAMPLES.items():
        series = np.stack([example.get(variable, nothing) for example in examples])
        attrs = {"units": unit, "long_name": f"{variable.replace('_', ' ')}, first realisation"}
        data[f"example_{variable}"] = (("law", "time"), series, attrs)
    data["example_elevation"] = ("time", known["elevation"], {"units": "m", "long_name": "elevation at the float"})
    coords = {
        "law": ("law", names),
        "realisation": ("realisation", np.array(waves.seeds)),
        "sha256": ("realisation", [outcome.sha256 for outcome in rows[names[0]]]),
        "information": ("law", [sight(law).level for law in laws.values()]),
        "preview": ("law", [sight(law).preview for law in laws.values()], {"units": "s", "long_name": "preview"}),
        "label": ("law", [name.replace("_", " ") for name in names]),
        "time": ("time", known["time"], {"units": "s", "long_name": "time"}),
    }
    return Comparison(data, coords)


def _judged(ds: Comparison, motion_limit: float) -> Comparison:
    """Add the verdicts that need all runs, or the limit that was asked for."""
    kept = [ds[name].values for name in ("turns_kept", "cycle_slips", "waves_counted")]
    pair = ds.sel(law=BASELINE) if BASELINE in ds.law.values else None
    measure = () if pair is None else [pair[name].values for name in ("turns_kept", "cycle_slips", "locked")]
    over = (ds.phi1_p98.values > motion_limit) | (ds.phi3_p98.values > motion_limit)
    for name, values in (("in_step", in_step(*kept, *measure)), ("over_limit", over)):
        ds[name] = (("law", "realisation"), values, {"units": "1", "long_name": name.replace("_", " ")})
    return ds


def _attributes(values: Mapping[str, Any]) -> dict[str, str]:
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in values.items()}


def _default_experiment(plant: Plant, waves: Realisations, settings: Settings) -> dict[str, Any]:
    run = {"duration": waves.duration, "dt": settings.dt, "blend": settings.blend, "start": settings.start}
    return {"sea": repr(waves.sea), "run": {**run, "seeds": list(waves.seeds)}, "plant": {"name": plant.name}}
