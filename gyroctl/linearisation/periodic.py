"""The periodic linear model about a locked orbit: A_k, B_k, C_k, D_k from sample to sample of a wave period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.flow import STEP
from gyroctl.linearisation.held import INPUTS, HeldFlow, samples_per_wave
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI, PSI_RATE

if TYPE_CHECKING:
    from gyroctl.linearisation.averaged import AveragedModel
    from gyroctl.linearisation.harmonic import HarmonicTransfer
    from gyroctl.linearisation.lifted import LiftedModel
    from gyroctl.linearisation.orbit import PeriodicOrbit

DEFAULT_OUTPUTS = ("psi", "psi_rate", "omega_rate", "phi1", "phi3", "power")
DERIVED = ("power", "slip", "u1", "u3")
"""Outputs that are no states: power [W], slip omega' - N psi' [rad/s], u1 and u3 [rad/s]."""


@dataclass(frozen=True)
class PeriodicModel:
    """Deviations from a locked orbit, x_{k+1} = A_k x_k + B_k u_k, y_k = C_k x_k + D_k u_k, k counted modulo N.

    The controls and additions to the wave moments are held over a sample; outputs are those at its start.

    Parameters
    ----------
    A : (N, n, n) array
        Exact sampled-data transition matrices.
    B : (N, n, 4) array
        Of held deviations of cc, cg [Nms] and Me1, Me3 [Nm].
    C : (N, p, n) array
        Output matrices.
    D : (N, p, 4) array
        Direct parts: the power feels cg at once.
    states, inputs, outputs : tuple of str
        Names; states are the plant's without omega, which is cyclic.
    asked : float
        Control period that was asked for. [s]
    orbit : (N + 1, rows) array
        States on the orbit at the samples, the last one a period after the first.
    controls : (2,) array
        cc, cg on the orbit. [Nms]
    flow : HeldFlow
        The nonlinear map from sample to sample which this linearises.
    """

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    asked: float
    orbit: NDArray[np.float64] = field(repr=False)
    controls: NDArray[np.float64] = field(repr=False)
    flow: HeldFlow = field(repr=False)

    @property
    def samples(self) -> int:
        """Samples per wave period."""
        return int(self.A.shape[0])

    @property
    def period(self) -> float:
        """Sampling period that is used: the wave period over a whole number of samples. [s]"""
        return self.flow.period

    @property
    def wave_period(self) -> float:
        """Wave period. [s]"""
        return self.flow.forcing.period

    @property
    def note(self) -> str:
        """What was done about a control period that does not divide the wave period."""
        return (
            f"{self.samples} samples of {self.period:.6g} s per wave period of {self.wave_period:.6g} s; "
            f"a control period of {self.asked:g} s was asked for ({100.0 * (self.period / self.asked - 1.0):+.3f} %)"
        )

    @cached_property
    def monodromy(self) -> NDArray[np.float64]:
        """Transition matrix over one wave period from sample 0."""
        return transition(self.A)

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers over one wave period, largest first."""
        values = np.linalg.eigvals(self.monodromy).astype(complex)
        return values[np.argsort(-np.abs(values))]

    def select(self, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None) -> PeriodicModel:
        """Return the model with fewer inputs and outputs, by name.

        Raises
        ------
        InputError
            For a name that the model does not have.
        """
        i = _places("inputs", self.inputs, inputs)
        o = _places("outputs", self.outputs, outputs)
        return PeriodicModel(
            self.A, self.B[:, :, i], self.C[:, o], self.D[:, o][:, :, i], self.states,
            tuple(self.inputs[j] for j in i), tuple(self.outputs[j] for j in o), self.asked, self.orbit, self.controls,
            self.flow,
        )  # fmt: skip

    def continuous(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A(t) (N, n, n) and B(t) (N, n, 4) of the continuous-time model x' = A(t) x + B(t) u at the samples."""
        flow, a, b = self.flow, [], []
        for k, x in enumerate(self.orbit[:-1]):
            moments = np.real(np.exp(2j * np.pi * k / self.samples) * flow.forcing.amplitude)
            full, entry = flow.plant.jacobians(x, tuple(self.controls), moments)
            a.append((full @ flow.embedding)[flow.free])
            b.append(entry[flow.free])
        return np.array(a), np.array(b)

    def lifted(self) -> LiftedModel:
        """Time-invariant model over one wave period: inputs and outputs of all its samples stacked."""
        from gyroctl.linearisation.lifted import lift

        return lift(self)

    def averaged(self) -> AveragedModel:
        """Low-order model of the slow modes: libration and horizontal mode, with its range of validity."""
        from gyroctl.linearisation.averaged import average

        return average(self)

    def harmonic(self) -> HarmonicTransfer:
        """Harmonic transfer function: what a harmonic of an input does to each harmonic of an output."""
        from gyroctl.linearisation.harmonic import HarmonicTransfer

        return HarmonicTransfer(self)

    def to_mat(self, path: str | Path) -> None:
        """Write matrices, names and orbit to a MATLAB file; the sample is the last index there."""
        from scipy.io import savemat

        content = {name: np.moveaxis(getattr(self, name), 0, -1) for name in "ABCD"}
        savemat(path, {**content, **names_for_matlab(self), "period": self.period, "wave_period": self.wave_period,
                       "orbit": self.orbit, "controls": self.controls, "note": self.note})  # fmt: skip


def linearise(
    orbit: PeriodicOrbit, outputs: Sequence[str] = DEFAULT_OUTPUTS, period: float = 0.1, dt: float = 0.01
) -> PeriodicModel:
    """Linearise the plant about a locked orbit, exactly, by complex step through the kernel.

    Parameters
    ----------
    orbit : PeriodicOrbit
        A locked orbit, stable or not.
    outputs : sequence of str
        Names of states, or of `DERIVED`.
    period : float
        Control period; the nearest one that divides the wave period is used, see `PeriodicModel.note`. [s]
    dt : float
        Longest Runge-Kutta step. [s]

    Returns
    -------
    PeriodicModel

    Raises
    ------
    InputError
        Where there is no orbit, for an unknown output, or for a period that is not positive or longer than the wave's.
    """
    if orbit.status == "no orbit":
        raise InputError("orbit", orbit.status, "there is nothing to linearise about", orbit.advice)
    if not (np.isfinite(period) and 0.0 < period <= orbit.period):
        raise InputError("period", period, "must be positive and at most the wave period", "Give it in s, e.g. 0.1")
    known = (*orbit.plant.labels, *DERIVED)
    for name in outputs:
        if name not in known:
            raise InputError("outputs", name, "unknown output", f"Choose from {', '.join(known)}")
    flow = HeldFlow(orbit.plant, orbit.forcing, samples_per_wave(orbit.period, period), orbit.cc, dt)
    states = flow.close(orbit.x, orbit.cc, orbit.cg, orbit.sense)
    maps = [flow.jacobian(x, orbit.cc, orbit.cg, k) for k, x in enumerate(states[:-1])]
    measured = [_measure(flow, x, (orbit.cc, orbit.cg), outputs) for x in states[:-1]]
    return PeriodicModel(
        np.array([a for a, _ in maps]), np.array([b for _, b in maps]),
        np.array([c for c, _ in measured]), np.array([d for _, d in measured]),
        tuple(orbit.plant.labels[row] for row in flow.free), INPUTS, tuple(outputs), period, states,
        np.array([orbit.cc, orbit.cg]), flow,
    )  # fmt: skip


def output(plant: Plant, name: str, x: NDArray[Any], u: Sequence[Any]) -> Any:
    """Value of an output by name at state `x` (rows, ...) and controls `u`; real or complex."""
    if name in plant.labels:
        return x[plant.labels.index(name)]
    if name == "power":
        return u[1] * x[OMEGA_RATE] ** 2
    if name == "slip":
        return x[OMEGA_RATE] - plant.parameters.N * x[PSI_RATE]
    c, s = np.cos(x[PSI]), np.sin(x[PSI])
    if name == "u1":
        return c * x[PHI1_RATE] - s * x[PHI3_RATE]
    return s * x[PHI1_RATE] + c * x[PHI3_RATE]


def transition(matrices: NDArray[Any]) -> NDArray[Any]:
    """Product A_{N-1} ... A_0 of `matrices` (N, n, n)."""
    product: NDArray[Any] = np.eye(matrices.shape[1], dtype=matrices.dtype)
    for matrix in matrices:
        product = matrix @ product
    return product


def names_for_matlab(model: Any) -> dict[str, Any]:
    """Names of states, inputs and outputs as cell arrays."""
    kinds = ("states", "inputs", "outputs")
    return {kind: np.array(getattr(model, kind), dtype=object)[:, None] for kind in kinds}


def _measure(
    flow: HeldFlow, x: NDArray[np.float64], u: tuple[float, float], outputs: Sequence[str]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """C (p, free) and D (p, 4) at one sample."""
    c, d = np.zeros((len(outputs), flow.free.size)), np.zeros((len(outputs), len(INPUTS)))
    points = x[:, None] + 1j * STEP * flow.embedding
    for i, name in enumerate(outputs):
        c[i] = np.imag(output(flow.plant, name, points, u)) / STEP
        for j in range(2):
            moved = [complex(value) for value in u]
            moved[j] += 1j * STEP
            d[i, j] = np.imag(output(flow.plant, name, x.astype(complex), moved)) / STEP
    return c, d


def _places(field_name: str, known: tuple[str, ...], wanted: Sequence[str] | None) -> list[int]:
    for name in wanted or ():
        if name not in known:
            raise InputError(field_name, name, "the model does not have it", f"Choose from {', '.join(known)}")
    return [known.index(name) for name in (known if wanted is None else wanted)]
