"""The constant pairs of a site: the best one of each sea state, and the one that serves the whole site best."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from gyroctl.engine.steps import Asked, Steps, planned
from gyroctl.harness.law_fingerprint import value_fingerprint
from gyroctl.harness.run import Settings
from gyroctl.harness.yardstick import BASELINE, Yardstick
from gyroctl.plant import Plant
from gyroctl.simulation.progress import Progress
from gyroctl.tuning.best_pair import COARSE, Lengths, searching
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.pair_means import Pair, Trial, means_of
from gyroctl.tuning.yardstick import LOCKED, SEEDS, Search, search_pair
from gyroctl.waves import SeaState

CASE = "constant pairs"

SEARCHED, TRIED = SEEDS[:16], SEEDS[:8]
"""Tuning seeds of the search in a sea state, and of the trials of pairs in all of them."""

WINDOW = (200.0, 2000.0)
"""Shortest and longest runs of a search. [s]"""

MOST = 24
"""Pairs of sea states that are tried for the whole site: those of the sea states that give most."""

NEAR = (0.87, 1.0, 1.15)
"""Neighbours of the best of them, as factors on both controls. [-]"""


def pairs_of_seas(
    plant: Plant,
    seas: Mapping[str, SeaState],
    settings: Settings,
    motion_limit: float,
    duration: float,
    budget: float,
    folder: Path,
    workers: int,
    quiet: bool = False,
) -> dict[str, Yardstick]:
    """Best constant pair of each sea state, by name: searched once with this budget each, and kept.

    Parameters
    ----------
    plant : Plant
        The device; one with friction or a wetted surface is searched for as one that rolls on polynomials.
    seas : mapping of str to SeaState
        The sea states, as they act on it.
    settings : Settings
        Of the runs; steps and actuators count.
    motion_limit : float
        Limit of the 98 % motion, kept where a pair can keep it. [rad]
    duration : float
        Of a run. [s]
    budget : float
        Simulated time for each. [s]
    folder : Path
        Of the stored results.
    workers, quiet
        Threads, and no progress.

    Raises
    ------
    InputError
        For a budget that is too small.
    """
    length = min(max(duration, WINDOW[0]), WINDOW[1])
    acting = Settings(actuators=settings.actuators, blend=min(settings.blend, 0.5 * length))
    lengths, goal = Lengths(COARSE, length, length), Goal(locked=LOCKED, motion=motion_limit)
    found, todo = {}, {}
    for name, sea in seas.items():
        wanted = Search(plant.rolling.smooth, sea, acting, goal, budget, SEARCHED)
        todo[name] = wanted, Steps(folder, value_fingerprint(wanted.key, *lengths), (__name__,), (Yardstick,), CASE)
    asked = [Asked(steps, _named(name), BASELINE, n) for n, (name, (_, steps)) in enumerate(todo.items(), 1)]
    with planned(folder, CASE, asked), Progress("pairs of sea states", len(todo), quiet) as progress:
        for name, (wanted, steps) in todo.items():
            kept = steps.store.path(steps.key(_named(name))).is_file()
            found[name] = steps(_named(name), partial(search_pair, wanted, workers, True, lengths))
            progress.skip() if kept else progress.advance()
    return found


def pair_of_site(
    plant: Plant,
    seas: Mapping[str, SeaState],
    shares: Mapping[str, float],
    pairs: Mapping[str, Yardstick],
    settings: Settings,
    duration: float,
    folder: Path,
    workers: int,
    quiet: bool = False,
) -> Yardstick:
    """Constant pair of most energy in a year: of those of the sea states, and neighbours of the best of them.

    Parameters
    ----------
    plant, seas, settings, duration, folder, workers, quiet
        As in `pairs_of_seas`.
    shares : mapping of str to float
        Parts of the year, by sea state. [1]
    pairs : mapping of str to Yardstick
        From `pairs_of_seas`.
    """
    length = min(max(duration, WINDOW[0]), WINDOW[1])
    base = searching(plant, Settings(actuators=settings.actuators, blend=min(settings.blend, 0.5 * length)))
    acting = replace(base, dt=COARSE)
    limits, tried = acting.actuators, dict[Pair, float]()
    known = list(dict.fromkeys((one.cc, one.cg) for one in pairs.values()))

    def energy(some: Sequence[Pair], progress: Progress) -> None:
        """Try pairs in every sea state: mean power over the year. [W]"""
        total = np.zeros(len(some))
        for name, sea in seas.items():
            on = Trial(plant.rolling.smooth, sea, TRIED, length, acting, workers, quiet=True)
            given = value_fingerprint(Search(on.plant, sea, acting, Goal(), 0.0, TRIED).key, length, list(some))
            steps = Steps(folder, given, (__name__,), (), CASE)
            powers = steps(f"{SITE} in {name}", partial(_powers, some, on))
            total += shares[name] * np.asarray(powers)
            progress.advance()
        tried.update(zip(some, total.tolist(), strict=True))

    with Progress("pair of the site", 2 * len(seas), quiet) as progress:
        energy(_most(known, pairs, shares), progress)
        cc, cg = max(tried, key=lambda pair: tried[pair])
        near = [(float(f"{cc * a:.3g}"), float(f"{cg * b:.3g}")) for a in NEAR for b in NEAR]
        near = [(a, b) for a, b in near if a <= limits.cc_max and b <= limits.cg_max and (a, b) not in tried]
        if near:
            energy(near, progress)
    best = max(tried, key=lambda pair: tried[pair])
    span = f"seeds {TRIED[0]} to {TRIED[-1]}"
    words = f"most energy in the year of {len(tried)} pairs that were tried in every sea state on {span}"
    return Yardstick(*best, searched=True, words=words)


SITE = "pair of the site"


def _most(known: list[Pair], pairs: Mapping[str, Yardstick], shares: Mapping[str, float]) -> list[Pair]:
    """Of the pairs of sea states those of the most time."""
    time = dict.fromkeys(known, 0.0)
    for name, one in pairs.items():
        time[one.cc, one.cg] += shares[name]
    return sorted(sorted(known, key=lambda pair: -time[pair])[:MOST])


def _powers(pairs: Sequence[Pair], on: Trial) -> list[float]:
    """Mean power of each pair. [W]"""
    powers = [one["mean_power"] for one in means_of(pairs, on)]
    return [power if math.isfinite(power) else 0.0 for power in powers]


def _named(name: str) -> str:
    return f"best pair, {name}"
