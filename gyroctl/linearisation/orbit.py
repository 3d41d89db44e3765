"""The locked orbit: the ring turns once per wave, found by Newton's method on the half-period map.

The forced system maps to itself under half a period and phi -> -phi, z -> -z, psi -> psi - pi (times the sense of
rotation). The fixed point of the half-period map followed by that reflection is the orbit; it halves the work, and
the square of the half map's Jacobian against the full map's is a free check of accuracy.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.flow import Forcing, flow, flow_jacobian
from gyroctl.linearisation.guess import estimated_share, harmonic_balance
from gyroctl.linearisation.orbit_map import Wave
from gyroctl.linearisation.symmetry import free_rows, reflect, signs
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA, OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI, PSI_RATE

if TYPE_CHECKING:
    from gyroctl.linearisation.modes import Mode

Status = Literal["stable", "unstable", "no orbit"]

TOLERANCE = 1e-11
ITERATIONS = 30
PIECES = 16
"""Instants of half a period for the mean of the co-rotating rate."""

SETTLING = 40
"""Periods of plain simulation that bring a poor first guess nearer, where Newton's method fails from the guess."""


class RegularWave(Protocol):
    """What the orbit needs to know of a regular wave."""

    @property
    def height(self) -> float:
        """Wave height. [m]"""
        ...

    @property
    def wp(self) -> float:
        """Angular frequency. [rad/s]"""
        ...

    @property
    def heading(self) -> float:
        """Heading. [deg]"""
        ...


