"""Where there is no orbit: the nearest wave height that has one, at the same controls and frequency."""

from __future__ import annotations

import dataclasses

import numpy as np

from gyroctl.errors import InputError
from gyroctl.orbits.continuation import scaled_map
from gyroctl.orbits.flow import Vector
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.pseudo_arclength import Palc, begin, follow, locate
from gyroctl.orbits.search import TOO_HEAVY, search_orbit
from gyroctl.orbits.wave import RegularWave
from gyroctl.plant import Plant

FACTORS = (1.05, 1.2, 1.5, 2.0, 3.0, 5.0)
"""Heights that are tried, in the unit of the height that harmonic balance asks for."""

LOWER = (0.8, 0.5, 0.25)
"""And in the unit of the height itself: too high a wave can leave no orbit either."""

HIGHEST = 5.0
"""No search above this height, for a device of the size of Table 1. [m]"""


def find_orbit(
    plant: Plant,
    wave: RegularWave,
    cc: float,
    cg: float,
    sense: int = 1,
    dt: float | None = None,
    guess: Vector | None = None,
) -> Orbit:
    """Find the locked orbit as `search_orbit`; where there is none, its advice names the nearest height with one.

    Parameters
    ----------
    plant : Plant
        The device.
    wave : Regular
        Height [m], angular frequency [rad/s] and heading [deg].
    cc, cg : float
        Controls. [Nms]
    sense : {1, -1}
        Sense of rotation of the ring.
    dt : float, optional
        Longest step; 0.01 s at the size of Table 1. [s]
    guess : (n,) array, optional
        State at phase zero; by default from harmonic balance. [rad], [rad/s]

    Returns
    -------
    Orbit
        Status "no orbit" where there is none.

    Raises
    ------
    InputError
        If an argument is not what it should be, or the excitation is not known at the frequency.
    """
    orbit = search_orbit(plant, wave, cc, cg, sense, dt, guess)
    height = np.nan if orbit.status != "no orbit" else nearest_height(orbit)
    if np.isnan(height):
        return orbit
    verb = "raise" if height > orbit.wave.height else "lower"
    way = f"{verb} the wave height from {orbit.wave.height:.4g} m to {height:.4g} m, the nearest that has an orbit"
    return dataclasses.replace(orbit, nearest_height=height, advice=f"Lower cg or {way}: {TOO_HEAVY}")


def nearest_height(missing: Orbit) -> float:
    """Return the nearest height [m] with an orbit, by following an orbit to its fold; NaN where none is found.

    Parameters
    ----------
    missing : Orbit
        With the status "no orbit"; its share of the lock capacity is an estimate, inverse to the height.
    """
    wave, share = missing.wave, missing.lock_share
    unit = wave.height * max(share, 1.0) if np.isfinite(share) else wave.height
    for height in [unit * f for f in FACTORS] + [wave.height * f for f in LOWER]:
        if height > HIGHEST * missing.plant.parameters.length_scale:
            continue
        other = dataclasses.replace(wave, height=height)
        orbit = search_orbit(missing.plant, other, missing.cc, missing.cg, missing.sense, missing.dt)
        if orbit.status != "no orbit":
            return _towards(orbit, wave.height)
    return np.nan


def _towards(orbit: Orbit, height: float) -> float:
    """Follow an orbit towards a height; return where it turns back, or the height of the orbit itself."""
    own, options = orbit.wave.height, Palc(step=0.1)
    limits = (min(height, own), max(height, own))
    try:
        scaled, unknowns = scaled_map(orbit, "height", limits, options.symmetric)
    except InputError:
        return own
    start = begin(scaled.system(), unknowns, options)
    if start is None:
        return own
    sense = np.sign((height - own) * start.tangent[-1])
    start = start._replace(tangent=start.tangent * sense)
    low, high = (limit / scaled.value_scale[0] for limit in limits)
    before = start
    for point in follow(scaled.system, start, options, lambda y: bool(low <= y[-1] <= high)):
        if point.tangent[-1] * before.tangent[-1] < 0.0:
            fold = locate(scaled.system(), before, point, lambda p: float(p.tangent[-1]), options)
            return own if fold is None else float(scaled.split(fold.y)[1][0])
        before = point
    return float(scaled.split(before.y)[1][0])
