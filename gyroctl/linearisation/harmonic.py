"""The harmonic transfer function: what each harmonic of an input does to each harmonic of an output.

An input exp(i w t) times a harmonic exp(i m wp t) leaves a periodic system at all w + l wp. With N held samples per
wave period there are exactly N harmonics, and the matrix is found without truncation from the lifted model (N. M.
Wereley and S. R. Hall, Proc. 29th IEEE Conference on Decision and Control, 1990, in discrete time).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.faces.locks import harmonic_face
from gyroctl.faces.show import shown
from gyroctl.linearisation.lifted import lift_matrices
from gyroctl.linearisation.periodic import PeriodicMatrices


@shown(harmonic_face)
@dataclass(frozen=True)
class HarmonicTransfer:
    """Harmonic transfer function of a periodic model.

    Parameters
    ----------
    model : PeriodicMatrices
        The model.
    """

    model: PeriodicMatrices

    @property
    def harmonics(self) -> NDArray[np.int64]:
        """Harmonic numbers in the order of the blocks: 0 in the middle."""
        count = self.model.samples
        return np.arange(count) - (count - 1) // 2

    def __call__(self, omega: float, keep: int | None = None) -> NDArray[np.complex128]:
        """Matrix (2 keep + 1, p, 2 keep + 1, m) at frequency `omega` [rad/s].

        Entry [l, i, j, k] is the amplitude of output i at omega + l wp per amplitude of input k at omega + j wp, both
        counted from -keep; all N harmonics without `keep`. Amplitudes are those of the samples.
        """
        model, count = self.model, self.model.samples
        p, m = len(model.outputs), len(model.inputs)
        a, b, c, d = self._lifted
        z = np.exp(1j * omega * model.wave_period)
        response = (c @ np.linalg.solve(z * np.eye(a.shape[0]) - a, b) + d).reshape(count, p, count, m)
        rates = (omega + self.harmonics * 2.0 * np.pi / model.wave_period) * model.period
        waves = np.exp(1j * np.outer(np.arange(count), rates))  # sample, harmonic
        full = np.einsum("sl,siuk,uj->lijk", waves.conj(), response, waves, optimize=True) / count
        if keep is None:
            return np.asarray(full)
        chosen = np.flatnonzero(np.abs(self.harmonics) <= keep)
        return np.asarray(full[np.ix_(chosen, np.arange(p), chosen, np.arange(m))])

    def baseband(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Response (len(omega), p, m) at the input's own frequency: what a slow observer sees."""
        return np.array([self(float(w), keep=0)[0, :, 0, :] for w in omega])

    @cached_property
    def _lifted(self) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
        return lift_matrices(self.model.A, self.model.B, self.model.C, self.model.D)
