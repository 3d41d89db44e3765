"""The ledger of seeds: which realisations laws are tuned and tried on, which judge them, and which are still unused.

It stands in ``gyroctl/data/seeds.toml``, and is changed by commits alone: a reserve is declared before a run on it, and
marked spent after it. Who runs on what is told by `states`, what a law may not be judged on by `refused_for`.
"""

from __future__ import annotations

import datetime
import inspect
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

from gyroctl.errors import InputError
from gyroctl.harness.protocol import Law, Wrapping
from gyroctl.harness.registry import registered, tuned_seeds
from gyroctl.harness.tuned_sets import read_sets, seeds_of
from gyroctl.reading import read_json, read_toml

LEDGER = Path(__file__).parents[1] / "data" / "seeds.toml"

SPAN_MAX = 1_000_000
"""Most seeds of an entry."""

State = Literal["tuning", "exploration", "spent", "reserve"]

TRIED: tuple[State, ...] = ("tuning", "exploration")
"""States of seeds that may not judge a law."""

MEANING: Mapping[str, str] = {
    "tuning": "laws were tuned on them",
    "exploration": "laws were tried on them",
    "spent": "laws were changed after results on them were known",
    "reserve": "declared, and no result on them was known: mark them spent",
}
"""States in words, for pages and tables."""


class Entry(NamedTuple):
    """Seeds from `first` to `last` in one state, since when and for what."""

    first: int
    last: int
    state: State
    since: datetime.date
    use: str

    @property
    def span(self) -> range:
        """The seeds."""
        return range(self.first, self.last + 1)


class Ledger(NamedTuple):
    """Entries in ascending order, no two of which overlap, and the seeds that are kept for judging."""

    judging: range
    entries: tuple[Entry, ...]

    def state(self, seed: int) -> State | None:
        """State of a seed, None where it is in no entry."""
        return next((entry.state for entry in self.entries if seed in entry.span), None)

    def among(self, seeds: Iterable[int], *wanted: State) -> list[int]:
        """Those of the seeds that are in one of these states, in ascending order."""
        return sorted(seed for seed in seeds if self.state(seed) in wanted)

    def states(self, seeds: Iterable[int]) -> dict[str, list[int]]:
        """Seeds by their state, those that are in no entry as ``unlisted``."""
        found: dict[str, list[int]] = {}
        for seed in sorted(seeds):
            found.setdefault(self.state(seed) or "unlisted", []).append(seed)
        return found

    def closed_to_tuning(self, seeds: Iterable[int]) -> list[int]:
        """Those of the seeds on which no law may be tuned, in ascending order."""
        return sorted(s for s in seeds if s in self.judging or self.state(s) in ("spent", "reserve"))

    def tried(self) -> set[int]:
        """Seeds that may not judge a law."""
        return {seed for entry in self.entries if entry.state in TRIED for seed in entry.span}


@lru_cache(maxsize=1)
def ledger() -> Ledger:
    """Ledger of this package."""
    return read_ledger(LEDGER)


def read_ledger(path: Path) -> Ledger:
    """Read a ledger.

    Raises
    ------
    InputError
        For a file that is none: an unknown state, a range that ends before it begins, or ranges that overlap.
    """
    tables = read_toml("ledger", path, "Restore it from the repository")
    try:
        judging = tables["judging"]["first"], tables["judging"]["last"]
        listed = [Entry(**table) for table in tables["seeds"]]
    except (KeyError, TypeError) as error:
        raise InputError("ledger", str(path), f"cannot be read: {error}", "Restore it from the repository") from None
    if not _are_seeds(*judging):
        raise InputError("ledger", judging, "are no seeds for judging", "Give whole numbers, first <= last")
    for entry in listed:
        if entry.state not in get_args(State):
            raise InputError("ledger", entry.state, "unknown state", f"Choose one of {', '.join(get_args(State))}")
        told = isinstance(entry.since, datetime.date) and isinstance(entry.use, str) and entry.use
        if not (_are_seeds(entry.first, entry.last) and told):
            mend = "Give first <= last, a date as since, and what the seeds are for as use"
            raise InputError("ledger", entry, "is no entry", mend)
    entries = sorted(listed, key=lambda entry: entry.first)
    for one, other in pairwise(entries):
        if other.first <= one.last:
            problem = f"overlaps {one.first} to {one.last}"
            raise InputError("ledger", f"{other.first} to {other.last}", problem, "Give every seed one state")
    return Ledger(range(judging[0], judging[1] + 1), tuple(entries))


def _are_seeds(first: object, last: object) -> bool:
    """Whether these are the ends of a span of seeds; one of which they are listed must fit into the memory."""
    return type(first) is int and type(last) is int and 0 <= first <= last < first + SPAN_MAX


def all_tuning_seeds() -> tuple[int, ...]:
    """Seeds on which any registered law was tuned.

    The tuned sets beside a law tell; packages of laws that were tuned in another way tell by a function `tuning_seeds`.
    """
    seeds: set[int] = set()
    for name, point in registered().items():
        seeds |= tuned_seeds(name)
        package = inspect.getmodule(point.load())
        for module in (package, import_module(point.module)):
            tell = getattr(module, "tuning_seeds", None)
            if callable(tell):
                seeds |= set(tell())
    return tuple(sorted(seeds))


def refused_for(laws: Iterable[Law], names: Iterable[str] = ()) -> tuple[int, ...]:
    """Seeds on which these laws may not be judged, in ascending order.

    Parameters
    ----------
    laws : iterable of Law
        The laws; what was tuned beside the file of each, or of a law within it, counts.
    names : iterable of str
        Names from which they were built, "file.py:Name" among them, as far as they are known.

    Returns
    -------
    tuple of int
        Those that the ledger keeps for tuning and trying, those of every registered law, and those of these laws.
    """
    seeds = ledger().tried() | set(all_tuning_seeds())
    for law in laws:
        seeds |= seeds_beside(law)
    for name in names:
        seeds |= tuned_seeds(name)
    return tuple(sorted(seeds))


def seeds_beside(law: Law) -> set[int]:
    """Seeds of the tuned sets beside the file of a law: of every name that this file defines or uses."""
    seeds: set[int] = set()
    for one in _layers(law):
        for function in _functions(type(one)):
            folder = Path(function.__code__.co_filename).parent / "tuned"
            for path in sorted(folder.glob("*.json")) if folder.is_dir() else ():
                if path.stem in function.__globals__ or path.stem == type(one).__name__:
                    seeds |= seeds_of(_sets(path))
    return seeds


def _layers(law: Law) -> Iterator[Law]:
    yield law
    while isinstance(law, Wrapping):
        law = law.law
        yield law


def _functions(kind: type[Any]) -> Iterator[Any]:
    """Functions that a class has of its own or inherits: a class may take its step from another file."""
    for owner in kind.__mro__:
        yield from (value for value in vars(owner).values() if inspect.isfunction(value))


def _sets(path: Path) -> dict[str, Any]:
    """Tuned sets of a file; a JSON file of another kind has none."""
    try:
        content = read_json("tuned", path, "Write it anew with gyroctl tune")
    except InputError:
        return {}
    known = isinstance(content, Mapping) and "sets" in content
    return read_sets(path) if known else {}
