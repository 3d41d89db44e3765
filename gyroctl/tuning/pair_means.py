"""Means of the metrics of constant pairs over realisations: by the compiled ensemble, or as those of any other law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gyroctl.harness.actuation import Actuators
from gyroctl.harness.constant_pairs import scan
from gyroctl.harness.laws import law
from gyroctl.harness.run import Settings
from gyroctl.harness.yardstick import PAIR
from gyroctl.plant import Plant
from gyroctl.simulation.lock import THRESHOLD
from gyroctl.simulation.progress import Progress
from gyroctl.tuning.bench import Bench, Job
from gyroctl.tuning.goal import METRICS, RESERVE
from gyroctl.waves import Sea

Pair = tuple[float, float]
Means = dict[str, float]

MEANS = ("mean_power", "power_cv", "locked", "phi1_p98", "phi3_p98")
"""What the ensemble tells of a pair."""


class Trial(NamedTuple):
    """On what pairs are run."""

    plant: Plant
    sea: Sea
    seeds: Sequence[int]
    duration: float  # [s]
    settings: Settings  # step, blend, actuators
    workers: int = 1
    title: str = "constant pair"
    quiet: bool = False


def means_of(pairs: Sequence[Pair], on: Trial) -> list[Means]:
    """Means of each pair.

    Where the contact may slip, pairs are run as any other law is: turns kept and reversals, which the ensemble does not
    tell, then stand beside the rest, and power is what was generated and stored.
    """
    return _on_the_bench(pairs, on) if on.plant.slips else _side_by_side(pairs, on)


def as_it_acts(pair: Pair, actuators: Actuators) -> Pair:
    """What the actuators make of a constant command: resolution, gain, limit."""
    cc, cg = pair
    if actuators.cc_quantum > 0.0:
        cc = min(math.floor(cc / actuators.cc_quantum + 0.5) * actuators.cc_quantum, actuators.cc_max)
    if actuators.cg_quantum > 0.0:
        cg = min(math.floor(cg / actuators.cg_quantum + 0.5) * actuators.cg_quantum, actuators.cg_max)
    return cc * actuators.cc_gain, cg


def _side_by_side(pairs: Sequence[Pair], on: Trial) -> list[Means]:
    acting = [as_it_acts(pair, on.settings.actuators) for pair in pairs]
    how: dict[str, Any] = {"workers": on.workers, "title": on.title, "quiet": on.quiet, "ledger": False}
    found = scan(on.plant, on.sea, acting, on.seeds, on.duration, on.settings.blend, on.settings.dt, **how)
    tables = {name: getattr(found, name).astype(float) for name in MEANS}
    means = {name: np.nan_to_num(table, nan=10.0).mean(axis=1) for name, table in tables.items()}
    rows = [{name: float(value[i]) for name, value in means.items()} for i in range(len(pairs))]
    for row in rows:
        row["short_reserve"] = (RESERVE - THRESHOLD) * (1.0 - row["locked"])
    return rows


def _on_the_bench(pairs: Sequence[Pair], on: Trial) -> list[Means]:
    step = on.settings.dt
    jobs = [
        Job(PAIR, (("cc", cc), ("cg", cg)), on.sea, seed, on.duration, step) for seed in on.seeds for cc, cg in pairs
    ]
    with (
        Bench(on.plant, on.settings, law(PAIR), on.workers, device=on.plant) as bench,
        Progress(on.title, len(jobs), on.quiet) as progress,
    ):
        table = np.array(bench.perform(jobs, lambda _: progress.advance()))
    means = table.reshape(len(on.seeds), len(pairs), len(METRICS)).mean(axis=0)
    return [dict(zip(METRICS, row, strict=True)) for row in means.tolist()]
