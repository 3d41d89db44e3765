"""Tuning of laws on tuning seeds: one rule of what is good, one search, one budget of simulated time for every law.

A tuning searches on short runs of a few realisations, other ones in each generation, and then confirms a few points on
all tuning seeds with the fine step. The points are means of the search's distribution, not its best samples: the best
of hundreds of samples on a few realisations is mostly luck. Every step that has ended is kept, so that a tuning that
was stopped ends with the same numbers, and one that is given a larger budget goes on from where it was.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gyroctl.engine.cluster import connected
from gyroctl.errors import InputError
from gyroctl.fingerprint import code_of
from gyroctl.harness.law_fingerprint import law_source, value_fingerprint
from gyroctl.harness.registry import describe
from gyroctl.harness.seed_ledger import ledger
from gyroctl.names import file_in
from gyroctl.simulation.progress import Progress
from gyroctl.tuning.bench import Bench
from gyroctl.tuning.best_pair import Lengths, best_pair
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.log import TuningLog
from gyroctl.tuning.record import plant_hash, provenance, record
from gyroctl.tuning.stages import Plan, Seen, Stages, search, shortlist, weighed
from gyroctl.tuning.steps_kept import noted
from gyroctl.tuning.task import Task, TuningSea
from gyroctl.tuning.waters import Circumstances
from gyroctl.tuning.yardstick import Search

BUDGET, BUDGET_MAX = 4.0e6, 1e12
"""Simulated time for each set of each law, and the most that can be asked for. [s]"""

FEWEST, MOST = 2, 8
"""Points that are confirmed."""


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


class Start(NamedTuple):
    """A tuned set at which a search begins: what was spent on it, the search owes too. [s]"""

    name: str
    parameters: Mapping[str, float]
    spent: float


def tune(
    task: Task,
    which: str,
    on: Circumstances,
    budget: float = BUDGET,
    folder: Path | None = None,
    workers: int = 1,
    quiet: bool = False,
    start: Start | None = None,
    scheduler: Any = None,
) -> Tuned:
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
    scheduler : str or dask.distributed.Client, optional
        Of other machines that run it, "tcp://HOST:PORT"; it changes no bit of the result. Constant pairs are searched
        on this machine in any case.

    Raises
    ------
    InputError
        For seeds that judge laws, a budget too small for two points, what the law refuses, or a scheduler that does not
        answer.
    ConnectionError
        Where the scheduler is lost.
    """
    check_seeds(task, on)
    if not (np.isfinite(budget) and 0.0 < budget <= BUDGET_MAX):
        raise InputError(
            "budget", budget, f"must be a positive time, at most {BUDGET_MAX:g} s", f"The default is {BUDGET:g} s"
        )
    if task.method == "pairs":
        return _pairs(task, which, on, budget, workers, quiet)
    seas = task.served(which)
    if start:
        task = starting(task, start.parameters)
    example = task.first(on.device)
    plan = planned(task, seas, budget)
    parts = (task.stem, which, _key(task, which, on))
    log = TuningLog(file_in(folder, *parts, ending=".jsonl") if folder is not None else None)
    total = plan.generations * plan.generation + plan.points * plan.confirmation
    with (
        connected(scheduler) if scheduler is not None else nullcontext() as client,
        Bench(on.plant, on.settings, example, workers, client, on.device) as bench,
        Progress(f"tune {task.stem} for {which}", round(total), quiet) as progress,
        noted(folder, log, f"{task.stem} for {which}", plan),
    ):
        work = Stages(task, seas, on.settings.dt, bench, log, progress)
        means, archive = search(work, plan)
        points = shortlist(work, plan, means, archive)
        confirmed = [work.confirm(parameters) for parameters in points]
    searching, confirming = plan.generations * plan.generation, len(points) * plan.confirmation
    found = {
        **provenance(task, on),
        "start_from": start.name if start else "task",
        "spent_before_s": start.spent if start else 0.0,
        "budget_s": budget,
        "spent_s": searching + confirming,
        "spent_searching_s": searching,
        "spent_confirming_s": confirming,
        "search": {**asdict(task.search), "generations": plan.generations, "points_confirmed": len(points)},
    }
    sets = {}
    for name, goals in task.goals.items():
        best = chosen(confirmed, goals, seas)
        sets[f"{task.named(which)}-{name}" if name else task.named(which)] = record(best, goals, seas, task, found)
    return Tuned(sets, (*archive, *confirmed))


