"""The task of a tuning, a TOML file that ships beside its law: which law, which knobs, which seas, which goals."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.code_files import PARAMETER, Trust, asked_for, is_file, parted
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build, home, registered
from gyroctl.harness.run_size import DT
from gyroctl.harness.tuned_sets import SEEDS_MAX, task_file
from gyroctl.names import name_of, part_of_path
from gyroctl.plant import Plant
from gyroctl.tables import check_known, checked_table, names_of, number, read_tables, table_of
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.knob import Knob, knob_of
from gyroctl.tuning.waters import LINEAR, in_water
from gyroctl.waves import SeaState
from gyroctl.waves.checks import DURATION_MAX, SEED_MAX, whole, within
from gyroctl.waves.peak_periods import in_frequencies

TABLES = ("law", "method", "fixed", "knobs", "seas", "goal", "goals", "search", "seeds")
"""Of a task; what is to be different in a water stands below its name, as [real.goal]."""
METHODS = ("evolution", "pairs")

RUNS_MAX = 10_000
"""Most points of a generation, and most realisations of a sea in it."""

MAY_BE_ZERO = ("seed", "first")
LARGEST_SEED = 2**32 - 1
"""Of the samples: what the generator of the search takes."""

SHARES = ("locked", "turns", "forward")
"""Limits of a goal that are parts of a whole."""

MAY_BE_WAIVED = ("turns", "forward")
"""Limits of a goal that ask for nothing where they are 0."""

EVERY_SEA = "all"
"""Name of the set that serves all seas of a task."""


@dataclass(frozen=True)
class TuningSea:
    """A sea of a task.

    Parameters
    ----------
    sea : SeaState
        The waves.
    weight : float
        In the score of the set for all seas.
    power : float
        Unit of the power in the score, about what a constant pair gives. [W]
    runs : int
        Realisations in each generation of the set for all seas.
    """

    sea: SeaState
    weight: float = 1.0
    power: float = 1.0
    runs: int = 4


SEAS = {
    "gamma1": TuningSea(SeaState(gamma=1.0), weight=0.35, power=1.2, runs=4),
    "gamma5": TuningSea(SeaState(gamma=5.0), weight=0.4, power=2.1, runs=4),
    "gamma50": TuningSea(SeaState(gamma=50.0), weight=0.25, power=3.9, runs=2),
}
"""Seas of a task that names none."""


@dataclass(frozen=True)
class SearchTable:
    """How the search goes.

    Parameters
    ----------
    population : int
        Points in a generation.
    spread : float
        First standard deviation, in coordinates of the knobs.
    window : float
        Length of the runs of the search, blend included. [s]
    runs : int
        Realisations in each generation of a set for one sea.
    dt : float
        Longest step of the search: statistics, not verdicts. [s]
    confirm : float
        Length of the runs that confirm. [s]
    confirm_share : float
        Part of the budget that confirming may take. [-]
    seed : int
        Of the samples.
    """

    population: int = 14
    spread: float = 0.3
    window: float = 1000.0
    runs: int = 6
    dt: float = 0.025
    confirm: float = 2000.0
    confirm_share: float = 0.3
    seed: int = 1


@dataclass(frozen=True)
class Seeds:
    """Tuning seeds: `count` from `first` on."""

    first: int = 100000
    count: int = 64

    @property
    def span(self) -> range:
        """The seeds."""
        return range(self.first, self.first + self.count)


Entries = TypeVar("Entries", SearchTable, Seeds)


@dataclass(frozen=True)
class Task:
    """What is tuned; `law` as `gyroctl.law` takes it.

    Parameters
    ----------
    law : str
        Registered name, or "file.py:Name" with its whole path.
    stem : str
        Name under which the tuned sets are kept.
    method : {"evolution", "pairs"}
        Search over the knobs, or the best constant pair.
    fixed : mapping of str to float or str
        Parameters that differ from the law's defaults and are not searched; a design model by its variant.
    knobs : tuple of Knob
        The search space.
    seas : mapping of str to TuningSea
        By the names of the sets.
    goals : mapping of str to mapping of str to Goal
        By name, "" the main one, and by sea.
    search, seeds
        How, and on which seeds.
    water : str
        For which water, see `gyroctl.tuning.waters`.
    """

    law: str
    stem: str
    method: str
    fixed: Mapping[str, float | str]
    knobs: tuple[Knob, ...]
    seas: Mapping[str, TuningSea]
    goals: Mapping[str, Mapping[str, Goal]]
    search: SearchTable = field(default_factory=SearchTable)
    seeds: Seeds = field(default_factory=Seeds)
    water: str = LINEAR

    def named(self, which: str) -> str:
        """Name under which the set for `which` seas ships."""
        if self.water == LINEAR:
            return which
        return self.water if which == EVERY_SEA else f"{self.water}-{which}"

    def at(self, x: NDArray[np.float64]) -> dict[str, Any]:
        """Parameters at a point (n,) of the search."""
        found = {knob.name: knob.value(float(value)) for knob, value in zip(self.knobs, x, strict=True)}
        return {**self.fixed, **found}

    def first(self, device: Plant | None = None) -> Law:
        """Law at the middle of the search, for a device of one's own where there is one.

        Raises
        ------
        InputError
            As `gyroctl.law`; field ``knobs.NAME`` or ``fixed.NAME`` for a parameter of the task.
        """
        try:
            return build(self.law, self.at(np.zeros(len(self.knobs))), device=device)
        except InputError as error:
            name = error.field.removeprefix(f"laws.{self.law}.")
            tables = {**dict.fromkeys(self.fixed, "fixed"), **{knob.name: "knobs" for knob in self.knobs}}
            if name == error.field or name not in tables:
                raise
            raise InputError(f"{tables[name]}.{name}", error.value, error.problem, error.mend) from None

    def at_length(self, length: float) -> Task:
        """Return the task for a device that is `length` times as long: seas, lengths of runs, steps by Froude's law.

        The knobs stay: a law is given the numbers of the device's model, in which they are meant.
        """
        if length == 1.0:
            return self
        time, power = growth("s", length), growth("W", length)
        seas = {}
        for name, one in self.seas.items():
            sea = dataclasses.replace(one.sea, hs=one.sea.hs * length, wp=one.sea.wp / time)
            seas[name] = dataclasses.replace(one, sea=sea, power=one.power * power)
        own = {name: getattr(self.search, name) * time for name in ("window", "dt", "confirm")}
        return dataclasses.replace(self, seas=seas, search=dataclasses.replace(self.search, **own))

    def served(self, which: str) -> dict[str, TuningSea]:
        """Seas that the set `which` serves: one, or all of them.

        Raises
        ------
        InputError
            For a name that is no sea of the task.
        """
        if which == EVERY_SEA:
            return dict(self.seas)
        if which not in self.seas:
            choices = ", ".join((EVERY_SEA, *self.seas))
            raise InputError("--for", which, f"is no sea of the task of {self.law}", f"Choose one of {choices}")
        one = self.seas[which]
        return {which: dataclasses.replace(one, weight=1.0, runs=self.search.runs)}


PAIRS = {"best_constant": "constant"}
"""Laws that are another law with its best numbers."""


def read_task(name: str, water: str = LINEAR, allow_code: Sequence[str | Path] = ()) -> Task:
    """Read the task of a law, or a task file.

    Parameters
    ----------
    name : str
        A registered law or "file.py:Name" with its task beside it (``tuning/NAME.toml``), or the path of a task file.
    water : str
        For which water it is meant.
    allow_code : sequence of str or Path
        Files outside the task's folder that may run, see `gyroctl.harness.code_files`. A file that is given as `name`
        may.

    Raises
    ------
    InputError
        For a law without a task, a file that cannot be read, an unknown entry, a value out of range, or a law in a file
        outside the task's folder that was not asked for.
    """
    if name.endswith(".toml"):
        path, stem = Path(name), Path(name).stem
    else:
        if is_file(name):
            allow_code = (*asked_for(allow_code), Path(parted(name)[0]))
        folder, stem = home(PAIRS.get(name, name))
        path = task_file(folder, stem)
        if not path.is_file():
            problem = f"ships no task for its tuning: there is no {path.name} in {path.parent}"
            raise InputError("law", name, problem, 'Write one, see the page "Tuning", and give its path')
    return build_task(read_tables(path, "task"), stem, path.parent, water, allow_code)


def tasked() -> list[str]:
    """Names of the registered laws that ship a task, the one that a constant pair stands for aside."""
    return [name for name in registered() if name not in PAIRS and task_file(*home(name)).is_file()]


def build_task(
    given: Mapping[str, Any],
    stem: str = "law",
    folder: Path = Path(),
    water: str = LINEAR,
    allow_code: Sequence[str | Path] = (),
) -> Task:
    """Build a task from tables as read from TOML; a law's file is relative to `folder`, from where it may run."""
    trust = Trust(folder, asked_for(allow_code))
    tables = in_water(given, water)
    check_known("", tables, TABLES)
    law = tables.get("law", stem)
    if not isinstance(law, str):
        raise InputError("law", law, "must be a name", 'Give a registered law, or "file.py:Name"')
    if is_file(law):
        law = trust.name("law", law)
        stem = parted(law)[1]
    part_of_path("law", stem)
    method = tables.get("method", METHODS[0])
    if method not in METHODS:
        raise InputError("method", method, "unknown method", f"Choose one of {', '.join(METHODS)}")
    seas = _seas(table_of(tables, "seas"))
    search = _entries(SearchTable(), "search", table_of(tables, "search"))
    if search.population < 4:
        raise InputError("search.population", search.population, "is too small to rank", "Give at least 4")
    if not 0.0 < search.confirm_share < 1.0:
        raise InputError("search.confirm_share", search.confirm_share, "must be between 0 and 1", "The default is 0.3")
    within("search.population", search.population, 4, RUNS_MAX, "The default is 14")
    within("search.runs", search.runs, 1, RUNS_MAX, "The default is 6")
    within("search.spread", search.spread, 1e-6, 1e3, "The default is 0.3")
    for name in ("window", "confirm"):
        mend = f"Give seconds; the default is {getattr(SearchTable, name):g}"
        within(f"search.{name}", getattr(search, name), 1.0, DURATION_MAX, mend)
    within("search.dt", search.dt, *DT, "Give the longest step in seconds; the default is 0.025")
    if search.seed > LARGEST_SEED:
        raise InputError("search.seed", search.seed, "is too large", f"Give at most {LARGEST_SEED}")
    for name in table_of(tables, "knobs"):
        name_of("knobs", name)
    knobs = tuple(knob_of(f"knobs.{name}", name, entry) for name, entry in table_of(tables, "knobs").items())
    if method == "evolution" and not knobs:
        mend = "Write [knobs] and below it for example cc = {start = 0.05, width = 0.3}"
        raise InputError("knobs", {}, "there is nothing to tune", mend)
    fixed = {
        name: value if isinstance(value, str) else number(f"fixed.{name}", value)
        for name, value in trust.names("fixed", table_of(tables, "fixed")).items()
    }
    for name in ("tuning", PARAMETER):
        if name in (*fixed, *(knob.name for knob in knobs)):
            raise InputError(name, name, "is no parameter to search or to fix", "Take it out of [knobs] and [fixed]")
    seeds = _entries(Seeds(), "seeds", table_of(tables, "seeds"))
    within("seeds.count", seeds.count, 1, SEEDS_MAX, "The default is 64")
    within("seeds.first", seeds.first, 0, SEED_MAX - SEEDS_MAX, "Give the first seed, for example 100000")
    return Task(law, stem, method, fixed, knobs, seas, _goals(tables, seas), search, seeds, water)


