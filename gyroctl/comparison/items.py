"""The work items of a comparison: a law on a realisation, and the key under which its result is stored.

The key is the hash of everything that can change a bit of the result, so that what is finished is never computed again
and a stale result never taken for a fresh one.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.fingerprint import code_of, text_of
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.protocol import Law, LawError
from gyroctl.harness.run import Settings, lead_in
from gyroctl.harness.start import locked_start
from gyroctl.harness.together import Loop, run_together, too_long
from gyroctl.harness.together import Outcome as Run
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE
from gyroctl.simulation.effort import effort
from gyroctl.simulation.extremes import on_few_points
from gyroctl.simulation.lock import load_angle, load_share
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.simulation.validity import validity
from gyroctl.waves import Sea, WaveRealisation, prepare, realise
from gyroctl.waves.energy import wave_power
from gyroctl.waves.grid import STEP

COUNTERS = ("deadline_misses", "fallbacks", "clamped", "starts", "pulls", "catches", "unloads")
"""What a law may count while it runs, see `LawTiming`."""


KEPT = 50_000
"""Most instants of a realisation that is kept for the next law on it, where the plant needs its moments alone."""

SERIES = 20_000
"""Most points of a time series that is stored, the samples of 2000 s: a longer one keeps its peaks and the stretch in
its middle, see `few_points`, unless all of it is asked for. Metrics are always of the whole record."""


@dataclass(frozen=True)
class Realisations:
    """The identical waves of a comparison: a sea, seeds, and their grid.

    Parameters
    ----------
    sea : Sea
        The waves.
    seeds : tuple of int
        One realisation each.
    duration : float
        Length. [s]
    dt : float, optional
        Grid of the moments, by default that of `realise`. [s]
    """

    sea: Sea
    seeds: tuple[int, ...]
    duration: float = 2000.0
    dt: float | None = None

    def at(self, plant: Plant, seed: int, settings: Settings) -> WaveRealisation:
        """Return the waves of a seed as they act on the plant; short ones are kept for the other laws."""
        step = self.dt or STEP * plant.parameters.time_scale
        if plant.coefficients.beyond is None and self.duration <= KEPT * step:
            return _kept(_The(self), seed, _The(plant), _The(settings))
        return self.made(seed, plant, settings)

    def made(self, seed: int, plant: Plant, settings: Settings) -> WaveRealisation:
        """Make the waves of a seed anew, as `at` returns them."""
        return lead_in(realise(plant, self.sea, seed, self.duration, self.dt), settings)


class _The:
    """An object that is itself alone, and stays as long as it is asked for."""

    __slots__ = ("it",)

    def __init__(self, it: Any) -> None:
        self.it = it

    def __hash__(self) -> int:
        return id(self.it)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _The) and self.it is other.it


@lru_cache(maxsize=64)  # of some laws on a filling of the lanes
def _kept(waves: _The, seed: int, plant: _The, settings: _The) -> WaveRealisation:
    made: WaveRealisation = waves.it.made(seed, plant.it, settings.it)
    return made


@dataclass(frozen=True, slots=True)
class Item:
    """One law on one realisation."""

    plant: Plant
    name: str
    law: Any  # a Law; None while it travels apart
    waves: Realisations
    seed: int
    settings: Settings
    available: float  # power of the waves [W]
    example: bool  # whether the time series are wanted
    sha256: str  # of the waves as they act
    time_limit: float  # that a run may take [s]
    key: str  # under which the result is stored
    full: bool = False  # whether the time series are wanted sample by sample, however long


@dataclass(frozen=True)
class Outcome:
    """Result of an item."""

    sha256: str  # of its waves
    values: Mapping[str, float]  # metrics; none where the run failed
    series: dict[str, NDArray[np.float64]] = field(default_factory=dict)  # of the example
    failure: str = ""  # why the run failed


def work_items(
    plant: Plant,
    laws: Mapping[str, Law],
    waves: Realisations,
    settings: Settings,
    time_limit: float,
    full: bool = False,
    series: bool = True,
) -> list[Item]:
    """Every law on every realisation; with `full` the time series of the first one whole, whatever their length.

    Without `series` no time series is kept, and all runs are stored as those of the further realisations are.

    Raises
    ------
    InputError
        For waves or a start that no run could use.
    """
    synthesis = prepare(plant, waves.sea, waves.duration, waves.dt)
    waves.at(plant, waves.seeds[0], settings)
    if settings.start == "locked":
        locked_start(plant, waves.sea)
    width = plant.parameters.d + plant.parameters.c  # crests run along the lever, and so does the capsule
    available = wave_power(synthesis, plant.depth) * width
    device = [plant.coefficients, plant.water, asdict(plant.parameters)]
    common = [*device, waves.duration, asdict(settings), repr(available)]
    hashes = {seed: synthesis.sha256(seed, settings.score_from) for seed in waves.seeds}
    check_different(list(hashes.values()))
    content = {name: law_fingerprint(law) for name, law in laws.items()}
    items = []
    for (name, law), seed in product(laws.items(), waves.seeds):
        example = series and seed == waves.seeds[0] and (full or "short")  # whether and how the time series are kept
        text = json.dumps([code_of(__name__), content[name], hashes[seed], example, *common])
        # a law that is not known by its content has no key, and its result is not stored
        key = hashlib.sha256(text.encode()).hexdigest() if content[name] else ""
        wanted = (available, bool(example), hashes[seed], time_limit, key, full)
        items.append(Item(plant, name, law, waves, seed, settings, *wanted))
    return items


def about(item: Item, case: str) -> dict[str, Any]:
    """What a stored result is of, and the code that it rests on; a law's own is told by the key alone."""
    return {"case": case, "law": item.name, "seed": item.seed, "code": {__name__: text_of(__name__)}}


