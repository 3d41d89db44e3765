"""The stages of a tuning: the search on few short runs, what is worth confirming, and its confirmation on all seeds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from cmaes import CMA
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.reading import is_finite
from gyroctl.simulation.progress import Progress
from gyroctl.tuning.bench import Bench, Job
from gyroctl.tuning.goal import METRICS, Goal
from gyroctl.tuning.log import MEND, TuningLog
from gyroctl.tuning.task import Task, TuningSea

SETTLED = 0.55
"""Part of the search after which its means are worth confirming."""

Means = dict[str, float]


class Seen(NamedTuple):
    """A point that was run.

    Parameters
    ----------
    parameters : mapping
        Of the law.
    means : mapping of str to mapping
        Means of `METRICS` by sea.
    stage : {"search", "confirm"}
        On a few short runs, or on all tuning seeds with the fine step.
    """

    parameters: dict[str, float]
    means: dict[str, Means]
    stage: str


class Plan(NamedTuple):
    """How a budget is spent, in simulated time. [s]"""

    generations: int
    points: int
    generation: float
    confirmation: float


class Stages(NamedTuple):
    """What the stages share: task, seas of the set, step of the confirming runs [s], workers, log, progress bar."""

    task: Task
    seas: Mapping[str, TuningSea]
    dt: float
    bench: Bench
    log: TuningLog
    progress: Progress

    def generation(self, number: int, points: Sequence[Mapping[str, float]]) -> list[dict[str, Means]]:
        """Means by sea of each point on the realisations of a generation, which move on over all seeds."""
        span, jobs = self.task.seeds.span, []
        for sea in self.seas.values():
            for i in range(sea.runs):
                seed = span[(number * sea.runs + i) % len(span)]
                jobs += [self._job(point, sea, seed, self.task.search.window, self.task.search.dt) for point in points]
        rows = iter(self._run(f"search {number}", jobs))
        tables = {
            name: np.array([[next(rows) for _ in points] for _ in range(sea.runs)]) for name, sea in self.seas.items()
        }
        return [{name: _means(table[:, i]) for name, table in tables.items()} for i in range(len(points))]

    def confirm(self, point: dict[str, float]) -> Seen:
        """Means by sea of a point on all seeds with the fine step."""
        span, dt = self.task.seeds.span, self.dt
        jobs = [
            self._job(point, sea, seed, self.task.search.confirm, dt) for sea in self.seas.values() for seed in span
        ]
        rows = self._run("confirm " + json.dumps(point, sort_keys=True), jobs)
        count = len(span)
        parts = {name: np.array(rows[i * count : (i + 1) * count]) for i, name in enumerate(self.seas)}
        return Seen(point, {name: _means(part) for name, part in parts.items()}, "confirm")

    def _job(self, point: Mapping[str, float], sea: TuningSea, seed: int, duration: float, dt: float) -> Job:
        return Job(self.task.law, tuple(sorted(point.items())), sea.sea, seed, duration, dt)

    def _run(self, key: str, jobs: Sequence[Job]) -> list[tuple[float, ...]]:
        stored = stored_rows(self.log, key, len(jobs))
        if stored is not None:
            self.progress.total -= round(sum(job.duration for job in jobs))
            return stored
        rows = self.bench.perform(jobs, lambda job: self.progress.advance(round(job.duration)))
        self.log.add(key, rows)
        return rows


def stored_rows(log: TuningLog, key: str, count: int) -> list[tuple[float, ...]] | None:
    """Rows of `METRICS` of the `count` runs of a step, or None where it has not been run.

    Raises
    ------
    InputError
        For a step that was kept otherwise: its numbers would be taken for those of the runs.
    """
    stored = log.get(key)
    if stored is None:
        return None
    rows = [tuple(row) if isinstance(row, list | tuple) else () for row in stored] if isinstance(stored, list) else []
    whole = all(len(row) == len(METRICS) and all(map(is_finite, row)) for row in rows)
    if len(rows) != count or not whole:
        raise InputError("out", f"{log.path}: {key[:60]}", f"is no table of {count} runs", MEND)
    return rows


def search(work: Stages, plan: Plan) -> tuple[list[NDArray[np.float64]], list[Seen]]:
    """Search by covariance matrix adaptation; return its mean after each generation and every point that was run.

    The strategy of Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772. The loss of lock is a cliff, and
    the score of a few realisations is noisy, so that gradients and simplices stall. Its samples depend on the seed and
    on the scores alone: gone through again from its log, a search is the same.
    """
    task, table, goals = work.task, work.task.search, work.task.goals[""]
    strategy = CMA(np.zeros(len(task.knobs)), table.spread, seed=table.seed, population_size=table.population)
    means, archive = [], []
    for number in range(plan.generations):
        points = [strategy.ask() for _ in range(table.population)]
        parameters = [task.at(point) for point in points]
        found = work.generation(number, parameters)
        strategy.tell(ranked(points, [weighed(entry, goals, work.seas) for entry in found]))
        means.append(strategy.mean.copy())
        archive += [Seen(p, entry, "search") for p, entry in zip(parameters, found, strict=True)]
    return means, archive


def ranked(points: Sequence[NDArray[np.float64]], scores: Sequence[float]) -> list[tuple[NDArray[np.float64], float]]:
    """Points with their ranks, 0 for the highest score; of no number, the last ones."""
    order = np.argsort(-np.array(scores), kind="stable")
    return [(points[best], float(rank)) for rank, best in enumerate(order)]


def shortlist(
    work: Stages, plan: Plan, means: Sequence[NDArray[np.float64]], archive: Sequence[Seen]
) -> list[dict[str, float]]:
    """Points to confirm: the start, means of the later search, and for each further goal the middle of its best points.

    The start is among them lest a search ship what is worse.
    """
    task = work.task
    count = plan.points - len(task.goals)
    parts = np.linspace(1.0, SETTLED, count) if len(means) > 1 else np.ones(1)
    later = [task.at(means[round(part * (len(means) - 1))]) for part in parts]
    points = [task.at(np.zeros(len(task.knobs))), *later]
    for name, goals in task.goals.items():
        if name:
            order = sorted(archive, key=lambda seen: weighed(seen.means, goals, work.seas), reverse=True)
            points.append(_middle(task, [seen.parameters for seen in order[: task.search.population // 2]]))
    return [point for i, point in enumerate(points) if point not in points[:i]]


def _middle(task: Task, points: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Mean of points in the coordinates of the search: less a matter of luck than the best of them."""
    x = np.array([[knob.coordinate(point[knob.name]) for knob in task.knobs] for point in points])
    return task.at(x.mean(axis=0))


def _means(rows: NDArray[np.float64]) -> Means:
    return dict(zip(METRICS, (float(value) for value in rows.mean(axis=0)), strict=True))


def weighed(means: Mapping[str, Means], goals: Mapping[str, Goal], seas: Mapping[str, TuningSea]) -> float:
    """Score over the seas by their weights."""
    return sum(sea.weight * goals[name].score(means[name], sea.power) for name, sea in seas.items())
