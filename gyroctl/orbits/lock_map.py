"""Where lock exists and where it is stable: over (cc, cg), over (wp, height), and the hinge damping that it needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.locks import map_face
from gyroctl.faces.show import shown
from gyroctl.froude import at_length, growth
from gyroctl.orbits.bifurcation import BifurcationCurve, curve
from gyroctl.orbits.continuation import Branch, continue_orbit
from gyroctl.orbits.nearest_orbit import find_orbit
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.pseudo_arclength import Palc
from gyroctl.orbits.search import search_orbit
from gyroctl.orbits.wave import RegularWave
from gyroctl.plant import Plant
from gyroctl.plant.given import check_plant

OPTIONS = Palc(longest=0.3)
CC_RANGE, WP_RANGE = (0.01, 0.3), (2.0, 4.5)
"""Couplings [Nms] and frequencies [rad/s] of a map where none are given, at the size of Table 1."""

HIGHEST, LOWEST = 1.0, (1e-3, 1e-4)
"""Height that a tongue stays below where none is given, and those down to which its tip is sought and followed, at the
size of Table 1. [m]"""

DAMPING = (0.5, 20.0)
"""Hinge damping from which the critical one is sought at least, and the largest where none is given, at the size of
Table 1. [Nms/rad]"""

LOADS = (1e-3, 3e-4, 1e-4, 1e-5, 0.0)
"""Gains at which a first orbit is sought, in this order; the first is also an estimate of a fold that no orbit tells.
At the size of Table 1. [Nms]"""

SLICES = 5
"""Slices along which the map looks for Neimark-Sacker points that start no curve yet."""

START_SHARE = 0.2
"""Used share of the lock capacity of the first orbit: small, so that it goes on to small couplings."""

NEAR = 0.02
"""Part of the map's width within which a point is taken to lie on a curve that is there already."""

Report = Callable[[str], None]


