"""First guess of the locked orbit by harmonic balance: float at the wave frequency, ring at constant speed."""

from __future__ import annotations

import numpy as np

from gyroctl.orbits.flow import Complex, Forcing, Vector
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE, RADIATION

ANGLES = 721


def harmonic_balance(plant: Plant, forcing: Forcing, cc: float, cg: float, sense: int) -> list[Vector]:
    """First guesses: float motion at the wave frequency, ring at constant speed, mean torque in balance.

    The ring angle at phase zero is where the mean of u3 is what the generator takes, -N cg/J4; there are two such
    angles below pull-out, of which one is stable, and none above: then the angle of largest pull is returned.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, ANGLES)
    surplus = _mean_u3(plant, forcing, angles, sense) + plant.parameters.N * cg / plant.parameters.J4
    crossings = np.flatnonzero(np.sign(surplus[:-1]) * np.sign(surplus[1:]) <= 0)
    step = np.diff(angles)
    roots = [angles[i] - surplus[i] * step[i] / (surplus[i + 1] - surplus[i]) for i in crossings]
    best = float(angles[np.argmin(surplus)])
    return [_harmonic_state(plant, forcing, cc, cg, angle, sense) for angle in roots or [best]]


def estimated_share(plant: Plant, forcing: Forcing, cg: float, sense: int) -> float:
    """Estimate of the used share of lock capacity by harmonic balance; infinite where the wave pulls nowhere."""
    pull = -_mean_u3(plant, forcing, np.linspace(0.0, 2.0 * np.pi, ANGLES), sense)
    best = float(np.max(pull))
    return float(plant.parameters.N * cg / plant.parameters.J4 / best) if best > 0.0 else np.inf


def _float_rates(plant: Plant, forcing: Forcing, angle: Vector, sense: int) -> tuple[Complex, Complex, Complex]:
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


def _mean_u3(plant: Plant, forcing: Forcing, angle: Vector, sense: int) -> Vector:
    v1, v3, turning = _float_rates(plant, forcing, angle, sense)
    return np.asarray(0.5 * np.real(np.conj(-1j * sense * turning) * v1 + np.conj(turning) * v3))


def _harmonic_state(plant: Plant, forcing: Forcing, cc: float, cg: float, angle: float, sense: int) -> Vector:
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
