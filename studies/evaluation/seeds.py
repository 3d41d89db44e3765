"""Which realisations each law is judged on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from gyroctl.errors import InputError
from gyroctl.harness.seed_ledger import MEANING, ledger
from gyroctl.reports.wording import seed_ranges

SEEDS_MAX = 100_000
"""Most realisations of one law."""

MEND = "Give for example 1:64, or nmpc=1:16 for one law"


class SeedPlan(NamedTuple):
    """Seeds of all laws, and those of laws that have their own."""

    common: tuple[int, ...]  # for every law that is not named
    own: Mapping[str, tuple[int, ...]]  # for laws that are too slow for all of them, and for cases of a table

    def of(self, *names: str, case: str = "") -> tuple[int, ...]:
        """Seeds of the law that has these names: its own in the case, its own, those of the case, the common ones."""
        asked = [*(f"{name}@{case}" for name in names if case), *names, f"@{case}"]
        return next((self.own[name] for name in asked if name in self.own), self.common)

    def in_case(self, case: str) -> tuple[int, ...]:
        """Every seed that some law may meet in a case, in order: those of the reference there."""
        own = [seeds for name, seeds in self.own.items() if name.partition("@")[2] in ("", case)]
        return tuple(sorted(set(self.of(case=case)).union(*own)))

    @property
    def all(self) -> tuple[int, ...]:
        """Every seed, in order."""
        return tuple(sorted(set(self.common).union(*self.own.values())))


def seed_plan(texts: Iterable[str], allow_tuning: bool = False, tuned_on: Sequence[int] = ()) -> SeedPlan:
    """Read seeds as they are given on the command line.

    Parameters
    ----------
    texts : iterable of str
        ``1:64`` (both ends included), ``1,5,9``, or with a law in front, ``nmpc=1:16``; for one case of a table,
        ``nmpc@gamma 5=1:200``, or ``@gamma 5=1:200`` for every law that has none of its own.
    allow_tuning : bool
        Accept seeds that are kept for tuning: to try things out, never to judge.
    tuned_on : sequence of int
        Further seeds on which a law was tuned.

    Raises
    ------
    InputError
        Field ``seeds``: what is no seed, repeats, or was used for tuning.
    """
    common, own = tuple(range(1, 65)), {}
    for text in texts:
        name, equals, numbers = text.rpartition("=")
        seeds = _seeds(text, numbers)
        if equals:
            own[name.strip()] = seeds
        else:
            common = seeds
    plan = SeedPlan(common, own)
    used = sorted(set(plan.all) & (ledger().tried() | set(tuned_on)))
    if used and not allow_tuning:
        mend = "Choose others, for example 1:64, or try things out with --allow-tuning-seeds"
        raise InputError("seeds", f"{used[0]} to {used[-1]}", "are kept for tuning and cannot judge a law", mend)
    return plan


def states_in_words(seeds: Sequence[int]) -> str:
    """What the ledger says of seeds: ``1 to 64: spent, laws were changed after results on them were known``."""
    parts = []
    for state, some in ledger().states(seeds).items():
        meaning = MEANING.get(state, "in no entry of the ledger")
        parts.append(f"{seed_ranges(tuple(some))}: {state}, {meaning}")
    return "; ".join(parts)


def _seeds(text: str, numbers: str) -> tuple[int, ...]:
    found: list[int] = []
    for part in numbers.split(","):
        first, colon, last = part.strip().partition(":")
        if not first.isdecimal() or (colon and not last.isdecimal()):
            raise InputError("seeds", text, f"{part.strip() or 'nothing'} is no seed and no range of seeds", MEND)
        many = int(last) - int(first) if colon else 0
        if many + len(found) >= SEEDS_MAX:
            raise InputError("seeds", text, f"are more than {SEEDS_MAX} realisations", MEND)
        found += range(int(first), int(last) + 1) if colon else [int(first)]
    if not found or len(set(found)) < len(found):
        raise InputError("seeds", text, "is empty or repeats a seed", MEND)
    return tuple(sorted(found))