@shown(map_face)
@dataclass(frozen=True)
class LockMap:
    """Borders of lock over (cc, cg) in a regular wave.

    Parameters
    ----------
    fold : BifurcationCurve
        Largest cg [Nms] with an orbit (first) over cc (second).
    neimark_sacker : tuple of BifurcationCurve
        cc (first) and cg (second) where an oscillation of the float begins to grow. Parts of these curves lie on the
        unstable branch behind the fold: `others` above 1 tells.
    slices : tuple of Branch
        Orbits over cg at several cc, from 0 to the fold and back, for power contours.
    cc : (n,) array
        The coupling of each slice. [Nms]
    sense : {1, -1}
        Sense of rotation.
    """

    fold: BifurcationCurve
    neimark_sacker: tuple[BifurcationCurve, ...]
    slices: tuple[Branch, ...]
    cc: NDArray[np.float64]
    sense: int

    def largest_cg(self, cc: float) -> float:
        """Largest cg with an orbit at a coupling, stable or not. [Nms]"""
        order = np.argsort(self.fold.second)
        return float(np.interp(cc, self.fold.second[order], self.fold.first[order]))

    def power(self, cc: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean power [W] of the orbits below the fold, (len(cc), len(share)), at cg = share * largest cg.

        Interpolated linearly between slices; NaN outside them.
        """
        slices = zip(self.cc, self.slices, strict=True)
        table = np.array([np.interp(share * self.largest_cg(at), *_lower_part(branch)) for at, branch in slices])
        return np.stack([np.interp(cc, self.cc, column, np.nan, np.nan) for column in table.T], axis=1)


def lock_map(
    plant: Plant,
    wave: RegularWave,
    cc: tuple[float, float] | None = None,
    sense: int = 1,
    options: Palc | None = None,
    progress: Report | None = None,
) -> LockMap:
    """Fold and Neimark-Sacker curves over (cc, cg) up to the fold.

    Parameters
    ----------
    plant : Plant
        The device.
    wave : Regular
        Height [m], angular frequency [rad/s] and heading [deg].
    cc : (low, high), optional
        Range of the coupling; 0.01 to 0.3 Nms at the size of Table 1. [Nms]
    sense : {1, -1}
        Sense of rotation.
    options : Palc
        Steps.
    progress : callable
        Called with a line of text at each stage.

    Raises
    ------
    InputError
        If the range is not increasing and positive, or no orbit is found in it.
    """
    check_plant(plant)
    usual = at_length(CC_RANGE, "Nms", plant.parameters.length_scale)
    low, high = cc = usual if cc is None else cc
    if not (np.isfinite(high) and 0.0 < low < high):
        mend = f"Give for example ({usual[0]:.3g}, {usual[1]:.3g})"
        raise InputError("cc", cc, "must be an increasing range of positive couplings", mend)
    options, tell = options or OPTIONS, progress or (lambda _: None)
    grid = [float(at) for at in np.geomspace(low, high, SLICES)]
    tell("first orbit")
    first = _some_orbit(plant, wave, grid[SLICES // 2], sense)
    across = continue_orbit(first, "cc", (low, high), options)
    slices: dict[float, Branch] = {}
    for at in grid:
        tell(f"orbits at cc = {at:.3g}")
        start = across.orbit(int(np.argmin(np.abs(across.values - at))))
        orbit = search_orbit(plant, wave, at, start.cg, sense, guess=start.x)
        if orbit.status != "no orbit":
            slices[at] = continue_orbit(orbit, "cg", (0.0, 4.0 * _scale_of_cg(first)), options)
    folds = [point for branch in slices.values() for point in branch.folds]
    if not folds:
        raise InputError("cc", cc, "no fold was found in this range of cg", "Check the wave height")
    tell("fold curve")
    fold = curve(min(folds, key=lambda p: abs(p.orbit.cc - grid[SLICES // 2])), "cc", (low, high), options)
    top = float(1.02 * np.max(fold.first))
    curves: list[BifurcationCurve] = []

    def known(at: tuple[float, float]) -> bool:
        return any(_on(one, at, high - low, top) for one in curves)

    def trace(across: Branch, cg: float) -> None:
        for seed in across.of_kind("Neimark-Sacker"):
            if not known((seed.value, cg)):
                tell(f"Neimark-Sacker curve from cc = {seed.value:.3g}, cg = {cg:.3g}")
                curves.append(curve(seed, "cg", (0.0, top), options, first_limits=(low, high)))

    trace(across, first.cg)
    for at, branch in slices.items():
        for point in branch.of_kind("Neimark-Sacker"):
            if not known((at, point.value)):  # found again along cc, so that cc is its first parameter
                trace(continue_orbit(point.orbit, "cc", (low, high), options), point.value)
    return LockMap(fold, tuple(curves), tuple(slices.values()), np.array(list(slices)), sense)


def tongue(
    plant: Plant,
    wave: RegularWave,
    cc: float,
    cg: float,
    wp: tuple[float, float] | None = None,
    highest: float | None = None,
    sense: int = 1,
    options: Palc | None = None,
) -> BifurcationCurve:
    """Least height (first) with an orbit over the frequency (second): the lock tongue.

    Parameters
    ----------
    plant, wave, cc, cg, sense
        As for `lock_orbit`; the wave's height and frequency are where the search starts.
    wp : (low, high), optional
        Range of frequencies; 2 to 4.5 rad/s at the size of Table 1. [rad/s]
    highest : float, optional
        No height above this; 1 m at the size of Table 1. [m]
    options : Palc
        Steps.

    Raises
    ------
    InputError
        If there is no orbit to start from, or no fold below it.
    """
    check_plant(plant)
    length = plant.parameters.length_scale
    wp = at_length(WP_RANGE, "rad/s", length) if wp is None else wp
    highest = HIGHEST * length if highest is None else highest
    least, tip = at_length(LOWEST, "m", length)
    orbit = find_orbit(plant, wave, cc, cg, sense)
    branch = continue_orbit(orbit, "height", (least, max(highest, 1.01 * wave.height)), options or OPTIONS)
    if not branch.folds:
        raise InputError("cg", cg, "the orbit goes on to vanishing height", "The tongue has no tip: raise cg")
    lowest = min(branch.folds, key=lambda point: point.value)
    return curve(lowest, "wp", wp, options or OPTIONS, first_limits=(tip, highest))


def critical_damping(
    plant: Plant,
    wave: RegularWave,
    cg: float,
    cc: tuple[float, float] | None = None,
    largest: float | None = None,
    sense: int = 1,
    options: Palc | None = None,
) -> BifurcationCurve:
    """Hinge damping d1 (first) that the lock needs over the coupling (second): a Neimark-Sacker curve.

    Parameters
    ----------
    plant, wave, cg, sense
        As for `lock_orbit`.
    cc : (low, high), optional
        Range of the coupling; 0.01 to 0.3 Nms at the size of Table 1. [Nms]
    largest : float, optional
        No damping above this; 20 Nms/rad at the size of Table 1. [Nms/rad]
    options : Palc
        Steps.

    Raises
    ------
    InputError
        If there is no orbit, or none that becomes unstable with small damping.
    """
    check_plant(plant)
    length = plant.parameters.length_scale
    cc = at_length(CC_RANGE, "Nms", length) if cc is None else cc
    least, most = at_length(DAMPING, "Nms/rad", length)
    largest, damped = most if largest is None else largest, plant.replace(d1=max(plant.parameters.d1, least))
    for at in np.geomspace(cc[1], cc[0], 4)[1:]:
        orbit = find_orbit(damped, wave, float(at), cg, sense)
        branch = continue_orbit(orbit, "d1", (0.0, largest), options or OPTIONS)
        pairs = branch.of_kind("Neimark-Sacker")
        if pairs:
            return curve(max(pairs, key=lambda p: p.value), "cc", cc, options or OPTIONS, first_limits=(0.0, largest))
    raise InputError("cc", cc, "the lock needs no hinge damping in this range", "Lower cc")


def _some_orbit(plant: Plant, wave: RegularWave, cc: float, sense: int) -> Orbit:
    """Return an orbit at this coupling with a load well below the fold."""
    for cg in (load * growth("Nms", plant.parameters.length_scale) for load in LOADS):
        orbit = search_orbit(plant, wave, cc, cg, sense)
        if orbit.status != "no orbit":
            lighter = cg * min(1.0, START_SHARE / max(orbit.lock_share, 1e-9))
            return search_orbit(plant, wave, cc, lighter, sense, guess=orbit.x)
    found = find_orbit(plant, wave, cc, 0.0, sense)
    raise InputError("height", wave.height, "has no orbit at any load", found.advice)


def _scale_of_cg(orbit: Orbit) -> float:
    """Estimate of the fold: V J4/N, from the orbit's used share."""
    usual = LOADS[0] * growth("Nms", orbit.plant.parameters.length_scale)
    return orbit.cg / orbit.lock_share if orbit.lock_share > 0.0 else usual


def _lower_part(branch: Branch) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values of cg and power from no load to the fold, on the side where the ring angle does not run away."""
    turn = int(np.argmax(branch.values))
    runs_away = np.any((np.abs(branch.multipliers.imag) < 1e-9) & (branch.multipliers.real > 1.0), axis=1)
    if np.mean(runs_away[: turn + 1]) < 0.5:
        return branch.values[: turn + 1], branch.power[: turn + 1]
    return branch.values[turn:][::-1], branch.power[turn:][::-1]


def _on(known: BifurcationCurve, at: tuple[float, float], width: float, top: float) -> bool:
    """Whether a point lies on a curve."""
    a = np.stack([known.first / width, known.second / top], axis=1)
    p = np.array([at[0] / width, at[1] / top])
    along = a[1:] - a[:-1]
    part = np.clip(np.sum((p - a[:-1]) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-30), 0.0, 1.0)
    return bool(np.min(np.linalg.norm(a[:-1] + part[:, None] * along - p, axis=1)) < NEAR)
