"""Curves of folds, Neimark-Sacker points and flips over two parameters.

A minimally augmented system (Govaerts 2000): fixed point, and g = 0 where
``[[A - mu, b], [c^H, 0]] [v; g] = [0; 1]`` with mu = 1, -1 or exp(i theta). Its derivative -w^H dA v needs second
derivatives of the flow in the direction v only: a central difference of the exact Jacobian along v gives them all at
once. It steers Newton's method and enters no result: the residual g is exact.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.locks import curve_face
from gyroctl.faces.show import shown
from gyroctl.orbits.continuation import Kind, Range, ScaledMap, SpecialPoint, width_around
from gyroctl.orbits.flow import Complex, Matrix, Vector
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.pseudo_arclength import Limits, Palc, Point, System, begin, joined, one_way

NUDGE = 3e-5
"""Half width of the central difference, in unknowns of size one."""

RESONANCE = 0.02
"""Distance of theta from 0 and pi at which a Neimark-Sacker curve ends in a strong resonance. [rad]"""


@shown(curve_face)
@dataclass(frozen=True)
class BifurcationCurve:
    """A curve of bifurcation points.

    Parameters
    ----------
    kind : {"fold", "Neimark-Sacker", "symmetry breaking", "period doubling"}
        Of the points.
    parameters : (str, str)
        Names of the first and the second parameter.
    first, second : (n,) arrays
        Their values along the curve. [unit of the parameter]
    frequency : (n,) array
        Of the critical oscillation, zero where the multiplier is real. [rad/s]
    power : (n,) array
        Mean electrical power of the orbit there. [W]
    error : (n,) array
        Distance of the critical multiplier from its place, by the eigenvalues. [-]
    others : (n,) array
        Modulus of the largest other multiplier over a period: below 1 the point is where stability is lost. [-]
    ends : (str, str)
        Why the curve stops: "limit", "resonance", "closed" or "step" (no further step found, or too many).
    states : (n, m) array
        Unknowns of the orbit at each point: the state at phase zero without the cyclic angle. [rad], [rad/s]
    chain : tuple
        Points as they were followed; `orbit` reads them.
    scaled : object
        The map that was followed, in scaled unknowns.
    """

    kind: Kind
    parameters: tuple[str, str]
    first: NDArray[np.float64]
    second: NDArray[np.float64]
    frequency: NDArray[np.float64]
    power: NDArray[np.float64]
    error: NDArray[np.float64]
    others: NDArray[np.float64]
    ends: tuple[str, str]
    states: NDArray[np.float64] = field(repr=False)
    chain: tuple[Point, ...] = field(repr=False)
    scaled: ScaledMap = field(repr=False)

    def orbit(self, index: int) -> Orbit:
        """Return the orbit at a point of the curve."""
        return self.scaled.orbit(_core(self.chain[index].y, self.scaled, self.kind))

    def first_at(self, second: float) -> NDArray[np.float64]:
        """First parameter where the curve passes `second`, by linear interpolation; several where it turns back."""
        gap = self.second - second
        at = np.flatnonzero(np.sign(gap[:-1]) * np.sign(gap[1:]) <= 0.0)
        at = at[gap[at] != gap[at + 1]]
        part = gap[at] / (gap[at] - gap[at + 1])
        return np.asarray(np.unique(self.first[at] + part * (self.first[at + 1] - self.first[at])))


def curve(
    point: SpecialPoint, second: str, limits: Range, options: Palc | None = None, first_limits: Range | None = None
) -> BifurcationCurve:
    """Follow a special point in its own parameter and a second one, both ways.

    Parameters
    ----------
    point : SpecialPoint
        From a branch.
    second : str
        The second parameter, see `continue_orbit`.
    limits : (low, high)
        Of the second parameter; they enclose its value at the point.
    options : Palc
        Steps.
    first_limits : (low, high), optional
        Of the first parameter; by default only what is physically possible.

    Raises
    ------
    InputError
        For an unknown parameter, the same one twice, or limits that do not enclose the point.
    """
    options = options or Palc()
    scaled = _two_parameters(point, second, limits)
    first = scaled.orbit_map.parameters[0]
    low, high = first_limits or (scaled.orbit_map.least(first), np.inf)
    x, values = point.scaled.split(point.point.y)
    core = scaled.join(x, np.array([values[0], scaled.orbit_map.value(second)]))
    angle = [abs(float(np.angle(point.multiplier)))] if point.kind == "Neimark-Sacker" else []
    y = np.concatenate([core[:-1], angle, core[-1:]])
    augmented = Augmented(scaled, point.kind)
    start = begin(augmented.near(y), y, options)
    if start is None:
        problem = "the augmented system does not converge from this point"
        raise InputError("point", point.value, problem, "Refine the branch with smaller steps")
    one, two = scaled.value_scale
    box = {x.size: Limits(low / one, high / one), y.size - 1: Limits(limits[0] / two, limits[1] / two)}
    if angle:
        box[x.size + 1] = Limits(RESONANCE, np.pi - RESONANCE, "resonance")
    ahead, last = one_way(augmented.near, start.turned(1.0), box, options)
    behind, first_end = one_way(augmented.near, start.turned(-1.0), box, options)
    return _tell(augmented, joined(start, ahead, behind), (first_end, last))


@dataclass(frozen=True)
class Augmented:
    """Equations of a bifurcation point in unknowns (state, first, [theta,] second)."""

    scaled: ScaledMap
    kind: Kind

    def matrix(self, y: Vector, A: Matrix) -> Complex:
        """A - mu, singular at the point."""
        return np.asarray(A - self.place(y) * np.eye(A.shape[0]), complex)

    def place(self, y: Vector) -> complex:
        """Where the critical multiplier is."""
        if self.kind == "Neimark-Sacker":
            return complex(np.exp(1j * y[self.scaled.state_scale.size + 1]))
        return 1.0 + 0j if self.kind == "fold" else -1.0 + 0j

    def near(self, y: Vector) -> System:
        """Return the equations with borders from the null vectors at `y`, renewed at every point of a curve."""
        _, A, _ = self.scaled.evaluate(_core(y, self.scaled, self.kind))
        u, _, vh = np.linalg.svd(self.matrix(y, A))
        return lambda z: self._equations(z, u[:, -1], vh[-1])

    def _equations(self, y: Vector, column: Complex, row: Complex) -> tuple[Vector, Matrix]:
        scaled, m = self.scaled, self.scaled.state_scale.size
        core = _core(y, scaled, self.kind)
        gap, A, B = scaled.evaluate(core)
        bordered = np.zeros((m + 1, m + 1), complex)
        bordered[:m, :m] = self.matrix(y, A)
        bordered[:m, m] = column
        bordered[m, :m] = row
        unit = np.eye(m + 1)[m]
        right: Complex = np.linalg.solve(bordered, unit).astype(complex)
        left: Complex = np.linalg.solve(bordered.T, unit).astype(complex)  # row vector: no conjugate
        v, g, w = right[:m], complex(right[m]), left[:m]
        slope = self._slope(core, v, w)  # of g in (state, first, second)
        jacobian = np.hstack([A - np.eye(m), B])
        if self.kind != "Neimark-Sacker":
            return np.array([*gap, g.real]), np.vstack([jacobian, slope.real])
        turning = 1j * np.exp(1j * y[m + 1]) * (w @ v)
        rows = np.vstack([jacobian, slope.real, slope.imag])
        by_theta = np.array([*np.zeros(m), turning.real, turning.imag])
        return np.array([*gap, g.real, g.imag]), np.insert(rows, m + 1, by_theta, axis=1)

    def _slope(self, core: Vector, v: Complex, w: Complex) -> Complex:
        """-w dA v with respect to (state, first, second): second derivatives along v."""
        m = self.scaled.state_scale.size
        out = np.zeros(core.size, complex)
        for part, unit in ((v.real, 1.0), (v.imag, 1j)):
            size = float(np.max(np.abs(part)))
            if size < 1e-12:
                continue
            nudge = np.zeros(core.size)
            nudge[:m] = part * (NUDGE / size)
            _, A1, B1 = self.scaled.evaluate(core + nudge)
            _, A0, B0 = self.scaled.evaluate(core - nudge)
            change = np.hstack([A1 - A0, B1 - B0]) * (0.5 * size / NUDGE)
            out -= unit * (w @ change)
        return out


def _two_parameters(point: SpecialPoint, second: str, limits: Range) -> ScaledMap:
    if second == point.parameter:
        raise InputError("second", second, "is the first parameter already", "Choose another one")
    moved = point.scaled.orbit_map.over((point.parameter, second))
    widths = np.array([point.scaled.value_scale[0], width_around(moved, second, limits, "point")])
    return ScaledMap(moved, point.scaled.state_scale, widths)


def _core(y: Vector, scaled: ScaledMap, kind: Kind) -> Vector:
    """Unknowns of the map, without theta."""
    return np.delete(y, scaled.state_scale.size + 1) if kind == "Neimark-Sacker" else y


def _tell(augmented: Augmented, chain: list[Point], ends: tuple[str, str]) -> BifurcationCurve:
    scaled, kind = augmented.scaled, augmented.kind
    over_a_period = 2 if scaled.orbit_map.symmetric else 1
    rows, states = [], []
    for point in chain:
        core = _core(point.y, scaled, kind)
        x, values = scaled.split(core)
        _, A, _ = scaled.evaluate(core)
        spectrum = np.linalg.eigvals(A).astype(complex)
        goal = augmented.place(point.y)
        own = int(np.argmin(np.abs(spectrum - goal)))
        mine = {own, int(np.argmin(np.abs(spectrum - np.conj(goal))))}
        others = max((abs(value) for i, value in enumerate(spectrum) if i not in mine), default=0.0)
        frequency = scaled.frequency(goal, values) if kind == "Neimark-Sacker" else 0.0
        power = scaled.orbit_map.evaluate(x, values, derivative=False).power
        rows.append((*values, frequency, power, abs(spectrum[own] - goal), others**over_a_period))
        states.append(x)
    one, two = scaled.orbit_map.parameters
    first, second, frequencies, powers, errors, largest = np.array(rows).T
    columns = (first, second, frequencies, powers, errors, largest)
    return BifurcationCurve(kind, (one, two), *columns, ends, np.array(states), tuple(chain), scaled)
