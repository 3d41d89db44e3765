"""Named modes of the locked orbit, the fast ones included.

The slip decays by e-70 over half a period, so no eigenvalue of the monodromy matrix knows it. The half period is cut
into segments instead and the segments' Jacobians are put side by side in one block-cyclic matrix: its eigenvalues are
the roots of the multipliers, all within reach of the rounding (the idea of the periodic Schur decomposition; see
Bojanczyk, Golub and Van Dooren 1992, and Lust 2001 for Floquet multipliers).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.faces.locks import mode_face
from gyroctl.faces.show import shown
from gyroctl.orbits.flow import PADDING, Complex, Matrix, Stretch, changes, directions, step_count
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.sensitivity import state_units
from gyroctl.orbits.symmetry import free_rows, signs
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE, RADIATION
from gyroctl.plant.kernel import slip_rate

SEGMENTS = 4
DECAY = 15.0
"""Least number of segments, and the largest decay of the slip over one of them that the rounding lets through."""

TWISTS = (0.5, 1.1, 1.7)
"""Angles [rad] by which the product is turned, so that no root of it falls on the border between two branches."""

SIZES = {"horizontal": 2, "libration": 2, "slip": 1, "vertical": 2}
FLIPPED = ("horizontal", "vertical", "radiation")
"""Modes of the float: the symmetry changes their sign, so that the half map's multiplier has another sign too."""


@shown(mode_face)
@dataclass(frozen=True)
class Mode:
    """A Floquet mode: a real multiplier or a conjugate pair.

    Parameters
    ----------
    name : {"libration", "horizontal", "vertical", "slip", "radiation"}
        By the states that take part in it: ring phase and angular momentum about the ring's axis; phi1; phi3; the
        difference between flywheel and ring; the waves that were radiated.
    multiplier : complex
        Over one period, imaginary part not negative. [-]
    order : {1, 2}
        1 for a real multiplier, 2 for a pair.
    rate : float
        Growth rate, negative where it decays. [1/s]
    frequency : float
        Zero for a real one; otherwise known up to multiples of twice the wave's frequency, and given in the interval
        up to the wave's frequency. [rad/s]
    share : float
        Part of the mode in the states that it is named after. [-]
    shape : (n,) complex array
        Right eigenvector at phase zero, largest entry one. [-]
    """

    name: str
    multiplier: complex
    order: int
    rate: float
    frequency: float
    share: float
    shape: NDArray[np.complex128]

    @property
    def decay_time(self) -> float:
        """Time to fall by e; negative where the mode grows. [s]"""
        return -1.0 / self.rate

    @property
    def period(self) -> float:
        """Period of the oscillation; infinite for a real multiplier. [s]"""
        return 2.0 * np.pi / self.frequency if self.frequency > 0.0 else np.inf


def segment_jacobians(orbit: Orbit, segments: int, halves: int = 1) -> NDArray[np.float64]:
    """Exact Jacobians (segments, m, m) of the flow over equal parts of half a period (or a whole one, `halves` = 2).

    The unknowns are those of the half map; the symmetry is in the last of the segments of half a period.
    """
    plant, forcing = orbit.plant, orbit.forcing
    k, n, free = plant.coefficients, orbit.x.size, free_rows(plant)
    hold = 0.5 * halves * orbit.period / segments
    steps = step_count(k, orbit.cc, hold, orbit.dt, plant.parameters.time_scale)
    waves = forcing.grid(0.5 * halves)
    gear = k.N if plant.parameters.connection == "rigid" else None
    state, blocks = orbit.x.astype(float), []
    for i in range(segments):
        stretch = Stretch(PADDING * forcing.dt + i * hold, hold, steps, waves, forcing.dt)
        state, columns = changes(k, state, directions(n, gear)[:, free], orbit.cc, orbit.cg, stretch)
        blocks.append(columns[free])
    if halves == 1:
        blocks[-1] = signs(n)[free, None] * blocks[-1]
    return np.array(blocks)


