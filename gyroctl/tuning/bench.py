"""The runs of a tuning, on threads (compiled laws), processes (others) or other machines: none changes a bit."""

from __future__ import annotations

import math
import os
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager, closing
from dataclasses import replace
from functools import lru_cache
from types import TracebackType
from typing import Any, NamedTuple

import cloudpickle
import numpy as np
from numpy.typing import NDArray

from gyroctl.engine.apart import CONTEXT
from gyroctl.engine.cluster import FEWEST, Lost, Task, hand_out, threads_of
from gyroctl.engine.parent import end_with_parent
from gyroctl.errors import InputError
from gyroctl.fingerprint import code_of
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law, LawError
from gyroctl.harness.registry import build
from gyroctl.harness.run import Settings, lead_in
from gyroctl.harness.together import Loop, Outcome, pieces, run_together
from gyroctl.harness.travelling import by_value, modules_of
from gyroctl.plant import Plant
from gyroctl.plant.equations import PSI, PSI_RATE
from gyroctl.plant.kernel import slip_rate
from gyroctl.simulation.lock import WINDOW
from gyroctl.simulation.metrics import evaluate
from gyroctl.tuning.goal import METRICS, RESERVE, WORST
from gyroctl.waves import Sea, WaveRealisation, realise

KEPT = 24
"""Realisations kept: jobs come realisation by realisation, so that few are needed at a time."""

STEADY = 2.0
"""Largest product of step and slip rate in a search."""


class Job(NamedTuple):
    """A law on a realisation. The law comes by name, since a worker process would not know a user's file."""

    law: str
    parameters: tuple[tuple[str, float], ...]
    sea: Sea
    seed: int
    duration: float
    dt: float


class Runner:
    """Performs jobs on one plant; keeps the last realisations."""

    def __init__(self, plant: Plant, settings: Settings, device: Plant | None = None) -> None:
        self.plant, self.settings, self.device = plant, settings, device
        self.waves: OrderedDict[tuple[Sea, int, float], WaveRealisation] = OrderedDict()

    def __call__(self, jobs: Sequence[Job], laws: Sequence[Law] | None = None) -> list[tuple[float, ...]]:
        """Run jobs, of these laws where they have been built, side by side where possible; `METRICS` of each."""
        built = laws or [build(job.law, dict[str, Any](job.parameters), device=self.device) for job in jobs]
        loops = [self._loop(job, law) for job, law in zip(jobs, built, strict=True)]
        outcomes = run_together(self.plant, loops)
        return [self._metrics(loop.waves, outcome) for loop, outcome in zip(loops, outcomes, strict=True)]

    def _loop(self, job: Job, built: Law) -> Loop:
        acting = self.acting(job.sea, job.seed, job.duration)
        return Loop(built, acting, scanning(self.plant, built, self.settings, job.dt), job.law)

    def _metrics(self, acting: WaveRealisation, outcome: Outcome) -> tuple[float, ...]:
        if isinstance(outcome, LawError):
            return WORST
        record, wp = outcome[0], acting.sea.wp
        found = evaluate(self.plant, record, acting.moments[1], acting.dt, wp, acting.blend, np.nan)
        window = WINDOW * self.plant.parameters.time_scale
        span = round(window / record.period)
        psi = record.states[:, PSI]
        reserve = np.min(psi[span:] - psi[:-span]) / (window * wp) if np.all(np.isfinite(psi)) else 0.0
        found["short_reserve"] = max(0.0, RESERVE - float(reserve))
        found["reversed"] = float(self._reversed(record.states[round(acting.blend / record.period) :]))
        values = [found[name] for name in METRICS]
        return tuple(v if np.isfinite(v) else worst for v, worst in zip(values, WORST, strict=True))

    def _reversed(self, states: NDArray[np.float64]) -> bool:
        """Whether the axis rolled backwards: the spin of its contact against the ring, where the contact may slip."""
        if not self.plant.slips:
            return False
        spin = states[:, len(self.plant.labels) - 1]
        return bool(np.any(spin * states[:, PSI_RATE] < 0.0))

    def acting(self, sea: Sea, seed: int, duration: float) -> WaveRealisation:
        """Return the waves as they act, blended in."""
        key = (sea, seed, duration)
        kept = self.waves.get(key)
        if kept is None:
            kept = self.waves[key] = lead_in(realise(self.plant, sea, seed, duration), self.settings)
            if len(self.waves) > KEPT:
                self.waves.popitem(last=False)
        return kept


def scanning(plant: Plant, built: Law, settings: Settings, dt: float) -> Settings:
    """Settings with the longest step up to `dt` that the largest coupling of the law leaves stable.

    A law that tells its largest coupling, as `cc` where it is fixed or as `cc_max`, is run with longer steps.
    """
    largest = float(getattr(built, "cc", getattr(built, "cc_max", settings.actuators.cc_max)))
    largest = min(largest, settings.actuators.cc_max)
    if dt <= settings.dt or largest <= 0.0:
        return replace(settings, dt=dt)
    rate = float(slip_rate(plant.coefficients, largest))
    longest = STEADY / rate if rate > 0.0 else math.inf  # a flywheel that is geared to the ring does not slip
    actuators: Actuators = replace(settings.actuators, cc_max=largest)
    return replace(settings, dt=max(min(dt, longest), settings.dt), actuators=actuators)


