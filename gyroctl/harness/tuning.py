"""Tuning of laws on tuning seeds: one rule of what is good, one search, one budget of simulated time for every law.

A tuning searches on short runs of a few realisations, other ones in each generation, and then confirms a few points on
all tuning seeds with the fine step. The points are means of the search's distribution, not its best samples: the best
of hundreds of samples on a few realisations is mostly luck. Every step that has ended is kept, so that a tuning that
was stopped ends with the same numbers, and one that is given a larger budget goes on from where it was.
"""

from __future__ import annotations

import datetime
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness import actuation, evolution, goal, loop, sensing, tuning_bench, tuning_task
from gyroctl.harness.constant_pair import best_pair
from gyroctl.harness.goal import METRICS, Goal
from gyroctl.harness.law_content import content
from gyroctl.harness.laws import describe, law
from gyroctl.harness.robustness import wilson
from gyroctl.harness.run import Settings
from gyroctl.harness.tuning_bench import Bench, Job, named
from gyroctl.harness.tuning_log import TuningLog
from gyroctl.harness.tuning_task import Task, TuningSea
from gyroctl.plant import Plant
from gyroctl.plant.compiled import source_stamp
from gyroctl.plant.kernel import SOURCES
from gyroctl.simulation import lock, metrics
from gyroctl.simulation.progress import Progress

BUDGET = 4.0e6
"""Simulated time for each set of each law. [s]"""

EVALUATION = range(0, 10000)
"""Seeds that are kept for judging laws: no law may be tuned on them."""

FEWEST, MOST = 2, 8
"""Points that are confirmed."""

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


@dataclass(frozen=True)
class Tuned:
    """A tuning that has ended.

    Parameters
    ----------
    sets : mapping of str to mapping
        What ships: by name, with ``parameters``, ``goal``, ``result`` and ``found``.
    archive : tuple of Seen
        Every point that was run.
    """

    sets: Mapping[str, Any]
    archive: tuple[Seen, ...] = ()


@dataclass(frozen=True)
class Circumstances:
    """On what a law is tuned.

    Parameters
    ----------
    plant : Plant
        The device.
    settings : Settings
        Steps of the confirming runs, sensors, actuators.
    evaluation : frozenset of int
        Seeds beside `EVALUATION` that must not be tuned on.
    """

    plant: Plant
    settings: Settings = field(default_factory=Settings)
    evaluation: frozenset[int] = frozenset()


class Start(NamedTuple):
    """A tuned set at which a search begins: what was spent on it, the search owes too. [s]"""

    name: str
    parameters: Mapping[str, float]
    spent: float


class Plan(NamedTuple):
    """How a budget is spent, in simulated time. [s]"""

    generations: int
    points: int
    generation: float
    confirmation: float


def tune(
    task: Task, which: str, on: Circumstances, budget: float = BUDGET, folder: Path | None = None, workers: int = 1,
    quiet: bool = False, start: Start | None = None,
) -> Tuned:  # fmt: skip
    """Tune a law for all seas of its task, or for one of them.

    Parameters
    ----------
    task : Task
        What is tuned.
    which : str
        "all", or a sea of the task.
    on : Circumstances
        Plant, settings, seeds to keep away from.
    budget : float
        Simulated time that may be spent. [s]
    folder : Path, optional
        Where the steps are kept; a tuning that is found there goes on.
    workers : int
        Threads or processes; they change no bit of the result.
    quiet : bool
        Show no progress.
    start : Start, optional
        Where the search begins instead of at the task's start.

    Raises
    ------
    InputError
        For seeds that judge laws, a budget too small for two points, or what the law refuses.
    """
    check_seeds(task, on)
    if not (np.isfinite(budget) and budget > 0.0):
        raise InputError("budget", budget, "must be a positive time", f"The default is {BUDGET:g} s")
    if task.method == "pairs":
        return _pairs(task, which, on, budget, workers, quiet)
    seas = task.served(which)
    if start:
        task = starting(task, start.parameters)
    example = law(task.law, None, **task.at(np.zeros(len(task.knobs))))
    plan = planned(task, seas, budget)
    log = TuningLog(folder / f"{task.stem}.{which}.{_key(task, which, on)}.jsonl" if folder is not None else None)
    total = plan.generations * plan.generation + plan.points * plan.confirmation
    with (
        Bench(on.plant, on.settings, example, workers) as bench,
        Progress(f"tune {task.stem} for {which}", round(total), quiet) as progress,
    ):
        work = _Work(task, seas, on, bench, log, progress)
        means, archive = _search(work, plan)
        points = _shortlist(work, plan, means, archive)
        confirmed = [work.confirm(parameters) for parameters in points]
    found = {
        **_provenance(task, on), "start_from": start.name if start else "task",
        "spent_before_s": start.spent if start else 0.0, "budget_s": budget,
        "spent_s": plan.generations * plan.generation + len(points) * plan.confirmation,
        "spent_searching_s": plan.generations * plan.generation,
        "spent_confirming_s": len(points) * plan.confirmation,
        "search": {**asdict(task.search), "generations": plan.generations, "points_confirmed": len(points)},
    }  # fmt: skip
    sets = {}
    for name, goals in task.goals.items():
        best = chosen(confirmed, goals, seas)
        sets[f"{which}-{name}" if name else which] = _set(best, goals, seas, task, found)
    return Tuned(sets, (*archive, *confirmed))