def failed(item: Item, failure: str) -> Outcome:
    """Outcome of a run that failed."""
    return Outcome(item.sha256, {}, {}, failure)


def check_different(hashes: Sequence[str]) -> None:
    """Refuse waves that are the same for several seeds."""
    if len(set(hashes)) < len(hashes):
        problem = "several seeds give the same waves, as in a regular sea or one from a record"
        raise InputError("run.seeds", len(hashes), problem, "Give one seed; more of them are no independent runs")


def perform(items: Sequence[Item]) -> list[Outcome]:
    """Run items of one plant, side by side where that is possible; a law that fails ends its own run alone.

    Of runs so long that they go one by one no two are held at a time, neither records nor waves.
    """
    if any(too_long(item.plant, item.waves.duration, item.settings.actuators.period) for item in items):
        return [outcome for item in items for outcome in _performed([item])]
    return _performed(items)


def _performed(items: Sequence[Item]) -> list[Outcome]:
    loops = [
        Loop(item.law, item.waves.at(item.plant, item.seed, item.settings), item.settings, item.name, item.time_limit)
        for item in items
    ]
    runs = run_together(items[0].plant, loops)
    return [_outcome(item, loop.waves, run) for item, loop, run in zip(items, loops, runs, strict=True)]


def _outcome(item: Item, waves: WaveRealisation, run: Run) -> Outcome:
    if isinstance(run, LawError):
        return failed(item, str(run))
    plant, settings, (record, timing) = item.plant, item.settings, run
    rest, scored = settings.start == "rest", (settings.score_from, item.available)
    values = evaluate(plant, record, waves.moments[1], waves.dt, item.waves.sea.wp, *scored, from_rest=rest)
    values |= validity(plant, record, waves, settings.score_from, rest)
    first, limits = round(settings.score_from / record.period), settings.actuators
    values |= effort(record.controls[first:], (limits.cc_max, limits.cg_max), record.period)
    values |= {
        "saturations": float(record.saturations),
        "step_ms_median": timing.median,
        "step_ms_p99": timing.p99,
        **{name: float(timing.counters.get(name, 0)) for name in COUNTERS},
    }
    return Outcome(waves.sha256, values, _series(item, record, waves) if item.example else {})


def _series(item: Item, record: Record, waves: WaveRealisation) -> dict[str, NDArray[np.float64]]:
    states = record.states[:-1]
    cc, cg = record.controls.T
    psi, phi1_rate, phi3_rate = states[:, PSI], states[:, PHI1_RATE], states[:, PHI3_RATE]
    time, p = np.arange(states.shape[0]) * record.period, item.plant.parameters
    series = {
        "time": time,
        "power": cg * states[:, OMEGA_RATE] ** 2,
        "ring_speed": states[:, PSI_RATE],
        "phi1": states[:, PHI1],
        "phi3": states[:, PHI3],
        "cc": cc.copy(),
        "cg": cg.copy(),
        "load_share": load_share(psi, phi1_rate, phi3_rate, cg, record.period, item.waves.sea.wp, p.J4 / p.N),
        "load_angle": load_angle(psi, phi1_rate, phi3_rate, record.period, item.waves.sea.wp),
        "elevation": np.interp(time, waves.time, waves.elevation),
    }
    return series if item.full else on_few_points(series, SERIES)