@dataclass(frozen=True)
class PeriodicOrbit:
    """A locked orbit under a regular wave.

    Parameters
    ----------
    x : (n,) array
        State at phase zero of the wave.
    period : float
        Wave period. [s]
    multipliers : (n - 1,) complex array
        Floquet multipliers over one period, largest first; without the angle omega, which is cyclic.
    error : float
        Largest difference between the multipliers of the full map and the squares of the half map's.
    residual : float
        What remains of the fixed-point equation.
    power : float
        Mean electrical power. [W]
    load_angle : float
        Angle of the mean of exp(i psi)(phi1' + i phi3'). [rad]
    lock_share : float
        Used share of the lock capacity, N cg/(J4 V) with V the modulus of that mean.
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
        frequency of a mode up to twice that of the period.
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
        he = self.plant.excitation(np.array([self.wave.wp]), self.wave.heading)[:, 0]
        return Forcing(0.5 * self.wave.height * he, self.wave.wp)

    @property
    def lock_reserve(self) -> float:
        """Part of the lock capacity that is not used, 1 - `lock_share`."""
        return 1.0 - self.lock_share

    def states(self, count: int) -> NDArray[np.float64]:
        """States (count, n) at `count` even instants of a period, from phase zero on."""
        n, forcing = self.x.size, self.forcing
        later = [flow(self.plant, self.x, self.cc, self.cg, forcing, i / count, self.dt)[:n] for i in range(1, count)]
        return np.array([self.x, *later])

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """Modes by name, slowest decay first: libration, horizontal, vertical, slip, radiation."""
        from gyroctl.linearisation.modes import find_modes

        return find_modes(self)

    def mode(self, name: str) -> Mode:
        """Return the slowest mode of that name.

        Raises
        ------
        InputError
            If the orbit has no mode of that name.
        """
        for mode in self.modes:
            if mode.name == name:
                return mode
        have = ", ".join(dict.fromkeys(mode.name for mode in self.modes))
        raise InputError("mode", name, "this orbit has no mode of that name", f"Choose one of {have}")

    def linearise(self, outputs: tuple[str, ...] | None = None, period: float = 0.1) -> Any:
        """Periodic linear model about the orbit, see `gyroctl.linearisation.periodic.linearise`.

        Parameters
        ----------
        outputs : tuple of str, optional
            Names of the outputs.
        period : float
            Sampling period. [s]
        """
        from importlib import import_module

        periodic = import_module("gyroctl.linearisation.periodic")
        chosen = {} if outputs is None else {"outputs": outputs}
        return periodic.linearise(self, period=period, **chosen)


def lock_orbit(
    plant: Plant, wave: RegularWave, cc: float, cg: float, sense: int = 1, dt: float = 0.01,
    guess: NDArray[np.float64] | None = None, nearest: bool = True,
) -> PeriodicOrbit:  # fmt: skip
    """Find the locked orbit.

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
    dt : float
        Longest step. [s]
    guess : (n,) array, optional
        State at phase zero; by default from harmonic balance.
    nearest : bool
        Where there is no orbit, look for the nearest wave height that has one (some 0.2 s).

    Returns
    -------
    PeriodicOrbit
        The stable orbit if there is one; else an unstable one; else the status "no orbit" with advice.

    Raises
    ------
    InputError
        If height, frequency or a control is out of range, or the excitation is not known at the frequency.
    """
    if not wave.height > 0.0:
        raise InputError("height", wave.height, "must be positive", "Give the wave height in metres, for example 0.2")
    if not wave.wp > 0.0:
        raise InputError("wp", wave.wp, "must be positive", "Give the angular frequency in rad/s, for example 3.14")
    if sense not in (1, -1):
        raise InputError("sense", sense, "must be 1 or -1", "Choose the sense of rotation of the ring")
    for name, value in (("cc", cc), ("cg", cg)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(name, value, "must be zero or positive", f"Give {name} in Nms")
    he = plant.excitation(np.array([wave.wp]), wave.heading)[:, 0]
    if not np.any(he):
        low, high = plant.excitation.omega[[0, -1]]
        raise InputError("wp", wave.wp, "the excitation is not known at this frequency",
                         f"Give a frequency in the tabulated band, {low:g} to {high:g} rad/s")  # fmt: skip
    at = Wave(float(wave.height), float(wave.wp), float(wave.heading))
    orbit = _search(plant, at, Forcing(0.5 * at.height * he, at.wp), float(cc), float(cg), sense, dt, guess)
    if orbit.status != "no orbit" or not nearest:
        return orbit
    from gyroctl.linearisation.nearest import nearest_height

    height = nearest_height(plant, at, cc, cg, sense, dt, orbit.lock_share)
    return dataclasses.replace(orbit, nearest_height=height, advice=_way_out(at.height, height))


def _search(
    plant: Plant, wave: Wave, forcing: Forcing, cc: float, cg: float, sense: int, dt: float,
    guess: NDArray[np.float64] | None,
) -> PeriodicOrbit:  # fmt: skip
    guesses = [guess] if guess is not None else harmonic_balance(plant, forcing, cc, cg, sense)
    found: list[PeriodicOrbit] = []
    for first in guesses:
        for settle in (False, True):
            start = flow(plant, first, cc, cg, forcing, SETTLING, dt)[: first.size] if settle else first
            if settle:
                start = start.copy()
                start[PSI] -= sense * 2.0 * np.pi * SETTLING
                start[OMEGA] = 0.0
            x, residual = _newton(plant, np.real(start), cc, cg, forcing, sense, dt)
            if residual < 1e-8:
                found.append(describe(plant, x, residual, cc, cg, wave, forcing, sense, dt))
                break
        if found and found[-1].status == "stable":
            return found[-1]
    if found:
        return min(found, key=lambda orbit: float(np.abs(orbit.multipliers[0])))
    nothing = np.full(len(plant.labels), np.nan)
    unknown = np.full(free_rows(plant).size, np.nan, complex)
    return PeriodicOrbit(
        nothing, forcing.period, unknown, np.nan, np.nan, np.nan, np.nan, estimated_share(plant, forcing, cg, sense),
        "no orbit", _way_out(wave.height, np.nan), plant, cc, cg, sense, dt, wave, unknown,
    )  # fmt: skip


def _way_out(height: float, nearest: float) -> str:
    if np.isnan(nearest):
        return "Lower cg or raise the wave height: the load asks for more than the wave can pull"
    verb = "raise" if nearest > height else "lower"
    return (
        f"Lower cg or {verb} the wave height from {height:.4g} m to {nearest:.4g} m, the nearest that has an orbit: "
        "the load asks for more than the wave can pull"
    )


def _newton(
    plant: Plant, x: NDArray[np.float64], cc: float, cg: float, forcing: Forcing, sense: int, dt: float
) -> tuple[NDArray[np.float64], float]:
    """Fixed point of the reflected half map in all states but omega."""
    free = free_rows(plant)
    sign = signs(x.size)
    scale = np.maximum(np.abs(x[free]), 1e-2)
    size = np.inf
    for _ in range(ITERATIONS):
        end, jacobian = flow_jacobian(plant, x, cc, cg, forcing, 0.5, dt)
        gap = (reflect(end, sense) - x)[free]
        size = float(np.max(np.abs(gap) / scale))
        if not np.isfinite(size) or size < TOLERANCE:
            break
        half = (sign[:, None] * jacobian)[np.ix_(free, free)]
        step = np.linalg.solve(np.eye(free.size) - half, gap)
        # the ring angle sets how far the linear picture can be trusted
        shrink = min(1.0, 0.5 / max(abs(step[2]), 1e-300))
        x = x.copy()
        x[free] += shrink * step
        x[OMEGA] = 0.0
        if plant.parameters.connection == "rigid":
            x[OMEGA_RATE] = plant.parameters.N * x[PSI_RATE]
    return x, size if np.isfinite(size) else np.inf


def describe(
    plant: Plant, x: NDArray[np.float64], residual: float, cc: float, cg: float, wave: Wave, forcing: Forcing,
    sense: int, dt: float,
) -> PeriodicOrbit:  # fmt: skip
    """Return the orbit through the fixed point `x` (n,) of the half map, with everything that is told of it."""
    free, n = free_rows(plant), x.size
    _, half = flow_jacobian(plant, x, cc, cg, forcing, 0.5, dt)
    _, full = flow_jacobian(plant, x, cc, cg, forcing, 1.0, dt)
    reflected = (signs(n)[:, None] * half)[np.ix_(free, free)]
    squared = reflected @ reflected
    halves = np.linalg.eigvals(reflected).astype(complex)
    halves = halves[np.argsort(-np.abs(halves), kind="stable")]
    multipliers = halves**2
    error = float(np.max(np.abs(squared - full[np.ix_(free, free)])))
    end = flow(plant, x, cc, cg, forcing, 1.0, dt)
    power = float(np.real(end[n + 4])) / forcing.period
    rates = []
    for i in range(PIECES):
        state = np.real(flow(plant, x, cc, cg, forcing, 0.5 * i / PIECES, dt)[:n]) if i else x
        rates.append(np.exp(1j * state[PSI]) * (state[PHI1_RATE] + 1j * state[PHI3_RATE]))
    mean = complex(np.mean(rates))  # the second half of the period repeats the first
    stable = bool(np.abs(multipliers[0]) < 1.0)
    advice = "" if stable else _advice(multipliers[0])
    return PeriodicOrbit(
        x, forcing.period, multipliers, error, residual, power, float(np.angle(mean)),
        plant.parameters.N * cg / (plant.parameters.J4 * abs(mean)), "stable" if stable else "unstable", advice,
        plant, cc, cg, sense, dt, wave, halves,
    )  # fmt: skip


def _advice(multiplier: complex) -> str:
    if abs(multiplier.imag) > 1e-6:
        return "An oscillation grows on this orbit (Neimark-Sacker): raise the hinge damping d1 or change cc"
    return "A ring angle off this orbit runs away from it: this is the branch behind the fold"