def check_seeds(task: Task, on: Circumstances) -> None:
    """Refuse tuning on seeds that judge laws."""
    span = task.seeds.span
    overlap = sorted(set(span) & (set(EVALUATION) | on.evaluation))
    if overlap:
        raise InputError("seeds", f"{span[0]} to {span[-1]}",
                         f"seeds {overlap[0]} to {overlap[-1]} judge laws and must not tune them",
                         f"Give seeds.first = {EVALUATION[-1] + 1} or more, and none of the experiment")  # fmt: skip


def planned(task: Task, seas: Mapping[str, TuningSea], budget: float) -> Plan:
    """Share a budget between search and confirmation."""
    table = task.search
    confirmation = len(seas) * task.seeds.count * table.confirm
    generation = table.population * sum(sea.runs for sea in seas.values()) * table.window
    extra = len(task.goals) - 1
    points = min(max(int(table.confirm_share * budget / confirmation), FEWEST + extra), MOST + extra)
    generations = int((budget - points * confirmation) / generation)
    if generations < 1:
        least = points * confirmation + generation
        raise InputError(
            "budget", budget, f"is too small: {points} confirmations and one generation take {least:g} s",
            "Give more, or shorten search.window, search.confirm, search.population or seeds.count in the task",
        )  # fmt: skip
    return Plan(generations, points, generation, confirmation)


def starting(task: Task, start: Mapping[str, float]) -> Task:
    """Return the task with its knobs at other starts."""
    knobs = tuple(knob.beginning(start.get(knob.name, knob.start)) for knob in task.knobs)
    return Task(**{**task.__dict__, "knobs": knobs})


def chosen(points: Sequence[Seen], goals: Mapping[str, Goal], seas: Mapping[str, TuningSea]) -> Seen:
    """Choose the point that meets its goal in every sea, and of those the one with the best score."""

    def worth(point: Seen) -> tuple[bool, float]:
        met = all(goals[name].met(point.means[name]) for name in seas)
        return met, weighed(point.means, goals, seas)

    return max(points, key=worth)


def weighed(means: Mapping[str, Means], goals: Mapping[str, Goal], seas: Mapping[str, TuningSea]) -> float:
    """Score over the seas by their weights."""
    return sum(sea.weight * goals[name].score(means[name], sea.power) for name, sea in seas.items())


class _Work(NamedTuple):
    """What the stages of a tuning share."""

    task: Task
    seas: Mapping[str, TuningSea]
    on: Circumstances
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
        tables = {name: np.array([[next(rows) for _ in points] for _ in range(sea.runs)])
                  for name, sea in self.seas.items()}  # fmt: skip
        return [{name: _means(table[:, i]) for name, table in tables.items()} for i in range(len(points))]

    def confirm(self, point: dict[str, float]) -> Seen:
        """Means by sea of a point on all seeds with the fine step."""
        span, dt = self.task.seeds.span, self.on.settings.dt
        jobs = [
            self._job(point, sea, seed, self.task.search.confirm, dt) for sea in self.seas.values() for seed in span
        ]
        rows = self._run("confirm " + json.dumps(point, sort_keys=True), jobs)
        count = len(span)
        parts = {name: np.array(rows[i * count : (i + 1) * count]) for i, name in enumerate(self.seas)}
        return Seen(point, {name: _means(part) for name, part in parts.items()}, "confirm")

    def _job(self, point: Mapping[str, float], sea: TuningSea, seed: int, duration: float, dt: float) -> Job:
        return Job(self.task.law, named(point), sea.sea, seed, duration, dt)

    def _run(self, key: str, jobs: Sequence[Job]) -> list[tuple[float, ...]]:
        stored = self.log.get(key)
        if stored is not None:
            self.progress.total -= round(sum(job.duration for job in jobs))
            return [tuple(row) for row in stored]
        rows = self.bench.perform(jobs, lambda job: self.progress.advance(round(job.duration)))
        self.log.add(key, rows)
        return rows


