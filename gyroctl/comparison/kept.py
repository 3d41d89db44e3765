"""What the driver of a comparison keeps of each run: a row of numbers, and of the first realisation a few points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from gyroctl.comparison.items import SERIES, Item, Outcome
from gyroctl.simulation.extremes import on_few_points

IN_ALL = 32 * SERIES
"""Points of one signal of all laws together: of more than 32 laws each keeps fewer."""


class Row(Mapping[str, float]):
    """Metrics of a run as one array; runs with the same metrics share their names."""

    __slots__ = ("_columns", "_numbers")

    def __init__(self, values: Mapping[str, float]) -> None:
        self._columns = _columns(tuple(values))
        self._numbers = np.fromiter(values.values(), np.float64, len(values))

    def __getitem__(self, name: str) -> float:
        """Value of a metric, in its unit."""
        return float(self._numbers[self._columns[name]])

    def __iter__(self) -> Iterator[str]:
        """Names of the metrics."""
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of metrics."""
        return len(self._columns)


def kept(item: Item, outcome: Outcome, laws: int) -> Outcome:
    """What is held of a run in a comparison of so many laws until it is written."""
    series = outcome.series
    if series and not item.full:
        series = on_few_points(series, min(SERIES, IN_ALL // laws))
    return replace(outcome, values=Row(outcome.values), series=series)


@lru_cache(maxsize=64)
def _columns(names: tuple[str, ...]) -> dict[str, int]:
    return {name: column for column, name in enumerate(names)}