def find_modes(orbit: Orbit) -> tuple[Mode, ...]:
    """Modes of an orbit, slowest decay first.

    Parameters
    ----------
    orbit : Orbit
        A locked orbit.

    Returns
    -------
    tuple of Mode
        libration, horizontal, vertical, slip, radiation: as many as the orbit has.
    """
    if orbit.status == "no orbit":
        return ()
    slip = float(slip_rate(orbit.plant.coefficients, orbit.cc))  # zero where the flywheel is geared
    symmetric = orbit.plant.parameters.symmetric
    pieces = max(SEGMENTS, int(np.ceil(0.5 * orbit.period * slip / DECAY)))
    blocks = segment_jacobians(orbit, pieces) if symmetric else segment_jacobians(orbit, 2 * pieces, 2)
    halves, shares, shapes = _cyclic_eigenvalues(orbit, blocks)
    groups = _group_shares(orbit, shares)
    single = np.abs(halves.imag) <= 1e-7 * np.abs(halves)
    kept = [i for i in range(halves.size) if single[i] or halves[i].imag > 0.0]
    names = _assign({i: {name: share[i] for name, share in groups.items()} for i in kept}, single)
    modes = []
    for i in kept:
        half = complex(halves[i].real) if single[i] else complex(halves[i])
        if not symmetric:  # of the whole period: the frequency is told up to half of that of the wave
            half = complex(np.sqrt(half + 0j))
        turned = -half if symmetric and names[i] in FLIPPED else half
        frequency = 0.0 if single[i] and turned.real > 0.0 else abs(float(np.angle(turned))) / (0.5 * orbit.period)
        multiplier = half**2 if (half**2).imag >= 0.0 else (half**2).conjugate()
        rate, share = float(np.log(abs(half))) / (0.5 * orbit.period), float(groups[names[i]][i])
        modes.append(Mode(names[i], multiplier, 1 if single[i] else 2, rate, frequency, share, shapes[i]))
    return tuple(sorted(modes, key=lambda mode: -mode.rate))


def _cyclic_eigenvalues(orbit: Orbit, blocks: Matrix) -> tuple[Complex, Matrix, Complex]:
    """Half-map multipliers (m,), participation (rows of the changed coordinates, m), shapes (m, n) at phase zero."""
    count, m = blocks.shape[0], blocks.shape[1]
    free = free_rows(orbit.plant)
    scale = np.maximum(np.abs(orbit.x[free]), 1e-3 * state_units(orbit.plant)[free])
    change = _coordinates(orbit)
    for twist in TWISTS:
        cyclic = np.zeros((count * m, count * m), complex)
        for i, block in enumerate(blocks):
            to = (i + 1) % count
            turned = block * (scale[None, :] / scale[:, None]) * (np.exp(1j * twist) if to == 0 else 1.0)
            cyclic[to * m : (to + 1) * m, i * m : (i + 1) * m] = turned
        roots, right = np.linalg.eig(cyclic)
        main = np.flatnonzero(np.abs(np.angle(roots)) < np.pi / count)
        if main.size == m:
            break
    else:
        main = np.argsort(np.abs(np.angle(roots)))[:m]
    left = np.linalg.inv(right)
    shares = np.zeros((m, m))
    for i in range(count):
        rows = slice(i * m, (i + 1) * m)
        v = change @ (scale[:, None] * right[rows][:, main])
        w = (left[main][:, rows] / scale[None, :]) @ np.linalg.inv(change)
        shares += np.abs(v * w.T)
    shapes = np.zeros((m, orbit.x.size), complex)
    shapes[:, free] = (scale[:, None] * right[:m][:, main]).T
    shapes /= shapes[np.arange(m), np.argmax(np.abs(shapes), axis=1)][:, None]
    return roots[main] ** count * np.exp(-1j * twist), shares / shares.sum(axis=0), shapes


def _coordinates(orbit: Orbit) -> NDArray[np.float64]:
    """Matrix (m, m) to coordinates that keep slip and libration apart.

    The coupling changes the slip omega' - N psi' but not J2 psi'/N + J4 omega'.
    """
    free = list(free_rows(orbit.plant))
    change = np.eye(len(free))
    if OMEGA_RATE in free:
        p = orbit.plant.parameters
        ring, wheel = free.index(PSI_RATE), free.index(OMEGA_RATE)
        change[ring, [ring, wheel]] = p.J2 / p.N, p.J4
        change[wheel, [ring, wheel]] = -p.N, 1.0
    return change


def _group_shares(orbit: Orbit, shares: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    free = list(free_rows(orbit.plant))
    rows = {
        "horizontal": (PHI1, PHI1_RATE),
        "vertical": (PHI3, PHI3_RATE),
        "libration": (PSI, PSI_RATE),
        "slip": (OMEGA_RATE,),
        "radiation": tuple(range(RADIATION, orbit.x.size)),
    }
    nothing = np.zeros(len(free))
    return {name: sum((shares[free.index(r)] for r in own if r in free), nothing) for name, own in rows.items()}


def _assign(shares: dict[int, dict[str, float]], single: NDArray[np.bool_]) -> dict[int, str]:
    """Give names, the clearest case first, none to more modes than the device has states of that kind."""
    left = dict(SIZES)
    names: dict[int, str] = {}
    for i, name, _ in sorted(((i, n, s) for i, by in shares.items() for n, s in by.items()), key=lambda c: -c[2]):
        order = 1 if single[i] else 2
        if i in names or (name in left and left[name] < order):
            continue
        names[i] = name
        if name in left:
            left[name] -= order
    return names
