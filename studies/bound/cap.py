"""A cap that no law can pass: what the float could yield to a device that may exchange angular momentum at will.

All that ring, spin axis and flywheel do to the float is the rate of change of their angular momentum about the spin
axis e = (cos psi, -sin psi): with h = K u1 + 2 N J3 psi' + J4 omega', equations (22)-(23) read

    (J1 + Jh) phi'' + d phi' + Mr + k phi = Me - d/dt (h e)        (and the lever term, which does no work)

So whatever the law: the moment on the float is -H', where H stays within a disc of radius max |h|, which the speed of
the flywheel sets. Drop all else that binds H (that it lies on the circle, that the ring must turn it, that the coupling
only brakes), keep the disc and the limits of motion, and let H choose itself with perfect foresight: a convex problem,
whose optimum is no less than what any law takes from the float. What a law takes feeds the generator and the slip.

Absorbed energy is the wave input less radiation, hinge and the float's stored energy. That it is a concave function of
the motion needs the storage of the radiation filters written out: Mr phi' = d/dt (z'Xz/2) + z'Qz/2 with A'X + XA = -Q,
X b = p (positive-real lemma). Time is discretised by the midpoint rule, which keeps this balance exactly.

All of it is of the linear float. Beyond the linear plant the waves' moments depend on where the float is: their power
is no concave function of the motion, the largest moment over all places times a speed that nothing bounds is no bound
either, and what hinge, radiation and drag leave of that, pointwise, is a hundred times what is there. So no cap of use
is known there; drag and the losses inside only take, but what the moving position and the wetted surface bring in may
be of either sign. The linear float's cap in the same waves is a yardstick beside it, and no limit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI1_RATE, PHI3, PHI3_RATE, PSI, PSI_RATE, RADIATION
from gyroctl.simulation.metrics import Record
from gyroctl.waves import WaveRealisation

INSIDE = ("slip", "generator", "bearing", "windage", "rolling_resistance", "contact")
"""Powers of the ledger that are taken inside the float."""


class Float(NamedTuple):
    """Float alone, I v' = Me - H' - d v - k phi - p z: states (phi1, v1, z1.., phi3, v3, z3..)."""

    A: NDArray[np.float64]  # (n, n)
    B: NDArray[np.float64]  # (n, 2) of a moment
    damping: NDArray[np.float64]  # (n, n) power lost, x'Dx [W]
    energy: NDArray[np.float64]  # (n, n) stored mechanically, x'Ex/2 [J]
    filters: NDArray[np.float64]  # (n, n) and in the radiation filters, x'Sx/2 [J]
    rates: tuple[int, int]  # rows of v1, v3
    angles: tuple[int, int]  # rows of phi1, phi3


def float_alone(plant: Plant) -> Float:
    """Linear model of the float without what is inside.

    Raises
    ------
    InputError
        Field ``plant``: where a device has the doubly counted generator reaction, which is no exchange of momentum.
    """
    import scipy.linalg

    k = plant.coefficients
    if k.reaction:
        problem = "the doubled generator reaction makes energy of its own"
        raise InputError("plant", plant.name, problem, "Use the corrected device")
    parts: list[tuple[Any, ...]] = []
    for inverse, stiffness, d, p, q in ((k.i1, k.k1, k.d1, k.p1, k.q1), (k.i3, k.k3, k.d3, k.p3, k.q3)):
        n = len(q)
        filters = np.diag(np.ones(n - 1), 1)
        filters[-1] = -np.array(q[::-1])
        b, out = np.zeros(n), np.zeros(n)
        b[-1] = 1.0
        out[: len(p)] = p[::-1]
        X, Q = storage(filters, b, out)
        A, D, E, S = (np.zeros((n + 2, n + 2)) for _ in range(4))
        A[0, 1], A[1, 0], A[1, 1] = 1.0, -stiffness * inverse, -d * inverse
        A[1, 2:], A[2:, 1], A[2:, 2:] = -out * inverse, b, filters
        D[1, 1], D[2:, 2:] = d, 0.5 * Q
        E[0, 0], E[1, 1], S[2:, 2:] = stiffness, 1.0 / inverse, X
        parts.append((A, np.eye(n + 2)[:, 1:2] * inverse, D, E, S))
    first = len(k.q1) + 2
    A, B, D, E, S = (scipy.linalg.block_diag(*matrices) for matrices in zip(*parts, strict=True))
    return Float(A, B, D, E, S, (1, first + 1), (0, first))


def storage(
    A: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Storage X and loss Q of a passive filter z' = Az + bv, Mr = c'z: A'X + XA = -Q <= 0, Xb = c, X > 0."""
    import cvxpy as cp

    n = int(b.size)
    # unit-size states and outputs: the canonical form is badly scaled
    size = np.abs(np.linalg.eigvals(A)).mean() ** np.arange(n)
    gain = float(np.abs(c * size).max())
    scaled, into, out = A * size[None, :] / size[:, None], b / size, c * size / gain
    unit = float(np.abs(into).max())
    X = cp.Variable((n, n), symmetric=True)
    loss = -(scaled.T @ X + X @ scaled)
    problem = cp.Problem(cp.Minimize(cp.norm(X @ (into / unit) - out)), [X >> 0, loss >> 0])
    problem.solve(solver="CLARABEL")
    found = gain / unit * np.asarray(X.value) / np.outer(size, size)
    found = 0.5 * (found + found.T)
    return found, -(A.T @ found + found @ A)


