"""Tuning of laws on tuning seeds: one rule of what is good, one search, one budget of simulated runs for every law.

The search is the covariance matrix adaptation evolution strategy (Hansen, The CMA evolution strategy: a tutorial,
arXiv:1604.00772): the score is noisy and its edge, the loss of lock, is a cliff, so that gradients and simplices stall
on it. The answer of a search is the mean of its distribution, not its best sample: the best of hundreds of samples on a
few realisations is mostly luck.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness.controller import Law
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant import Plant
from gyroctl.simulation.metrics import evaluate
from gyroctl.waves import WaveRealisation

METRICS = ("mean_power", "power_cv", "locked", "phi1_p98", "phi3_p98", "cycle_slips")


@dataclass(frozen=True)
class Goal:
    """What a tuning is to reach: the most power within limits.

    Parameters
    ----------
    locked : float
        Least part of the realisations that must stay locked. [-]
    motion : float
        Largest mean of the 98 % motion, for each of phi1 and phi3. [rad]
    power_cv : float
        Largest mean coefficient of variation of the power. [-]
    """

    locked: float = 0.95
    motion: float = 0.35
    power_cv: float = float("inf")

    def met(self, means: Mapping[str, float]) -> bool:
        """Whether the limits are kept by means over realisations."""
        within = max(means["phi1_p98"], means["phi3_p98"]) <= self.motion and means["power_cv"] <= self.power_cv
        return within and means["locked"] >= self.locked

    def score(self, means: Mapping[str, float], power: float) -> float:
        """Mean power over `power` [W], less penalties: smooth, so that a search finds back from outside the limits.

        Every realisation lost counts, also within the limit: 8 for all of them. 30 per rad of motion and 8 per unit of
        power CV beyond the limits.
        """
        motion = sum(max(0.0, means[name] - self.motion) for name in ("phi1_p98", "phi3_p98"))
        rough = 8.0 * max(0.0, means["power_cv"] - self.power_cv)
        return means["mean_power"] / power - 8.0 * (1.0 - means["locked"]) - 30.0 * motion - rough


def judge(plant: Plant, law: Law, waves: Sequence[WaveRealisation], settings: Settings) -> dict[str, float]:
    """Means of `METRICS` over realisations; a power CV that is not defined (no power at all) counts as 10."""
    rows = []
    for realisation in waves:
        acting = lead_in(realisation, settings)
        record, _ = run_law(plant, law, acting, settings)
        found = evaluate(plant, record, acting.moments[1], acting.dt, acting.sea.wp, acting.blend, np.nan)
        rows.append([found[name] for name in METRICS])
    means = np.nan_to_num(np.array(rows), nan=10.0).mean(axis=0)
    return dict(zip(METRICS, (float(value) for value in means), strict=True))


def evolve(
    score: Callable[[NDArray[np.float64], int], float], start: NDArray[np.float64], spread: float, evaluations: int,
    population: int, seed: int,
) -> list[NDArray[np.float64]]:  # fmt: skip
    """Maximise `score` by covariance matrix adaptation.

    Parameters
    ----------
    score : callable
        Score of a point (n,) in a generation, counted from 0; the higher the better. The generation lets a score
        change its realisations, alike for all points that are compared.
    start : (n,) array
        First mean, in coordinates in which a change of 1 is large for every parameter.
    spread : float
        First standard deviation.
    evaluations : int
        Calls of `score`, rounded down to whole generations.
    population : int
        Calls in a generation.
    seed : int
        Of the samples: the same seed gives the same search.

    Returns
    -------
    list of (n,) arrays
        Mean after each generation, the last one last.
    """
    rng = np.random.default_rng(seed)
    n, parents = start.size, population // 2
    weights = np.log(parents + 0.5) - np.log(np.arange(1, parents + 1))
    weights /= weights.sum()
    effective = 1.0 / float(weights @ weights)
    c_path, c_cov = (effective + 2) / (n + effective + 5), (4 + effective / n) / (n + 4 + 2 * effective / n)
    rank_one = 2 / ((n + 1.3) ** 2 + effective)
    rank_mu = min(1 - rank_one, 2 * (effective - 2 + 1 / effective) / ((n + 2) ** 2 + effective))
    damping = 1 + c_path + 2 * max(0.0, np.sqrt((effective - 1) / (n + 1)) - 1)
    expected = np.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n))
    mean, covariance, path, cov_path = start.astype(float), np.eye(n), np.zeros(n), np.zeros(n)
    means = []
    for generation in range(1, evaluations // population + 1):
        values, axes = np.linalg.eigh(covariance)
        scales = np.sqrt(np.maximum(values, 1e-20))
        steps = (rng.standard_normal((population, n)) * scales) @ axes.T
        scores = np.array([score(mean + spread * step, generation - 1) for step in steps])
        best = steps[np.argsort(-scores, kind="stable")[:parents]]
        move = weights @ best
        mean = mean + spread * move
        path = (1 - c_path) * path + np.sqrt(c_path * (2 - c_path) * effective) * (axes @ ((axes.T @ move) / scales))
        length = float(np.linalg.norm(path))
        steady = length / np.sqrt(1 - (1 - c_path) ** (2 * generation)) < (1.4 + 2 / (n + 1)) * expected
        cov_path = (1 - c_cov) * cov_path + steady * np.sqrt(c_cov * (2 - c_cov) * effective) * move
        covariance = (1 - rank_one - rank_mu) * covariance + rank_one * np.outer(cov_path, cov_path)
        covariance = covariance + rank_mu * (best.T * weights) @ best
        spread *= float(np.exp(c_path / damping * (length / expected - 1)))
        means.append(mean)
    return means
