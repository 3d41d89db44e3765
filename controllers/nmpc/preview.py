"""What is known of the moments ahead, by level of information."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError


class Waves(Protocol):
    """A realisation as `gyroctl.waves.WaveRealisation`: moments (2, n) on an even grid from t = 0."""

    @property
    def moments(self) -> NDArray[np.float64]: ...  # noqa: D102

    @property
    def dt(self) -> float: ...  # noqa: D102


class Preview(NamedTuple):
    """True moments on the grid of the prediction model, for a law that may see them."""

    moments: NDArray[np.float64]  # (n, 2) [Nm]
    h: float  # [s]

    def window(self, t: float, count: int) -> NDArray[np.float64]:
        """Moments at t, t + h, ..., count of them, flat (2 count,); beyond the end the last ones stay. [Nm]"""
        first = round(t / self.h)
        last = self.moments.shape[0] - 1
        if first + count <= last + 1:
            return self.moments[first : first + count].ravel()
        return self.moments[np.minimum(np.arange(first, first + count), last)].ravel()


def preview(waves: Waves, h: float) -> Preview:
    """Sample a realisation on the grid of the prediction model.

    Raises
    ------
    InputError
        Where the realisation's grid is coarser than the model's step or does not fit it.
    """
    every = round(h / waves.dt)
    if every < 1 or not math.isclose(every * waves.dt, h, rel_tol=1e-9):
        raise InputError("run.waves_dt", waves.dt, f"does not divide the model's step of {h:g} s",
                         "Realise the waves on a grid of 0.05 s or a part of it")  # fmt: skip
    return Preview(np.ascontiguousarray(waves.moments[:, ::every].T), h)


def between(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Moments (n, 2) at each control interval, to twice as many instants (2 n - 1, 2), by cubic interpolation.

    A straight line would be off by 3 % of the shortest waves' moments; four points are off by 0.2 %.
    """
    n = moments.shape[0]
    out = np.empty((2 * n - 1, 2))
    out[::2] = moments
    out[1::2] = 0.5 * (moments[1:] + moments[:-1])
    if n >= 4:
        out[3:-3:2] += 0.0625 * (moments[1:-2] + moments[2:-1] - moments[:-3] - moments[3:])
    return out
