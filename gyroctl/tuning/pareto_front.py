"""The Pareto front of what a tuning has run: mean power up, power CV down, lock up, motion as a limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.writing import write_rows


class FrontRow(NamedTuple):
    """A point in one sea.

    Parameters
    ----------
    sea : str
        Name of the sea.
    stage : {"search", "confirm"}
        On a few short runs (a lucky sample may flatter it), or on all tuning seeds.
    mean_power, power_cv, locked, motion : float
        Means; `motion` is the larger one of both directions. [W, 1, 1, rad]
    front : bool
        No point of the same stage within the motion limit is better in one and as good in the other two.
    chosen : str
        Set that ships it, or nothing.
    parameters : mapping
        Of the law.
    """

    sea: str
    stage: str
    mean_power: float
    power_cv: float
    locked: float
    motion: float
    front: bool
    chosen: str
    parameters: Mapping[str, float]


def nondominated(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rows of `values` (n, k), the higher the better, no other beats in one column and matches in the rest."""
    beaten = [np.any(np.all(values >= row, axis=1) & np.any(values > row, axis=1)) for row in values]
    return ~np.array(beaten, bool)


def front_rows(archive: Sequence[Any], sets: Mapping[str, Any], motion: Mapping[str, float]) -> list[FrontRow]:
    """Rows of a tuning's archive by sea, the front marked within the motion limit [rad] of each sea."""
    rows = []
    for sea in sorted({name for seen in archive for name in seen.means}):
        for stage in ("search", "confirm"):
            points = [seen for seen in archive if seen.stage == stage and sea in seen.means]
            means = [seen.means[sea] for seen in points]
            swing = np.array([max(m["phi1_p98"], m["phi3_p98"]) for m in means])
            values = np.array([[m["mean_power"], -m["power_cv"], m["locked"]] for m in means]).reshape(-1, 3)
            within = swing <= motion[sea]
            front = np.zeros(len(points), bool)
            front[within] = nondominated(values[within])
            for i, seen in enumerate(points):
                power, cv, locked = (means[i][name] for name in ("mean_power", "power_cv", "locked"))
                ships = " ".join(_shipping(sets, sea, seen)) if stage == "confirm" else ""
                row = FrontRow(sea, stage, power, cv, locked, float(swing[i]), bool(front[i]), ships, seen.parameters)
                rows.append(row)
    return rows


def _shipping(sets: Mapping[str, Any], sea: str, seen: Any) -> list[str]:
    """Names of the sets that ship a point for a sea."""
    alike = (name for name, entry in sets.items() if entry["parameters"] == seen.parameters)
    return [name for name in alike if sea in sets[name]["result"]]


def write_front(rows: Sequence[FrontRow], path: Path) -> None:
    """Write what is on a front or confirmed as a CSV table, most power first, whole or not at all."""
    kept = [row for row in rows if row.front or row.stage == "confirm"]
    kept.sort(key=lambda row: (row.sea, row.stage, -row.mean_power))
    names = list(dict.fromkeys(name for row in kept for name in row.parameters))
    head = ["sea", "stage", "mean_power_w", "power_cv", "locked", "motion_rad", "front", "chosen"]
    table: list[list[Any]] = [[*head, *names]]
    for row in kept:
        numbers = [f"{value:.4g}" for value in row[2:6]]
        own = [row.parameters.get(name, "") for name in names]
        table.append([row.sea, row.stage, *numbers, int(row.front), row.chosen, *own])
    write_rows(path, table)
