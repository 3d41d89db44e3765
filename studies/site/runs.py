"""The runs of a site: every law and both constant pairs on the same realisations of every sea state."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.comparison.cluster import connected, run_far
from gyroctl.comparison.compare import check_fair
from gyroctl.comparison.execution import execute
from gyroctl.comparison.items import Item, Outcome, Realisations, work_items
from gyroctl.engine.state import RUNS
from gyroctl.harness.yardstick import BASELINE, Yardstick
from gyroctl.simulation.lock import in_step
from gyroctl.studies.site.cells import Cell
from gyroctl.studies.site.request import SITE_PAIR, SiteRequest

CASE = "site"

METRICS = ("mean_power", "locked", "reversals", "phi1_p98", "phi3_p98", "cycle_slips", "turns_kept", "waves_counted")


class LawRuns(NamedTuple):
    """Runs of a law in the sea states that are run, each (cells, n)."""

    power: NDArray[np.float64]  # generated and stored [W]
    locked: NDArray[np.bool_]
    in_step: NDArray[np.bool_]
    reversals: NDArray[np.float64]  # in the scored time [1]
    motion: NDArray[np.float64]  # the larger of the 98 % motions [rad]
    failed: NDArray[np.bool_]
    failures: Mapping[str, str] = {}  # the first reason in each sea state where there is one

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Whether lock was not kept."""
        return np.asarray(~self.locked)


def run_cells(
    ask: SiteRequest, cells: Sequence[Cell], pairs: Mapping[str, Yardstick], site: Yardstick
) -> dict[str, LawRuns]:
    """Run what is not stored.

    Parameters
    ----------
    ask : SiteRequest
        Laws, device, seeds, length.
    cells : sequence of Cell
        Those that are run.
    pairs : mapping of str to Yardstick
        Best constant pair of each sea state that is run, by its name.
    site : Yardstick
        The one pair for all of them.

    Returns
    -------
    dict of str to LawRuns
        The laws, then the pair of the site and those of the sea states.
    """
    names = [*ask.laws, SITE_PAIR, BASELINE]
    items: list[Item] = []
    for cell in cells:
        assert cell.sea is not None
        laws = {**ask.laws, SITE_PAIR: site.law, BASELINE: pairs[cell.name].law}
        waves = Realisations(cell.sea, ask.seeds, ask.duration)
        own = {_named(cell, name): law for name, law in laws.items()}
        items += work_items(ask.plant, own, waves, ask.settings, max(60.0, ask.duration), series=False)
    with connected(ask.scheduler) if ask.scheduler else nullcontext() as client:
        run = partial(run_far, client) if client is not None else None
        outcomes = execute(items, ask.workers or os.cpu_count() or 1, ask.out / RUNS, ask.quiet, CASE, run)
    found: dict[str, list[list[Outcome]]] = {name: [] for name in names}
    for cell in cells:
        rows = {name: [outcomes[_named(cell, name), seed] for seed in ask.seeds] for name in names}
        check_fair(rows)
        for name in names:
            found[name].append(rows[name])
    reference = _tables(found[BASELINE])
    return {name: _runs(cells, found[name], _tables(found[name]), reference) for name in names}


def _named(cell: Cell, law: str) -> str:
    return f"{cell.name}: {law}"


def _tables(rows: Sequence[Sequence[Outcome]]) -> dict[str, NDArray[np.float64]]:
    """Metrics of a law, (cells, n): NaN where a run failed."""
    return {
        name: np.array([[one.values.get(name, np.nan) for one in row] for row in rows], np.float64) for name in METRICS
    }


def _runs(
    cells: Sequence[Cell],
    rows: Sequence[Sequence[Outcome]],
    own: Mapping[str, NDArray[np.float64]],
    pair: Mapping[str, NDArray[np.float64]],
) -> LawRuns:
    kept = ("turns_kept", "cycle_slips", "waves_counted")
    step = np.zeros(own["locked"].shape, bool)
    for at in range(len(cells)):
        measure = [pair[name][at] for name in ("turns_kept", "cycle_slips", "locked")]
        step[at] = in_step(*(own[name][at] for name in kept), *measure)
    failed = np.array([[bool(one.failure) for one in row] for row in rows], bool)
    reasons = {
        cell.name: next(one.failure for one in row if one.failure)
        for cell, row, broken in zip(cells, rows, failed, strict=True)
        if broken.any()
    }
    motion = np.maximum(own["phi1_p98"], own["phi3_p98"])
    return LawRuns(own["mean_power"], own["locked"] == 1.0, step & ~failed, own["reversals"], motion, failed, reasons)
