"""The plant under a regular wave over one sample of held controls, and its exact derivative.

A wave period is cut into whole samples, so that what is linearised is periodic. The control period of the harness
(0.1 s) does not divide a wave period in general: the nearest whole number of samples is taken, and models say so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.orbits.choices import of_moment
from gyroctl.orbits.flow import PADDING, STEP, Forcing, Stretch, Vector, run, step_count
from gyroctl.orbits.symmetry import free_rows
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PSI, PSI_RATE

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
        return free_rows(self.plant)

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
        pace = self.plant.parameters.time_scale
        return step_count(self.plant.coefficients, self.cc_max, self.period, self.dt, pace)

    @cached_property
    def _waves(self) -> Vector:
        return self.forcing.grid(1.0)

    def advance(self, x: Vector, cc: float, cg: float, sample: int, begin: float = 0.0, end: float = 1.0) -> Vector:
        """State (rows,) at the fraction `end` of a sample from that at the fraction `begin`."""
        return np.asarray(self._hold(x, np.array([cc, cg]), self._waves, sample, begin, end))

    def jacobian(
        self, x: Vector, cc: float, cg: float, sample: int, begin: float = 0.0, end: float = 1.0
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
        at, u, waves = x.astype(complex), np.array([cc, cg], complex), self._waves.astype(complex)
        columns = [self._hold(at + 1j * STEP * row, u, waves, sample, begin, end) for row in self.embedding.T]
        columns += [self._hold(at, u + 1j * STEP * row, waves, sample, begin, end) for row in np.eye(2)]
        for i in range(2):
            raised = waves.copy()
            for row in of_moment(self.plant.channels, INPUTS[2 + i]):
                raised[row :: len(self.plant.channels)] += 1j * STEP
            columns.append(self._hold(at, u, raised, sample, begin, end))
        slope = np.stack(columns, axis=1).imag[self.free] / STEP
        return slope[:, : self.free.size], slope[:, self.free.size :]

    def by_amplitude(self, x: Vector, cc: float, cg: float, sample: int) -> NDArray[np.float64]:
        """Exact derivative (free, 2) of `advance` by the wave's relative amplitude, in phase and a quarter period away.

        The wave is Re((1 + a + i b) amplitude exp(i wp t)), every signal of it alike; the columns are those of a and b.
        """
        at, u, waves = x.astype(complex), np.array([cc, cg], complex), self._waves.astype(complex)
        turned = (self.forcing.amplitude, 1j * self.forcing.amplitude)
        changes = [replace(self.forcing, amplitude=amplitude).grid(1.0) for amplitude in turned]
        ends = [self._hold(at, u, waves + 1j * STEP * change, sample, 0.0, 1.0) for change in changes]
        return np.stack(ends, axis=1).imag[self.free] / STEP

    def close(self, x: Vector, cc: float, cg: float, sense: int) -> NDArray[np.float64]:
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
        self, x: NDArray[Any], u: NDArray[Any], waves: NDArray[Any], sample: int, begin: float, end: float
    ) -> NDArray[Any]:
        if end <= begin:
            return x
        steps = max(1, round(self.steps * (end - begin)))
        start = PADDING * self.forcing.dt + (sample % self.samples + begin) * self.period
        stretch = Stretch(start, (end - begin) * self.period, steps, waves, self.forcing.dt)
        return run(self.plant.coefficients, x, u[0], u[1], stretch)[: x.size]


def samples_per_wave(wave_period: float, period: float) -> int:
    """Whole number of samples in a wave period nearest to the wanted sampling period [s]."""
    return max(1, round(wave_period / period))