def _search(work: _Work, plan: Plan) -> tuple[list[NDArray[np.float64]], list[Seen]]:
    """Run the search; return its mean after each generation and every point that was run."""
    task, table, goals = work.task, work.task.search, work.task.goals[""]
    search = evolution.begin(np.zeros(len(task.knobs)), table.spread)
    means, archive = [], []
    for number in range(plan.generations):
        points = evolution.ask(search, table.population, table.seed)
        parameters = [task.at(point) for point in points]
        found = work.generation(number, parameters)
        scores = np.array([weighed(entry, goals, work.seas) for entry in found])
        search = evolution.tell(search, points, scores)
        means.append(search.mean)
        archive += [Seen(p, entry, "search") for p, entry in zip(parameters, found, strict=True)]
    return means, archive


def _shortlist(
    work: _Work, plan: Plan, means: Sequence[NDArray[np.float64]], archive: Sequence[Seen]
) -> list[dict[str, float]]:
    """Points to confirm: means of the later search, and for each further goal the middle of its best points."""
    task = work.task
    count = plan.points - (len(task.goals) - 1)
    parts = np.linspace(SETTLED, 1.0, count) if len(means) > 1 else np.ones(1)
    points = [task.at(means[round(part * (len(means) - 1))]) for part in parts]
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


def _set(
    best: Seen, goals: Mapping[str, Goal], seas: Mapping[str, TuningSea], task: Task, found: Mapping[str, Any]
) -> dict[str, Any]:
    """One set as it ships."""
    return {
        "parameters": best.parameters,
        "goal": {name: {key: value for key, value in asdict(goals[name]).items() if np.isfinite(value)}
                 for name in seas},
        "met": {name: goals[name].met(best.means[name]) for name in seas},
        "result": {name: result(best.means[name], task.seeds.count) for name in seas},
        "found": dict(found),
    }  # fmt: skip


def result(means: Means, runs: int) -> dict[str, Any]:
    """Means as they ship, with the Wilson interval of the lock probability."""
    share = wilson(round(means["locked"] * runs), runs)
    rounded = {name: float(f"{value:.4g}") for name, value in means.items() if name != "short_reserve"}
    return {**rounded, "runs": runs, "locked_ci95": [round(share.low, 4), round(share.high, 4)]}


def _pairs(task: Task, which: str, on: Circumstances, budget: float, workers: int, quiet: bool) -> Tuned:
    """Best constant pair of each sea apart: a pair that serves several seas would be no yardstick in any."""
    sets: dict[str, Any] = {}
    archive: list[Seen] = []
    names = list(task.seas) if which == tuning_task.EVERY_SEA else list(task.served(which))
    for name in names:
        goals = task.goals[""][name]
        found = best_pair(on.plant, task.seas[name].sea, budget, task.seeds.span, goals, on.settings, workers,
                          f"constant pair for {name}", quiet)  # fmt: skip
        archive += [Seen({"cc": cc, "cg": cg}, {name: means}, stage) for (cc, cg), means, stage in found.seen]
        best = Seen({"cc": found.cc, "cg": found.cg}, {name: found.means}, "confirm")
        circumstances = {
            **_provenance(task, on), "budget_s": budget, "spent_s": found.spent,
        }  # fmt: skip
        sets[name] = _set(best, {name: goals}, {name: task.seas[name]}, task, circumstances)
    return Tuned(sets, tuple(archive))


def _provenance(task: Task, on: Circumstances) -> dict[str, Any]:
    from gyroctl import __version__

    return {
        "date": datetime.date.today().isoformat(),
        "version": __version__,
        "seeds": {"first": task.seeds.span[0], "last": task.seeds.span[-1]},
        "method": task.method,
        "rule": " ".join((Goal.score.__doc__ or "").split()),
        "seas": {name: asdict(sea) for name, sea in task.seas.items()},
        "start": {knob.name: knob.start for knob in task.knobs},
        "plant": on.plant.name,
        "plant_sha256": plant_hash(on.plant),
        "hydrodynamics_sha256": on.plant.excitation.sha256,
    }


def plant_hash(plant: Plant) -> str:
    """SHA-256 of every number of the plant's equations."""
    return hashlib.sha256(json.dumps([plant.coefficients, asdict(plant.parameters)]).encode()).hexdigest()


def _key(task: Task, which: str, on: Circumstances) -> str:
    """Hash of all that can change a bit of the search but its length: by it a tuning finds itself again."""
    engine = (evolution, goal, tuning_bench, tuning_task, loop, sensing, actuation, metrics, lock)
    stamp = source_stamp((__file__, *SOURCES, *(str(part.__file__) for part in engine)))
    built = law(task.law, None, **task.at(np.zeros(len(task.knobs))))
    text = json.dumps([
        repr(task), which, plant_hash(on.plant), on.plant.excitation.sha256, asdict(on.settings), stamp, content(built),
        repr(describe(built)),
    ])  # fmt: skip
    return hashlib.sha256(text.encode()).hexdigest()[:12]
