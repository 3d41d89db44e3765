"""The search for a locked orbit by Newton's method on the half-period map, from harmonic balance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.orbits.flow import Forcing, flow, flow_jacobian
from gyroctl.orbits.guess import estimated_share, harmonic_balance
from gyroctl.orbits.orbit import Orbit, describe
from gyroctl.orbits.symmetry import free_rows, reflect, signs
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
    dt: float = 0.01,
    guess: NDArray[np.float64] | None = None,
) -> Orbit:
    """Find the locked orbit; parameters, result and errors as of `gyroctl.lock_orbit`, without the nearest height."""
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
        raise InputError(
            "wp",
            wave.wp,
            "the excitation is not known at this frequency",
            f"Give a frequency in the tabulated band, {low:g} to {high:g} rad/s",
        )
    at = Wave(float(wave.height), float(wave.wp), float(wave.heading))
    return _search(plant, at, Forcing(0.5 * at.height * he, at.wp), float(cc), float(cg), sense, dt, guess)


def _search(
    plant: Plant,
    wave: Wave,
    forcing: Forcing,
    cc: float,
    cg: float,
    sense: int,
    dt: float,
    guess: NDArray[np.float64] | None,
) -> Orbit:
    guesses = [guess] if guess is not None else harmonic_balance(plant, forcing, cc, cg, sense)
    found: list[Orbit] = []
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
    return Orbit(
        nothing,
        forcing.period,
        unknown,
        np.nan,
        np.nan,
        np.nan,
        np.nan,
        estimated_share(plant, forcing, cg, sense),
        "no orbit",
        f"Lower cg or raise the wave height: {TOO_HEAVY}",
        plant,
        cc,
        cg,
        sense,
        dt,
        wave,
        unknown,
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