class Bench(AbstractContextManager["Bench"]):
    """Workers that perform jobs.

    Parameters
    ----------
    plant, settings
        Common to all runs.
    example : Law
        The law that is tuned: threads where it can be compiled, processes otherwise.
    workers : int
        How many.
    client : dask.distributed.Client, optional
        Of other machines that perform them instead.
    device : Plant, optional
        The device that the laws are built for, where it is one of one's own.
    """

    def __init__(
        self,
        plant: Plant,
        settings: Settings,
        example: Law,
        workers: int,
        client: Any = None,
        device: Plant | None = None,
    ) -> None:
        self.runner, self.client = Runner(plant, settings, device), client
        self.modules = tuple(sorted({__name__, *modules_of(example)}))
        self.workers = max(1, workers)
        self.compiled = compile_law(example) is not None
        self.pool: Executor | None = None
        self.call: Callable[[Sequence[Job]], list[tuple[float, ...]]] = self.runner
        if client is not None:
            self.workers = max(threads_of(client), FEWEST)
        elif self.workers > 1 and self.compiled:
            self.pool = ThreadPoolExecutor(self.workers)
        elif self.workers > 1:
            self.pool = ProcessPoolExecutor(
                self.workers, mp_context=CONTEXT, initializer=_equip, initargs=(plant, settings, device)
            )
            self.call = _perform

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Drop what is not under way."""
        if self.pool is not None:
            self.pool.shutdown(wait=kind is None, cancel_futures=True)

    def perform(self, jobs: Sequence[Job], done: Callable[[Job], None]) -> list[tuple[float, ...]]:
        """Metrics of each job in the order of the jobs; `done` is told of each one that has ended.

        Raises
        ------
        BrokenExecutor, MemoryError
            Where workers are lost again and again.
        """
        batches = self._batches(jobs)
        if self.client is not None:
            return self._far(jobs, batches, done)
        work = [[jobs[number] for number in batch] for batch in batches]
        rows = map(self.call, work) if self.pool is None else self.pool.map(self.call, work)
        found: dict[int, tuple[float, ...]] = {}
        for batch, some in zip(batches, rows, strict=True):
            for number, row in zip(batch, some, strict=True):
                found[number] = row
                done(jobs[number])
        return [found[number] for number in range(len(jobs))]

    def _far(
        self, jobs: Sequence[Job], batches: Sequence[list[int]], done: Callable[[Job], None]
    ) -> list[tuple[float, ...]]:
        """Perform batches on other machines, where a law is known by its content: its file is here."""
        on, code = cloudpickle.dumps((self.runner.plant, self.runner.settings)), code_of(*self.modules)
        points = {(job.law, job.parameters) for job in jobs}
        device = self.runner.device
        laws = {point: by_value(build(point[0], dict[str, Any](point[1]), device=device)) for point in points}
        tasks = []
        for numbers in batches:
            some = [jobs[number] for number in numbers]
            packed = [laws[job.law, job.parameters] for job in some]
            tasks.append(Task((on, some, packed), numbers, self.modules, code))
        found: dict[int, tuple[float, ...]] = {}
        with closing(hand_out(self.client, perform_there, tasks, _apart)) as ended:
            for task, rows in ended:
                if isinstance(rows, Lost):
                    raise MemoryError(rows.value) if rows is Lost.MEMORY else BrokenExecutor(rows.value)
                for number, row in zip(task.own, rows, strict=True):
                    found[number] = row
                    done(jobs[number])
        return [found[number] for number in range(len(jobs))]

    def _batches(self, jobs: Sequence[Job]) -> list[list[int]]:
        """Numbers of the jobs that are run side by side: evenly for the workers, and few enough for the lanes."""
        if not self.compiled:
            return [[number] for number in range(len(jobs))]
        numbers = list(range(len(jobs)))
        return [numbers[part] for part in pieces(len(jobs), self.workers)]


def _apart(task: Task) -> list[Task]:
    on, jobs, laws = task.what
    parts = zip(jobs, laws, task.own, strict=True)
    return [task._replace(what=(on, [job], [law]), own=[number]) for job, law, number in parts]


def perform_there(what: tuple[bytes, Sequence[Job], Sequence[bytes]]) -> list[tuple[float, ...]]:
    """Perform jobs on a worker: on a plant with settings, of laws that are packed."""
    on, jobs, laws = what
    return _runner_on(on)(jobs, [cloudpickle.loads(law) for law in laws])


@lru_cache(maxsize=2)
def _runner_on(packed: bytes) -> Runner:
    return Runner(*cloudpickle.loads(packed))


def workers_wanted(workers: int) -> int:
    """Return `workers`, or the number of cores for 0."""
    if workers < 0:
        raise InputError("workers", workers, "must not be negative", "Give 0 for all cores")
    return workers or os.cpu_count() or 1


_runner: Runner | None = None


def _equip(plant: Plant, settings: Settings, device: Plant | None) -> None:
    global _runner
    end_with_parent()
    _runner = Runner(plant, settings, device)


def _perform(jobs: Sequence[Job]) -> list[tuple[float, ...]]:
    assert _runner is not None
    return _runner(jobs)
