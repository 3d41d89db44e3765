"""Long time series on few points: every peak stays, and a stretch in the middle stays sample by sample.

A line of more points than a screen has pixels shows no more than its envelope. So most of the record is cut into
buckets, and each gives two points: its least and its greatest value, in the order in which they came. What is drawn
from them has every peak at its height, and at its time to within a bucket. One grid of times serves all signals of a
record: it does not depend on their values.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

STRETCH = 120.0
"""Length of the stretch in the middle that a report shows first: about sixty waves. [s]"""

DETAILED = 0.6
"""Largest part of the points that the stretch in the middle may take. [1]"""

FEWEST = 16
"""Fewest points on which a record is put."""

Array = NDArray[np.float64]


class Grid(NamedTuple):
    """Few points for a long record.

    Parameters
    ----------
    edges : (b + 1,) array
        First sample of each bucket, and the number of samples; a bucket of one sample is that sample.
    time : (p,) array
        Of the points: of a bucket its first sample and the one in its middle. [s]
    """

    edges: NDArray[np.int64]
    time: Array

    def __call__(self, values: Array) -> Array:
        """Put signals on the points.

        Parameters
        ----------
        values : (..., n) array
            Signals at the samples, any unit.

        Returns
        -------
        (..., p) array
            Of each bucket the least and the greatest value in the order in which they came; what is no number is
            left out, and stays where there is nothing else.
        """
        starts, sizes = self.edges[:-1], np.diff(self.edges)
        inside = np.minimum(np.arange(sizes.max()), sizes[:, None] - 1)  # short buckets repeat their last sample
        found = np.asarray(values, dtype=np.float64)[..., starts[:, None] + inside]
        unknown = np.isnan(found)
        first = np.where(unknown, np.inf, found).argmin(-1)
        second = np.where(unknown, -np.inf, found).argmax(-1)
        order = np.stack([np.minimum(first, second), np.maximum(first, second)], axis=-1)
        pairs = np.take_along_axis(found, order, axis=-1)
        single = np.broadcast_to(np.stack([np.ones_like(sizes), sizes], axis=-1) > [0, 1], pairs.shape)
        return np.asarray(pairs[single].reshape(*pairs.shape[:-2], self.time.size), dtype=np.float64)


def middle(time: Array, width: float) -> tuple[float, float]:
    """Beginning and end of a stretch in the middle of a record, the whole of it where it is shorter. [s]"""
    first, last = float(time[0]), float(time[-1])
    if last - first <= width:
        return first, last
    start = round((first + last - width) / 2.0 / 10.0) * 10.0
    return start, start + width


def few_points(time: Array, most: int) -> Grid | None:
    """Grid on which a record keeps its peaks, with every sample of the `STRETCH` in the middle.

    Parameters
    ----------
    time : (n,) array
        Of the samples, ascending. [s]
    most : int
        Points to which it is cut down, 16 at least. The stretch in the middle takes three in five of them at most, and
        is shorter where it has more samples.

    Returns
    -------
    Grid or None
        None for a record that is as short: all of it is kept.
    """
    count, most = time.size, max(most, FEWEST)
    if count <= most:
        return None
    begin, end = middle(time, STRETCH)
    inside = np.flatnonzero((time >= begin) & (time <= end))
    detail = min(inside.size, int(DETAILED * most))
    left = (int(inside[0]) + int(inside[-1]) + 1 - detail) // 2 if detail else count // 2
    right = left + detail
    # the last sample stands alone, so that the grid ends where the record does
    buckets = (most - detail - 1) // 2
    before = min(max(round(buckets * left / max(left + count - 1 - right, 1)), min(left, 1)), left)
    after = min(buckets - before, count - 1 - right)
    parts = (np.linspace(0, left, before + 1)[:-1], np.arange(left, right), np.linspace(right, count - 1, after + 1))
    edges = np.concatenate([*(np.round(part).astype(np.int64) for part in parts), [count]])
    sizes = np.diff(edges)
    points = np.stack([edges[:-1], edges[:-1] + sizes // 2], axis=-1)[np.stack([sizes > 0, sizes > 1], axis=-1)]
    return Grid(edges, np.asarray(time[points], dtype=np.float64))


def on_few_points(series: Mapping[str, Array], most: int) -> dict[str, Array]:
    """Put signals, each (n,), and their ``time`` on at most so many points, see `few_points`."""
    grid = few_points(series["time"], most)
    if grid is None:
        return dict(series)
    return {name: grid.time if name == "time" else grid(values) for name, values in series.items()}
