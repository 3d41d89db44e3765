"""The fair comparison: several laws on identical realisations, each run a work item with its own stored result.

An item is a law on a realisation. Its key is the hash of everything that can change a bit of its result, so what is
finished is never computed again, and neither the number of workers nor the order can matter.
"""

from __future__ import annotations

import datetime
import hashlib
import json
import os
import pickle
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, fields
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.comparison import store
from gyroctl.errors import InputError
from gyroctl.harness import actuation, loop, sensing, start
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.harness.start import locked_start
from gyroctl.orbits import flow, orbit
from gyroctl.plant import Plant
from gyroctl.plant.compiled import source_stamp
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE
from gyroctl.plant.kernel import SOURCES
from gyroctl.simulation import lock, metrics
from gyroctl.simulation.metrics import UNITS, evaluate
from gyroctl.simulation.progress import Progress
from gyroctl.waves import Sea, WaveRealisation, estimation, prepare, realise
from gyroctl.waves.energy import wave_power

if TYPE_CHECKING:
    import xarray

COUNTERS = ("deadline_misses", "fallbacks", "clamped", "starts", "pulls", "catches", "unloads")
"""What a law may count while it runs, see `LawTiming`."""

COUNTS = {"saturations": "1", "step_ms_median": "ms", "step_ms_p99": "ms", **dict.fromkeys(COUNTERS, "1")}
EXAMPLES = {
    "power": "W",
    "ring_speed": "rad/s",
    "phi1": "rad",
    "phi3": "rad",
    "cc": "Nms",
    "cg": "Nms",
    "load_share": "1",
}


@dataclass(frozen=True)
class Realisations:
    """The identical waves of a comparison: a sea, seeds, and their grid.

    Parameters
    ----------
    sea : Sea
        The waves.
    seeds : tuple of int
        One realisation each.
    duration, dt : float
        Length and grid of the moments. [s]
    """

    sea: Sea
    seeds: tuple[int, ...]
    duration: float = 2000.0
    dt: float = 0.05


@dataclass(frozen=True)
class Item:
    """One law on one realisation."""

    plant: Plant
    name: str
    law: Law
    sea: Sea
    seed: int
    duration: float
    waves_dt: float
    settings: Settings
    available: float
    example: bool
    key: str = ""


@dataclass(frozen=True)
class Outcome:
    """Result of an item: hash of its waves, metrics, and the time series where it is the example."""

    sha256: str
    values: dict[str, float]
    series: dict[str, NDArray[np.float64]] = field(default_factory=dict)