def _seas(table: Mapping[str, Any]) -> dict[str, TuningSea]:
    if not table:
        return dict(SEAS)
    seas = {}
    for name, entry in table.items():
        path = f"seas.{part_of_path('seas', name)}"
        if name == EVERY_SEA or not isinstance(entry, Mapping):
            raise InputError(path, entry, "must be a table with a name of its own", f"Write [seas.rough], not {path}")
        check_known(path, entry, ("hs", "wp", "tp", "gamma", "weight", "power", "runs"))
        entry = in_frequencies(path, entry)
        values = {key: number(f"{path}.{key}", value) for key, value in entry.items()}
        sea = SeaState(**{key: values.pop(key) for key in ("hs", "wp", "gamma") if key in values})
        for key, value in values.items():
            if value <= 0.0:
                raise InputError(f"{path}.{key}", value, "must be positive", "Leave it out for the default")
        like = next((known for known in SEAS.values() if known.sea == sea), TuningSea(sea))
        within(f"{path}.power", values.get("power", 1.0), 1e-6, 1e9, "Give about what a constant pair gives, in W")
        within(f"{path}.weight", values.get("weight", 1.0), 1e-6, 1e6, "Leave it out for the default")
        runs = whole(f"{path}.runs", values.pop("runs", like.runs), 1, RUNS_MAX, f"The default is {like.runs}")
        seas[name] = dataclasses.replace(like, sea=sea, runs=runs, **values)
    return seas


