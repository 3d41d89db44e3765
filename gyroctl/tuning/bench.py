"""The runs of a tuning, on threads (compiled laws) or processes (others): their number changes no bit of any result."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace
from multiprocessing import get_context
from types import TracebackType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law, LawError
from gyroctl.harness.registry import build
from gyroctl.harness.run import Settings, lead_in
from gyroctl.harness.together import Loop, Outcome, pieces, run_together
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

    def __call__(self, jobs: Sequence[Job]) -> list[tuple[float, ...]]:
        """Run jobs, side by side where that is possible, and return the `METRICS` of each."""
        loops = [self._loop(job) for job in jobs]
        outcomes = run_together(self.plant, loops)
        return [self._metrics(loop.waves, outcome) for loop, outcome in zip(loops, outcomes, strict=True)]

    def _loop(self, job: Job) -> Loop:
        parameters: dict[str, Any] = dict(job.parameters)
        built = build(job.law, parameters, device=self.device)
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
    longest = STEADY / float(slip_rate(plant.coefficients, largest))
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
    device : Plant, optional
        The device that the laws are built for, where it is one of one's own.
    """

    def __init__(
        self, plant: Plant, settings: Settings, example: Law, workers: int, device: Plant | None = None
    ) -> None:
        self.runner = Runner(plant, settings, device)
        self.workers = max(1, workers)
        self.compiled = compile_law(example) is not None
        self.pool: Executor | None = None
        self.call: Callable[[Sequence[Job]], list[tuple[float, ...]]] = self.runner
        if self.workers > 1 and self.compiled:
            self.pool = ThreadPoolExecutor(self.workers)
        elif self.workers > 1:
            self.pool = ProcessPoolExecutor(
                self.workers, mp_context=get_context("spawn"), initializer=_equip, initargs=(plant, settings, device)
            )
            self.call = _perform

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Drop what is not under way."""
        if self.pool is not None:
            self.pool.shutdown(wait=kind is None, cancel_futures=True)

    def perform(self, jobs: Sequence[Job], done: Callable[[Job], None]) -> list[tuple[float, ...]]:
        """Metrics of each job in the order of the jobs; `done` is told of each one that has ended."""
        batches = self._batches(jobs)
        work = [[jobs[number] for number in batch] for batch in batches]
        rows = map(self.call, work) if self.pool is None else self.pool.map(self.call, work)
        found: dict[int, tuple[float, ...]] = {}
        for batch, some in zip(batches, rows, strict=True):
            for number, row in zip(batch, some, strict=True):
                found[number] = row
                done(jobs[number])
        return [found[number] for number in range(len(jobs))]

    def _batches(self, jobs: Sequence[Job]) -> list[list[int]]:
        """Numbers of the jobs that are run side by side: evenly for the workers, and few enough for the lanes."""
        if not self.compiled:
            return [[number] for number in range(len(jobs))]
        numbers = list(range(len(jobs)))
        return [numbers[part] for part in pieces(len(jobs), self.workers)]


def workers_wanted(workers: int) -> int:
    """Return `workers`, or the number of cores for 0."""
    if workers < 0:
        raise InputError("workers", workers, "must not be negative", "Give 0 for all cores")
    return workers or os.cpu_count() or 1


_runner: Runner | None = None


def _equip(plant: Plant, settings: Settings, device: Plant | None) -> None:
    global _runner
    _runner = Runner(plant, settings, device)


def _perform(jobs: Sequence[Job]) -> list[tuple[float, ...]]:
    assert _runner is not None
    return _runner(jobs)
