"""Every kind of sea as a set of waves with frequencies, amplitudes and, where they are given, phases."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.waves.directional import DirectionalSpectrum, SpreadSea
from gyroctl.waves.drifting import DriftingSea, FadedSum
from gyroctl.waves.grid import TimeGrid
from gyroctl.waves.record import ElevationRecord
from gyroctl.waves.regular import Bichromatic, Regular
from gyroctl.waves.spectrum import SeaState
from gyroctl.waves.superposition import ChirpSum, HarmonicSum, LineSum, Superposition
from gyroctl.waves.tabulated import TabulatedSpectrum
from gyroctl.waves.turning import TurningSea
from gyroctl.waves.two_peaks import TwoPeaks

Spectral = SeaState | TwoPeaks | TabulatedSpectrum | SpreadSea | DirectionalSpectrum
"""Stationary seas with a spectrum."""

Sea = Spectral | DriftingSea | TurningSea | Regular | Bichromatic | ElevationRecord
"""Any sea of this package."""

Transfer = Callable[[NDArray[np.float64], float], NDArray[np.complex128]]
"""From frequencies (k,) [rad/s] and a heading [deg] to signals per metre of wave (rows, k)."""


class Components(NamedTuple):
    """Waves whose sum is the elevation, ``eta(t) = Re sum_k a_k exp(i (omega_k t + phase_k))``."""

    omega: NDArray[np.float64]  # (k,) [rad/s]
    amplitude: NDArray[np.complex128]  # (k,), complex where the sea fixes its phases [m]
    random: int  # number of phases drawn from the seed: k, or 0 where the sea fixes them
    captured: float  # variance of the waves before any scaling over that of the sea [-]
    superpose: Superposition
    headings: tuple[float, ...] = ()  # of equal parts of the waves, in order; none where all have the sea's [deg]
    bearings: NDArray[np.float64] | None = None  # (k,) heading of each wave, where they differ [deg]

    def in_direction(self, transfer: Transfer, heading: float) -> NDArray[np.complex128]:
        """Transfer to some signals of all waves, (rows, k): each by its own heading, or all by `heading` [deg]."""
        if self.bearings is not None:
            return self._each(transfer, self.bearings)
        if not self.headings:
            return transfer(self.omega, heading)
        parts = np.split(self.omega, len(self.headings))
        return np.concatenate([transfer(*one) for one in zip(parts, self.headings, strict=True)], axis=1)

    def _each(self, transfer: Transfer, bearings: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Transfer of waves of many headings, all waves of one heading at once."""
        order = np.argsort(bearings, kind="stable")
        starts = np.flatnonzero(np.diff(bearings[order])) + 1
        groups = np.split(order, starts)
        parts = [transfer(self.omega[group], float(bearings[group[0]])) for group in groups]
        whole = np.empty((parts[0].shape[0], self.omega.size), dtype=np.complex128)
        for group, part in zip(groups, parts, strict=True):
            whole[:, group] = part
        return whole


def components(sea: Sea, grid: TimeGrid) -> Components:
    """Waves of `sea` for the instants of `grid`.

    Raises
    ------
    InputError
        Field ``sea``: no sea of this package. Field ``run.duration``: longer than an elevation record.
    """
    if isinstance(sea, Spectral):
        return _of_spectrum(sea, grid)
    if isinstance(sea, DriftingSea):
        return _of_stages(sea, grid)
    if isinstance(sea, TurningSea):
        return _of_headings(sea, grid)
    if isinstance(sea, Regular | Bichromatic):
        omega, amplitude = sea.lines
        drawn = omega.size if isinstance(sea, Bichromatic) else 0
        return Components(omega, amplitude.astype(np.complex128), drawn, 1.0, LineSum(omega, grid.time))
    if isinstance(sea, ElevationRecord):
        return _of_record(sea, grid)
    mend = f"Give one of {', '.join(kind.__name__ for kind in get_args(Sea))}"
    raise InputError("sea", sea, "is no sea", mend)


def _of_spectrum(sea: Spectral, grid: TimeGrid) -> Components:
    omega = grid.harmonics
    amplitude = np.sqrt(2.0 * sea.spectrum(omega) * (2.0 * np.pi / grid.period))
    variance, wanted = 0.5 * float(amplitude @ amplitude), sea.hs**2 / 16.0
    if variance == 0.0:
        mend = f"Give a spectrum with its energy between {omega[0]:.4g} and {grid.omega_max:.4g} rad/s"
        raise InputError("sea.wp", sea.wp, "no wave energy falls on the harmonics", mend)
    # The harmonics stop at 12.566 rad/s and the tail beyond is lost (0.5 % of the variance at gamma 1 and 3.14 rad/s),
    # so every amplitude is scaled: each realisation then has variance Hs^2/16 exactly, and seas of equal Hs compare.
    amplitude *= np.sqrt(wanted / variance)
    bearings = sea.headings_at(omega) if isinstance(sea, SpreadSea | DirectionalSpectrum) else None
    heights, total = amplitude.astype(np.complex128), HarmonicSum(grid.steps)
    return Components(omega, heights, omega.size, variance / wanted, total, bearings=bearings)


def _of_stages(sea: DriftingSea, grid: TimeGrid) -> Components:
    stages = [_of_spectrum(stage, grid) for stage in sea.stages]
    windows = sea.windows(grid.time)
    part = np.sqrt(np.mean(windows**2, axis=1))  # amplitudes over the whole run: their squares add up to its variance
    return Components(
        np.concatenate([stage.omega for stage in stages]),
        np.concatenate([stage.amplitude * share for stage, share in zip(stages, part, strict=True)]),
        sum(stage.random for stage in stages),
        float(part**2 @ [stage.captured for stage in stages]),
        FadedSum(stages[0].superpose, windows / np.where(part > 0.0, part, 1.0)[:, None]),
    )


def _of_headings(sea: TurningSea, grid: TimeGrid) -> Components:
    still, weights = _of_spectrum(sea.still, grid), sea.weights(grid.time)
    part = np.sqrt(np.mean(weights, axis=1))  # of the amplitude: their squares add up to 1, and so to its variance
    return Components(
        np.tile(still.omega, len(part)),
        np.concatenate([share * still.amplitude for share in part]),
        still.random,
        still.captured,
        FadedSum(still.superpose, weights / np.where(part > 0.0, part, 1.0)[:, None]),
        sea.headings,
    )


def _of_record(sea: ElevationRecord, grid: TimeGrid) -> Components:
    if grid.duration > sea.duration + 1e-6 * grid.dt:
        mend = f"Give a duration up to that of the record, {sea.duration:g} s, or a longer record"
        raise InputError("run.duration", grid.duration, "is longer than the elevation record", mend)
    period, amplitude = sea.harmonics(grid.omega_max)
    omega = 2.0 * np.pi / period * np.arange(1, amplitude.size + 1, dtype=np.float64)
    whole = sea.harmonics(np.pi / sea.step).coefficients
    captured = float(np.vdot(amplitude, amplitude).real / np.vdot(whole, whole).real)
    return Components(omega, amplitude, 0, captured, ChirpSum(grid.dt / period))
