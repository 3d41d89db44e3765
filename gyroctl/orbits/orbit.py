"""A locked orbit: the ring turns once per wave. What is known of it, from the fixed point of the half-period map.

The forced system maps to itself under half a period and phi -> -phi, z -> -z, psi -> psi - pi (times the sense of
rotation). The fixed point of the half-period map followed by that reflection is the orbit; it halves the work, and
the square of the half map's Jacobian against the full map's is a free check of accuracy. Where a choice of the plant
breaks the symmetry, the fixed point is that of the full map.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.faces.locks import orbit_face
from gyroctl.faces.show import shown
from gyroctl.orbits.flow import Forcing, Vector, flow, flow_jacobian
from gyroctl.orbits.symmetry import free_rows, signs
from gyroctl.orbits.wave import Wave
from gyroctl.plant import Plant
from gyroctl.plant.equations import PHI1_RATE, PHI3_RATE, PSI

Status = Literal["stable", "unstable", "no orbit"]

GROWS = "An oscillation grows on this orbit (Neimark-Sacker): raise the hinge damping d1 or change cc"
RUNS_AWAY = "A ring angle off this orbit runs away from it: this is the branch behind the fold"
DOUBLES = "An oscillation at half the frequency of the wave grows on this orbit (period doubling): raise d1 or the drag"

PIECES = 16
"""Instants of half a period for the mean of the co-rotating rate."""


class LockProblem(NamedTuple):
    """What is asked for where an orbit is wanted, in the order of the fields of `Orbit` that tell it."""

    plant: Plant
    cc: float
    cg: float
    sense: int
    dt: float
    wave: Wave


@shown(orbit_face)
@dataclass(frozen=True)
class Orbit:
    """A locked orbit under a regular wave.

    Parameters
    ----------
    x : (n,) array
        State at phase zero of the wave. [rad], [rad/s]
    period : float
        Wave period. [s]
    multipliers : (n - 1,) complex array
        Floquet multipliers over one period, largest first; without the angle omega, which is cyclic. [-]
    error : float
        Largest difference between the Jacobian of the full map and the square of the half map's, or, where there is
        no symmetry, the product of those of the two halves. [-]
    residual : float
        What remains of the fixed-point equation. [rad], [rad/s]
    power : float
        Mean electrical power. [W]
    load_angle : float
        Angle of the mean of exp(i psi)(phi1' + i phi3'). [rad]
    lock_share : float
        Used share of the lock capacity, N cg/(J4 V) with V the modulus of that mean. [-]
    status : {"stable", "unstable", "no orbit"}
        "no orbit": the other fields hold the last iterate and are not to be used.
    advice : str
        What to do about it; where there is no orbit, the nearest wave height that has one.
    plant, cc, cg, sense, dt
        As asked for.
    wave : Wave
        Height [m], angular frequency [rad/s] and heading [deg].
    half_multipliers : (n - 1,) complex array
        Eigenvalues of the reflected half map, in the order of `multipliers`, which are their squares: they know the
        frequency of a mode up to twice that of the period. Without the symmetry principal roots of `multipliers`. [-]
    nearest_height : float
        The nearest wave height with an orbit where there is none at this; NaN where none was found. [m]
    """

    x: NDArray[np.float64]
    period: float
    multipliers: NDArray[np.complex128]
    error: float
    residual: float
    power: float
    load_angle: float
    lock_share: float
    status: Status
    advice: str
    plant: Plant = field(repr=False)
    cc: float = 0.0
    cg: float = 0.0
    sense: int = 1
    dt: float = 0.01
    wave: Wave = field(default_factory=lambda: Wave(np.nan, np.nan))
    half_multipliers: NDArray[np.complex128] = field(default_factory=lambda: np.empty(0, complex), repr=False)
    nearest_height: float = np.nan

    @property
    def forcing(self) -> Forcing:
        """Moments of the wave."""
        return Forcing.of(self.plant, self.wave)

    @property
    def lock_reserve(self) -> float:
        """Part of the lock capacity that is not used, 1 - `lock_share`."""
        return 1.0 - self.lock_share

    def states(self, count: int) -> NDArray[np.float64]:
        """States (count, n) at `count` even instants of a period, from phase zero on."""
        n, forcing = self.x.size, self.forcing
        later = [flow(self.plant, self.x, self.cc, self.cg, forcing, i / count, self.dt)[:n] for i in range(1, count)]
        return np.array([self.x, *later])


def describe(problem: LockProblem, forcing: Forcing, x: Vector, residual: float) -> Orbit:
    """Return the orbit through the fixed point `x` (n,), with everything that is told of it."""
    plant, cc, cg, _, dt, _ = problem
    free, n, symmetric = free_rows(plant), x.size, plant.parameters.symmetric
    middle, half = flow_jacobian(plant, x, cc, cg, forcing, 0.5, dt)
    _, full = flow_jacobian(plant, x, cc, cg, forcing, 1.0, dt)
    if symmetric:
        reflected = (signs(n)[:, None] * half)[np.ix_(free, free)]
        twice = reflected @ reflected
        halves = np.linalg.eigvals(reflected).astype(complex)
    else:
        _, later = flow_jacobian(plant, middle, cc, cg, Forcing(-forcing.amplitude, forcing.wp), 0.5, dt)
        twice = later[np.ix_(free, free)] @ half[np.ix_(free, free)]
        halves = np.sqrt(np.linalg.eigvals(full[np.ix_(free, free)]).astype(complex))
    halves = halves[np.argsort(-np.abs(halves), kind="stable")]
    multipliers = halves**2
    error = float(np.max(np.abs(twice - full[np.ix_(free, free)])))
    end = flow(plant, x, cc, cg, forcing, 1.0, dt)
    power = float(np.real(end[n + 4])) / forcing.period
    rates, span = [], 0.5 if symmetric else 1.0
    for i in range(PIECES):
        state = np.real(flow(plant, x, cc, cg, forcing, span * i / PIECES, dt)[:n]) if i else x
        rates.append(np.exp(1j * state[PSI]) * (state[PHI1_RATE] + 1j * state[PHI3_RATE]))
    mean = complex(np.mean(rates))  # with the symmetry the second half of the period repeats the first
    angle, share = float(np.angle(mean)), plant.parameters.N * cg / (plant.parameters.J4 * abs(mean))
    stable = bool(np.abs(multipliers[0]) < 1.0)
    status: Status = "stable" if stable else "unstable"
    advice = "" if stable else _why_unstable(multipliers[0])
    told = (x, forcing.period, multipliers, error, residual, power, angle, share, status, advice)
    return Orbit(*told, *problem, halves)


def _why_unstable(largest: complex) -> str:
    """What grows, by the largest multiplier; a negative one needs a device without the symmetry."""
    if abs(largest.imag) > 1e-6:
        return GROWS
    return RUNS_AWAY if largest.real > 0.0 else DOUBLES
