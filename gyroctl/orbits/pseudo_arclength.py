"""Pseudo-arclength continuation of the solutions of m equations in m + 1 unknowns (Keller 1977).

The same few functions follow orbits in one parameter and bifurcation points in two. Steps, angle control and the
bordered Newton corrector are as in AUTO and BifurcationKit; the systems are small and dense here, so that plain
factorisations serve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.orbits.flow import Vector

System = Callable[[Vector], tuple[Vector, NDArray[np.float64]]]
"""y (m + 1,) -> residual (m,), its Jacobian (m, m + 1)."""

Near = Callable[[Vector], System]
"""The equations near y."""


@dataclass(frozen=True)
class Palc:
    """Options of the continuation; lengths are in scaled variables, where the orbit and the limits are of size one.

    Parameters
    ----------
    step, shortest, longest : float
        First, least and largest length of a step. [-]
    points : int
        Most points in each direction.
    tolerance : float
        Largest residual of an accepted point. [-]
    iterations : int
        Most Newton iterations before the step is shortened.
    angle : float
        Largest angle between neighbouring tangents. [rad]
    symmetric : bool
        Follow orbits that have the half-period symmetry, at half the cost; False follows the whole period, where
        period doubling is possible.
    """

    step: float = 0.02
    shortest: float = 1e-6
    longest: float = 0.25
    points: int = 400
    tolerance: float = 1e-10
    iterations: int = 8
    angle: float = 0.3
    symmetric: bool = True


class Point(NamedTuple):
    """A solution with the tangent of the curve through it."""

    y: Vector
    tangent: Vector
    jacobian: NDArray[np.float64]

    def turned(self, sense: float) -> Point:
        """Return the point with its tangent the other way for a negative sense."""
        return self._replace(tangent=sense * self.tangent)


class Limits(NamedTuple):
    """Limits of one unknown."""

    low: float
    high: float
    name: str = "limit"  # what it means to pass them; a curve is led onto a "limit" and stops short of any other

    def hold(self, value: float) -> bool:
        """Whether a value is within the limits."""
        return bool(self.low <= value <= self.high)


def tangent_of(jacobian: NDArray[np.float64], along: Vector) -> Vector:
    """Unit null vector of a Jacobian (m, m + 1), with a positive component along `along`."""
    t = np.linalg.solve(np.vstack([jacobian, along]), np.eye(along.size)[-1])
    return np.asarray(t / np.linalg.norm(t))


def correct(system: System, y: Vector, row: Vector, target: float, options: Palc) -> tuple[Point | None, int]:
    """Newton's method on the system with ``row @ y = target`` added; None where it does not converge."""
    size = np.inf
    for iteration in range(options.iterations + 1):
        residual, jacobian = system(y)
        gap = np.append(residual, row @ y - target)
        before, size = size, float(np.max(np.abs(gap)))
        if not np.isfinite(size):
            return None, iteration
        if size < options.tolerance:
            return Point(y, tangent_of(jacobian, row), jacobian), iteration
        if iteration > 1 and size > 2.0 * before:
            return None, iteration
        if iteration < options.iterations:
            try:
                y = y - np.linalg.solve(np.vstack([jacobian, row]), gap)
            except np.linalg.LinAlgError:
                return None, iteration
    return None, options.iterations


def begin(system: System, y: Vector, options: Palc, direction: Vector | None = None) -> Point | None:
    """Return the first point: the solution at the same last unknown, or nearest along `direction`."""
    row = np.eye(y.size)[-1] if direction is None else direction
    point, _ = correct(system, y, row, float(row @ y), options)
    return point


def follow(near: Near, start: Point, options: Palc, inside: Callable[[Vector], bool]) -> Iterator[Point]:
    """Yield points along the tangent of `start`, without it, up to the first that is not `inside`, which is included.

    Parameters
    ----------
    near : callable
        The equations near y: bordered systems renew their borders there.
    start : Point
        On the curve.
    options : Palc
        Steps.
    inside : callable
        Whether y is within the limits.
    """
    here, step = start, options.step
    for _ in range(options.points):
        local = near(here.y)
        while True:
            guess = here.y + step * here.tangent
            there, iterations = correct(local, guess, here.tangent, float(here.tangent @ guess), options)
            if there is not None and here.tangent @ there.tangent > np.cos(options.angle):
                break
            step *= 0.5
            if step < options.shortest:
                return
        yield there
        if not inside(there.y):
            return
        here = there
        step = float(min(options.longest, step * 2.0 ** ((4 - iterations) / 3.0), 1.5 * step))


def one_way(near: Near, start: Point, box: dict[int, Limits], options: Palc) -> tuple[list[Point], str]:
    """Follow a curve, whose equations `near` tells, from `start` to the border of a box of limits by index.

    Returns the points without the start, the last one on the limit if that was reached, and the end: the name of the
    limits that were passed, "closed" where the curve came back, "step" where no further step was found.
    """

    def passed(y: Vector) -> int | None:
        return next((i for i, limits in box.items() if not limits.hold(y[i])), None)

    way: list[Point] = []
    left = False
    for point in follow(near, start, options, lambda y: passed(y) is None):
        index = passed(point.y)
        if index is not None:
            if box[index].name == "limit":
                way += _on_limit(near, way[-1] if way else start, point, index, box[index], options)
            return way, box[index].name
        way.append(point)
        distance = float(np.linalg.norm(point.y - start.y))
        left = left or distance > 2.0 * options.longest
        if left and distance < options.longest and point.tangent @ start.tangent > 0.9:
            return way, "closed"
    return way, "step"


def _on_limit(near: Near, inner: Point, outer: Point, index: int, limits: Limits, options: Palc) -> list[Point]:
    """Return the point on the limit between two neighbours, or nothing where it is the inner one or not found."""
    limit = limits.low if outer.y[index] < limits.low else limits.high
    part = (limit - inner.y[index]) / (outer.y[index] - inner.y[index])
    at = inner.y + part * (outer.y - inner.y)
    point, _ = correct(near(at), at, np.eye(at.size)[index], limit, options)
    if point is None or np.linalg.norm(point.y - inner.y) < 1e-9:
        return []
    return [point.turned(float(np.sign(point.tangent @ inner.tangent)))]


def joined(start: Point, ahead: list[Point], behind: list[Point]) -> list[Point]:
    """Return the points of both ways from a start as one curve in the sense of the start's tangent."""
    return [*(point.turned(-1.0) for point in reversed(behind)), start, *ahead]


def locate(system: System, before: Point, after: Point, test: Callable[[Point], float], options: Palc) -> Point | None:
    """Point between two neighbours where a test function is zero; None where it has the same sign at both."""
    from scipy.optimize import brentq

    length = float(before.tangent @ (after.y - before.y))
    points = {0.0: before, length: after}
    values = {s: test(point) for s, point in points.items()}
    if not values[0.0] * values[length] <= 0.0:
        return None

    def at(s: float) -> float:
        if s not in points:
            guess = before.y + (after.y - before.y) * (s / length)
            target = float(before.tangent @ before.y) + s
            guess = guess + before.tangent * (target - float(before.tangent @ guess))
            found, _ = correct(system, guess, before.tangent, target, options)
            if found is None:
                raise ArithmeticError("the corrector failed between two points")
            points[s] = found
            values[s] = test(found)
        return values[s]

    try:
        s = float(brentq(at, 0.0, length, xtol=1e-13 * max(1.0, length), rtol=1e-14))
    except ArithmeticError:
        return None
    at(s)
    return points[s]
