"""What is asked for: laws, seeds, length of the runs, and where everything goes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from gyroctl.comparison.compare import check_workers
from gyroctl.errors import InputError
from gyroctl.harness.code_files import asked_for
from gyroctl.harness.run import Settings
from gyroctl.harness.seed_ledger import ledger, refused_for
from gyroctl.names import text_of
from gyroctl.reports.layout import REFERENCE
from gyroctl.studies.evaluation.entrants import Entrant, default_entrants, parse
from gyroctl.studies.evaluation.seeds import SeedPlan, seed_plan
from gyroctl.waves.checks import DURATION_MAX, at_most, positive, within

BUDGET_MAX = 1e12
"""Largest simulated time for a search. [s]"""

BUDGET = 4e6
"""Simulated time for the search of a constant pair where none is asked for and the table has none of its own. [s]"""

DURATION = 2000.0
"""Length of the runs where none is asked for and the table has none of its own. [s]"""

RUNS, PAIRS = "runs", "pairs"
"""Folders of finished runs and of constant pairs that were found."""


@dataclass(frozen=True)
class Request:
    """Common to all tables."""

    out: Path  # folder of tables, figures and finished runs
    entrants: tuple[Entrant, ...]  # the laws, the reference aside
    plan: SeedPlan  # realisations of each law
    duration: float = DURATION  # length of the runs [s]
    workers: int | None = None  # they change no result
    tuned_on: tuple[int, ...] = ()  # seeds that no run may use
    budget: float = BUDGET  # simulated time for the search of each sea's best constant pair [s]
    settings: Settings = field(default_factory=Settings)  # steps, sensors and actuators of the nominal case
    given: frozenset[str] = frozenset()  # of laws, seeds, duration, budget what was asked for
    planner: str = "nmpc"  # the law whose information is varied
    quiet: bool = False  # no progress
    say: Callable[[str], None] = lambda _: None  # told what is being done
    only: tuple[str, ...] = ()  # cases that are run, all where none is named
    scheduler: Any = None  # address or client of other machines that make the runs; they change no result

    def usually(self, laws: str, seeds: Sequence[str], duration: float) -> Request:
        """Request of a table with these for what was not asked for; seeds of a law that takes no part are left out."""
        entrants = self.entrants if "laws" in self.given else tuple(parse(laws))
        plan = self.plan
        if "seeds" not in self.given:
            usual, part = seed_plan(seeds, tuned_on=self.tuned_on), {entrant.name for entrant in entrants}
            plan = SeedPlan(usual.common, {law: own for law, own in usual.own.items() if law in part})
        length = self.duration if "duration" in self.given else duration
        return replace(self, entrants=entrants, plan=plan, duration=length)

    def record(self) -> dict[str, Any]:
        """For the JSON files."""
        return {
            "laws": [entrant.label for entrant in self.entrants],
            "duration_s": self.duration,
            "seeds": list(self.plan.common),
            "own_seeds": {name: list(s) for name, s in self.plan.own.items()},
            "seed_states": ledger().states(self.plan.all),
            **({"only": list(self.only)} if self.only else {}),
        }


def request(
    out: Path,
    laws: str = "",
    seeds: Sequence[str] = (),
    duration: float | None = None,
    workers: int = 0,
    allow_tuning_seeds: bool = False,
    budget: float | None = None,
    planner: str = "nmpc",
    quiet: bool = False,
    say: Callable[[str], None] = lambda _: None,
    allow_code: Sequence[str | Path] = (),
    only: str = "",
) -> Request:
    """Build a request from what was typed; the files of laws that are typed may run, and `allow_code` for tuned sets.

    Parameters
    ----------
    out : Path
        Folder of tables, figures and runs.
    laws : str
        Laws with commas between, ``nmpc[information=oracle]``; all without it.
    seeds : sequence of str
        Realisations: ``1:64``, ``nmpc=1:16``, ``@gamma 5=1:8``.
    duration : float, optional
        Length of the runs. [s]
    workers : int
        0 for all cores; they change no result.
    allow_tuning_seeds : bool
        To try things out: such a table judges nothing.
    budget : float, optional
        Simulated time to find the best constant pair of a sea. [s]
    planner : str
        Law whose information is varied.
    quiet : bool
        No progress.
    say : callable
        Takes what is to be told.
    allow_code : sequence of str or Path
        Files of Python that may run.
    only : str
        Cases with commas between; all without it.

    Returns
    -------
    Request
        Checked.

    Raises
    ------
    InputError
        For laws, seeds or a duration that cannot be used, all before the first run.
    """
    given = {"laws": bool(laws), "seeds": bool(seeds), "duration": duration is not None}
    given["budget"] = budget is not None
    text_of("planner", planner)
    budget = BUDGET if budget is None else budget
    duration = DURATION if duration is None else duration
    allowed, typed = asked_for(allow_code), parse(laws) if laws else default_entrants()
    entrants = tuple(replace(entrant, allow_code=allowed) for entrant in typed if entrant.label != REFERENCE)
    built, names = [entrant.build() for entrant in entrants], [entrant.name for entrant in entrants]
    tuned_on = refused_for(built, names)
    plan = seed_plan(seeds, allow_tuning_seeds, tuned_on)
    known = {entrant.label for entrant in entrants} | {*names, planner}
    for whose in plan.own:
        name = whose.partition("@")[0]  # "nmpc@gamma 5": in that case alone; "@gamma 5": every law in it
        if name and name not in known and not any(name.startswith(f"{one}[") for one in known):
            raise InputError("seeds", name, "no law of that name takes part", f"Name one of {', '.join(sorted(known))}")
    if out.exists() and not out.is_dir():
        raise InputError("out", str(out), "is not a folder", "Give the name of a folder")
    settings = Settings()
    check_workers(workers)
    positive("budget", budget, "Give simulated seconds, for example 4e6")
    at_most("budget", budget, BUDGET_MAX, "s")
    within("duration", duration, 0.0, DURATION_MAX, "Give seconds, for example 2000")
    if not duration > settings.score_from:
        problem = f"is not longer than the blend of {settings.blend:g} s"
        raise InputError("duration", duration, problem, "Give a longer one, for example 2000")
    refused, asked = () if allow_tuning_seeds else tuned_on, frozenset(name for name, it in given.items() if it)
    return Request(
        out,
        entrants,
        plan,
        duration,
        workers or None,
        refused,
        budget,
        settings,
        asked,
        planner,
        quiet,
        say,
        tuple(name.strip() for name in only.split(",") if name.strip()),
    )
