"""Branches of locked orbits over one parameter, through folds, with the points where stability changes.

Symmetric orbits lose stability at a fold (half-map multiplier +1), a Neimark-Sacker pair, or by a loss of symmetry
(half-map multiplier -1). Period doubling needs a half-map multiplier of +-i, a pair: it cannot happen to a symmetric
orbit before the symmetry is lost (Swift and Wiesenfeld 1984). With `symmetric=False` the whole map is followed and
multipliers -1 are period doublings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.locks import branch_face, point_face
from gyroctl.faces.show import shown
from gyroctl.orbits.flow import Vector
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.orbit_map import OrbitMap, ParametricMap
from gyroctl.orbits.pseudo_arclength import Limits, Palc, Point, System, begin, correct, joined, locate, one_way
from gyroctl.orbits.sensitivity import state_units
from gyroctl.orbits.symmetry import free_rows
from gyroctl.plant.equations import PSI

Range = tuple[float, float]
Kind = Literal["fold", "Neimark-Sacker", "symmetry breaking", "period doubling"]
SPLITS = 6
"""How often an interval with an unexplained change of stability is halved."""


class ScaledMap(NamedTuple):
    """An orbit map in unknowns of size one."""

    orbit_map: ParametricMap
    state_scale: Vector  # (m,)
    value_scale: Vector  # (p,)

    def split(self, y: Vector) -> tuple[Vector, Vector]:
        """State (m,) and parameter values (p,) of scaled unknowns (at least m + p,)."""
        m, p = self.state_scale.size, self.value_scale.size
        return y[:m] * self.state_scale, y[m : m + p] * self.value_scale

    def join(self, x: Vector, values: Vector) -> Vector:
        """Scaled unknowns (m + p,) of state and parameter values."""
        return np.concatenate([x / self.state_scale, values / self.value_scale])

    def evaluate(self, y: Vector) -> tuple[Vector, NDArray[np.float64], NDArray[np.float64]]:
        """Residual image - x (m,), A (m, m), B (m, p), all scaled."""
        x, values = self.split(y)
        found = self.orbit_map.evaluate(x, values)
        A = found.by_state * (self.state_scale[None, :] / self.state_scale[:, None])
        B = found.by_parameter * (self.value_scale[None, :] / self.state_scale[:, None])
        return (found.image - x) / self.state_scale, A, B

    def orbit(self, y: Vector) -> Orbit:
        """Return the orbit of scaled unknowns."""
        return self.orbit_map.orbit(*self.split(y))

    def frequency(self, multiplier: complex, values: Vector) -> float:
        """Frequency [rad/s] of an oscillation with a multiplier of the map; the symmetry turns it by half a turn."""
        turned = -multiplier if self.orbit_map.symmetric else multiplier
        return abs(float(np.angle(turned))) / self.orbit_map.span(values)

    def system(self, _: Vector | None = None) -> System:
        """Return the equations of a fixed point."""

        def equations(y: Vector) -> tuple[Vector, NDArray[np.float64]]:
            gap, A, B = self.evaluate(y)
            return gap, np.hstack([A - np.eye(gap.size), B])

        return equations


@shown(point_face)
@dataclass(frozen=True)
class SpecialPoint:
    """A point of a branch where stability changes.

    Parameters
    ----------
    kind : {"fold", "Neimark-Sacker", "symmetry breaking", "period doubling"}
        What happens there.
    parameter : str
        Name of the parameter of the branch.
    value : float
        Its value at the point. [unit of the parameter]
    multiplier : complex
        The critical multiplier over the map's interval (half a period for symmetric orbits), of modulus one. [-]
    error : float
        Distance of its modulus (for real ones: of itself) from where it should be. [-]
    point : object
        The point in scaled unknowns; `orbit` reads it.
    scaled : object
        The map that was followed.
    """

    kind: Kind
    parameter: str
    value: float
    multiplier: complex
    error: float
    point: Point = field(repr=False)
    scaled: ScaledMap = field(repr=False)

    @property
    def frequency(self) -> float:
        """Frequency of the critical oscillation of the float or, where the multiplier is real, zero. [rad/s]"""
        if self.kind != "Neimark-Sacker":
            return 0.0
        return self.scaled.frequency(self.multiplier, self.scaled.split(self.point.y)[1])

    @cached_property
    def orbit(self) -> Orbit:
        """The orbit at the point."""
        return self.scaled.orbit(self.point.y)


@shown(branch_face)
@dataclass(frozen=True)
class Branch:
    """Orbits along one parameter, in the order of the arclength.

    Parameters
    ----------
    parameter : str
        Name of the parameter.
    values : (n,) array
        Its values; they turn back at folds. [unit of the parameter]
    states : (n, m) array
        Unknowns of each orbit: the state at phase zero without the cyclic angle. [rad], [rad/s]
    multipliers : (n, m) complex array
        Floquet multipliers over one period, largest first. [-]
    stable : (n,) bool array
        Whether all of them are inside the unit circle.
    power : (n,) array
        Mean electrical power. [W]
    points : tuple of SpecialPoint
        Where stability changes, in the same order.
    closed : bool
        Whether the branch came back to its beginning (an isola).
    chain : tuple
        Points as they were followed; `orbit` reads them.
    scaled : object
        The map that was followed, in scaled unknowns.
    """

    parameter: str
    values: NDArray[np.float64]
    states: NDArray[np.float64]
    multipliers: NDArray[np.complex128]
    stable: NDArray[np.bool_]
    power: NDArray[np.float64]
    points: tuple[SpecialPoint, ...]
    closed: bool
    chain: tuple[Point, ...] = field(repr=False)
    scaled: ScaledMap = field(repr=False)

    def orbit(self, index: int) -> Orbit:
        """Return the orbit at a point of the branch, with everything that is told of it."""
        return self.scaled.orbit(self.chain[index].y)

    def of_kind(self, kind: Kind) -> tuple[SpecialPoint, ...]:
        """Those among `points` of one kind."""
        return tuple(point for point in self.points if point.kind == kind)

    @property
    def folds(self) -> tuple[SpecialPoint, ...]:
        """The folds among `points`."""
        return self.of_kind("fold")


def continue_orbit(orbit: Orbit, parameter: str, limits: Range, options: Palc | None = None) -> Branch:
    """Follow an orbit in a parameter, both ways, through folds, to the limits.

    Parameters
    ----------
    orbit : Orbit
        Where to start, stable or not.
    parameter : str
        cc, cg [Nms], height [m], wp [rad/s], phase between the moments [rad], d1 [Nms/rad], k1 [Nm/rad] or N [-]; or a
        choice beyond the linear model, see `gyroctl.orbits.orbit_map.OrbitMap`.
    limits : (low, high)
        Where to stop; the orbit's own value is between them.
    options : Palc
        Steps.

    Raises
    ------
    InputError
        If there is no orbit, the parameter is unknown, or the limits do not enclose the orbit's value.
    """
    options = options or Palc()
    scaled, start = scaled_map(orbit, parameter, limits, options.symmetric)
    return continue_fixed_point(scaled, start, limits, options)


def continue_fixed_point(scaled: ScaledMap, y: Vector, limits: Range, options: Palc) -> Branch:
    """Follow a fixed point of any map in its one parameter, see `continue_orbit`.

    Raises
    ------
    InputError
        If there is no fixed point near the scaled unknowns `y` (m + 1,).
    """
    start = begin(scaled.system(), y, options)
    if start is None:  # on a fold the parameter cannot be held: hold a mixture of all unknowns instead
        start = begin(scaled.system(), y, options, np.full(y.size, y.size**-0.5))
    if start is None:
        raise InputError("orbit", "no fixed point", "there is none near the start", "Find it anew with lock_orbit")
    chain, closed = _both_ways(scaled, start, limits, options)
    points = [point for a, b in pairwise(chain) for point in _special(scaled, a, b, options)]
    return _branch(scaled, chain, tuple(points), closed)


def scaled_map(orbit: Orbit, parameter: str, limits: Range, symmetric: bool) -> tuple[ScaledMap, Vector]:
    """Return the map of an orbit over a parameter, scaled by orbit and width of the limits, and the orbit in it."""
    if orbit.status == "no orbit":
        raise InputError("orbit", orbit.status, "there is nothing to continue", orbit.advice)
    plain = OrbitMap(orbit.plant, orbit.wave, orbit.cc, orbit.cg, orbit.sense, orbit.dt, (parameter,), symmetric)
    width, band = width_around(plain, parameter, limits, "orbit"), orbit.plant.excitation.omega
    if parameter == "wp" and (limits[0] < band[0] or limits[1] > band[-1]):
        mend = f"Stay in the tabulated band, {band[0]:g} to {band[-1]:g} rad/s"
        raise InputError("limits", limits, "the excitation is not known at these frequencies", mend)
    if parameter == "wp" and plain.lacks_signals(limits):
        problem = "the wetted surface follows no waves as short as the upper one"
        raise InputError("limits", limits, problem, "Lower the upper limit")
    return scaled_by_orbit(plain, orbit, width)


def scaled_by_orbit(plain: OrbitMap, orbit: Orbit, width: float) -> tuple[ScaledMap, Vector]:
    """Return a map over one parameter, scaled by an orbit and the width of the limits, and the orbit in it."""
    # the size of each state over the period: at phase zero one of them may be small by chance
    free = free_rows(orbit.plant)
    scale = np.maximum(np.max(np.abs(orbit.states(8)), axis=0)[free], 1e-6 * state_units(orbit.plant)[free])
    scale[PSI] = 1.0
    scaled = ScaledMap(plain, scale, np.array([width]))
    return scaled, scaled.join(orbit.x[free], np.array([plain.value(plain.parameters[0])]))


def width_around(of: ParametricMap, name: str, limits: Range, start: str) -> float:
    """Width of limits that enclose the value of a parameter at a start, "orbit" or "point"; refuse others."""
    (low, high), value, least = limits, of.value(name), of.least(name)
    if not (np.isfinite(low) and np.isfinite(high) and low <= value <= high and low < high):
        problem = f"must enclose the {start}'s {name} = {value:.6g}"
        raise InputError("limits", limits, problem, f"Give (low, high) around it, or start from another {start}")
    if low < least:
        raise InputError("limits", limits, f"{name} cannot be below {least:g}", "Raise the lower limit")
    return high - low


def _both_ways(scaled: ScaledMap, start: Point, limits: Range, options: Palc) -> tuple[list[Point], bool]:
    low, high = (limit / scaled.value_scale[0] for limit in limits)
    ways = []
    for sense in (1.0, -1.0):
        way, end = one_way(scaled.system, start.turned(sense), {start.y.size - 1: Limits(low, high)}, options)
        if end == "closed":
            return [start, *way, start], True
        ways.append(way)
    return joined(start, *ways), False


def _eigenvalues(point: Point) -> NDArray[np.complex128]:
    m = point.jacobian.shape[0]
    return np.asarray(np.linalg.eigvals(point.jacobian[:, :m] + np.eye(m)), complex)


def _turning(point: Point) -> float:
    return float(point.tangent[-1])


def _flipping(point: Point) -> float:
    return float(np.real(np.prod(1.0 + _eigenvalues(point))))


def _pairing(point: Point) -> float:
    """Zero where two multipliers have product one; smooth also where multipliers meet."""
    values = _eigenvalues(point)
    first, second = np.triu_indices(values.size, 1)
    return float(np.real(np.prod(1.0 - values[first] * values[second])))


def _special(scaled: ScaledMap, a: Point, b: Point, options: Palc, depth: int = 0) -> list[SpecialPoint]:
    flipped: Kind = "symmetry breaking" if scaled.orbit_map.symmetric else "period doubling"
    tests: dict[Kind, Callable[[Point], float]] = {"fold": _turning, flipped: _flipping, "Neimark-Sacker": _pairing}
    system, found, explained = scaled.system(), [], 0
    for kind, test in tests.items():
        if test(a) * test(b) < 0.0 or (test(a) == 0.0 and depth == 0):
            point = locate(system, a, b, test, options)
            special = None if point is None else _classify(scaled, kind, point)
            if special is not None:
                found.append(special)
                explained += 2 if kind == "Neimark-Sacker" else 1
    change = abs(int(np.sum(np.abs(_eigenvalues(b)) > 1.0)) - int(np.sum(np.abs(_eigenvalues(a)) > 1.0)))
    if depth < SPLITS and change > explained:
        target = float(a.tangent @ (0.5 * (a.y + b.y)))
        middle, _ = correct(system, 0.5 * (a.y + b.y), a.tangent, target, options)
        if middle is not None:
            left = _special(scaled, a, middle, options, depth + 1)
            return left + _special(scaled, middle, b, options, depth + 1)
    return sorted(found, key=lambda special: float(a.tangent @ special.point.y))


def _classify(scaled: ScaledMap, kind: Kind, point: Point) -> SpecialPoint | None:
    """Return the special point, or None where the test function vanished for another reason (a neutral saddle)."""
    values = _eigenvalues(point)
    if kind == "Neimark-Sacker":
        pairs = values[values.imag > 1e-7]
        if pairs.size == 0:
            return None
        critical = complex(pairs[np.argmin(np.abs(np.abs(pairs) - 1.0))])
        error = abs(abs(critical) - 1.0)
    else:
        goal = 1.0 if kind == "fold" else -1.0
        critical = complex(values[np.argmin(np.abs(values - goal))])
        error = abs(critical - goal)
    if error > 1e-4:
        return None
    _, at = scaled.split(point.y)
    return SpecialPoint(kind, scaled.orbit_map.parameters[0], float(at[0]), critical, float(error), point, scaled)


def _branch(scaled: ScaledMap, chain: list[Point], points: tuple[SpecialPoint, ...], closed: bool) -> Branch:
    over_a_period = 2 if scaled.orbit_map.symmetric else 1
    split = [scaled.split(point.y) for point in chain]
    states, values = np.array([x for x, _ in split]), np.array([float(at[0]) for _, at in split])
    spectra = [_eigenvalues(point) ** over_a_period for point in chain]
    multipliers = np.array([own[np.argsort(-np.abs(own))] for own in spectra])
    power = np.array([scaled.orbit_map.evaluate(x, at, derivative=False).power for x, at in split])
    stable, name = np.all(np.abs(multipliers) < 1.0, axis=1), scaled.orbit_map.parameters[0]
    return Branch(name, values, states, multipliers, stable, power, points, closed, tuple(chain), scaled)
