"""Lock: lost when the 10 s mean of the ring speed falls below half the peak frequency; cycle slips counted apart.

The instantaneous speed says nothing: a good law lets it swing by a quarter within the cycle without losing a turn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

WINDOW = 10.0
"""Length of the mean. [s]"""

THRESHOLD = 0.5
"""Part of the peak frequency below which lock is lost. [-]"""


def loss_time(psi: ArrayLike, dt: float, wp: float, sense: int = 1) -> NDArray[np.float64]:
    """Time of the first stall.

    Parameters
    ----------
    psi : array_like, (n,) or (n, runs)
        Ring angle at even instants from t = 0. [rad]
    dt : float
        Their spacing; it divides 10 s. [s]
    wp : float
        Peak angular frequency of the sea. [rad/s]
    sense : {1, -1}
        Sense of rotation of the lock.

    Returns
    -------
    array, () or (runs,)
        End of the first 10 s whose mean ring speed is below wp/2 [s]; NaN where that never happens. A run that is
        not finite counts as lost from there. Locking again later does not undo the loss.
    """
    angle = np.asarray(psi, float)
    span = round(WINDOW / dt)
    with np.errstate(invalid="ignore"):
        mean = sense * (angle[span:] - angle[:-span]) / WINDOW
        slow = ~(mean >= THRESHOLD * wp)  # NaN counts as slow
    if slow.shape[0] == 0:
        return np.full(angle.shape[1:], np.nan)
    first = np.argmax(slow, axis=0)
    return np.asarray(np.where(np.any(slow, axis=0), (first + span) * dt, np.nan))


def wave_phasor(moment: ArrayLike, dt: float, wp: float) -> NDArray[np.complex128]:
    """Analytic signal of a moment (n,), band-passed to [wp/2, 3wp/2]: its angle is the phase of the waves. [Nm]"""
    signal = np.asarray(moment, float)
    spectrum = np.fft.fft(signal)
    omega = 2.0 * np.pi * np.fft.fftfreq(signal.size, dt)
    band = (omega >= 0.5 * wp) & (omega <= 1.5 * wp)
    return np.asarray(np.fft.ifft(np.where(band, 2.0 * spectrum, 0.0)))


def cycle_slips(psi: ArrayLike, phasor: ArrayLike, dt: float, sense: int = 1) -> int:
    """Count the turns that the ring lost or gained against the waves.

    Parameters
    ----------
    psi : array_like, (n,)
        Ring angle. [rad]
    phasor : array_like, (n,)
        Waves at the same instants, `wave_phasor`. [Nm]
    dt : float
        Spacing of the samples. [s]
    sense : {1, -1}
        Sense of rotation.

    Returns
    -------
    int
        Jumps by 2 pi of the ring angle against the phase of the waves. That phase is taken from the 10 s mean of the
        waves' envelope, so weighted by their height, since in a lull the phase of an irregular sea jumps by itself
        and pulls at nothing. The ring is not averaged: it slips within two or three waves, and a mean over the angle
        between both would close such a turn up. A jump is counted once the angle is three quarters of a turn off
        its level, so that swinging about a half turn does not count again and again.
    """
    angle, waves = sense * np.asarray(psi, float), np.asarray(phasor)
    finite = np.isfinite(angle) & np.isfinite(waves)
    if not np.all(finite):
        end = int(np.argmin(finite))
        angle, waves = angle[:end], waves[:end]
    half = round(0.5 * WINDOW / dt)
    if angle.size <= 2 * half:
        return 0
    # the envelope on the waves' own mean frequency, weighted by their power
    carrier = np.angle(np.sum(waves[1:] * np.conj(waves[:-1]))) * np.arange(angle.size)
    total = np.concatenate([[0.0], np.cumsum(waves * np.exp(-1j * carrier))])
    centre = np.arange(angle.size)
    envelope = total[np.minimum(centre + half + 1, angle.size)] - total[np.maximum(centre - half, 0)]
    turns = (angle - carrier - np.unwrap(np.angle(envelope))) / (2.0 * np.pi)
    level, count = turns[0], 0
    for turn in turns[:: max(round(0.5 / dt), 1)]:
        jumps = int(abs(turn - level) + 0.25)
        count += jumps
        level += jumps if turn > level else -jumps
    return count


def load_share(
    psi: ArrayLike, phi1_rate: ArrayLike, phi3_rate: ArrayLike, cg: ArrayLike, dt: float, wp: float, capacity: float
) -> NDArray[np.float64]:
    """Used share of the lock capacity, N cg/(J4 V).

    Parameters
    ----------
    psi, phi1_rate, phi3_rate, cg : array_like, (n,)
        Ring angle [rad], float rates [rad/s], generator gain [Nms].
    dt : float
        Spacing of the samples. [s]
    wp : float
        Angular frequency; V is a mean over one period. [rad/s]
    capacity : float
        J4/N. [kg m^2]

    Returns
    -------
    array, (n,)
        1 at pull-out of a steady lock; V is the modulus of the mean of exp(i psi)(phi1' + i phi3').
    """
    turned = np.exp(1j * np.asarray(psi)) * (np.asarray(phi1_rate) + 1j * np.asarray(phi3_rate))
    span = max(round(2.0 * np.pi / wp / dt), 1)
    total = np.concatenate([[0.0], np.cumsum(turned)])
    ends = np.arange(1, turned.size + 1)
    begins = np.maximum(ends - span, 0)
    V = np.abs(total[ends] - total[begins]) / (ends - begins)
    return np.asarray(np.asarray(cg) / (capacity * np.maximum(V, 1e-9)))
