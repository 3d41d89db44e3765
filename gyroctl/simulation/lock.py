"""Lock: lost when the 10 s mean of the ring speed falls below half the peak frequency; cycle slips counted apart.

The instantaneous speed says nothing: a good law lets it swing by a quarter within the cycle without losing a turn. And
lock says little of the turns: a ring may lose every tenth of them and never stall. So a second verdict stands beside
it, in step, by the turns that were kept and the slips.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

WINDOW = 10.0
"""Length of the mean. [s]"""

THRESHOLD = 0.5
"""Part of the peak frequency below which lock is lost. [-]"""

KEPT = 0.98
"""Part of the reference's turns that a run in step keeps. [-]"""

KEPT_SIZE = 50_000
"""Longest moment whose phase is kept for the next run on it."""

SURE = 0.95
"""Level of the upper limit of the reference's cycle slips. [-]"""


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
    """Analytic signal of a moment (n,), band-passed to [wp/2, 3wp/2]: its angle is the phase of the waves. [Nm]

    Parameters
    ----------
    moment : array_like, (n,)
        Excitation moment at the samples. [Nm]
    dt : float
        Sampling period. [s]
    wp : float
        Peak frequency of the waves. [rad/s]

    Returns
    -------
    (n,) complex array
        [Nm]
    """
    from scipy.fft import irfft, rfft

    signal = np.asarray(moment, float)
    spectrum = rfft(signal)
    omega = 2.0 * np.pi * np.fft.rfftfreq(signal.size, dt)
    band = np.where((omega >= 0.5 * wp) & (omega <= 1.5 * wp), spectrum, 0.0)
    if signal.size % 2 == 0:
        band[-1] = 0.0  # at half the sampling rate a wave has no phase
    both = irfft(np.stack([band, -1j * band]), signal.size)  # what passes, and the same a quarter of a turn later
    return np.asarray(both[0] + 1j * both[1])


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
    return wave_phase(phasor, dt).slips(psi, sense)


class WavePhase(NamedTuple):
    """Phase of the waves at even instants: what the ring is counted against, the same for every run on these waves.

    Fields
    ------
    phasor : (n,) array
        `wave_phasor` at the instants. [Nm]
    dt : float
        Their spacing. [s]
    advance : float
        Mean advance of the phase from one to the next, weighted by the power. [rad]
    carrier, drift : (n,) array
        Phase of the waves' own mean frequency, and that of the 10 s mean of their envelope against it. [rad]
    """

    phasor: NDArray[np.complex128]
    dt: float
    advance: float
    carrier: NDArray[np.float64]
    drift: NDArray[np.float64]

    def slips(self, psi: ArrayLike, sense: int = 1) -> int:
        """Count the cycle slips of a ring angle (n,) [rad], see `cycle_slips`."""
        angle = sense * np.asarray(psi, float)
        finite = np.isfinite(angle) & np.isfinite(self.phasor)
        if not np.all(finite):
            end = int(np.argmin(finite))
            return wave_phase(self.phasor[:end], self.dt).slips(angle[:end])
        if angle.size <= 2 * round(0.5 * WINDOW / self.dt):
            return 0
        turns = (angle - self.carrier - self.drift) / (2.0 * np.pi)
        level, count = float(turns[0]), 0
        for turn in turns[:: max(round(0.5 / self.dt), 1)].tolist():
            jumps = int(abs(turn - level) + 0.25)
            if jumps:
                count += jumps
                level += jumps if turn > level else -jumps
        return count

    def turns(self, psi: ArrayLike, sense: int = 1) -> float:
        """Mean ring speed of an angle (n,) [rad] over the mean frequency of the waves, see `turns_kept`."""
        angle = np.asarray(psi, float)
        if angle.size < 2:
            return float("nan")
        with np.errstate(invalid="ignore", divide="ignore"):
            return float(sense * (angle[-1] - angle[0]) / np.float64(self.advance * (angle.size - 1)))