def compare(
    plant: Plant,
    laws: Mapping[str, Law],
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
    laws : mapping of str to Law
        Laws by the names that they get in the result.
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
    settings = settings or Settings()
    if not isinstance(waves, Realisations):
        waves = _from_realisations(waves)
    if not laws:
        raise InputError("laws", {}, "there is nothing to compare", "Give at least one law")
    _check_seeds(waves.seeds, tuning_seeds)
    if not waves.duration > settings.score_from:
        raise InputError(
            "run.duration",
            waves.duration,
            f"is not longer than the blend of {settings.blend:g} s",
            "Give a longer duration, or a shorter run.blend",
        )
    items = _items(plant, laws, waves, settings)
    outcomes = _execute(items, workers or os.cpu_count() or 1, results, quiet)
    rows = {name: [outcomes[name, seed] for seed in waves.seeds] for name in laws}
    check_fair(rows)
    return _dataset(plant, laws, waves, settings, rows, tuning_seeds, experiment, motion_limit)


def check_fair(rows: Mapping[str, Sequence[Outcome]]) -> None:
    """Refuse a comparison of runs on different waves, or of waves that are the same for several seeds."""
    names = list(rows)
    hashes = [outcome.sha256 for outcome in rows[names[0]]]
    for name in names[1:]:
        for index, outcome in enumerate(rows[name]):
            if outcome.sha256 != hashes[index]:
                raise InputError(
                    f"laws.{name}",
                    outcome.sha256[:12],
                    f"realisation {index + 1} differs from that of {names[0]} ({hashes[index][:12]})",
                    "Compare runs on identical waves only: run all laws together, or empty the folder of results",
                )
    if len(set(hashes)) < len(hashes):
        raise InputError(
            "run.seeds",
            len(hashes),
            "several seeds give the same waves, as in a regular sea",
            "Give one seed; more of them are no independent runs",
        )


def perform(item: Item) -> Outcome:
    """Run one item."""
    waves = lead_in(realise(item.plant, item.sea, item.seed, item.duration, item.waves_dt), item.settings)
    record, timing = run_law(item.plant, item.law, waves, item.settings, item.name)
    values = evaluate(
        item.plant,
        record,
        waves.moments[1],
        waves.dt,
        item.sea.wp,
        item.settings.score_from,
        item.available,
        from_rest=item.settings.start == "rest",
    )
    values |= {
        "saturations": float(record.saturations),
        "step_ms_median": timing.median,
        "step_ms_p99": timing.p99,
        **{name: float(timing.counters.get(name, 0)) for name in COUNTERS},
    }
    return Outcome(waves.sha256, values, _example(item, record, waves) if item.example else {})


def _example(item: Item, record: metrics.Record, waves: WaveRealisation) -> dict[str, NDArray[np.float64]]:
    states = record.states[:-1]
    cc, cg = record.controls.T
    p = item.plant.parameters
    time = np.arange(states.shape[0]) * record.period
    return {
        "time": time,
        "power": cg * states[:, OMEGA_RATE] ** 2,
        "ring_speed": states[:, PSI_RATE],
        "phi1": states[:, PHI1],
        "phi3": states[:, PHI3],
        "cc": cc.copy(),
        "cg": cg.copy(),
        "load_share": lock.load_share(
            states[:, PSI], states[:, PHI1_RATE], states[:, PHI3_RATE], cg, record.period, item.sea.wp, p.J4 / p.N
        ),
        "elevation": np.interp(time, waves.time, waves.elevation),
    }


def _items(plant: Plant, laws: Mapping[str, Law], waves: Realisations, settings: Settings) -> list[Item]:
    synthesis = prepare(plant, waves.sea, waves.duration, waves.dt)  # refuses what no run could use
    lead_in(realise(plant, waves.sea, waves.seeds[0], waves.duration, waves.dt), settings)
    if settings.start == "locked":
        locked_start(plant, waves.sea)
    width = plant.parameters.d + plant.parameters.c  # crests run along the lever, and so does the capsule
    available = wave_power(synthesis, plant.depth) * width
    sources = (loop, sensing, actuation, start, flow, orbit, metrics, lock)
    stamp = source_stamp((*SOURCES, *(str(source.__file__) for source in sources)))
    items = []
    for name, law in laws.items():
        for seed in waves.seeds:
            plain = Item(
                plant, name, law, waves.sea, seed, waves.duration, waves.dt, settings, available, seed == waves.seeds[0]
            )
            key = _key(plain, synthesis.sha256(seed, settings.score_from), stamp)
            items.append(Item(**{**plain.__dict__, "key": key}))
    return items


def _key(item: Item, waves: str, stamp: str) -> str:
    """Hash of all that can change a bit of the result; empty where the law cannot be hashed: it is not stored."""
    law = _law_content(item.law)
    if not law:
        return ""
    text = json.dumps(
        [
            item.plant.coefficients,
            asdict(item.plant.parameters),
            waves,
            item.duration,
            asdict(item.settings),
            stamp,
            repr(item.available),
            item.example,
        ]
    )
    return hashlib.sha256(text.encode() + law).hexdigest()


def _law_content(law: Any) -> bytes:
    """Every field of a law and the source that defines it, helpers included; empty where they cannot be had."""
    try:
        names = law._asdict() if hasattr(law, "_asdict") else [f.name for f in fields(law)]
        values = [(name, getattr(law, name)) for name in names]
        source = _source(Path(type(law).step.__code__.co_filename))
        if hasattr(law, "law"):  # a law around a law: the source of both
            inner = _law_content(law.law)
            source = source + inner if inner else b""
        return pickle.dumps((type(law).__qualname__, values)) + source if source else b""
    except (AttributeError, OSError, TypeError, pickle.PicklingError):
        return b""  # a law with hidden state, or one that was typed in by hand


def _source(file: Path) -> bytes:
    """Text of a law: its file, or, in a package, all files of it and of the estimation that it may rest on."""
    if not (file.parent / "__init__.py").is_file():
        return file.read_bytes()
    folders = (file.parent, Path(str(estimation.__file__)).parent)
    return b"".join(path.read_bytes() for folder in folders for path in sorted(folder.rglob("*.py")))


def _execute(items: Sequence[Item], workers: int, results: Path | None, quiet: bool) -> dict[tuple[str, int], Outcome]:
    """Map over the items: compiled laws on threads, the others on processes where there are several workers."""
    outcomes: dict[tuple[str, int], Outcome] = {}
    with Progress("runs", len(items), quiet) as progress, ExitStack() as pools:
        todo = []
        for item in items:
            stored = store.load(results, item.key)
            if stored is None:
                todo.append(item)
            else:
                outcomes[item.name, item.seed] = Outcome(*stored)
                progress.advance()
        compiled = {item.name: compile_law(item.law) is not None for item in todo}
        fast = [item for item in todo if compiled[item.name]]
        slow = [item for item in todo if not compiled[item.name]]
        # One run of a slow law goes ahead, beside the fast ones: on a new installation it compiles what it calls, and
        # the other processes find that done.
        ahead = slow[:1] if fast and workers > 1 else []
        stages = [[(True, fast), (False, ahead)], [(False, slow[len(ahead) :])]]
        executors = {
            True: pools.enter_context(ThreadPoolExecutor(max(workers - len(ahead), 1))),
            False: pools.enter_context(_processes(workers, slow)),
        }
        for stage in stages:
            futures = {executors[machine].submit(perform, item): item for machine, batch in stage for item in batch}
            try:
                for future in as_completed(futures):
                    item, outcome = futures[future], future.result()
                    store.save(results, item.key, outcome.sha256, outcome.values, outcome.series)
                    outcomes[item.name, item.seed] = outcome
                    progress.advance()
            except BaseException:
                for pool in executors.values():
                    pool.shutdown(wait=False, cancel_futures=True)
                raise
    return outcomes


def _processes(workers: int, batch: Sequence[Item]) -> Executor:
    """Processes for laws that run as Python; a single thread where one will do, or where a law cannot be sent."""
    if workers == 1 or len(batch) <= 1:
        return ThreadPoolExecutor(1)
    try:
        for law in {item.name: item.law for item in batch}.values():
            pickle.loads(pickle.dumps(law))
            if type(law).__module__.startswith("gyroctl_user_"):
                raise pickle.PicklingError  # a worker process would not know the user's file
    except (pickle.PicklingError, AttributeError, TypeError, ImportError):
        return ThreadPoolExecutor(1)
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def _from_realisations(waves: Sequence[WaveRealisation]) -> Realisations:
    if not waves:
        raise InputError("waves", [], "there are no realisations", "Give at least one, see gyroctl.realise")
    first = waves[0]
    for other in waves:
        if (other.sea, other.duration, other.dt) != (first.sea, first.duration, first.dt):
            raise InputError(
                "waves",
                other.sha256[:12],
                "realisations of different seas, lengths or grids",
                "Compare on one sea at a time",
            )
    return Realisations(first.sea, tuple(w.seed for w in waves), first.duration, first.dt)


def _check_seeds(seeds: Sequence[int], tuning_seeds: Sequence[int]) -> None:
    if not seeds:
        raise InputError("run.seeds", list(seeds), "there are no realisations", "Give at least one seed")
    if len(set(seeds)) < len(seeds):
        raise InputError("run.seeds", list(seeds), "a seed repeats", "Give each seed once")
    overlap = sorted(set(seeds) & set(tuning_seeds))
    if overlap:
        raise InputError(
            "run.seeds",
            overlap,
            "these seeds were used for tuning and cannot judge the result",
            "Choose others, for example 1 to 64",
        )


def _dataset(
    plant: Plant,
    laws: Mapping[str, Law],
    waves: Realisations,
    settings: Settings,
    rows: Mapping[str, Sequence[Outcome]],
    tuning_seeds: Sequence[int],
    experiment: Mapping[str, Any] | None,
    motion_limit: float,
) -> xarray.Dataset:
    import xarray as xr

    from gyroctl import __version__

    names = list(laws)
    data: dict[str, Any] = {}
    for variable, unit in {**UNITS, **COUNTS}.items():
        values = np.array([[outcome.values[variable] for outcome in rows[name]] for name in names])
        if variable in ("locked", "outside_model"):
            values = values.astype(bool)
        attrs = {"units": unit, "long_name": variable.replace("_", " ")}
        data[variable] = (("law", "realisation"), values, attrs)
    example = {name: rows[name][0].series for name in names}
    for variable, unit in EXAMPLES.items():
        series = np.stack([example[name][variable] for name in names])
        attrs = {"units": unit, "long_name": f"{variable.replace('_', ' ')}, first realisation"}
        data[f"example_{variable}"] = (("law", "time"), series, attrs)
    first = example[names[0]]
    data["example_elevation"] = ("time", first["elevation"], {"units": "m", "long_name": "elevation at the float"})
    coords = {
        "law": ("law", names),
        "realisation": ("realisation", np.array(waves.seeds)),
        "sha256": ("realisation", [outcome.sha256 for outcome in rows[names[0]]]),
        "information": ("law", [laws[name].information for name in names]),
        "label": ("law", [name.replace("_", " ") for name in names]),
        "time": ("time", first["time"], {"units": "s", "long_name": "time"}),
    }
    attributes = {
        "experiment": json.dumps(experiment or _default_experiment(plant, waves, settings)),
        "gyroctl_version": __version__,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "tuning_seeds": json.dumps(sorted(int(seed) for seed in tuning_seeds)),
        "parameters": json.dumps({name: describe(law) for name, law in laws.items()}),
        "duration": waves.duration,
        "blend": settings.score_from,
        "start": settings.start,
        "motion_limit": motion_limit,
        "plant": plant.name,
        "wp": waves.sea.wp,
        "hs": waves.sea.hs,
        "capture_width_m": plant.parameters.d + plant.parameters.c,
    }
    return xr.Dataset(data, coords, attributes)


def _default_experiment(plant: Plant, waves: Realisations, settings: Settings) -> dict[str, Any]:
    return {
        "sea": repr(waves.sea),
        "run": {
            "duration": waves.duration,
            "dt": settings.dt,
            "blend": settings.blend,
            "start": settings.start,
            "seeds": list(waves.seeds),
        },
        "plant": {"name": plant.name},
    }
