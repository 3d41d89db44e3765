"""The locked orbit: the ring turns once per wave, found by Newton's method on the half-period map.

The forced system maps to itself under half a period and phi -> -phi, z -> -z, psi -> psi - pi (times the sense of
rotation). The fixed point of the half-period map followed by that reflection is the orbit; it halves the work, and
the square of the half map's Jacobian against the full map's is a free check of accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.flow import Forcing, flow, flow_jacobian
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA, OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE, RADIATION

Status = Literal["stable", "unstable", "no orbit"]

TOLERANCE = 1e-11
ITERATIONS = 30
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
        What to do about it.
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


def lock_orbit(
    plant: Plant, wave: RegularWave, cc: float, cg: float, sense: int = 1, dt: float = 0.01,
    guess: NDArray[np.float64] | None = None,
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
    forcing = Forcing(0.5 * wave.height * he, wave.wp)
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
                found.append(_describe(plant, x, residual, cc, cg, forcing, sense, dt))
                break
        if found and found[-1].status == "stable":
            return found[-1]
    if found:
        return min(found, key=lambda orbit: float(np.abs(orbit.multipliers[0])))
    nothing = np.full(len(plant.labels), np.nan)
    share = _capacity(plant, forcing, cg, sense)
    return PeriodicOrbit(
        nothing, forcing.period, np.full(nothing.size - 1, np.nan, complex), np.nan, np.nan, np.nan, np.nan, share,
        "no orbit", "Lower cg or raise the wave height: the load asks for more than the wave can pull", plant, cc, cg,
        sense,
    )  # fmt: skip


def harmonic_balance(
    plant: Plant, forcing: Forcing, cc: float, cg: float, sense: int
) -> list[NDArray[np.float64]]:
    """First guesses: float motion at the wave frequency, ring at constant speed, mean torque in balance.

    The ring angle at phase zero is where the mean of u3 is what the generator takes, -N cg/J4; there are two such
    angles below pull-out, of which one is stable, and none above: then the angle of largest pull is returned.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 721)
    surplus = _mean_u3(plant, forcing, angles, sense) + plant.parameters.N * cg / plant.parameters.J4
    crossings = np.flatnonzero(np.sign(surplus[:-1]) * np.sign(surplus[1:]) <= 0)
    roots = [
        angles[i] - surplus[i] * (angles[i + 1] - angles[i]) / (surplus[i + 1] - surplus[i]) for i in crossings
    ] or [float(angles[np.argmin(surplus)])]
    return [_harmonic_state(plant, forcing, cc, cg, angle, sense) for angle in roots]


def _float_rates(
    plant: Plant, forcing: Forcing, angle: NDArray[np.float64], sense: int
) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]:
    """Complex amplitudes of phi1', phi3' and of exp(i sense psi) at the wave frequency."""
    k, w = plant.coefficients, forcing.wp
    turning = np.exp(1j * sense * angle)
    gyroscopic = k.N * (2.0 * k.J3 + k.J4) * w**2
    h1, h3 = (r.response(w) for r in plant.radiation)
    z1 = k.k1 - w**2 * (1.0 / k.i1 + 0.5 * k.K) + 1j * w * (k.d1 + h1)
    z3 = k.k3 - w**2 * (1.0 / k.i3 + 0.5 * k.K) + 1j * w * (k.d3 + h3)
    v1 = 1j * w * (forcing.amplitude[0] - 1j * sense * gyroscopic * turning) / z1
    v3 = 1j * w * (forcing.amplitude[1] + gyroscopic * turning) / z3
    return v1, v3, turning


def _mean_u3(plant: Plant, forcing: Forcing, angle: NDArray[np.float64], sense: int) -> NDArray[np.float64]:
    v1, v3, turning = _float_rates(plant, forcing, angle, sense)
    return np.asarray(0.5 * np.real(np.conj(-1j * sense * turning) * v1 + np.conj(turning) * v3))


def _capacity(plant: Plant, forcing: Forcing, cg: float, sense: int) -> float:
    """Estimate of the used share of lock capacity by harmonic balance."""
    pull = -_mean_u3(plant, forcing, np.linspace(0.0, 2.0 * np.pi, 721), sense)
    return float(plant.parameters.N * cg / plant.parameters.J4 / np.max(pull))


