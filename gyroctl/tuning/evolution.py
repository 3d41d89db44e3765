"""Covariance matrix adaptation: a search for scores that are noisy and have cliffs, by ranks alone.

The strategy of Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772. The loss of lock is a cliff and the
score of a few realisations is noisy, so that gradients and simplices stall. Nothing mutates: a search is
``points = ask(search, ...)`` and ``search = tell(search, points, scores)`` in turn, and the samples of a generation
depend on the seed and its number only, so that a search can be gone through again from its scores.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Search(NamedTuple):
    """State of a search: the normal distribution of its samples and the paths that it has gone.

    Parameters
    ----------
    generation : int
        Generations told so far.
    mean : (n,) array
        Of the samples, in coordinates in which a change of 1 is large for every parameter.
    spread : float
        Standard deviation.
    covariance : (n, n) array
        Shape of the samples.
    path, shape_path : (n,) arrays
        Moves of the mean, smoothed over generations, for the spread and for the covariance.
    """

    generation: int
    mean: Array
    spread: float
    covariance: Array
    path: Array
    shape_path: Array


def begin(start: Array, spread: float) -> Search:
    """Begin a search at `start` (n,) with standard deviation `spread` in every coordinate."""
    n = start.size
    return Search(0, start.astype(float), spread, np.eye(n), np.zeros(n), np.zeros(n))


def ask(search: Search, population: int, seed: int) -> Array:
    """Return the points (population, n) of the next generation."""
    rng = np.random.default_rng([seed, search.generation])
    axes, scales = _axes(search.covariance)
    steps = (rng.standard_normal((population, search.mean.size)) * scales) @ axes.T
    return np.asarray(search.mean + search.spread * steps)


def tell(search: Search, points: Array, scores: Array) -> Search:
    """Move the distribution towards the points of high score.

    Parameters
    ----------
    points : (population, n) array
        What `ask` gave.
    scores : (population,) array
        Their scores, the higher the better.
    """
    n, parents = search.mean.size, points.shape[0] // 2
    generation = search.generation + 1
    weights = np.log(parents + 0.5) - np.log(np.arange(1, parents + 1))
    weights /= weights.sum()
    effective = 1.0 / float(weights @ weights)
    c_path, c_shape = (effective + 2) / (n + effective + 5), (4 + effective / n) / (n + 4 + 2 * effective / n)
    rank_one = 2 / ((n + 1.3) ** 2 + effective)
    rank_mu = min(1 - rank_one, 2 * (effective - 2 + 1 / effective) / ((n + 2) ** 2 + effective))
    damping = 1 + c_path + 2 * max(0.0, np.sqrt((effective - 1) / (n + 1)) - 1)
    expected = np.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n))

    axes, scales = _axes(search.covariance)
    best = (points[np.argsort(-scores, kind="stable")[:parents]] - search.mean) / search.spread
    move = weights @ best
    white = axes @ ((axes.T @ move) / scales)
    path = (1 - c_path) * search.path + np.sqrt(c_path * (2 - c_path) * effective) * white
    length = float(np.linalg.norm(path))
    steady = length / np.sqrt(1 - (1 - c_path) ** (2 * generation)) < (1.4 + 2 / (n + 1)) * expected
    shape_path = (1 - c_shape) * search.shape_path + steady * np.sqrt(c_shape * (2 - c_shape) * effective) * move
    covariance = (1 - rank_one - rank_mu) * search.covariance + rank_one * np.outer(shape_path, shape_path)
    covariance = covariance + rank_mu * (best.T * weights) @ best
    spread = search.spread * float(np.exp(c_path / damping * (length / expected - 1)))
    return Search(generation, search.mean + search.spread * move, spread, covariance, path, shape_path)


def _axes(covariance: Array) -> tuple[Array, Array]:
    values, axes = np.linalg.eigh(covariance)
    return axes, np.sqrt(np.maximum(values, 1e-20))
