"""What a law with a limited preview sees of a realisation: the moments up to now and some seconds more.

Two objects, so that the limit holds: the law has the `Window`, in which nothing is written that it may not see yet, and
the loop has the `Shutter`, which knows the realisation and opens the window as time goes on.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyroctl.waves.realisation import WaveRealisation


@dataclass(frozen=True)
class Window:
    """A realisation as far as it may be seen; read `moments` anew at each sample.

    Parameters
    ----------
    moments : (2, n) array
        Wave moments on the grid of the realisation up to now and `preview` more, NaN beyond. [Nm]
    dt, duration : float
        Grid and length of the realisation. [s]
    preview : float
        How far ahead of now it is open. [s]
    deviation : (2,) array
        Standard deviation of the moments over the whole realisation, for the error of a probe. [Nm]
    seed : int
        For random numbers of the law's own; the waves cannot be drawn from it.
    """

    moments: NDArray[np.float64] = field(repr=False)
    dt: float
    duration: float
    preview: float
    deviation: NDArray[np.float64] = field(repr=False)
    seed: int


class Shutter:
    """Opens a window as time goes on.

    Parameters
    ----------
    waves : WaveRealisation
        The realisation as it acts.
    preview : float
        How far ahead the window opens. [s]
    """

    def __init__(self, waves: WaveRealisation, preview: float) -> None:
        self._all, self._dt, self._preview = waves.moments, waves.dt, preview
        self._seen = np.full(waves.moments.shape, np.nan)
        self._count = 0
        shown = self._seen.view()
        shown.flags.writeable = False
        seed = int(hashlib.sha256(f"window {waves.sha256}".encode()).hexdigest()[:8], 16)
        self.window = Window(shown, waves.dt, waves.duration, preview, np.std(waves.moments, axis=1), seed)
        self.open(0.0)

    def open(self, t: float) -> None:
        """Open the window up to `t` [s] and the preview; what has been seen stays."""
        count = min(math.floor((t + self._preview) / self._dt + 1e-6) + 1, self._all.shape[1])
        if count > self._count:
            self._seen[:, self._count : count] = self._all[:, self._count : count]
            self._count = count
