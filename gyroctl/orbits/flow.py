"""The flow of the plant under a regular wave, with exact derivatives: a complex step, or the tangents that it takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.orbits.wave import RegularWave
from gyroctl.plant import Plant
from gyroctl.plant.columns import hold_each
from gyroctl.plant.equations import OMEGA_RATE, PSI_RATE, Coefficients, powers
from gyroctl.plant.kernel import hold_one, slip_rate, steps_for
from gyroctl.plant.tangents import hold_changes
from gyroctl.waves.channels import transfers

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAMPLES = 128
"""Samples of the regular wave per period: the interpolation error is then 4e-14 of the moment."""

PADDING = 8
STEP = 1e-30


@dataclass(frozen=True)
class Forcing:
    """Moments of a regular wave, Re(amplitude exp(i wp t)), on a grid for the kernel.

    Parameters
    ----------
    amplitude : (channels,) complex array
        Moments of the wave [Nm], and further signals that the plant asks for, see `Plant.channels`.
    wp : float
        Angular frequency. [rad/s]
    """

    amplitude: NDArray[np.complex128]
    wp: float

    @classmethod
    def of(cls, plant: Plant, wave: RegularWave) -> Forcing:
        """Return the moments that a wave exerts on a device.

        Raises
        ------
        InputError
            For a device whose spin axis may slip on its track, or whose wetted surface is followed.
        """
        if plant.slips:
            problem = "an axis that sticks and slips has no orbit that could be differentiated"
            mend = 'Give plant.smooth or plant.rolling, the same device with contact = "rolling"'
            raise InputError("plant.contact", "friction", problem, mend)
        beyond = plant.coefficients.beyond
        if beyond is not None and beyond.surface is not None:
            problem = "cannot be differentiated: its moments are held between evaluations"
            mend = 'Give plant.smooth, the same device with wetted = "reduced"'
            raise InputError("plant.wetted", "surface", problem, mend)
        he = transfers(plant, np.array([wave.wp]), wave.heading)[:, 0]
        return cls(0.5 * wave.height * he, wave.wp)

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


class Stretch(NamedTuple):
    """A stretch of time under a wave, as the kernel takes it."""

    start: float  # since the begin of the grid [s]
    hold: float  # length [s]
    steps: int
    waves: NDArray[Any]  # moments on the grid, flat [Nm]
    waves_dt: float  # spacing of the grid [s]


def run(k: Coefficients, x: NDArray[Any], cc: complex, cg: complex, stretch: Stretch) -> NDArray[Any]:
    """State and ledger after a stretch that begins at the state `x` (n,), with which the ledger begins too."""
    return hold_one(np.concatenate([x, np.zeros(powers(k), x.dtype)]), k, cc, cg, *stretch)


def changes(
    k: Coefficients, x: Vector, seeds: Matrix, cc: float, cg: float, stretch: Stretch
) -> tuple[Vector, NDArray[np.float64]]:
    """State (n,) after a stretch that begins at `x`, and its derivative (n, m) in the directions `seeds` (n, m).

    Both ways take a step of the same size and give the same bits; within the linear model all directions go at once.
    """
    if k.beyond is None:
        end, columns = hold_changes(x, STEP * seeds, k, cc, cg, *stretch)
        return end, columns / STEP
    n = x.size
    y = np.zeros((seeds.shape[1], n + powers(k)), complex)
    y[:, :n] = x + 1j * STEP * seeds.T
    hold_each(y, k, np.array([[cc], [cg]], complex), *stretch)
    return y[0, :n].real.copy(), np.ascontiguousarray(y[:, :n].T).imag / STEP


def step_count(k: Coefficients, cc: float, duration: float, dt: float, pace: float = 1.0) -> int:
    """Number of Runge-Kutta steps for `duration` [s], as the simulation would take, in a device's unit of time."""
    return int(steps_for(duration, dt, pace * float(slip_rate(k, cc))))


def flow(
    plant: Plant, x: NDArray[Any], cc: complex, cg: complex, forcing: Forcing, periods: float, dt: float | None = None
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
    dt : float, optional
        Longest step; 0.01 s at the size of Table 1. [s]

    Returns
    -------
    (n + 5,) array, or more
        State, then the energies of the ledger [J].
    """
    if x.dtype != complex:
        cc, cg = cc.real, cg.real
    return run(plant.coefficients, x, cc, cg, stretch_of(plant, cc.real, forcing, periods, dt))


def stretch_of(plant: Plant, cc: float, forcing: Forcing, periods: float, dt: float | None = None) -> Stretch:
    """The stretch of `flow`: `periods` wave periods from phase zero, in steps that the coupling `cc` [Nms] allows."""
    periods = float(periods)
    duration = periods * forcing.period
    halves = max(1, round(2.0 * periods)) if (2.0 * periods).is_integer() else 1  # same step in half and full map
    longest = plant.step if dt is None else dt
    steps = halves * step_count(plant.coefficients, cc, duration / halves, longest, plant.parameters.time_scale)
    # the grid begins before phase zero so that the interpolation is central everywhere
    return Stretch(PADDING * forcing.dt, duration, steps, forcing.grid(periods), forcing.dt)


def flow_jacobian(
    plant: Plant, x: Vector, cc: float, cg: float, forcing: Forcing, periods: float, dt: float | None = None
) -> tuple[Vector, Vector]:
    """End state (n,) of `flow` and its exact derivative (n, n) with respect to the start."""
    seeds = directions(x.size, plant.parameters.N if plant.parameters.connection == "rigid" else None)
    return changes(plant.coefficients, x, seeds, cc, cg, stretch_of(plant, cc, forcing, periods, dt))


def directions(n: int, gear: float | None) -> Matrix:
    """Return a direction (n,) for each state in turn, in columns; `gear` is N where the flywheel is geared."""
    seeds = np.eye(n)
    if gear is not None:
        seeds[OMEGA_RATE, PSI_RATE] = gear  # the flywheel turns along
    return seeds
