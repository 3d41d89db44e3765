"""One case: a device and a sea, the laws that are run on it, and what became of every run."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.comparison.compare import Realisations, compare
from gyroctl.errors import InputError
from gyroctl.harness.protocol import Law, LawError
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings
from gyroctl.harness.sight import sight
from gyroctl.harness.yardstick import Yardstick
from gyroctl.plant import Plant
from gyroctl.reports.layout import REFERENCE, failures, names
from gyroctl.studies.evaluation.entrants import Entrant, kind, pair
from gyroctl.studies.evaluation.request import RUNS, Request
from gyroctl.tuning.yardstick import find_yardstick
from gyroctl.waves import Sea


@dataclass(frozen=True)
class Case:
    """A device in a sea."""

    name: str  # in the table
    truth: Plant  # the device that is simulated; no law ever gets it: laws bring a design model of their own
    sea: Sea
    settings: Settings  # steps, sensors and actuators


@dataclass(frozen=True)
class Runs:
    """A law in a case: one value of every metric a realisation."""

    entrant: Entrant
    kind: str  # what the law is
    information: str  # level at which it is judged, by what it sees
    seeds: NDArray[np.int64]  # the realisations, (n,)
    hashes: tuple[str, ...]  # content of their waves
    values: Mapping[str, NDArray[np.float64]]  # (n,) by the names of `simulation.metrics.UNITS` and the counters
    preview: float = math.nan  # how far ahead it is told the waves, infinite for all of them [s]

    def on(self, seeds: Sequence[int], name: str) -> NDArray[np.float64]:
        """Values of a metric on some of the realisations, in their order."""
        at = {int(seed): i for i, seed in enumerate(self.seeds)}
        return self.values[name][[at[seed] for seed in seeds]]


@dataclass(frozen=True)
class Outcome:
    """All laws in a case; `failed` says in words why a law has no runs, or misses some."""

    case: Case
    runs: Mapping[str, Runs]
    failed: Mapping[str, str]

    @property
    def reference(self) -> Runs:
        """Runs of the best constant pair."""
        return self.runs[REFERENCE]

    @property
    def failures(self) -> dict[str, str]:
        """Why laws have no runs, or miss some, by case and law."""
        return {f"{self.case.name}, {law}": why for law, why in self.failed.items()}


def run_case(case: Case, entrants: Iterable[Entrant], ask: Request) -> Outcome:
    """Run the laws on the case; what is stored is not run again, and a law that fails does not stop the others.

    Parameters
    ----------
    case : Case
        Device, sea, settings.
    entrants : iterable of Entrant
        The laws with the reference.
    ask : Request
        Seeds, length, folder.

    Raises
    ------
    InputError
        Where not even the reference can be run, or a law holds the true device as its model.
    """
    groups: dict[tuple[int, ...], list[Entrant]] = {}
    for entrant in entrants:
        label = entrant.label
        reference = label == REFERENCE
        seeds = ask.plan.in_case(case.name) if reference else ask.plan.of(label, entrant.name, case=case.name)
        groups.setdefault(seeds, []).append(entrant)
    runs: dict[str, Runs] = {}
    failed: dict[str, str] = {}
    for seeds, group in groups.items():
        done, broken = _run_group(case, group, seeds, ask)
        runs |= done
        failed |= broken
    if REFERENCE not in runs:
        raise InputError("case", case.name, f"the reference cannot be run: {failed[REFERENCE]}", "Choose another sea")
    check_waves(runs.values())
    return Outcome(case, runs, failed)


def check_any(done: Collection[Any], failed: Mapping[str, str]) -> None:
    """Refuse to draw a table of no cases.

    Raises
    ------
    InputError
        Field ``cases``, with the reason of each.
    """
    if not done:
        problem = f"every case failed: {'; '.join(f'{what}: {why}' for what, why in failed.items())}"
        raise InputError("cases", list(failed), problem.rstrip("."), "Correct what failed")


def common_seeds(first: Runs, second: Runs) -> tuple[int, ...]:
    """Realisations on which both laws were run."""
    return tuple(int(seed) for seed in first.seeds if seed in set(second.seeds.tolist()))


def best_pair_of(case: Case, ask: Request) -> Entrant:
    """Best constant pair of a case as its reference: as it ships, or searched once."""
    found = find_yardstick(case.truth, case.sea, case.settings, workers=ask.workers, quiet=ask.quiet, say=ask.say)
    return pair(found.cc, found.cg)


def check_waves(runs: Iterable[Runs]) -> None:
    """Refuse laws that met other waves under the same seed."""
    met: dict[int, str] = {}
    for law in runs:
        for seed, sha256 in zip(law.seeds.tolist(), law.hashes, strict=True):
            if met.setdefault(seed, sha256) != sha256:
                problem, mend = f"met other waves under seed {seed}", "Empty the folder of finished runs"
                raise InputError(f"laws.{law.entrant.label}", sha256[:12], problem, mend)


def check_design(built: Law, truth: Plant) -> None:
    """Refuse a law that holds the very device that is simulated."""
    if any(model is truth for model in designs(built)):
        problem, mend = "plans with the device itself, not with a model of it", "Give the law a design model of its own"
        raise InputError("laws", type(built).__name__, problem, mend)


def designs(built: Any) -> list[Plant]:
    """Design models among the fields of a law and of the laws it wraps."""
    if is_dataclass(built):
        members = [getattr(built, f.name) for f in fields(built)]
    else:
        members = list(built) if isinstance(built, tuple) else []
    found = [member for member in members if isinstance(member, Plant)]
    for member in members:
        if isinstance(member, Law):
            found += designs(member)
    return found


def _run_group(
    case: Case, group: Sequence[Entrant], seeds: tuple[int, ...], ask: Request
) -> tuple[dict[str, Runs], dict[str, str]]:
    """Run laws that have the same seeds; what fails is told from what does not by running one by one."""
    laws, failed = _build(case, group)
    if not laws:
        return {}, failed
    waves = Realisations(case.sea, seeds, ask.duration)
    try:
        ds = compare(
            case.truth,
            laws,
            waves,
            case.settings,
            ask.workers,
            results=ask.out / RUNS,
            tuning_seeds=ask.tuned_on,
            quiet=ask.quiet,
            yardstick=_yardstick(laws),
            case=case.name,
            scheduler=ask.scheduler,
        )
    except (InputError, LawError, BrokenProcessPool) as error:
        if isinstance(error, InputError) and error.field == "scheduler":  # no law is at fault
            raise
        if len(laws) == 1:
            return {}, {**failed, next(iter(laws)): str(error)}
        runs: dict[str, Runs] = {}
        for entrant in group:  # what the others have finished is stored
            if entrant.label in laws:
                done, broken = _run_group(case, [entrant], seeds, ask)
                runs |= done
                failed |= broken
        return runs, failed
    hashes = tuple(str(sha256) for sha256 in ds["sha256"].values)
    every = [str(name) for name in ds.data_vars if ds[name].dims == ("law", "realisation")]
    metrics = [name for name in every if ds[name].dtype.kind in "bif"]  # why a run failed is a text

    def gathered(entrant: Entrant) -> Runs:
        built, row = laws[entrant.label], ds.sel(law=entrant.label)
        values = {name: np.asarray(row[name].values, np.float64) for name in metrics}
        seen = sight(built)
        return Runs(entrant, kind(built), seen.level, np.asarray(seeds, np.int64), hashes, values, seen.preview)

    runs = {entrant.label: gathered(entrant) for entrant in group if entrant.label in laws}
    for label, reasons in zip(names(ds), failures(ds), strict=True):
        if reasons and label in laws:
            failed[label] = f"failed in {len(reasons)} of {len(seeds)} runs: {next(iter(reasons.values()))}"
            if len(reasons) == len(seeds):
                del runs[label]
    return runs, failed


def _yardstick(laws: Mapping[str, Law]) -> Yardstick | None:
    """Pair that a table has chosen as its reference, and says how."""
    if REFERENCE not in laws:
        return None
    chosen = describe(laws[REFERENCE])
    return Yardstick(chosen["cc"], chosen["cg"], searched=False, words="see the table")


def _build(case: Case, group: Sequence[Entrant]) -> tuple[dict[str, Law], dict[str, str]]:
    """Laws by label, and in words why some cannot be built."""
    laws: dict[str, Law] = {}
    failed: dict[str, str] = {}
    for entrant in group:
        try:
            laws[entrant.label] = entrant.build()
        except InputError as error:
            failed[entrant.label] = str(error)
            continue
        check_design(laws[entrant.label], case.truth)
    return laws, failed
