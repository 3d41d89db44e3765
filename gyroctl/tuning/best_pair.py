"""The best constant pair of any sea, with the budget that every law has: the yardstick of all laws.

A coarse grid over all that the device can hold, a fine one about its best pair, the few best of that on all seeds with
the fine step, and then from neighbour to neighbour. Sixteen runs stand side by side on each core: this takes seconds,
and minutes where the contact may slip.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.run import Settings
from gyroctl.plant import Plant
from gyroctl.plant.kernel import slip_rate
from gyroctl.simulation.ensemble import UNSTABLE
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.pair_means import Means, Pair, Trial, means_of
from gyroctl.waves import Sea

CC = (0.03, 0.04, 0.052, 0.07, 0.09, 0.115)
CG = tuple(float(f"{value:.4g}") for value in np.geomspace(4e-5, 3e-3, 12))
"""First grid. [Nms]"""

COARSE, WINDOW, FULL = 0.025, 1000.0, 2000.0
"""Step of the grids, length of the runs of the first one and of the others, where nothing else is asked for. [s]"""

SHARES = (0.1, 0.35, 0.25, 0.3)
"""Of the budget for the first grid, the fine one, the confirmation, and the neighbours of what it confirmed."""

FINER_CC = (0.8, 0.9, 1.0, 1.12, 1.25, 1.4)
FINER_CG = (0.65, 0.77, 0.89, 1.0, 1.12, 1.25, 1.38)
NEAR_CC, NEAR_CG = (1.0, 0.93, 1.07), (1.05, 1.1, 0.96, 1.16)
"""The fine grid and the neighbours, as factors on the best pair so far. [-]"""

KNOWN = ((0.07, 2.88e-4), (0.0582, 4.87e-4), (0.0468, 9.11e-4))
"""Good pairs of the default device at gamma 1, 5 and 50, from earlier searches: none shall be better than what a search
finds there. Tried where the grid comes near to them. [Nms]"""

PARTS, FURTHER = (0.4, 0.7, 1.0), 6
"""Of a limit below the first grid; gains that are tried beyond an edge of that grid."""

FEWEST, ROUND, ROUNDS = 4, 6, 16
"""Realisations that a grid must at least have; neighbours that are tried at a time, and how often."""

EVERY_OTHER = 2
"""Of the values of the first grid, where the budget does not reach for all of them."""


class Lengths(NamedTuple):
    """How long the runs of a search are."""

    dt: float  # longest step of the grids [s]
    window: float  # runs of the first grid [s]
    full: float  # runs of the fine grid and of the confirmation [s]

    def at(self, length: float) -> Lengths:
        """Return them in the time of a device that is `length` times as long."""
        return Lengths(*(value * growth("s", length) for value in self))


class BestPair(NamedTuple):
    """A constant pair and how it was found.

    Parameters
    ----------
    cc, cg : float
        The pair. [Nms]
    means : mapping
        Means of the metrics on all seeds.
    met : bool
        Whether it meets the goal; otherwise it is the pair that comes nearest.
    spent : float
        Simulated time. [s]
    seen : tuple of (pair, means, stage)
        Every pair that was run.
    """

    cc: float
    cg: float
    means: Means
    met: bool
    spent: float
    seen: tuple[tuple[Pair, Means, str], ...]


def best_pair(
    plant: Plant,
    sea: Sea,
    budget: float,
    seeds: Sequence[int],
    goal: Goal | None = None,
    settings: Settings | None = None,
    workers: int = 1,
    title: str = "constant pair",
    quiet: bool = False,
    lengths: Lengths | None = None,
) -> BestPair:
    """Find the constant pair of most power within a goal.

    Parameters
    ----------
    plant : Plant
        The device.
    sea : Sea
        The waves.
    budget : float
        Simulated time that may be spent. [s]
    seeds : sequence of int
        Tuning seeds.
    goal : Goal, optional
        Limits; the default ones otherwise.
    settings : Settings, optional
        Step of the confirmation, blend and limits of the actuators.
    workers, title, quiet
        Threads and progress bar.
    lengths : Lengths, optional
        Of the runs; `COARSE`, `WINDOW` and `FULL` otherwise.

    Raises
    ------
    InputError
        For a budget that is too small.
    """
    length = plant.parameters.length_scale
    goal, (coarse, window, full) = goal or Goal(), lengths or Lengths(COARSE, WINDOW, FULL).at(length)
    settings, unit_of_pair = searching(plant, settings or Settings().at(length), coarse), growth("Nms", length)
    limits = settings.actuators
    seen: list[tuple[Pair, Means, str]] = []
    spent = 0.0

    def order(means: Means) -> tuple[bool, float]:
        met = goal.met(means)  # within the goal a loss costs a yardstick nothing
        return met, means["mean_power"] if met else goal.score(means, unit)

    def run(pairs: Sequence[Pair], count: int, duration: float, dt: float, stage: str) -> list[Means]:
        nonlocal spent
        acting = replace(settings, dt=dt)
        rows = means_of(pairs, Trial(plant, sea, seeds[:count], duration, acting, workers, title, quiet))
        seen.extend((pair, means, stage) for pair, means in zip(pairs, rows, strict=True))
        spent += len(pairs) * count * duration
        return rows

    grid = distinct(plant, first_grid(settings, unit=unit_of_pair))
    if SHARES[0] * budget < FEWEST * len(grid) * window:  # what lies between is left to the fine grid
        grid = distinct(plant, first_grid(settings, EVERY_OTHER, unit_of_pair))
    unit, few = 1.0, _count(budget, 0, len(grid), window, len(seeds))
    first = dict(zip(grid, run(grid, few, window, coarse, "search"), strict=True))
    cc, cg = max(first, key=lambda pair: order(first[pair]))
    beyond = _beyond(cg, grid, settings)
    if beyond:
        first |= zip(beyond, run(beyond, few, window, coarse, "search"), strict=True)
    held = [means["mean_power"] for means in first.values() if means["locked"] >= 0.9]
    unit = max(held, default=1.0) or 1.0  # a unit of the sea itself: a score in watts would forgive losses in high seas
    cc, cg = max(first, key=lambda pair: order(first[pair]))
    finer = distinct(plant, _around(cc, cg, FINER_CC, FINER_CG, settings))
    second = run(finer, _count(budget, 1, len(finer), full, len(seeds)), full, coarse, "search")
    each = len(seeds) * full
    good = [(a * unit_of_pair, b * unit_of_pair) for a, b in KNOWN if cc > 0.0]
    known = [(a, b) for a, b in good if a <= limits.cc_max and b <= limits.cg_max and _close((a, b), (cc, cg))]
    edge = [pair for pair in _edge(finer, [order(means) for means in second]) if pair not in known]
    batch = [*known, *edge][: max(1, int(SHARES[2] * budget / each))]
    confirmed: dict[Pair, Means] = {}
    for _ in range(
        ROUNDS
    ):  # from the best pair so far to its neighbours, then from the next best one, until the budget is spent
        confirmed |= zip(batch, run(batch, len(seeds), full, settings.dt, "confirm"), strict=True)
        ranked = sorted(confirmed, key=lambda pair: order(confirmed[pair]), reverse=True)
        around = (distinct(plant, _around(*pair, NEAR_CC, NEAR_CG, settings)) for pair in ranked)
        near = next((new for pairs in around if (new := [pair for pair in pairs if pair not in confirmed])), [])
        batch = near[: max(0, min(ROUND, int((budget - spent) / each)))]
        if not batch:
            break
    best = ranked[0]
    return BestPair(*best, confirmed[best], goal.met(confirmed[best]), spent, tuple(seen))


def searching(plant: Plant, settings: Settings, coarse: float = COARSE) -> Settings:
    """Settings of a search: no coupling with which its coarse step would be unstable (0.14 Nms for that of 0.025 s)."""
    limits, rate = settings.actuators, float(slip_rate(plant.coefficients, 1.0))
    if rate == 0.0:  # a flywheel that is geared to the ring does not slip
        return settings
    stable = 0.99 * UNSTABLE / (coarse * rate)
    room = stable / limits.cc_gain - 0.5 * limits.cc_quantum  # a resolution may round upwards
    stable = max(room, 1e-3 * stable)
    return replace(settings, actuators=replace(limits, cc_max=min(limits.cc_max, stable)))


def distinct(plant: Plant, pairs: Sequence[Pair]) -> list[Pair]:
    """Pairs that differ on this device, in their order: where the flywheel is geared to the ring, cc does nothing."""
    if plant.parameters.connection == "rigid":
        return list(dict.fromkeys((0.0, cg) for _, cg in pairs))
    return list(pairs)


def first_grid(settings: Settings, step: int = 1, unit: float = 1.0) -> list[Pair]:
    """Pairs of the first grid that the actuators can give; where they can give none of them, parts of their limits.

    `unit` is that of cc and cg of the device over that of Table 1.

    Of every row of values only each `step`-th is taken, the second one of `step` first.
    """
    limits = settings.actuators
    of_cc, of_cg = [unit * cc for cc in CC[step - 1 :: step]], [unit * cg for cg in CG[step - 1 :: step]]
    ccs = [cc for cc in of_cc if cc <= limits.cc_max] or [part * limits.cc_max for part in PARTS]
    cgs = [cg for cg in of_cg if cg <= limits.cg_max] or [part * limits.cg_max for part in PARTS]
    return [(cc, cg) for cc in ccs for cg in cgs]


def _beyond(cg: float, grid: Sequence[Pair], settings: Settings) -> list[Pair]:
    """Pairs beyond the edge of a grid whose best gain `cg` lies on that edge."""
    ccs, cgs = list(dict.fromkeys(a for a, _ in grid)), [b for _, b in grid]
    if cg == max(cgs) and 1.1 * cg < settings.actuators.cg_max:
        gains = np.geomspace(cg, settings.actuators.cg_max, FURTHER + 1)[1:]
    elif cg == min(cgs):
        gains = np.geomspace(0.1 * cg, cg, FURTHER + 1)[:-1]
    else:
        return []
    return [(cc, float(f"{gain:.4g}")) for cc in ccs for gain in gains if gain <= settings.actuators.cg_max]


def _edge(pairs: Sequence[Pair], orders: Sequence[tuple[bool, float]]) -> list[Pair]:
    """Pairs in the order in which they are worth confirming: at each cc the best cg, then in turn those below it.

    The few realisations of a grid flatter the pairs at the edge of lock, so that those below it belong to the list.
    """
    steps: list[list[tuple[tuple[bool, float], Pair]]] = []
    for cc in dict.fromkeys(pair[0] for pair in pairs):
        column = sorted((pair[1], i) for i, pair in enumerate(pairs) if pair[0] == cc)
        top = max(range(len(column)), key=lambda at: orders[column[at][1]])
        for step, at in enumerate(range(top, -1, -1)):
            if len(steps) <= step:
                steps.append([])
            steps[step].append((orders[column[at][1]], pairs[column[at][1]]))
    return [pair for step in steps for _, pair in sorted(step, reverse=True)]


def _close(pair: Pair, other: Pair) -> bool:
    return all(abs(math.log(a / b)) < math.log(2.0) for a, b in zip(pair, other, strict=True))


def _around(
    cc: float, cg: float, cc_factors: Sequence[float], cg_factors: Sequence[float], settings: Settings
) -> list[Pair]:
    limits = settings.actuators
    ccs = [float(f"{cc * factor:.3g}") for factor in cc_factors]
    cgs = [float(f"{cg * factor:.3g}") for factor in cg_factors]
    return [(a, b) for a in ccs if a <= limits.cc_max for b in cgs if b <= limits.cg_max]


def _count(budget: float, stage: int, pairs: int, duration: float, seeds: int) -> int:
    count = int(SHARES[stage] * budget / (pairs * duration))
    if count < FEWEST:
        least = FEWEST * pairs * duration / SHARES[stage]
        raise InputError("budget", budget, f"is too small for the grid of {pairs} pairs", f"Give {least:g} s or more")
    return min(count, seeds)
