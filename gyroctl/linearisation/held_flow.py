"""The plant under a regular wave over one sample of held controls, and its exact derivative.

A wave period is cut into whole samples, so that what is linearised is periodic. The control period of the harness
(0.1 s) does not divide a wave period in general: the nearest whole number of samples is taken, and models say so.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gyroctl.orbits.flow import PADDING, STEP, Forcing
from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, OMEGA, OMEGA_RATE, PSI, PSI_RATE
from gyroctl.plant.kernel import TAPS, hold_into, slip_rate, steps_for

INPUTS = ("cc", "cg", "Me1", "Me3")


@dataclass(frozen=True)
class HeldFlow:
    """Flow of the plant from sample to sample of a wave period.

    Parameters
    ----------
    plant : Plant
        The device.
    forcing : Forcing
        The regular wave.
    samples : int
        Samples per wave period.
    cc_max : float
        Largest coupling that occurs: it sets the number of steps, the same in every sample. [Nms]
    dt : float
        Longest Runge-Kutta step. [s]
    """

    plant: Plant
    forcing: Forcing
    samples: int
    cc_max: float
    dt: float = 0.01

    @property
    def period(self) -> float:
        """Sampling period. [s]"""
        return self.forcing.period / self.samples

    @cached_property
    def free(self) -> NDArray[np.int64]:
        """Rows of the state that are free: not omega, which is cyclic, nor its rate where it is geared to the ring."""
        tied = (OMEGA,) if self.plant.parameters.connection == "magnetic" else (OMEGA, OMEGA_RATE)
        return np.array([row for row in range(len(self.plant.labels)) if row not in tied])

    @cached_property
    def embedding(self) -> NDArray[np.float64]:
        """Matrix (rows, free) from deviations of the free rows to deviations of the state."""
        matrix = np.zeros((len(self.plant.labels), self.free.size))
        matrix[self.free, np.arange(self.free.size)] = 1.0
        if self.plant.parameters.connection == "rigid":
            matrix[OMEGA_RATE] = self.plant.parameters.N * matrix[PSI_RATE]
        return matrix

    @cached_property
    def steps(self) -> int:
        """Runge-Kutta steps per sample."""
        return int(steps_for(self.period, self.dt, slip_rate(self.plant.coefficients, self.cc_max)))

    @cached_property
    def _waves(self) -> NDArray[np.float64]:
        return self.forcing.grid(1.0)

    def advance(
        self, x: NDArray[np.float64], cc: float, cg: float, sample: int, begin: float = 0.0, end: float = 1.0
    ) -> NDArray[np.float64]:
        """State (rows,) at the fraction `end` of a sample from that at the fraction `begin`."""
        return np.asarray(self._hold(x, np.array([cc, cg]), self._waves, sample, begin, end))

    def jacobian(
        self, x: NDArray[np.float64], cc: float, cg: float, sample: int, begin: float = 0.0, end: float = 1.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Exact derivative of `advance` in the free rows.

        Returns
        -------
        A : (free, free) array
            With respect to the state at `begin`.
        B : (free, 4) array
            With respect to cc, cg and constant additions to Me1, Me3, held from `begin` to `end`.
        """
        if end <= begin:
            return np.eye(self.free.size), np.zeros((self.free.size, len(INPUTS)))
        u, waves = np.array([cc, cg], complex), self._waves.astype(complex)
        columns = []
        for direction in self.embedding.T:
            columns.append(self._hold(x + 1j * STEP * direction, u, waves, sample, begin, end))
        for i in range(2):
            moved = u.copy()
            moved[i] += 1j * STEP
            columns.append(self._hold(x.astype(complex), moved, waves, sample, begin, end))
        for i in range(2):
            raised = waves.copy()
            raised[i::2] += 1j * STEP
            columns.append(self._hold(x.astype(complex), u, raised, sample, begin, end))
        slope = np.stack(columns, axis=1).imag[self.free] / STEP
        return slope[:, : self.free.size], slope[:, self.free.size :]

    def close(self, x: NDArray[np.float64], cc: float, cg: float, sense: int) -> NDArray[np.float64]:
        """States (samples + 1, rows) of the periodic orbit with constant controls next to `x`, by Newton's method.

        An orbit that was found with other steps is off by the error of the steps; this removes it.
        """
        for _ in range(8):
            states, product = [x], np.eye(self.free.size)
            for k in range(self.samples):
                product = self.jacobian(states[-1], cc, cg, k)[0] @ product
                states.append(self.advance(states[-1], cc, cg, k))
            gap = states[-1] - x
            gap[PSI] -= sense * 2.0 * np.pi
            step = np.linalg.solve(np.eye(self.free.size) - product, gap[self.free])
            if np.max(np.abs(step)) < 1e-12:
                break
            x = x + self.embedding @ step
        return np.array(states)

    def _hold(
        self,
        x: NDArray[np.float64] | NDArray[np.complex128],
        u: NDArray[np.float64] | NDArray[np.complex128],
        waves: NDArray[np.float64] | NDArray[np.complex128],
        sample: int,
        begin: float,
        end: float,
    ) -> NDArray[np.float64] | NDArray[np.complex128]:
        if end <= begin:
            return x
        y = np.concatenate([x, np.zeros(len(LEDGER), x.dtype)])
        steps = max(1, round(self.steps * (end - begin)))
        start = PADDING * self.forcing.dt + (sample % self.samples + begin) * self.period
        work, moments = np.empty((5, y.size), y.dtype), np.empty(6, waves.dtype)
        hold_into(
            y,
            work,
            moments,
            np.empty(TAPS),
            self.plant.coefficients,
            u.astype(y.dtype)[:, None],
            start,
            (end - begin) * self.period,
            steps,
            waves,
            self.forcing.dt,
        )
        return y[: x.size]


def samples_per_wave(wave_period: float, period: float) -> int:
    """Whole number of samples in a wave period nearest to the wanted sampling period [s]."""
    return max(1, round(wave_period / period))
