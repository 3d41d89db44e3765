"""The matrices of a periodic model, from sample to sample of a wave period, and what its outputs are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.faces.locks import model_face
from gyroctl.faces.show import shown
from gyroctl.linearisation.held_flow import HeldFlow
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI, PSI_RATE

DEFAULT_OUTPUTS = ("psi", "psi_rate", "omega_rate", "phi1", "phi3", "power")
DERIVED = ("power", "slip", "u1", "u3")
"""Outputs that are no states: power [W], slip omega' - N psi' [rad/s], u1 and u3 [rad/s]."""


@shown(model_face)
@dataclass(frozen=True)
class PeriodicMatrices:
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
        return multipliers_of(self.monodromy)


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


def multipliers_of(matrix: NDArray[Any]) -> NDArray[np.complex128]:
    """Eigenvalues of a transition matrix over a period, largest first."""
    values = np.linalg.eigvals(matrix).astype(complex)
    return values[np.argsort(-np.abs(values))]
