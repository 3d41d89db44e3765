"""The flow of the plant under a regular wave, with exact derivatives by complex step through the compiled kernel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PSI_RATE
from gyroctl.plant.kernel import hold_one, slip_rate, steps_for

SAMPLES = 128
"""Samples of the regular wave per period: the interpolation error is then 4e-14 of the moment."""

PADDING = 8
STEP = 1e-30


@dataclass(frozen=True)
class Forcing:
    """Moments of a regular wave, Re(amplitude exp(i wp t)), on a grid for the kernel.

    Parameters
    ----------
    amplitude : (2,) complex array
        Moments of the wave. [Nm]
    wp : float
        Angular frequency. [rad/s]
    """

    amplitude: NDArray[np.complex128]
    wp: float

    @property
    def period(self) -> float:
        """Wave period. [s]"""
        return 2.0 * np.pi / self.wp

    @property
    def dt(self) -> float:
        """Spacing of the grid. [s]"""
        return self.period / SAMPLES

    def grid(self, periods: float) -> NDArray[np.float64]:
        """Return moments from -8 grid steps to `periods` and 8 more, sample by sample, flat."""
        count = int(np.ceil(periods * SAMPLES)) + 1
        time = np.arange(-PADDING, count + PADDING) * self.dt
        return np.ascontiguousarray(np.real(np.exp(1j * self.wp * time)[:, None] * self.amplitude)).ravel()


def step_count(plant: Plant, cc: float, duration: float, dt: float) -> int:
    """Number of Runge-Kutta steps for `duration` [s], as the simulation would take."""
    return int(steps_for(duration, dt, slip_rate(plant.coefficients, float(np.real(cc)))))


def flow(
    plant: Plant, x: NDArray[Any], cc: complex, cg: complex, forcing: Forcing, periods: float, dt: float = 0.01
) -> NDArray[Any]:
    """State and ledger after `periods` wave periods from phase zero.

    Parameters
    ----------
    plant : Plant
        The device.
    x : (n,) array
        State at phase zero; complex for derivatives.
    cc, cg : complex
        Controls. [Nms]
    forcing : Forcing
        The wave.
    periods : float
        Length of the interval in wave periods.
    dt : float
        Longest step. [s]

    Returns
    -------
    (n + 5,) array
        State, then the five energies of the ledger [J].
    """
    periods = float(periods)
    duration = periods * forcing.period
    offset = PADDING * forcing.dt
    start = np.concatenate([x, np.zeros(len(LEDGER), x.dtype)])
    if start.dtype != complex:
        cc, cg = cc.real, cg.real
    else:
        cc, cg = complex(cc), complex(cg)
    # the grid begins before phase zero so that the interpolation is central everywhere
    halves = max(1, round(2.0 * periods)) if (2.0 * periods).is_integer() else 1  # same step in half and full map
    steps = halves * step_count(plant, cc.real, duration / halves, dt)
    return hold_one(start, plant.coefficients, cc, cg, offset, duration, steps, forcing.grid(periods), forcing.dt)


def flow_jacobian(
    plant: Plant, x: NDArray[np.float64], cc: float, cg: float, forcing: Forcing, periods: float, dt: float = 0.01
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """End state (n,) of `flow` and its exact derivative (n, n) with respect to the start."""
    n = x.size
    columns = []
    for start in complex_steps(x, plant.parameters.N if plant.parameters.connection == "rigid" else None):
        columns.append(flow(plant, start, cc, cg, forcing, periods, dt)[:n])
    stacked = np.stack(columns, axis=1)
    return stacked[:, 0].real.copy(), stacked.imag / STEP


def complex_steps(x: NDArray[np.float64], gear: float | None) -> list[NDArray[np.complex128]]:
    """Return a start (n,) with a complex step for each state in turn; `gear` is N where the flywheel is geared."""
    starts = []
    for i in range(x.size):
        start = x.astype(complex)
        start[i] += 1j * STEP
        if i == PSI_RATE and gear is not None:  # the flywheel turns along
            start[OMEGA_RATE] += 1j * STEP * gear
        starts.append(start)
    return starts
