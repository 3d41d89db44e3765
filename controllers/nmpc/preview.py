"""What is known of the moments ahead, by level of information."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.compiled import entry_point


class Waves(Protocol):
    """A realisation as `gyroctl.waves.WaveRealisation`: moments (2, n) on an even grid from t = 0."""

    @property
    def moments(self) -> NDArray[np.float64]: ...  # noqa: D102

    @property
    def dt(self) -> float: ...  # noqa: D102

    @property
    def duration(self) -> float: ...  # noqa: D102


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


def preview(waves: Waves, h: float, horizon: float) -> Preview:
    """Sample a realisation on the grid of the prediction model.

    Raises
    ------
    InputError
        Where the realisation's grid is coarser than the model's step or does not fit it, or it is shorter than the
        horizon.
    """
    every = round(h / waves.dt)
    if every < 1 or not math.isclose(every * waves.dt, h, rel_tol=1e-9):
        raise InputError("run.waves_dt", waves.dt, f"does not divide the model's step of {h:g} s",
                         "Realise the waves on a grid of 0.05 s or a part of it")  # fmt: skip
    if waves.moments.shape[1] * waves.dt < horizon:
        raise InputError("nmpc.horizon", horizon, f"is longer than the waves that were told, {waves.duration:g} s",
                         "Give a shorter horizon or longer waves")  # fmt: skip
    return Preview(np.ascontiguousarray(waves.moments[:, ::every].T), h)


@entry_point
def between(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Moments (n, 2) at each control interval, to twice as many instants, flat (2 (2 n - 1),), by cubic interpolation.

    A straight line would be off by 3 % of the shortest waves' moments; four points are off by 0.2 %.
    """
    n = moments.shape[0]
    out = np.empty(2 * (2 * n - 1))
    for i in range(n):
        for j in range(2):
            out[4 * i + j] = moments[i, j]
            if i + 1 < n:
                middle = 0.5 * (moments[i, j] + moments[i + 1, j])
                if 0 < i < n - 2:
                    middle += 0.0625 * (moments[i, j] + moments[i + 1, j] - moments[i - 1, j] - moments[i + 2, j])
                out[4 * i + 2 + j] = middle
    return out
