"""The order of the laws in a case, whether it can be told, and what becomes of it and of lock in another case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Literal, NamedTuple

import numpy as np

from gyroctl.statistics import CONFIDENCE, Estimate, PairedDifference, holm, paired_difference
from gyroctl.statistics import in_words as difference_in_words
from gyroctl.studies.evaluation.cases import Runs, common_seeds

MORE = ("more", "less")

HOLDS = 0.9
"""Share of its runs in which a law holds lock that is said to hold it."""

LEVEL = 1.0 - CONFIDENCE
"""Of the tests of a case together."""


@dataclass(frozen=True)
class Order:
    """Laws of a case by mean power, and the paired difference of every two of them."""

    laws: tuple[str, ...]  # the one with the most power first
    pairs: tuple[PairedDifference, ...]  # the law with more power first; Holm over all pairs of the case [W]

    def pair(self, one: str, other: str) -> PairedDifference:
        """Difference of two laws, the one with more power first."""
        return next(pair for pair in self.pairs if {pair.first, pair.second} == {one, other})

    @property
    def words(self) -> str:
        """Write the order: ``>`` between neighbours that can be told apart, ``≈`` between others."""
        signs = [">" if told(self.pair(one, other)) else "≈" for one, other in pairwise(self.laws)]
        return self.laws[0] + "".join(f" {sign} {law}" for sign, law in zip(signs, self.laws[1:], strict=True))


Kind = Literal["turned", "parted", "blurred", "exchanged"]


class Change(NamedTuple):
    """Two laws that stand to each other otherwise than in the linear plant.

    "turned": told apart there and here, the other way round; "parted": told apart only here; "blurred": told apart
    only there; "exchanged": the other way round within what chance explains.
    """

    kind: Kind
    first: str  # has more power here
    second: str
    here: Estimate  # how much more [W]
    before: Estimate  # how much more in the linear plant [W]
    lost: tuple[str, ...]  # which of the two do not hold lock here


class Lost(NamedTuple):
    """A law that holds lock in fewer runs than in the linear plant on the same realisations."""

    law: str
    held: int
    held_before: int
    runs: int
    p_holm: float  # exact sign test of the runs in which the two differ, Holm over the laws of the case
    sure: bool


def order(runs: Mapping[str, Runs]) -> Order:
    """Rank the laws of a case: by how many of the others a law surpasses on the realisations that both have.

    Laws that have fewer realisations than the others are so judged on identical waves, too.
    """
    laws = list(runs)
    found: list[tuple[str, str, Estimate, float]] = []
    for one, other in combinations(laws, 2):
        seeds = common_seeds(runs[one], runs[other])
        own, second = runs[one].on(seeds, "mean_power"), runs[other].on(seeds, "mean_power")
        if np.nanmean(own - second) < 0.0:
            one, other, own, second = other, one, second, own
        found.append((one, other, *paired_difference(own, second)))
    corrected = holm([p for *_, p in found])
    pairs = tuple(
        PairedDifference(one, other, estimate, p, p_holm, difference_in_words(estimate, p_holm, MORE, LEVEL))
        for (one, other, estimate, p), p_holm in zip(found, corrected, strict=True)
    )
    won = {law: sum(pair.first == law for pair in pairs) for law in laws}
    power = {law: float(np.nanmean(runs[law].values["mean_power"])) for law in laws}
    return Order(tuple(sorted(laws, key=lambda law: (-won[law], -power[law]))), pairs)


def told(pair: PairedDifference) -> bool:
    """Whether the two laws can be told apart."""
    return pair.words in MORE


def changes(linear: Order, here: Order, holding: Sequence[str]) -> list[Change]:
    """Compare every two laws of a case with the linear plant; `holding` are those that hold lock here."""
    found = []
    for pair in here.pairs:
        if not {pair.first, pair.second} <= set(linear.laws):
            continue
        before = linear.pair(pair.first, pair.second)
        turned = before.first != pair.first
        if kind := _kind(told(before), told(pair), turned):
            lost = tuple(law for law in (pair.first, pair.second) if law not in holding)
            more = before.estimate
            if turned:
                more = more._replace(value=-more.value, low=-more.high, high=-more.low)
            found.append(Change(kind, pair.first, pair.second, pair.estimate, more, lost))
    return found


def _kind(before: bool, here: bool, turned: bool) -> Kind | None:
    """Kind of change by whether two laws can be told apart in the linear plant and here; None for none."""
    if before and here:
        return "turned" if turned else None
    if before or here:
        return "blurred" if before else "parted"
    return "exchanged" if turned else None


def holding(runs: Mapping[str, Runs]) -> list[str]:
    """Laws that hold lock in `HOLDS` of their runs at least."""
    return [law for law, one in runs.items() if float(np.mean(one.values["locked"] > 0.5)) >= HOLDS]


def lost_lock(linear: Mapping[str, Runs], here: Mapping[str, Runs]) -> list[Lost]:
    """Laws that hold lock in fewer of the same realisations than in the linear plant."""
    from scipy.stats import binomtest

    tried: list[tuple[str, int, int, int, float]] = []
    for law, runs in here.items():
        if law not in linear:
            continue
        seeds = common_seeds(runs, linear[law])
        now, before = runs.on(seeds, "locked") > 0.5, linear[law].on(seeds, "locked") > 0.5
        gone, won = int(np.sum(before & ~now)), int(np.sum(now & ~before))
        p = float(binomtest(gone, gone + won).pvalue) if gone + won else 1.0
        tried.append((law, int(now.sum()), int(before.sum()), len(seeds), p))
    corrected = holm([p for *_, p in tried])
    return [
        Lost(law, held, held_before, count, p_holm, p_holm < LEVEL)
        for (law, held, held_before, count, _), p_holm in zip(tried, corrected, strict=True)
        if held < held_before
    ]