def momentum(plant: Plant, states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angular momentum H (2, n) of all inside the float about the spin axis, from states (n, rows). [Nms]"""
    k = plant.coefficients
    c, s = np.cos(states[:, PSI]), np.sin(states[:, PSI])
    u1 = c * states[:, PHI1_RATE] - s * states[:, PHI3_RATE]
    axis = 2.0 * k.N * k.J3 * states[:, PSI_RATE]
    if plant.slips:
        axis = 2.0 * k.J3 * states[:, len(plant.labels) - 1]
    h = k.K * u1 + axis + k.J4 * states[:, OMEGA_RATE]
    return np.array([h * c, -h * s])


def float_states(plant: Plant, states: NDArray[np.float64]) -> NDArray[np.float64]:
    """States of `Float` (n, samples) from those of the plant (samples, rows)."""
    n1, n3 = len(plant.coefficients.q1), len(plant.coefficients.q3)
    order = [PHI1, PHI1_RATE, *range(RADIATION, RADIATION + n1)]
    order += [PHI3, PHI3_RATE, *range(RADIATION + n1, RADIATION + n1 + n3)]
    return states[:, order].T


def absorbed(plant: Plant, record: Record) -> float:
    """Mean power that all inside the float took from it in a run: generated, slipped and stored inside. [W]"""
    n = len(plant.labels)
    ends = record.states[[0, -1]]
    x = float_states(plant, ends)
    outside = 0.5 * np.einsum("is,ij,js->s", x, float_alone(plant).energy, x)
    inside = np.asarray(plant.stored_energy(ends[:, :n].T)) - outside
    taken = float(inside[1] - inside[0])
    for name in INSIDE:
        if name in plant.ledger:
            row = n + plant.ledger.index(name)
            taken += float(ends[1, row] - ends[0, row])
    return float(taken / ((record.states.shape[0] - 1) * record.period))


def momentum_cap(
    plant: Plant,
    waves: WaveRealisation,
    start: NDArray[np.float64],
    duration: float,
    most: float,
    limit: float | None = None,
    every: int | None = None,
) -> float:
    """Most mean power that anything inside the float with an angular momentum of at most `most` can take from it.

    Parameters
    ----------
    plant : Plant
        The device.
    waves : WaveRealisation
        The window.
    start : (n,) array
        State of the plant at its start. [rad], [rad/s]
    duration : float
        Of the window. [s]
    most : float
        Radius of the disc of H. [Nms]
    limit : float, optional
        Of |phi1| and |phi3| at every instant. [rad]
    every : int, optional
        Time step, in steps of the waves' grid; by default one and two, extrapolated to zero.

    Returns
    -------
    float
        [W]

    Raises
    ------
    InputError
        Where the window is longer than the waves.
    """
    import cvxpy as cp

    if every is None:  # the error is of second order
        fine, coarse = [momentum_cap(plant, waves, start, duration, most, limit, step) for step in (1, 2)]
        return float(fine + (fine - coarse) / 3.0)
    alone = float_alone(plant)
    h, steps = waves.dt * every, round(duration / (waves.dt * every))
    ends = waves.moments[:, : steps * every + 1 : every]
    middle = 0.5 * (ends[:, 1:] + ends[:, :-1])
    n, rows, angles = alone.A.shape[0], list(alone.rates), list(alone.angles)
    first = float_states(plant, start[None, :])[:, 0]
    stored = alone.energy + alone.filters
    size = 5.0 * np.sqrt(1.0 / np.diag(stored))  # unknowns of order one
    A, B = alone.A * size[None, :] / size[:, None], alone.B / size[:, None]
    x, H = cp.Variable((n, steps + 1)), cp.Variable((2, steps + 1))
    half = 0.5 * (x[:, 1:] + x[:, :-1])
    constraints = [
        x[:, 0] == first / size,
        x[:, 1:] - x[:, :-1] == h * (A @ half) + B @ (h * middle) - most * (B @ (H[:, 1:] - H[:, :-1])),
        H[:, 0] == momentum(plant, start[None, :])[:, 0] / most,
        cp.norm(H[:, 1:], axis=0) <= 1.0,
    ]
    if limit is not None:
        constraints.append(cp.abs(x[angles, 1:]) <= np.outer(limit / size[angles], np.ones(steps)))
    scaling = np.outer(size, size)
    lost = h * cp.sum_squares(_root(alone.damping * scaling) @ half)
    end = 0.5 * cp.sum_squares(_root(stored * scaling) @ x[:, steps])
    given = h * cp.sum(cp.multiply(middle * size[rows][:, None], half[rows]))
    begin = 0.5 * float(first @ stored @ first)
    problem = cp.Problem(cp.Maximize((given - lost - end + begin) / duration), constraints)
    problem.solve(solver="CLARABEL")
    return float(problem.value)


def _root(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """R with R'R = matrix; what rounding has made negative counts as zero."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))).T)
