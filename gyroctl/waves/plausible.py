"""Whether a record is one of waves: drift, an offset, and a sampling that cuts the waves are told or refused."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError

SLOW = 0.1
"""What is slower than this part of the frequency of the waves is drift. [-]"""

DRIFT_SAID, DRIFT_MAX = 0.005, 0.1
"""Variance of the drift over that of the waves from which on it is told, and refused: Hs would be wrong by 5 %. [-]"""

CUT_SAID, CUT_MAX = 0.01, 0.1
"""Part of the variance beyond the Nyquist frequency, if the tail goes on, from which on it is told, and refused. [-]"""

ALONE = 20.0
"""Distance of a sample from the middle of its neighbours over that of all but a hundredth that is no water. [-]"""

FEW = 3.0
"""Nyquist over peak frequency of the waves below which it is told: all of a narrow peak may be folded there. [-]"""

WAVES_LEAST = 8
"""Fewest periods in a record that make a wave of it."""


class Content(NamedTuple):
    """What a record consists of."""

    peak: float  # frequency with the most energy per octave, among what has at least `WAVES_LEAST` periods [rad/s]
    drift: float  # variance below `SLOW` times that, over the rest [-]
    cut: float  # variance beyond the Nyquist frequency over that of the waves, where the tail is as w^-5 [-]
    nyquist: float  # [rad/s]


def content_of(surface: NDArray[np.float64], step: float) -> Content:
    """Look at an elevation (n,) [m] about its mean, sampled every `step` [s]."""
    n = surface.size
    spacing = 2.0 * math.pi / (step * n)
    omega = spacing * np.arange(1, n // 2 + 1)
    # A window, so that the step from the end of a drifting record to its beginning is no wave of every frequency.
    tapered = np.abs(np.fft.rfft(surface * np.hanning(n)))[1:] ** 2
    count = max(1, n // 200)
    smooth = np.convolve(tapered, np.ones(count) / count, mode="same")
    first = min(WAVES_LEAST, omega.size // 4)
    peak = float(omega[first + int(np.argmax((omega * smooth)[first:]))])
    power = np.abs(np.fft.rfft(surface))[1:] ** 2
    slow = omega < SLOW * peak
    waves = float(power[~slow].sum())
    top = omega > 0.85 * omega[-1]
    # The densities there are doubled by what is folded back; a tail by the fifth power holds S(w) w / 4.
    tail = 0.5 * float(power[top].mean()) / spacing * omega[-1] / 4.0
    return Content(peak, float(power[slow].sum()) / waves, tail / waves, math.pi / step)


def check_content(surface: NDArray[np.float64], step: float) -> tuple[str, ...]:
    """Refuse a record that is no sound record of waves; tell what is notable about one.

    Raises
    ------
    InputError
        Field ``sea.eta``: mostly drift, or with a sample that stands out alone.
        Field ``sea.time``: sampled too rarely for its waves.
    """
    _check_spikes(surface, step)
    found = content_of(surface, step)
    said = []
    hs = 4.0 * float(np.std(surface))
    if found.cut > CUT_MAX:
        problem = (
            f"samples reach {found.nyquist:.3g} rad/s, and the waves go on: some {found.cut:.0%} of their energy is "
            "beyond and stands at false frequencies"
        )
        fine = math.pi / (4.0 * min(found.peak, 0.5 * found.nyquist))
        raise InputError("sea.time", step, problem, f"Give a record sampled every {fine:.2g} s or less")
    if found.cut > CUT_SAID or found.nyquist < FEW * found.peak:
        beyond = f"some {found.cut:.1%} of the energy lies beyond {found.nyquist:.3g} rad/s"
        said.append(f"sampled every {step:.4g} s: {beyond}")
    if found.drift > DRIFT_MAX:
        problem = f"the record drifts: {found.drift / (1.0 + found.drift):.0%} of its variance is slower than "
        problem += f"{SLOW * found.peak:.2g} rad/s, beside waves at {found.peak:.3g} rad/s"
        mend = 'Give detrend = "linear" or detrend = "high-pass" to take the drift off, or a record without it'
        raise InputError("sea.eta", round(hs, 4), problem, mend)
    if found.drift > DRIFT_SAID:
        slow = hs * math.sqrt(found.drift / (1.0 + found.drift)) / 4.0
        said.append(f"drift of {slow:.2g} m (standard deviation) below {SLOW * found.peak:.2g} rad/s is left in")
    return tuple(said)


def _check_spikes(surface: NDArray[np.float64], step: float) -> None:
    """Refuse a record in which a single sample is far from both neighbours, by a deviation of the record or more."""
    off = np.abs(surface[1:-1] - 0.5 * (surface[:-2] + surface[2:]))
    worst = int(np.argmax(off))
    if off[worst] > max(ALONE * float(np.quantile(off, 0.99)), float(np.std(surface))):
        problem = f"a single sample stands out, {step * (worst + 1):.4g} s after the first, as no water moves"
        mend = 'Leave its cell empty, and give gaps = "linear" and longest = the longest gap to fill [s]'
        raise InputError("sea.eta", round(float(surface[worst + 1]), 4), problem, mend)