def _harmonic_state(
    plant: Plant, forcing: Forcing, cc: float, cg: float, angle: float, sense: int
) -> NDArray[np.float64]:
    v1, v3, _ = (np.asarray(v).item() for v in _float_rates(plant, forcing, np.asarray(angle), sense))
    w, k = forcing.wp, plant.coefficients
    x = np.zeros(len(plant.labels))
    x[PHI1], x[PHI3] = (v1 / (1j * w)).real, (v3 / (1j * w)).real
    x[PHI1_RATE], x[PHI3_RATE] = v1.real, v3.real
    x[PSI], x[PSI_RATE] = angle, sense * w
    slip = cc / (cc + cg) if cc + cg > 0.0 and plant.parameters.connection == "magnetic" else 1.0
    x[OMEGA_RATE] = k.N * sense * w * slip
    row = RADIATION
    for rate, r in zip((v1, v3), plant.radiation, strict=True):
        state = rate / np.polyval([1.0, *r.q], 1j * w)
        for i in range(len(r.q)):
            x[row + i] = (state * (1j * w) ** i).real
        row += len(r.q)
    return x


def _reflect(x: NDArray[np.float64], sense: int) -> NDArray[np.float64]:
    """Undo half a period by symmetry."""
    out = -x
    for row in (OMEGA, PSI_RATE, OMEGA_RATE):
        out[row] = x[row]
    out[PSI] = x[PSI] - sense * np.pi
    return out


def _newton(
    plant: Plant, x: NDArray[np.float64], cc: float, cg: float, forcing: Forcing, sense: int, dt: float
) -> tuple[NDArray[np.float64], float]:
    """Fixed point of the reflected half map in all states but omega."""
    free = _free_rows(plant)
    signs = _signs(plant)
    scale = np.maximum(np.abs(x[free]), 1e-2)
    size = np.inf
    for _ in range(ITERATIONS):
        end, jacobian = flow_jacobian(plant, x, cc, cg, forcing, 0.5, dt)
        gap = (_reflect(end, sense) - x)[free]
        size = float(np.max(np.abs(gap) / scale))
        if not np.isfinite(size) or size < TOLERANCE:
            break
        half = (signs[:, None] * jacobian)[np.ix_(free, free)]
        step = np.linalg.solve(np.eye(free.size) - half, gap)
        # the ring angle sets how far the linear picture can be trusted
        shrink = min(1.0, 0.5 / max(abs(step[2]), 1e-300))
        x = x.copy()
        x[free] += shrink * step
        x[OMEGA] = 0.0
        if plant.parameters.connection == "rigid":
            x[OMEGA_RATE] = plant.parameters.N * x[PSI_RATE]
    return x, size if np.isfinite(size) else np.inf


def _free_rows(plant: Plant) -> NDArray[np.int64]:
    """Rows that Newton's method may move: not omega, and not omega' where it is tied to the ring."""
    tied = (OMEGA,) if plant.parameters.connection == "magnetic" else (OMEGA, OMEGA_RATE)
    return np.array([row for row in range(len(plant.labels)) if row not in tied])


def _signs(plant: Plant) -> NDArray[np.float64]:
    signs = -np.ones(len(plant.labels))
    signs[[PSI, OMEGA, PSI_RATE, OMEGA_RATE]] = 1.0
    return signs


def _describe(
    plant: Plant, x: NDArray[np.float64], residual: float, cc: float, cg: float, forcing: Forcing, sense: int, dt: float
) -> PeriodicOrbit:
    free, n = _free_rows(plant), x.size
    _, half = flow_jacobian(plant, x, cc, cg, forcing, 0.5, dt)
    _, full = flow_jacobian(plant, x, cc, cg, forcing, 1.0, dt)
    squared = np.linalg.matrix_power((_signs(plant)[:, None] * half)[np.ix_(free, free)], 2)
    multipliers = np.linalg.eigvals(squared)
    multipliers = multipliers[np.argsort(-np.abs(multipliers))]
    error = float(np.max(np.abs(squared - full[np.ix_(free, free)])))
    end = flow(plant, x, cc, cg, forcing, 1.0, dt)
    power = float(np.real(end[n + 4])) / forcing.period
    points = [x]
    pieces = 32
    rates = []
    for i in range(pieces):
        state = np.real(flow(plant, x, cc, cg, forcing, i / pieces, dt)[:n]) if i else points[0]
        rates.append(np.exp(1j * state[PSI]) * (state[PHI1_RATE] + 1j * state[PHI3_RATE]))
    mean = complex(np.mean(rates))
    stable = bool(np.abs(multipliers[0]) < 1.0)
    advice = "" if stable else _advice(multipliers[0])
    return PeriodicOrbit(
        x, forcing.period, multipliers, error, residual, power, float(np.angle(mean)),
        plant.parameters.N * cg / (plant.parameters.J4 * abs(mean)), "stable" if stable else "unstable", advice,
        plant, cc, cg, sense,
    )  # fmt: skip


def _advice(multiplier: complex) -> str:
    if abs(multiplier.imag) > 1e-6:
        return "An oscillation grows on this orbit (Neimark-Sacker): raise the hinge damping d1 or change cc"
    return "A ring angle off this orbit runs away from it: this is the branch behind the fold"
