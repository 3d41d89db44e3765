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

Vector = NDArray[np.float64]
System = Callable[[Vector], tuple[Vector, NDArray[np.float64]]]
"""y (m + 1,) -> residual (m,), its Jacobian (m, m + 1)."""


@dataclass(frozen=True)
class Palc:
    """Options of the continuation; lengths are in scaled variables, where the orbit and the limits are of size one.

    Parameters
    ----------
    step, shortest, longest : float
        First, least and largest length of a step.
    points : int
        Most points in each direction.
    tolerance : float
        Largest residual of an accepted point.
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


def tangent_of(jacobian: NDArray[np.float64], along: Vector) -> Vector:
    """Unit null vector of a Jacobian (m, m + 1), with a positive component along `along`."""
    right = np.zeros(along.size)
    right[-1] = 1.0
    t = np.linalg.solve(np.vstack([jacobian, along]), right)
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
    row = np.zeros(y.size)
    row[-1] = 1.0
    if direction is not None:
        row = direction
    point, _ = correct(system, y, row, float(row @ y), options)
    return point


def follow(
    system: Callable[[Point], System], start: Point, options: Palc, inside: Callable[[Vector], bool]
) -> Iterator[Point]:
    """Yield points along the tangent of `start`, without it, up to the first that is not `inside`, which is included.

    Parameters
    ----------
    system : callable
        The equations near a point: bordered systems renew their borders there.
    start : Point
        On the curve.
    options : Palc
        Steps.
    inside : callable
        Whether y is within the limits.
    """
    here, step = start, options.step
    for _ in range(options.points):
        local = system(here)
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


def locate(system: System, before: Point, after: Point, test: Callable[[Point], float], options: Palc) -> Point | None:
    """Point between two neighbours where a test function is zero; None where it has the same sign at both."""
    from scipy.optimize import brentq

    values = {0.0: test(before)}
    length = float(before.tangent @ (after.y - before.y))
    points = {0.0: before, length: after}
    values[length] = test(after)
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