def _goals(tables: Mapping[str, Any], seas: Mapping[str, TuningSea]) -> dict[str, dict[str, Goal]]:
    main = table_of(tables, "goal")
    goals = {"": _goal("goal", main, seas)}
    for name, entry in table_of(tables, "goals").items():
        path = f"goals.{part_of_path('goals', name)}"
        goals[name] = _goal(path, {**main, **checked_table(path, entry)}, seas)
    return goals


def _goal(path: str, entry: Mapping[str, Any], seas: Mapping[str, TuningSea]) -> dict[str, Goal]:
    """Read a goal for each sea: a limit is a number for all of them, or a table of numbers by sea."""
    check_known(path, entry, names_of(Goal))
    goals = {}
    for sea in seas:
        limits = {}
        for name, value in entry.items():
            if isinstance(value, Mapping):
                check_known(f"{path}.{name}", value, seas)
                if sea not in value:
                    continue
                value = value[sea]
            limits[name] = number(f"{path}.{name}", value)
            waived = limits[name] == 0.0 and name in MAY_BE_WAIVED
            if (limits[name] <= 0.0 and not waived) or (name in SHARES and limits[name] > 1.0):
                raise InputError(f"{path}.{name}", limits[name], "is out of range", "Leave it out for the default")
        goals[sea] = Goal(**limits)
    return goals


def _entries(default: Entries, path: str, table: Mapping[str, Any]) -> Entries:
    """Return the entries of `default` with those of a table; where the default is a whole number so must they be."""
    check_known(path, table, names_of(default))
    values: dict[str, Any] = {}
    for name, given in table.items():
        value, usual = number(f"{path}.{name}", given), getattr(default, name)
        counts, none = isinstance(usual, int), value == 0.0 and name not in MAY_BE_ZERO
        if value < 0.0 or none or (counts and value != int(value)):
            problem = "must be a positive whole number" if counts else "must be positive"
            raise InputError(f"{path}.{name}", given, problem, f"The default is {usual}")
        values[name] = int(value) if counts else value
    return dataclasses.replace(default, **values)
