"""Basin stability and the smallest shock that breaks lock along each state."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.robustness.regime import Excite, Regime, judge, remembered, simulate, steady, verdict
from gyroctl.statistics import Share, wilson

LADDER = 20
"""Sizes tried before the bisection: breaking is not monotone in the size, so the first that breaks is sought."""

SMALLEST = 0.02
"""First size of the ladder, as a part of the largest."""

REFINEMENT = 6
"""Bisections: the shock is then known to half a percent of itself."""


class Shock(NamedTuple):
    """Smallest shock along one state.

    Parameters
    ----------
    state : str
        Name of the state.
    sign : {1, -1}
        Direction.
    size : float
        Smallest shock that breaks lock; NaN where none up to `largest` does. [rad or rad/s]
    largest : float
        Largest that was tried. [rad or rad/s]
    """

    state: str
    sign: int
    size: float
    largest: float


def largest_shocks(regime: Regime) -> dict[str, float]:
    """Largest disturbance of each state that is worth trying. [rad, rad/s]

    Motion up to the limit of 0.35 rad and the rate that belongs to it, half a turn of the ring, a standing ring, and
    half the speed of the flywheel.
    """
    wp, N = regime.wave.wp, regime.plant.parameters.N
    limits = {"phi1": 0.35, "phi3": 0.35, "psi": math.pi}
    limits |= {"phi1_rate": 0.35 * wp, "phi3_rate": 0.35 * wp, "psi_rate": wp}
    if regime.plant.parameters.connection == "magnetic":
        limits["omega_rate"] = 0.5 * N * wp
    return limits


def smallest_shocks(regime: Regime, periods: float = 100.0) -> tuple[Shock, ...]:
    """Find the smallest shock along each state and in each direction that makes the ring lose a turn.

    Parameters
    ----------
    regime : Regime
        The lock that is hit, at the phase of the wave at which it is frozen.
    periods : float
        Waves after which a run is judged.
    """
    excite = remembered(steady(regime))
    return tuple(
        _smallest(regime, state, sign, largest, periods, excite)
        for state, largest in largest_shocks(regime).items()
        for sign in (1, -1)
    )


def basin_stability(
    regime: Regime, size: float = 0.5, samples: int = 128, seed: int = 1, periods: float = 100.0
) -> Share:
    """Share of random disturbances after which the lock returns, with its interval.

    Parameters
    ----------
    regime : Regime
        The lock that is disturbed.
    size : float
        All states at once, each uniform within +- size times `largest_shocks`. [-]
    samples : int
        Disturbances.
    seed : int
        Of the disturbances.
    periods : float
        Waves after which a run is judged.

    Raises
    ------
    InputError
        For a size that is not positive or no samples.
    """
    if not size > 0.0:
        raise InputError("size", size, "must be positive", "Give the size of the disturbances, for example 0.5")
    if samples < 1:
        raise InputError("samples", samples, "must be at least 1", "Give the number of disturbances, for example 128")
    outcome = judge(regime, disturbances(regime, size, samples, seed), periods)
    return wilson(int(outcome.returns.sum()), samples)


def disturbances(regime: Regime, size: float, samples: int, seed: int) -> NDArray[np.float64]:
    """Disturbed states (samples, n); the same directions for every size, so that sizes are compared fairly."""
    rng = np.random.Generator(np.random.PCG64(seed))
    starts = np.repeat(regime.x[None, :], samples, axis=0)
    for state, largest in largest_shocks(regime).items():
        starts[:, regime.plant.labels.index(state)] += size * largest * rng.uniform(-1.0, 1.0, samples)
    if regime.plant.parameters.connection == "rigid":
        starts[:, 7] = regime.plant.parameters.N * starts[:, 6]
    return starts


def _smallest(regime: Regime, state: str, sign: int, largest: float, periods: float, excite: Excite) -> Shock:
    row = regime.plant.labels.index(state)

    def holds(size: float) -> bool:
        start = regime.x.copy()
        start[row] += sign * size
        if regime.plant.parameters.connection == "rigid" and state == "psi_rate":
            start[7] = regime.plant.parameters.N * start[6]
        return verdict(regime, simulate(regime, start, periods, excite))[0]

    below = 0.0
    for size in np.geomspace(SMALLEST, 1.0, LADDER) * largest:
        if not holds(float(size)):
            break
        below = float(size)
    else:
        return Shock(state, sign, math.nan, largest)
    above = float(size)
    for _ in range(REFINEMENT):
        middle = 0.5 * (below + above)
        below, above = (middle, above) if holds(middle) else (below, middle)
    return Shock(state, sign, above, largest)
