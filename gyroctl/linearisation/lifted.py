"""The lifted model: a periodic model seen once per wave period is time-invariant."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.faces.locks import model_face
from gyroctl.faces.show import shown
from gyroctl.linearisation.exchange import control_system, save_matlab
from gyroctl.linearisation.periodic import PeriodicMatrices
from gyroctl.orbits.sensitivity import state_units
from gyroctl.plant.equations import PSI


@shown(model_face)
@dataclass(frozen=True)
class LiftedModel:
    """Time-invariant model over one wave period; input i of sample k is column k m + i, outputs likewise.

    Parameters
    ----------
    A : (n, n) array
        Monodromy matrix: its eigenvalues are the Floquet multipliers.
    B : (n, N m) array
        Of the inputs of all samples.
    C : (N p, n) array
        To the outputs of all samples.
    D : (N p, N m) array
        Lower block triangular: later samples do not act on earlier ones.
    states, inputs, outputs : tuple of str
        Names; ``cg[3]`` is cg in sample 3.
    period : float
        Wave period, the sampling period of this model. [s]
    """

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    states: tuple[str, ...] = field(repr=False)
    inputs: tuple[str, ...] = field(repr=False)
    outputs: tuple[str, ...] = field(repr=False)
    period: float

    def to_control(self) -> Any:
        """Return a `control.StateSpace` with named signals."""
        return control_system(self, "lifted", self.period)

    def to_scipy(self) -> Any:
        """Return a `scipy.signal.dlti` of the same matrices."""
        from scipy.signal import dlti

        return dlti(self.A, self.B, self.C, self.D, dt=self.period)

    def to_mat(self, path: str | Path) -> None:
        """Write matrices and names to a MATLAB file."""
        save_matlab(path, self, period=self.period)


def lift(model: PeriodicMatrices) -> LiftedModel:
    """Lift a periodic model over one wave period, from sample 0."""
    inputs = tuple(f"{name}[{k}]" for k in range(model.samples) for name in model.inputs)
    outputs = tuple(f"{name}[{k}]" for k in range(model.samples) for name in model.outputs)
    lifted = lift_matrices(model.A, model.B, model.C, model.D)
    return LiftedModel(*lifted, model.states, inputs, outputs, model.wave_period)


def lift_matrices(
    A: NDArray[Any], B: NDArray[Any], C: NDArray[Any], D: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Stack matrices (N, n, n), (N, n, m), (N, p, n), (N, p, m) over a period into those of the lifted model."""
    samples, n, m = B.shape
    p = C.shape[1]
    state, entry = np.eye(n, dtype=A.dtype), np.zeros((n, samples * m), A.dtype)
    out, direct = np.zeros((samples * p, n), A.dtype), np.zeros((samples * p, samples * m), A.dtype)
    for k in range(samples):
        rows, columns = slice(k * p, (k + 1) * p), slice(k * m, (k + 1) * m)
        out[rows], direct[rows] = C[k] @ state, C[k] @ entry
        direct[rows, columns] += D[k]
        state, entry = A[k] @ state, A[k] @ entry
        entry[:, columns] += B[k]
    return state, entry, out, direct


def nonlinear_error(
    model: PeriodicMatrices, sizes: NDArray[np.float64], seed: int = 0, periods: int = 3
) -> NDArray[np.float64]:
    """Relative error of the model against the nonlinear plant, for each size of a random perturbation.

    Start and all held inputs cc, cg are perturbed, by `size` times the typical magnitude of each on the orbit; the
    error is that of the state over `periods` wave periods relative to the deviation itself, both as root mean squares
    in those magnitudes. For a correct linearisation it falls in proportion to `size`.
    """
    flow, n = model.flow, len(model.states)
    units = state_units(flow.plant)
    least = 1e-3 * np.max(np.abs(model.orbit[0] / units)) * units[flow.free]
    scale = np.maximum(np.std(model.orbit[:-1], axis=0)[flow.free], least)
    scale[list(model.states).index("psi")] = 1.0
    rng = np.random.default_rng(seed)
    start = rng.standard_normal(n) * scale
    held = rng.standard_normal((periods * model.samples, 2)) * model.controls
    turn, errors = model.orbit[-1, PSI] - model.orbit[0, PSI], []
    for size in sizes:
        x, linear = model.orbit[0] + flow.embedding @ (size * start), size * start
        wrong, all_of_it = 0.0, 0.0
        for i in range(periods * model.samples):
            k = i % model.samples
            u = model.controls + size * held[i]
            x = flow.advance(x, u[0], u[1], k)
            linear = model.A[k] @ linear + model.B[k][:, :2] @ (size * held[i])
            there = model.orbit[k + 1].copy()
            there[PSI] += i // model.samples * turn
            deviation = (x - there)[flow.free]
            wrong += float(np.sum(((deviation - linear) / scale) ** 2))
            all_of_it += float(np.sum((deviation / scale) ** 2))
        errors.append(np.sqrt(wrong / all_of_it))
    return np.array(errors)