def wave_phase(phasor: ArrayLike, dt: float) -> WavePhase:
    """Phase of waves by their phasor (n,) [Nm] every `dt` [s]."""
    waves = np.asarray(phasor)
    half, centre = round(0.5 * WINDOW / dt), np.arange(waves.size)
    # the envelope on the waves' own mean frequency
    advance = _advance(waves)
    carrier = advance * np.arange(waves.size, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        total = np.concatenate([[0.0], np.cumsum(waves * np.exp(-1j * carrier))])
    envelope = total[np.minimum(centre + half + 1, waves.size)] - total[np.maximum(centre - half, 0)]
    return WavePhase(waves, dt, advance, carrier, np.asarray(np.unwrap(np.angle(envelope))))


def phase_of_moment(
    moment: NDArray[np.float64], moment_dt: float, wp: float, first: int, samples: int, dt: float
) -> WavePhase:
    """Phase of the waves at the instants ``first`` to ``samples - 1`` of a run sampled every `dt` [s].

    `moment` (m,) [Nm], every `moment_dt` [s], is Me3, and wp the peak angular frequency [rad/s]. Kept for the other
    runs on the same waves.
    """
    moment = np.ascontiguousarray(moment, np.float64)
    at = (moment_dt, wp, first, samples, dt)
    return _kept_phase(moment.tobytes(), *at) if moment.size <= KEPT_SIZE else _phase_at(moment, *at)


@lru_cache(maxsize=64)  # of some laws on a filling of the lanes
def _kept_phase(moment: bytes, *at: Any) -> WavePhase:
    return _phase_at(np.frombuffer(moment), *at)


def _phase_at(
    moment: NDArray[np.float64], moment_dt: float, wp: float, first: int, samples: int, dt: float
) -> WavePhase:
    instants = np.arange(first, samples) * dt
    phasor = wave_phasor(moment, moment_dt, wp)
    return wave_phase(np.interp(instants, np.arange(moment.size) * moment_dt, phasor), dt)


def turns_kept(psi: ArrayLike, phasor: ArrayLike, dt: float, sense: int = 1) -> float:
    """Mean ring speed over the mean frequency of the waves.

    Parameters
    ----------
    psi : array_like, (n,)
        Ring angle. [rad]
    phasor : array_like, (n,)
        Waves at the same instants, `wave_phasor`. [Nm]
    dt : float
        Spacing of the samples; it cancels, and stands here as in `cycle_slips`. [s]
    sense : {1, -1}
        Sense of rotation.

    Returns
    -------
    float
        Near 1 for a ring that turns once a wave; NaN where the run is not finite or has no two samples. The frequency
        of the waves is the mean weighted by their power, the carrier against which the cycle slips are counted.
    """
    return wave_phase(phasor, dt).turns(psi, sense)


def in_step(
    turns: ArrayLike,
    slips: ArrayLike,
    waves: ArrayLike,
    reference_turns: ArrayLike = (),
    reference_slips: ArrayLike = (),
    reference_locked: ArrayLike = (),
) -> NDArray[np.bool_]:
    """Tell which runs were in step with the waves, measured by the best constant pair.

    The frequency of an irregular sea is no sharp number, and in a lull the phase of the waves jumps by itself, so that
    even a ring that never slid keeps 0.97 to 1.01 of the turns and counts a slip now and then. Hence the measure is
    what the best constant pair, which hardly swings, does on the same waves.

    Parameters
    ----------
    turns : array_like, (..., n)
        `turns_kept` of the runs, the last axis over the realisations. [-]
    slips : array_like, (..., n)
        Their cycle slips. [1 per 1000 waves]
    waves : array_like, (..., n) or (n,)
        Number of waves over which they were counted. [-]
    reference_turns, reference_slips, reference_locked : array_like, (n,)
        The same of the best constant pair on the same realisations, and where it kept lock; empty where it did not run.

    Returns
    -------
    array of bool, (..., n)
        Whether a run kept at least 0.98 of the pair's turns on the same realisation, and slipped no oftener than the
        upper 95 % limit of a Poisson count whose observation is the pair's median over the runs in which it kept lock.
        Where the pair lost lock on a realisation, its median over the others stands in for its turns. Where it lost
        lock in all, or did not run, 0.98 of all turns is asked for, and the limit is that of no slip, 3.0. A run that
        is not finite is not in step.
    """
    kept, count = np.asarray(turns, float), np.asarray(slips, float) * np.asarray(waves, float) / 1000.0
    held = np.asarray(reference_locked, bool) & np.isfinite(np.asarray(reference_turns, float))
    needed: NDArray[np.float64] | float = KEPT
    usual = 0.0  # slips [1 per 1000 waves]
    if held.any():
        own = np.asarray(reference_turns, float)
        needed = KEPT * np.where(held, own, np.median(own[held]))
        usual = float(np.median(np.asarray(reference_slips, float)[held]))
    limit = poisson_limit(usual * np.asarray(waves, float) / 1000.0)
    with np.errstate(invalid="ignore"):
        return np.asarray((kept >= needed) & (count <= limit))


def poisson_limit(count: ArrayLike) -> NDArray[np.float64]:
    """Largest mean of a Poisson count that an observation of `count` does not exclude at 95 %, one-sided: 3.0 for 0."""
    from scipy.special import gammaincinv

    return np.asarray(gammaincinv(np.asarray(count, float) + 1.0, SURE))


def _advance(waves: NDArray[np.complex128]) -> float:
    """Mean advance of the phase of the waves from sample to sample, weighted by their power. [rad]"""
    return float(np.angle(np.sum(waves[1:] * np.conj(waves[:-1]))))


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
    V = np.abs(_pull(psi, phi1_rate, phi3_rate, dt, wp))
    return np.asarray(np.asarray(cg) / (capacity * np.maximum(V, 1e-9)))


def load_angle(psi: ArrayLike, phi1_rate: ArrayLike, phi3_rate: ArrayLike, dt: float, wp: float) -> NDArray[np.float64]:
    """Load angle in the course of time: that of the mean over one period of exp(i psi)(phi1' + i phi3').

    Parameters
    ----------
    psi, phi1_rate, phi3_rate, dt, wp
        As those of `load_share`.

    Returns
    -------
    array, (n,)
        From -pi to pi; on a locked orbit it is constant, see `gyroctl.orbits.PeriodicOrbit`. [rad]
    """
    return np.asarray(np.angle(_pull(psi, phi1_rate, phi3_rate, dt, wp)))


def _pull(psi: ArrayLike, phi1_rate: ArrayLike, phi3_rate: ArrayLike, dt: float, wp: float) -> NDArray[np.complex128]:
    """Mean of exp(i psi)(phi1' + i phi3') over the last period, (n,). [rad/s]"""
    turned = np.exp(1j * np.asarray(psi)) * (np.asarray(phi1_rate) + 1j * np.asarray(phi3_rate))
    span = max(round(2.0 * np.pi / wp / dt), 1)
    total = np.concatenate([[0.0], np.cumsum(turned)])
    ends = np.arange(1, turned.size + 1)
    begins = np.maximum(ends - span, 0)
    return np.asarray((total[ends] - total[begins]) / (ends - begins))
