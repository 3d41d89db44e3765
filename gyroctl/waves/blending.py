"""The smooth passage from a regular wave, on whose locked orbit a run starts, to the sea."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.waves.checks import finite


def check_blend(blend: float, duration: float) -> float:
    """Return the length of a blend that fits into a run [s].

    Parameters
    ----------
    blend : float
        Length of the blend. [s]
    duration : float
        Length of the run. [s]

    Returns
    -------
    float
        The blend. [s]

    Raises
    ------
    InputError
        Field ``run.blend``: negative. Field ``run.duration``: shorter than the blend.
    """
    mend = "Give the length of the blend in seconds, 0 for none, for example 100"
    length = finite("run.blend", blend, mend)
    if length < 0.0:
        raise InputError("run.blend", blend, "must not be negative", mend)
    if duration < length:
        mend = f"Give a duration of at least {length:g} s, or a shorter run.blend"
        raise InputError("run.duration", duration, f"is shorter than the blend of {length:g} s", mend)
    return length


def blend_signals(
    signals: NDArray[np.float64], regular: NDArray[np.complex128], wp: float, dt: float, blend: float
) -> None:
    """Blend signals of a sea from those of a regular wave, in place.

    Over ``0 <= t < blend`` the sea is weighted by ``(1 - cos(pi t / blend)) / 2`` and the regular wave by the rest;
    both weights act on amplitudes. Later samples are not touched.

    Parameters
    ----------
    signals : ndarray, shape (..., rows, n)
        Signals of one realisation or of a batch, overwritten. [Nm], or of the signal
    regular : ndarray, shape (rows,), complex
        Regular wave of each row, ``Re(regular exp(i wp t))``. [Nm], or of the signal
    wp : float
        Frequency of the regular wave. [rad/s]
    dt : float
        Time step. [s]
    blend : float
        Length of the blend. [s]
    """
    if blend == 0.0:
        return
    time = dt * np.arange(min(signals.shape[-1], int(np.ceil(blend / dt))))
    weight = 0.5 * (1.0 - np.cos(np.pi * time / blend))
    wave = (regular[:, None] * np.exp(1j * wp * time)).real
    start = signals[..., : time.size]
    start *= weight
    start += (1.0 - weight) * wave