def check_seeds(task: Task, on: Circumstances) -> None:
    """Refuse tuning on seeds that judge laws, by the ledger or by the experiment at hand."""
    span, book = task.seeds.span, ledger()
    overlap = sorted({*book.closed_to_tuning(span), *(set(span) & on.evaluation)})
    if overlap:
        problem = f"seeds {overlap[0]} to {overlap[-1]} judge laws and must not tune them"
        mend = f"Give seeds.first = {book.judging[-1] + 1} or more, and none of the experiment"
        raise InputError("seeds", f"{span[0]} to {span[-1]}", problem, mend)


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
        problem = f"is too small: {points} confirmations and one generation take {least:g} s"
        mend = "Give more, or shorten search.window, search.confirm, search.population or seeds.count in the task"
        raise InputError("budget", budget, problem, mend)
    return Plan(generations, points, generation, confirmation)


def starting(task: Task, start: Mapping[str, float]) -> Task:
    """Return the task with its knobs at other starts."""
    knobs = tuple(knob.beginning(start.get(knob.name, knob.start)) for knob in task.knobs)
    return replace(task, knobs=knobs)


def chosen(points: Sequence[Seen], goals: Mapping[str, Goal], seas: Mapping[str, TuningSea]) -> Seen:
    """Choose the point that meets its goal in every sea, and of those the one with the best score."""

    def worth(point: Seen) -> tuple[bool, float]:
        return all(goals[name].met(point.means[name]) for name in seas), weighed(point.means, goals, seas)

    return max(points, key=worth)


def _pairs(task: Task, which: str, on: Circumstances, budget: float, workers: int, quiet: bool) -> Tuned:
    """Best constant pair of each sea apart: a pair that serves several seas would be no yardstick in any."""
    sets: dict[str, Any] = {}
    archive: list[Seen] = []
    lengths = Lengths(task.search.dt, task.search.window, task.search.confirm)
    for name in task.served(which):
        goals = task.goals[""][name]
        span, title = task.seeds.span, f"constant pair for {name}"
        sea, how = task.seas[name].sea, (workers, title, quiet, lengths)
        found = best_pair(on.plant, sea, budget, span, goals, on.settings, *how)
        archive += [Seen({"cc": cc, "cg": cg}, {name: means}, stage) for (cc, cg), means, stage in found.seen]
        best = Seen({"cc": found.cc, "cg": found.cg}, {name: found.means}, "confirm")
        key = Search(on.plant, task.seas[name].sea, on.settings, goals, budget, span).key
        circumstances = {**provenance(task, on), "budget_s": budget, "spent_s": found.spent, "key": key}
        sets[task.named(name)] = record(best, {name: goals}, {name: task.seas[name]}, task, circumstances)
    return Tuned(sets, tuple(archive))


def _key(task: Task, which: str, on: Circumstances) -> str:
    """Hash of all that can change a bit of the search but its length: by it a tuning finds itself again."""
    built = task.first(on.device)
    surroundings = [plant_hash(on.plant), on.plant.excitation.sha256, asdict(on.settings), code_of(__name__)]
    # a law is built from its name and numbers alone, so that its source tells it even where it hides a state; of files
    # their last names and contents count, so that a tuning may move
    given = value_fingerprint(task, describe(built)) or repr((task, describe(built)))
    text = json.dumps([given, which, *surroundings, law_source(built)])
    return hashlib.sha256(text.encode()).hexdigest()[:12]
