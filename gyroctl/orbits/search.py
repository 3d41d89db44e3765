"""The search for a locked orbit by Newton's method on the half-period map, from harmonic balance."""

from __future__ import annotations

import numpy as np

from gyroctl.errors import InputError
from gyroctl.orbits.flow import Forcing, Vector, flow, flow_jacobian
from gyroctl.orbits.guess import estimated_share, harmonic_balance
from gyroctl.orbits.orbit import LockProblem, Orbit, describe
from gyroctl.orbits.sensitivity import state_units
from gyroctl.orbits.symmetry import free_rows, reflect, signs, unwound
from gyroctl.orbits.wave import RegularWave, Wave
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA, OMEGA_RATE, PSI, PSI_RATE

TOLERANCE = 1e-11
ITERATIONS = 30

SETTLING = 40
"""Periods of plain simulation that bring a poor first guess nearer, where Newton's method fails from the guess."""

TOO_HEAVY = "the load asks for more than the wave can pull"


def search_orbit(
    plant: Plant,
    wave: RegularWave,
    cc: float,
    cg: float,
    sense: int = 1,
    dt: float | None = None,
    guess: Vector | None = None,
) -> Orbit:
    """Find the locked orbit; parameters, result and errors as of `gyroctl.lock_orbit`, without the nearest height.

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
    if not wave.height > 0.0:
        raise InputError("height", wave.height, "must be positive", "Give the wave height in metres, for example 0.2")
    if not wave.wp > 0.0:
        raise InputError("wp", wave.wp, "must be positive", "Give the angular frequency in rad/s, for example 3.14")
    if sense not in (1, -1):
        raise InputError("sense", sense, "must be 1 or -1", "Choose the sense of rotation of the ring")
    for name, value in (("cc", cc), ("cg", cg)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(name, value, "must be zero or positive", f"Give {name} in Nms")
    at = Wave(float(wave.height), float(wave.wp), float(wave.heading))
    forcing = Forcing.of(plant, at)
    if not np.any(forcing.amplitude):
        low, high = plant.excitation.omega[[0, -1]]
        mend = f"Give a frequency in the tabulated band, {low:g} to {high:g} rad/s"
        raise InputError("wp", wave.wp, "the excitation is not known at this frequency", mend)
    problem = LockProblem(plant, float(cc), float(cg), sense, plant.step if dt is None else dt, at)
    guesses = [guess] if guess is not None else harmonic_balance(plant, forcing, problem.cc, problem.cg, sense)
    found: list[Orbit] = []
    for first in guesses:
        orbit = _from_guess(problem, forcing, first)
        if orbit is not None and orbit.status == "stable":
            return orbit
        found += [orbit] if orbit is not None else []
    if found:
        return min(found, key=lambda orbit: float(np.abs(orbit.multipliers[0])))
    nothing, nan = np.full(len(plant.labels), np.nan), np.nan
    unknown = np.full(free_rows(plant).size, np.nan, complex)
    share = estimated_share(plant, forcing, problem.cg, sense)
    advice = f"Lower cg or raise the wave height: {TOO_HEAVY}"
    return Orbit(nothing, forcing.period, unknown, nan, nan, nan, nan, share, "no orbit", advice, *problem, unknown)


def _from_guess(problem: LockProblem, forcing: Forcing, guess: Vector) -> Orbit | None:
    """Orbit by Newton's method from a guess, or else from where plain simulation leads it; None where both fail."""
    plant, cc, cg, sense, dt, _ = problem
    x, residual = _newton(problem, forcing, np.real(guess))
    if not residual < 1e-8:
        start = flow(plant, guess, cc, cg, forcing, SETTLING, dt)[: guess.size].copy()
        start[PSI] -= sense * 2.0 * np.pi * SETTLING
        start[OMEGA] = 0.0
        x, residual = _newton(problem, forcing, np.real(start))
    return describe(problem, forcing, x, residual) if residual < 1e-8 else None


def _newton(problem: LockProblem, forcing: Forcing, x: Vector) -> tuple[Vector, float]:
    """Fixed point in all states but omega: of the reflected half map, or of the whole one where symmetry fails."""
    plant, cc, cg, sense, dt, _ = problem
    free, symmetric = free_rows(plant), plant.parameters.symmetric
    sign = signs(x.size) if symmetric else np.ones(x.size)
    periods = 0.5 if symmetric else 1.0
    scale = np.maximum(np.abs(x[free]), 1e-2 * state_units(plant)[free])
    size = np.inf
    for _ in range(ITERATIONS):
        end, jacobian = flow_jacobian(plant, x, cc, cg, forcing, periods, dt)
        gap = ((reflect(end, sense) if symmetric else unwound(end, sense)) - x)[free]
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
