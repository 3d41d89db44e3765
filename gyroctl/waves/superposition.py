"""Sums of harmonic waves on a time grid: ``Re sum_k c_k exp(i omega_k t)``, one way for each kind of frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Superposition(Protocol):
    """Sum of waves of fixed frequencies at fixed instants."""

    def __call__(self, coefficients: NDArray[np.complex128], out: NDArray[np.float64]) -> None:
        """Write the sums.

        Parameters
        ----------
        coefficients : ndarray, shape (rows, k)
            Complex amplitudes, time sign exp(+i omega t), one row per signal.
        out : ndarray, shape (rows, n)
            Receives the signals.
        """


@dataclass(frozen=True)
class HarmonicSum:
    """Harmonics 1..k of one period, by inverse FFT; instants may run to one period inclusive.

    Parameters
    ----------
    steps : int
        Steps of the time grid in one period, more than 2 k.
    """

    steps: int

    def __call__(self, coefficients: NDArray[np.complex128], out: NDArray[np.float64]) -> None:
        """Write the sums into `out`; see `Superposition`.

        Room for two rows at a time stays in the cache, and scipy.fft takes them together: NumPy, whose bits are the
        same, takes half as long again.
        """
        from scipy.fft import irfft

        k, n = coefficients.shape[1], out.shape[1]
        half = np.zeros((2, k + 1), dtype=np.complex128)
        for first in range(0, coefficients.shape[0], 2):
            some = coefficients[first : first + 2]
            np.multiply(some, 0.5, out=half[: len(some), 1:])
            whole = irfft(half[: len(some)], self.steps, norm="forward")
            out[first : first + 2, : self.steps] = whole[:, :n]
            out[first : first + 2, self.steps :] = whole[:, : max(n - self.steps, 0)]


@dataclass(frozen=True, eq=False)
class LineSum:
    """A few waves of any frequency, summed directly.

    Parameters
    ----------
    omega : ndarray, shape (k,)
        Frequencies. [rad/s]
    time : ndarray, shape (n,)
        Instants. [s]
    """

    omega: NDArray[np.float64]
    time: NDArray[np.float64]

    def __call__(self, coefficients: NDArray[np.complex128], out: NDArray[np.float64]) -> None:
        """Write the sums into `out`; see `Superposition`."""
        out[:] = 0.0
        for omega, column in zip(self.omega, coefficients.T, strict=True):
            out += (column[:, None] * np.exp(1j * omega * self.time)).real


@dataclass(frozen=True)
class ChirpSum:
    """Harmonics 1..k of a period that is no multiple of the time step, by Bluestein's chirp transform.

    The angle of wave m at instant j is ``2 pi ratio m j``, and ``m j = (m^2 + j^2 - (j - m)^2) / 2`` turns the sum
    into a convolution with a chirp: exact at any time step, at the cost of three FFTs.

    Parameters
    ----------
    ratio : float
        Time step over period. [-]
    """

    ratio: float

    def __call__(self, coefficients: NDArray[np.complex128], out: NDArray[np.float64]) -> None:
        """Write the sums into `out`; see `Superposition`."""
        k, n = coefficients.shape[1], out.shape[1]
        size = 1 << (n + k).bit_length()
        weighted = coefficients * self._chirp(np.arange(1, k + 1))
        kernel = np.zeros(size, dtype=np.complex128)
        kernel[:n] = self._chirp(np.arange(n)).conj()
        kernel[-k:] = self._chirp(np.arange(k, 0, -1)).conj()
        padded = np.zeros((coefficients.shape[0], size), dtype=np.complex128)
        padded[:, 1 : k + 1] = weighted
        convolved = np.fft.ifft(np.fft.fft(padded) * np.fft.fft(kernel))[:, :n]
        out[:] = (convolved * self._chirp(np.arange(n))).real

    def _chirp(self, index: NDArray[np.int64]) -> NDArray[np.complex128]:
        # Whole turns are taken off before the exponential: the square reaches 1e9, its angle must keep its digits.
        half_turns = np.mod(self.ratio * np.square(index.astype(np.float64)), 2.0)
        return np.exp(1j * np.pi * half_turns)
