"""Where lock exists and where it is stable: grids of locked orbits over (cc, cg) and over (wp, height)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.search import search_orbit
from gyroctl.plant import Plant
from gyroctl.robustness.regime import settle
from gyroctl.robustness.shocks import basin_stability
from gyroctl.studies.margins.request import Request
from gyroctl.waves import Regular
from gyroctl.writing import plain

DT = 0.02
"""Step of the maps at the size of Table 1: multipliers then agree with those of the default step to 1e-4. [s]"""

NONE, GROWS, STABLE = 0, 1, 2
"""Codes of a point: no orbit, an orbit on which an oscillation grows, a stable orbit."""

ACCURACY = 5e-4
"""Of the border, relative. [-]"""

Tick = Callable[[], None]


@dataclass(frozen=True)
class OrbitMap:
    """Orbits on a grid.

    Parameters
    ----------
    axes : pair of str
        What runs along the first and the second axis.
    first : (n,) array
        cc [Nms] or wp [rad/s].
    second : (m,) array
        cg [Nms] or height [m].
    code : (m, n) array of int
        0 no orbit, 1 an oscillation grows, 2 stable.
    power, angle : (m, n) arrays
        Mean power [W] and load angle [rad]; NaN without an orbit.
    growth : (m, n) array
        ln|lambda| of the largest multiplier per wave. [-]
    border : (n,) array
        Value of the second axis at which the orbit ends (fold); NaN where it does not within the grid.
    other_sense : (m', 3) array
        Points (first, second, 1 or 0) at which the other sense of rotation was looked for.
    """

    axes: tuple[str, str]
    first: NDArray[np.float64]
    second: NDArray[np.float64]
    code: NDArray[np.int64]
    power: NDArray[np.float64]
    angle: NDArray[np.float64]
    growth: NDArray[np.float64]
    border: NDArray[np.float64]
    other_sense: NDArray[np.float64]

    def record(self) -> dict[str, Any]:
        """Numbers for JSON; NaN becomes null."""
        return dict(plain(self))


def coupling_map(
    plant: Plant, wave: Regular, cc: Sequence[float], cg: Sequence[float], sense: int = 1, tick: Tick = lambda: None
) -> OrbitMap:
    """Orbits over magnetic coupling and generator gain; the border is the fold in cg.

    Parameters
    ----------
    plant, wave
        Device and regular wave.
    cc, cg : sequence of float
        Grid, each increasing. [Nms]
    sense : {1, -1}
        Sense of rotation.
    tick : callable
        Called after each column.
    """
    dt = DT * plant.parameters.time_scale

    def at(first: float, second: float, guess: NDArray[np.float64] | None, turn: int) -> Orbit:
        return search_orbit(plant, wave, first, second, turn, dt, guess)

    return _grid(("cc", "cg"), cc, cg, at, sense, tick)


def tongue_map(
    plant: Plant,
    cc: float,
    cg: float,
    wp: Sequence[float],
    height: Sequence[float],
    sense: int = 1,
    heading: float = 0.0,
    tick: Tick = lambda: None,
) -> OrbitMap:
    """Orbits over frequency and height of the wave; the border is the smallest height that carries the load."""
    dt = DT * plant.parameters.time_scale

    def at(first: float, second: float, guess: NDArray[np.float64] | None, turn: int) -> Orbit:
        return search_orbit(plant, Regular(second, first, heading), cc, cg, turn, dt, guess)

    return _grid(("wp", "height"), wp, height, at, sense, tick)


def basin_map(
    asked: Request, cc: Sequence[float], cg: Sequence[float], size: float, samples: int, tick: Tick
) -> NDArray[np.float64]:
    """Share of disturbances after which lock returns, (m, n) over cg and cc; NaN where no orbit is stable."""
    share, dt = np.full((len(cg), len(cc)), np.nan), DT * asked.plant.parameters.time_scale
    for j, coupling in enumerate(cc):
        for i, gain in enumerate(cg):
            orbit = search_orbit(asked.plant, asked.wave, coupling, gain, asked.sense, dt)
            if orbit.status == "stable":
                share[i, j] = basin_stability(settle(orbit, asked.wave), size, samples, periods=60.0).value
        tick()
    return share


At = Callable[[float, float, NDArray[np.float64] | None, int], Orbit]


def _grid(
    axes: tuple[str, str], first: Sequence[float], second: Sequence[float], at: At, sense: int, tick: Tick
) -> OrbitMap:
    """Follow each column from the side where lock is sure to the side where it ends."""
    xs, ys = np.asarray(first, float), np.asarray(second, float)
    code = np.zeros((ys.size, xs.size), np.int64)
    power, angle, growth = (np.full(code.shape, np.nan) for _ in range(3))
    border = np.full(xs.size, np.nan)
    order = range(ys.size) if axes[1] == "cg" else range(ys.size - 1, -1, -1)  # a light load, a high wave
    for j, x in enumerate(xs):
        kept: tuple[float, Orbit] | None = None
        for i in order:
            orbit = _follow(at, float(x), float(ys[i]), kept[1] if kept else None, sense)
            code[i, j] = _code(orbit)
            if code[i, j] == NONE:
                if kept:
                    border[j] = _border(at, float(x), kept, float(ys[i]), sense)
                break
            kept = float(ys[i]), orbit
            power[i, j], angle[i, j] = orbit.power, orbit.load_angle
            growth[i, j] = math.log(abs(orbit.multipliers[0]))
        tick()
    other = [
        (x, y, float(_code(at(float(x), float(y), None, -sense)) != NONE))
        for x in xs[1 :: max(xs.size // 3, 1)]
        for y in ys[1 :: max(ys.size // 3, 1)]
    ]
    tick()
    return OrbitMap(axes, xs, ys, code, power, angle, growth, border, np.array(other))


def _code(orbit: Orbit) -> int:
    if orbit.status == "stable":
        return STABLE
    largest = orbit.multipliers[0]
    if orbit.status == "no orbit" or (abs(largest.imag) < 1e-6 and largest.real > 0.0):
        return NONE  # a real multiplier beyond one: the branch behind the fold, on which no lock stays
    return GROWS


def _follow(at: At, x: float, y: float, near: Orbit | None, sense: int) -> Orbit:
    if near is not None:
        found = at(x, y, near.x, sense)
        if _code(found) != NONE:
            return found
    return at(x, y, None, sense)


def _border(at: At, x: float, kept: tuple[float, Orbit], outside: float, sense: int) -> float:
    inside, near = kept
    while abs(outside - inside) > ACCURACY * abs(outside):
        middle = 0.5 * (inside + outside)
        found = at(x, middle, near.x, sense)
        if _code(found) == NONE:
            outside = middle
        else:
            inside, near = middle, found
    return inside
